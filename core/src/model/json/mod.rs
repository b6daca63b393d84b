//! JSON form of a model, through serde-json-core, with the content of the binary form.
//!
//! `terms` are indices into the library's order. serde-json-core writes NaN as `null`, which is an error to the reader.

mod arena;

use core::fmt;

use serde::de::{DeserializeSeed, MapAccess, Visitor};
use serde::ser::{SerializeSeq, SerializeStruct};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use self::arena::{Arena, Words};
use super::{Array, Input, Model, ModelError, Scaling};
use crate::dynamics::{Dynamics, TERM_WORDS, decode_term, encode_term};
use crate::input_check::ScreenConfig;
use crate::library::Library;
use crate::monitor::MonitorConfig;
use crate::network::{Arithmetic, MAX_LAYERS, Network};
use crate::states::{Alignment, Estimator, Orders, StateSpec};
use crate::{Floats, Word};

/// Schema that is written: its monitor judges the logarithm of the level, and its networks may be in
/// fixed point.
pub(super) const SCHEMA: &str = "ballrace-device-model/4";
/// Schemas that are read besides, whose monitor judged the level itself: finite differences, any other estimator, libraries
/// with powers.
pub(super) const LEVELS_SCHEMAS: [&str; 3] =
    ["ballrace-device-model/1", "ballrace-device-model/2", "ballrace-device-model/3"];

type Widths = heapless::Vec<u16, { MAX_LAYERS + 1 }>;

/// Everything but the arrays.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header<'a> {
    schema: &'a str,
    sample_rate_hz: f32,
    inputs: usize,
    /// Orders of the states; `None`: the states are given directly.
    #[serde(deserialize_with = "Option::deserialize")]
    orders: Option<Orders>,
    alignment: Alignment,
    #[serde(default, skip_serializing_if = "is_differences")]
    estimator: Estimator,
    library: Library,
    screen: ScreenConfig,
    monitor: AnyMonitor,
    encoder_widths: Widths,
    decoder_widths: Widths,
}

fn is_differences(estimator: &Estimator) -> bool {
    *estimator == Estimator::Differences
}

/// Schema of before version 4 for an estimator and a library.
fn levels_schema(estimator: Estimator, library: Library) -> &'static str {
    let [differences, estimators, powers] = LEVELS_SCHEMAS;
    match (library.powers, estimator) {
        (true, _) => powers,
        (false, Estimator::Differences) => differences,
        (false, _) => estimators,
    }
}

/// Monitor's settings in the keys of any schema; those of the others are absent.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct AnyMonitor {
    block: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    healthy_centre: Option<f32>,
    healthy_spread: f32,
    ewma_weight: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    limit: Option<f32>,
    release: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    calm_blocks: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    false_alarms_per_day: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    blocks_per_day: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    healthy_blocks: Option<u32>,
    #[serde(skip_serializing)]
    healthy_mean: Option<f32>,
    #[serde(skip_serializing)]
    ewma_limit: Option<f32>,
    #[serde(skip_serializing)]
    of_blocks: Option<u32>,
    #[serde(skip_serializing)]
    #[expect(dead_code, reason = "of before, read over")]
    cusum_slack: Option<f32>,
    #[serde(skip_serializing)]
    #[expect(dead_code, reason = "of before, read over")]
    cusum_limit: Option<f32>,
    #[serde(skip_serializing)]
    #[expect(dead_code, reason = "of before, read over")]
    votes: Option<u32>,
}

impl From<MonitorConfig> for AnyMonitor {
    fn from(m: MonitorConfig) -> Self {
        Self {
            block: m.block,
            healthy_centre: Some(m.healthy_centre),
            healthy_spread: m.healthy_spread,
            ewma_weight: m.ewma_weight,
            limit: Some(m.limit),
            release: m.release,
            calm_blocks: Some(m.calm_blocks),
            false_alarms_per_day: Some(m.false_alarms_per_day),
            blocks_per_day: Some(m.blocks_per_day),
            healthy_blocks: Some(m.healthy_blocks),
            ..Self::default()
        }
    }
}

