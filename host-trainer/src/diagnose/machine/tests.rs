//! Tests of the diagnosis of machines of unknown structure, on signals made here.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::change::Change;
use super::comb::Comb;
use super::modulation::{Modulation, Tones, bands, partition};
use super::names::is_beyond_healthy;
use super::observation::{Observation, held_out, neighbours};
use super::pattern::Pattern;
use super::synthesis::{Modulator, noise};
use super::{Verdict, diagnose, is_unknown};
use crate::diagnose::Task;
use crate::diagnose::result::DiagnosisResult;
use crate::recording::{Channel, Recording};
use crate::report::diagnosis::verdict;
use crate::rig::Rig;
use crate::rig::test_support::nominal;
use crate::signal::kinematics::Geometry;
use crate::signal::spectrum::{Spectrum, welch};

const RATE: f64 = 12_000.0;

fn unknown_rig() -> Rig {
    let mut rig = nominal();
    rig.unknown = ["inner", "outer", "resonator", "excitation", "sensor"].map(String::from).to_vec();
    rig
}

fn geometry() -> Geometry {
    nominal().bearing().unwrap().bearing.geometry()
}

/// Impacts of a defect.
#[derive(Clone, Copy)]
struct Impacts {
    /// Rate, orders of the shaft.
    order: f64,
    /// Amplitude of a ring; the noise has 1.
    size: f64,
    /// Depth of the modulation once a turn of the shaft.
    turning: f64,
}

/// Machine with noise, two shaft orders, a mode and impacts.
#[derive(Clone, Copy)]
struct Machine {
    seed: u64,
    shaft_hz: f64,
    seconds: f64,
    /// Amplitude of the shaft's first order.
    first: f64,
    /// Gain of everything.
    gain: f64,
    /// Amplitude of noise around 3.4 kHz.
    hiss: f64,
    impacts: Option<Impacts>,
}

const HEALTHY: Machine =
    Machine { seed: 1, shaft_hz: 30.0, seconds: 4.0, first: 0.2, gain: 1.0, hiss: 0.0, impacts: None };

impl Machine {
    fn recording(self) -> Recording {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let count = (self.seconds * RATE) as usize;
        let mut samples: Vec<f64> = (0..count).map(|_| StandardNormal.sample(&mut random)).collect();
        let (mut past, mut before) = (0.0, 0.0);
        for (i, v) in samples.iter_mut().enumerate() {
            let turns = self.shaft_hz * i as f64 / RATE;
            // A lightly damped mode that noise excites.
            let drive: f64 = StandardNormal.sample(&mut random);
            let mode = 2.0 * 0.9 * (TAU * 3400.0 / RATE).cos() * past - 0.81 * before + self.hiss * drive;
            (past, before) = (mode, past);
            *v += mode + self.first * (TAU * turns).cos() + 0.3 * (2.0 * TAU * turns + 1.0).cos();
        }
        if let Some(Impacts { order, size, turning }) = self.impacts {
            let mut turn = random.random_range(0.0..1.0 / order);
            while turn < self.shaft_hz * self.seconds {
                let at = turn / self.shaft_hz * RATE;
                let strength = size * (1.0 + turning * (TAU * turn).cos()) / (1.0 + turning);
                for k in 0..200 {
                    let place = at.ceil() as usize + k;
                    let t = (place as f64 - at) / RATE;
                    if let Some(v) = samples.get_mut(place) {
                        *v += strength * (-600.0 * t).exp() * (TAU * 3400.0 * t).sin();
                    }
                }
                // Balls slip by chance.
                turn += (1.0 + 0.003 * Distribution::<f64>::sample(&StandardNormal, &mut random)) / order;
            }
        }
        samples.iter_mut().for_each(|v| *v *= self.gain);
        let channels = vec![Channel { name: "ay".into(), location: None, samples }];
        Recording { channels, sample_rate_hz: RATE, shaft_hz: Some(self.shaft_hz), ..Recording::default() }
    }
}

