//! Hypotheses: every effect of the vocabulary that a bearing rig can have, with starts of its search.
//!
//! Sizes follow from the rig: a defect's depth from the contact's deflection, a spring's curvature from its static
//! deflection. Effects with a time or frequency of their own start at [`InitialGuesses`] from the residual.

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
    pub free: &'static [&'static str],
    /// Strength at which the effect vanishes.
    pub nothing: f64,
    /// Samples by which each recording of the subset leads the rig without the effect, if known.
    pub leads: Option<Vec<i64>>,
}

impl Start {
    /// Numeric parameter of the effect; 0 if absent.
    pub fn number(&self, key: &str) -> f64 {
        self.effect.number(key).unwrap_or_default()
    }

    /// Whether the effect has a time.
    pub fn is_timed(&self) -> bool {
        self.effect.parameters.contains_key("time_s")
    }

    /// Start rotated on the shaft, if the effect is fixed to the shaft.
    #[must_use]
    pub fn turned_on_shaft(&self, by_rad: f64) -> Self {
        let effect = self.effect.turned_on_shaft(by_rad).unwrap_or_else(|| self.effect.clone());
        Self { effect, ..self.clone() }
    }

    /// Whether the effect is a local defect.
    pub fn is_pit(&self) -> bool {
        self.effect.name.ends_with("-defect")
    }

    /// Whether the effect is a structural resonance.
    pub fn is_mode(&self) -> bool {
        self.effect.name == "structural-resonance"
    }

    /// Key of the strength; times and rates are none.
    pub fn strength(&self) -> Option<&'static str> {
        self.free.iter().copied().find(|key| !["time_s", "fraction", "rate_per_s"].contains(key))
    }

    /// Start with its strength scaled by a fiftieth to fifty; a negative factor turns the phase by π.
    pub fn scaled(&self, by: f64) -> Option<Self> {
        let key = self.strength().filter(|_| (0.02..50.0).contains(&by.abs()))?;
        let scaled = self.with(key, self.nothing + (self.number(key) - self.nothing) * by.abs());
        if by > 0.0 {
            return Some(scaled);
        }
        Some(scaled.with("phase_rad", self.effect.number("phase_rad")? + PI))
    }

    /// Start with another value of a parameter.
    #[must_use]
    pub fn with(&self, key: &str, value: f64) -> Self {
        Self { effect: self.effect.clone().with_number(key, value), ..self.clone() }
    }
}

