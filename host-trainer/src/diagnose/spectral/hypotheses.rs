//! Hypotheses: the lasting effects that a bearing rig can have, with starts of their search: those of the vocabulary, and what
//! would be taken for one of them.
//!
//! Sizes follow from the rig: a defect's depth from the contact's deflection, a spring's curvature from its static
//! deflection. Phases are no part of a power spectrum and are not estimated, but that of a few lobes under the load.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::guesses::Guesses;
use crate::rig::config::{BearingRig, Machine, RigKind};
use crate::rig::effect::component::Component;
use crate::rig::effect::{EffectKind, ParameterKey, ValueKind};
use crate::rig::{EffectEntry, Rig};

/// Component and direction on which the load acts.
pub const LOAD_COMPONENT: &str = "inner-y";

/// Symmetry of a law that is the same in every direction.
pub const ISOTROPIC: &str = "isotropic";
/// Sources of a mode with the signs of its gain that make a difference: the force across the sensor is not in step with what the
/// sensor has.
pub const MODE_SOURCES: [(&str, f64); 5] =
    [("along", 1.0), ("along", -1.0), ("across", 1.0), ("motion", 1.0), ("motion", -1.0)];

/// Effects of a support that act on the motion in either direction alike. A load bends a spring's law along it, and hardly across;
/// where one of these acts in one direction, the same in both can be worse than nothing, so that no search would begin there.
const ACTING_EITHER_WAY: [EffectKind; 5] = [
    EffectKind::CoulombFriction,
    EffectKind::ViscousFriction,
    EffectKind::QuadraticDrag,
    EffectKind::DampingChange,
    EffectKind::StiffnessChange,
];

/// Effect at one component or channel, with starts of its search.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Effect.
    pub kind: EffectKind,
    /// Component, channel or lobes such as `outer`, `ay`, `5 lobes`; empty if there is no choice.
    pub place: String,
    /// Parameters that are fitted.
    pub free: &'static [ParameterKey],
    /// Starts of the search. An effect in one direction that is none of [`ACTING_EITHER_WAY`] has none of its own: it starts where that
    /// in both is found.
    pub starts: Vec<EffectEntry>,
    /// Parameter by whose square the power of the effect's lines grows, so that one run gives all its sizes; `None` for an
    /// effect whose sizes are simulated each.
    pub size: Option<ParameterKey>,
    /// All parameters of the effect's form, fitted where they gain enough, the last of them one that the first fit leaves as it is;
    /// empty where there are no more.
    pub extended: &'static [ParameterKey],
}

/// Numbers from one to another, even in the logarithm.
pub fn ladder(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..count).map(|k| from * (to / from).powf(f64::from(k) / f64::from(count.max(2) - 1))).collect()
}

/// Multiples of a step, ever farther apart: in parts, each up to a multiple and as many steps apart as stated.
fn widening(step: f64, parts: &[(u32, usize)]) -> impl Iterator<Item = f64> {
    let from = std::iter::once(0).chain(parts.iter().map(|(to, _)| *to));
    let each = parts.iter().zip(from).flat_map(|((to, by), from)| (from..=*to).step_by(*by).skip(1));
    each.map(move |n| step * f64::from(n))
}

/// The same with both signs.
fn both_ways(from: f64, to: f64, count: u32) -> Vec<f64> {
    ladder(from, to, count).into_iter().flat_map(|v| [v, -v]).collect()
}

/// Effect along each axis by itself, and the same in every direction.
fn both_symmetries(effect: EffectEntry) -> [EffectEntry; 2] {
    let isotropic = effect.clone().with_text(ParameterKey::Symmetry, ISOTROPIC);
    [effect, isotropic]
}

/// All lasting hypotheses for a rig under a load, N.
pub fn all(rig: &Rig, load_n: f64, guesses: &Guesses) -> Vec<Hypothesis> {
    let Some(machine) = rig.bearing() else { return Vec::new() };
    let mut list = List { machine, load: load_n.abs().max(1.0), out: Vec::new() };
    list.defects();
    list.races();
    list.forces();
    list.springs();
    list.parts();
    list.dissipation();
    list.sensors(guesses);
    list.rotation(guesses);
    list.directions();
    list.out
}