/// A machine at five speeds.
fn runs(machine: Machine) -> Vec<Recording> {
    let at = |(n, shaft_hz): (usize, f64)| {
        let first = machine.first * (shaft_hz / 30.0).powi(2);
        Machine { shaft_hz, first, seed: 10 * machine.seed + n as u64, ..machine }.recording()
    };
    [15.0, 20.0, 25.0, 30.0, 40.0].into_iter().enumerate().map(at).collect()
}

fn diagnosed(baseline: Option<&[Recording]>, recordings: &[Recording]) -> DiagnosisResult {
    let rig = unknown_rig();
    diagnose(&Task { rig: &rig, baseline, recordings, seed: 1 }, &|_| ()).unwrap()
}

fn names(outcome: &DiagnosisResult) -> Vec<&str> {
    outcome.diagnosis.causes.iter().map(|c| c.name.as_str()).collect()
}

#[test]
fn a_rig_is_unknown_once_all_masses_and_stiffnesses_are() {
    assert!(is_unknown(&unknown_rig()));
    let mut rig = nominal();
    assert!(!is_unknown(&rig));
    rig.unknown = ["outer", "resonator", "inner.damping_n_s_per_m"].map(String::from).to_vec();
    assert!(!is_unknown(&rig));
}

#[test]
fn invariant_families_add_up_at_any_slip() {
    let geometry = geometry();
    for slip in [-0.01, 0.0, 0.02] {
        let of = |pattern: Pattern| pattern.fundamental(&geometry, slip);
        assert!((of(Pattern::Outer) + of(Pattern::Inner) - geometry.balls as f64).abs() < 1e-9);
        assert!((of(Pattern::Outer) - geometry.balls as f64 * of(Pattern::Cage)).abs() < 1e-9);
    }
}

#[test]
fn pits_are_named_without_a_baseline_and_the_synthesis_is_nearer() {
    let orders = geometry().orders();
    for (order, turning, name) in [(orders.bpfo, 0.0, "outer-race-defect"), (orders.bpfi, 0.8, "inner-race-defect")] {
        let impacts = Some(Impacts { order: 0.998 * order, size: 6.0, turning });
        let outcome = diagnosed(None, &[Machine { impacts, ..HEALTHY }.recording()]);
        assert_eq!(names(&outcome), [name], "{:?}", outcome.diagnosis);
        let fit = &outcome.diagnosis.fit;
        assert!(fit.after < fit.before && fit.after < 4.0 && fit.p_value < 0.01, "{fit:?}");
        let [from, to] = outcome.diagnosis.location.frequency_hz[0];
        assert!((from..to).contains(&3400.0), "{from} {to}");
    }
}

#[test]
fn null_noise_and_impacts_of_another_machine_get_no_name() {
    for seed in 0..6 {
        let outcome = diagnosed(None, &[Machine { seed, ..HEALTHY }.recording()]);
        assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{:?}", outcome.diagnosis);
        // A gear, or a bearing of other geometry.
        let impacts = Some(Impacts { order: 4.31, size: 6.0, turning: 0.0 });
        let outcome = diagnosed(None, &[Machine { seed, impacts, ..HEALTHY }.recording()]);
        assert_eq!(names(&outcome), Vec::<&str>::new(), "{:?}", outcome.diagnosis);
    }
}

#[test]
fn null_healthy_machines_of_one_make_are_quiet() {
    let baseline = runs(HEALTHY);
    // Another mounting: half the gain, and somewhat more of a mode.
    for (gain, hiss) in [(1.0, 0.0), (0.5, 0.3), (1.6, 0.0)] {
        let outcome = diagnosed(Some(&baseline), &runs(Machine { seed: 5, gain, hiss, ..HEALTHY }));
        let named = names(&outcome);
        assert!(named.is_empty() || named == ["sensor-gain"] && hiss == 0.0, "{gain} {hiss} {named:?}");
    }
    let same = diagnosed(Some(&baseline), &runs(Machine { seed: 5, ..HEALTHY }));
    assert_eq!(same.diagnosis.verdict, Verdict::NoMismatch);
    assert_eq!(same.held_out[0].before, same.held_out[0].after);
}

