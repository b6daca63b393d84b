//! Events: a shock or a step of the load, once in a recording, at a time of its own.
//!
//! A power spectrum has no time. An event is found in the whitened samples by the rig's response to it, shifted to every time
//! (a matched filter: G. L. Turin, IRE Trans. Inf. Theory 6 (1960) 311–329).

use std::f64::consts::LN_2;
use std::sync::Arc;

use rayon::prelude::*;
use realfft::num_complex::Complex;

use super::observation::{Observation, Power};
use super::prediction::START_ANGLES_RAD;
use super::settings::{EventSettings, GateSettings};
use crate::identify::likelihood::observed::{CHANNELS, padded};
use crate::rig::effect::course::Course;
use crate::rig::effect::{EffectKind, ParameterKey};
use crate::rig::simulate::{fewest_substeps, shortest_settling_s, simulate_all};
use crate::rig::{EffectEntry, OperatingCondition, Rig, RigError, Run, Start};
use crate::signal::coherence::short_time;
use crate::signal::lines::floor;
use crate::signal::transform::{hann, inverse_plan, median};
use crate::stats::significance::Z975;

const SETTINGS: EventSettings = EventSettings::DEFAULT;
const GATE: GateSettings = GateSettings::DEFAULT;

/// Occurrence of an event in a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence {
    /// Time, s.
    pub time_s: f64,
    /// Amplitude over the template's.
    pub amplitude: f64,
    /// Decrease of −ln L.
    pub gain: f64,
    /// Gain over that of the next greatest elsewhere in the recording.
    pub isolation: f64,
    /// Index of the channel that the response is strongest in.
    pub channel: usize,
}

impl Occurrence {
    /// Whether the event happened once, and not by chance.
    pub fn is_event(&self) -> bool {
        self.gain > SETTINGS.gain && self.isolation > SETTINGS.isolation
    }
}

/// Event of a kind in all recordings.
#[derive(Clone, Debug)]
pub struct Event {
    /// Effect of the template with its own time.
    pub effect: EffectEntry,
    /// Best time and size in each recording.
    pub occurrences: Vec<Occurrence>,
    /// Probability among the other kinds.
    pub probability: f64,
    /// Whether templates that gain about as much have about the same size: what a slow change rings with depends on its course.
    pub is_size_known: bool,
}

impl Event {
    /// Gain of the recordings in which it happened.
    pub fn gain(&self) -> f64 {
        self.occurrences.iter().filter(|o| o.is_event()).map(|o| o.gain).sum()
    }

    /// Whether a recording has others as great at several times: bursts, of which one stands out in some recordings by chance.
    fn is_of_many(&self) -> bool {
        let (once, often): (Vec<&Occurrence>, Vec<&Occurrence>) = self.occurrences.iter().partition(|o| o.is_event());
        let mean = self.gain() / once.len().max(1) as f64;
        often.iter().any(|o| o.gain > mean / SETTINGS.isolation)
    }

    /// Ends of the 95 % interval of the size over it, where the response has the template's shape: the information of a size a
    /// is 2 G/a² by theory (96).
    pub fn band(&self) -> [f64; 2] {
        let width = Z975 / (2.0 * self.gain()).sqrt().max(Z975);
        [1.0 - width, 1.0 + width]
    }

    /// Effect with its time and size in a recording.
    pub fn effect_in(&self, recording: usize) -> Option<EffectEntry> {
        let occurrence = self.occurrences.get(recording).filter(|o| o.is_event())?;
        Some(self.scaled(occurrence).with_number(ParameterKey::TimeS, occurrence.time_s))
    }

