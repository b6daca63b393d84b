//! Model of host and device, borrowed from flash, a file or a buffer.
//!
//! Two written forms: [binary](Model::from_bytes) (used in place, CRC-32) and [JSON](Model::from_json)
//! (read into a caller's buffer). Every model has passed [`Model::new`]'s checks, which the evaluator relies on.

mod binary;
mod error;
mod json;

pub use crate::crc::crc32;
pub use binary::{FORMAT_VERSION, MAGIC};
pub use error::{Array, ModelError};

use crate::dynamics::{Dynamics, decode_term};
use crate::input_check::ScreenConfig;
use crate::library::Library;
use crate::monitor::MonitorConfig;
use crate::network::Network;
use crate::states::StateSpec;
use crate::{Floats, Word};

/// Greatest number of inputs of a model whose states are given directly.
pub const MAX_INPUTS: usize = crate::network::MAX_WIDTH;

/// Source of a model's input x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// Virtual states of one acceleration channel, streamed from samples.
    VirtualStates(StateSpec),
    /// Number of states that are given with each step.
    Direct(usize),
}

impl Input {
    /// Number of inputs, which is the number of derivatives as well.
    pub const fn len(&self) -> usize {
        match self {
            Input::VirtualStates(spec) => spec.dimension,
            Input::Direct(n) => *n,
        }
    }

    /// Whether there are no inputs.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Mean and scale of a standardisation, theory (6): (x − mean) / scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scaling<'a> {
    /// Means, in physical units.
    pub mean: Floats<'a>,
    /// Scales, in physical units; positive.
    pub scale: Floats<'a>,
}

/// A SINDy-NN model, theory (10) and (11): z = φ(x), ż = Θ(z) Ξ, ẋ = ∇ψ(z) ż.
#[derive(Clone, Debug, PartialEq)]
pub struct Model<'a> {
    /// Sample rate of the recordings fitted to, Hz.
    pub sample_rate_hz: f32,
    /// Source of the inputs x.
    pub input: Input,
    /// Scaling of the inputs x.
    pub states: Scaling<'a>,
    /// Scaling of the derivatives ẋ, which differs from that of the states.
    pub derivatives: Scaling<'a>,
    /// Encoder φ.
    pub encoder: Network<'a>,
    /// Decoder ψ.
    pub decoder: Network<'a>,
    /// Library of candidate functions.
    pub library: Library,
    /// Coefficients Ξ.
    pub dynamics: Dynamics<'a>,
    /// Healthy standard deviation of each derivative's residual, in scaled units.
    pub residual_spread: Floats<'a>,
    /// Limits of the sensor.
    pub screen: ScreenConfig,
    /// Limits of the residual.
    pub monitor: MonitorConfig,
}

impl<'a> Model<'a> {
    /// Checks that the parts fit together and every number is usable.
    ///
    /// # Errors
    /// [`ModelError`] of the first part that fails.
    pub fn new(model: Self) -> Result<Self, ModelError> {
        model.check()?;
        Ok(model)
    }

