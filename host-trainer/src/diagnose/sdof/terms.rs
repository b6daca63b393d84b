//! Candidate library of the force balance: columns of each effect of the vocabulary.
//!
//! A force is that of the effect's own definition at unit strength, so that fit and simulation use the same term. Strengths
//! are linear and fitted; nonlinear parameters of a term (the gap of a stop, the width of a play, the velocity at which
//! friction turns over, a mode's frequency) are searched over a grid within the range of the data, each value a
//! [`Variant`].

use crate::rig::effect::{EffectKind, ParameterKey};
use std::f64::consts::TAU;

use crate::identify::force_balance::{
    equation::{Equation, Parameter, forces},
    states::{Sensed, States, Track},
};
use crate::rig::{EffectEntry, Rig, config::Restoring, simulate::assemble};

/// Meaning of a fitted coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Meaning {
    /// Strength of the effect: this parameter.
    Strength(ParameterKey),
    /// Stiffness of the spring, which the rig has already.
    Spring,
    /// Change of a parameter of the rig.
    Change(Parameter),
    /// Sensor gain, 1/(1 + coefficient).
    Gain,
    /// Sensor bias, minus the coefficient.
    Bias,
    /// Mode, with two coefficients.
    Mode,
}

/// Sign that a coefficient must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// Positive.
    Positive,
    /// Either.
    Any,
}

/// Part of the diagnosis of a rig of one degree of freedom that seeks an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SoughtBy {
    /// The force balance: [`Library`] has a term of the effect.
    Balance,
    /// The coefficient of another effect's term, by its sign or size.
    Other(EffectKind),
    /// The tests of the samples themselves.
    Acquisition,
    /// The search for single events in the residual.
    Events,
}

/// Part of the diagnosis that seeks an effect; `None` where a rig of one degree of freedom cannot have it. The match is
/// exhaustive, so that no effect is silently never sought.
pub fn sought_by(kind: EffectKind) -> Option<SoughtBy> {
    Some(match kind {
        EffectKind::OuterRaceDefect
        | EffectKind::InnerRaceDefect
        | EffectKind::BallDefect
        | EffectKind::OuterRaceWaviness
        | EffectKind::InnerRaceWaviness
        | EffectKind::Unbalance
        | EffectKind::Misalignment
        | EffectKind::ExcessClearance
        | EffectKind::SpeedDrift
        | EffectKind::CageSlip
        | EffectKind::ContactExponent => return None,
        EffectKind::HardeningStiffness
        | EffectKind::AsymmetricStiffness
        | EffectKind::StiffnessChange
        | EffectKind::DampingChange
        | EffectKind::MassChange
        | EffectKind::CoulombFriction
        | EffectKind::QuadraticDrag
        | EffectKind::EndStopContact
        | EffectKind::Backlash
        | EffectKind::ConstantForce
        | EffectKind::StructuralResonance
        | EffectKind::LoadStep
        | EffectKind::SensorBias
        | EffectKind::SensorGain => SoughtBy::Balance,
        EffectKind::SofteningStiffness => SoughtBy::Other(EffectKind::HardeningStiffness),
        EffectKind::ViscousFriction => SoughtBy::Other(EffectKind::DampingChange),
        EffectKind::MainsInterference | EffectKind::SensorClipping => SoughtBy::Acquisition,
        EffectKind::Shock | EffectKind::DroppedSamples => SoughtBy::Events,
    })
}

/// Candidate cause.
#[derive(Clone, Debug)]
pub struct Term {
    /// Effect.
    pub kind: EffectKind,
    /// Meaning of the coefficient.
    pub meaning: Meaning,
    /// Sign that the coefficient must have.
    pub sign: Sign,
    /// Grid of nonlinear parameters.
    pub variants: Vec<Variant>,
}

/// Term with its nonlinear parameters fixed.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Effect at unit strength.
    pub entry: EffectEntry,
    /// Columns of the term.
    pub columns: Vec<usize>,
}