    /// Effect of the mean size, at the time of the recording with the greatest gain.
    pub fn mean(&self) -> EffectEntry {
        let events: Vec<&Occurrence> = self.occurrences.iter().filter(|o| o.is_event()).collect();
        let best = events.iter().max_by(|a, b| a.gain.total_cmp(&b.gain));
        let weight: f64 = events.iter().map(|o| o.gain).sum();
        let amplitude = events.iter().map(|o| o.gain * o.amplitude).sum::<f64>() / weight.max(1e-9);
        let Some(best) = best else { return self.effect.clone() };
        self.scaled(&Occurrence { amplitude, ..**best }).with_number(ParameterKey::TimeS, best.time_s)
    }

    /// Effect of an occurrence's size.
    fn scaled(&self, occurrence: &Occurrence) -> EffectEntry {
        let size = self.effect.number(self.size()).unwrap_or_default();
        self.effect.clone().with_number(self.size(), size * occurrence.amplitude)
    }

    /// Parameter of the size.
    pub fn size(&self) -> ParameterKey {
        if self.effect.kind == EffectKind::Shock { ParameterKey::ImpulseNS } else { ParameterKey::ChangeN }
    }
}

/// Longer part of a recording before or after an event; after a step of the load it is under the load of then.
pub fn without_event(observation: &Observation, time_s: f64, effect: &EffectEntry) -> Observation {
    let (from_s, to_s) = (time_s - SETTINGS.before_s, time_s + SETTINGS.after_s);
    let mut part = observation.longer_part(from_s, to_s);
    let duration_s = observation.condition.samples as f64 / observation.condition.sample_rate_hz;
    if from_s < duration_s - to_s {
        part.condition.load_n += effect.number(ParameterKey::ChangeN).unwrap_or_default();
    }
    part
}

/// The event of greatest gain of all kinds; `None` without one, or where it is one of many.
///
/// # Errors
/// What the simulation refuses.
pub fn event(rig: &Rig, observations: &[Observation], noise: &[Arc<Power>]) -> Result<Option<Event>, RigError> {
    let greatest_n = observations.iter().map(|o| o.condition.load_n.abs()).fold(1.0, f64::max);
    let templates = templates(greatest_n);
    let whitened: Vec<Whitened> = observations.iter().zip(noise).map(|(o, s)| Whitened::new(o, s)).collect();
    let responses = responses(rig, observations, &templates)?;
    let matched = |(effect, responses): (&EffectEntry, &Vec<Responses>)| {
        let time_s = effect.number(ParameterKey::TimeS).unwrap_or_default();
        let occurrences = whitened.iter().zip(responses).map(|(w, response)| w.matched(response, time_s)).collect();
        Event { effect: effect.clone(), occurrences, probability: GATE.event_probability, is_size_known: true }
    };
    let mut events: Vec<Event> = templates.par_iter().zip(&responses).map(matched).collect();
    events.sort_by(|a, b| b.gain().total_cmp(&a.gain()));
    let Some(best) = events.first().filter(|e| e.gain() > 0.0 && !e.is_of_many()).cloned() else { return Ok(None) };
    let other = events.iter().find(|e| e.effect.kind != best.effect.kind).map_or(0.0, Event::gain);
    let by_rank = 1.0 + ((other - best.gain()) / GATE.model_error_nats(best.gain())).exp();
    let of_kind = events.iter().filter(|e| e.effect.kind == best.effect.kind);
    let alike = of_kind.filter(|e| e.gain() > SETTINGS.alike_gain * best.gain());
    let sizes = alike
        .map(|e| e.mean().number(best.size()).unwrap_or_default() / best.mean().number(best.size()).unwrap_or(1.0));
    let [least, greatest] = sizes.fold([1.0f64, 1.0], |[least, greatest], size| [least.min(size), greatest.max(size)]);
    // The size of a shock, in any duration, is no number of the vocabulary.
    let is_shock = best.effect.kind == EffectKind::Shock;
    let is_size_known = is_shock || least > 0.0 && greatest < SETTINGS.alike_size * least;
    Ok(Some(Event { probability: best.probability / by_rank, is_size_known, ..best }))
}