impl AnyMonitor {
    /// Settings in the keys of version 4, or with `levels` in those of before; `None` where a key is missing.
    fn config(&self, levels: bool) -> Option<MonitorConfig> {
        let Self { block, healthy_spread, ewma_weight, release, .. } = *self;
        if levels {
            let config = MonitorConfig::from_levels(block, self.healthy_mean?, healthy_spread);
            let (limit, calm_blocks) = (self.ewma_limit?, self.of_blocks?);
            return Some(MonitorConfig { ewma_weight, limit, release, calm_blocks, ..config });
        }
        Some(MonitorConfig {
            block,
            healthy_centre: self.healthy_centre?,
            healthy_spread,
            ewma_weight,
            limit: self.limit?,
            release,
            calm_blocks: self.calm_blocks?,
            false_alarms_per_day: self.false_alarms_per_day?,
            blocks_per_day: self.blocks_per_day?,
            healthy_blocks: self.healthy_blocks?,
        })
    }
}

/// Names of the arrays, in the order in which they are written.
const ARRAYS: [&str; 10] = [
    "state_mean",
    "state_scale",
    "derivative_mean",
    "derivative_scale",
    "residual_spread",
    "encoder",
    "decoder",
    "term_ends",
    "equations",
    "coefficients",
];
const ENCODER: usize = 5;
const DECODER: usize = 6;
/// Names of the networks' arrays of integers, in fixed point.
const FIXED_NAMES: [&str; 2] = ["encoder_fixed", "decoder_fixed"];
const TERM_ENDS: usize = 7;
const EQUATIONS: usize = 8;

struct FloatSeq<'a>(Floats<'a>);

impl Serialize for FloatSeq<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut seq = serializer.serialize_seq(Some(self.0.len()))?;
        self.0.iter().try_for_each(|v| seq.serialize_element(&v))?;
        seq.end()
    }
}

struct IntegerSeq<'a>(&'a [Word]);

impl Serialize for IntegerSeq<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut seq = serializer.serialize_seq(Some(self.0.len()))?;
        self.0.iter().try_for_each(|w| seq.serialize_element(&u32::from_le_bytes(*w)))?;
        seq.end()
    }
}

struct TermSeq<'a>(&'a [[Word; TERM_WORDS]], Library);

impl Serialize for TermSeq<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut seq = serializer.serialize_seq(Some(self.0.len()))?;
        for code in self.0 {
            let term = decode_term(code, &self.1);
            let index = term.and_then(|term| self.1.index_of(term)).unwrap_or(usize::MAX);
            seq.serialize_element(&(index as u32))?;
        }
        seq.end()
    }
}

impl Serialize for Model<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (orders, alignment, estimator) = match self.input {
            Input::Direct(_) => (None, Alignment::Forward, Estimator::Differences),
            Input::VirtualStates(spec) => (Some(spec.orders), spec.alignment, spec.estimator),
        };
        let widths = |n: &Network<'_>| Widths::from_slice(n.widths()).unwrap_or_default();
        let header = Header {
            schema: SCHEMA,
            sample_rate_hz: self.sample_rate_hz,
            inputs: self.input.len(),
            orders,
            alignment,
            estimator,
            library: self.library,
            screen: self.screen,
            monitor: self.monitor.into(),
            encoder_widths: widths(&self.encoder),
            decoder_widths: widths(&self.decoder),
        };
        let mut out = serializer.serialize_struct("Model", 2 + ARRAYS.len())?;
        out.serialize_field("header", &header)?;
        out.serialize_field("terms", &TermSeq(self.dynamics.terms, self.library))?;
        for (n, name) in ARRAYS.into_iter().enumerate() {
            let words = array(self, n);
            let [encoder, decoder] = FIXED_NAMES;
            match n {
                TERM_ENDS | EQUATIONS => out.serialize_field(name, &IntegerSeq(words))?,
                ENCODER if self.encoder.arithmetic() == Arithmetic::Fixed => {
                    out.serialize_field(encoder, &IntegerSeq(words))?;
                }
                DECODER if self.decoder.arithmetic() == Arithmetic::Fixed => {
                    out.serialize_field(decoder, &IntegerSeq(words))?;
                }
                _ => out.serialize_field(name, &FloatSeq(Floats(words)))?,
            }
        }
        out.end()
    }
}

