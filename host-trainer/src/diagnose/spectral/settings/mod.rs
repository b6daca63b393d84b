//! Settings of the diagnosis by power spectra, a file for each stage.

mod event;
mod fit;
mod gate;
mod guess;
mod intervals;
mod lack;
mod likelihood;
mod mains;
mod search;
mod tolerance;
mod unsteady;

pub use event::EventSettings;
pub use fit::FitSettings;
pub use gate::GateSettings;
pub use guess::GuessSettings;
pub use intervals::IntervalSettings;
pub use lack::LackSettings;
pub use likelihood::{FORMS, LikelihoodSettings, WIDTHS};
pub use mains::MainsSettings;
pub use search::SearchSettings;
pub use tolerance::ToleranceSettings;
pub use unsteady::UnsteadySettings;

use crate::diagnose::shown::ShownSettings;

/// All settings, stage by stage.
pub fn document() -> serde_json::Value {
    serde_json::json!({
        "likelihood": LikelihoodSettings::DEFAULT,
        "fit": FitSettings::DEFAULT,
        "event": EventSettings::DEFAULT,
        "lack": LackSettings::DEFAULT,
        "gate": GateSettings::DEFAULT,
        "tolerance": ToleranceSettings::DEFAULT,
        "intervals": IntervalSettings::DEFAULT,
        "mains": MainsSettings::DEFAULT,
        "unsteady": UnsteadySettings::DEFAULT,
        "guess": GuessSettings::DEFAULT,
        "search": SearchSettings::DEFAULT,
        "shown": ShownSettings::DEFAULT,
    })
}
