//! Binary form of a model: little-endian 32-bit words, a header, the arrays, a CRC-32.
//!
//! | words | content |
//! |---|---|
//! | 0 | magic `BRMD` |
//! | 1 | format version |
//! | 2 | length of everything in words, the CRC included |
//! | 3…6 | inputs; n_MD orders (0 given directly, 1 even, 2 consecutive); alignment (0 forward, 1 half, 2 causal); sample rate, Hz (f32) |
//! | 7…9 | library: variables, degree, harmonics |
//! | 10…13 | used terms; coefficients; encoder layers; decoder layers |
//! | 14…15 | screen: full scale, m/s² (f32); stuck after |
//! | 16…25 | monitor: block; healthy centre, healthy spread, EWMA weight, limit, release (f32); calm blocks; false alarms a day, blocks a day (f32); healthy blocks |
//! | then | from version 2, estimator: 0 differences (version 3), 1 Savitzky–Golay, 2 Kalman; excess degree (0 but for Savitzky–Golay); stretch or cut-off (f32) |
//! | then | from version 3, whether the library has powers (0, 1) |
//! | then | from version 4, networks in fixed point: 1 the encoder, 2 the decoder, 3 both |
//! | then | encoder widths, decoder widths (layers + 1 words each, none for the identity) |
//! | then | f32: state mean, state scale, derivative mean, derivative scale, residual spread |
//! | then | encoder parameters, decoder parameters ([`crate::network`] has their layout): f32, or words of fixed point |
//! | then | term codes (3 words each), ends, equations, coefficients ([`crate::dynamics`]) |
//! | last | CRC-32 (IEEE 802.3) of all bytes before it |
//!
//! Every model is written as version 4, whose monitor judges the logarithm of the level and whose networks may be in fixed
//! point: no earlier version can hold either.
//! Versions 1 (finite differences), 2 (other estimators) and 3 (libraries with powers) are read. Their monitor words were
//! block; healthy mean, healthy spread of the level, EWMA weight, EWMA limit, CUSUM slack, CUSUM limit (f32); votes; of
//! blocks; release (f32). They become [`MonitorConfig::from_levels`] with their weight, limit, release, and `of blocks`
//! as the calm blocks; CUSUM and votes are read over, and no rate of false alarms is stated.

use super::{Array, Input, Model, ModelError, Scaling};
use crate::crc::crc32;
use crate::dynamics::{Dynamics, TERM_WORDS};
use crate::input_check::ScreenConfig;
use crate::library::Library;
use crate::monitor::MonitorConfig;
use crate::network::{Arithmetic, MAX_LAYERS, MAX_WIDTH, Network, word_count};
use crate::states::{Alignment, Estimator, Orders, StateSpec};
use crate::{Floats, Word};

/// First four bytes of the binary form.
pub const MAGIC: [u8; 4] = *b"BRMD";
/// Newest version of the binary form. This crate reads it and all before, and writes it, the oldest that holds the monitor.
pub const FORMAT_VERSION: u32 = 4;
/// Version of models of finite differences.
const DIFFERENCES_VERSION: u32 = 1;
/// Version of models of other estimators.
const ESTIMATORS_VERSION: u32 = 2;
/// Last version whose monitor judges the level itself, and whose networks are in single precision.
const LEVELS_VERSION: u32 = 3;
const HEADER_WORDS: usize = 26;
/// Words of what came after version 1: estimator, powers, arithmetic.
const NEWER_WORDS: usize = 5;
const DIFFERENCES: u32 = 0;
const SAVITZKY_GOLAY: u32 = 1;
const KALMAN: u32 = 2;
/// Greatest count in a header: above any model that fits, below any overflow of the sums over sizes.
const MAX_COUNT: usize = 1 << 24;