/// Array `n` of [`ARRAYS`].
fn array<'a>(model: &Model<'a>, n: usize) -> &'a [Word] {
    match n {
        0 => model.states.mean.0,
        1 => model.states.scale.0,
        2 => model.derivatives.mean.0,
        3 => model.derivatives.scale.0,
        4 => model.residual_spread.0,
        ENCODER => model.encoder.words(),
        DECODER => model.decoder.words(),
        TERM_ENDS => model.dynamics.ends,
        EQUATIONS => model.dynamics.equations,
        _ => model.dynamics.coefficients.0,
    }
}

pub(super) fn write(model: &Model<'_>, buffer: &mut [u8]) -> Result<usize, ModelError> {
    serde_json_core::to_slice(model, buffer).map_err(|_| ModelError::JsonBufferTooSmall)
}

pub(super) fn read<'a>(text: &str, storage: &'a mut [Word]) -> Result<Model<'a>, ModelError> {
    let mut arena = Arena { free: storage, full: false };
    let mut deserializer = serde_json_core::de::Deserializer::new(text.as_bytes(), None);
    let parsed = Document { arena: &mut arena }.deserialize(&mut deserializer);
    let parsed = parsed.and_then(|parsed| deserializer.end().map(|_| parsed));
    match parsed {
        Ok(parsed) => parsed.build(),
        Err(_) if arena.full => Err(ModelError::StorageTooSmall),
        Err(_) => Err(ModelError::Json),
    }
}

/// Contents of a document, before they are checked.
struct Parsed<'a> {
    header: ParsedHeader,
    terms: &'a [Word],
    codes: &'a mut [Word],
    arrays: [&'a [Word]; ARRAYS.len()],
    /// Arithmetic of encoder and decoder, which the names of their arrays tell.
    networks: [Arithmetic; 2],
}

/// Models that a document's schema fits.
enum SchemaFits {
    None,
    /// Schema of before version 4.
    SinglePrecision,
    Any,
}

/// A header without its borrowed schema.
struct ParsedHeader {
    schema_fits: SchemaFits,
    sample_rate_hz: f32,
    input: Input,
    library: Library,
    screen: ScreenConfig,
    /// `None` where a key is missing.
    monitor: Option<MonitorConfig>,
    encoder_widths: Widths,
    decoder_widths: Widths,
}

impl From<Header<'_>> for ParsedHeader {
    fn from(h: Header<'_>) -> Self {
        let input = match h.orders {
            None => Input::Direct(h.inputs),
            Some(orders) => Input::VirtualStates(StateSpec {
                dimension: h.inputs,
                orders,
                alignment: h.alignment,
                estimator: h.estimator,
            }),
        };
        let levels = h.schema == levels_schema(h.estimator, h.library);
        Self {
            schema_fits: match (levels, h.schema == SCHEMA) {
                (true, _) => SchemaFits::SinglePrecision,
                (false, true) => SchemaFits::Any,
                (false, false) => SchemaFits::None,
            },
            sample_rate_hz: h.sample_rate_hz,
            input,
            library: h.library,
            screen: h.screen,
            monitor: h.monitor.config(levels),
            encoder_widths: h.encoder_widths,
            decoder_widths: h.decoder_widths,
        }
    }
}

