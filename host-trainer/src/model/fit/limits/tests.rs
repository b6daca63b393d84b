use super::*;

/// Rate of the tests: FEMTO's day at the default rate.
const RATE: Rate = Rate { false_alarms_per_day: 0.1, blocks_per_day: 8640.0 };
const WEIGHT: f32 = 0.3;

fn white(seed: u64, n: usize) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| 0.1 * normal(&mut rng)).collect()
}

fn limit_of(levels: &[f64], rate: &Rate) -> Limit {
    limit(&HealthyBlocks { log_levels: levels, held_out: levels.len() / 5, noise_floor: 0.01 }, rate, WEIGHT, 1)
}

#[test]
fn invariant_limits_widen_with_rarer_alarms_fewer_blocks_and_drift() {
    let (few, many) = (white(1, 40), white(1, 400));
    let at = |rate: f64| limit_of(&few, &Rate { false_alarms_per_day: rate, ..RATE });
    let limits = [10.0, 1.0, 0.1, 0.001].map(|rate| at(rate).log_power);
    assert!(limits.windows(2).all(|w| w[0] < w[1]), "{limits:?}");
    assert!(!at(0.1).extrapolated && at(0.001).extrapolated);
    assert!(limit_of(&many, &RATE).log_power < 0.6 * limit_of(&few, &RATE).log_power);
    let drifting: Vec<f64> = few.iter().enumerate().map(|(k, v)| v + 0.3 * (k as f64 / 8.0).sin()).collect();
    assert!(limit_of(&drifting, &RATE).log_power > 1.2 * limit_of(&few, &RATE).log_power);
    assert!(limit_of(&few, &RATE).effective_blocks > limit_of(&drifting, &RATE).effective_blocks);
    assert_eq!(limit_of(&few, &RATE), limit_of(&few, &RATE));
}

/// Seconds of a healthy machine do not excuse a level that no drift of a healthy machine reaches.
#[test]
fn invariant_extrapolation_ends_where_drift_does() {
    let rate = |day: f64| Rate { false_alarms_per_day: 0.1, blocks_per_day: day };
    let few = white(3, 20);
    let (rare, never) = (limit_of(&few, &rate(864_000.0)), limit_of(&few, &rate(864_000_000.0)));
    assert!(rare.extrapolated && never.extrapolated);
    assert_eq!(rare.log_power, never.log_power);
    assert!(rare.log_power < rare.asked_log_power && rare.asked_log_power < never.asked_log_power);
    assert!((3.0..4.5).contains(&(never.log_power / MAX_DRIFT)), "{never:?}");
}

#[test]
fn blocks_that_say_nothing_still_give_a_limit() {
    for levels in [vec![], vec![0.1], vec![0.1, 0.1], vec![0.1; 50]] {
        let found = limit_of(&levels, &RATE);
        assert!(found.log_power.is_finite() && found.log_power > 0.0 && found.spread >= 0.01, "{found:?}");
    }
}

/// Machines with the drift that the prior holds possible, from none to the greatest.
#[test]
fn null_simulated_machines_alarm_at_the_stated_rate() {
    let (machines, healthy, horizon) = (120, 40, 4000);
    let rate = Rate { false_alarms_per_day: 2.0, ..RATE };
    let alarmed = |k: u64| {
        let mut rng = ChaCha8Rng::seed_from_u64(100 + k);
        let time = (SETTINGS.correlation_factor * healthy) as f64;
        let drift = SETTINGS.max_drift * rng.random::<f64>();
        let mut path =
            Drift { value: drift * normal(&mut rng), decay: (-1.0 / time).exp(), increment: step(drift, time) };
        let mut level = || path.next(&mut rng) + 0.1 * normal(&mut rng);
        let record: Vec<f64> = (0..healthy).map(|_| level()).collect();
        let centre = record.iter().sum::<f64>() / healthy as f64;
        let held_out = healthy;
        let found = limit(&HealthyBlocks { log_levels: &record, held_out, noise_floor: 0.01 }, &rate, WEIGHT, k);
        let mut statistic = Statistic::default();
        (0..horizon).any(|_| {
            let ewma = statistic.push((level() - centre) as f32, WEIGHT);
            ewma.is_some_and(|ewma| f64::from(ewma.abs()) > found.log_power)
        })
    };
    let count = (0..machines).filter(|k| alarmed(*k)).count() as f64;
    let expected = machines as f64 * (1.0 - (-f64::from(horizon) / rate.mean_blocks()).exp());
    let spread = (expected * (1.0 - expected / machines as f64)).sqrt();
    println!("{count} of {machines} alarmed, expected {expected:.1} ± {spread:.1}");
    assert!((count - expected).abs() < 3.5 * spread, "{count} {expected} {spread}");
}