/// Columns of the force balance with their meaning. Column 0 is the target.
#[derive(Default)]
pub struct Library {
    /// Filtered columns of [`States::rows`] rows each.
    pub columns: Vec<Vec<f64>>,
    /// Unknown parameters of the rig with their columns.
    pub own: Vec<(Parameter, usize)>,
    /// Candidate causes.
    pub terms: Vec<Term>,
    /// Flexible columns without a name, which show how much is explainable.
    pub flexible: Vec<usize>,
    /// Stiffness k of the rig, N/m.
    pub stiffness: f64,
}

struct Builder<'a> {
    rig: &'a Rig,
    states: &'a States,
    healthy: &'a [bool],
    focus: &'a [EffectEntry],
    library: Library,
}

impl Library {
    /// Library of a rig and recordings. No effect acts in `healthy` recordings; every hypothesis fits the `unknown`
    /// parameters anew; around the effects of `focus` the grid is finer.
    pub fn new(
        rig: &Rig,
        equation: &Equation,
        states: &States,
        healthy: &[bool],
        unknown: &[Parameter],
        focus: &[EffectEntry],
    ) -> Self {
        let mut columns = vec![equation.target(unknown)];
        let mut own = Vec::new();
        for parameter in unknown {
            own.push((*parameter, columns.len()));
            columns.push(equation.column(*parameter).to_vec());
        }
        let library =
            Self { columns, own, terms: Vec::new(), flexible: Vec::new(), stiffness: equation.rig.stiffness_n_per_m };
        let mut builder = Builder { rig, states, healthy, focus, library };
        builder.changes(equation, unknown);
        builder.forces(equation);
        builder.sensor(equation);
        builder.modes();
        builder.library
    }

    /// Columns of the unknown parameters.
    pub fn own_columns(&self) -> Vec<usize> {
        self.own.iter().map(|(_, column)| *column).collect()
    }
}

/// Column with zeros on the healthy recordings.
pub fn where_under_test(states: &States, healthy: &[bool], mut column: Vec<f64>) -> Vec<f64> {
    let mut start = 0;
    for (track, healthy) in states.tracks.iter().zip(healthy) {
        if *healthy {
            column[start..start + track.rows.len()].fill(0.0);
        }
        start += track.rows.len();
    }
    column
}