impl<'a> Parsed<'a> {
    fn build(self) -> Result<Model<'a>, ModelError> {
        let Parsed { header, terms, codes, arrays, networks } = self;
        match header.schema_fits {
            SchemaFits::Any => {}
            SchemaFits::SinglePrecision if networks == [Arithmetic::Float; 2] => {}
            SchemaFits::SinglePrecision | SchemaFits::None => return Err(ModelError::Schema),
        }
        let monitor = header.monitor.ok_or(ModelError::Json)?;
        if !header.library.is_valid() {
            return Err(ModelError::Library { found: header.library });
        }
        let (codes, _) = codes.as_chunks_mut::<TERM_WORDS>();
        let codes = codes.get_mut(..terms.len()).ok_or(ModelError::StorageTooSmall)?;
        for (index, (code, term)) in codes.iter_mut().zip(terms).enumerate() {
            let term = header.library.term(u32::from_le_bytes(*term) as usize);
            *code = encode_term(term.ok_or(ModelError::Term { index })?);
        }
        let network = |widths: &Widths, arithmetic, words, name| {
            Network::new(widths, arithmetic, words).ok_or(ModelError::Network { network: name })
        };
        let [in_encoder, in_decoder] = networks;
        let [mean, scale, d_mean, d_scale, spread, encoder, decoder, ends, equations, coefficients] = arrays;
        Model::new(Model {
            sample_rate_hz: header.sample_rate_hz,
            input: header.input,
            states: Scaling { mean: Floats(mean), scale: Floats(scale) },
            derivatives: Scaling { mean: Floats(d_mean), scale: Floats(d_scale) },
            encoder: network(&header.encoder_widths, in_encoder, encoder, Array::Encoder)?,
            decoder: network(&header.decoder_widths, in_decoder, decoder, Array::Decoder)?,
            library: header.library,
            dynamics: Dynamics { terms: codes, ends, equations, coefficients: Floats(coefficients) },
            residual_spread: Floats(spread),
            screen: header.screen,
            monitor,
        })
    }
}

struct Document<'r, 'a> {
    arena: &'r mut Arena<'a>,
}

impl<'de, 'a> DeserializeSeed<'de> for Document<'_, 'a> {
    type Value = Parsed<'a>;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Parsed<'a>, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, 'a> Visitor<'de> for Document<'_, 'a> {
    type Value = Parsed<'a>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a ballrace device model")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Parsed<'a>, A::Error> {
        use serde::de::Error;
        let mut header = None;
        let mut terms = None;
        let mut arrays: [Option<&'a [Word]>; ARRAYS.len()] = [None; ARRAYS.len()];
        let mut networks = [Arithmetic::Float; 2];
        while let Some(key) = map.next_key::<&str>()? {
            if key == "header" {
                header = Some(ParsedHeader::from(map.next_value::<Header<'de>>()?));
                continue;
            }
            let fixed = FIXED_NAMES.iter().position(|name| *name == key);
            if let Some(arithmetic) = fixed.and_then(|network| networks.get_mut(network)) {
                *arithmetic = Arithmetic::Fixed;
            }
            let n = fixed.map(|network| ENCODER + network).or(ARRAYS.iter().position(|name| *name == key));
            let integers = key == "terms" || fixed.is_some() || matches!(n, Some(TERM_ENDS | EQUATIONS));
            let words = map.next_value_seed(Words { arena: self.arena, integers })?;
            match n.and_then(|n| arrays.get_mut(n)) {
                Some(slot) => *slot = Some(words),
                None if key == "terms" => terms = Some(words),
                None => return Err(A::Error::unknown_field(key, &ARRAYS)),
            }
        }
        let mut complete: [&'a [Word]; ARRAYS.len()] = [&[]; ARRAYS.len()];
        for ((slot, found), name) in complete.iter_mut().zip(arrays).zip(ARRAYS) {
            *slot = found.ok_or_else(|| A::Error::missing_field(name))?;
        }
        Ok(Parsed {
            header: header.ok_or_else(|| A::Error::missing_field("header"))?,
            terms: terms.ok_or_else(|| A::Error::missing_field("terms"))?,
            codes: core::mem::take(&mut self.arena.free),
            arrays: complete,
            networks,
        })
    }
}
