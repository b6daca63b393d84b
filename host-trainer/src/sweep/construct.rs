//! Construction of a library in the paper's three steps: the degrees n_D that reach a target, for them the dimensions n_MD, for
//! these the harmonics n_F, each under a limit of a fit's time; and the choice among all that were tried.

use serde::Serialize;

use ballrace_core::library::Library;

use super::config::Sizes;
use super::job::Row;

/// Limits of the construction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// R² in sample that a library must reach.
    pub target: f64,
    /// Longest time of a fit, s.
    pub seconds: f64,
    /// Greatest degree n_D.
    pub max_nd: usize,
    /// Greatest dimension n_MD.
    pub max_nmd: usize,
    /// Most harmonics n_F.
    pub max_nf: usize,
}

impl Default for Limits {
    /// The paper's target and time; the greatest sizes of its Table 3 without the three of the end.
    fn default() -> Self {
        Self { target: 0.90, seconds: 10.0, max_nd: 5, max_nmd: 8, max_nf: 6 }
    }
}

/// Step of the construction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// What the step looks for.
    pub name: &'static str,
    /// Libraries that were fitted for it.
    pub tried: Vec<Row>,
    /// What it keeps and why.
    pub kept: String,
}

/// Libraries tried, and the one chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Construction {
    /// The three steps.
    pub steps: Vec<Step>,
    /// Row of the chosen library; `None` if no fit succeeded within the time.
    pub chosen: Option<Row>,
    /// Why it was chosen.
    pub why: String,
}

/// Most functions of a library that is tried: more take gigabytes, whatever the time. The paper's widest has 2,528.
const MAX_FUNCTIONS: usize = 3000;

/// Most dimensions that are kept of each degree: the paper's Table 3 has two.
const DIMENSIONS_KEPT: usize = 2;

/// Constructs a library; `fit` gives the row of given sizes.
pub fn construct(limits: &Limits, fit: &mut dyn FnMut(Sizes) -> Row) -> Construction {
    let mut fit = |nd, nmd, nf| fit(Sizes { name: String::new(), nd, nmd, nf });
    let is_quick = |row: &Row| row.error.is_none() && row.seconds <= limits.seconds;
    let is_small = |nd, nmd, nf| Library::new(nmd, nd, nf).is_some_and(|library| library.len() <= MAX_FUNCTIONS);
    let reaches = |row: &Row| is_quick(row) && row.r2.is_some_and(|r2| r2 >= limits.target);

    // Step 1, which has the fits of step 2 too.
    let mut tried: Vec<Row> = Vec::new();
    for nd in 1..=limits.max_nd {
        for nmd in (1..=limits.max_nmd).take_while(|nmd| is_small(nd, *nmd, 0)) {
            let row = fit(nd, nmd, 0);
            let too_long = !is_quick(&row);
            tried.push(row);
            if too_long {
                // A greater dimension takes longer still.
                break;
            }
        }
    }
    let of_degree = |nd: usize| tried.iter().filter(move |row| row.job.sizes.nd == nd);
    let mut degrees: Vec<usize> = (1..=limits.max_nd).filter(|nd| of_degree(*nd).any(reaches)).collect();
    let is_reached = !degrees.is_empty();
    if !is_reached {
        degrees.extend(best(tried.iter().filter(|row| is_quick(row)), |row| row.r2).map(|row| row.job.sizes.nd));
    }
    let kept = match (is_reached, degrees.as_slice()) {
        (true, degrees) => {
            format!("n_D {}: with some n_MD they reach R² {:.2} in sample", list(degrees), limits.target)
        }
        (false, []) => format!("none: no fit ended within {} s", limits.seconds),
        (false, degrees) => {
            format!("n_D {}, which comes nearest: none reaches R² {:.2} in sample", list(degrees), limits.target)
        }
    };
    let first = Step { name: "degrees n_D", tried: tried.clone(), kept };

    // Step 2: the greatest dimensions that do, for each degree.
    let mut bases: Vec<(usize, usize)> = Vec::new();
    for nd in &degrees {
        let mut rows: Vec<&Row> = of_degree(*nd).filter(|row| reaches(row)).collect();
        if !is_reached {
            rows = best(of_degree(*nd).filter(|row| is_quick(row)), |row| row.r2).into_iter().collect();
        }
        bases.extend(rows.iter().rev().take(DIMENSIONS_KEPT).rev().map(|row| (*nd, row.job.sizes.nmd)));
    }
    let pairs: Vec<String> = bases.iter().map(|(nd, nmd)| format!("n_D {nd} with n_MD {nmd}")).collect();
    let second = Step {
        name: "dimensions n_MD",
        tried: Vec::new(),
        kept: match (is_reached, bases.is_empty()) {
            (true, _) => format!("{}: the greatest that do, at most {DIMENSIONS_KEPT} a degree", pairs.join(", ")),
            (false, true) => "none".into(),
            (false, false) => format!("{}: the best within the time", pairs.join(", ")),
        },
    };

    // Step 3: harmonics until the time is over.
    let mut with_harmonics = Vec::new();
    for (nd, nmd) in &bases {
        for nf in (1..=limits.max_nf).take_while(|nf| is_small(*nd, *nmd, *nf)) {
            let row = fit(*nd, *nmd, nf);
            let too_long = !is_quick(&row);
            with_harmonics.push(row);
            if too_long {
                break;
            }
        }
    }
    let within = with_harmonics.iter().filter(|row| is_quick(row)).count();
    let kept = format!("{within} libraries within {} s", limits.seconds);
    let third = Step { name: "harmonics n_F", tried: with_harmonics, kept };

    let candidates = || tried.iter().chain(&third.tried).filter(|row| is_quick(row));
    // Of libraries that reach the target, if any does: the choice is by recordings that were not fitted to.
    let chosen = best(candidates().filter(|row| reaches(row)), |row| row.r2_validation)
        .or_else(|| best(candidates(), |row| row.r2_validation))
        .cloned();
    let why = match &chosen {
        Some(row) => format!(
            "greatest R² on the validation part, {:.4}, of {} libraries that {}",
            row.r2_validation.unwrap_or(f64::NAN),
            if is_reached { candidates().filter(|row| reaches(row)).count() } else { candidates().count() },
            if is_reached {
                "reach the target within the time"
            } else {
                "were fitted within the time; none reaches the target"
            }
        ),
        None => format!("no fit ended within {} s", limits.seconds),
    };
    Construction { steps: vec![first, second, third], chosen, why }
}

