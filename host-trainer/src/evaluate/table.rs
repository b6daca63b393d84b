//! Summary of all cases.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::Serialize;

use super::calibration::{Bin, brier, reliability, sure_and_wrong};
use super::score::{Checked, Score};
use super::settings::EvaluationSettings;
use crate::evaluate::cases::case_spec::{Kind, Severity};

/// Share of cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Share {
    /// Number of cases that count.
    pub of: usize,
    /// Number of all cases.
    pub all: usize,
}

impl Share {
    fn count<'a>(scores: impl IntoIterator<Item = &'a Score>, is: impl Fn(&Score) -> bool) -> Self {
        scores
            .into_iter()
            .fold(Self::default(), |share, s| Self { of: share.of + usize::from(is(s)), all: share.all + 1 })
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.all {
            0 => write!(f, "–"),
            all => write!(f, "{}/{} ({:.0} %)", self.of, all, 100.0 * self.of as f64 / all as f64),
        }
    }
}

/// Summary of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Single effects whose first cause is right.
    pub first_right: Share,
    /// Single effects diagnosed without another cause.
    pub only_right: Share,
    /// Controls without a diagnosed cause.
    pub quiet: Share,
    /// Effects outside the vocabulary that are called unexplained.
    pub honest: Share,
    /// Pairs of which both are diagnosed, and nothing else.
    pub both: Share,
    /// Pairs of which the first diagnosed cause is one of the two.
    pub one_of_two: Share,
    /// Intervals of 95 % that hold the truth.
    pub intervals: Share,
    /// Diagnosed causes whose held-out error falls.
    pub improved: Share,
    /// Single effects and pairs with a right cause, with nothing wrong beside it.
    pub nothing_beside: Share,
    /// Brier score of all stated probabilities; `None` if no cause was named.
    pub brier: Option<f64>,
    /// Wrong names that were sure, against the number of cases.
    pub sure_and_wrong: Share,
    /// Reliability diagram of all stated probabilities.
    pub reliability: Vec<Bin>,
    /// Mean share of the mismatch that is left, over right causes; `None` if no diagnosis states it.
    pub left: Option<f64>,
    /// Right causes after which the held-out signals are nearer by their log-spectral distance.
    pub nearer: Share,
    /// Mean log-spectral distance of these, dB: before, after.
    pub distance: Option<[f64; 2]>,
    /// Wall time of a case, s: median, slowest.
    pub seconds: [f64; 2],
}

/// Mean; `None` of nothing.
fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

