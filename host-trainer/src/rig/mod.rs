//! The rig: simulation of a machine from its known parameters and its effects.
//!
//! Start at [`simulate()`]: [`config`] reads a [`Rig`], [`effect`] turns its `[[effect]]` tables into an [`assembly`],
//! [`bearing`] (theory (28) to (41)) or [`sdof`] (theory (42) and (43)) integrates that, and the assembly's output chain
//! (theory (38)) makes a [`Recording`](crate::recording::Recording). [`simulate_many`] runs many parameter sets or seeds
//! side by side.
//!
//! # How the 5-DoF rig is integrated
//!
//! The stiffest modes are linear: the resonator at 5.4 kHz against 1 kHz of the contact. So the linear part is
//! solved exactly and only the contact force is approximated, by the exponential Runge–Kutta method of order four of
//! Cox and Matthews (2002), four contact forces a step. The step follows from the contact's frequency at its
//! deflection under the load, and from the fastest rate that an effect declares. The remaining error comes from the onset
//! of contact, where δ^1.5 has no second derivative: it falls with h^2.5, whatever the order, so that a higher order
//! would not pay. RMS error in m/s² (the larger of the two channels) against
//! the reference trajectories, whose accelerations are 0.01 to 0.07 m/s² RMS:
//!
//! | steps a sample | rig A, 9 balls | rig B, 13 balls |
//! |---|---|---|
//! | 1 | 1.7e-6 to 4.0e-6 | 7.8e-6 to 1.0e-5 |
//! | 2 | 3.7e-7 to 5.5e-7 | 1.4e-6 to 1.7e-6 |
//! | **3, chosen for both** | 1.7e-7 to 2.5e-7 | 3.9e-7 to 4.7e-7 |
//! | 4 | 6.3e-8 to 9.2e-8 | 2.1e-7 to 2.8e-7 |
//! | 8 | 1.1e-8 to 2.2e-8 | 3.1e-8 to 4.6e-8 |
//! | 16 | 2.3e-9 to 3.0e-9 | 7.5e-9 to 8.7e-9 |
//!
//! # Speed
//!
//! `benches/rig.rs`, rig A at 25.6 kHz on one core of an AMD EPYC (AVX-512):
//!
//! | | s for 0.2 s | × real time | RMS error, m/s² | time, ours = 1 |
//! |---|---|---|---|---|
//! | one run | 0.0019 | 107 | 1.6e-7 | 1 |
//! | 8 runs side by side, each | 0.00037 | 541 | 1.6e-7 | 0.2 |
//! | 64 runs side by side, each | 0.00030 | 658 | 1.6e-7 | 0.16 |
//! | `ode_solvers` DOPRI5, rtol 1e-7 | 0.0094 | 21 | 5.5e-7 | 5.0 |
//! | SciPy `solve_ivp` LSODA, rtol 1e-8 | 0.63 | 0.3 | 2.9e-7 | 338 |
//! | SciPy `solve_ivp` RK45, rtol 1e-7 | 0.62 | 0.3 | 7.2e-7 | 331 |
//!
//! Eight runs take 580 ns for a sample. By count that is 12 contact forces with some 5 loaded balls each, so 60 vector
//! square roots, and about 1100 vector multiply-adds, half of them the step matrices'. Effects that act on forces or
//! contact run in plain numbers, run by run, and bring eight runs down to a third to a sixth of the nominal rig's
//! speed, one run to about half.

pub mod assembly;
pub mod batch;
pub mod bearing;
pub mod condition;
pub mod config;
pub mod effect;
mod error;
pub mod film;
pub(crate) mod noise;
pub mod plausible;
pub(crate) mod random_part;
pub mod sdof;
pub(crate) mod settings;
pub mod simulate;
#[cfg(test)]
mod simulate_tests;
pub mod state;
#[cfg(test)]
pub(crate) mod test_support;
pub mod transfer_path;

pub use condition::{OperatingCondition, Start};
pub use config::{EffectEntry, Machine, Rig, Value};
pub use error::RigError;
pub use simulate::{Run, simulate, simulate_many};