impl Builder<'_> {
    fn push(&mut self, column: Vec<f64>) -> usize {
        self.library.columns.push(where_under_test(self.states, self.healthy, column));
        self.library.columns.len() - 1
    }

    fn term(&mut self, kind: EffectKind, meaning: Meaning, sign: Sign, variants: Vec<(EffectEntry, Vec<f64>)>) {
        let variants =
            variants.into_iter().map(|(entry, column)| Variant { entry, columns: vec![self.push(column)] }).collect();
        self.library.terms.push(Term { kind, meaning, sign, variants });
    }

    /// Terms of parameters that differ from nominal; unknown ones need healthy recordings.
    fn changes(&mut self, equation: &Equation, unknown: &[Parameter]) {
        let told = self.healthy.contains(&true);
        for (kind, parameter) in [
            (EffectKind::MassChange, Parameter::Mass),
            (EffectKind::StiffnessChange, Parameter::Stiffness),
            (EffectKind::DampingChange, Parameter::Damping),
        ] {
            if unknown.contains(&parameter) && !told {
                continue;
            }
            let value = parameter.value_in(&equation.rig);
            // Damping absent from the nominal model is friction.
            let (kind, meaning, sign) = if parameter == Parameter::Damping && value == 0.0 {
                (EffectKind::ViscousFriction, Meaning::Strength(ParameterKey::DampingNSPerM), Sign::Positive)
            } else {
                (kind, Meaning::Change(parameter), Sign::Any)
            };
            let entry = EffectEntry::new(kind, &[]);
            self.term(kind, meaning, sign, vec![(entry, equation.column(parameter).to_vec())]);
        }
    }

    /// Column of minus the force of an effect.
    fn force(&self, entry: &EffectEntry) -> Vec<f64> {
        let alone = Rig::new(self.rig.model.clone()).with_effect(entry.clone());
        let assembly = assemble(&alone);
        self.states.column(|track| forces(&assembly, track, self.states.step_s()).iter().map(|f| -f).collect())
    }

    /// Value of an effect's parameter around which the grid is refined.
    fn focus(&self, kind: EffectKind, key: ParameterKey) -> Option<f64> {
        self.focus.iter().find(|e| e.kind == kind)?.number(key)
    }

    /// Grid of a parameter; around a value in focus, a finer one between its neighbours.
    fn grid(&self, kind: EffectKind, key: ParameterKey, grid: Vec<f64>) -> Vec<f64> {
        let Some(middle) = self.focus(kind, key) else { return grid };
        let below = grid.iter().copied().filter(|x| *x < middle).fold(f64::NEG_INFINITY, f64::max);
        let above = grid.iter().copied().filter(|x| *x > middle).fold(f64::INFINITY, f64::min);
        let (below, above) = match (below.is_finite(), above.is_finite()) {
            (true, true) => (below, above),
            (true, false) => (below, 2.0 * middle - below),
            (false, true) => (2.0 * middle - above, above),
            _ => return grid,
        };
        (0..=12).map(|k| below + (above - below) * f64::from(k) / 12.0).collect()
    }

    fn strength(
        &mut self,
        kind: EffectKind,
        key: ParameterKey,
        sign: Sign,
        unit: f64,
        inside: &[(ParameterKey, Vec<f64>)],
    ) {
        let points: Vec<Vec<(ParameterKey, f64)>> = match inside {
            [] => vec![Vec::new()],
            [(inner, values), ..] => {
                self.grid(kind, *inner, values.clone()).into_iter().map(|v| vec![(*inner, v)]).collect()
            }
        };
        let variants: Vec<_> = points
            .into_iter()
            .map(|mut numbers| {
                numbers.push((key, unit));
                let entry = EffectEntry::new(kind, &numbers);
                let column = self.force(&entry).into_iter().map(|x| x / unit).collect::<Vec<f64>>();
                (entry, column)
            })
            .filter(|(_, column)| column.iter().any(|x| *x != 0.0))
            .collect();
        if !variants.is_empty() {
            self.term(kind, Meaning::Strength(key), sign, variants);
        }
    }

    fn forces(&mut self, equation: &Equation) {
        use Sign::{Any, Positive};
        let (_, largest_v) = self.states.amplitudes();
        let under_test: Vec<&Track> =
            self.states.tracks.iter().zip(self.healthy).filter(|(_, h)| !**h).map(|(t, _)| t).collect();
        let mut positions: Vec<f64> = under_test.iter().flat_map(|t| t.position.iter().copied()).collect();
        let longest = under_test.iter().map(|t| t.len()).max().unwrap_or(0) as f64 * self.states.step_s();
        positions.sort_by(f64::total_cmp);
        let mut sizes: Vec<f64> = positions.iter().map(|q| q.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let part = |sorted: &[f64], share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
        let turn = [3e-4, 3e-3, 2e-2].map(|share| share * largest_v).to_vec();
        self.strength(
            EffectKind::CoulombFriction,
            ParameterKey::ForceN,
            Positive,
            1.0,
            &[(ParameterKey::RegularisationMPerS, turn)],
        );
        self.strength(EffectKind::QuadraticDrag, ParameterKey::DragNS2PerM2, Positive, 1.0, &[]);
        self.strength(EffectKind::HardeningStiffness, ParameterKey::CubicNPerM3, Any, 1.0, &[]);
        self.strength(EffectKind::AsymmetricStiffness, ParameterKey::QuadraticNPerM2, Any, 1.0, &[]);
        // Denser towards the extreme: a stop is touched in a small part of the time.
        let gaps = (0..28).map(|k| part(&positions, 1.0 - 0.5 * 0.82f64.powi(k))).collect();
        self.strength(
            EffectKind::EndStopContact,
            ParameterKey::StiffnessNPerM,
            Positive,
            1.0,
            &[(ParameterKey::GapM, gaps)],
        );
        if self.states.high_pass.is_none() {
            self.strength(EffectKind::ConstantForce, ParameterKey::ForceN, Any, 1.0, &[]);
            let times = (4..=28).map(|k| longest * f64::from(k) / 32.0).collect();
            self.strength(EffectKind::LoadStep, ParameterKey::ChangeN, Any, 1.0, &[(ParameterKey::TimeS, times)]);
        }
        if equation.rig.stiffness_n_per_m > 0.0 && equation.rig.restoring == Restoring::Linear {
            let widths = (1..=20).map(|k| 2.0 * part(&sizes, 0.045 * f64::from(k))).collect();
            let variants: Vec<_> = self
                .grid(EffectKind::Backlash, ParameterKey::WidthM, widths)
                .into_iter()
                .map(|width| EffectEntry::new(EffectKind::Backlash, &[(ParameterKey::WidthM, width)]))
                .map(|entry| {
                    let column = self.force(&entry).into_iter().map(|x| x / equation.rig.stiffness_n_per_m).collect();
                    (entry, column)
                })
                .collect();
            self.term(EffectKind::Backlash, Meaning::Spring, Sign::Positive, variants);
        }
    }

    /// Terms of a wrong gain or bias of the sensor. With a nonlinear spring the column depends on the value, which the
    /// first search passes to the second.
    fn sensor(&mut self, equation: &Equation) {
        let rig = &equation.rig;
        let pendulum = rig.restoring == Restoring::Pendulum;
        let mut all = vec![0.0; self.states.rows()];
        for parameter in [Parameter::Mass, Parameter::Damping, Parameter::Stiffness] {
            let value = parameter.value_in(rig);
            all.iter_mut().zip(equation.column(parameter)).for_each(|(sum, x)| *sum += value * x);
        }
        let k = rig.stiffness_n_per_m;
        let share = self.sensed_value(EffectKind::SensorGain).map(|gain| 1.0 / gain - 1.0).filter(|s| s.abs() > 1e-3);
        if let (true, Some(share)) = (pendulum, share) {
            let beyond = |q: &f64| k * ((((1.0 + share) * q).sin() - q.sin()) / share - q.sin());
            let column = self.states.column(|t| t.position.iter().map(beyond).collect());
            all.iter_mut().zip(column).for_each(|(sum, x)| *sum += x);
        }
        self.term(
            EffectKind::SensorGain,
            Meaning::Gain,
            Sign::Any,
            vec![(EffectEntry::new(EffectKind::SensorGain, &[]), all)],
        );
        if self.states.sensed == Sensed::Position && k > 0.0 {
            let bias = self.sensed_value(EffectKind::SensorBias).filter(|b| b.abs() > 1e-6);
            let slope = |q: &f64| match (pendulum, bias) {
                (false, _) => k,
                (true, None) => k * q.cos(),
                (true, Some(bias)) => k * (q.sin() - (q - bias).sin()) / bias,
            };
            let column = self.states.column(|t| t.position.iter().map(slope).collect());
            self.term(
                EffectKind::SensorBias,
                Meaning::Bias,
                Sign::Any,
                vec![(EffectEntry::new(EffectKind::SensorBias, &[]), column)],
            );
        }
    }

    fn sensed_value(&self, kind: EffectKind) -> Option<f64> {
        self.focus.iter().filter(|e| e.kind == kind).find_map(|e| e.number(ParameterKey::Value))
    }

    /// Terms of a mode driven by the base motion q, which does not act back: η̈ + 2ζω η̇ + ω² η = −q̈, with columns ω² η
    /// and ω η̇.
    fn modes(&mut self) {
        let low = (2.0 * self.states.band.low_hz).max(0.5 * self.states.cutoff_hz() / 20.0);
        let high = (1.3 * self.states.cutoff_hz()).min(0.4 * self.states.sample_rate_hz);
        if high < 1.2 * low {
            return;
        }
        let count = 30;
        let mut variants = Vec::new();
        let grid = (0..count).map(|k| low * (high / low).powf(f64::from(k) / f64::from(count - 1))).collect();
        let ratios = match self.focus(EffectKind::StructuralResonance, ParameterKey::DampingRatio) {
            Some(ratio) => [0.4, 0.7, 1.0, 1.5, 2.2].map(|factor| (factor * ratio).min(0.5)).to_vec(),
            None => vec![0.01, 0.04, 0.12],
        };
        for hz in self.grid(EffectKind::StructuralResonance, ParameterKey::FrequencyHz, grid) {
            for &ratio in &ratios {
                let numbers =
                    [(ParameterKey::FrequencyHz, hz), (ParameterKey::DampingRatio, ratio), (ParameterKey::Gain, 1.0)];
                let entry = EffectEntry::new(EffectKind::StructuralResonance, &numbers);
                let of = |which: usize| self.states.column(|t| mode(self.states, t, hz, ratio, which));
                let columns = [of(0), of(1)];
                let columns = columns.into_iter().map(|c| self.push(c)).collect();
                variants.push(Variant { entry, columns });
            }
        }
        let kind = EffectKind::StructuralResonance;
        self.library.terms.push(Term { kind, meaning: Meaning::Mode, sign: Sign::Any, variants });
    }
}