impl Hypothesis {
    /// Whether this is the same effect in one of the directions in which another one acts.
    pub fn is_direction_of(&self, other: &Self) -> bool {
        let direction = self.place.strip_prefix(other.place.as_str());
        self.kind == other.kind && direction.is_some_and(|rest| matches!(rest, "-x" | "-y"))
    }

    /// Whether this is the same effect at the same place.
    pub fn is_same_as(&self, other: &Self) -> bool {
        (self.kind, &self.place) == (other.kind, &other.place)
    }

    /// This effect of a support in one of the directions in which it acts.
    fn in_direction(&self, place: String) -> Self {
        let mut directed = Self { place, starts: Vec::new(), ..self.clone() };
        if ACTING_EITHER_WAY.contains(&self.kind) {
            let along_axes = self.starts.iter().filter(|start| start.text(ParameterKey::Symmetry).is_none());
            directed.starts = along_axes.map(|start| directed.placed(start)).collect();
        }
        directed
    }

    /// Effect at this hypothesis's component.
    pub fn placed(&self, effect: &EffectEntry) -> EffectEntry {
        effect.clone().with_text(ParameterKey::Component, &self.place)
    }
}

/// Parameters of an effect with those of its form that its first fit leaves as they are; none of most.
fn extended(kind: EffectKind) -> &'static [ParameterKey] {
    use ParameterKey::{
        AboveCos, AboveSin, AmplitudeM, AngleRad, BelowCos, BelowSin, DampingNSPerM, DampingRatio, DeflectionM, DepthM,
        Exponent, Flank, FrequencyHz, Gain, GainAcross, GapM, PhaseRad, StiffnessNPerM, WidthRad,
    };
    match kind {
        EffectKind::ContactExponent => &[Exponent, DeflectionM],
        EffectKind::EndStopContact => &[StiffnessNPerM, GapM, DampingNSPerM],
        EffectKind::OuterRaceDefect => &[DepthM, WidthRad, AngleRad, Flank],
        EffectKind::InnerRaceDefect | EffectKind::BallDefect => &[DepthM, WidthRad, Flank],
        EffectKind::StructuralResonance => &[Gain, FrequencyHz, DampingRatio, GainAcross],
        EffectKind::OuterRaceWaviness => &[AmplitudeM, PhaseRad, BelowCos, BelowSin, AboveCos, AboveSin],
        // The turns of the shaft take the main wave through all phases.
        EffectKind::InnerRaceWaviness => &[AmplitudeM, BelowCos, BelowSin, AboveCos, AboveSin],
        _ => &[],
    }
}

struct List<'r> {
    machine: &'r BearingRig,
    load: f64,
    out: Vec<Hypothesis>,
}

