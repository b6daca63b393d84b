//! Diagnosis of the 5-DoF rig by the power spectra of its recordings.
//!
//! | module | holds |
//! |---|---|
//! | `observation` | recordings as power spectra |
//! | `prediction` | spectra that a rig predicts: noise and lines |
//! | `likelihood` | their density, with all that a machine is beyond its drawing |
//! | `fit` | Fisher scoring of the rig's numbers and the noise's colour |
//! | `events` | shocks and steps of the load, each at a time of its own |
//! | `hypotheses` | lasting effects with starts of their search |
//! | `search` | the effects that gain most |
//! | `lack` | what a prediction leaves |
//! | `pipeline` | from recordings to a result |
//! | `terms` | causes as curves |
//! | `text` | sentences |

mod events;
mod fit;
mod hypotheses;
mod lack;
mod likelihood;
mod observation;
mod pipeline;
mod prediction;
mod search;
mod settings;
mod terms;
mod text;

pub(crate) use pipeline::diagnose;
