use super::*;
use crate::signal::surrogate::SurrogateKind;
use ballrace_core::network::Arithmetic;
use ballrace_core::states::Orders;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn noise(count: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..count).map(|_| (0..12).map(|_| rng.random_range(-0.5..0.5f32)).sum()).collect()
}

fn recordings(make: impl Fn(u64) -> Vec<f32>) -> Vec<Series> {
    (0..10).map(|k| Series { name: format!("r{k}"), samples: make(k) }).collect()
}

fn config(solver: Solver) -> FitConfig {
    FitConfig {
        spec: StateSpec {
            dimension: 3,
            orders: Orders::Even,
            alignment: Alignment::Half,
            estimator: Estimator::Differences,
        },
        degree: 3,
        harmonics: 0,
        powers: false,
        latent: None,
        solver,
        arithmetic: Arithmetic::Float,
        hold_out_every: 5,
        null_fits: 5,
        null_kind: SurrogateKind::default(),
        causal: true,
        trainings: 2,
        seed: 1,
        ..FitConfig::default()
    }
}

fn stlsq() -> Solver {
    Solver::Stlsq(StlsqConfig::default())
}

fn quick_network() -> Solver {
    let train = TrainConfig { max_steps: Some(150), batch: 256, ..TrainConfig::default() };
    Solver::SindyNn { hidden: vec![16], train }
}

#[test]
fn recordings_of_one_name_in_two_folders_are_held_out_each_by_itself() {
    let made = recordings(|k| noise(2000, k));
    let alike: Vec<Series> = made
        .iter()
        .enumerate()
        .map(|(n, s)| Series { name: format!("r{}", n % 6), samples: s.samples.clone() })
        .collect();
    let monitor = |recordings: &[Series]| {
        let config = FitConfig { null_fits: 0, ..config(stlsq()) };
        fit(recordings, 25_600.0, &config, &|_| ()).unwrap().report.monitor
    };
    assert_eq!(monitor(&made), monitor(&alike));
}

#[test]
fn null_on_white_noise_the_verdict_is_nothing() {
    for solver in [stlsq(), quick_network()] {
        let made = recordings(|k| noise(2000, k));
        let fitted = fit(&made, 25_600.0, &config(solver), &|_| ()).unwrap();
        assert!(!fitted.report.verdict.beyond_null, "{}", fitted.report.verdict.words);
        assert!(fitted.report.verdict.words.starts_with("nothing beyond the null"));
        assert_eq!(fitted.report.scores.null.len(), 5);
    }
}

#[test]
fn null_on_linear_noise_the_verdict_is_nothing_though_r2_is_high() {
    // A resonance driven by noise: its spectrum is all there is to it.
    let made = recordings(|k| {
        let (mut a, mut b) = (0.0f32, 0.0f32);
        let drive = noise(2000, 50 + k);
        drive
            .iter()
            .map(|e| {
                let x = 1.6 * a - 0.9 * b + e;
                b = a;
                a = x;
                x
            })
            .collect()
    });
    let fitted = fit(&made, 25_600.0, &config(stlsq()), &|_| ()).unwrap();
    assert!(fitted.report.scores.causal.next_sample.unwrap() > 0.8);
    assert!(!fitted.report.verdict.beyond_null, "{}", fitted.report.verdict.words);
}

#[test]
fn null_on_tones_in_noise_the_verdict_is_nothing() {
    for scale in [1.0, 0.1] {
        let made = recordings(|k| {
            let tone =
                |i: usize, frequency: f32, phase: f32| (std::f32::consts::TAU * (frequency * i as f32 + phase)).sin();
            let noise = noise(2000, 90 + k);
            let turn = k as f32 * 0.37;
            (0..2000).map(|i| tone(i, 0.0313, turn) + 0.5 * tone(i, 0.171, 2.0 * turn) + scale * noise[i]).collect()
        });
        let fitted = fit(&made, 25_600.0, &config(stlsq()), &|_| ()).unwrap();
        assert!(!fitted.report.verdict.beyond_null, "{scale}: {}", fitted.report.verdict.words);
    }
}