#[test]
fn unbalance_is_the_first_order_at_all_speeds() {
    let outcome = diagnosed(Some(&runs(HEALTHY)), &runs(Machine { seed: 5, first: 0.8, ..HEALTHY }));
    assert_eq!(names(&outcome), ["unbalance"], "{:?}", outcome.diagnosis);
    assert!(outcome.diagnosis.causes[0].parameters.is_empty());
}

#[test]
fn a_pit_at_several_speeds_is_named_against_the_baseline() {
    let impacts = Some(Impacts { order: geometry().orders().bpfo, size: 6.0, turning: 0.0 });
    let outcome = diagnosed(Some(&runs(HEALTHY)), &runs(Machine { seed: 5, impacts, ..HEALTHY }));
    assert_eq!(names(&outcome), ["outer-race-defect"], "{:?}", outcome.diagnosis);
    assert!(outcome.diagnosis.causes[0].evidence.contains("dB over the healthy machine"));
    assert_eq!(outcome.rig, unknown_rig());
}

#[test]
fn noise_has_the_density_and_the_modulation_that_it_is_made_with() {
    let density = Spectrum { step_hz: 100.0, values: (0..61).map(|k| if k > 30 { 4.0 } else { 1.0 }).collect() };
    let lines = vec![(3.2, 0.5), (6.4, 0.3)];
    let modulators: Vec<Modulator> = partition(6000.0, 2)
        .into_iter()
        .map(|band_hz| Modulator { lines: if band_hz.start > 0.0 { lines.clone() } else { Vec::new() }, band_hz })
        .collect();
    assert!((modulators[1].share() - 0.5).abs() < 0.2 && modulators[0].share() == 0.0);
    let made = noise(120_000, RATE, 30.0, &density, &modulators, 3);
    let found = welch(&[made.as_slice()], RATE, 240).unwrap();
    for hz in [1000.0, 5000.0] {
        let (got, wanted) = (found.values[(hz / found.step_hz) as usize], if hz > 3100.0 { 4.0 } else { 1.0 });
        assert!((got / wanted - 1.0).abs() < 0.15, "{hz}: {got}");
    }
    let modulation = Modulation::new(&made, RATE, 30.0, &partition(6000.0, 2), 400.0, Tones::Kept).unwrap();
    for (order, amplitude) in lines {
        let at = (order / modulation.order_step).round() as usize;
        let [still, moved] = [0, 1].map(|band: usize| modulation.bands[band].power[at].sqrt());
        assert!(still < 0.05 && (moved - amplitude).abs() < 0.05, "{order}: {still} {moved}");
    }
}

/// What is done to the samples of a recording at a speed of the shaft, Hz.
type Alteration<'a> = &'a dyn Fn(&mut Vec<f64>, f64);

/// Recordings with their channel `ay` changed.
fn changed(recordings: &[Recording], change: impl Fn(&mut Vec<f64>, f64)) -> Vec<Recording> {
    let mut out = recordings.to_vec();
    out.iter_mut().for_each(|r| change(&mut r.channels[0].samples, r.shaft_hz.unwrap()));
    out
}

/// The shaft's lines are where each recording's own speed has them.
#[test]
fn null_another_speed_is_no_change() {
    let machine = Machine { first: 1.0, ..HEALTHY };
    for shaft_hz in [27.4, 31.0] {
        let now = Machine { seed: 7, shaft_hz, ..machine }.recording();
        let outcome = diagnosed(Some(&[machine.recording()]), &[now]);
        assert_eq!(outcome.diagnosis.verdict, Verdict::NoMismatch, "{shaft_hz}: {:?}", outcome.diagnosis);
    }
}