impl List<'_> {
    fn add(
        &mut self,
        kind: EffectKind,
        place: impl Into<String>,
        free: &'static [ParameterKey],
        starts: Vec<EffectEntry>,
    ) {
        let size = match kind {
            EffectKind::OuterRaceDefect | EffectKind::InnerRaceDefect | EffectKind::BallDefect => {
                Some(ParameterKey::DepthM)
            }
            EffectKind::OuterRaceWaviness | EffectKind::InnerRaceWaviness => Some(ParameterKey::AmplitudeM),
            EffectKind::Misalignment => Some(ParameterKey::ForceN),
            _ => None,
        };
        self.out.push(Hypothesis { kind, place: place.into(), free, starts, size, extended: extended(kind) });
    }

    /// Deflection of the most loaded contact, m.
    fn contact(&self) -> f64 {
        let bearing = &self.machine.bearing;
        (self.load / bearing.contact_stiffness_n_per_m1_5).powf(1.0 / bearing.contact_exponent)
    }

    /// Static deflection of either support, m.
    fn support(&self) -> f64 {
        self.load / (self.machine.inner.stiffness_n_per_m + self.machine.outer.stiffness_n_per_m).max(1.0)
    }

    fn defects(&mut self) {
        use ParameterKey::{AngleRad, DepthM, SpinRad, WidthRad};
        let depth = 0.03 * self.contact();
        let of = |kind: EffectKind, key: ParameterKey, angle: f64| {
            let widths = [0.02, 0.04, 0.08, 0.16].into_iter();
            widths.map(move |w| EffectEntry::new(kind, &[(DepthM, depth), (WidthRad, w), (key, angle)]))
        };
        let outer = [-0.4, 0.0, 0.4].into_iter().flat_map(|a| of(EffectKind::OuterRaceDefect, AngleRad, FRAC_PI_2 + a));
        let outer = outer.collect();
        let inner = of(EffectKind::InnerRaceDefect, AngleRad, 0.0).collect();
        let ball = of(EffectKind::BallDefect, SpinRad, 0.0).collect();
        self.add(EffectKind::OuterRaceDefect, "", &[DepthM, WidthRad, AngleRad], outer);
        self.add(EffectKind::InnerRaceDefect, "", &[DepthM, WidthRad], inner);
        self.add(EffectKind::BallDefect, "", &[DepthM, WidthRad], ball);
    }

    fn races(&mut self) {
        use ParameterKey::{AmplitudeM, DeflectionM, Exponent, Lobes, PhaseRad, RadialClearanceM};
        let balls = self.machine.bearing.balls;
        for kind in [EffectKind::OuterRaceWaviness, EffectKind::InnerRaceWaviness] {
            for lobes in 2..=(2 * balls + 3) {
                let place = format!("{lobes} lobes");
                let height = 0.03 * self.contact();
                let of = |phase: f64| {
                    EffectEntry::new(kind, &[(AmplitudeM, height), (Lobes, lobes as f64), (PhaseRad, phase)])
                };
                // Few lobes at rest bend the balls' mean path under the load: what that does depends on where they are.
                if kind == EffectKind::OuterRaceWaviness && 2 * lobes <= balls {
                    let starts = [0.0, FRAC_PI_2, PI, -FRAC_PI_2].map(of).to_vec();
                    self.add(kind, place, &[AmplitudeM, PhaseRad], starts);
                } else {
                    self.add(kind, place, &[AmplitudeM], vec![of(0.0)]);
                }
            }
        }
        let clearance = self.machine.bearing.radial_clearance_m;
        let of = |more: f64| {
            let value = clearance + more * self.contact();
            EffectEntry::new(EffectKind::ExcessClearance, &[(RadialClearanceM, value)])
        };
        // Other balls bear the load every fraction of a deflection: the likelihood has as many valleys.
        let starts = widening(0.02, &[(50, 1), (100, 5), (200, 10)]).map(of).collect();
        self.add(EffectKind::ExcessClearance, "", &[RadialClearanceM], starts);
        let exponent = self.machine.bearing.contact_exponent;
        let of = |by: f64| EffectEntry::new(EffectKind::ContactExponent, &[(Exponent, exponent + by)]);
        // To the line contact of a roller, 10/9, and beyond. The stiffness under load changes by a twentieth with each of the closest. The valleys of a far softer or stiffer contact
        // are wider, and those of a softer one most, which hides behind its supports.
        let softer = widening(0.005, &[(12, 1), (28, 2), (84, 4)]);
        let stiffer = widening(0.005, &[(16, 1), (84, 2)]).map(|by| -by);
        let starts = softer.chain(stiffer).map(of);
        // As stiff as nominal under the load, it bends the contact alone.
        let bent = both_ways(0.03, 0.4, 4).into_iter().map(of);
        let bent = bent.map(|effect| effect.with_number(DeflectionM, self.contact()));
        let starts = starts.chain(bent).collect();
        self.add(EffectKind::ContactExponent, "", &[Exponent], starts);
    }

    fn forces(&mut self) {
        use ParameterKey::{AngleRad, Component, ForceN, PsdN2PerHz, UnbalanceKgM};
        let nominal = self.machine.excitation.unbalance_kg_m.max(1e-5);
        let of = |factor: f64| EffectEntry::new(EffectKind::Unbalance, &[(UnbalanceKgM, factor * nominal)]);
        let starts = ladder(2.0, 2000.0, 16).into_iter().map(of).collect();
        self.add(EffectKind::Unbalance, "", &[UnbalanceKgM], starts);
        let of =
            |angle: f64| EffectEntry::new(EffectKind::Misalignment, &[(ForceN, 0.02 * self.load), (AngleRad, angle)]);
        // A rotating force, or one along x or y.
        let starts = [FRAC_PI_4, 0.1, FRAC_PI_2 - 0.1].map(of).to_vec();
        self.add(EffectKind::Misalignment, "", &[ForceN, AngleRad], starts);
        // Along the load; and across it or oblique.
        for (component, free, angles_rad) in [
            (LOAD_COMPONENT, [ForceN].as_slice(), [0.0].as_slice()),
            ("outer-y", &[ForceN], &[0.0]),
            ("inner-x", &[ForceN, AngleRad], &[-0.8, 0.0, 0.8]),
            ("outer-x", &[ForceN, AngleRad], &[-0.8, 0.0, 0.8]),
        ] {
            let of = |share: f64| {
                EffectEntry::new(EffectKind::ConstantForce, &[(ForceN, share * self.load)])
                    .with_text(Component, component)
            };
            let sizes = both_ways(0.01, 0.8, 4).into_iter().map(of);
            let turned = |effect: EffectEntry| angles_rad.iter().map(move |a| effect.clone().with_number(AngleRad, *a));
            self.add(EffectKind::ConstantForce, component, free, sizes.flat_map(turned).collect());
        }
        // Its size is sought by that of the process force; without one there is no scale.
        let process = self.machine.excitation.process_force_psd_n2_per_hz;
        if process > 0.0 {
            for component in ["inner", "outer", "resonator"] {
                let of = |factor: f64| {
                    EffectEntry::new(EffectKind::RandomForce, &[(PsdN2PerHz, factor * process)])
                        .with_text(Component, component)
                };
                let starts = ladder(0.003, 10.0, 8).into_iter().map(of).collect();
                self.add(EffectKind::RandomForce, component, &[PsdN2PerHz], starts);
            }
        }
    }

    fn springs(&mut self) {
        use ParameterKey::{Component, CubicNPerM3, GapM, QuadraticNPerM2, StiffnessNPerM, WidthM};
        let still = self.support();
        let parts = [("inner", self.machine.inner.stiffness_n_per_m), ("outer", self.machine.outer.stiffness_n_per_m)];
        for (component, k) in parts.into_iter().filter(|(_, k)| *k > 0.0) {
            let of = |kind: EffectKind, key: ParameterKey, value: f64| {
                EffectEntry::new(kind, &[(key, value)]).with_text(Component, component)
            };
            let cubic = |share: f64| share * k / (3.0 * still * still);
            let hard = ladder(0.03, 2.0, 12).into_iter();
            let hard = hard.map(|s| of(EffectKind::HardeningStiffness, CubicNPerM3, cubic(s)));
            let hard = hard.flat_map(both_symmetries).collect();
            self.add(EffectKind::HardeningStiffness, component, &[CubicNPerM3], hard);
            let soft = ladder(0.03, 0.5, 8).into_iter();
            let soft = soft.map(|s| of(EffectKind::SofteningStiffness, CubicNPerM3, -cubic(s)));
            let soft = soft.flat_map(both_symmetries).collect();
            self.add(EffectKind::SofteningStiffness, component, &[CubicNPerM3], soft);
            let square = |share: f64| share * k / (2.0 * still);
            let skew = both_ways(0.04, 0.6, 6).into_iter();
            let skew = skew.map(|s| of(EffectKind::AsymmetricStiffness, QuadraticNPerM2, square(s))).collect();
            self.add(EffectKind::AsymmetricStiffness, component, &[QuadraticNPerM2], skew);
            // A play of a hundredth of the static deflection leaves the housing free across the load, where it hardly moves.
            let widths = ladder(0.003, 1.6, 8).into_iter();
            let widths = widths.map(|s| of(EffectKind::Backlash, WidthM, s * still)).collect();
            self.add(EffectKind::Backlash, component, &[WidthM], widths);
            let vertical = if component == "inner" { "inner-y" } else { "outer-y" };
            let stop = |(gap, stiffer): (f64, f64)| {
                EffectEntry::new(EffectKind::EndStopContact, &[(GapM, gap * still), (StiffnessNPerM, stiffer * k)])
                    .with_text(Component, vertical)
            };
            let gaps = [0.5, 0.7, 0.85, 1.0, 1.15];
            let stops = gaps.into_iter().flat_map(|gap| [0.15, 1.0, 5.0].map(|s| stop((gap, s)))).collect();
            self.add(EffectKind::EndStopContact, vertical, &[StiffnessNPerM, GapM], stops);
        }
    }

    fn parts(&mut self) {
        use ParameterKey::{Component, Value};
        let m = self.machine;
        let contact = m.bearing.contact_stiffness_n_per_m1_5;
        let sections = [
            ("inner", Some(&m.inner)),
            ("outer", Some(&m.outer)),
            ("resonator", Some(&m.resonator)),
            ("bearing", None),
        ];
        for (component, support) in sections {
            let mut change = |kind: EffectKind, nominal: f64, logs: &[f64]| {
                let of =
                    |log: &f64| EffectEntry::new(kind, &[(Value, log.exp() * nominal)]).with_text(Component, component);
                if nominal > 0.0 {
                    self.add(kind, component, &[Value], logs.iter().map(of).collect());
                }
            };
            let small = [-0.7, -0.5, -0.3, -0.15, -0.06, -0.02, 0.02, 0.06, 0.15, 0.3, 0.5, 0.7];
            change(EffectKind::StiffnessChange, support.map_or(contact, |s| s.stiffness_n_per_m), &small);
            if let Some(support) = support {
                change(EffectKind::DampingChange, support.damping_n_s_per_m, &[-0.8, 0.4, 1.2, 4.0, 12.0]);
                change(EffectKind::MassChange, support.mass_kg, &small);
            }
        }
    }

    fn dissipation(&mut self) {
        use ParameterKey::{Component, DampingNSPerM, DragNS2PerM2, ForceN};
        let m = self.machine;
        for (component, damping) in [
            ("outer", m.outer.damping_n_s_per_m),
            ("inner", m.inner.damping_n_s_per_m),
            ("resonator", m.resonator.damping_n_s_per_m),
        ] {
            let of = |share: f64| {
                let entry = EffectEntry::new(EffectKind::CoulombFriction, &[(ForceN, share * self.load)]);
                sharpened(m, entry.with_text(Component, component))
            };
            // As sharp as can be, and rounded over the speeds at which a housing vibrates.
            let rounded = |sharp: EffectEntry| {
                [1e-5, 4e-5].map(|v| sharp.clone().with_number(ROUNDED, v)).into_iter().chain([sharp])
            };
            let starts = ladder(1e-4, 2e-2, 6).into_iter().map(of).flat_map(rounded).collect();
            self.add(EffectKind::CoulombFriction, component, &[ForceN, ROUNDED], starts);
            if component != "resonator" {
                let of = |speed: f64| {
                    EffectEntry::new(EffectKind::QuadraticDrag, &[(DragNS2PerM2, damping.max(1.0) / speed)])
                        .with_text(Component, component)
                };
                let starts = ladder(1e-2, 1e-4, 4).into_iter().map(of).flat_map(both_symmetries).collect();
                self.add(EffectKind::QuadraticDrag, component, &[DragNS2PerM2], starts);
            }
            if damping == 0.0 {
                let of = |c: f64| {
                    EffectEntry::new(EffectKind::ViscousFriction, &[(DampingNSPerM, c)]).with_text(Component, component)
                };
                self.add(EffectKind::ViscousFriction, component, &[DampingNSPerM], [10.0, 300.0].map(of).to_vec());
            }
        }
        let of = |c: f64| {
            EffectEntry::new(EffectKind::ViscousFriction, &[(DampingNSPerM, c)]).with_text(Component, "bearing")
        };
        let starts = ladder(50.0, 2000.0, 3).into_iter().map(of).collect();
        self.add(EffectKind::ViscousFriction, "bearing", &[DampingNSPerM], starts);
    }

    /// The effects of a support in one direction only.
    fn directions(&mut self) {
        let of = |h: &Hypothesis| {
            let names = match h.kind.definition().parameter(ParameterKey::Component).map(|p| p.value_kind) {
                Some(ValueKind::Name(choices)) => choices.names(RigKind::Bearing5Dof),
                _ => &[],
            };
            let places = ["x", "y"].map(|axis| format!("{}-{axis}", h.place));
            let known = places.into_iter().filter(move |place| names.contains(&place.as_str()));
            known.map(|place| h.in_direction(place)).collect::<Vec<_>>()
        };
        let directed: Vec<Hypothesis> = self.out.iter().flat_map(of).collect();
        self.out.extend(directed);
    }

    fn rotation(&mut self, guesses: &Guesses) {
        use ParameterKey::{Fraction, RatePerS};
        let of = |slip: &f64| EffectEntry::new(EffectKind::CageSlip, &[(Fraction, *slip)]);
        let slips: Vec<EffectEntry> = guesses.slips.iter().map(of).collect();
        let of = |rate: &f64| EffectEntry::new(EffectKind::SpeedDrift, &[(RatePerS, *rate)]);
        let drifts: Vec<EffectEntry> = guesses.drifts_per_s.iter().map(of).collect();
        for (kind, free, starts) in
            [(EffectKind::CageSlip, [Fraction].as_slice(), slips), (EffectKind::SpeedDrift, &[RatePerS], drifts)]
        {
            if !starts.is_empty() {
                self.add(kind, "", free, starts);
            }
        }
    }

    fn sensors(&mut self, guesses: &Guesses) {
        use ParameterKey::{Channel, DampingRatio, FrequencyHz, Gain, Source, Value};
        for (channel, peaks) in ["ax", "ay"].into_iter().zip(&guesses.peaks_hz) {
            let mode = |hz: f64, ratio: f64, gain: f64, source: &str| {
                let numbers = [(Gain, gain), (FrequencyHz, hz), (DampingRatio, ratio)];
                let mode = EffectEntry::new(EffectKind::StructuralResonance, &numbers);
                mode.with_text(Channel, channel).with_text(Source, source)
            };
            let gains = [0.15, 0.8, 4.0];
            let of = |hz: &f64| {
                let sizes = [0.01, 0.04].into_iter().flat_map(|ratio| gains.map(|gain| (ratio, gain)));
                let each = sizes.flat_map(|size| MODE_SOURCES.map(|source| (size, source)));
                each.map(|((ratio, gain), (source, sign))| mode(*hz, ratio, sign * gain, source)).collect::<Vec<_>>()
            };
            let modes: Vec<EffectEntry> = peaks.iter().flat_map(of).collect();
            if !modes.is_empty() {
                self.add(EffectKind::StructuralResonance, channel, &[Gain, FrequencyHz, DampingRatio], modes);
            }
        }
        for channel in ["all", "ax", "ay"] {
            let of =
                |value: f64| EffectEntry::new(EffectKind::SensorGain, &[(Value, value)]).with_text(Channel, channel);
            // The level of the noise replaces this start.
            self.add(EffectKind::SensorGain, channel, &[Value], vec![of(1.1)]);
        }
        for channel in ["ax", "ay"] {
            let of = |value: f64| {
                EffectEntry::new(EffectKind::TransverseSensitivity, &[(Value, value)]).with_text(Channel, channel)
            };
            let starts = both_ways(0.02, 20.0, 6).into_iter().map(of).collect();
            self.add(EffectKind::TransverseSensitivity, channel, &[Value], starts);
        }
    }
}

