//! Hypotheses: every effect of the vocabulary that a bearing rig can have, with starts of its search.
//!
//! Sizes follow from the rig: a defect's depth from the contact's deflection, a spring's curvature from its static
//! deflection. Effects with a time or frequency of their own start at [`InitialGuesses`] from the residual.

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

use crate::rig::config::{BearingRig, Machine};
use crate::rig::effect::component::Component;
use crate::rig::{EffectEntry, Rig};

/// Start of a search.
#[derive(Clone, Debug)]
pub struct Start {
    /// Effect with its start values.
    pub effect: EffectEntry,
    /// Parameters that are fitted; the first that is no time is the strength.
    pub free: &'static [ParameterKey],
    /// Strength at which the effect vanishes.
    pub nothing: f64,
    /// Samples by which each recording of the subset leads the rig without the effect, if known.
    pub leads: Option<Vec<i64>>,
}

impl Start {
    /// Numeric parameter of the effect; 0 if absent.
    pub fn number(&self, key: ParameterKey) -> f64 {
        self.effect.number(key).unwrap_or_default()
    }

    /// Whether the effect has a time.
    pub fn is_timed(&self) -> bool {
        self.effect.parameters.contains_key(&ParameterKey::TimeS)
    }

    /// Start rotated on the shaft, if the effect is fixed to the shaft.
    #[must_use]
    pub fn turned_on_shaft(&self, by_rad: f64) -> Self {
        let effect = self.effect.turned_on_shaft(by_rad).unwrap_or_else(|| self.effect.clone());
        Self { effect, ..self.clone() }
    }

    /// Whether the effect is a local defect.
    pub fn is_pit(&self) -> bool {
        matches!(self.effect.kind, EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect)
    }

    /// Whether the effect is a structural resonance.
    pub fn is_mode(&self) -> bool {
        self.effect.kind == EffectKind::StructuralResonance
    }

    /// Key of the strength; times and rates are none.
    pub fn strength(&self) -> Option<ParameterKey> {
        let rates = [ParameterKey::TimeS, ParameterKey::Fraction, ParameterKey::RatePerS];
        self.free.iter().copied().find(|key| !rates.contains(key))
    }

    /// Start with its strength scaled by a fiftieth to fifty; a negative factor turns the phase by π.
    pub fn scaled(&self, by: f64) -> Option<Self> {
        let key = self.strength().filter(|_| (0.02..50.0).contains(&by.abs()))?;
        let scaled = self.with(key, self.nothing + (self.number(key) - self.nothing) * by.abs());
        if by > 0.0 {
            return Some(scaled);
        }
        Some(scaled.with(ParameterKey::PhaseRad, self.effect.number(ParameterKey::PhaseRad)? + PI))
    }

    /// Start with another value of a parameter.
    #[must_use]
    pub fn with(&self, key: ParameterKey, value: f64) -> Self {
        Self { effect: self.effect.clone().with_number(key, value), ..self.clone() }
    }
}

/// Hypothesis: an effect, at one component or channel if it has one.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Effect.
    pub kind: EffectKind,
    /// Component, channel or lobes such as `outer`, `ay`, `5 lobes`; empty if there is no choice.
    pub place: String,
    /// Starts of the search, at least one.
    pub starts: Vec<Start>,
}

impl Hypothesis {
    /// Whether initial angles must be fitted anew: effects that rotate with the shaft, of which the null model knows little,
    /// defects, whose pulses outweigh the ball passes, and effects that change the rotation.
    pub fn has_angles_of_its_own(&self) -> bool {
        self.starts.iter().any(Start::is_pit)
            || [EffectKind::InnerRaceWaviness, EffectKind::CageSlip, EffectKind::SpeedDrift].contains(&self.kind)
    }

    /// Whether the effect must be sought in whole recordings, as beginnings may miss it or are too short.
    pub fn needs_whole_recordings(&self) -> bool {
        [
            EffectKind::LoadStep,
            EffectKind::Shock,
            EffectKind::DroppedSamples,
            EffectKind::SpeedDrift,
            EffectKind::CageSlip,
        ]
        .contains(&self.kind)
    }
}

