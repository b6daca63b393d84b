//! Columns of the regression: the rig's unknown parameters, the terms with a name, and flexible ones without.
//!
//! Each column is what a force of the measured states, or a signal at the sensor, adds to the rig's one-step predictions
//! ([`Predictor`]).

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::acquire::{Acquired, Track};
use super::nominal::Nominal;
use super::terms::{Meaning, Sign, State, Term, Variant};
use crate::identify::force_balance::{
    equation::Parameter,
    predictor::{Grid, Predictor},
    states::Sensed,
};
use crate::rig::config::Restoring;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::simulate::assemble;
use crate::rig::state::{DOFS, Instant, MASS};
use crate::rig::{EffectEntry, Rig};

/// Multiple of the nominal stiffness within which a play's spring lies.
const SPRING: (f64, f64) = (0.6, 1.6);

/// Displacements over the largest at which half of a spring's nonlinear part is left.
const KNEES: [f64; 3] = [1.0, 0.5, 0.25];

/// Frequencies of a mode that are tried in an octave.
const MODES: f64 = 4.0;

/// What drives a column.
pub enum Source<'a> {
    /// A force on the grid of each recording.
    Force(Signal<'a>),
    /// The recorded input, at unit gain.
    Input,
    /// A signal at the sensor.
    Sensor(Signal<'a>),
}

/// A term without its columns yet, and what drives each of its variants.
type Job<'a> = (Term, Vec<(EffectEntry, Source<'a>)>);
/// Signal of a recording.
pub(super) type Signal<'a> = Box<dyn Fn(&Track) -> Vec<f64> + Sync + 'a>;

/// Columns of the regression with their meaning. Column 0 is the target.
#[derive(Default)]
pub struct Library {
    /// White rows of each column.
    pub columns: Vec<Vec<f64>>,
    /// Unknown parameters of the rig with their columns, and the least that each coefficient may be.
    pub own: Vec<(Parameter, usize, f64)>,
    /// Candidate causes.
    pub terms: Vec<Term>,
    /// Flexible columns without a name.
    pub flexible: Vec<usize>,
    /// Rows of each recording.
    pub rows: Vec<usize>,
    /// Sum of the logarithms of the rows' variances.
    pub log_variance: f64,
    /// Standard deviation of each row before whitening, in units of the sensor noise's.
    pub deviations: Vec<f64>,
    /// What each flexible column depends on, in words.
    pub about: Vec<&'static str>,
    /// Pitch of a force along the position, in its unit, and the columns of its cosine and sine.
    pub along: Option<(f64, [usize; 2])>,
    /// Knots and columns of the splines of position and of velocity.
    pub splines: [Vec<(f64, usize)>; 2],
}

/// Maker of columns.
pub struct Builder<'a> {
    /// Rig with its effects.
    pub rig: &'a Rig,
    /// Nominal machine.
    pub nominal: &'a Nominal,
    /// Recordings.
    pub acquired: &'a Acquired,
    predictors: Vec<Predictor>,
}

impl<'a> Builder<'a> {
    /// Maker of columns at a ratio of force noise to sensor noise.
    pub fn new(rig: &'a Rig, nominal: &'a Nominal, acquired: &'a Acquired, ratio: f64) -> Self {
        let operator = nominal.operator(acquired.sensed);
        let [q, v] = acquired.amplitudes();
        // Diffuse against the noise, in units of its standard deviation.
        let unit = acquired.noise_std.max(1e-9 * q);
        let sizes = [100.0 * q / unit, 100.0 * v / unit];
        let one = |track: &Track| {
            let grid = Grid { step_s: track.step_s(), fine: track.fine, bad: &track.bad, sizes };
            Predictor::new(operator, &grid, ratio)
        };
        let predictors = acquired.tracks.par_iter().map(one).collect();
        Self { rig, nominal, acquired, predictors }
    }

