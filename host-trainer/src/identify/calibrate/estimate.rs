//! Estimates with intervals from a search, and undetermined combinations: theory (59).

use crate::rig::config::RigKey;
use crate::stats::significance::Z975;
use faer::Mat;
use faer::Side;
use faer::linalg::solvers::DenseSolveCore;
use serde::Serialize;

use super::settings::CalibrationSettings;
use crate::identify::likelihood::coordinate::{Coordinate, Scale};
use crate::identify::likelihood::problem::Expansion;

const SETTINGS: CalibrationSettings = CalibrationSettings::DEFAULT;

/// Estimate of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Name, such as `outer.mass_kg`.
    pub key: RigKey,
    /// Value in the rig before.
    pub before: f64,
    /// Value of greatest likelihood.
    pub value: f64,
    /// 95 % confidence interval, if the rig is right otherwise.
    pub interval95: [f64; 2],
    /// Whether the recordings determine the parameter: the interval's ends are less than a factor of four apart.
    pub determined: bool,
}

/// Parameters of which the recordings determine only a combination.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Undetermined {
    /// Names of the parameters.
    pub keys: Vec<RigKey>,
    /// Undetermined product of powers, such as `outer.mass_kg^0.7 · outer.stiffness_n_per_m^0.7`.
    pub free: String,
    /// Standard deviation of the product's logarithm.
    pub deviation: f64,
}

/// Covariance of the first `count` unknowns of an expansion at its optimum, the others free as well, theory (59). An
/// unknown on which nothing depends has an enormous variance.
///
/// The inverse of the information is widened where scores of bands scatter more than expected, because the rig is not quite
/// the machine: White, "Maximum likelihood estimation of misspecified models",
/// Econometrica 50 (1982) 1–25, eq. 3.4.
pub fn covariance(expansion: &Expansion, count: usize) -> Mat<f64> {
    let inverse = inverse(&expansion.information);
    let widened = |a: usize| {
        let pull = |score: &Vec<f64>| score.iter().enumerate().map(|(b, s)| inverse[(a, b)] * s).sum::<f64>();
        let scattered: f64 = expansion.scores.iter().map(|score| pull(score).powi(2)).sum();
        (scattered / inverse[(a, a)]).max(1.0).sqrt()
    };
    let widened: Vec<f64> = (0..count).map(widened).collect();
    Mat::from_fn(count, count, |a, b| inverse[(a, b)] * widened[a] * widened[b])
}

fn inverse(information: &Mat<f64>) -> Mat<f64> {
    let n = information.nrows();
    // On a common scale, so that the ridge that makes it invertible is small against all information.
    let scale: Vec<f64> = (0..n).map(|a| 1.0 / information[(a, a)].sqrt().max(1e-6)).collect();
    let scaled =
        Mat::from_fn(n, n, |a, b| information[(a, b)] * scale[a] * scale[b] + if a == b { 1e-10 } else { 0.0 });
    let inverse = match scaled.llt(Side::Lower) {
        Ok(factor) => factor.inverse(),
        Err(_) => scaled.partial_piv_lu().inverse(),
    };
    Mat::from_fn(n, n, |a, b| inverse[(a, b)] * scale[a] * scale[b])
}

/// Estimates of the `sought` coordinates at `found`, with intervals.
pub fn estimates(sought: &[Coordinate], before: &[f64], found: &[f64], covariance: &Mat<f64>) -> Vec<Estimate> {
    sought
        .iter()
        .enumerate()
        .map(|(a, coordinate)| {
            let deviation = covariance[(a, a)].max(0.0).sqrt();
            let end = |side: f64| coordinate.to_value(found[a] + side * Z975 * deviation.min(300.0));
            let (one, other) = (end(-1.0), end(1.0));
            Estimate {
                key: coordinate.key,
                before: before[a],
                value: coordinate.to_value(found[a]),
                interval95: [one.min(other), one.max(other)],
                determined: deviation < SETTINGS.undetermined_std,
            }
        })
        .collect()
}