/// Start values from the residual of the nominal rig.
#[derive(Clone, Debug, Default)]
pub struct InitialGuesses {
    /// Frequencies at which the residual's power rises above its surroundings, Hz, highest first.
    pub resonances_hz: Vec<f64>,
    /// Times at which the residual changes or has its greatest burst, s.
    pub times_s: Vec<f64>,
    /// Gap where samples may be missing.
    pub gap: Option<Gap>,
    /// Fractions by which the cage may be slow.
    pub slips: Vec<f64>,
    /// Rates at which the speed may drift, 1/s.
    pub drifts_per_s: Vec<f64>,
}

/// Samples that may be missing in all recordings.
#[derive(Clone, Debug)]
pub struct Gap {
    /// Time of the gap, s.
    pub time_s: f64,
    /// Count of missing samples.
    pub count: f64,
    /// Samples by which each recording leads its prediction.
    pub leads: Vec<i64>,
}

/// Sizes that the rig split.
struct Sizes {
    load: f64,
    /// Deflection of the most loaded contact, m.
    contact: f64,
    /// Static deflection of either support, m.
    support: f64,
}

impl Sizes {
    fn new(rig: &BearingRig, load_n: f64) -> Self {
        let contact =
            (load_n.abs() / rig.bearing.contact_stiffness_n_per_m1_5).powf(1.0 / rig.bearing.contact_exponent);
        // Both springs carry the load together, as far apart as the contact lets them be.
        let support = load_n.abs() / (rig.inner.stiffness_n_per_m + rig.outer.stiffness_n_per_m).max(1.0);
        Self { load: load_n.abs().max(1.0), contact, support }
    }
}

struct Builder {
    out: Vec<Hypothesis>,
}

impl Builder {
    fn add(
        &mut self,
        kind: EffectKind,
        place: impl Into<String>,
        free: &'static [ParameterKey],
        effects: Vec<EffectEntry>,
    ) {
        self.add_from(0.0, kind, place, free, effects);
    }

    /// Of an effect that does nothing at a strength other than 0.
    fn add_from(
        &mut self,
        nothing: f64,
        kind: EffectKind,
        place: impl Into<String>,
        free: &'static [ParameterKey],
        effects: Vec<EffectEntry>,
    ) {
        let starts = effects.into_iter().map(|effect| Start { effect, free, nothing, leads: None }).collect();
        self.add_starts(kind, place.into(), starts);
    }

    fn add_starts(&mut self, kind: EffectKind, place: String, starts: Vec<Start>) {
        if !starts.is_empty() {
            self.out.push(Hypothesis { kind, place, starts });
        }
    }
}

/// Phases that are tried, rad; half a turn on is the other way round, which [`Start::scaled`] comes to.
const PHASES: [f64; 3] = [0.0, FRAC_PI_3, 2.0 * FRAC_PI_3];

/// As many numbers from one to another, evenly in the logarithm.
fn ladder(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..count).map(|k| from * (to / from).powf(f64::from(k) / f64::from(count - 1))).collect()
}

/// The same with both signs.
fn both_ways(from: f64, to: f64, count: u32) -> Vec<f64> {
    ladder(from, to, count).into_iter().flat_map(|v| [v, -v]).collect()
}

fn entry(kind: EffectKind, numbers: &[(ParameterKey, f64)]) -> EffectEntry {
    EffectEntry::new(kind, numbers)
}

/// All hypotheses for a rig under a load, N.
pub fn all(rig: &Rig, load_n: f64, guesses: &InitialGuesses) -> Vec<Hypothesis> {
    let Some(machine) = rig.bearing() else { return Vec::new() };
    let sizes = Sizes::new(machine, load_n);
    let mut b = Builder { out: Vec::new() };
    pits(&mut b, &sizes);
    races(&mut b, machine, &sizes);
    springs(&mut b, machine, &sizes);
    linear(&mut b, machine);
    dissipation(&mut b, machine, &sizes);
    in_time(&mut b, &sizes, guesses);
    sensors(&mut b, guesses);
    b.out
}

