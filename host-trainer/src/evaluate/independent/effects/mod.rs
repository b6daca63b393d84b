//! Effects of the vocabulary in forms of their own, drawn for each case.
//!
//! A form is what a machine may do, not what the rig's effect of the same name does: the name is all that the two share. Where
//! a parameter of the vocabulary means the same in both, it is in the truth; else the truth describes the form.

mod acquisition;
mod events;
mod forces;
mod races;
mod supports;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::plant::Plant;
use super::settings::{FormSettings, StrengthSettings};
use crate::evaluate::cases::HiddenEffect;
use crate::evaluate::cases::machine::Drawn;
use crate::rig::effect::{EffectKind, ParameterKey};

pub(super) const FORMS: FormSettings = FormSettings::DEFAULT;

/// What the draw of an effect may know of the machine.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// Machine and conditions.
    pub drawn: &'a Drawn,
    /// RMS of the healthy recordings in `ax` and `ay`, without the mean, m/s².
    pub rms: [f64; 2],
    /// Healthy recordings' sizes in `ax` and `ay`, ascending, m/s².
    pub sizes: [&'a [f64]; 2],
    /// Recordings of the case.
    pub recordings: usize,
    /// Place in the range of strengths, 0 to 1.
    pub share: f64,
}

impl Context<'_> {
    /// Number of a range by the case's severity, in the logarithm.
    pub fn by_severity(&self, [low, high]: [f64; 2]) -> f64 {
        low * (high / low).powf(self.share)
    }

    /// Length of a recording, s.
    pub fn seconds(&self) -> f64 {
        self.drawn.seconds()
    }

    /// Time of an event, s.
    pub fn time_s(&self, rng: &mut ChaCha8Rng) -> f64 {
        self.seconds() * within(FORMS.event_at, rng)
    }
}

/// How strong an effect is made.
#[derive(Clone, Debug, PartialEq)]
pub enum Strength {
    /// By a number that is drawn.
    Fixed,
    /// By what it changes over whole recordings; between two limits.
    Lasting([f64; 2]),
    /// By what it changes after its time in each recording, s; between two limits.
    Event([f64; 2], Vec<f64>),
}

/// Puts an effect of a strength into the machine of a recording.
pub type Apply = Box<dyn Fn(f64, usize, &mut Plant)>;
/// Truth about an effect of a strength.
pub type Told = Box<dyn Fn(f64) -> Vec<HiddenEffect>>;

/// A drawn effect, before its strength.
pub struct Effect {
    /// Name.
    pub kind: EffectKind,
    /// How strong it is made.
    pub strength: Strength,
    /// Whether each recording has it.
    pub present: Vec<bool>,
    /// Puts it into a machine.
    pub apply: Apply,
    /// Truth about it.
    pub told: Told,
    /// Another name of the same physics.
    pub accept: Option<EffectKind>,
}

impl Effect {
    fn new(
        kind: EffectKind,
        context: &Context,
        strength: Strength,
        apply: impl Fn(f64, usize, &mut Plant) + 'static,
        told: impl Fn(f64) -> HiddenEffect + 'static,
    ) -> Self {
        let told = Box::new(move |strength| vec![told(strength)]);
        let present = vec![true; context.recordings];
        Self { kind, strength, present, apply: Box::new(apply), told, accept: None }
    }

    fn in_some(mut self, present: Vec<bool>) -> Self {
        self.present = present;
        self
    }

    fn accepting(mut self, kind: Option<EffectKind>) -> Self {
        self.accept = kind;
        self
    }
}

