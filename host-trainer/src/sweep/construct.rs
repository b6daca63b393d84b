//! Construction of a library in the paper's three steps: the degrees n_D that reach a target, for them the dimensions n_MD, for
//! these the harmonics n_F, each under a limit of a fit's time; and the choice among all that were tried.

use ballrace_core::library::Library;
use serde::Serialize;

use super::config::Sizes;
use super::job::Row;
use crate::model::fit::settings::LibrarySettings;

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

/// Most functions of a library that is tried.
const MAX_FUNCTIONS: usize = LibrarySettings::DEFAULT.max_functions;

/// Most dimensions that are kept of each degree: the paper's Table 3 has two.
const DIMENSIONS_KEPT: usize = 2;

/// Constructs a library; `fit` gives the row of given sizes.
pub fn construct(limits: &Limits, fit: &mut dyn FnMut(Sizes) -> Row) -> Construction {
    let mut fit = |[nd, nmd, nf]: [usize; 3]| fit(Sizes { name: String::new(), nd, nmd, nf });
    let polynomials = limits.polynomials(&mut fit);
    let degrees = limits.degrees(&polynomials);
    let bases = limits.bases(&polynomials, &degrees);
    let with_harmonics = limits.with_harmonics(&bases, &mut fit);

    let is_reached = polynomials.iter().any(|row| limits.is_reached_by(row));
    let candidates: Vec<&Row> =
        polynomials.iter().chain(&with_harmonics).filter(|row| limits.is_candidate(row, is_reached)).collect();
    let chosen = best(candidates.iter().copied(), |row| row.r2_validation).cloned();
    let why = limits.why(chosen.as_ref(), candidates.len(), is_reached);
    let within = with_harmonics.iter().filter(|row| limits.is_quick(row)).count();
    let steps = vec![
        Step { name: "degrees n_D", kept: limits.words_of_degrees(&degrees, is_reached), tried: polynomials },
        Step { name: "dimensions n_MD", kept: words_of_bases(&bases, is_reached), tried: Vec::new() },
        Step {
            name: "harmonics n_F",
            kept: format!("{within} libraries within {} s", limits.seconds),
            tried: with_harmonics,
        },
    ];
    Construction { steps, chosen, why }
}

impl Limits {
    fn is_quick(&self, row: &Row) -> bool {
        row.error.is_none() && row.seconds <= self.seconds
    }

    fn is_reached_by(&self, row: &Row) -> bool {
        self.is_quick(row) && row.r2.is_some_and(|r2| r2 >= self.target)
    }

    /// Whether the choice is among such rows: those that reach the target, if any does.
    fn is_candidate(&self, row: &Row, is_reached: bool) -> bool {
        if is_reached { self.is_reached_by(row) } else { self.is_quick(row) }
    }

    /// Rows of all degrees and dimensions, for the first two steps.
    fn polynomials(&self, fit: &mut dyn FnMut([usize; 3]) -> Row) -> Vec<Row> {
        let of_degree = |nd| self.until_too_long((1..=self.max_nmd).map(|nmd| [nd, nmd, 0]), fit);
        (1..=self.max_nd).flat_map(of_degree).collect()
    }

    /// Rows of the sizes in their order, which grow, up to the first that takes too long or would have too many functions.
    fn until_too_long(
        &self,
        sizes: impl Iterator<Item = [usize; 3]>,
        fit: &mut dyn FnMut([usize; 3]) -> Row,
    ) -> Vec<Row> {
        let is_small =
            |[nd, nmd, nf]: [usize; 3]| Library::new(nmd, nd, nf).is_some_and(|library| library.len() <= MAX_FUNCTIONS);
        let mut rows = Vec::new();
        for at in sizes.take_while(|at| is_small(*at)) {
            rows.push(fit(at));
            if rows.last().is_some_and(|row| !self.is_quick(row)) {
                break;
            }
        }
        rows
    }

    /// Step 1: degrees that reach the target with some dimension; the nearest if none does.
    fn degrees(&self, polynomials: &[Row]) -> Vec<usize> {
        let reaching = polynomials.iter().filter(|row| self.is_reached_by(row));
        let mut degrees: Vec<usize> = reaching.map(|row| row.job.sizes.nd).collect();
        degrees.dedup();
        if degrees.is_empty() {
            let nearest = best(polynomials.iter().filter(|row| self.is_quick(row)), |row| row.r2);
            degrees.extend(nearest.map(|row| row.job.sizes.nd));
        }
        degrees
    }

    /// Step 2: of each degree the greatest dimensions that reach the target; the nearest if none does.
    fn bases(&self, polynomials: &[Row], degrees: &[usize]) -> Vec<[usize; 2]> {
        let of_degree = |nd: &usize| {
            let of_degree = || polynomials.iter().filter(|row| row.job.sizes.nd == *nd);
            let mut rows: Vec<&Row> = of_degree().filter(|row| self.is_reached_by(row)).collect();
            if rows.is_empty() {
                rows.extend(best(of_degree().filter(|row| self.is_quick(row)), |row| row.r2));
            }
            let skipped = rows.len().saturating_sub(DIMENSIONS_KEPT);
            rows.into_iter().skip(skipped).map(|row| [row.job.sizes.nd, row.job.sizes.nmd]).collect::<Vec<_>>()
        };
        degrees.iter().flat_map(of_degree).collect()
    }

    /// Step 3: rows with harmonics until the time is over.
    fn with_harmonics(&self, bases: &[[usize; 2]], fit: &mut dyn FnMut([usize; 3]) -> Row) -> Vec<Row> {
        let of_base = |[nd, nmd]: &[usize; 2]| {
            let (nd, nmd) = (*nd, *nmd);
            self.until_too_long((1..=self.max_nf).map(|nf| [nd, nmd, nf]), fit)
        };
        bases.iter().flat_map(of_base).collect()
    }

    fn words_of_degrees(&self, degrees: &[usize], is_reached: bool) -> String {
        let list = degrees.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let Self { target, seconds, .. } = self;
        match (is_reached, degrees) {
            (true, _) => format!("n_D {list}: with some n_MD they reach R² {target:.2} in sample"),
            (false, []) => format!("none: no fit ended within {seconds} s"),
            (false, _) => format!("n_D {list}, which comes nearest: none reaches R² {target:.2} in sample"),
        }
    }

    fn why(&self, chosen: Option<&Row>, candidates: usize, is_reached: bool) -> String {
        let Some(r2) = chosen.and_then(|row| row.r2_validation) else {
            return format!("no fit ended within {} s", self.seconds);
        };
        let that = if is_reached {
            "reach the target within the time"
        } else {
            "were fitted within the time; none reaches the target"
        };
        format!("greatest R² on the validation part, {r2:.4}, of {candidates} libraries that {that}")
    }
}

fn words_of_bases(bases: &[[usize; 2]], is_reached: bool) -> String {
    let pairs = bases.iter().map(|[nd, nmd]| format!("n_D {nd} with n_MD {nmd}")).collect::<Vec<_>>().join(", ");
    match (is_reached, bases) {
        (true, _) => format!("{pairs}: the greatest that do, at most {DIMENSIONS_KEPT} a degree"),
        (false, []) => "none".into(),
        (false, _) => format!("{pairs}: the best within the time"),
    }
}

fn best<'a>(rows: impl Iterator<Item = &'a Row>, of: fn(&Row) -> Option<f64>) -> Option<&'a Row> {
    rows.filter(|row| of(row).is_some()).max_by(|a, b| of(a).unwrap_or(f64::MIN).total_cmp(&of(b).unwrap_or(f64::MIN)))
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
