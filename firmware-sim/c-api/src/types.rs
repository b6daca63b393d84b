//! What crosses the interface, with C's layout.

use ballrace_core::device;
use ballrace_core::input_check;
use ballrace_core::model::ModelError;
use ballrace_core::monitor;

/// Error of a call. 0 is success.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error {
    /// Success.
    None = 0,
    /// A pointer is null.
    NullPointer = 1,
    /// The memory is too short: `ballrace_memory_size` says what the model needs.
    MemoryTooSmall = 2,
    /// The memory is not aligned to `BALLRACE_MEMORY_ALIGNMENT` bytes.
    MemoryMisaligned = 3,
    /// The handle is not one that `ballrace_init` gave, or its memory was overwritten.
    NotADevice = 4,
    /// The model has fewer bytes than it says.
    ModelTruncated = 5,
    /// The bytes are not a model.
    ModelMagic = 6,
    /// The model is of a version of the format that this library does not read.
    ModelVersion = 7,
    /// The model's checksum differs: its bytes were changed after they were written.
    ModelChecksum = 8,
    /// The model's header or sizes are out of range.
    ModelHeader = 9,
    /// A number of the model is not finite, not positive, or out of range.
    ModelContent = 10,
    /// The model takes states, not samples.
    ModelTakesStates = 11,
}

impl Error {
    /// One sentence, ending in a zero byte.
    pub const fn text(code: i32) -> &'static core::ffi::CStr {
        match code {
            0 => c"no error",
            1 => c"a pointer is null",
            2 => c"the memory is too short: ballrace_memory_size says what the model needs",
            3 => c"the memory is not aligned to BALLRACE_MEMORY_ALIGNMENT bytes",
            4 => c"the handle is not a device, or its memory was overwritten",
            5 => c"the model has fewer bytes than it says",
            6 => c"the bytes are not a model: they do not start with BRMD",
            7 => c"the model is of a version of the format that this library does not read",
            8 => c"the model's checksum differs: its bytes were changed after they were written",
            9 => c"the model's header or sizes are out of range",
            10 => c"a number of the model is not finite, not positive, or out of range",
            11 => c"the model takes states, expected one that takes samples",
            _ => c"no error has this number",
        }
    }
}

impl From<ModelError> for Error {
    fn from(error: ModelError) -> Self {
        match error {
            ModelError::Truncated { .. } => Self::ModelTruncated,
            ModelError::Magic { .. } => Self::ModelMagic,
            ModelError::Version { .. } => Self::ModelVersion,
            ModelError::Checksum { .. } => Self::ModelChecksum,
            ModelError::HeaderWord { .. }
            | ModelError::ArraySizes
            | ModelError::States(_)
            | ModelError::Dimension { .. }
            | ModelError::Library { .. }
            | ModelError::Network { .. }
            | ModelError::NetworkShape { .. }
            | ModelError::Length { .. } => Self::ModelHeader,
            // Those of JSON and of writing, which no call here does, are among the rest.
            _ => Self::ModelContent,
        }
    }
}

/// Quality of a sample.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Good: is evaluated.
    Good = 0,
    /// NaN or infinite.
    NonFinite = 1,
    /// At or beyond the sensor's full scale.
    Saturated = 2,
    /// Equal to too many samples before it.
    Stuck = 3,
    /// Not received.
    Missing = 4,
}

impl From<input_check::Quality> for Quality {
    fn from(quality: input_check::Quality) -> Self {
        match quality {
            input_check::Quality::Good => Self::Good,
            input_check::Quality::NonFinite => Self::NonFinite,
            input_check::Quality::Saturated => Self::Saturated,
            input_check::Quality::Stuck => Self::Stuck,
            input_check::Quality::Missing => Self::Missing,
        }
    }
}

/// Status of the machine.
#[repr(i32)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Status {
    /// Too few blocks so far.
    #[default]
    Starting = 0,
    /// Residual of the healthy machine.
    Healthy = 1,
    /// Residual that differs from the healthy machine's.
    Anomalous = 2,
    /// Too many broken samples.
    Blind = 3,
}

impl From<monitor::Status> for Status {
    fn from(status: monitor::Status) -> Self {
        match status {
            monitor::Status::Starting => Self::Starting,
            monitor::Status::Healthy => Self::Healthy,
            monitor::Status::Anomalous => Self::Anomalous,
            monitor::Status::Blind => Self::Blind,
        }
    }
}