#[test]
fn faults_of_the_acquisition_are_named() {
    let baseline = runs(HEALTHY);
    let now = runs(Machine { seed: 5, ..HEALTHY });
    let named = |recordings: &[Recording]| {
        let outcome = diagnosed(Some(&baseline), recordings);
        names(&outcome).into_iter().map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(named(&changed(&now, |samples, _| samples.iter_mut().for_each(|v| *v += 30.0))), ["sensor-bias"]);
    let clipped = changed(&now, |samples, _| samples.iter_mut().for_each(|v| *v = v.clamp(-2.5, 2.5)));
    assert_eq!(named(&clipped), ["sensor-clipping"]);
    let held = changed(&now, |samples, _| {
        let last = samples[20_000];
        samples[20_001..20_100].fill(last);
    });
    assert_eq!(named(&held), ["dropped-samples"]);
    let hum = |samples: &mut Vec<f64>, hz: f64| {
        samples.iter_mut().enumerate().for_each(|(k, v)| *v += 0.5 * (TAU * hz * k as f64 / RATE).sin());
    };
    assert_eq!(named(&changed(&now, |samples, _| hum(samples, 50.0))), ["mains-interference"]);
    // A healthy machine with the same is as it was.
    let both =
        |change: &dyn Fn(&mut Vec<f64>, f64)| diagnosed(Some(&changed(&baseline, change)), &changed(&now, change));
    let known: [Alteration; 3] = [
        &|samples, _| samples.iter_mut().for_each(|v| *v += 30.0),
        &|samples, _| samples.iter_mut().for_each(|v| *v = v.clamp(-2.5, 2.5)),
        &|samples, _| hum(samples, 50.0),
    ];
    for change in known {
        assert_eq!(both(change).diagnosis.verdict, Verdict::NoMismatch);
    }
}

/// Half orders are of a loose part, which raises the whole ones too; a rotor out of balance and a defect are two causes.
#[test]
fn looseness_is_no_unbalance_and_two_causes_stand_together() {
    let baseline = runs(HEALTHY);
    let loose = changed(&runs(Machine { seed: 5, first: 2.0, ..HEALTHY }), |samples, shaft_hz| {
        for (k, v) in samples.iter_mut().enumerate() {
            let turn = TAU * shaft_hz * k as f64 / RATE;
            *v += 2.0 * (1..=5).map(|n| (0.5 * f64::from(n) * turn).cos()).sum::<f64>();
        }
    });
    let outcome = diagnosed(Some(&baseline), &loose);
    assert_eq!(names(&outcome), ["end-stop-contact"]);
    let (_, sentence) = verdict(&outcome);
    assert!(
        sentence.starts_with("The machine shows end-stop-contact (looseness: half orders of the shaft "),
        "{sentence}"
    );
    let impacts = Some(Impacts { order: 0.998 * geometry().orders().bpfo, size: 6.0, turning: 0.0 });
    let both = diagnosed(Some(&baseline), &runs(Machine { seed: 6, first: 1.6, impacts, ..HEALTHY }));
    let mut found = names(&both);
    found.sort_unstable();
    assert_eq!(found, ["outer-race-defect", "unbalance"], "{:?}", both.diagnosis);
    let (_, sentence) = verdict(&both);
    for expected in ["outer-race-defect (BPFO ", " dB over the healthy machine in ", "unbalance (15.0 Hz, "] {
        assert!(sentence.contains(expected), "{expected}: {sentence}");
    }
}

/// A mode at 1 kHz of the healthy machine is at 0.9 kHz now.
#[test]
fn a_mode_that_moved_is_a_change_of_stiffness() {
    let ringing = |hz: f64| {
        move |samples: &mut Vec<f64>, shaft_hz: f64| {
            let mut random = ChaCha8Rng::seed_from_u64((7.0 * shaft_hz + hz) as u64);
            let (decay, mut past, mut before) = ((-TAU * hz * 0.01 / RATE).exp(), 0.0, 0.0);
            for v in samples.iter_mut() {
                let drive: f64 = StandardNormal.sample(&mut random);
                let mode = 2.0 * decay * (TAU * hz / RATE).cos() * past - decay * decay * before + 0.3 * drive;
                (past, before) = (mode, past);
                *v += mode;
            }
        }
    };
    let baseline = changed(&runs(HEALTHY), ringing(1000.0));
    let now = runs(Machine { seed: 5, ..HEALTHY });
    let outcome = diagnosed(Some(&baseline), &changed(&now, ringing(900.0)));
    assert_eq!(names(&outcome), ["stiffness-change"], "{:?}", outcome.diagnosis);
    // To half a band of a sixteenth of an octave.
    let [low, high] = outcome.diagnosis.location.frequency_hz[0];
    assert!((low / 900.0 - 1.0).abs() < 0.025 && (high / 1000.0 - 1.0).abs() < 0.025, "{low} {high}");
    let still = diagnosed(Some(&baseline), &changed(&now, ringing(1001.0)));
    assert_eq!(still.diagnosis.verdict, Verdict::NoMismatch, "{:?}", still.diagnosis);
}

/// Friction that is louder above 3 kHz raises neighbouring bands alike, without a line.
#[test]
fn a_wide_change_is_unexplained() {
    let louder = |samples: &mut Vec<f64>, _: f64| {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut last: f64 = 0.0;
        for v in samples.iter_mut() {
            let next: f64 = StandardNormal.sample(&mut random);
            // A difference is louder the higher.
            *v += 1.6 * (next - last);
            last = next;
        }
    };
    let outcome = diagnosed(Some(&runs(HEALTHY)), &changed(&runs(Machine { seed: 5, ..HEALTHY }), louder));
    assert_eq!(outcome.diagnosis.verdict, Verdict::Unexplained, "{:?}", outcome.diagnosis);
    let [from, to] = outcome.diagnosis.location.frequency_hz[0];
    assert!(from > 1000.0 && to > 4000.0, "{from} {to}");
}

#[test]
fn a_comb_has_the_depth_of_its_modulation() {
    let density = Spectrum { step_hz: 6000.0, values: vec![1.0; 2] };
    let order = Pattern::Outer.fundamental(&geometry(), 0.004);
    let modulator = Modulator { band_hz: 0.0..6000.0, lines: vec![(order, 0.4), (2.0 * order, 0.3)] };
    let made = noise(96_000, RATE, 30.0, &density, &[modulator], 1);
    let bands = bands(RATE, geometry().orders().bpfi * 30.0);
    let modulation = Modulation::new(&made, RATE, 30.0, &bands, 600.0, Tones::Limited).unwrap();
    let comb = Comb::find(&[modulation], Pattern::Outer, &geometry(), 1).unwrap();
    assert!((comb.depth - 0.5).abs() < 0.15 && comb.p_value < 0.01, "{comb:?}");
    assert!((comb.slip[0] - 0.004).abs() < 0.001, "{comb:?}");
}

#[test]
fn a_changed_mode_is_beyond_healthy_and_a_changed_gain_is_not() {
    let of = |machine: Machine| runs(machine).iter().map(|r| Observation::new(r).unwrap()).collect::<Vec<_>>();
    let baseline = of(HEALTHY);
    let change = |machine: Machine| Change::new(&of(machine), &baseline, 1).unwrap();
    let louder = change(Machine { seed: 5, gain: 2.0, ..HEALTHY });
    assert!((louder.gain_db - 6.02).abs() < 0.3 && louder.shape_db < 2.0 && !is_beyond_healthy(&louder), "{louder:?}");
    let hissing = change(Machine { seed: 5, hiss: 30.0, ..HEALTHY });
    assert!(is_beyond_healthy(&hissing), "{hissing:?}");
    // Nothing there to be compared with.
    assert_eq!(Change::new(&baseline, &[], 1), None);
}

#[test]
fn the_recording_held_out_is_surrounded_by_the_others() {
    let all: Vec<Observation> = runs(HEALTHY).iter().map(|r| Observation::new(r).unwrap()).collect();
    assert_eq!(held_out(&all).map(|n| all[n].shaft_hz), Some(25.0));
    assert_eq!(held_out(&all[..1]), None);
    let others: Vec<&Observation> = all.iter().filter(|r| r.shaft_hz != 25.0).collect();
    let around = neighbours(&others, 25.0);
    assert_eq!(around.iter().map(|(r, _)| r.shaft_hz).collect::<Vec<_>>(), [20.0, 30.0]);
    assert!((around.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(neighbours(&others, 60.0).len(), 1);
}
