//! Rank of significance tests.

use super::result::Test;
use crate::stats::significance::false_discovery_rates;

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
