//! Significance tests of the residual: each statistic against its null distribution, with false discovery rates, theory (82).

use super::DiagnoseError;
use super::explain::NullFit;
use super::residual::{Whitened, whitened};
use super::result::{Aspect, Test};
use super::statistics::{ResidualView, Statistic, highest_lines, statistics};
use super::validation::replicate;
use crate::identify::likelihood::observed::{CHANNELS, Observed};
use crate::stats::significance::{false_discovery_rates, two_sided};

/// Replicates of the rig that give the null distribution.
const REPLICATES: u64 = 8;
/// Count of highest lines that are tested in addition to those of the bearing.
const LINES: usize = 6;

/// Tests of the null model's residual against replicates of that rig, the most significant first.
///
/// # Errors
/// Errors of the simulation.
pub fn of_residual(null_fit: &NullFit) -> Result<Vec<Test>, DiagnoseError> {
    let rig = null_fit.rig()?;
    let Some(machine) = rig.bearing() else { return Ok(Vec::new()) };
    let geometry = machine.bearing.geometry();
    let (observed, point) = (null_fit.problem.observed, &null_fit.found.point);
    let expected = null_fit.problem.predict(point)?;
    let replicated = |n: u64| {
        let made = replicate(&rig, observed, &point.angles, null_fit.seed.wrapping_add(n))?;
        let left = whitened(&made, &expected);
        Ok::<_, DiagnoseError>(statistics(&views(&made, &left, Some(&point.angles)), &geometry))
    };
    // Replicates that fail are left out.
    let others: Vec<_> = (1..=REPLICATES).filter_map(|n| replicated(n).ok()).collect();
    let views = views(observed, &null_fit.residuals, Some(&point.angles));
    let mut tests = against(statistics(&views, &geometry), &others);
    tests.extend(lines(&views));
    Ok(ranked(tests))
}

/// Residuals with what they may depend on. The angles are those of cage and shaft at the first sample, rad; the shaft's is used
/// only with a tachometer.
pub fn views<'a>(
    observed: &'a [Observed],
    residuals: &'a [Whitened],
    angles: Option<&[[f64; 2]]>,
) -> Vec<ResidualView<'a>> {
    let of = |w: &'a Whitened| {
        let o = observed.get(w.recording)?;
        let angles = angles.and_then(|a| a.get(w.recording));
        Some(ResidualView {
            whitened: w,
            samples: o.samples[w.channel].as_deref()?,
            condition: o.condition,
            cage: angles.map(|[cage, _]| *cage),
            shaft: angles.filter(|_| o.tachometer.is_some()).map(|[_, shaft]| *shaft),
        })
    };
    residuals.iter().filter_map(of).collect()
}

/// Tests of statistics against those of other recordings under the same conditions.
pub fn against(own: Vec<Statistic>, others: &[Vec<Statistic>]) -> Vec<Test> {
    let count = others.len() as f64;
    let of = |(index, s): (usize, Statistic)| {
        let values = || others.iter().filter_map(|o| o.get(index)).map(|o| o.value);
        let mean = values().sum::<f64>() / count.max(1.0);
        let variance = values().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0).max(1.0);
        let z = (s.value - mean) / (variance.max(1.0) * (1.0 + 1.0 / count.max(1.0))).sqrt();
        let p_value = two_sided(z);
        Test { aspect: s.aspect, channel: s.channel, at: s.at, what: s.what, z, p_value, q_value: 1.0 }
    };
    own.into_iter().enumerate().map(of).collect()
}