/// Rate of dry friction near standstill that is simulated, 1/s: no faster than a few steps a sample follow.
pub const FASTEST_FRICTION_PER_S: f64 = 1e5;
/// Speed at which dry friction is rounded at least, m/s: far below what a housing vibrates at.
const SHARPEST_M_PER_S: f64 = 2e-6;

/// Effect with dry friction as sharp at rest as can be simulated with its force; any other effect unchanged.
fn sharpened(rig: &BearingRig, effect: EffectEntry) -> EffectEntry {
    match rounded_at(rig, &effect) {
        Some(speed) => effect.with_number(ROUNDED, speed),
        None => effect,
    }
}

/// The parameter of dry friction that rounds its step.
const ROUNDED: ParameterKey = ParameterKey::RegularisationMPerS;

/// The speed at which dry friction changes at that rate at rest; nothing of another effect.
fn rounded_at(rig: &BearingRig, effect: &EffectEntry) -> Option<f64> {
    if effect.kind != EffectKind::CoulombFriction {
        return None;
    }
    let component = effect.text(ParameterKey::Component).and_then(Component::parse).unwrap_or(Component::Outer);
    let mass_kg = component.part_of(&Machine::Bearing(rig.clone())).mass;
    let speed = effect.number(ParameterKey::ForceN).unwrap_or_default() / (mass_kg * FASTEST_FRICTION_PER_S);
    Some(speed.max(SHARPEST_M_PER_S))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::nominal;

    /// Part of the diagnosis of a bearing rig that seeks an effect.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum SoughtBy {
        /// The power spectra: [`all`] has hypotheses of the effect.
        Spectra,
        /// The whitened samples, `diagnose::spectral::events`.
        Events,
        /// The samples themselves, `diagnose::acquisition`, and `mains`.
        Acquisition,
        /// Not sought: at one speed it is like another effect.
        None,
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
            | EffectKind::SpeedDrift
            | EffectKind::CageSlip
            | EffectKind::ContactExponent
            | EffectKind::SensorGain
            | EffectKind::RandomForce
            | EffectKind::TransverseSensitivity => SoughtBy::Spectra,
            EffectKind::LoadStep | EffectKind::Shock => SoughtBy::Events,
            EffectKind::LubricantFilm => SoughtBy::None,
            EffectKind::SensorBias
            | EffectKind::SensorClipping
            | EffectKind::DroppedSamples
            | EffectKind::MainsInterference => SoughtBy::Acquisition,
        }
    }

    #[test]
    fn invariant_every_effect_has_hypotheses_where_the_spectra_seek_it() {
        let guesses = Guesses { peaks_hz: [vec![2000.0], vec![900.0]], slips: vec![0.02], drifts_per_s: vec![0.01] };
        let sought: Vec<_> = all(&nominal(), 500.0, &guesses).iter().map(|h| h.kind).collect();
        for kind in EffectKind::ALL {
            assert_eq!(sought.contains(kind), sought_by(*kind) == SoughtBy::Spectra, "{kind}");
            assert!(!kind.in_vocabulary() || sought_by(*kind) != SoughtBy::None, "{kind}");
        }
    }

    #[test]
    fn starts_lie_farther_apart_part_by_part() {
        assert_eq!(widening(0.5, &[(3, 1), (7, 2)]).collect::<Vec<_>>(), [0.5, 1.0, 1.5, 2.5, 3.5]);
    }

    #[test]
    fn invariant_every_start_is_a_rig_that_can_run() {
        for hypothesis in all(&nominal(), 500.0, &Guesses::default()) {
            for start in &hypothesis.starts {
                nominal().with_effect(start.clone()).check().unwrap();
            }
        }
    }
}
