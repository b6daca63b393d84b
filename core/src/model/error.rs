//! Errors of a model.

use core::fmt;

use crate::library::Library;
use crate::states::SpecError;

/// Names an array of a model in an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Array {
    /// Means of the states.
    StateMean,
    /// Scales of the states.
    StateScale,
    /// Means of the derivatives.
    DerivativeMean,
    /// Scales of the derivatives.
    DerivativeScale,
    /// Healthy spread of the residuals.
    ResidualSpread,
    /// Encoder.
    Encoder,
    /// Decoder.
    Decoder,
    /// Ends of the terms' runs.
    TermEnds,
    /// Equation of each coefficient.
    Equations,
    /// Coefficients.
    Coefficients,
}

/// Error of bytes, text or parts that are not a model.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ModelError {
    /// Fewer bytes than the header, or than the header says.
    Truncated {
        /// Bytes needed.
        needed: usize,
        /// Bytes found.
        found: usize,
    },
    /// The first four bytes are not [`super::MAGIC`].
    Magic {
        /// Bytes found.
        found: [u8; 4],
    },
    /// Another version of the format.
    Version {
        /// Version found.
        found: u32,
    },
    /// The CRC-32 differs: the bytes were changed after they were written.
    Checksum {
        /// Checksum stored.
        stored: u32,
        /// Checksum of the bytes.
        computed: u32,
    },
    /// A header word out of range.
    HeaderWord {
        /// Index of the word.
        index: usize,
        /// Value found.
        found: u32,
    },
    /// The arrays do not fill the bytes exactly.
    ArraySizes,
    /// Virtual states that cannot be streamed.
    States(SpecError),
    /// Count of given inputs out of range.
    Dimension {
        /// Number of inputs found.
        found: usize,
    },
    /// Sample rate not a positive number.
    SampleRate {
        /// Sample rate found, Hz.
        found: f32,
    },
    /// Library sizes out of range.
    Library {
        /// Library found.
        found: Library,
    },
    /// Widths out of range, too many layers, or parameters that do not fill them.
    Network {
        /// Encoder or decoder.
        network: Array,
    },
    /// A network with the wrong number of inputs or outputs.
    NetworkShape {
        /// Encoder or decoder.
        network: Array,
        /// Inputs and outputs of the model.
        expected: (usize, usize),
        /// Inputs and outputs of the network.
        found: (usize, usize),
    },
    /// An array has the wrong length.
    Length {
        /// Array of the wrong length.
        array: Array,
        /// Length needed.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// NaN or infinity in an array.
    NotFinite {
        /// Array with the value.
        array: Array,
        /// Index of the value.
        index: usize,
    },
    /// A scale or spread is zero or negative.
    ScaleNotPositive {
        /// Array with the value.
        array: Array,
        /// Index of the value.
        index: usize,
    },
    /// A used term is not one of the library's.
    Term {
        /// Index among the used terms.
        index: usize,
    },
    /// A term's run of coefficients goes backwards, too far, or not far enough.
    TermRun {
        /// Index among the used terms.
        index: usize,
    },
    /// A coefficient belongs to an equation that does not exist.
    Equation {
        /// Index of the coefficient.
        index: usize,
    },
    /// Limits of screen or monitor out of range.
    Monitor,
    /// The buffer to write to is too short.
    BufferTooSmall {
        /// Bytes needed.
        needed: usize,
        /// Bytes found.
        found: usize,
    },
    /// The buffer for JSON text is too short.
    JsonBufferTooSmall,
    /// The storage for the arrays of a JSON model is too short.
    StorageTooSmall,
    /// Not JSON, or a key is missing, unknown or of the wrong type; serde-json-core does not say where.
    Json,
    /// The JSON document names another schema.
    Schema,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truncated { needed, found } => write!(f, "model has {found} bytes, expected {needed}"),
            Self::Magic { found } => write!(f, "model starts with {found:02x?}, expected {:02x?}", super::MAGIC),
            Self::Version { found } => {
                write!(f, "model format version {found}, expected 1 to {}", super::FORMAT_VERSION)
            }
            Self::Checksum { stored, computed } => {
                write!(f, "model CRC-32 is {computed:08x}, expected the stored {stored:08x}")
            }
            Self::HeaderWord { index, found } => write!(f, "model header word {index}: {found} means nothing"),
            Self::ArraySizes => f.write_str("model arrays do not fill its bytes exactly"),
            Self::States(error) => write!(f, "virtual states: {error}"),
            Self::Dimension { found } => write!(f, "model has {found} inputs, out of range"),
            Self::SampleRate { found } => write!(f, "model sample rate {found} Hz, expected a positive number"),
            Self::Library { found } => write!(f, "model library out of range: {found:?}"),
            Self::Network { network } => write!(f, "{network:?}: widths or parameter count out of range"),
            Self::NetworkShape { network, expected, found } => {
                write!(
                    f,
                    "{network:?} leads from {} to {}, expected {} to {}",
                    found.0, found.1, expected.0, expected.1
                )
            }
            Self::Length { array, expected, found } => {
                write!(f, "{array:?} has {found} values, expected {expected}")
            }
            Self::NotFinite { array, index } => write!(f, "{array:?}[{index}] is not finite"),
            Self::ScaleNotPositive { array, index } => write!(f, "{array:?}[{index}] is not positive"),
            Self::Term { index } => write!(f, "used term {index} is not one of the library's"),
            Self::TermRun { index } => write!(f, "coefficients of used term {index} are out of range"),
            Self::Equation { index } => write!(f, "coefficient {index} belongs to no equation"),
            Self::Monitor => f.write_str("monitor or screen limits out of range"),
            Self::BufferTooSmall { needed, found } => write!(f, "buffer has {found} bytes, model needs {needed}"),
            Self::JsonBufferTooSmall => f.write_str("buffer too small for the model's JSON"),
            Self::StorageTooSmall => f.write_str("storage too small for the model's arrays"),
            Self::Json => f.write_str("not JSON, or a key of the model is missing, unknown or of the wrong type"),
            Self::Schema => write!(
                f,
                "model JSON has another schema, expected {:?} or, as estimator and powers ask for, one of {:?}",
                super::json::SCHEMA,
                super::json::LEVELS_SCHEMAS
            ),
        }
    }
}

impl core::error::Error for ModelError {}
