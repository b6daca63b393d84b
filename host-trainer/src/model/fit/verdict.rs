//! Verdict on a model: its scores against those of surrogates, theory (25).

use serde::{Deserialize, Serialize};

use super::score::{Scores, TrainingScores};
use crate::signal::surrogate::SurrogateKind;

/// Verdict on a model's scores.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Whether the model beats its null on held-out recordings.
    pub beyond_null: bool,
    /// Verdict as text.
    pub words: String,
}

/// One-sided 99.5 % points of Student's t for 1 to 30 degrees of freedom: two scores are compared, so
/// that at most 1 of 100 verdicts is a false claim.
const T_995: [f64; 30] = [
    63.657, 9.925, 5.841, 4.604, 4.032, 3.707, 3.499, 3.355, 3.250, 3.169, 3.106, 3.055, 3.012, 2.977, 2.947, 2.921,
    2.898, 2.878, 2.861, 2.845, 2.831, 2.819, 2.807, 2.797, 2.787, 2.779, 2.771, 2.763, 2.756, 2.750,
];

/// A score against those of its surrogates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// The score.
    pub score: f64,
    /// Mean of the surrogates' scores.
    pub mean: f64,
    /// Standard deviation of the surrogates' scores.
    pub spread: f64,
    /// Upper prediction limit of the surrogates' scores.
    pub limit: f64,
}

/// Compares a score with the upper prediction limit for one more draw from the surrogates' scores, theory (25);
/// `None` for fewer than two surrogates or a score that is not finite.
pub fn compare(score: f64, null: &[f64]) -> Option<Comparison> {
    let n = null.len();
    if n < 2 || !score.is_finite() {
        return None;
    }
    let mean = null.iter().sum::<f64>() / n as f64;
    let spread = (null.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1) as f64).sqrt();
    let t = T_995.get(n - 2).copied().unwrap_or(2.75);
    Some(Comparison { score, mean, spread, limit: mean + t * spread * (1.0 + 1.0 / n as f64).sqrt() })
}

/// Verdict on a model's scores, theory (25): the least of its trainings' scores counts.
pub fn verdict(scores: &Scores) -> Verdict {
    let null =
        |pick: fn(&super::score::NullScores) -> Option<f64>| scores.null.iter().filter_map(pick).collect::<Vec<_>>();
    let trainings = |own: f64, pick: fn(&TrainingScores) -> Option<f64>| {
        let others = scores.trainings.iter().filter_map(pick);
        others.fold((own, own), |(least, most), score| (least.min(score), most.max(score)))
    };
    let (least, most) = trainings(scores.held_out.mean(), |t| Some(t.held_out));
    let derivative = compare(least, &null(|n| Some(n.held_out)));
    let next_sample = scores.causal.next_sample.map(|own| trainings(own, |t| t.causal));
    let causal = next_sample.and_then(|(least, _)| compare(least, &null(|n| n.causal)));
    let beats = |c: &Option<Comparison>| c.is_some_and(|c| c.score > c.limit);
    let line = |what: &str, most: f64, c: &Option<Comparison>| match c {
        Some(Comparison { score, mean, spread, .. }) => {
            let range = if most > *score { format!("{score:.4} to {most:.4}") } else { format!("{score:.4}") };
            format!("{what} R² {range}, null {mean:.4} ± {spread:.4}")
        }
        None => format!("{what}: no null to compare with"),
    };
    let evidence = format!(
        "{}; {}",
        line("held-out", most, &derivative),
        line("next-sample", next_sample.map_or(0.0, |(_, most)| most), &causal)
    );
    let (beyond_null, claim) = match (beats(&derivative), beats(&causal)) {
        _ if derivative.is_none() && causal.is_none() => {
            (false, "not judged: fewer than two surrogate fits".to_owned())
        }
        (true, true) => {
            (true, "dynamics beyond the null, in the derivatives and in the prediction of the next sample".into())
        }
        (true, false) => (
            false,
            format!(
                "no dynamics beyond the null: the derivatives are fitted better than those of a surrogate with {}, but the next sample {}",
                kept(scores.null_kind),
                if causal.is_some() { "is not predicted better" } else { "was not predicted" }
            ),
        ),
        (false, true) => (true, "beyond the null in the prediction of the next sample only".into()),
        (false, false) => (
            false,
            format!(
                "nothing beyond the null: a surrogate with {} is fitted as well, so the score is that of these and of the algebra of differences",
                kept(scores.null_kind)
            ),
        ),
    };
    Verdict { beyond_null, words: format!("{claim} ({evidence})") }
}

/// What a surrogate has of its recording.
pub fn kept(kind: SurrogateKind) -> &'static str {
    match kind {
        SurrogateKind::White => "the same variance",
        SurrogateKind::Phase => "the same spectrum",
        SurrogateKind::Amplitude => "the same spectrum and amplitudes",
        SurrogateKind::Cyclostationary => "the same spectrum, amplitudes and periodic changes of level",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_prediction_limit() {
        // n = 5: t(0.995; 4) = 4.604, √(1 + 1/5) = 1.0954.
        let c = compare(1.0, &[0.0, 1.0, 2.0, 3.0, 4.0]).unwrap();
        assert!((c.mean - 2.0).abs() < 1e-12 && (c.spread - 2.5f64.sqrt()).abs() < 1e-12);
        assert!((c.limit - (2.0 + 4.604 * 2.5f64.sqrt() * 1.0954)).abs() < 1e-3);
        assert_eq!(compare(1.0, &[0.5]), None);
    }
}
