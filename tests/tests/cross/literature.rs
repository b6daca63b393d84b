//! Literature: numbers that others published or measured, at the tolerance they support.

use ballrace::model::states::{Scales, rows};
use ballrace::model::stlsq::{RFactor, StlsqConfig, fit};
use ballrace::paper::{PaperLibrary, TABLE_3};
use ballrace::recording::input::Series;
use ballrace::signal::phases::life::Features;
use ballrace::signal::phases::{Rules, phases};
use ballrace_core::library::Library;
use ballrace_core::states::{Alignment, Estimator, Orders, StateSpec};
use ballrace_tests::{femto, white_noise};
use rayon::prelude::*;

#[test]
fn function_counts_of_table_3() {
    for PaperLibrary { sizes: [n_d, n_md, n_f], functions, .. } in TABLE_3 {
        let library = Library::new(n_md, n_d, n_f).unwrap();
        assert_eq!(library.len(), functions, "n_D {n_d}, n_MD {n_md}, n_F {n_f}");
    }
}

/// The paper's aging phase of Bearing 3_3 begins at 3060 s: its recordings are 10 s apart, the first at 10 s.
#[test]
fn bearing_3_3_ages_from_the_recording_that_the_paper_says() {
    let Some(series) = femto("Bearing3_3", "vertical", 0..434) else { return };
    let features = |s: &Series| Features::new(&s.samples.iter().map(|v| f64::from(*v)).collect::<Vec<_>>());
    let life: Vec<Features> = series.iter().map(features).collect();
    let found = phases(&life, &vec![true; life.len()], &Rules::default()).expect("enough recordings");
    assert_eq!(found.aging.map(|index| series[index].name.as_str()), Some("acc_00306"));
}

/// Mean R² over outputs and recordings of plain least squares on standardised states, each recording
/// fitted by itself, in sample.
fn r_squared(recordings: &[Series], alignment: Alignment, dimension: usize, degree: usize, harmonics: usize) -> f64 {
    let spec = StateSpec { dimension, orders: Orders::Even, alignment, estimator: Estimator::Differences };
    let library = Library::new(dimension, degree, harmonics).unwrap();
    let config = StlsqConfig { threshold: Some(0.0), ridge: 0.0, ..StlsqConfig::default() };
    let each = |series: &Series| {
        let mut rows = rows(&series.samples, spec);
        Scales::from_rows(std::slice::from_ref(&rows)).apply(&mut rows);
        let moments = RFactor::from_samples(library, &rows);
        let equations = fit(&moments, &[], &config);
        let scores = equations.iter().enumerate().map(|(o, e)| moments.r_squared(o, &e.coefficients));
        scores.sum::<f64>() / equations.len() as f64
    };
    recordings.par_iter().map(each).sum::<f64>() / recordings.len() as f64
}

/// What was measured about the paper's R², Bearing 3_3 vertical in its aging phase beside white noise.
const MEASURED: [(Alignment, usize, usize, usize, f64, f64); 5] = [
    (Alignment::Forward, 4, 1, 0, 0.997, 0.985),
    (Alignment::Forward, 8, 2, 2, 0.9997, 0.997),
    (Alignment::Half, 4, 1, 0, 0.881, 0.868),
    (Alignment::Half, 8, 1, 0, 0.898, 0.915),
    (Alignment::Half, 8, 2, 2, 0.904, 0.918),
];

#[test]
fn measured_r2_on_white_noise() {
    let noise: Vec<Series> =
        (0..12).map(|k| Series { name: format!("noise {k}"), samples: white_noise(2560, k) }).collect();
    for (alignment, n_md, n_d, n_f, _, expected) in MEASURED {
        let got = r_squared(&noise, alignment, n_md, n_d, n_f);
        assert!((got - expected).abs() < 0.004, "{alignment:?} n_MD {n_md}: {got} for {expected}");
    }
}

#[test]
fn measured_r2_on_bearing_3_3() {
    // The paper's aging phase, 3060 s to 4320 s: 126 recordings, one every ten seconds.
    let Some(all) = femto("Bearing3_3", "vertical", 306..432) else { return };
    let chosen: Vec<Series> = all.into_iter().step_by(6).collect();
    for (alignment, n_md, n_d, n_f, expected, _) in MEASURED {
        let got = r_squared(&chosen, alignment, n_md, n_d, n_f);
        println!("{alignment:?} n_MD {n_md} n_D {n_d} n_F {n_f}: {got:.4} for {expected}");
        assert!((got - expected).abs() < 0.003, "{alignment:?} n_MD {n_md}: {got} for {expected}");
    }
}
