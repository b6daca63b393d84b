//! Scores of predictions, theory (122), (123).

/// Ranks from 1, of equal values the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut first = 0;
    for equal in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let mean = first as f64 + 0.5 * (equal.len() + 1) as f64;
        equal.iter().for_each(|n| ranks[*n] = mean);
        first += equal.len();
    }
    ranks
}

/// Rank correlation of Spearman; `None` where either side does not vary.
pub fn spearman(a: &[f64], b: &[f64]) -> Option<f64> {
    let (a, b) = (ranks(a), ranks(b));
    let mean = 0.5 * (a.len() as f64 + 1.0);
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    (scale > 0.0).then(|| product(&a, &b) / scale)
}

/// Area under the ROC curve: the chance that a positive value is above a negative one, half for equal ones; `None` without
/// values of both kinds.
pub fn area_under_roc(values: &[f64], positive: &[bool]) -> Option<f64> {
    let count = positive.iter().filter(|positive| **positive).count() as f64;
    let others = positive.len() as f64 - count;
    let sum: f64 = ranks(values).iter().zip(positive).filter(|(_, positive)| **positive).map(|(rank, _)| rank).sum();
    (count > 0.0 && others > 0.0).then(|| (sum - 0.5 * count * (count + 1.0)) / (count * others))
}

/// Share of each class that is named right; `None` for a class without rows.
pub fn recalls(named: &[usize], truth: &[usize], classes: usize) -> Vec<Option<f64>> {
    let recall = |class: usize| {
        let own: Vec<_> = named.iter().zip(truth).filter(|(_, truth)| **truth == class).collect();
        (!own.is_empty()).then(|| own.iter().filter(|(named, truth)| named == truth).count() as f64 / own.len() as f64)
    };
    (0..classes).map(recall).collect()
}

/// Mean of the values that there are; NaN for none.
pub fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}