    /// What a cosine and a sine at the sensor add to the predictions of each recording.
    pub fn tone(&self, hz: f64) -> Vec<[Vec<f64>; 2]> {
        let waves: [fn(f64) -> f64; 2] = [f64::cos, f64::sin];
        let one = |(track, predictor): (&Track, &Predictor)| {
            let signal = |wave: fn(f64) -> f64| {
                (0..track.len()).map(|k| wave(TAU * hz * k as f64 * track.step_s())).collect::<Vec<_>>()
            };
            waves.map(|wave| predictor.of_sensor(&signal(wave)))
        };
        self.acquired.tracks.par_iter().zip(&self.predictors).map(one).collect()
    }

    fn column(&self, source: &Source, everywhere: bool) -> Vec<f64> {
        let interpolation = self.acquired.interpolation;
        let one = |(track, predictor): (&Track, &Predictor)| {
            if track.healthy && !everywhere {
                return vec![0.0; track.bad.iter().filter(|b| !**b).count()];
            }
            match source {
                Source::Force(force) => predictor.of_force(&force(track), false),
                Source::Input => {
                    let held = interpolation == crate::rig::sdof::Interpolation::Hold;
                    predictor.of_force(&track.grid_input(interpolation), held)
                }
                Source::Sensor(signal) => predictor.of_sensor(&signal(track)),
            }
        };
        self.acquired.tracks.iter().zip(&self.predictors).flat_map(one).collect()
    }

    /// The target and the rig's own columns.
    pub fn own(&self) -> Library {
        let nominal = self.nominal;
        let machine = &nominal.machine;
        let mut target = self.column(&Source::Sensor(Box::new(|t: &Track| t.sensed.clone())), true);
        let mut take = |column: Vec<f64>, weight: f64| {
            target.iter_mut().zip(column).for_each(|(y, x)| *y -= weight * x);
        };
        if self.acquired.driven {
            take(self.column(&Source::Input, true), machine.input_gain_n_per_unit);
        }
        let pendulum = machine.restoring == Restoring::Pendulum;
        let (gravity, stiffness) = (machine.gravity_n, machine.stiffness_n_per_m);
        if gravity != 0.0 || pendulum {
            let force = move |q: f64| gravity - if pendulum { stiffness * (q.sin() - q) } else { 0.0 };
            take(self.column(&Source::Force(Box::new(move |t: &Track| t.signal(|q, _, _| force(q)))), true), 1.0);
        }
        if !self.rig.effects.is_empty() {
            take(self.column(&Source::Force(self.forces(self.rig.effects.clone())), true), 1.0);
        }
        let mut library = Library {
            columns: vec![target],
            rows: self.acquired.tracks.iter().map(|t| t.bad.iter().filter(|b| !**b).count()).collect(),
            deviations: self.predictors.iter().flat_map(Predictor::deviations).collect(),
            log_variance: self.predictors.iter().map(|p| p.log_variance).sum(),
            ..Library::default()
        };
        for parameter in &nominal.unknown {
            let column = self.column(&self.unit(*parameter), true);
            let least = match parameter {
                Parameter::Mass => -0.999 * machine.mass_kg,
                Parameter::Damping => -machine.damping_n_s_per_m,
                Parameter::Stiffness => -machine.stiffness_n_per_m,
                Parameter::Gain | Parameter::Gravity => f64::NEG_INFINITY,
            };
            library.own.push((*parameter, library.columns.len(), least));
            library.columns.push(column);
        }
        library
    }