/// Sequential reader of words.
struct Reader<'a> {
    words: &'a [Word],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [Word], ModelError> {
        let taken = self.words.get(self.at..).and_then(|rest| rest.get(..count)).ok_or(ModelError::ArraySizes)?;
        self.at += count;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, ModelError> {
        match self.take(1)? {
            [word] => Ok(u32::from_le_bytes(*word)),
            _ => Err(ModelError::ArraySizes),
        }
    }

    fn float(&mut self) -> Result<f32, ModelError> {
        self.word().map(f32::from_bits)
    }

    /// A word that must be at most `limit`.
    fn count(&mut self, limit: usize) -> Result<usize, ModelError> {
        let index = self.at;
        let found = self.word()?;
        if found as usize <= limit { Ok(found as usize) } else { Err(ModelError::HeaderWord { index, found }) }
    }

    fn estimator(&mut self, version: u32) -> Result<Estimator, ModelError> {
        let index = self.at;
        let kind = self.word()?;
        let (excess, parameter) = (self.count(usize::from(u8::MAX))? as u8, self.float()?);
        match kind {
            DIFFERENCES if version > ESTIMATORS_VERSION => Ok(Estimator::Differences),
            SAVITZKY_GOLAY => Ok(Estimator::SavitzkyGolay { excess, stretch: parameter }),
            KALMAN => Ok(Estimator::Kalman { cutoff: parameter }),
            found => Err(ModelError::HeaderWord { index, found }),
        }
    }

    fn monitor(&mut self, version: u32) -> Result<MonitorConfig, ModelError> {
        let (block, centre, spread, ewma_weight) = (self.word()?, self.float()?, self.float()?, self.float()?);
        let limit = self.float()?;
        if version <= LEVELS_VERSION {
            // Slack and limit of the CUSUM, and votes.
            self.take(3)?;
            let (calm_blocks, release) = (self.word()?, self.float()?);
            let levels = MonitorConfig::from_levels(block, centre, spread);
            return Ok(MonitorConfig { ewma_weight, limit, release, calm_blocks, ..levels });
        }
        Ok(MonitorConfig {
            block,
            healthy_centre: centre,
            healthy_spread: spread,
            ewma_weight,
            limit,
            release: self.float()?,
            calm_blocks: self.word()?,
            false_alarms_per_day: self.float()?,
            blocks_per_day: self.float()?,
            healthy_blocks: self.word()?,
        })
    }

    fn floats(&mut self, count: usize) -> Result<Floats<'a>, ModelError> {
        self.take(count).map(Floats)
    }

    fn widths(&mut self, layers: usize) -> Result<heapless::Vec<u16, { MAX_LAYERS + 1 }>, ModelError> {
        let mut widths = heapless::Vec::new();
        let count = if layers == 0 { 0 } else { layers + 1 };
        for _ in 0..count {
            let width = self.count(MAX_WIDTH)? as u16;
            widths.push(width).map_err(|_| ModelError::ArraySizes)?;
        }
        Ok(widths)
    }
}

pub(super) fn read(bytes: &[u8]) -> Result<Model<'_>, ModelError> {
    let (words, _) = bytes.as_chunks::<4>();
    let mut r = Reader { words, at: 0 };
    if words.len() < HEADER_WORDS {
        return Err(ModelError::Truncated { needed: 4 * HEADER_WORDS, found: bytes.len() });
    }
    let magic = r.word()?.to_le_bytes();
    if magic != MAGIC {
        return Err(ModelError::Magic { found: magic });
    }
    let version = r.word()?;
    if !(DIFFERENCES_VERSION..=FORMAT_VERSION).contains(&version) {
        return Err(ModelError::Version { found: version });
    }
    let length = r.count(MAX_COUNT)?;
    if length <= HEADER_WORDS || words.len() < length {
        return Err(ModelError::Truncated { needed: 4 * length.max(HEADER_WORDS + 1), found: bytes.len() });
    }
    let (body, crc) = bytes.split_at_checked(4 * (length - 1)).ok_or(ModelError::ArraySizes)?;
    let stored = crc.first_chunk().map(|w| u32::from_le_bytes(*w)).ok_or(ModelError::ArraySizes)?;
    let computed = crc32(body);
    if stored != computed {
        return Err(ModelError::Checksum { stored, computed });
    }
    r.words = words.get(..length - 1).ok_or(ModelError::ArraySizes)?;

    let inputs = r.count(MAX_COUNT)?;
    let orders = r.count(2)?;
    let alignment = match r.count(2)? {
        0 => Alignment::Forward,
        1 => Alignment::Half,
        _ => Alignment::Causal,
    };
    let sample_rate_hz = r.float()?;
    let library = Library {
        variables: r.count(usize::from(u8::MAX))? as u8,
        degree: r.count(usize::from(u8::MAX))? as u8,
        harmonics: r.count(usize::from(u16::MAX))? as u16,
        powers: false,
    };
    let terms = r.count(MAX_COUNT)?;
    let coefficients = r.count(MAX_COUNT)?;
    let (encoder_layers, decoder_layers) = (r.count(MAX_LAYERS)?, r.count(MAX_LAYERS)?);
    let screen = ScreenConfig { full_scale: r.float()?, stuck_after: r.word()? };
    let monitor = r.monitor(version)?;
    let estimator = if version == DIFFERENCES_VERSION { Estimator::Differences } else { r.estimator(version)? };
    let library = library.with_powers(version > ESTIMATORS_VERSION && r.count(1)? == 1);
    let fixed = if version > LEVELS_VERSION { r.count(3)? } else { 0 };
    let spec = |orders| StateSpec { dimension: inputs, orders, alignment, estimator };
    let input = match orders {
        0 => Input::Direct(inputs),
        1 => Input::VirtualStates(spec(Orders::Even)),
        _ => Input::VirtualStates(spec(Orders::Consecutive)),
    };
    let (encoder, decoder) = (r.widths(encoder_layers)?, r.widths(decoder_layers)?);
    let states = Scaling { mean: r.floats(inputs)?, scale: r.floats(inputs)? };
    let derivatives = Scaling { mean: r.floats(inputs)?, scale: r.floats(inputs)? };
    let residual_spread = r.floats(inputs)?;
    let mut network = |widths: &[u16], fixed, name| {
        let arithmetic = if fixed { Arithmetic::Fixed } else { Arithmetic::Float };
        let wrong = ModelError::Network { network: name };
        let words = r.take(word_count(widths, arithmetic).ok_or(wrong)?)?;
        Network::new(widths, arithmetic, words).ok_or(wrong)
    };
    let encoder = network(&encoder, fixed & 1 != 0, Array::Encoder)?;
    let decoder = network(&decoder, fixed & 2 != 0, Array::Decoder)?;
    let dynamics = Dynamics {
        terms: r.take(TERM_WORDS * terms)?.as_chunks().0,
        ends: r.take(terms)?,
        equations: r.take(coefficients)?,
        coefficients: r.floats(coefficients)?,
    };
    if r.at != r.words.len() {
        return Err(ModelError::ArraySizes);
    }
    Model::new(Model {
        sample_rate_hz,
        input,
        states,
        derivatives,
        encoder,
        decoder,
        library,
        dynamics,
        residual_spread,
        screen,
        monitor,
    })
}

