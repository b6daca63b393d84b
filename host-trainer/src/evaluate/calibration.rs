//! Score of the stated probabilities, and of the held-out signals as anyone can measure them.

use std::path::Path;

use serde::Serialize;

use super::settings::EvaluationSettings;
use crate::diagnose::write::HELD_OUT;
use crate::identify::calibrate::distance::log_spectral;

const SETTINGS: EvaluationSettings = EvaluationSettings::DEFAULT;

/// Cause that a diagnosis names, with its probability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Said {
    /// Name in the vocabulary.
    pub name: String,
    /// Stated probability.
    pub probability: f64,
    /// Whether it is a hidden one, or the same physics.
    pub right: bool,
}

/// Bin of a reliability diagram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Lower end of the stated probabilities; the bin below ends there.
    pub from: f64,
    /// Upper end; 1 belongs to the last bin.
    pub to: f64,
    /// Number of causes named with a probability in it.
    pub count: usize,
    /// Mean of their probabilities.
    pub said: f64,
    /// Share of them that is right.
    pub right: f64,
}

/// Brier score of stated probabilities: mean square of probability less 1 for right and less 0 for wrong names (G. W. Brier,
/// Monthly Weather Review 78 (1950) 1–3, in the form for one event). `None` without a name.
pub fn brier<'a>(said: impl IntoIterator<Item = &'a Said>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0usize);
    for cause in said {
        sum += (cause.probability - f64::from(u8::from(cause.right))).powi(2);
        count += 1;
    }
    (count > 0).then(|| sum / count as f64)
}

/// Reliability diagram of stated probabilities (A. H. Murphy, R. L. Winkler, J. R. Stat. Soc. C 26 (1977) 41–47); empty bins
/// are left out.
pub fn reliability(said: &[&Said]) -> Vec<Bin> {
    let bins = SETTINGS.bins;
    let place = |p: f64| ((p * bins as f64).floor().max(0.0) as usize).min(bins - 1);
    let bin = |n: usize| {
        let of: Vec<_> = said.iter().filter(|s| place(s.probability) == n).collect();
        let count = of.len();
        let mean = |sum: f64| sum / count as f64;
        (count > 0).then(|| Bin {
            from: n as f64 / bins as f64,
            to: (n + 1) as f64 / bins as f64,
            count,
            said: mean(of.iter().map(|s| s.probability).sum()),
            right: mean(of.iter().filter(|s| s.right).count() as f64),
        })
    };
    (0..bins).filter_map(bin).collect()
}

/// Number of wrong names with a probability that is sure.
pub fn sure_and_wrong<'a>(said: impl IntoIterator<Item = &'a Said>) -> usize {
    said.into_iter().filter(|s| !s.right && s.probability > SETTINGS.sure).count()
}

/// Log-spectral distance, dB, of the measured signals to those before and after the correction, mean over the held-out files of
/// a diagnosis. `None` without such a file.
pub fn distance(diagnosis: &Path) -> Option<[f64; 2]> {
    let files = std::fs::read_dir(diagnosis.join(HELD_OUT)).ok()?;
    let paths = files.flatten().map(|f| f.path()).filter(|p| p.extension().is_some_and(|e| e == "csv"));
    let distances: Vec<[f64; 2]> = paths.filter_map(|p| of_file(&std::fs::read_to_string(p).ok()?)).collect();
    let mean = |n: usize| distances.iter().map(|d| d[n]).sum::<f64>() / distances.len() as f64;
    (!distances.is_empty()).then(|| [mean(0), mean(1)])
}

/// Distances of a file with the columns `time_s,measured,before,after`.
fn of_file(text: &str) -> Option<[f64; 2]> {
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|row| row.split(',').filter_map(|v| v.trim().parse().ok()).collect()).collect();
    let column = |n: usize| rows.iter().map(|row| row.get(n).copied()).collect::<Option<Vec<f64>>>();
    let (time, measured) = (column(0)?, column(1)?);
    let rate = (time.len().checked_sub(1)? as f64) / (time.last()? - time.first()?);
    let to = |n: usize| log_spectral(&measured, &column(n)?, rate);
    Some([to(2)?, to(3)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(probability: f64, right: bool) -> Said {
        Said { name: "shock".into(), probability, right }
    }

    #[test]
    fn golden_brier_score_and_bins_of_four_names() {
        let all = [said(0.95, true), said(0.95, false), said(0.61, true), said(1.0, true)];
        let brier = brier(&all).unwrap();
        assert!((brier - (0.0025 + 0.9025 + 0.1521) / 4.0).abs() < 1e-12, "{brier}");
        let bins = reliability(&all.iter().collect::<Vec<_>>());
        assert_eq!(bins.len(), 2);
        assert_eq!((bins[0].count, bins[0].right, bins[1].count), (1, 1.0, 3));
        assert!((bins[1].said - 2.9 / 3.0).abs() < 1e-12 && (bins[1].right - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(sure_and_wrong(&all), 1);
        assert_eq!(super::brier(&[]), None);
    }

    #[test]
    fn golden_distance_of_half_the_amplitude_is_six_decibels() {
        let mut text = String::from("time_s,measured,before,after\n");
        for i in 0..4096u64 {
            let v = ((i * i * 7919) % 1013) as f64 - 506.0;
            text += &format!("{},{v},{},{v}\n", i as f64 / 1000.0, 0.5 * v);
        }
        let [before, after] = of_file(&text).unwrap();
        assert!((before - 20.0 * 2f64.log10()).abs() < 1e-4 && after == 0.0, "{before} {after}");
        assert_eq!(of_file("time_s,measured,before,after\n"), None);
    }

    #[test]
    fn seeds_are_for_choosing_or_for_scoring() {
        let purposes = [0, 1, 99, 100, 199, 200].map(|seed| &SETTINGS.purpose(seed)[..7]);
        assert_eq!(purposes, ["neither", "choosin", "choosin", "scoring", "scoring", "neither"]);
    }
}