fn pits(b: &mut Builder, sizes: &Sizes) {
    let depths = [0.06, 0.3].map(|share| share * sizes.contact);
    let widths = [0.025, 0.06, 0.14];
    let grid = |kind: EffectKind, key: ParameterKey, angles: &[f64]| -> Vec<EffectEntry> {
        let of = |depth, width, angle| {
            entry(kind, &[(ParameterKey::DepthM, depth), (ParameterKey::WidthRad, width), (key, angle)])
        };
        let depths = depths.iter();
        depths.flat_map(|d| widths.iter().flat_map(move |w| angles.iter().map(move |a| of(*d, *w, *a)))).collect()
    };
    let down = FRAC_PI_2;
    let angles: Vec<f64> = (-4..=4).map(|k| down + 0.2 * f64::from(k)).collect();
    let outer = grid(EffectKind::OuterRaceDefect, ParameterKey::AngleRad, &angles);
    b.add(
        EffectKind::OuterRaceDefect,
        "",
        &[ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::AngleRad],
        outer,
    );
    b.add(
        EffectKind::InnerRaceDefect,
        "",
        &[ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::AngleRad],
        grid(EffectKind::InnerRaceDefect, ParameterKey::AngleRad, &[0.0]),
    );
    // The angles that are sought bring its spin with them.
    b.add(
        EffectKind::BallDefect,
        "",
        &[ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::SpinRad],
        grid(EffectKind::BallDefect, ParameterKey::SpinRad, &[0.0]),
    );
}

fn races(b: &mut Builder, rig: &BearingRig, sizes: &Sizes) {
    // The inner race's phase is the shaft's angle, which is sought.
    for (kind, phases) in [(EffectKind::OuterRaceWaviness, PHASES.as_slice()), (EffectKind::InnerRaceWaviness, &[0.0])]
    {
        for lobes in 2..=(2 * rig.bearing.balls + 3) {
            let of = |share: f64, phase: f64| {
                let amplitude = share * sizes.contact;
                entry(
                    kind,
                    &[
                        (ParameterKey::AmplitudeM, amplitude),
                        (ParameterKey::Lobes, lobes as f64),
                        (ParameterKey::PhaseRad, phase),
                    ],
                )
            };
            let starts = phases.iter().map(|phase| of(0.03, *phase)).collect();
            b.add(kind, format!("{lobes} lobes"), &[ParameterKey::AmplitudeM, ParameterKey::PhaseRad], starts);
        }
    }
    let unbalance = rig.excitation.unbalance_kg_m.max(1e-5);
    let of = |factor: f64| entry(EffectKind::Unbalance, &[(ParameterKey::UnbalanceKgM, factor * unbalance)]);
    let nominal = rig.excitation.unbalance_kg_m;
    b.add_from(nominal, EffectKind::Unbalance, "", &[ParameterKey::UnbalanceKgM], [0.3, 2.5, 10.0].map(of).to_vec());
    let of = |phase: f64| {
        entry(EffectKind::Misalignment, &[(ParameterKey::ForceN, 0.03 * sizes.load), (ParameterKey::PhaseRad, phase)])
    };
    b.add(EffectKind::Misalignment, "", &[ParameterKey::ForceN, ParameterKey::PhaseRad], PHASES.map(of).to_vec());
    let clearance = rig.bearing.radial_clearance_m;
    let of = |more: f64| {
        entry(EffectKind::ExcessClearance, &[(ParameterKey::RadialClearanceM, clearance + more * sizes.contact)])
    };
    // Waveforms differ from one twentieth of it to the next.
    let starts = ladder(0.03, 4.0, 100).into_iter().map(of).collect();
    b.add_from(clearance, EffectKind::ExcessClearance, "", &[ParameterKey::RadialClearanceM], starts);
    let exponent = rig.bearing.contact_exponent;
    let of = |by: f64| entry(EffectKind::ContactExponent, &[(ParameterKey::Exponent, exponent + by)]);
    let starts = both_ways(0.004, 0.15, 5).into_iter().map(of).collect();
    b.add_from(exponent, EffectKind::ContactExponent, "", &[ParameterKey::Exponent], starts);
}