/// Tests of the highest lines of each channel, in the first recording that has it, against the noise around them. Powers of
/// noise are exponential; p is for the highest of the whole spectrum.
fn lines(views: &[ResidualView]) -> Vec<Test> {
    let first = |channel: usize| views.iter().find(|l| l.whitened.channel == channel);
    let of = |view: &ResidualView| {
        let channel = CHANNELS[view.whitened.channel];
        let values = view.whitened.spectrum.len() as f64;
        let test = move |(order, ratio): (f64, f64)| Test {
            aspect: Aspect::Order,
            channel,
            at: Some([order; 2]),
            what: format!("{channel}, a line at order {order:.3}"),
            z: ratio - 1.0,
            p_value: (values * (-ratio).exp()).min(1.0),
            q_value: 1.0,
        };
        highest_lines(view, LINES).into_iter().map(test)
    };
    (0..CHANNELS.len()).filter_map(first).flat_map(of).collect()
}

/// All tests with their false discovery rates, theory (82), the most significant first.
pub fn ranked(mut tests: Vec<Test>) -> Vec<Test> {
    let p_values: Vec<f64> = tests.iter().map(|t| t.p_value).collect();
    for (test, rate) in tests.iter_mut().zip(false_discovery_rates(&p_values)) {
        test.q_value = rate;
    }
    let telling = |t: &Test| t.z.abs();
    tests.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then(telling(b).total_cmp(&telling(a))));
    tests
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::diagnose::result::FDR_LEVEL;
    use crate::identify::force_balance::testing::white;
    use crate::identify::likelihood::observed::coefficients;
    use crate::rig::OperatingCondition;
    use crate::signal::kinematics::Geometry;

    const RATE: f64 = 8192.0;
    const SHAFT_HZ: f64 = 30.0;
    /// Where the cage is at the first sample.
    const CAGE: f64 = 0.2;

    fn geometry() -> Geometry {
        Geometry { balls: 9, ball_diameter_m: 0.00794, pitch_diameter_m: 0.03904, contact_angle_rad: 0.0 }
    }

    /// Tests of three recordings of white noise that `change` has been at, which is given recording, time and sample.
    fn tested(seed: u64, change: impl Fn(usize, f64, f64) -> f64) -> Vec<Test> {
        let of = |seed: u64, change: &dyn Fn(usize, f64, f64) -> f64| {
            let (mut residuals, mut samples) = (Vec::new(), Vec::new());
            for recording in 0..3 {
                let noise = white(7 * seed + recording as u64, 1.0, RATE as usize);
                let signal: Vec<f64> =
                    noise.iter().enumerate().map(|(i, v)| change(recording, i as f64 / RATE, *v)).collect();
                let spectrum = coefficients(&signal);
                samples.push(signal.clone());
                residuals.push(Whitened { recording, channel: 1, spectrum, signal, sample_rate_hz: RATE });
            }
            let views: Vec<ResidualView> = residuals
                .iter()
                .zip(&samples)
                .map(|(whitened, samples)| ResidualView {
                    whitened,
                    samples,
                    condition: OperatingCondition {
                        shaft_hz: SHAFT_HZ,
                        load_n: 300.0 + 200.0 * whitened.recording as f64,
                        sample_rate_hz: RATE,
                        samples: samples.len(),
                    },
                    cage: Some(CAGE),
                    shaft: Some(0.0),
                })
                .collect();
            (statistics(&views, &geometry()), lines(&views))
        };
        let others: Vec<_> = (1..=8).map(|n| of(1000 * seed + n, &|_, _, v| v).0).collect();
        let (own, lines) = of(seed, &change);
        ranked([against(own, &others), lines].concat())
    }

    #[test]
    fn null_noise_stands_out_as_seldom_as_it_is_said_to() {
        let mut wrong = 0;
        let mut squares = std::collections::BTreeMap::<&str, (f64, f64)>::new();
        for seed in 0..60 {
            let tests = tested(seed, |_, _, v| v);
            wrong += usize::from(tests.iter().any(Test::is_significant));
            for t in tests.iter().filter(|t| !t.what.contains("a line")) {
                let (sum, count) = squares.entry(t.aspect.text()).or_default();
                *sum += t.z * t.z;
                *count += 1.0;
            }
        }
        // The stated rate is one in a hundred.
        assert!(FDR_LEVEL == 0.01 && wrong <= 4, "{wrong}");
        for (aspect, (sum, count)) in squares {
            assert!((0.3..1.5).contains(&(sum / count)), "{aspect}: {}", sum / count);
        }
    }

    #[test]
    fn what_differs_is_found_where_it_is() {
        let first = |aspect: Aspect, change: &dyn Fn(usize, f64, f64) -> f64| {
            let tests = tested(3, change);
            let of = tests.iter().filter(|t| t.aspect == aspect);
            let first = of.clone().next().filter(|t| t.is_significant()).unwrap_or_else(|| panic!("{:?}", tests[0]));
            (first.at.unwrap_or_default(), first.what.clone())
        };
        let orders = geometry().orders();
        let tone = |order: f64, t: f64| (TAU * order * SHAFT_HZ * t).sin();
        let (at, _) = first(Aspect::Order, &|_, t, v| v + 0.3 * tone(7.3, t));
        assert!((at[0] - 7.3).abs() < 0.02, "{at:?}");
        let (at, _) = first(Aspect::Spectrum, &|_, t, v| v + 0.3 * tone(7.3, t));
        assert!((at[0]..at[1]).contains(&(7.3 * SHAFT_HZ)), "{at:?}");
        let (at, _) = first(Aspect::Time, &|_, t, v| if (0.40..0.42).contains(&t) { 4.0 * v } else { v });
        assert!(at[0] < 0.42 && at[1] > 0.40, "{at:?}");
        let (_, what) = first(Aspect::Envelope, &|_, t, v| v * (1.0 + 0.5 * tone(orders.bpfi, t)));
        assert!(what.contains("BPFI"), "{what}");
        first(Aspect::Load, &|n, _, v| v * (1.0 + 0.1 * n as f64));
        first(Aspect::Moments, &|_, _, v| v.powi(3));
        first(Aspect::Mean, &|_, _, v| v + 0.1);
    }

    #[test]
    fn what_happens_at_an_angle_or_in_a_state_is_told_and_what_happens_once_is_not_taken_for_it() {
        let standing = |change: &dyn Fn(usize, f64, f64) -> f64, aspect: Aspect| -> Vec<[f64; 2]> {
            let tests = tested(5, change);
            tests
                .iter()
                .filter(|t| t.aspect == aspect && t.is_significant() && t.z > 0.0)
                .filter_map(|t| t.at)
                .collect()
        };
        let pitch = TAU / 9.0;
        let cage = |t: f64| (CAGE + TAU * geometry().orders().ftf * SHAFT_HZ * t).rem_euclid(pitch);
        let near = |t: f64| (0.25 * pitch..0.33 * pitch).contains(&cage(t));
        let found = standing(&|_, t, v| if near(t) { 1.6 * v } else { v }, Aspect::CageAngle);
        assert!(
            !found.is_empty() && found.iter().all(|[from, to]| *from < 0.34 * pitch && *to > 0.24 * pitch),
            "{found:?}"
        );
        let turned = |t: f64| (SHAFT_HZ * t).rem_euclid(1.0);
        let found = standing(&|_, t, v| if turned(t) < 0.08 { 1.6 * v } else { v }, Aspect::ShaftAngle);
        assert!(found.len() == 1 && found[0][0] == 0.0, "{found:?}");
        // A stretch of time is less than a turn.
        let found = standing(&|_, t, v| if turned(t) < 0.08 { 8.0 * v } else { v }, Aspect::Time);
        assert_eq!(found, Vec::<[f64; 2]>::new());
        let burst = |_: usize, t: f64, v: f64| if (0.400..0.403).contains(&t) { 40.0 * v } else { v };
        for aspect in [Aspect::ShaftAngle, Aspect::CageAngle, Aspect::Velocity, Aspect::Displacement] {
            assert_eq!(standing(&burst, aspect), Vec::<[f64; 2]>::new(), "{aspect:?}");
        }
        assert!(standing(&burst, Aspect::Time).iter().all(|[from, to]| *from <= 0.403 && *to >= 0.400));
    }
}