impl Summary {
    /// Summary of all scores.
    pub fn from_scores(scores: &[Score]) -> Self {
        let kind = |kind: Kind| scores.iter().filter(move |s| s.kind == kind.name());
        let mut seconds: Vec<f64> = scores.iter().map(|s| s.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        let stated: Vec<bool> = scores.iter().flat_map(|s| &s.parameters).filter_map(|p| p.held).collect();
        let improved = scores.iter().filter_map(|s| s.held_out);
        let said: Vec<_> = scores.iter().flat_map(|s| &s.probabilities).collect();
        let hidden = || scores.iter().filter(|s| [Kind::Single.name(), Kind::Pair.name()].contains(&s.kind));
        let right = || hidden().filter(|s| s.nothing_beside.is_some());
        let left: Vec<f64> = right().filter_map(|s| s.left).collect();
        let distances: Vec<[f64; 2]> = right().filter_map(|s| s.distance).collect();
        let distance = |n: usize| mean(&distances.iter().map(|d| d[n]).collect::<Vec<_>>());
        Self {
            nothing_beside: Share::count(right(), |s| s.nothing_beside == Some(true)),
            brier: brier(said.iter().copied()),
            sure_and_wrong: Share { of: sure_and_wrong(said.iter().copied()), all: scores.len() },
            reliability: reliability(&said),
            left: mean(&left),
            nearer: Share { of: distances.iter().filter(|d| d[1] < d[0]).count(), all: distances.len() },
            distance: distance(0).zip(distance(1)).map(|(before, after)| [before, after]),
            first_right: Share::count(kind(Kind::Single), |s| s.first_right),
            only_right: Share::count(kind(Kind::Single), |s| s.right),
            quiet: Share::count(kind(Kind::Control), |s| s.right),
            honest: Share::count(kind(Kind::Outside), |s| s.right),
            both: Share::count(kind(Kind::Pair), |s| s.right),
            one_of_two: Share::count(kind(Kind::Pair), |s| s.first_right),
            intervals: Share { of: stated.iter().filter(|held| **held).count(), all: stated.len() },
            improved: improved.fold(Share::default(), |share, [before, after]| Share {
                of: share.of + usize::from(after < before),
                all: share.all + 1,
            }),
            seconds: [seconds.get(seconds.len() / 2), seconds.last()].map(|s| s.copied().unwrap_or_default()),
        }
    }
}

/// All tables as Markdown, of an evaluation of a seed.
pub fn markdown(scores: &[Score], seed: u64) -> String {
    let summary = Summary::from_scores(scores);
    let purpose = EvaluationSettings::DEFAULT.purpose(seed);
    let mut out = format!("| seed {seed} | {purpose} |\n|---|---|\n");
    let mut row = |what: &str, share: Share| _ = writeln!(out, "| {what} | {share} |");
    row("single effects: first cause right", summary.first_right);
    row("single effects: nothing else said", summary.only_right);
    row("controls: quiet", summary.quiet);
    row("outside the vocabulary: called unexplained", summary.honest);
    row("pairs: both named", summary.both);
    row("pairs: first is one of them", summary.one_of_two);
    row("95 % intervals that hold the truth", summary.intervals);
    row("right causes with nothing wrong beside them", summary.nothing_beside);
    row("wrong names with a probability above 0.9, of all cases", summary.sure_and_wrong);
    row("right causes after which the held-out signals are nearer", summary.nearer);
    row("named causes whose held-out error falls", summary.improved);
    let decimals = |of: Option<f64>| of.map_or("–".into(), |v| format!("{v:.3}"));
    _ = writeln!(out, "| Brier score of the stated probabilities | {} |", decimals(summary.brier));
    _ = writeln!(out, "| share of the mismatch left beside right causes | {} |", decimals(summary.left));
    if let Some([before, after]) = summary.distance {
        _ = writeln!(out, "| their log-spectral distance, before and after | {before:.2} dB, {after:.2} dB |");
    }
    _ = writeln!(
        out,
        "| time of a case, median and slowest | {:.0} s, {:.0} s |",
        summary.seconds[0], summary.seconds[1]
    );
    out.push_str("\n| stated probability | names | mean stated | right |\n|---|---|---|---|\n");
    for Bin { from, to, count, said, right } in &summary.reliability {
        _ = writeln!(out, "| {from:.1} to {to:.1} | {count} | {said:.3} | {right:.3} |");
    }
    out.push_str("\n| hidden | slight | plain | severe | called something else |\n|---|---|---|---|---|\n");
    for (hidden, of) in by_hidden(scores, Kind::Single) {
        let at = |severity: Severity| {
            Share::count(of.iter().copied().filter(|s| s.severity == Some(severity.name())), |s| s.first_right)
        };
        let at = Severity::ALL.map(|s| match at(s) {
            Share { all: 0, .. } => "–".into(),
            Share { of, all } => format!("{of}/{all}"),
        });
        _ = writeln!(out, "| {hidden} | {} | {} |", at.join(" | "), otherwise(&of));
    }
    for (title, kind) in [("pair", Kind::Pair), ("outside the vocabulary", Kind::Outside), ("control", Kind::Control)] {
        let rows = by_hidden(scores, kind);
        if rows.is_empty() {
            continue;
        }
        _ = write!(out, "\n| {title} | right | called something else |\n|---|---|---|\n");
        for (hidden, of) in rows {
            let right = Share::count(of.iter().copied(), |s| s.right);
            _ = writeln!(out, "| {hidden} | {}/{} | {} |", right.of, right.all, otherwise(&of));
        }
    }
    out.push_str("\n| all cases that are right | with | without |\n|---|---|---|\n");
    let mut split = |what: &str, has: &dyn Fn(&Score) -> bool| {
        let share = |with: bool| Share::count(scores.iter().filter(|s| has(s) == with), |s| s.right);
        _ = writeln!(out, "| {what} | {} | {} |", share(true), share(false));
    };
    split("loud", &|s| s.loud);
    split("tachometer", &|s| s.tachometer);
    split("guessed rig, with a baseline", &|s| s.guessed);
    out.push_str("\n| parameter | cases | median error | in its 95 % interval |\n|---|---|---|---|\n");
    let mut parameters: BTreeMap<&str, Vec<&Checked>> = BTreeMap::new();
    for checked in scores.iter().flat_map(|s| &s.parameters) {
        parameters.entry(&checked.key).or_default().push(checked);
    }
    for (key, of) in parameters {
        let mut errors: Vec<f64> = of.iter().map(|c| (c.found - c.truth).abs() / c.truth.abs().max(1e-30)).collect();
        errors.sort_by(f64::total_cmp);
        let stated: Vec<bool> = of.iter().filter_map(|c| c.held).collect();
        let held = Share { of: stated.iter().filter(|h| **h).count(), all: stated.len() };
        let error = 100.0 * errors[errors.len() / 2];
        _ = writeln!(out, "| {key} | {} | {error:.2} % | {}/{} |", of.len(), held.of, held.all);
    }
    out
}

/// Confusion matrix as CSV: hidden causes in rows, diagnosed causes in columns.
pub fn confusion(scores: &[Score]) -> String {
    let mut cells: BTreeMap<(String, String), usize> = BTreeMap::new();
    for score in scores {
        *cells.entry((hidden(score), answer(score))).or_default() += 1;
    }
    let columns: std::collections::BTreeSet<&String> = cells.keys().map(|(_, said)| said).collect();
    let rows: std::collections::BTreeSet<&String> = cells.keys().map(|(hidden, _)| hidden).collect();
    let mut out = String::from("hidden");
    columns.iter().for_each(|c| _ = write!(out, ",{c}"));
    out.push('\n');
    for row in rows {
        out.push_str(row);
        for column in &columns {
            _ = write!(out, ",{}", cells.get(&(row.clone(), (*column).clone())).unwrap_or(&0));
        }
        out.push('\n');
    }
    out
}

fn by_hidden(scores: &[Score], kind: Kind) -> BTreeMap<String, Vec<&Score>> {
    let mut out: BTreeMap<String, Vec<&Score>> = BTreeMap::new();
    for score in scores.iter().filter(|s| s.kind == kind.name()) {
        out.entry(hidden(score)).or_default().push(score);
    }
    out
}

fn hidden(score: &Score) -> String {
    match (&score.truth.outside, score.truth.causes.as_slice()) {
        (Some(outside), _) => outside.clone(),
        (None, []) => "nothing".into(),
        (None, causes) => causes.join(" + "),
    }
}

/// Diagnosed causes, or the verdict without one.
fn answer(score: &Score) -> String {
    if score.said.is_empty() { score.verdict.replace(',', ";") } else { score.said.join(" + ") }
}

/// Wrong diagnoses, with their cases.
fn otherwise(scores: &[&Score]) -> String {
    let wrong = scores.iter().filter(|s| !s.right);
    let listed = wrong.map(|s| {
        let severity = s.severity.map_or(String::new(), |severity| format!(", {severity}"));
        format!("{} ({}{severity})", answer(s), s.case)
    });
    listed.collect::<Vec<_>>().join("; ")
}
