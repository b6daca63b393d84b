//! Exact permutation test over the labels of records, theory (125).

use rayon::prelude::*;

use super::leave_one_out::{Aim, Bearing, Problem};

/// Share of all ways to give the records' classes to the records whose score is no less than the own one's: every record has
/// one class. Names of classes with equally many records can be swapped without a change, so that one of these ways stands
/// for all.
pub fn p_value(aim: Aim, records: &[Bearing], own: f64) -> f64 {
    let ways = labellings(&classes(records), aim.classes);
    let reaches = |labels: &&Vec<usize>| score(aim, records, labels) >= own - 1e-12;
    ways.par_iter().filter(reaches).count() as f64 / ways.len() as f64
}

/// Number of such ways.
pub fn count(aim: Aim, records: &[Bearing]) -> usize {
    labellings(&classes(records), aim.classes).len()
}

fn classes(records: &[Bearing]) -> Vec<usize> {
    records.iter().map(|record| record.targets.first().map_or(0, |target| *target as usize)).collect()
}

/// Score of records with other labels.
fn score(aim: Aim, records: &[Bearing], labels: &[usize]) -> f64 {
    let relabelled = |(record, label): (&Bearing, &usize)| Bearing {
        targets: vec![*label as f64; record.targets.len()],
        ..record.clone()
    };
    let records: Vec<Bearing> = records.iter().zip(labels).map(relabelled).collect();
    mean_score(aim, &records)
}

/// Mean score of records, each predicted by the others.
pub fn mean_score(aim: Aim, records: &[Bearing]) -> f64 {
    let problem = Problem::new(aim, records);
    let held_out = problem.leave_one_out();
    let scores: Vec<f64> = held_out.iter().enumerate().map(|(n, held)| problem.score(n, &held.outputs)).collect();
    problem.together(&(0..records.len()).collect::<Vec<_>>(), &scores)
}

/// All distinct orders of labels, one for each set of those that differ by swapped names of classes with equal counts.
pub fn labellings(labels: &[usize], classes: usize) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> =
        (0..classes).map(|class| labels.iter().filter(|label| **label == class).count()).collect();
    let counts = left.clone();
    let (mut all, mut begun) = (Vec::new(), Vec::new());
    extend(&mut left, &mut begun, labels.len(), &mut all);
    let first = |way: &[usize], class: usize| way.iter().position(|label| *label == class);
    let is_first_of_its_kind = |way: &Vec<usize>| {
        let pairs = (0..classes).flat_map(|b| (0..b).map(move |a| (a, b)));
        pairs.filter(|(a, b)| counts[*a] == counts[*b]).all(|(a, b)| first(way, a) <= first(way, b))
    };
    all.retain(is_first_of_its_kind);
    all
}

fn extend(left: &mut [usize], begun: &mut Vec<usize>, length: usize, all: &mut Vec<Vec<usize>>) {
    if begun.len() == length {
        all.push(begun.clone());
        return;
    }
    for class in 0..left.len() {
        if left[class] > 0 {
            left[class] -= 1;
            begun.push(class);
            extend(left, begun, length, all);
            begun.pop();
            left[class] += 1;
        }
    }
}
