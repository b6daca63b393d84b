//! Rigs, speeds and loads.

use crate::rig::config::ModelKey;
use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::rig::OperatingCondition;
use crate::rig::config::BearingRig;
use crate::rig::simulate::bearing_of;
use crate::rig::{Rig, RigError};

/// Two machines: a bearing of 9 large balls, and one of 13 small ones.
const RIGS: [&str; 2] = [include_str!("large.toml"), include_str!("small.toml")];
const SAMPLE_RATE_HZ: f64 = 25_600.0;
/// Of all masses, springs and dampers, the largest factor by which a drawn machine differs from those.
const OTHER: f64 = 1.25;
/// What is guessed is wrong by this factor at most.
const WRONG: f64 = 1.2;

/// A machine and the conditions that it is recorded under.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// The machine as it is when nothing is the matter.
    pub rig: Rig,
    /// Its parameters.
    pub machine: BearingRig,
    /// Conditions.
    pub conditions: Vec<OperatingCondition>,
}

impl Drawn {
    /// Load of the first recording, N.
    pub fn load_n(&self) -> f64 {
        self.conditions[0].load_n
    }

    /// Length of a recording, s.
    pub fn seconds(&self) -> f64 {
        self.conditions[0].samples as f64 / self.conditions[0].sample_rate_hz
    }

    /// Deflection of the two supports under the load, m.
    pub fn static_m(&self) -> f64 {
        self.load_n() / (self.machine.inner.stiffness_n_per_m + self.machine.outer.stiffness_n_per_m)
    }

    /// Deflection of the most loaded contact, m.
    pub fn contact_m(&self) -> f64 {
        let bearing = &self.machine.bearing;
        (self.load_n() / bearing.contact_stiffness_n_per_m1_5).powf(1.0 / bearing.contact_exponent)
    }

    /// Natural frequency of the outer race on its support, Hz.
    pub fn outer_hz(&self) -> f64 {
        (self.machine.outer.stiffness_n_per_m / self.machine.outer.mass_kg).sqrt() / TAU
    }
}

/// Evenly in the logarithm.
pub fn log_uniform(from: f64, to: f64, rng: &mut ChaCha8Rng) -> f64 {
    from * (to / from).powf(rng.random::<f64>())
}

/// Numbers of the supports, each drawn by itself.
const SUPPORTS: [ModelKey; 9] = [
    ModelKey::InnerMass,
    ModelKey::InnerStiffness,
    ModelKey::InnerDamping,
    ModelKey::OuterMass,
    ModelKey::OuterStiffness,
    ModelKey::OuterDamping,
    ModelKey::ResonatorMass,
    ModelKey::ResonatorStiffness,
    ModelKey::ResonatorDamping,
];

/// Draws a machine and its conditions.
///
/// # Errors
/// None, as long as the two files are rigs.
pub fn draw(loud: bool, seconds: f64, count: usize, rng: &mut ChaCha8Rng) -> Result<Drawn, RigError> {
    let text = RIGS[usize::from(rng.random::<bool>())];
    let mut rig = Rig::parse(text, std::path::Path::new("rig.toml"))?;
    for key in SUPPORTS {
        scale(&mut rig, key, log_uniform(1.0 / OTHER, OTHER, rng));
    }
    scale(&mut rig, ModelKey::Unbalance, log_uniform(0.5, 2.0, rng));
    if loud {
        scale(&mut rig, ModelKey::SensorNoise, 4.0);
        scale(&mut rig, ModelKey::ProcessForce, 10.0);
    }
    let (shaft_hz, load_n) = (rng.random_range(18.0..42.0), log_uniform(350.0, 1800.0, rng));
    let factors = [(1.0, 1.0), (0.9, 0.7), (1.1, 1.3), (1.0, 1.15)];
    let mut conditions = Vec::new();
    for n in 0..count {
        let (speed, load) = factors[n % factors.len()];
        let mut near = |value: f64| value * rng.random_range(0.97..1.03);
        conditions.push(OperatingCondition {
            shaft_hz: rounded(near(shaft_hz * speed)),
            load_n: rounded(near(load_n * load)),
            sample_rate_hz: SAMPLE_RATE_HZ,
            samples: (seconds * SAMPLE_RATE_HZ).round() as usize,
        });
    }
    let machine = bearing_of(&rig.model)?;
    Ok(Drawn { rig, machine, conditions })
}

/// As an engineer writes it down.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn scale(rig: &mut Rig, key: ModelKey, factor: f64) {
    if let Some(value) = rig.get(key) {
        // A positive number stays one.
        _ = rig.set(key, value * factor);
    }
}

/// Makes guesses of a support's stiffness, a damping and the noise.
///
/// # Errors
/// None that a positive factor can give.
pub fn guess(rig: &mut Rig, rng: &mut ChaCha8Rng) -> Result<(), RigError> {
    let keys = [ModelKey::OuterStiffness, ModelKey::InnerDamping, ModelKey::SensorNoise];
    for key in keys {
        scale(rig, key, log_uniform(1.0 / WRONG, WRONG, rng));
    }
    rig.unknown = keys.map(|key| key.name().to_owned()).to_vec();
    rig.check()
}