    /// Reads the binary form; the arrays stay in place.
    ///
    /// # Errors
    /// [`ModelError`] of the bytes or of the model in them.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, ModelError> {
        binary::read(bytes)
    }

    /// Writes the binary form; returns its length in bytes.
    ///
    /// # Errors
    /// [`ModelError::BufferTooSmall`] with the length needed.
    pub fn to_bytes(&self, buffer: &mut [u8]) -> Result<usize, ModelError> {
        binary::write(self, buffer)
    }

    /// Length of the binary form in bytes.
    pub fn byte_len(&self) -> usize {
        binary::byte_len(self)
    }

    /// Reads the JSON form; the arrays go to `storage`. As many words as `text` has bytes are always enough.
    ///
    /// # Errors
    /// [`ModelError`] of the text or of the model in it.
    pub fn from_json(text: &str, storage: &'a mut [Word]) -> Result<Self, ModelError> {
        json::read(text, storage)
    }

    /// Writes the JSON form; returns its length in bytes.
    ///
    /// # Errors
    /// [`ModelError::JsonBufferTooSmall`].
    pub fn to_json(&self, buffer: &mut [u8]) -> Result<usize, ModelError> {
        json::write(self, buffer)
    }

    /// Number of latent variables z.
    pub fn latent(&self) -> usize {
        usize::from(self.library.variables)
    }

    fn check(&self) -> Result<(), ModelError> {
        let inputs = self.input.len();
        match self.input {
            Input::VirtualStates(spec) => spec.check().map_err(ModelError::States)?,
            Input::Direct(n) if !(1..=MAX_INPUTS).contains(&n) => return Err(ModelError::Dimension { found: n }),
            Input::Direct(_) => {}
        }
        if !(self.sample_rate_hz.is_finite() && self.sample_rate_hz > 0.0) {
            return Err(ModelError::SampleRate { found: self.sample_rate_hz });
        }
        if !self.library.is_valid() {
            return Err(ModelError::Library { found: self.library });
        }
        for (network, name, from, to) in [
            (&self.encoder, Array::Encoder, inputs, self.latent()),
            (&self.decoder, Array::Decoder, self.latent(), inputs),
        ] {
            let found = match network.widths() {
                [] => (from, from),
                [first, .., last] => (usize::from(*first), usize::from(*last)),
                [only] => (usize::from(*only), 0),
            };
            if found != (from, to) {
                return Err(ModelError::NetworkShape { network: name, expected: (from, to), found });
            }
            if let Some(index) = network.first_not_finite() {
                return Err(ModelError::NotFinite { array: name, index });
            }
        }
        for (name, values) in [
            (Array::StateMean, self.states.mean),
            (Array::StateScale, self.states.scale),
            (Array::DerivativeMean, self.derivatives.mean),
            (Array::DerivativeScale, self.derivatives.scale),
            (Array::ResidualSpread, self.residual_spread),
        ] {
            if values.len() != inputs {
                return Err(ModelError::Length { array: name, expected: inputs, found: values.len() });
            }
            finite(name, values)?;
            let is_scale = !matches!(name, Array::StateMean | Array::DerivativeMean);
            if let Some(index) = values.iter().position(|v| is_scale && v <= 0.0) {
                return Err(ModelError::ScaleNotPositive { array: name, index });
            }
        }
        self.check_dynamics()?;
        let screen_valid = self.screen.full_scale.is_finite() && self.screen.full_scale >= 0.0;
        if screen_valid && self.monitor.is_valid() { Ok(()) } else { Err(ModelError::Monitor) }
    }

    fn check_dynamics(&self) -> Result<(), ModelError> {
        let Dynamics { terms, ends, equations, coefficients } = self.dynamics;
        for (array, expected, found) in
            [(Array::TermEnds, terms.len(), ends.len()), (Array::Equations, coefficients.len(), equations.len())]
        {
            if expected != found {
                return Err(ModelError::Length { array, expected, found });
            }
        }
        finite(Array::Coefficients, coefficients)?;
        if let Some(index) = terms.iter().position(|code| decode_term(code, &self.library).is_none()) {
            return Err(ModelError::Term { index });
        }
        let mut start = 0;
        for (index, end) in ends.iter().map(|e| u32::from_le_bytes(*e) as usize).enumerate() {
            if end < start || end > coefficients.len() {
                return Err(ModelError::TermRun { index });
            }
            start = end;
        }
        if start != coefficients.len() {
            return Err(ModelError::TermRun { index: ends.len() });
        }
        match equations.iter().position(|e| u32::from_le_bytes(*e) as usize >= self.latent()) {
            Some(index) => Err(ModelError::Equation { index }),
            None => Ok(()),
        }
    }
}

fn finite(array: Array, values: Floats<'_>) -> Result<(), ModelError> {
    match values.iter().position(|v| !v.is_finite()) {
        Some(index) => Err(ModelError::NotFinite { array, index }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