/// Undetermined directions of the parameters.
pub fn undetermined(sought: &[Coordinate], covariance: &Mat<f64>) -> Vec<Undetermined> {
    let Ok(directions) = covariance.self_adjoint_eigen(Side::Lower) else { return Vec::new() };
    let (values, vectors) = (directions.S().column_vector(), directions.U());
    let free = |k: &usize| values[*k].max(0.0).sqrt() >= SETTINGS.undetermined_std;
    (0..sought.len())
        .rev()
        .filter(free)
        .map(|k| {
            let largest =
                (0..sought.len()).map(|a| vectors[(a, k)]).fold(0.0f64, |l, v| if v.abs() > l.abs() { v } else { l });
            let part = |a: usize| vectors[(a, k)] * largest.signum();
            let members: Vec<usize> =
                (0..sought.len()).filter(|a| part(*a).abs() >= SETTINGS.min_direction_share).collect();
            let power = |a: &usize| match sought[*a].scale {
                Scale::Log { .. } if members.len() == 1 => sought[*a].key.to_string(),
                Scale::Log { .. } => format!("{}^{:.2}", sought[*a].key, part(*a)),
                Scale::Linear { unit } => format!("exp({:.3e}·{})", part(*a) / unit, sought[*a].key),
            };
            Undetermined {
                keys: members.iter().map(|a| sought[*a].key).collect(),
                free: members.iter().map(power).collect::<Vec<_>>().join(" · "),
                deviation: values[k].max(0.0).sqrt(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::config::ModelKey;

    fn coordinates(keys: &[ModelKey]) -> Vec<Coordinate> {
        keys.iter()
            .map(|key| Coordinate {
                key: (*key).into(),
                scale: Scale::Log { sign: 1.0 },
                moves_mean: true,
                moves_variance: true,
            })
            .collect()
    }

    /// Expansion without scores.
    fn quiet(information: Mat<f64>) -> Expansion {
        let gradient = vec![0.0; information.nrows()];
        Expansion { neg_log_likelihoods: Vec::new(), excess: 0.0, gradient, scores: Vec::new(), information }
    }

    /// Information on the difference of two logarithms alone: the ratio is known, the product is not.
    #[test]
    fn a_known_ratio_leaves_the_product_free() {
        let information = Mat::from_fn(3, 3, |a, b| match (a, b) {
            (2, 2) => 400.0,
            (2, _) | (_, 2) => 0.0,
            _ => {
                if a == b {
                    1e4
                } else {
                    -1e4
                }
            }
        });
        let sought = coordinates(&[ModelKey::Mass, ModelKey::Stiffness, ModelKey::Damping]);
        let covariance = covariance(&quiet(information), 3);
        let free = undetermined(&sought, &covariance);
        assert_eq!(free.len(), 1);
        assert_eq!(free[0].keys, [ModelKey::Mass.into(), ModelKey::Stiffness.into()]);
        assert_eq!(free[0].free, "mass_kg^0.71 · stiffness_n_per_m^0.71");
        let values = estimates(&sought, &[1.0; 3], &[0.0; 3], &covariance);
        assert_eq!(values.iter().map(|e| e.determined).collect::<Vec<_>>(), [false, false, true]);
        // 1/√400 = 0.05: the interval is e^±0.098.
        assert!((values[2].interval95[1] - 0.098f64.exp()).abs() < 1e-3, "{values:?}");
    }

    /// Scores twice as large as expected from the information, and half as large.
    #[test]
    fn a_parameter_that_bands_disagree_about_has_a_wider_interval() {
        let expansion = |pull: f64| Expansion {
            scores: (0..25).map(|k| vec![pull * if k % 2 == 0 { 1.0 } else { -1.0 }]).collect(),
            ..quiet(Mat::from_fn(1, 1, |_, _| 100.0))
        };
        // 25 · 4² / 100² in the place of 1/100.
        assert!((covariance(&expansion(4.0), 1)[(0, 0)] - 0.04).abs() < 1e-9);
        assert!((covariance(&expansion(1.0), 1)[(0, 0)] - 0.01).abs() < 1e-9);
    }

    /// Correlation with the other unknowns widens an estimate's interval.
    #[test]
    fn invariant_covariance_is_that_of_the_whole() {
        let information = Mat::from_fn(2, 2, |a, b| if a == b { 2.0 } else { 1.0 });
        // The inverse of [[2, 1], [1, 2]] has 2/3 on its diagonal, not 1/2.
        assert!((covariance(&quiet(information), 1)[(0, 0)] - 2.0 / 3.0).abs() < 1e-9);
    }
}
