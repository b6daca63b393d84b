//! Model on the host: assembled from a fit's parts, held in the binary form that the device uses.

use ballrace_core::dynamics::{Dynamics, TERM_WORDS, encode_term};
use ballrace_core::input_check::ScreenConfig;
use ballrace_core::library::Library;
use ballrace_core::model::{Input, Model, ModelError, Scaling};
use ballrace_core::monitor::MonitorConfig;
use ballrace_core::network::{Arithmetic, FixedError};
use ballrace_core::{Floats, Word};

use crate::model::sindy_nn::export::OwnedNetwork;
use crate::model::states::Scales;

/// A checked model in its binary form.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnedModel {
    bytes: Vec<u8>,
}

impl OwnedModel {
    /// Model from the binary form.
    ///
    /// # Errors
    /// [`ModelError`] of the bytes.
    pub fn from_bytes(bytes: Vec<u8>) -> Result<Self, ModelError> {
        Model::from_bytes(&bytes)?;
        Ok(Self { bytes })
    }

    /// Model from the device's JSON form.
    ///
    /// # Errors
    /// [`ModelError`] of the text.
    pub fn from_json(text: &str) -> Result<Self, ModelError> {
        let mut storage = vec![Word::default(); text.len()];
        Self::from_model(&Model::from_json(text, &mut storage)?)
    }

    /// Copy of a borrowed model.
    ///
    /// # Errors
    /// None for a checked model.
    pub fn from_model(model: &Model<'_>) -> Result<Self, ModelError> {
        let mut bytes = vec![0; model.byte_len()];
        model.to_bytes(&mut bytes)?;
        Ok(Self { bytes })
    }

    /// CRC-32 of the binary form before its last word, which holds it: over all of it every model has the same.
    pub fn checksum(&self) -> u32 {
        self.bytes.last_chunk().map_or(0, |word| u32::from_le_bytes(*word))
    }

    /// The same model with its networks in another arithmetic. The healthy level of its monitor stays that of before:
    /// `fit --arithmetic` finds it anew.
    ///
    /// # Errors
    /// [`FixedError`] of a network without a form in fixed point, or in fixed point already for single precision.
    pub fn with_arithmetic(&self, arithmetic: Arithmetic) -> Result<Self, FixedError> {
        let model = self.view();
        let encoder = OwnedNetwork::converted(&model.encoder, arithmetic)?;
        let decoder = OwnedNetwork::converted(&model.decoder, arithmetic)?;
        let model = Model { encoder: encoder.view(), decoder: decoder.view(), ..model };
        Ok(Self::from_model(&model).expect("the networks keep their shapes"))
    }

    /// The binary form.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The device's JSON form.
    ///
    /// # Errors
    /// None in practice: the buffer grows until the text fits.
    pub fn to_json(&self) -> Result<String, ModelError> {
        // A word takes at most 17 characters.
        let mut buffer = vec![0; 8 * self.bytes.len() + 4096];
        let length = self.view().to_json(&mut buffer)?;
        buffer.truncate(length);
        String::from_utf8(buffer).map_err(|_| ModelError::JsonBufferTooSmall)
    }

    /// Core's model over the bytes.
    pub fn view(&self) -> Model<'_> {
        Model::from_bytes(&self.bytes).expect("checked when it was made")
    }
}

/// Parts of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Source of the inputs x.
    pub input: Input,
    /// Scaling of states and derivatives.
    pub scales: Scales,
    /// Encoder φ.
    pub encoder: OwnedNetwork,
    /// Decoder ψ.
    pub decoder: OwnedNetwork,
    /// Library of candidate functions.
    pub library: Library,
    /// Ξ, terms × equations, row-major.
    pub xi: Vec<f32>,
    /// Healthy standard deviation of each derivative's residual, scaled units.
    pub residual_spread: Vec<f32>,
    /// Limits of the sensor.
    pub screen: ScreenConfig,
    /// Limits of the residual.
    pub monitor: MonitorConfig,
}

impl Parts {
    /// Assembles the model, Ξ without its zeros.
    ///
    /// # Errors
    /// [`ModelError`] of the first part that does not fit.
    pub fn assemble(&self) -> Result<OwnedModel, ModelError> {
        let words = |values: &mut dyn Iterator<Item = f32>| values.map(f32::to_le_bytes).collect::<Vec<Word>>();
        let arrays = [
            words(&mut self.scales.states.iter().map(|s| s.0)),
            words(&mut self.scales.states.iter().map(|s| s.1)),
            words(&mut self.scales.derivatives.iter().map(|s| s.0)),
            words(&mut self.scales.derivatives.iter().map(|s| s.1)),
            words(&mut self.residual_spread.iter().copied()),
        ];
        let [mean, scale, d_mean, d_scale, spread] = arrays.each_ref().map(|words| Floats(words));
        let sparse = Sparse::from_coefficients(self.library, &self.xi);
        let model = Model::new(Model {
            sample_rate_hz: self.sample_rate_hz as f32,
            input: self.input,
            states: Scaling { mean, scale },
            derivatives: Scaling { mean: d_mean, scale: d_scale },
            encoder: self.encoder.view(),
            decoder: self.decoder.view(),
            library: self.library,
            dynamics: sparse.view(),
            residual_spread: spread,
            screen: self.screen,
            monitor: self.monitor,
        })?;
        OwnedModel::from_model(&model)
    }
}

/// Owned storage of [`Dynamics`].
struct Sparse {
    terms: Vec<[Word; TERM_WORDS]>,
    ends: Vec<Word>,
    equations: Vec<Word>,
    coefficients: Vec<Word>,
}

impl Sparse {
    fn from_coefficients(library: Library, xi: &[f32]) -> Self {
        let count = usize::from(library.variables);
        let mut out = Self { terms: vec![], ends: vec![], equations: vec![], coefficients: vec![] };
        for (index, row) in xi.chunks_exact(count).enumerate() {
            let before = out.coefficients.len();
            for (equation, value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                out.equations.push((equation as u32).to_le_bytes());
                out.coefficients.push(value.to_le_bytes());
            }
            if let (true, Some(term)) = (out.coefficients.len() > before, library.term(index)) {
                out.terms.push(encode_term(term));
                out.ends.push((out.coefficients.len() as u32).to_le_bytes());
            }
        }
        out
    }

    fn view(&self) -> Dynamics<'_> {
        Dynamics {
            terms: &self.terms,
            ends: &self.ends,
            equations: &self.equations,
            coefficients: Floats(&self.coefficients),
        }
    }
}