fn springs(b: &mut Builder, rig: &BearingRig, sizes: &Sizes) {
    let static_m = sizes.support;
    for (component, support) in [("inner", &rig.inner), ("outer", &rig.outer)] {
        let k = support.stiffness_n_per_m;
        if k <= 0.0 || static_m <= 0.0 {
            continue;
        }
        // A share of the spring's slope at its static deflection.
        let cubic = |share: f64| share * k / (3.0 * static_m * static_m);
        let of = |kind: EffectKind, key: ParameterKey, value: f64| {
            entry(kind, &[(key, value)]).with_text(ParameterKey::Component, component)
        };
        let hard = |s| of(EffectKind::HardeningStiffness, ParameterKey::CubicNPerM3, cubic(s));
        let hard = ladder(0.02, 3.0, 7).into_iter().map(hard).collect();
        b.add(EffectKind::HardeningStiffness, component, &[ParameterKey::CubicNPerM3], hard);
        let soft = |s| of(EffectKind::SofteningStiffness, ParameterKey::CubicNPerM3, -cubic(s));
        let soft = ladder(0.02, 0.5, 6).into_iter().map(soft).collect();
        b.add(EffectKind::SofteningStiffness, component, &[ParameterKey::CubicNPerM3], soft);
        let square = |share: f64| share * k / (2.0 * static_m);
        let skew = |s| of(EffectKind::AsymmetricStiffness, ParameterKey::QuadraticNPerM2, square(s));
        let skew = both_ways(0.02, 0.6, 5).into_iter().map(skew).collect();
        b.add(EffectKind::AsymmetricStiffness, component, &[ParameterKey::QuadraticNPerM2], skew);
        let of = |share: f64| {
            entry(EffectKind::Backlash, &[(ParameterKey::WidthM, share * 2.0 * static_m)])
                .with_text(ParameterKey::Component, component)
        };
        b.add(
            EffectKind::Backlash,
            component,
            &[ParameterKey::WidthM],
            ladder(0.03, 1.2, 7).into_iter().map(of).collect(),
        );
        let vertical = if component == "inner" { "inner-y" } else { "outer-y" };
        let of = |gap: f64, stiffer: f64| {
            entry(
                EffectKind::EndStopContact,
                &[(ParameterKey::GapM, gap * static_m), (ParameterKey::StiffnessNPerM, stiffer * k)],
            )
            .with_text(ParameterKey::Component, vertical)
        };
        // Whether it is met depends on the load: finely between the least and the greatest.
        let gaps = (8..=26).map(|k| 0.05 * f64::from(k));
        let stops = gaps.flat_map(|gap| [0.05, 0.4, 3.0].map(|s| of(gap, s)));
        b.add(
            EffectKind::EndStopContact,
            vertical,
            &[ParameterKey::StiffnessNPerM, ParameterKey::GapM],
            stops.collect(),
        );
    }
    // On the housing it does the same, k_outer/k_inner times as great and the other way: the springs are straight.
    let of = |share: f64| {
        entry(EffectKind::ConstantForce, &[(ParameterKey::ForceN, share * sizes.load)])
            .with_text(ParameterKey::Component, "inner-y")
    };
    b.add(
        EffectKind::ConstantForce,
        "inner-y",
        &[ParameterKey::ForceN],
        both_ways(0.01, 0.4, 5).into_iter().map(of).collect(),
    );
}

fn linear(b: &mut Builder, rig: &BearingRig) {
    let contact = rig.bearing.contact_stiffness_n_per_m1_5;
    let factors = |logs: Vec<f64>| -> Vec<f64> { logs.into_iter().map(f64::exp).collect() };
    let (small, large) = (factors(both_ways(0.02, 0.5, 5)), factors(both_ways(0.1, 1.6, 4)));
    let sections = [
        ("inner", Some(&rig.inner)),
        ("outer", Some(&rig.outer)),
        ("resonator", Some(&rig.resonator)),
        ("bearing", None),
    ];
    for (component, support) in sections {
        let mut change = |kind: EffectKind, nominal: f64, factors: &[f64]| {
            let of = |f: &f64| {
                entry(kind, &[(ParameterKey::Value, f * nominal)]).with_text(ParameterKey::Component, component)
            };
            if nominal > 0.0 {
                b.add_from(nominal, kind, component, &[ParameterKey::Value], factors.iter().map(of).collect());
            }
        };
        change(EffectKind::StiffnessChange, support.map_or(contact, |s| s.stiffness_n_per_m), &small);
        if let Some(support) = support {
            change(EffectKind::DampingChange, support.damping_n_s_per_m, &large);
            change(EffectKind::MassChange, support.mass_kg, &small);
        }
    }
}

