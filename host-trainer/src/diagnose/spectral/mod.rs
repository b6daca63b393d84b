//! Diagnosis of the 5-DoF rig by the power spectra of its recordings.
//!
//! | module | holds |
//! |---|---|
//! | `observation` | recordings as power spectra |
//! | `prediction` | spectra that a rig predicts: noise and lines |
//! | `unevenness` | lines of machines with unevenly spaced balls |
//! | `unsteady` | spikes, a level that rises and falls, a tone that sweeps |
//! | `likelihood` | spectra of a machine: a prediction with all that it is beyond its drawing |
//! | `colour`, `stretch` | noise and frequencies of lines beyond those of the rig |
//! | `density` | density of a bin's power under noise and lines |
//! | `place` | places between two values of a list |
//! | `cross` | what the phase between the channels adds |
//! | `data` | recordings of a fit, and points in the space of its unknowns |
//! | `expansion` | gradient and information at a point |
//! | `fit` | Fisher scoring of the rig's numbers and the noise's colour |
//! | `events` | shocks and steps of the load, each at a time of its own |
//! | `mains` | lines of the electrical supply, taken out of the samples |
//! | `hypotheses` | lasting effects with starts of their search |
//! | `guesses` | numbers that recordings show at once |
//! | `candidate` | hypotheses fitted on top of a null fit |
//! | `screening` | starts of all hypotheses on brief recordings |
//! | `search` | the effects that gain most |
//! | `pairs` | two effects at once |
//! | `angle` | angle of a defect in the outer race |
//! | `waves` | waviness with neighbouring numbers of lobes |
//! | `baseline` | calibration to the healthy machine, and what is no change since |
//! | `refit` | fits on other recordings |
//! | `gate` | what a candidate must be, beside its gain, to be a cause |
//! | `selection` | causes, one after the other, by fitted and held-out recordings |
//! | `tolerance` | what every machine has within its tolerances |
//! | `lack` | what a prediction leaves |
//! | `pipeline` | from recordings to a result |
//! | `subset` | causes of some of the recordings |
//! | `growth` | effects of one recording in the others |
//! | `causes` | causes and their numbers |
//! | `imperfect` | what a run of a rig lacks of a machine |
//! | `held_out` | simulations of held-out recordings |
//! | `terms` | causes as curves |
//! | `text` | sentences |

mod angle;
mod baseline;
mod candidate;
mod causes;
mod colour;
mod cross;
mod data;
mod density;
mod dissipation;
mod events;
mod expansion;
mod fit;
mod forms;
mod gate;
mod growth;
mod guesses;
mod held_out;
mod hypotheses;
mod imperfect;
mod lack;
mod likelihood;
mod mains;
mod observation;
mod pairs;
mod pipeline;
mod place;
mod prediction;
mod refit;
mod screening;
mod search;
mod selection;
mod settings;
mod sidebands;
mod stretch;
mod subset;
mod terms;
mod text;
mod tolerance;
mod unevenness;
mod unsteady;
mod waves;

pub(crate) use baseline::calibrated;
pub(crate) use subset::diagnose;