    fn unit(&self, parameter: Parameter) -> Source<'a> {
        let nominal = self.nominal;
        if parameter == Parameter::Gain {
            return Source::Input;
        }
        Source::Force(Box::new(move |t: &Track| t.signal(|q, v, a| nominal.unit_force(parameter, q, v, a))))
    }

    /// What all known forces but those of the linear states add where the sensor's gain g is higher by 1: the sensor's signal
    /// s = g q of the rig m q̈ + c q̇ + k q = F(q, q̇, u) is that of the same rig under g F(s/g, ṡ/g, u).
    fn other_gain<'b>(&'b self) -> Source<'b> {
        const CHANGE: f64 = 1e-3;
        let machine = &self.nominal.machine;
        let pendulum = machine.restoring == Restoring::Pendulum;
        let (gravity, stiffness) = (machine.gravity_n, machine.stiffness_n_per_m);
        let effects = self.forces(self.rig.effects.clone());
        let of_states = move |t: &Track, gain: f64| {
            let mut at = t.clone();
            [&mut at.states.position, &mut at.states.velocity].into_iter().flatten().for_each(|x| *x /= gain);
            let own = at.signal(|q, _, _| gravity - if pendulum { stiffness * (q.sin() - q) } else { 0.0 });
            own.iter().zip(effects(&at)).map(|(own, effects)| gain * (own + effects)).collect::<Vec<_>>()
        };
        Source::Force(Box::new(move |t: &Track| {
            let input = t.grid_input(self.acquired.interpolation);
            let states = of_states(t, 1.0 + CHANGE).into_iter().zip(of_states(t, 1.0));
            let states = states.map(|(with, without)| (with - without) / CHANGE);
            states.zip(input).map(|(states, u)| states + machine.input_gain_n_per_unit * u).collect()
        }))
    }

    /// Force of effects on the grid.
    fn forces(&self, entries: Vec<EffectEntry>) -> Signal<'a> {
        let mut rig = Rig::new(crate::rig::config::Machine::Sdof(self.nominal.machine.clone()));
        rig.effects = entries;
        let assembly = assemble(&rig);
        Box::new(move |track: &Track| {
            let step = track.step_s() / track.fine as f64;
            let (mut q, mut v) = ([0.0; DOFS], [0.0; DOFS]);
            let states = track.states.position.iter().zip(&track.states.velocity).enumerate();
            let one = |(k, (position, velocity)): (usize, (&f64, &f64))| {
                (q[MASS], v[MASS]) = (*position, *velocity);
                let at = Instant { time_s: track.start_s + k as f64 * step, ..Instant::default() };
                let mut sum = [0.0; DOFS];
                assembly.forces.iter().for_each(|force| force(&at, &q, &v, &mut sum));
                sum[MASS]
            };
            states.map(one).collect()
        })
    }

    /// All columns.
    pub fn library(&self, events: bool) -> Library {
        let mut library = self.own();
        let mut jobs: Vec<Job> = Vec::new();
        self.changes(&mut jobs);
        self.springs_and_friction(&mut jobs);
        self.sensor(&mut jobs, events);
        let sources: Vec<&Source> = jobs.iter().flat_map(|(_, variants)| variants.iter().map(|(_, s)| s)).collect();
        let mut columns: std::vec::IntoIter<Vec<f64>> =
            sources.par_iter().map(|source| self.column(source, false)).collect::<Vec<_>>().into_iter();
        for (mut term, variants) in jobs {
            for (entry, _) in variants {
                let Some(column) = columns.next() else { break };
                if column.iter().any(|x| *x != 0.0) {
                    term.variants.push(Variant { entry, column: library.columns.len() });
                    library.columns.push(column);
                }
            }
            if !term.variants.is_empty() {
                library.terms.push(term);
            }
        }
        let sources = super::flexible::sources(self.acquired);
        let flexible: Vec<Vec<f64>> = sources.par_iter().map(|flexible| self.column(&flexible.source, false)).collect();
        for (flexible, column) in sources.iter().zip(flexible) {
            if column.iter().any(|x| *x != 0.0) {
                if let Some((spline, knot)) = flexible.knot {
                    library.splines[spline].push((knot, library.columns.len()));
                }
                library.flexible.push(library.columns.len());
                library.about.push(flexible.about);
                library.columns.push(column);
            }
        }
        library.along = super::repeating::pitch(self.nominal, self.acquired).map(|pitch| {
            let from = library.columns.len();
            let waves: [fn(f64) -> f64; 2] = [f64::cos, f64::sin];
            for wave in waves {
                let force = move |t: &Track| t.signal(|q, _, _| wave(TAU * q / pitch));
                library.columns.push(self.column(&Source::Force(Box::new(force)), false));
            }
            (pitch, [from, from + 1])
        });
        library
    }

    /// A few nonlinear terms at once, for the noise and the input's interpolation.
    pub fn rough(&self) -> Library {
        let mut library = self.own();
        let [largest_q, largest_v] = self.acquired.amplitudes();
        let sources = super::flexible::rough(largest_q, largest_v);
        library.columns.extend(sources.par_iter().map(|s| self.column(s, true)).collect::<Vec<_>>());
        library
    }

    /// Terms of parameters that differ from nominal; unknown ones need healthy recordings.
    fn changes<'b>(&'b self, jobs: &mut Vec<Job<'b>>) {
        let nominal = self.nominal;
        let told = self.acquired.tracks.iter().any(|t| t.healthy);
        for (kind, parameter, state) in [
            (EffectKind::MassChange, Parameter::Mass, State::Acceleration),
            (EffectKind::StiffnessChange, Parameter::Stiffness, State::Position),
            (EffectKind::DampingChange, Parameter::Damping, State::Velocity),
        ] {
            if nominal.unknown.contains(&parameter) && !told {
                continue;
            }
            let value = parameter.value_in(&nominal.machine);
            // Something else that is known must set the scale.
            if parameter == Parameter::Mass && !nominal.anchors(self.acquired.driven).any(|p| p != parameter) {
                continue;
            }
            // Of a mass too small to show another one is a delay of the sensor.
            if parameter == Parameter::Mass && nominal.is_overdamped(self.acquired) {
                continue;
            }
            // Of a body that only falls, another mass and a constant force are one.
            if parameter == Parameter::Mass && !self.acquired.driven && nominal.machine.stiffness_n_per_m == 0.0 {
                continue;
            }
            // Damping absent from the nominal model is friction.
            let (kind, meaning, sign) = if parameter == Parameter::Damping && value == 0.0 {
                (EffectKind::ViscousFriction, Meaning::Strength(ParameterKey::DampingNSPerM), Sign::Positive)
            } else {
                let most = if parameter == Parameter::Mass { 0.9 * value } else { f64::INFINITY };
                let least = if parameter == Parameter::Mass { -9.0 } else { -0.9 };
                (kind, Meaning::Change(parameter), Sign::Within(least * value, most))
            };
            let sign = if value == 0.0 { Sign::Positive } else { sign };
            let source = if parameter == Parameter::Mass { self.other_mass() } else { self.unit(parameter) };
            let variants = vec![(EffectEntry::new(kind, &[]), source)];
            jobs.push((Term { kind, meaning, sign, state, variants: Vec::new() }, variants));
        }
    }

    /// Minus the acceleration that the rig's own forces give its mass. Unlike the smoothed acceleration it has hardly any
    /// noise: with it m q̈ = F is m₀ q̈ = F − θ F/m₀, where m = m₀/(1 − θ/m₀).
    fn other_mass<'b>(&'b self) -> Source<'b> {
        let nominal = self.nominal;
        let machine = &nominal.machine;
        let own = [Parameter::Damping, Parameter::Stiffness, Parameter::Gravity];
        let force = move |t: &Track| {
            let mut sum = t.signal(|q, v, a| {
                own.iter().map(|p| p.value_in(machine) * nominal.unit_force(*p, q, v, a)).sum::<f64>()
            });
            let input = t.grid_input(self.acquired.interpolation);
            sum.iter_mut().zip(input).for_each(|(f, u)| *f += machine.input_gain_n_per_unit * u);
            sum.iter_mut().for_each(|f| *f /= -machine.mass_kg);
            sum
        };
        Source::Force(Box::new(force))
    }

    fn strength<'b>(
        &'b self,
        jobs: &mut Vec<Job<'b>>,
        kind: EffectKind,
        key: ParameterKey,
        (sign, state): (Sign, State),
        inside: Option<(ParameterKey, Vec<f64>)>,
    ) {
        let points: Vec<Vec<(ParameterKey, f64)>> = match inside {
            None => vec![Vec::new()],
            Some((inner, values)) => values.into_iter().map(|v| vec![(inner, v)]).collect(),
        };
        let variants = points.into_iter().map(|mut numbers| {
            numbers.push((key, 1.0));
            let entry = EffectEntry::new(kind, &numbers);
            (entry.clone(), Source::Force(self.forces(vec![entry])))
        });
        let term = Term { kind, meaning: Meaning::Strength(key), sign, state, variants: Vec::new() };
        jobs.push((term, variants.collect()));
    }

    fn springs_and_friction<'b>(&'b self, jobs: &mut Vec<Job<'b>>) {
        let (either, back) = (Sign::Any, Sign::Positive);
        let [_, largest_v] = self.acquired.amplitudes();
        let mut positions: Vec<f64> = self.acquired.under_test().flat_map(|t| t.states.position.clone()).collect();
        positions.sort_by(f64::total_cmp);
        let mut sizes: Vec<f64> = positions.iter().map(|q| q.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let part = |sorted: &[f64], share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
        // Steeper than the velocity is known tells nothing.
        let known = self.acquired.under_test().map(|t| t.states.velocity_std).fold(0.0, f64::max);
        let mut turns: Vec<f64> =
            [1e-3, 5e-3, 2e-2, 6e-2].iter().map(|share| (share * largest_v).max(0.5 * known)).collect();
        turns.dedup();
        turns.retain(|v| *v < 0.2 * largest_v || *v <= 1.01 * turns_least(known, largest_v));
        let friction = Some((ParameterKey::RegularisationMPerS, turns));
        self.strength(jobs, EffectKind::CoulombFriction, ParameterKey::ForceN, (back, State::Velocity), friction);
        let drag = ParameterKey::DragNS2PerM2;
        self.strength(jobs, EffectKind::QuadraticDrag, drag, (back, State::Velocity), None);
        let largest_q = sizes.last().copied().unwrap_or_default();
        let saturations = KNEES.map(|share| (share * largest_q).powi(-2));
        let saturating = || Some((ParameterKey::SaturationPerM2, [0.0].into_iter().chain(saturations).collect()));
        let cubic = ParameterKey::CubicNPerM3;
        self.strength(jobs, EffectKind::HardeningStiffness, cubic, (either, State::Position), saturating());
        let square = ParameterKey::QuadraticNPerM2;
        self.strength(jobs, EffectKind::AsymmetricStiffness, square, (either, State::Position), saturating());
        // Denser towards the extreme: a stop is touched in a small part of the time.
        let gaps = (0..18).map(|k| part(&positions, 1.0 - 0.5 * 0.72f64.powi(k))).collect();
        let gaps = Some((ParameterKey::GapM, gaps));
        self.strength(jobs, EffectKind::EndStopContact, ParameterKey::StiffnessNPerM, (back, State::Position), gaps);
        let machine = &self.nominal.machine;
        if !self.nominal.unknown.contains(&Parameter::Gravity) {
            let force = ParameterKey::ForceN;
            self.strength(jobs, EffectKind::ConstantForce, force, (either, State::Position), None);
        }
        let k = machine.stiffness_n_per_m;
        // Of a linear spring a bias of the sensor is a constant force.
        if k > 0.0 && machine.restoring == Restoring::Pendulum {
            let entry = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, 1.0)]);
            let source = Source::Force(Box::new(move |t: &Track| t.signal(|q, _, _| k * q.cos())));
            let (kind, meaning) = (EffectKind::SensorBias, Meaning::Strength(ParameterKey::Value));
            let term = Term { kind, meaning, sign: either, state: State::Sensor, variants: Vec::new() };
            jobs.push((term, vec![(entry, source)]));
        }
        if k > 0.0 && machine.restoring == Restoring::Linear {
            let variants = (1..=28).map(|n| {
                let half = part(&sizes, 0.0325 * f64::from(n));
                let entry = EffectEntry::new(EffectKind::Backlash, &[(ParameterKey::WidthM, 2.0 * half)]);
                let force = move |t: &Track| t.signal(|q, _, _| q.clamp(-half, half));
                (entry, Source::Force(Box::new(force)))
            });
            let sign = Sign::Within(SPRING.0 * k, SPRING.1 * k);
            let (kind, meaning) = (EffectKind::Backlash, Meaning::Spring(k));
            let term = Term { kind, meaning, sign, state: State::Position, variants: Vec::new() };
            jobs.push((term, variants.collect()));
        }
    }

    /// A wrong gain of the sensor, a mode between mass and sensor, and the load's step.
    fn sensor<'b>(&'b self, jobs: &mut Vec<Job<'b>>, events: bool) {
        let any = (Sign::Any, State::Time);
        // All that scales with q must be known, or a wrong gain is a change of it.
        let scales = [Parameter::Mass, Parameter::Damping, Parameter::Stiffness];
        let anchored = self.nominal.anchors(self.acquired.driven).any(|p| !scales.contains(&p));
        let machine = &self.nominal.machine;
        let apart = machine.stiffness_n_per_m > 0.0 || machine.damping_n_s_per_m > 0.0;
        if anchored && apart && !self.nominal.unknown.iter().any(|p| scales.contains(p)) {
            let entry = EffectEntry::new(EffectKind::SensorGain, &[]);
            let (kind, meaning, sign) = (EffectKind::SensorGain, Meaning::Gain, Sign::Within(-0.9, 9.0));
            let term = Term { kind, meaning, sign, state: State::Sensor, variants: Vec::new() };
            jobs.push((term, vec![(entry, self.other_gain())]));
        }
        // A spring holds the mass, whose acceleration has no mean.
        if self.acquired.sensed == Sensed::Acceleration && machine.stiffness_n_per_m > 0.0 {
            let entry = EffectEntry::new(EffectKind::SensorBias, &[(ParameterKey::Value, 1.0)]);
            let source = Source::Sensor(Box::new(|t: &Track| vec![1.0; t.len()]));
            let (kind, meaning) = (EffectKind::SensorBias, Meaning::Strength(ParameterKey::Value));
            let term = Term { kind, meaning, sign: Sign::Any, state: State::Sensor, variants: Vec::new() };
            jobs.push((term, vec![(entry, source)]));
        }
        let longest = self.acquired.under_test().map(|t| t.len() as f64 * t.step_s()).fold(0.0, f64::max);
        if events {
            let times = (3..=21).map(|k| longest * f64::from(k) / 24.0).collect();
            self.strength(jobs, EffectKind::LoadStep, ParameterKey::ChangeN, any, Some((ParameterKey::TimeS, times)));
        }
        let rate = self.acquired.under_test().map(|t| t.sample_rate_hz).fold(f64::INFINITY, f64::min);
        let own = self.acquired.under_test().map(|t| super::acquire::frequency_hz(&t.states)).fold(0.0, f64::max);
        // A wide input moves the mass far above its own frequency.
        let natural = (machine.stiffness_n_per_m / machine.mass_kg).sqrt() / TAU;
        let beyond = if natural > 0.0 { natural.min(own) } else { own };
        let (low, high) = ((12.0 / longest).max(1.6 * beyond), (0.25 * rate).min(20.0 * own));
        // A mode has the mass's acceleration for its input, which must show.
        if high > 2.0 * low && !self.nominal.is_overdamped(self.acquired) {
            let mut variants = Vec::new();
            let steps = ((MODES * (high / low).log2()) as u32).max(15);
            for k in 0..=steps {
                let hz = low * (high / low).powf(f64::from(k) / f64::from(steps));
                for ratio in [0.02, 0.1] {
                    let numbers = [(ParameterKey::FrequencyHz, hz), (ParameterKey::DampingRatio, ratio)];
                    let entry = EffectEntry::new(EffectKind::StructuralResonance, &numbers);
                    let entry = entry.with_number(ParameterKey::Gain, 1.0).with_text(ParameterKey::Channel, "all");
                    let accelerometer = self.nominal.operator(self.acquired.sensed).accelerometer;
                    let source = move |t: &Track| super::flexible::mode(t, hz, ratio, accelerometer);
                    variants.push((entry, Source::Sensor(Box::new(source))));
                }
            }
            let (kind, meaning, sign) = (EffectKind::StructuralResonance, Meaning::Mode, Sign::Within(-30.0, 30.0));
            jobs.push((Term { kind, meaning, sign, state: State::Sensor, variants: Vec::new() }, variants));
        }
    }
}

fn turns_least(known: f64, largest: f64) -> f64 {
    (1e-3 * largest).max(0.5 * known)
}