/// Step of the model, in its scaled units unless stated otherwise. The arrays are the device's, valid until the next call
/// with it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Length of `states`, `predicted`, `measured` and `expected`.
    pub state_count: usize,
    /// Length of `latent` and `latent_rate`.
    pub latent_count: usize,
    /// Virtual states, in physical units.
    pub states: *const f32,
    /// Latent variables.
    pub latent: *const f32,
    /// Rates of the latent variables.
    pub latent_rate: *const f32,
    /// Predicted derivatives. A causal model's belong to the next sample.
    pub predicted: *const f32,
    /// Measured derivatives of this step's target instant.
    pub measured: *const f32,
    /// Prediction of `measured`: for a causal model that of the step before.
    pub expected: *const f32,
    /// Whether `measured` and `expected` belong together; their difference is the residual.
    pub comparable: bool,
    /// Whether the model predicts the next sample.
    pub has_next_sample: bool,
    /// Predicted next sample, m/s^2; else 0.
    pub next_sample: f32,
}

impl Step {
    /// Before the first step: no arrays.
    pub const NONE: Self = Self {
        state_count: 0,
        latent_count: 0,
        states: core::ptr::null(),
        latent: core::ptr::null(),
        latent_rate: core::ptr::null(),
        predicted: core::ptr::null(),
        measured: core::ptr::null(),
        expected: core::ptr::null(),
        comparable: false,
        has_next_sample: false,
        next_sample: 0.0,
    };
}

impl From<ballrace_core::evaluator::Step<'_>> for Step {
    fn from(step: ballrace_core::evaluator::Step<'_>) -> Self {
        Self {
            state_count: step.states.len(),
            latent_count: step.latent.len(),
            states: step.states.as_ptr(),
            latent: step.latent.as_ptr(),
            latent_rate: step.latent_rate.as_ptr(),
            predicted: step.predicted.as_ptr(),
            measured: step.measured.as_ptr(),
            expected: step.expected.as_ptr(),
            comparable: step.comparable,
            has_next_sample: step.next_sample.is_some(),
            next_sample: step.next_sample.unwrap_or_default(),
        }
    }
}

/// Monitor's statistics after a block.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Block {
    /// Whether the call ended a block; if not, the rest is zero.
    pub ended: bool,
    /// Whether the EWMA is beyond its limit.
    pub beyond: bool,
    /// Blocks so far, this one included; saturating.
    pub block: u32,
    /// Mean squared normalised residual; NaN for a blind block.
    pub level: f32,
    /// Distance of the level's logarithm from its healthy centre in healthy spreads; NaN for a blind block.
    pub deviation: f32,
    /// EWMA of the running median of the deviation, which the limit judges.
    pub ewma: f32,
    /// Status after this block.
    pub status: Status,
    /// Status before this block; a change is an event.
    pub was: Status,
}

impl From<Option<monitor::BlockReport>> for Block {
    fn from(report: Option<monitor::BlockReport>) -> Self {
        report.map_or(Self::default(), |report| Self {
            ended: true,
            beyond: report.beyond,
            block: report.block,
            level: report.level,
            deviation: report.deviation,
            ewma: report.ewma,
            status: report.status.into(),
            was: report.was.into(),
        })
    }
}

/// Result of one sample.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SampleResult {
    /// Quality of the sample; only good ones are evaluated.
    pub quality: Quality,
    /// Whether the model was evaluated; not for a broken sample, and not while the differences fill.
    pub evaluated: bool,
    /// Step of the model, if it was evaluated.
    pub step: Step,
    /// Statistics of the block that the sample ended, if it ended one.
    pub block: Block,
}

impl From<device::SampleResult<'_>> for SampleResult {
    fn from(result: device::SampleResult<'_>) -> Self {
        Self {
            quality: result.quality.into(),
            evaluated: result.step.is_some(),
            step: result.step.map_or(Step::NONE, Step::from),
            block: result.block.into(),
        }
    }
}

/// Totals since the start; the counts saturate.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Summary {
    /// Current status.
    pub status: Status,
    /// NaN or infinite samples.
    pub non_finite: u32,
    /// Samples at or beyond full scale.
    pub saturated: u32,
    /// Samples in stuck runs, counted from the one that made the run too long.
    pub stuck: u32,
    /// Samples not received.
    pub missing: u32,
}

impl From<device::Summary> for Summary {
    fn from(summary: device::Summary) -> Self {
        Self {
            status: summary.status.into(),
            non_finite: summary.faults.non_finite,
            saturated: summary.faults.saturated,
            stuck: summary.faults.stuck,
            missing: summary.faults.missing,
        }
    }
}