#[test]
fn null_on_skewed_noise_the_verdict_is_nothing_in_twelve_of_twelve() {
    for seed in 0..12 {
        // Innovations of exponential distribution, white.
        let made = recordings(|k| {
            let mut rng = ChaCha8Rng::seed_from_u64(1000 * seed + k);
            (0..2000).map(|_| -(1.0 - rng.random_range(0.0..1.0f32)).ln()).collect()
        });
        let fitted = fit(&made, 25_600.0, &FitConfig { seed, ..config(stlsq()) }, &|_| ()).unwrap();
        assert!(!fitted.report.verdict.beyond_null, "{seed}: {}", fitted.report.verdict.words);
    }
}

#[test]
fn null_on_skewed_noise_whose_level_swings_the_verdict_is_nothing_but_by_stationary_surrogates() {
    let mut of_phase = 0;
    for seed in 0..6 {
        let made = recordings(|k| {
            let mut rng = ChaCha8Rng::seed_from_u64(1000 * seed + k);
            let (mut a, mut b) = (0.0f32, 0.0f32);
            let step = |t: usize| {
                let skewed = -(1.0 - rng.random_range(0.0..1.0f32)).ln() - 1.0;
                let gaussian: f32 = (0..12).map(|_| rng.random_range(-0.5..0.5f32)).sum();
                let level = (1.0 + 0.95 * (0.06 * t as f32 + k as f32).cos()).powi(3);
                (b, a) = (a, 1.2 * a - 0.7 * b + level * (0.3 * gaussian + skewed));
                a
            };
            (0..2000).map(step).collect()
        });
        let beyond = |null_kind: SurrogateKind| {
            let config = FitConfig { seed, null_kind, ..config(stlsq()) };
            fit(&made, 25_600.0, &config, &|_| ()).unwrap().report.verdict.beyond_null
        };
        assert!(!beyond(SurrogateKind::default()), "{seed}");
        of_phase += u32::from(beyond(SurrogateKind::Phase));
    }
    assert!(of_phase > 0, "stationary Gaussian surrogates pass too, so the recordings test nothing");
}

#[test]
fn a_deterministic_map_is_found_beyond_its_null() {
    // The Hénon map: white-looking spectrum, next sample a quadratic of the last two.
    let made = recordings(|k| {
        let (mut x, mut y) = (0.1 + 0.01 * k as f32, 0.1);
        (0..2000)
            .map(|_| {
                let next = 1.0 - 1.4 * x * x + y;
                y = 0.3 * x;
                x = next;
                x
            })
            .collect()
    });
    let config = FitConfig {
        spec: StateSpec {
            dimension: 2,
            orders: Orders::Consecutive,
            alignment: Alignment::Causal,
            estimator: Estimator::Differences,
        },
        degree: 2,
        ..config(stlsq())
    };
    let fitted = fit(&made, 1000.0, &config, &|_| ()).unwrap();
    assert!(fitted.report.verdict.beyond_null, "{}", fitted.report.verdict.words);
    assert!(fitted.report.scores.causal.next_sample.unwrap() > 0.9999);
    // In a and its backward difference d: x' − x = 1 − x − 1.4 x² + 0.3 (x − d), so z0, z1, z0² and the constant.
    let first = &fitted.report.equations[0];
    let mut names: Vec<_> = first.terms.iter().map(|t| t.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["1", "z0", "z0^2", "z1"]);
    let coefficient = |name: &str| first.terms.iter().find(|t| t.name == name).unwrap().physical.unwrap();
    assert!((coefficient("z0^2") + 1.4).abs() < 1e-3, "in physical units: {}", coefficient("z0^2"));
    assert!((coefficient("z1") + 0.3).abs() < 1e-3);
    assert!((first.terms.iter().map(|t| t.share).sum::<f64>() - 1.0).abs() < 1e-9);
}

#[test]
fn same_seed_same_bits() {
    let made = recordings(|k| noise(600, k));
    for solver in [stlsq(), quick_network()] {
        let config = FitConfig { null_fits: 2, ..config(solver) };
        let run = || fit(&made, 25_600.0, &config, &|_| ()).unwrap();
        assert_eq!(run(), run());
    }
}

