//! Stages of a sample, and to which of them an instruction belongs, by the functions that its debug information says it
//! was inlined into.

use addr2line::Loader;

/// A stage of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Check of the sample.
    Screen,
    /// Virtual states.
    States,
    /// Encoder, without its activation.
    Encoder,
    /// Sigmoids of encoder and decoder.
    Activation,
    /// Candidate functions.
    Library,
    /// The sum over Ξ.
    Dynamics,
    /// Derivative of the decoder, without its activation.
    Decoder,
    /// Residual, blocks, limit.
    Monitor,
    /// All else: scaling, prediction of the next sample, the loop over the samples.
    Other,
}

impl Stage {
    /// Stages in the order of a sample.
    pub const ALL: [Self; 9] = [
        Self::Screen,
        Self::States,
        Self::Encoder,
        Self::Activation,
        Self::Library,
        Self::Dynamics,
        Self::Decoder,
        Self::Monitor,
        Self::Other,
    ];

    /// Name in tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Screen => "screen",
            Self::States => "states",
            Self::Encoder => "encoder",
            Self::Activation => "activation",
            Self::Library => "library",
            Self::Dynamics => "xi",
            Self::Decoder => "decoder",
            Self::Monitor => "monitor",
            Self::Other => "other",
        }
    }

    /// Stage of a function by its source file and name. The innermost function that has a stage counts.
    fn of_function(file: &str, function: &str) -> Option<Self> {
        const RULES: [(&str, &str, Stage); 10] = [
            ("core/src/math", "sigmoid", Stage::Activation),
            ("core/src/network", "sigmoid", Stage::Activation),
            ("core/src/network", "forward", Stage::Encoder),
            ("core/src/network", "tangent", Stage::Decoder),
            ("core/src/library", "", Stage::Library),
            // All of that module but the sum itself is the value of a term.
            ("core/src/dynamics", "rate", Stage::Dynamics),
            ("core/src/dynamics", "", Stage::Library),
            ("core/src/states", "", Stage::States),
            ("core/src/monitor", "", Stage::Monitor),
            ("core/src/input_check", "", Stage::Screen),
        ];
        let ours = !file.contains("library/core/src");
        let matching = |(path, name, _): &&(&str, &str, Stage)| file.contains(path) && function.contains(name);
        RULES.iter().find(matching).filter(|_| ours).map(|(_, _, stage)| *stage)
    }
}

/// What the debug information says of an instruction.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Stage of the innermost function that has one; without one an instruction is of its caller's stage.
    pub stage: Option<Stage>,
    /// Whether it belongs to the reading of the instruction counter that ends a sample.
    pub lap: bool,
}

/// Place of an address.
///
/// # Errors
/// A text of what is wrong with the debug information.
pub fn place(debug: &Loader, address: u32) -> Result<Place, String> {
    let error = |error: addr2line::gimli::Error| format!("debug information of {address:#010x}: {error}");
    let mut frames = debug.find_frames(address.into()).map_err(|e| error_text(address, &e))?;
    let mut place = Place::default();
    while let Some(frame) = frames.next().map_err(error)? {
        let Some(name) = &frame.function else { continue };
        let name = name.demangle().map_err(|e| error_text(address, &e))?;
        let file = frame.location.and_then(|location| location.file).unwrap_or("");
        place.lap |= file.ends_with("board.rs") && name.contains("lap");
        place.stage = place.stage.or_else(|| Stage::of_function(file, &name));
    }
    Ok(place)
}

fn error_text(address: u32, error: &dyn std::fmt::Display) -> String {
    format!("debug information of {address:#010x}: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_have_the_stage_of_their_module() {
        for (file, function, expected) in [
            ("core/src/network.rs", "forward", Some(Stage::Encoder)),
            ("core/src/network/dense.rs", "ballrace_core::network::Network::tangent", Some(Stage::Decoder)),
            ("core/src/network.rs", "accumulate", None),
            ("core/src/dynamics.rs", "rate", Some(Stage::Dynamics)),
            ("core/src/dynamics.rs", "{closure#0}", Some(Stage::Library)),
            ("core/src/math.rs", "sigmoid", Some(Stage::Activation)),
            ("core/src/network/fixed.rs", "sigmoid", Some(Stage::Activation)),
            ("core/src/math.rs", "exp", None),
            ("core/src/states/kalman.rs", "push", Some(Stage::States)),
            ("library/core/src/iter/adapters/zip.rs", "next", None),
        ] {
            assert_eq!(Stage::of_function(file, function), expected, "{file} {function}");
        }
    }
}