/// Draws the form of an effect.
pub fn draw(kind: EffectKind, context: &Context, rng: &mut ChaCha8Rng) -> Effect {
    match kind {
        EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect => {
            races::pit(kind, context, rng)
        }
        EffectKind::OuterRaceWaviness | EffectKind::InnerRaceWaviness => races::waviness(kind, context, rng),
        EffectKind::ExcessClearance | EffectKind::LubricantFilm => races::clearance(kind, context),
        EffectKind::ContactExponent => races::exponent(context, rng),
        EffectKind::Unbalance => forces::unbalance(context, rng),
        EffectKind::Misalignment => forces::misalignment(context, rng),
        EffectKind::ConstantForce => forces::constant(context, rng),
        EffectKind::RandomForce => forces::random(context, rng),
        EffectKind::SpeedDrift => forces::drift(context, rng),
        EffectKind::CageSlip => forces::slip(context),
        EffectKind::StructuralResonance => forces::resonance(context, rng),
        EffectKind::LoadStep => events::load_step(context, rng),
        EffectKind::Shock => events::shock(context, rng),
        EffectKind::DroppedSamples => events::dropped(context, rng),
        EffectKind::HardeningStiffness | EffectKind::SofteningStiffness => supports::cubic(kind, context, rng),
        EffectKind::AsymmetricStiffness => supports::quadratic(context, rng),
        EffectKind::StiffnessChange | EffectKind::DampingChange | EffectKind::MassChange => {
            supports::linear(kind, context, rng)
        }
        EffectKind::CoulombFriction => supports::friction(context, rng),
        EffectKind::ViscousFriction => supports::viscous(context, rng),
        EffectKind::QuadraticDrag => supports::drag(context, rng),
        EffectKind::EndStopContact => supports::stop(context, rng),
        EffectKind::Backlash => supports::backlash(context, rng),
        EffectKind::MainsInterference => acquisition::mains(context, rng),
        EffectKind::SensorBias => acquisition::bias(context, rng),
        EffectKind::SensorGain => acquisition::gain(context, rng),
        EffectKind::TransverseSensitivity => acquisition::transverse(context, rng),
        EffectKind::SensorClipping => acquisition::clipping(context, rng),
    }
}

/// Target of a strength's measure by severity, for what is reached by simulation.
pub fn target(strength: &Strength, context: &Context) -> Option<f64> {
    let settings = StrengthSettings::DEFAULT;
    match strength {
        Strength::Fixed => None,
        Strength::Lasting(_) => Some(context.by_severity(settings.lasting)),
        Strength::Event(..) => Some(context.by_severity(settings.event)),
    }
}

/// Truth about an effect: parameters that mean what the vocabulary's do, a component or channel, and the form in words.
fn truth(
    kind: EffectKind,
    numbers: &[(ParameterKey, f64)],
    at: Option<(ParameterKey, &str)>,
    form: &str,
) -> HiddenEffect {
    HiddenEffect {
        name: kind.to_string(),
        numbers: numbers.iter().map(|(key, value)| (key.to_string(), *value)).collect(),
        names: at.iter().map(|(key, name)| (key.to_string(), (*name).to_owned())).collect(),
        form: form.to_owned(),
        recordings: Vec::new(),
    }
}

/// Uniform draw from a range.
pub fn within([low, high]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(low..high)
}

/// Draw from a range, uniform in the logarithm.
pub fn log_within([low, high]: [f64; 2], rng: &mut ChaCha8Rng) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

/// One or the other sign.
fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<bool>() { 1.0 } else { -1.0 }
}

/// Draws one of a list.
fn one_of<T: Copy>(list: &[T], rng: &mut ChaCha8Rng) -> T {
    list[rng.random_range(0..list.len())]
}

/// Draws the recordings that have an event: mostly one or two, sometimes all.
fn some(recordings: usize, rng: &mut ChaCha8Rng) -> Vec<bool> {
    let count = match rng.random_range(0..10) {
        0..5 => 1,
        5..8 => 2,
        8 => 3,
        _ => recordings,
    };
    let mut present = vec![false; recordings];
    for _ in 0..count.min(recordings) {
        let absent: Vec<usize> = (0..recordings).filter(|n| !present[*n]).collect();
        if !absent.is_empty() {
            present[one_of(&absent, rng)] = true;
        }
    }
    present
}