fn templates(load_n: f64) -> Vec<EffectEntry> {
    use ParameterKey::{ChangeN, Component, DurationS, ImpulseNS, RiseS, Shape, TimeS};
    let step = |rise_s: f64, course: Course| {
        // A lag begins at that time, or much of it would be before the recording.
        let time_s = SETTINGS.template_s + (course.half() - 0.5).max(0.0) * rise_s;
        let numbers = [(TimeS, time_s), (ChangeN, SETTINGS.change_share * load_n), (RiseS, rise_s)];
        EffectEntry::new(EffectKind::LoadStep, &numbers).with_text(Shape, course.name())
    };
    let shock = |duration: f64, component: &str| {
        EffectEntry::new(
            EffectKind::Shock,
            &[(TimeS, SETTINGS.template_s), (ImpulseNS, SETTINGS.impulse_n_s), (DurationS, duration)],
        )
        .with_text(Component, component)
    };
    let places = SETTINGS.places.into_iter();
    let shocks = places.flat_map(|place| SETTINGS.durations_s.into_iter().map(move |d| shock(d, place)));
    let steps = Course::ALL.into_iter().flat_map(|course| SETTINGS.rises_s(course).iter().map(move |r| (*r, course)));
    let steps = steps.map(|(rise_s, course)| step(rise_s, course));
    steps.chain(shocks).collect()
}

/// Responses of both channels, from the event's time less [`EventSettings::template_s`].
type Responses = [Vec<f64>; 2];

/// Response of each recording's rig to each template.
fn responses(
    rig: &Rig,
    observations: &[Observation],
    templates: &[EffectEntry],
) -> Result<Vec<Vec<Responses>>, RigError> {
    let rigs: Vec<Rig> = templates.iter().map(|effect| rig.clone().with_effect(effect.clone())).collect();
    let [cage, shaft] = START_ANGLES_RAD;
    let mut runs = Vec::new();
    for o in observations {
        let samples = ((SETTINGS.template_s + SETTINGS.response_s) * o.condition.sample_rate_hz) as usize;
        let condition = OperatingCondition { samples: samples.min(o.condition.samples), ..o.condition };
        for rig in std::iter::once(rig).chain(&rigs) {
            let start = Start {
                substeps: Some(fewest_substeps(rig, None, &condition)),
                settle_s: shortest_settling_s(rig),
                ..Start::noise_free(cage, shaft)
            };
            runs.push(Run { rig, condition, start });
        }
    }
    let made = simulate_all(&runs)?.into_iter().collect::<Result<Vec<_>, _>>()?;
    let signals: Vec<Responses> = made
        .iter()
        .map(|r| CHANNELS.map(|name| r.channel(name).map_or_else(Vec::new, |c| c.samples.clone())))
        .collect();
    let of = |template: usize| {
        let each = signals.chunks(1 + templates.len());
        each.map(|chunk| {
            let (still, moved) = (&chunk[0], &chunk[1 + template]);
            [0, 1].map(|c| moved[c].iter().zip(&still[c]).map(|(m, s)| m - s).collect())
        })
        .collect()
    };
    Ok((0..templates.len()).map(of).collect())
}

/// Spectra of a recording over its noise.
struct Whitened {
    /// X/S of each channel.
    spectra: [Option<Vec<Complex<f64>>>; 2],
    /// Noise, lines, and what else the recording has all the time.
    noise: Power,
    samples: usize,
    sample_rate_hz: f64,
}

impl Whitened {
    fn new(o: &Observation, noise: &Power) -> Self {
        let n = o.condition.samples;
        let scale = 1.0 / (n as f64).sqrt();
        let noise = [0, 1].map(|c| match &o.power[c] {
            Some(power) => above_usual(&noise[c], power, &usual_power(o.samples[c].as_deref().unwrap_or_default())),
            None => noise[c].clone(),
        });
        let spectra = [0, 1].map(|c| {
            let flank = (SETTINGS.flank_s * o.condition.sample_rate_hz) as usize;
            let spectrum = padded(&faded(o.samples[c].as_deref()?, flank), n, scale);
            let last = spectrum.len() - 1;
            let of =
                |(k, x): (usize, Complex<f64>)| if k == 0 || k == last { Complex::default() } else { x / noise[c][k] };
            Some(spectrum.into_iter().enumerate().map(of).collect())
        });
        Self { spectra, noise, samples: n, sample_rate_hz: o.condition.sample_rate_hz }
    }

