//! Tables and figures of the paper as grids.

use std::ops::Range;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use serde::{Deserialize, Serialize};

use super::config::{Sizes, each};
use super::job::Job;
use super::method::Method;
use crate::paper::{PaperLibrary, TABLE_3};
use crate::signal::surrogate::SurrogateKind;

/// Table or figure of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Table 3: 21 libraries on Bearing 3_3.
    Table3,
    /// Table 4: SINDy-NN beside rivals on Bearing 3_3.
    Table4,
    /// Table 5: the best library on each bearing.
    Table5,
    /// Figure 10: degrees n_D and dimensions n_MD.
    Fig10,
    /// Figure 11: harmonics n_F.
    Fig11,
}

impl Preset {
    /// All tables and figures that are grids.
    pub const ALL: [Self; 5] = [Self::Table3, Self::Table4, Self::Table5, Self::Fig10, Self::Fig11];

    /// Sizes of its libraries.
    pub fn sizes(self) -> Vec<Sizes> {
        let named = |library: &PaperLibrary| Sizes { name: library.name.into(), ..sizes(library.sizes) };
        match self {
            Self::Table3 => TABLE_3.iter().map(named).collect(),
            Self::Table4 => vec![Sizes { name: "linear".into(), ..sizes([1, 8, 0]) }, best()],
            Self::Table5 => vec![best()],
            Self::Fig10 => (1..=5).flat_map(|nd| (1..=8).map(move |nmd| sizes([nd, nmd, 0]))).collect(),
            Self::Fig11 => {
                let bases = [[1, 8], [2, 7], [2, 8], [3, 5], [3, 6]];
                bases.iter().flat_map(|[nd, nmd]| (0..=6).map(|nf| sizes([*nd, *nmd, nf]))).collect()
            }
        }
    }

    /// Recordings of each aging phase where it is not stated.
    const fn usual_count(self) -> usize {
        match self {
            Self::Table5 => 8,
            Self::Table4 => 4,
            Self::Table3 | Self::Fig10 | Self::Fig11 => 1,
        }
    }

    /// Jobs on the aging phases of bearings: `count` recordings of each, spread evenly; all but Table 5 take the bearing of the
    /// paper's table, or the first.
    pub fn jobs(self, bearings: &[Bearing], count: Option<usize>) -> Vec<Job> {
        let chosen: Vec<&Bearing> = match self {
            Self::Table5 => bearings.iter().collect(),
            _ => bearings.iter().find(|b| b.name == PAPER_BEARING).or(bearings.first()).into_iter().collect(),
        };
        let count = count.unwrap_or(self.usual_count());
        let recordings: Vec<Option<String>> = chosen.iter().flat_map(|b| b.spread(count)).map(Some).collect();
        let jobs = each(vec![Job::default()], self.sizes(), |job, sizes| job.sizes = sizes);
        let solvers = match self {
            Self::Table3 | Self::Table4 | Self::Table5 => vec![Method::SindyNn, Method::Stlsq],
            // Hundreds of fits, of which least squares' differences are those of the libraries alone.
            Self::Fig10 | Self::Fig11 => vec![Method::Stlsq],
        };
        let jobs = each(jobs, solvers, |job, solver| job.solver = solver);
        let mut jobs = each(jobs, recordings, |job, recording| job.recording = recording);
        if self == Self::Table4 {
            let nulls = SurrogateKind::ALL.to_vec();
            jobs.retain(|job| job.sizes.nd > 1 || job.solver == Method::Stlsq);
            jobs = each(jobs, nulls, |job, kind| job.null_kind = kind);
            // Four nulls of a network are four times its training.
            jobs.retain(|job| job.solver == Method::Stlsq || job.null_kind == SurrogateKind::default());
        }
        if self == Self::Table4 {
            jobs.extend(rivals(&jobs));
        }
        // The paper has no causal score of its libraries, and each costs a training.
        jobs.iter_mut().for_each(|job| job.causal = job.solver == Method::Stlsq || self == Self::Table4);
        jobs
    }
}

/// Name of a preset, or of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetName {
    /// All.
    All,
    /// One.
    One(Preset),
}