/// Rate of dry friction near standstill that is simulated, 1/s: no faster than a few steps a sample follow.
const FASTEST_FRICTION_PER_S: f64 = 1e5;
/// The same at a first look, where one step a sample must do.
const FAST_FRICTION_PER_S: f64 = 3e4;
/// Speed at which dry friction is rounded at least, m/s: far below what a housing vibrates at.
const SHARPEST_M_PER_S: f64 = 2e-6;

/// Effect with dry friction as sharp at rest as can be simulated with its force; any other effect unchanged.
pub fn sharpened(rig: &BearingRig, effect: EffectEntry) -> EffectEntry {
    match rounded_at(rig, &effect, FASTEST_FRICTION_PER_S) {
        Some(speed) => effect.with_number(ROUNDED, speed),
        None => effect,
    }
}

/// Rig with dry friction no sharper than screening needs.
pub fn softened(rig: &Rig) -> Rig {
    let mut soft = rig.clone();
    let Some(machine) = rig.bearing() else { return soft };
    for effect in &mut soft.effects {
        let needed = rounded_at(machine, effect, FAST_FRICTION_PER_S);
        if let Some(speed) = needed.filter(|speed| effect.number(ROUNDED).is_none_or(|own| *speed > own)) {
            *effect = effect.clone().with_number(ROUNDED, speed);
        }
    }
    soft
}

/// The parameter of dry friction that rounds its step.
const ROUNDED: ParameterKey = ParameterKey::RegularisationMPerS;

/// The speed at which dry friction changes at that rate at rest; nothing of another effect.
fn rounded_at(rig: &BearingRig, effect: &EffectEntry, rate_per_s: f64) -> Option<f64> {
    if effect.kind != EffectKind::CoulombFriction {
        return None;
    }
    let component = effect.text(ParameterKey::Component).and_then(Component::parse).unwrap_or(Component::Outer);
    let mass_kg = component.part_of(&Machine::Bearing(rig.clone())).mass;
    let speed = effect.number(ParameterKey::ForceN).unwrap_or_default() / (mass_kg * rate_per_s);
    Some(speed.max(SHARPEST_M_PER_S))
}

fn dissipation(b: &mut Builder, rig: &BearingRig, sizes: &Sizes) {
    for component in ["outer", "inner", "resonator"] {
        let of = |share: f64| {
            let entry = entry(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, share * sizes.load)]);
            sharpened(rig, entry.with_text(ParameterKey::Component, component))
        };
        b.add(
            EffectKind::CoulombFriction,
            component,
            &[ParameterKey::ForceN],
            ladder(1e-4, 2e-2, 5).into_iter().map(of).collect(),
        );
        let damping = match component {
            "outer" => rig.outer.damping_n_s_per_m,
            "inner" => rig.inner.damping_n_s_per_m,
            _ => rig.resonator.damping_n_s_per_m,
        };
        if component != "resonator" {
            // As strong as the damper at 0.1 to 10 mm/s.
            let of = |speed: f64| {
                entry(EffectKind::QuadraticDrag, &[(ParameterKey::DragNS2PerM2, damping.max(1.0) / speed)])
                    .with_text(ParameterKey::Component, component)
            };
            b.add(
                EffectKind::QuadraticDrag,
                component,
                &[ParameterKey::DragNS2PerM2],
                ladder(1e-2, 1e-4, 5).into_iter().map(of).collect(),
            );
        }
        if damping == 0.0 {
            let of = |c: f64| {
                entry(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, c)])
                    .with_text(ParameterKey::Component, component)
            };
            b.add(
                EffectKind::ViscousFriction,
                component,
                &[ParameterKey::DampingNSPerM],
                [10.0, 300.0].map(of).to_vec(),
            );
        }
    }
    let of = |c: f64| {
        entry(EffectKind::ViscousFriction, &[(ParameterKey::DampingNSPerM, c)])
            .with_text(ParameterKey::Component, "bearing")
    };
    b.add(
        EffectKind::ViscousFriction,
        "bearing",
        &[ParameterKey::DampingNSPerM],
        ladder(20.0, 3000.0, 7).into_iter().map(of).collect(),
    );
}

