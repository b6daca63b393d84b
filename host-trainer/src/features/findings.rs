//! Answers in words, made of the numbers alone.

use super::answer::{Answer, Gain, Verdict};
use super::life::{Question, Reference};
use super::set::{FeatureSet, Fitted};
use super::settings::FeatureSettings;
use super::{LifeAnswer, Study};

const SETTINGS: FeatureSettings = FeatureSettings::DEFAULT;

impl Question {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Phase => "aging phase by the kurtosis rule",
            Self::Third => "first or last third of the life",
            Self::RemainingLife => "remaining life",
        }
    }
}

impl Reference {
    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Absolute => "features as they are",
            Self::Beginning => "features from the bearing's own beginning",
        }
    }
}

impl LifeAnswer {
    /// Name of question and reference.
    pub fn name(&self) -> String {
        format!("{}, {}", self.question.name(), self.reference.name())
    }
}

/// Name of the question on the CWRU records.
pub const FAULTS: &str = "damaged part, CWRU";

impl Study {
    /// Answers with their names.
    pub fn answers(&self) -> impl Iterator<Item = (String, &Answer)> {
        let lives = self.lives.iter().map(|own| (own.name(), &own.answer));
        lives.chain(self.faults.iter().map(|own| (FAULTS.to_owned(), own)))
    }

    /// Answer to the whole question in one paragraph.
    pub fn verdict(&self) -> String {
        let beyond_classical = self.tally(&|gain| gain.without == FeatureSet::CLASSICAL && !is_null(gain.with));
        let null_beyond_classical = self.tally(&|gain| gain.without == FeatureSet::CLASSICAL && is_null(gain.with));
        let beyond_null = self.tally(&|gain| gain.without != FeatureSet::CLASSICAL);
        let both: Vec<String> = self
            .answers()
            .flat_map(|(name, answer)| {
                let degrees = SETTINGS.degrees.into_iter().enumerate();
                let adding = degrees.filter(|(library, _)| adds_to_both(answer, *library));
                adding.map(move |(_, degree)| format!("{name} (Ξ{degree})")).collect::<Vec<_>>()
            })
            .collect();
        let both = match &both[..] {
            [] => "Beyond all of these together the coefficients add to no question.".into(),
            some => format!("Beyond all of these together the coefficients add to: {}.", some.join("; ")),
        };
        format!(
            "Added to RMS and kurtosis, the fitted coefficients {beyond_classical}; those of the null {null_beyond_classical}. \
             In place of the null's, the fitted ones {beyond_null}. {both}"
        )
    }

    fn tally(&self, counts: &dyn Fn(&Gain) -> bool) -> String {
        let gains: Vec<Verdict> = self
            .answers()
            .flat_map(|(_, own)| &own.gains)
            .filter(|gain| counts(gain))
            .map(|gain| gain.verdict)
            .collect();
        let count = |verdict| gains.iter().filter(|own| **own == verdict).count();
        format!(
            "add in {} of {} comparisons, take away in {}, and show no difference in {}",
            count(Verdict::Adds),
            gains.len(),
            count(Verdict::Lessens),
            count(Verdict::NotShown)
        )
    }
}

/// Whether coefficients of a library add to RMS and kurtosis, and more than those of every null do.
pub fn adds_to_both(answer: &Answer, library: usize) -> bool {
    let with = FeatureSet::of_recording(library, true);
    answer.gains.iter().filter(|gain| gain.with == with).all(|gain| gain.verdict == Verdict::Adds)
}

/// Answer of one question in a sentence for each library.
pub fn sentences(answer: &Answer) -> String {
    let of_library = |(library, degree): (usize, usize)| {
        let of = |wanted: &dyn Fn(&Gain) -> bool| {
            answer.gains.iter().filter(|gain| wanted(gain)).map(words).collect::<Vec<_>>().join(", ")
        };
        let with = FeatureSet::of_recording(library, true);
        let classical = of(&|gain| gain.with == with && gain.without == FeatureSet::CLASSICAL);
        let null = of(&|gain| gain.with == with && is_null(gain.without));
        format!("Ξ{degree} beyond RMS and kurtosis: {classical}; beyond these with the null's Ξ{degree}: {null}.")
    };
    SETTINGS.degrees.into_iter().enumerate().map(of_library).collect::<Vec<_>>().join(" ")
}

fn is_null(set: FeatureSet) -> bool {
    matches!(set.fitted, Some(Fitted { null: Some(_), .. }))
}

/// Gain in words, such as `+0.03 (not shown)`.
pub fn words(gain: &Gain) -> String {
    format!("{} ({})", signed(gain.gain), verdict(gain.verdict))
}

/// Verdict in words.
pub const fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Adds => "adds",
        Verdict::Lessens => "takes away",
        Verdict::NotShown => "not shown",
    }
}

/// Number with its sign and two digits.
pub fn signed(value: f64) -> String {
    let text = format!("{value:+.2}").replace('-', "−");
    if text.ends_with("0.00") { "0.00".into() } else { text }
}