    /// Best time and size of a response, whose template's event is at `time_s`.
    fn matched(&self, response: &Responses, time_s: f64) -> Occurrence {
        let (n, scale) = (self.samples, 1.0 / (self.samples as f64).sqrt());
        let mut energies = [0.0; 2];
        let mut product = vec![Complex::default(); n / 2 + 1];
        for (((spectrum, noise), response), energy) in
            self.spectra.iter().zip(self.noise.iter()).zip(response).zip(&mut energies)
        {
            let Some(spectrum) = spectrum else { continue };
            let template = padded(response, n, scale);
            for k in 1..template.len().min(product.len()).saturating_sub(1) {
                *energy += template[k].norm_sqr() / noise[k];
                product[k] += spectrum[k] * template[k].conj();
            }
        }
        let energy: f64 = energies.iter().sum();
        let inverse = inverse_plan(n);
        let mut correlation = inverse.make_output_vec();
        // Both buffers have the transform's length; twice the sum over positive frequencies comes out.
        inverse.process(&mut product, &mut correlation).unwrap_or_default();
        let gains: Vec<f64> = correlation.iter().map(|v| (0.5 * v).powi(2) / energy.max(1e-300)).collect();
        let Peak { at, gain, isolation } = Peak::of(&gains, self.sample_rate_hz);
        Occurrence {
            time_s: at as f64 / self.sample_rate_hz + time_s,
            amplitude: 0.5 * correlation[at] / energy.max(1e-300),
            gain,
            isolation,
            channel: usize::from(energies[1] > energies[0]),
        }
    }
}

/// Samples that fade in and out, so that little of a line is beside its frequency.
fn faded(samples: &[f64], flank: usize) -> Vec<f64> {
    let window = hann(2 * flank);
    let last = samples.len().saturating_sub(1);
    let weight = |n: usize| window.get(n.min(last - n)).filter(|_| n.min(last - n) < flank).copied().unwrap_or(1.0);
    samples.iter().enumerate().map(|(n, v)| weight(n) * v).collect()
}

/// Noise that is greater where a recording has more all the time, its `usual` power, and by as much as lines stand out of it: a
/// response that takes long has frequencies of lines and of what a loose part does, and they would be one at any time.
fn above_usual(noise: &[f64], power: &[f64], usual: &[f64]) -> Vec<f64> {
    let floor = floor(power, SETTINGS.line_reach);
    let of = |(((noise, power), floor), usual): (((&f64, &f64), &f64), &f64)| {
        let ratio = power / floor.max(f64::MIN_POSITIVE);
        // An event raises the floor, a line the usual power around it.
        let background = noise.max(floor.min(*usual));
        if ratio > SETTINGS.line_ratio { background * ratio } else { background }
    };
    noise.iter().zip(power).zip(&floor).zip(usual).map(of).collect()
}

/// Power at each frequency in the median over parts of a recording, most of which have no event.
fn usual_power(samples: &[f64]) -> Vec<f64> {
    if samples.len() < 2 * SETTINGS.parts {
        return vec![0.0; samples.len() / 2 + 1];
    }
    let window = hann(samples.len() / SETTINGS.parts);
    let squares: f64 = window.iter().map(|w| w * w).sum();
    let rows = short_time(samples, &window, window.len() / 2);
    let of = |row: &Vec<Complex<f64>>| {
        // Powers of noise are exponential.
        median(&mut row.iter().map(|x| x.norm_sqr() / squares).collect::<Vec<_>>()).unwrap_or(0.0) / LN_2
    };
    let usual: Vec<f64> = rows.iter().map(of).collect();
    let last = usual.len().saturating_sub(1);
    let at = |k: usize| usual.get((k * window.len() / samples.len().max(1)).min(last)).copied().unwrap_or(0.0);
    (0..=samples.len() / 2).map(at).collect()
}