fn in_time(b: &mut Builder, sizes: &Sizes, guesses: &InitialGuesses) {
    let of = |(time, share): (f64, f64)| {
        entry(
            EffectKind::LoadStep,
            &[(ParameterKey::TimeS, time), (ParameterKey::ChangeN, share * sizes.load), (ParameterKey::RiseS, 4e-5)],
        )
    };
    let times = guesses.times_s.iter().flat_map(|t| [-0.3, -0.1, 0.1, 0.3].map(|share| (*t, share)));
    b.add(
        EffectKind::LoadStep,
        "",
        &[ParameterKey::TimeS, ParameterKey::ChangeN, ParameterKey::RiseS],
        times.map(of).collect(),
    );
    let gap = |Gap { time_s, count, leads }: &Gap| Start {
        effect: entry(EffectKind::DroppedSamples, &[(ParameterKey::TimeS, *time_s), (ParameterKey::Count, *count)]),
        free: &[],
        nothing: 0.0,
        leads: Some(leads.clone()),
    };
    b.add_starts(EffectKind::DroppedSamples, String::new(), guesses.gap.iter().map(gap).collect());
    let of = |(time, impulse): (f64, f64)| {
        entry(
            EffectKind::Shock,
            &[(ParameterKey::TimeS, time), (ParameterKey::ImpulseNS, impulse), (ParameterKey::DurationS, 2e-4)],
        )
    };
    let times = guesses.times_s.iter().flat_map(|t| [1e-3, 1e-2, 0.1].map(|impulse| (t - 1e-4, impulse)));
    b.add(
        EffectKind::Shock,
        "",
        &[ParameterKey::TimeS, ParameterKey::ImpulseNS, ParameterKey::DurationS],
        times.map(of).collect(),
    );
    b.add(
        EffectKind::CageSlip,
        "",
        &[ParameterKey::Fraction],
        guesses.slips.iter().map(|f| entry(EffectKind::CageSlip, &[(ParameterKey::Fraction, *f)])).collect(),
    );
    b.add(
        EffectKind::SpeedDrift,
        "",
        &[ParameterKey::RatePerS],
        guesses.drifts_per_s.iter().map(|r| entry(EffectKind::SpeedDrift, &[(ParameterKey::RatePerS, *r)])).collect(),
    );
}