#[test]
fn what_cannot_be_fitted_is_refused_before_anything_long() {
    let good = recordings(|k| noise(600, k));
    let refuse = |made: &[Series], config: FitConfig| fit(made, 25_600.0, &config, &|_| ()).unwrap_err();
    let mut broken = good.clone();
    broken[3].samples[17] = f32::NAN;
    let error = refuse(&broken, config(stlsq())).to_string();
    assert_eq!(error, "r3, sample 17: found NaN, expected a finite number");
    assert!(matches!(refuse(&[], config(stlsq())), FitError::TooShort { found: 0, .. }));
    assert!(matches!(refuse(&good, FitConfig { degree: 12, ..config(stlsq()) }), FitError::Library { .. }));
    let spec = StateSpec { dimension: 17, ..config(stlsq()).spec };
    assert!(matches!(refuse(&good, FitConfig { spec, ..config(stlsq()) }), FitError::Dimension { found: 17 }));
    let solver = Solver::SindyNn { hidden: vec![], train: TrainConfig::default() };
    assert!(matches!(refuse(&good, config(solver)), FitError::Hidden { .. }));
    let block = FitConfig { block: Some(0), ..config(stlsq()) };
    assert!(matches!(refuse(&good, block), FitError::Block { found: 0, .. }));
    assert!(matches!(refuse(&good, FitConfig { full_scale: -1.0, ..config(stlsq()) }), FitError::FullScale { .. }));
    let flat = recordings(|_| vec![2.5; 600]);
    assert!(matches!(refuse(&flat, config(stlsq())), FitError::Constant { .. }));
}

#[test]
fn a_full_scale_that_is_not_stated_is_far_above_the_healthy_recordings() {
    let made = recordings(|k| noise(2000, 40 + k));
    let greatest = made.iter().flat_map(|s| &s.samples).fold(0.0f32, |greatest, sample| greatest.max(sample.abs()));
    for (stated, expected) in [(0.0, 64.0 * greatest), (7.5, 7.5)] {
        let config = FitConfig { full_scale: stated, null_fits: 0, ..config(stlsq()) };
        assert_eq!(fit(&made, 25_600.0, &config, &|_| ()).unwrap().model.view().screen.full_scale, expected);
    }
}

#[test]
fn fixed_point_scores_as_single_precision_does() {
    let made = recordings(|k| {
        let noise = noise(2000, 20 + k);
        (0..2000).map(|i| (0.4 * i as f32 + k as f32).sin() + 0.3 * noise[i]).collect()
    });
    let base = FitConfig { null_fits: 0, trainings: 1, ..config(quick_network()) };
    let [float, fixed] = [Arithmetic::Float, Arithmetic::Fixed]
        .map(|arithmetic| fit(&made, 25_600.0, &FitConfig { arithmetic, ..base.clone() }, &|_| ()).unwrap());
    let networks = |fitted: &Fitted| {
        let model = fitted.model.view();
        [model.encoder.arithmetic(), model.decoder.arithmetic()]
    };
    assert_eq!(networks(&float), [Arithmetic::Float; 2]);
    assert_eq!(networks(&fixed), [Arithmetic::Fixed; 2]);
    let scores = |fitted: &Fitted| {
        let scores = &fitted.report.scores;
        [scores.held_out.derivatives.clone(), vec![scores.causal.next_sample.unwrap()]].concat()
    };
    for (float, fixed) in scores(&float).into_iter().zip(scores(&fixed)) {
        assert!((float - fixed).abs() < 1e-3, "{float} {fixed}");
    }
    let deep = Solver::SindyNn { hidden: vec![8, 8], train: TrainConfig::default() };
    let refused = fit(&made, 25_600.0, &FitConfig { solver: deep, arithmetic: Arithmetic::Fixed, ..base }, &|_| ());
    assert!(matches!(refused, Err(FitError::FixedPoint(_))));
}
