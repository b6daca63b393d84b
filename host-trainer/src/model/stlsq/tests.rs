use super::*;
use crate::model::samples::Samples;
use ballrace_core::library::Library;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn normal(rng: &mut ChaCha8Rng) -> f32 {
    let (u, v): (f32, f32) = (rng.random_range(1e-7..1.0), rng.random_range(0.0..1.0));
    (-2.0 * u.ln()).sqrt() * (std::f32::consts::TAU * v).cos()
}

/// Samples of ẋ0 = 0.5 − 2 x1 + 0.7 x0 x1 + noise, ẋ1 = 1.5 sin x0 + noise.
fn known(count: usize, noise: f32, seed: u64) -> Samples<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut samples = Samples { inputs: 2, ..Default::default() };
    for _ in 0..count {
        let (a, b) = (normal(&mut rng), normal(&mut rng));
        samples.x.extend([a, b]);
        let y = [0.5 - 2.0 * b + 0.7 * a * b, 1.5 * a.sin()];
        samples.dx.extend(y.map(|y| y + noise * normal(&mut rng)));
    }
    samples
}

fn library() -> Library {
    Library::new(2, 3, 2).unwrap()
}

fn names(equation: &Equation) -> Vec<String> {
    let used = equation.coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
    used.map(|(t, _)| library().term(t).unwrap().to_string()).collect()
}

#[test]
fn finds_the_terms_and_their_coefficients() {
    let parts: Vec<_> = (0..5).map(|k| RFactor::from_samples(library(), &known(3000, 0.1, k))).collect();
    let train = RFactor::merge(&parts[..3].iter().collect::<Vec<_>>()).unwrap();
    let equations = fit(&train, &parts[3..], &StlsqConfig::default());
    assert_eq!(names(&equations[0]), ["1", "z1", "z0·z1"]);
    assert_eq!(names(&equations[1]), ["sin(z0)"]);
    let c = &equations[0].coefficients;
    assert!((c[0] - 0.5).abs() < 0.01 && (c[2] + 2.0).abs() < 0.01 && (c[4] - 0.7).abs() < 0.01);
    assert_eq!(train.rows, 9000);
}

#[test]
fn moments_say_what_the_rows_say() {
    let samples = known(700, 0.3, 9);
    // Blocks of other sizes, merged, must give the same.
    let cut = 2 * 233;
    let first = Samples { inputs: 2, x: samples.x[..cut].to_vec(), dx: samples.dx[..cut].to_vec() };
    let second = Samples { inputs: 2, x: samples.x[cut..].to_vec(), dx: samples.dx[cut..].to_vec() };
    let parts = RFactor::from_each(library(), &[first, second]);
    let merged = RFactor::merge(&parts.iter().collect::<Vec<_>>()).unwrap();
    let coefficients: Vec<f64> = (0..library().len()).map(|t| 0.1 * t as f64 - 0.5).collect();
    let mut theta = vec![0.0; library().len()];
    for output in 0..2 {
        let (mut square, mut sum, mut sum2) = (0.0, 0.0, 0.0);
        for s in 0..samples.len() {
            let (x, dx) = samples.row(s);
            library().row(x, &mut theta);
            let y = f64::from(dx[output]);
            let predicted: f64 = theta.iter().zip(&coefficients).map(|(t, c)| f64::from(*t) * c).sum();
            square += (y - predicted).powi(2);
            sum += y;
            sum2 += y * y;
        }
        let n = samples.len() as f64;
        assert!((merged.mean_square_error(output, &coefficients) - square / n).abs() < 1e-9 * square / n);
        assert!((merged.variance(output) - (sum2 / n - (sum / n).powi(2))).abs() < 1e-9);
    }
}

#[test]
fn a_threshold_means_the_same_for_every_record_length_and_unit() {
    let config = StlsqConfig { threshold: Some(1e-3), ..Default::default() };
    for count in [2_000, 40_000] {
        for unit in [1.0, 1e-3, 1e4] {
            let mut samples = known(count, 0.3, 3);
            samples.dx.iter_mut().for_each(|v| *v *= unit);
            let equations = fit(&RFactor::from_samples(library(), &samples), &[], &config);
            assert_eq!(names(&equations[0]), ["1", "z1", "z0·z1"], "{count} {unit}");
        }
    }
}

#[test]
fn null_noise_keeps_hardly_anything() {
    let config = StlsqConfig::default();
    let states: Vec<_> = (0..6).map(|k| known(3000, 0.1, k)).collect();
    let others: Vec<_> = (10..16).map(|k| known(3000, 0.1, k)).collect();
    let parts = RFactor::from_each(library(), &states);
    let train = RFactor::merge(&parts[..4].iter().collect::<Vec<_>>()).unwrap();
    let equations = fit(&train, &parts[4..], &config);
    // The constant is no noise: these targets have a mean.
    assert!(noise_terms(library(), &states, &others, &equations, &config) <= 1.0);
}

#[test]
fn inseparable_terms_are_named() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    // |x| ≪ 1: sin x is x.
    let x: Vec<f32> = (0..2000).map(|_| 0.01 * normal(&mut rng)).collect();
    let dx = x.iter().map(|x| 3.0 * x + 0.01 * normal(&mut rng)).collect();
    let library = Library::new(1, 1, 1).unwrap();
    let moments = RFactor::from_samples(library, &Samples { inputs: 1, x, dx });
    let equations = fit(&moments, &[], &StlsqConfig { threshold: Some(0.0), ..Default::default() });
    let diagnosis = diagnose(&moments, &equations);
    assert!(diagnosis.inseparable.iter().any(|(a, b, _)| (*a, *b) == (1, 2)), "{diagnosis:?}");
    assert!(diagnosis.condition_number > 1e3);
}

#[test]
fn invariant_rows_given_as_matrices_have_the_factor_of_core_s_library() {
    use faer::Mat;
    let samples = known(5000, 0.3, 5);
    let mut theta = Mat::zeros(samples.len(), library().len());
    let mut row = vec![0.0; library().len()];
    for s in 0..samples.len() {
        library().row(samples.row(s).0, &mut row);
        row.iter().enumerate().for_each(|(t, v)| theta[(s, t)] = f64::from(*v));
    }
    let targets = Mat::from_fn(samples.len(), 2, |s, o| f64::from(samples.row(s).1[o]));
    let coefficients: Vec<f64> = (0..library().len()).map(|t| 0.2 - 0.05 * t as f64).collect();
    // Too few rows for the Gram matrix, and enough.
    for count in [50, 5000] {
        let first = Samples { inputs: 2, x: samples.x[..2 * count].to_vec(), dx: samples.dx[..2 * count].to_vec() };
        let own = RFactor::from_samples(library(), &first);
        let given = RFactor::from_matrices(theta.as_ref().subrows(0, count), targets.as_ref().subrows(0, count));
        assert_eq!((given.rows, given.outputs()), (count, 2));
        let [a, b] = [&given, &own].map(|factor| factor.mean_square_error(1, &coefficients));
        assert!((a - b).abs() < 1e-9 * b, "{count}: {a} {b}");
    }
}