fn sensors(b: &mut Builder, guesses: &InitialGuesses) {
    // Where the residual stands out, and a grid for what it does not show.
    let grid = ladder(300.0, 9000.0, 18).into_iter().map(|hz| (hz, 0.04));
    let pointed = guesses.resonances_hz.iter().flat_map(|hz| [(*hz, 0.01), (*hz, 0.03), (*hz, 0.1)]);
    let modes = pointed.chain(grid).flat_map(|(hz, ratio)| [3.0, -3.0].map(|gain| (hz, ratio, gain)));
    let mode = |(hz, ratio, gain)| {
        entry(
            EffectKind::StructuralResonance,
            &[(ParameterKey::Gain, gain), (ParameterKey::FrequencyHz, hz), (ParameterKey::DampingRatio, ratio)],
        )
    };
    b.add(
        EffectKind::StructuralResonance,
        "ay",
        &[ParameterKey::Gain, ParameterKey::FrequencyHz, ParameterKey::DampingRatio],
        modes.map(mode).collect(),
    );
    let all = |v: f64| entry(EffectKind::SensorGain, &[(ParameterKey::Value, v)]);
    b.add_from(1.0, EffectKind::SensorGain, "all", &[ParameterKey::Value], [0.5, 0.8, 1.25, 2.0].map(all).to_vec());
    for channel in ["ax", "ay"] {
        let of = |kind: EffectKind, value: f64| {
            entry(kind, &[(ParameterKey::Value, value)]).with_text(ParameterKey::Channel, channel)
        };
        b.add_from(
            1.0,
            EffectKind::SensorGain,
            channel,
            &[ParameterKey::Value],
            [0.5, 0.8, 1.25, 2.0].map(|v| of(EffectKind::SensorGain, v)).to_vec(),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::nominal;

    /// Part of the diagnosis of a bearing rig that seeks an effect.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum SoughtBy {
        /// The likelihood: `all` has hypotheses of the effect.
        Likelihood,
        /// The tests of the samples themselves, `diagnose::acquisition`.
        Acquisition,
    }

    /// Part of the diagnosis that seeks an effect. The match is exhaustive, so that no effect is silently never sought.
    fn sought_by(kind: EffectKind) -> SoughtBy {
        match kind {
            EffectKind::OuterRaceDefect
            | EffectKind::InnerRaceDefect
            | EffectKind::BallDefect
            | EffectKind::OuterRaceWaviness
            | EffectKind::InnerRaceWaviness
            | EffectKind::Unbalance
            | EffectKind::Misalignment
            | EffectKind::ExcessClearance
            | EffectKind::HardeningStiffness
            | EffectKind::SofteningStiffness
            | EffectKind::AsymmetricStiffness
            | EffectKind::StiffnessChange
            | EffectKind::DampingChange
            | EffectKind::MassChange
            | EffectKind::CoulombFriction
            | EffectKind::ViscousFriction
            | EffectKind::QuadraticDrag
            | EffectKind::EndStopContact
            | EffectKind::Backlash
            | EffectKind::ConstantForce
            | EffectKind::StructuralResonance
            | EffectKind::LoadStep
            | EffectKind::SpeedDrift
            | EffectKind::Shock
            | EffectKind::CageSlip
            | EffectKind::ContactExponent
            | EffectKind::SensorGain
            | EffectKind::DroppedSamples => SoughtBy::Likelihood,
            EffectKind::MainsInterference | EffectKind::SensorBias | EffectKind::SensorClipping => {
                SoughtBy::Acquisition
            }
        }
    }

    #[test]
    fn invariant_every_effect_has_hypotheses_where_the_likelihood_seeks_it() {
        let gap = Gap { time_s: 0.1, count: 10.0, leads: Vec::new() };
        let guesses = InitialGuesses {
            times_s: vec![0.1],
            resonances_hz: vec![2000.0],
            slips: vec![0.01],
            drifts_per_s: vec![0.01],
            gap: Some(gap),
        };
        let sought: Vec<_> = all(&nominal(), 500.0, &guesses).iter().map(|h| h.kind).collect();
        for kind in EffectKind::ALL {
            assert_eq!(sought.contains(kind), sought_by(*kind) == SoughtBy::Likelihood, "{kind}");
        }
    }

    fn friction(force_n: f64, speed: f64) -> EffectEntry {
        EffectEntry::new(EffectKind::CoulombFriction, &[(ParameterKey::ForceN, force_n), (ROUNDED, speed)])
            .with_text(ParameterKey::Component, "outer")
    }

    #[test]
    fn what_has_a_phase_is_scaled_below_nothing_by_turning_it() {
        let wave = entry(
            EffectKind::OuterRaceWaviness,
            &[(ParameterKey::AmplitudeM, 2e-7), (ParameterKey::Lobes, 9.0), (ParameterKey::PhaseRad, 0.25)],
        );
        let start = |effect, free| Start { effect, free, nothing: 0.0, leads: None };
        let scaled = start(wave, &[ParameterKey::AmplitudeM, ParameterKey::PhaseRad]).scaled(-3.0).unwrap();
        assert!((scaled.number(ParameterKey::AmplitudeM) - 6e-7).abs() < 1e-20, "{scaled:?}");
        assert!((scaled.number(ParameterKey::PhaseRad) - 0.25 - PI).abs() < 1e-12, "{scaled:?}");
        let force = start(entry(EffectKind::ConstantForce, &[(ParameterKey::ForceN, 4.0)]), &[ParameterKey::ForceN]);
        assert!(force.scaled(-3.0).is_none() && force.scaled(1e3).is_none());
        assert!((force.scaled(0.5).unwrap().number(ParameterKey::ForceN) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn friction_of_the_rigs_own_is_made_softer_and_never_sharper() {
        let soft = |own: f64| {
            let rig = softened(&nominal().with_effect(friction(3.0, own)));
            rig.effects[0].number(ROUNDED).unwrap()
        };
        assert!(soft(2e-6) > 2e-6);
        assert_eq!(soft(1e-3), 1e-3);
    }
}