/// Column ω² η (`which` 0) or ω η̇ of a mode with base motion q; exact for q linear between samples.
pub fn mode(states: &States, track: &Track, hz: f64, ratio: f64, which: usize) -> Vec<f64> {
    let omega = TAU * hz;
    let h = states.step_s();
    // With a measured acceleration, q is its second integral, whose second difference is the acceleration.
    let drive = &track.position;
    let damped = omega * (1.0 - ratio * ratio).sqrt();
    let decay = (-ratio * omega * h).exp();
    let (s, c) = (damped * h).sin_cos();
    let along = ratio * omega / damped;
    let transition =
        [[decay * (c + along * s), decay * s / damped], [-decay * omega * omega * s / damped, decay * (c - along * s)]];
    // y = η, z = η̇: z' = −q̈ − 2ζω z − ω² y. With q piecewise linear q̈ is a train of impulses at the samples.
    let (mut y, mut z) = (0.0, 0.0);
    let mut out = Vec::with_capacity(drive.len());
    for k in 0..drive.len() {
        if k > 0 && k + 1 < drive.len() {
            z += (drive[k + 1] - 2.0 * drive[k] + drive[k - 1]) / h;
        }
        out.push(if which == 0 { omega * omega * y } else { omega * z });
        (y, z) = (transition[0][0] * y + transition[0][1] * z, transition[1][0] * y + transition[1][1] * z);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::force_balance::{equation::Equation, testing};
    use crate::rig::config::RigKind;

    #[test]
    fn invariant_every_effect_of_the_rig_is_sought() {
        let rig = testing::rig(testing::LINEAR);
        let recordings = testing::recordings(&rig, "q", 1.0, 0.01, 1000, 1);
        let mut states = States::new(&recordings).unwrap();
        states.learn_band().unwrap();
        let equation = Equation::new(&rig, &states).unwrap();
        let library = Library::new(&rig, &equation, &states, &vec![false; states.tracks.len()], &[], &[]);
        for kind in EffectKind::ALL {
            let by = sought_by(*kind);
            assert_eq!(by.is_some(), kind.definition().rigs.include(RigKind::Sdof), "{kind}");
            let term = library.terms.iter().any(|term| term.kind == *kind);
            assert_eq!(term, by == Some(SoughtBy::Balance), "{kind}");
        }
    }
}