pub(super) fn byte_len(model: &Model<'_>) -> usize {
    let widths = model.encoder.widths().len() + model.decoder.widths().len();
    let parameters = model.encoder.words().len() + model.decoder.words().len();
    let terms = (TERM_WORDS + 1) * model.dynamics.terms.len();
    let coefficients = 2 * model.dynamics.coefficients.len();
    let header = HEADER_WORDS + NEWER_WORDS;
    4 * (header + widths + 5 * model.input.len() + parameters + terms + coefficients + 1)
}

/// Words after the header: estimator and powers.
fn newer_words(model: &Model<'_>) -> [u32; NEWER_WORDS] {
    let estimator = match model.input {
        Input::VirtualStates(spec) => spec.estimator,
        Input::Direct(_) => Estimator::Differences,
    };
    let powers = model.library.powers.into();
    let is_fixed = |network: &Network<'_>| u32::from(network.arithmetic() == Arithmetic::Fixed);
    let fixed = is_fixed(&model.encoder) + 2 * is_fixed(&model.decoder);
    match estimator {
        Estimator::Differences => [DIFFERENCES, 0, 0, powers, fixed],
        Estimator::SavitzkyGolay { excess, stretch } => {
            [SAVITZKY_GOLAY, excess.into(), stretch.to_bits(), powers, fixed]
        }
        Estimator::Kalman { cutoff } => [KALMAN, 0, cutoff.to_bits(), powers, fixed],
    }
}

pub(super) fn write(model: &Model<'_>, buffer: &mut [u8]) -> Result<usize, ModelError> {
    let needed = byte_len(model);
    let found = buffer.len();
    let too_small = ModelError::BufferTooSmall { needed, found };
    let out = buffer.get_mut(..needed).ok_or(too_small)?;
    let (words, _) = out.as_chunks_mut::<4>();
    let mut slots = words.iter_mut();
    let mut put = |word: Word| {
        if let Some(slot) = slots.next() {
            *slot = word;
        }
    };
    let (orders, alignment) = match model.input {
        Input::Direct(_) => (0, Alignment::Forward),
        Input::VirtualStates(spec) if spec.orders == Orders::Even => (1, spec.alignment),
        Input::VirtualStates(spec) => (2, spec.alignment),
    };
    let m = &model.monitor;
    let layers = |n: &Network<'_>| n.widths().len().saturating_sub(1) as u32;
    put(MAGIC);
    for word in [
        FORMAT_VERSION,
        (needed / 4) as u32,
        model.input.len() as u32,
        orders,
        match alignment {
            Alignment::Forward => 0,
            Alignment::Half => 1,
            Alignment::Causal => 2,
        },
        model.sample_rate_hz.to_bits(),
        model.library.variables.into(),
        model.library.degree.into(),
        model.library.harmonics.into(),
        model.dynamics.terms.len() as u32,
        model.dynamics.coefficients.len() as u32,
        layers(&model.encoder),
        layers(&model.decoder),
        model.screen.full_scale.to_bits(),
        model.screen.stuck_after,
        m.block,
        m.healthy_centre.to_bits(),
        m.healthy_spread.to_bits(),
        m.ewma_weight.to_bits(),
        m.limit.to_bits(),
        m.release.to_bits(),
        m.calm_blocks,
        m.false_alarms_per_day.to_bits(),
        m.blocks_per_day.to_bits(),
        m.healthy_blocks,
    ] {
        put(word.to_le_bytes());
    }
    newer_words(model).iter().for_each(|word| put(word.to_le_bytes()));
    for width in model.encoder.widths().iter().chain(model.decoder.widths()) {
        put(u32::from(*width).to_le_bytes());
    }
    let d = &model.dynamics;
    for array in [
        model.states.mean.0,
        model.states.scale.0,
        model.derivatives.mean.0,
        model.derivatives.scale.0,
        model.residual_spread.0,
        model.encoder.words(),
        model.decoder.words(),
        d.terms.as_flattened(),
        d.ends,
        d.equations,
        d.coefficients.0,
    ] {
        array.iter().for_each(|word| put(*word));
    }
    let (body, crc) = out.split_at_mut_checked(needed - 4).ok_or(too_small)?;
    crc.copy_from_slice(&crc32(body).to_le_bytes());
    Ok(needed)
}