/// Greatest gain over all times, as in an [`Occurrence`].
struct Peak {
    at: usize,
    gain: f64,
    isolation: f64,
}

impl Peak {
    /// Peak of the gain at each sample less [`EventSettings::template_s`].
    fn of(gains: &[f64], sample_rate_hz: f64) -> Self {
        let reach = (SETTINGS.response_s * sample_rate_hz) as usize;
        // What begins later is hardly in the recording, and the jump from its end to its beginning looks like a step of the load.
        let last = gains.len().saturating_sub(reach / 2 + (SETTINGS.template_s * sample_rate_hz) as usize);
        // So does a line that fades in.
        let first = ((SETTINGS.flank_s * sample_rate_hz) as usize).min(last);
        let at = (first..last).max_by(|a, b| gains[*a].total_cmp(&gains[*b])).unwrap_or_default();
        // The greatest gain of each stretch away from it.
        let guard = (SETTINGS.guard_s * sample_rate_hz) as usize;
        let stretches = gains[first..last].chunks(guard.max(1)).enumerate();
        let away = stretches.filter(|(n, _)| (first + *n * guard).abs_diff(at) > 2 * guard);
        let greatest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        let mut others: Vec<f64> = away.map(|(_, values)| greatest(values)).collect();
        // Near either end that jump is another.
        let is_near_end = at < reach || at + reach > last;
        let jump = if is_near_end { greatest(&gains[last..]) } else { 0.0 };
        let most = greatest(&others).max(jump);
        let usual = median(&mut others).unwrap_or(0.0);
        let most_here = gains.get(at).copied().unwrap_or_default();
        Self { at, gain: most_here - usual, isolation: most_here / most.max(1e-9) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::diagnose::spectral::data::Data;
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::simulate;
    use crate::rig::test_support::{condition, nominal};

    fn event_of(rig: &Rig, observations: &[Observation]) -> Option<Event> {
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let data = Data::new(observations, orders, UnevenMachines::default());
        let point = Model::fixed(&data, rig.clone()).start().unwrap();
        let noise: Vec<_> = point.predictions.iter().map(|p| Arc::clone(&p.noise)).collect();
        event(rig, observations, &noise).unwrap()
    }

    /// A slow tone ends elsewhere than it began; a Fourier transform sees a jump from the end to the beginning.
    #[test]
    fn null_ends_that_differ_are_no_event() {
        let rig = nominal();
        for (seed, hz) in [(1, 3.37), (3, 61.7), (7, 17.21), (11, 43.3), (13, 97.9), (17, 29.1)] {
            let recording = simulate(&rig, &condition(30.3, 800.0, 25_600), &Start::seeded(seed)).unwrap();
            let phase = |n: usize| TAU * hz * n as f64 / recording.sample_rate_hz + seed as f64;
            let with_tone = |_: usize, samples: &[f64]| -> Vec<f64> {
                samples.iter().enumerate().map(|(n, v)| v + 0.4 * phase(n).cos()).collect()
            };
            let observation = Observation::new(&Observed::from_recording(&recording).unwrap());
            let found = event_of(&rig, &[observation.with_samples(with_tone)]);
            assert!(found.is_none(), "{hz} Hz: {found:?}");
        }
    }

    /// A load that follows a step slowly rings little, in the band of the lines of a bent shaft, where a shock would be a worse answer.
    #[test]
    fn a_slow_change_of_the_load_beside_lines_is_a_step() {
        use ParameterKey::{ChangeN, ForceN, RiseS, Shape, TimeS};
        let bent = EffectEntry::new(EffectKind::Misalignment, &[(ForceN, 60.0)]);
        let observed = |rig: &Rig| {
            let recording = simulate(rig, &condition(30.3, 800.0, 25_600), &Start::seeded(7)).unwrap();
            Observation::new(&Observed::from_recording(&recording).unwrap())
        };
        let rig = nominal().with_effect(bent);
        for (course, change_n, rise_s) in [(Course::FirstOrder, 150.0, 5e-3), (Course::SecondOrder, 400.0, 9e-3)] {
            let numbers = [(TimeS, 0.4), (ChangeN, change_n), (RiseS, rise_s)];
            let step = EffectEntry::new(EffectKind::LoadStep, &numbers).with_text(Shape, course.name());
            let found = event_of(&nominal(), &[observed(&rig.clone().with_effect(step))]).unwrap();
            let time_s = found.mean().number(TimeS).unwrap();
            assert!(found.effect.kind == EffectKind::LoadStep && (time_s - 0.4).abs() < 0.02, "{found:?}");
            assert!(found.probability > 0.7, "{}", found.probability);
            let change_n = found.mean().number(ChangeN).unwrap() / change_n;
            assert!(!found.is_size_known || (change_n - 1.0).abs() < 0.3, "{change_n}");
        }
        assert!(event_of(&nominal(), &[observed(&rig)]).is_none());
    }

    /// A burst of noise stands out by itself, and is one of many where another recording has several.
    #[test]
    fn null_one_of_many_bursts_is_no_event() {
        let rig = nominal();
        let with_bursts = |seed: u64, times_s: &[f64]| {
            let recording = simulate(&rig, &condition(30.3, 800.0, 25_600), &Start::seeded(seed)).unwrap();
            let of = |_: usize, samples: &[f64]| -> Vec<f64> {
                let burst = |n: usize, at_s: f64| {
                    let after_s = n as f64 / 25_600.0 - at_s;
                    10.0 * (TAU * 1500.0 * after_s).cos() * (-after_s.abs() / 1e-3).exp()
                };
                let sum = |n: usize| times_s.iter().map(|at_s| burst(n, *at_s)).sum::<f64>();
                samples.iter().enumerate().map(|(n, v)| v + sum(n)).collect()
            };
            Observation::new(&Observed::from_recording(&recording).unwrap()).with_samples(of)
        };
        let one = || with_bursts(3, &[0.4]);
        assert!(event_of(&rig, &[one(), with_bursts(4, &[])]).is_some());
        assert!(event_of(&rig, &[one(), with_bursts(4, &[0.2, 0.35, 0.5, 0.7])]).is_none());
    }

    /// Gains of a second at 25.6 kHz, flat but for peaks of a millisecond.
    fn isolation(peaks: &[(f64, f64)]) -> f64 {
        let rate = 25_600.0;
        let of = |n: usize| {
            let near = |(at_s, _): &&(f64, f64)| (n as f64 / rate - at_s).abs() < 5e-4;
            peaks.iter().find(near).map_or(1.0, |(_, gain)| *gain)
        };
        Peak::of(&(0..25_600).map(of).collect::<Vec<_>>(), rate).isolation
    }

    #[test]
    fn near_an_end_the_jump_to_the_beginning_is_another_peak() {
        let is_isolated = |at_s: f64, jump: f64| isolation(&[(at_s, 100.0), (0.99, jump)]) > SETTINGS.isolation;
        for at_s in [0.05, 0.9] {
            assert!(is_isolated(at_s, 10.0) && !is_isolated(at_s, 80.0) && !is_isolated(at_s, 200.0), "{at_s}");
        }
        assert!(is_isolated(0.5, 200.0));
        assert!(isolation(&[(0.5, 100.0), (0.7, 80.0)]) < SETTINGS.isolation, "two of a train");
    }
}