/// Hypothesis: an effect, at one component or channel if it has one.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Name in the vocabulary.
    pub name: &'static str,
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
            || ["inner-race-waviness", "cage-slip", "speed-drift"].contains(&self.name)
    }

    /// Whether the effect must be sought in whole recordings, as beginnings may miss it or are too short.
    pub fn needs_whole_recordings(&self) -> bool {
        ["load-step", "shock", "dropped-samples", "speed-drift", "cage-slip"].contains(&self.name)
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
        name: &'static str,
        place: impl Into<String>,
        free: &'static [&'static str],
        effects: Vec<EffectEntry>,
    ) {
        self.add_from(0.0, name, place, free, effects);
    }

    /// Of an effect that does nothing at a strength other than 0.
    fn add_from(
        &mut self,
        nothing: f64,
        name: &'static str,
        place: impl Into<String>,
        free: &'static [&'static str],
        effects: Vec<EffectEntry>,
    ) {
        let starts = effects.into_iter().map(|effect| Start { effect, free, nothing, leads: None }).collect();
        self.add_starts(name, place.into(), starts);
    }

    fn add_starts(&mut self, name: &'static str, place: String, starts: Vec<Start>) {
        if !starts.is_empty() {
            self.out.push(Hypothesis { name, place, starts });
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

fn entry(name: &str, numbers: &[(&str, f64)]) -> EffectEntry {
    EffectEntry::new(name, numbers)
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
    let grid = |name: &str, key: &str, angles: &[f64]| -> Vec<EffectEntry> {
        let of = |depth, width, angle| entry(name, &[("depth_m", depth), ("width_rad", width), (key, angle)]);
        let depths = depths.iter();
        depths.flat_map(|d| widths.iter().flat_map(move |w| angles.iter().map(move |a| of(*d, *w, *a)))).collect()
    };
    let down = FRAC_PI_2;
    let angles: Vec<f64> = (-4..=4).map(|k| down + 0.2 * f64::from(k)).collect();
    let outer = grid("outer-race-defect", "angle_rad", &angles);
    b.add("outer-race-defect", "", &["depth_m", "width_rad", "angle_rad"], outer);
    b.add(
        "inner-race-defect",
        "",
        &["depth_m", "width_rad", "angle_rad"],
        grid("inner-race-defect", "angle_rad", &[0.0]),
    );
    // The angles that are sought bring its spin with them.
    b.add("ball-defect", "", &["depth_m", "width_rad", "spin_rad"], grid("ball-defect", "spin_rad", &[0.0]));
}

fn races(b: &mut Builder, rig: &BearingRig, sizes: &Sizes) {
    // The inner race's phase is the shaft's angle, which is sought.
    for (name, phases) in [("outer-race-waviness", PHASES.as_slice()), ("inner-race-waviness", &[0.0])] {
        for lobes in 2..=(2 * rig.bearing.balls + 3) {
            let of = |share: f64, phase: f64| {
                let amplitude = share * sizes.contact;
                entry(name, &[("amplitude_m", amplitude), ("lobes", lobes as f64), ("phase_rad", phase)])
            };
            let starts = phases.iter().map(|phase| of(0.03, *phase)).collect();
            b.add(name, format!("{lobes} lobes"), &["amplitude_m", "phase_rad"], starts);
        }
    }
    let unbalance = rig.excitation.unbalance_kg_m.max(1e-5);
    let of = |factor: f64| entry("unbalance", &[("unbalance_kg_m", factor * unbalance)]);
    let nominal = rig.excitation.unbalance_kg_m;
    b.add_from(nominal, "unbalance", "", &["unbalance_kg_m"], [0.3, 2.5, 10.0].map(of).to_vec());
    let of = |phase: f64| entry("misalignment", &[("force_n", 0.03 * sizes.load), ("phase_rad", phase)]);
    b.add("misalignment", "", &["force_n", "phase_rad"], PHASES.map(of).to_vec());
    let clearance = rig.bearing.radial_clearance_m;
    let of = |more: f64| entry("excess-clearance", &[("radial_clearance_m", clearance + more * sizes.contact)]);
    // Waveforms differ from one twentieth of it to the next.
    let starts = ladder(0.03, 4.0, 100).into_iter().map(of).collect();
    b.add_from(clearance, "excess-clearance", "", &["radial_clearance_m"], starts);
    let exponent = rig.bearing.contact_exponent;
    let of = |by: f64| entry("contact-exponent", &[("exponent", exponent + by)]);
    let starts = both_ways(0.004, 0.15, 5).into_iter().map(of).collect();
    b.add_from(exponent, "contact-exponent", "", &["exponent"], starts);
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
        let of = |name: &str, key: &str, value: f64| entry(name, &[(key, value)]).with_text("component", component);
        let hard = |s| of("hardening-stiffness", "cubic_n_per_m3", cubic(s));
        let hard = ladder(0.02, 3.0, 7).into_iter().map(hard).collect();
        b.add("hardening-stiffness", component, &["cubic_n_per_m3"], hard);
        let soft = |s| of("softening-stiffness", "cubic_n_per_m3", -cubic(s));
        let soft = ladder(0.02, 0.5, 6).into_iter().map(soft).collect();
        b.add("softening-stiffness", component, &["cubic_n_per_m3"], soft);
        let square = |share: f64| share * k / (2.0 * static_m);
        let skew = |s| of("asymmetric-stiffness", "quadratic_n_per_m2", square(s));
        let skew = both_ways(0.02, 0.6, 5).into_iter().map(skew).collect();
        b.add("asymmetric-stiffness", component, &["quadratic_n_per_m2"], skew);
        let of =
            |share: f64| entry("backlash", &[("width_m", share * 2.0 * static_m)]).with_text("component", component);
        b.add("backlash", component, &["width_m"], ladder(0.03, 1.2, 7).into_iter().map(of).collect());
        let vertical = if component == "inner" { "inner-y" } else { "outer-y" };
        let of = |gap: f64, stiffer: f64| {
            entry("end-stop-contact", &[("gap_m", gap * static_m), ("stiffness_n_per_m", stiffer * k)])
                .with_text("component", vertical)
        };
        // Whether it is met depends on the load: finely between the least and the greatest.
        let gaps = (8..=26).map(|k| 0.05 * f64::from(k));
        let stops = gaps.flat_map(|gap| [0.05, 0.4, 3.0].map(|s| of(gap, s)));
        b.add("end-stop-contact", vertical, &["stiffness_n_per_m", "gap_m"], stops.collect());
    }
    // On the housing it does the same, k_outer/k_inner times as great and the other way: the springs are straight.
    let of = |share: f64| entry("constant-force", &[("force_n", share * sizes.load)]).with_text("component", "inner-y");
    b.add("constant-force", "inner-y", &["force_n"], both_ways(0.01, 0.4, 5).into_iter().map(of).collect());
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
        let mut change = |name: &'static str, nominal: f64, factors: &[f64]| {
            let of = |f: &f64| entry(name, &[("value", f * nominal)]).with_text("component", component);
            if nominal > 0.0 {
                b.add_from(nominal, name, component, &["value"], factors.iter().map(of).collect());
            }
        };
        change("stiffness-change", support.map_or(contact, |s| s.stiffness_n_per_m), &small);
        if let Some(support) = support {
            change("damping-change", support.damping_n_s_per_m, &large);
            change("mass-change", support.mass_kg, &small);
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
const ROUNDED: &str = "regularisation_m_per_s";

/// The speed at which dry friction changes at that rate at rest; nothing of another effect.
fn rounded_at(rig: &BearingRig, effect: &EffectEntry, rate_per_s: f64) -> Option<f64> {
    if effect.name != "coulomb-friction" {
        return None;
    }
    let component = effect.text("component").and_then(Component::parse).unwrap_or(Component::Outer);
    let mass_kg = component.part_of(&Machine::Bearing(rig.clone())).mass;
    let speed = effect.number("force_n").unwrap_or_default() / (mass_kg * rate_per_s);
    Some(speed.max(SHARPEST_M_PER_S))
}

fn dissipation(b: &mut Builder, rig: &BearingRig, sizes: &Sizes) {
    for component in ["outer", "inner", "resonator"] {
        let of = |share: f64| {
            let entry = entry("coulomb-friction", &[("force_n", share * sizes.load)]);
            sharpened(rig, entry.with_text("component", component))
        };
        b.add("coulomb-friction", component, &["force_n"], ladder(1e-4, 2e-2, 5).into_iter().map(of).collect());
        let damping = match component {
            "outer" => rig.outer.damping_n_s_per_m,
            "inner" => rig.inner.damping_n_s_per_m,
            _ => rig.resonator.damping_n_s_per_m,
        };
        if component != "resonator" {
            // As strong as the damper at 0.1 to 10 mm/s.
            let of = |speed: f64| {
                entry("quadratic-drag", &[("drag_n_s2_per_m2", damping.max(1.0) / speed)])
                    .with_text("component", component)
            };
            b.add(
                "quadratic-drag",
                component,
                &["drag_n_s2_per_m2"],
                ladder(1e-2, 1e-4, 5).into_iter().map(of).collect(),
            );
        }
        if damping == 0.0 {
            let of = |c: f64| entry("viscous-friction", &[("damping_n_s_per_m", c)]).with_text("component", component);
            b.add("viscous-friction", component, &["damping_n_s_per_m"], [10.0, 300.0].map(of).to_vec());
        }
    }
    let of = |c: f64| entry("viscous-friction", &[("damping_n_s_per_m", c)]).with_text("component", "bearing");
    b.add("viscous-friction", "bearing", &["damping_n_s_per_m"], ladder(20.0, 3000.0, 7).into_iter().map(of).collect());
}

fn in_time(b: &mut Builder, sizes: &Sizes, guesses: &InitialGuesses) {
    let of = |(time, share): (f64, f64)| {
        entry("load-step", &[("time_s", time), ("change_n", share * sizes.load), ("rise_s", 4e-5)])
    };
    let times = guesses.times_s.iter().flat_map(|t| [-0.3, -0.1, 0.1, 0.3].map(|share| (*t, share)));
    b.add("load-step", "", &["time_s", "change_n", "rise_s"], times.map(of).collect());
    let gap = |Gap { time_s, count, leads }: &Gap| Start {
        effect: entry("dropped-samples", &[("time_s", *time_s), ("count", *count)]),
        free: &[],
        nothing: 0.0,
        leads: Some(leads.clone()),
    };
    b.add_starts("dropped-samples", String::new(), guesses.gap.iter().map(gap).collect());
    let of = |(time, impulse): (f64, f64)| {
        entry("shock", &[("time_s", time), ("impulse_n_s", impulse), ("duration_s", 2e-4)])
    };
    let times = guesses.times_s.iter().flat_map(|t| [1e-3, 1e-2, 0.1].map(|impulse| (t - 1e-4, impulse)));
    b.add("shock", "", &["time_s", "impulse_n_s", "duration_s"], times.map(of).collect());
    b.add(
        "cage-slip",
        "",
        &["fraction"],
        guesses.slips.iter().map(|f| entry("cage-slip", &[("fraction", *f)])).collect(),
    );
    b.add(
        "speed-drift",
        "",
        &["rate_per_s"],
        guesses.drifts_per_s.iter().map(|r| entry("speed-drift", &[("rate_per_s", *r)])).collect(),
    );
}

fn sensors(b: &mut Builder, guesses: &InitialGuesses) {
    // Where the residual stands out, and a grid for what it does not show.
    let grid = ladder(300.0, 9000.0, 18).into_iter().map(|hz| (hz, 0.04));
    let pointed = guesses.resonances_hz.iter().flat_map(|hz| [(*hz, 0.01), (*hz, 0.03), (*hz, 0.1)]);
    let modes = pointed.chain(grid).flat_map(|(hz, ratio)| [3.0, -3.0].map(|gain| (hz, ratio, gain)));
    let mode = |(hz, ratio, gain)| {
        entry("structural-resonance", &[("gain", gain), ("frequency_hz", hz), ("damping_ratio", ratio)])
    };
    b.add("structural-resonance", "ay", &["gain", "frequency_hz", "damping_ratio"], modes.map(mode).collect());
    let all = |v: f64| entry("sensor-gain", &[("value", v)]);
    b.add_from(1.0, "sensor-gain", "all", &["value"], [0.5, 0.8, 1.25, 2.0].map(all).to_vec());
    for channel in ["ax", "ay"] {
        let of = |name: &str, value: f64| entry(name, &[("value", value)]).with_text("channel", channel);
        b.add_from(
            1.0,
            "sensor-gain",
            channel,
            &["value"],
            [0.5, 0.8, 1.25, 2.0].map(|v| of("sensor-gain", v)).to_vec(),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::nominal;

    fn friction(force_n: f64, speed: f64) -> EffectEntry {
        EffectEntry::new("coulomb-friction", &[("force_n", force_n), (ROUNDED, speed)]).with_text("component", "outer")
    }

    #[test]
    fn what_has_a_phase_is_scaled_below_nothing_by_turning_it() {
        let wave = entry("outer-race-waviness", &[("amplitude_m", 2e-7), ("lobes", 9.0), ("phase_rad", 0.25)]);
        let start = |effect, free| Start { effect, free, nothing: 0.0, leads: None };
        let scaled = start(wave, &["amplitude_m", "phase_rad"]).scaled(-3.0).unwrap();
        assert!((scaled.number("amplitude_m") - 6e-7).abs() < 1e-20, "{scaled:?}");
        assert!((scaled.number("phase_rad") - 0.25 - PI).abs() < 1e-12, "{scaled:?}");
        let force = start(entry("constant-force", &[("force_n", 4.0)]), &["force_n"]);
        assert!(force.scaled(-3.0).is_none() && force.scaled(1e3).is_none());
        assert!((force.scaled(0.5).unwrap().number("force_n") - 2.0).abs() < 1e-12);
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