const NAMES: [PresetName; 6] = [
    PresetName::One(Preset::Table3),
    PresetName::One(Preset::Table4),
    PresetName::One(Preset::Table5),
    PresetName::One(Preset::Fig10),
    PresetName::One(Preset::Fig11),
    PresetName::All,
];

impl ValueEnum for PresetName {
    fn value_variants<'a>() -> &'a [Self] {
        &NAMES
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::All => Some(PossibleValue::new("all").help("All of them")),
            Self::One(preset) => preset.to_possible_value(),
        }
    }
}

impl PresetName {
    /// The presets that it names.
    pub fn presets(self) -> Vec<Preset> {
        match self {
            Self::All => Preset::ALL.to_vec(),
            Self::One(preset) => vec![preset],
        }
    }
}

/// The rivals that this build has, on the recordings of jobs, from the states of the paper's best library.
fn rivals(jobs: &[Job]) -> Vec<Job> {
    let mut recordings: Vec<Option<String>> = jobs.iter().map(|job| job.recording.clone()).collect();
    recordings.dedup();
    recordings.sort();
    recordings.dedup();
    let base = Job { sizes: Sizes { name: String::new(), nd: 0, nf: 0, ..best() }, ..Job::default() };
    let built = Method::RIVALS.into_iter().filter(|method| method.is_built()).collect();
    let jobs = each(vec![base], built, |job, method| job.solver = method);
    each(jobs, recordings, |job, recording| job.recording = recording)
}

/// Bearing of the paper's Tables 3 and 4.
pub const PAPER_BEARING: &str = "Bearing3_3";

/// The paper's best library, No. 11.
pub fn best() -> Sizes {
    Sizes { name: "11".into(), ..sizes([2, 8, 2]) }
}

fn sizes([nd, nmd, nf]: [usize; 3]) -> Sizes {
    Sizes { name: String::new(), nd, nmd, nf }
}

/// Bearing run to failure.
#[derive(Clone, Debug, PartialEq)]
pub struct Bearing {
    /// Name of its folder.
    pub name: String,
    /// Names of its recordings.
    pub recordings: Vec<String>,
    /// Aging phase, as indices of recordings.
    pub aging: Range<usize>,
}

impl Bearing {
    /// Up to `count` recordings of the aging phase, the middles of as many equal parts.
    pub fn spread(&self, count: usize) -> Vec<String> {
        let (length, count) = (self.aging.len(), count.min(self.aging.len()));
        let at = |k: usize| self.aging.start + (2 * k + 1) * length / (2 * count);
        (0..count).map(|k| self.recordings[at(k)].clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace_core::library::Library;

    fn bearing(name: &str) -> Bearing {
        Bearing { name: name.into(), recordings: (0..50).map(|n| format!("{name}/{n}")).collect(), aging: 10..40 }
    }

    #[test]
    fn literature_the_functions_of_table_3_are_counted_as_the_paper_counts() {
        for library in TABLE_3 {
            let [nd, nmd, nf] = library.sizes;
            assert_eq!(Library::new(nmd, nd, nf).unwrap().len(), library.functions, "{}", library.name);
        }
    }

    #[test]
    fn tables_3_and_4_take_the_paper_s_bearing_and_table_5_all() {
        let bearings = [bearing("Bearing1_2"), bearing(PAPER_BEARING)];
        let folders = |preset: Preset| {
            let jobs = preset.jobs(&bearings, Some(2));
            let folder = |job: &Job| job.recording.as_ref().unwrap().split('/').next().unwrap().to_owned();
            jobs.iter().map(folder).collect::<std::collections::BTreeSet<_>>().len()
        };
        assert_eq!((folders(Preset::Table3), folders(Preset::Table4), folders(Preset::Table5)), (1, 1, 2));
        assert_eq!(Preset::Table3.jobs(&bearings, Some(2)).len(), 21 * 2 * 2);
        assert_eq!(bearings[0].spread(2), ["Bearing1_2/17", "Bearing1_2/32"]);
        assert_eq!(bearings[0].spread(1000).len(), 30);
    }
}