fn best<'a>(rows: impl Iterator<Item = &'a Row>, of: fn(&Row) -> Option<f64>) -> Option<&'a Row> {
    rows.filter(|row| of(row).is_some()).max_by(|a, b| of(a).unwrap_or(f64::MIN).total_cmp(&of(b).unwrap_or(f64::MIN)))
}

fn list(values: &[usize]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::TABLE_3;
    use crate::sweep::job::Job;

    fn row(sizes: Sizes, r2: f64, seconds: f64) -> Row {
        Row { r2: Some(r2), r2_validation: Some(r2), seconds, ..Row::failed(&Job { sizes, ..Job::default() }, 0, None) }
    }

    #[test]
    fn literature_on_the_paper_s_scores_and_times_the_choice_is_its_no_11() {
        let mut tried = 0;
        let mut fit = |sizes: Sizes| {
            tried += 1;
            let at = [sizes.nd, sizes.nmd, sizes.nf];
            let of_paper = TABLE_3.iter().find(|library| library.sizes == at);
            let in_table = TABLE_3.iter().any(|library| library.sizes[..2] == at[..2] && library.sizes[2] > 0);
            let (r2, seconds) = match (of_paper, sizes.nf) {
                (Some(library), _) => (library.r2, library.seconds),
                (None, 0) if in_table => (0.905, 2.0),
                (None, 0) => (0.85, 2.0),
                (None, _) => (0.93, 11.0),
            };
            row(sizes, r2, seconds)
        };
        let construction = construct(&Limits::default(), &mut fit);
        let chosen = construction.chosen.unwrap().job.sizes;
        assert_eq!([chosen.nd, chosen.nmd, chosen.nf], [2, 8, 2], "{}", construction.why);
        assert!(construction.steps[1].kept.starts_with("n_D 1 with n_MD 8, n_D 2 with n_MD 7, n_D 2 with n_MD 8"));
        // 40 polynomials, and harmonics until the time is over.
        assert!(tried < 40 + 6 * 6, "{tried}");
    }

    #[test]
    fn what_never_reaches_the_target_or_the_time_is_said() {
        let limits = Limits { max_nd: 2, max_nmd: 2, max_nf: 1, ..Limits::default() };
        let low = construct(&limits, &mut |sizes| {
            let r2 = 0.1 * sizes.nmd as f64;
            row(sizes, r2, 1.0)
        });
        assert_eq!(low.chosen.as_ref().map(|row| row.job.sizes.nmd), Some(2));
        assert!(low.why.ends_with("none reaches the target") && low.steps[0].kept.contains("comes nearest"));
        let slow = construct(&limits, &mut |sizes| row(sizes, 0.95, 60.0));
        assert_eq!((slow.chosen, slow.why.as_str()), (None, "no fit ended within 10 s"));
    }
}
