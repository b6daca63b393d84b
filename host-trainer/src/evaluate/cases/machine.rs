//! Rigs, speeds and loads.

use crate::rig::config::ModelKey;
use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::settings::CaseSettings;
use crate::rig::OperatingCondition;
use crate::rig::config::BearingRig;
use crate::rig::simulate::bearing_of;
use crate::rig::{Rig, RigError};

/// Two machines: a bearing of 9 large balls, and one of 13 small ones.
const RIGS: [&str; 2] = [include_str!("large.toml"), include_str!("small.toml")];
const SETTINGS: CaseSettings = CaseSettings::DEFAULT;

/// Drawn machine and its operating conditions.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Healthy machine.
    pub rig: Rig,
    /// Parameters of the machine.
    pub machine: BearingRig,
    /// Operating conditions.
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

/// Draw between two numbers, uniform in the logarithm.
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
        scale(&mut rig, key, log_uniform(1.0 / SETTINGS.machine_factor, SETTINGS.machine_factor, rng));
    }
    let [least, most] = SETTINGS.unbalance_factor;
    scale(&mut rig, ModelKey::Unbalance, log_uniform(least, most, rng));
    if loud {
        scale(&mut rig, ModelKey::SensorNoise, SETTINGS.loud_sensor_factor);
        scale(&mut rig, ModelKey::ProcessForce, SETTINGS.loud_force_factor);
    }
    let ([slowest, fastest], [lightest, heaviest]) = (SETTINGS.shaft_hz, SETTINGS.load_n);
    let (shaft_hz, load_n) = (rng.random_range(slowest..fastest), log_uniform(lightest, heaviest, rng));
    let ([least, most], factors) = (SETTINGS.condition_scatter, SETTINGS.condition_factors);
    let mut conditions = Vec::new();
    for n in 0..count {
        let (speed, load) = factors[n % factors.len()];
        let mut near = |value: f64| value * rng.random_range(least..most);
        conditions.push(OperatingCondition {
            shaft_hz: rounded(near(shaft_hz * speed)),
            load_n: rounded(near(load_n * load)),
            sample_rate_hz: SETTINGS.sample_rate_hz,
            samples: (seconds * SETTINGS.sample_rate_hz).round() as usize,
        });
    }
    let machine = bearing_of(&rig.model)?;
    Ok(Drawn { rig, machine, conditions })
}

/// Value rounded to two decimals.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

fn scale(rig: &mut Rig, key: ModelKey, factor: f64) {
    if let Some(value) = rig.get(key) {
        // A positive factor keeps the value in range.
        _ = rig.set(key, value * factor);
    }
}

/// Draws masses, springs and dampers again, up to a factor from what they are.
///
/// # Errors
/// None that a positive factor can give.
pub fn widen(drawn: &mut Drawn, factor: f64, rng: &mut ChaCha8Rng) -> Result<(), RigError> {
    for key in SUPPORTS {
        scale(&mut drawn.rig, key, log_uniform(1.0 / factor, factor, rng));
    }
    drawn.machine = bearing_of(&drawn.rig.model)?;
    Ok(())
}

/// Makes guesses of a support's stiffness, a damping and the noise.
///
/// # Errors
/// None that a positive factor can give.
pub fn guess(rig: &mut Rig, rng: &mut ChaCha8Rng) -> Result<(), RigError> {
    let keys = [ModelKey::OuterStiffness, ModelKey::InnerDamping, ModelKey::SensorNoise];
    for key in keys {
        scale(rig, key, log_uniform(1.0 / SETTINGS.guess_factor, SETTINGS.guess_factor, rng));
    }
    rig.unknown = keys.map(|key| key.name().to_owned()).to_vec();
    rig.check()
}
