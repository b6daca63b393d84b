//! Report of `ballrace features`.

use super::settings::ReportSettings;
use super::{Cell, Document, Section, Tone};
use crate::features::answer::{Answer, SetScore};
use crate::features::faults;
use crate::features::findings::{sentences, signed, verdict};
use crate::features::leave_one_out::Score;
use crate::features::life::{Life, Question, Reference};
use crate::features::set::FeatureSet;
use crate::features::{LifeAnswer, Study};
use crate::report::plot::DrawError;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::ratings::{self, Rating};
use crate::report::plot::style::{EARLY, INK, LATE, PREDICTED};
use crate::stats::format::{capital, chance};

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Report of a study of lives, on a channel.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(study: &Study, lives: &[Life], channel: &str) -> Result<Document, DrawError> {
    let names: Vec<&str> = lives.iter().map(|life| life.name.as_str()).collect();
    let records = if study.faults.is_some() { "; CWRU records at the drive end" } else { "" };
    let about = format!("{}, channel {channel}{records}", names.join(", "));
    let mut document = Document::new("Fitted coefficients as features", about, Tone::Open, study.verdict());
    document = document.section(summary(study)).section(reading(lives));
    for (name, answer) in study.answers() {
        document = document.section(section(&name, answer)?);
    }
    let remaining =
        study.lives.iter().find(|own| (own.question, own.reference) == (Question::RemainingLife, Reference::Absolute));
    remaining.map_or(Ok(document.clone()), |own| Ok(document.section(predictions(own)?)))
}

/// Mean scores of all sets for all questions.
fn summary(study: &Study) -> Section {
    let short = |own: &LifeAnswer| {
        let star = if own.reference == Reference::Beginning { "*" } else { "" };
        let name = match own.question {
            Question::Phase => "phase",
            Question::Third => "third",
            Question::RemainingLife => "life",
        };
        format!("{name}{star}")
    };
    let names = study.lives.iter().map(short).chain(study.faults.iter().map(|_| "CWRU".to_owned()));
    let head: Vec<String> = std::iter::once("features".to_owned()).chain(names).collect();
    let row = |set: FeatureSet| {
        let mean = |answer: &Answer| Cell::number(answer.of(set).map_or(String::new(), |own| two(own.mean)));
        std::iter::once(Cell::text(set.name())).chain(study.answers().map(|(_, answer)| mean(answer))).collect()
    };
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    Section::new("In short")
        .paragraph(
            "Mean score over the bearings left out. Phase: aging phase by the kurtosis rule, area under the ROC curve. Third: \
             first or last third of the life, the same. Life: rank correlation of predicted and true remaining life. CWRU: \
             share of the segments whose damaged part is named right, chance 0.33. * with features counted from the bearing's \
             own beginning.",
        )
        .table("", &head, FeatureSet::all().into_iter().map(row).collect())
}

fn reading(lives: &[Life]) -> Section {
    let row = |life: &Life| {
        let count = life.measured.len();
        let failure = life.failure.map_or("none".into(), |failure| (failure + 1).to_string());
        vec![Cell::text(&life.name), Cell::number(count), Cell::number(life.aging + 1), Cell::number(failure)]
    };
    Section::new("What is compared")
        .paragraph(
            "Every set of features goes to the same method, a ridge regression whose penalty is chosen inside the training \
             bearings; each bearing is predicted by the others alone. Ξ1 and Ξ2 are the coefficients of a least-squares fit of the \
             paper's polynomial library of degree n_D 1 and 2 (n_MD 4, half-sample alignment) to one recording, on standardised states, so that the \
             recording's scale is not in them. The null's are those of the same fit to a surrogate of the same recording: \
             what they tell, the spectrum tells and, for the cyclostationary kind (cyclic), the distribution and the periodic \
             level of the innovations.",
        )
        .paragraph(
            "Ξ1 is a function of the autocorrelation at lags 1 to 7 alone, which a surrogate keeps: beyond its null \
             it can have nothing but the sampling error that the surrogate adds.",
        )
        .paragraph(
            "The aging phase is defined by kurtosis, so kurtosis has an advantage there that no other feature has; the \
             question of the first or last third of the life is asked because of that. Failure counts as aging: leaving a \
             bearing out needs each class in at least two.",
        )
        .paragraph(
            "Intervals of 95 % are over blocks of consecutive recordings of the bearings that are there; they do not say what \
             other bearings would do. \"Adds\" and \"takes away\" need an interval on one side of 0 and no bearing on the \
             other; everything else is \"not shown\".",
        )
        .table("", &["bearing", "recordings", "aging from", "failure from"], lives.iter().map(row).collect())
}

/// Name of a score, and what chance gives.
fn score_name(answer: &Answer) -> (&'static str, f64) {
    match answer.score {
        Score::AreaUnderRoc => ("area under the ROC curve", 0.5),
        Score::Spearman => ("rank correlation with the true remaining life", 0.0),
        Score::Recall => ("share of segments named right", 1.0 / faults::CLASSES.len() as f64),
    }
}

fn section(name: &str, answer: &Answer) -> Result<Section, DrawError> {
    let (score, by_chance) = score_name(answer);
    let rating = |set: &SetScore| Rating {
        name: set.set.name(),
        scores: set.scores.clone(),
        mean: set.mean,
        interval: set.interval95,
    };
    let rows: Vec<Rating> = answer.sets.iter().map(rating).collect();
    let x = match answer.score {
        Score::Spearman => -1.0..1.0,
        Score::AreaUnderRoc | Score::Recall => -0.02..1.02,
    };
    // Of many records the colours would tell nothing.
    let named = if answer.bearings.len() > 4 { &[][..] } else { &answer.bearings };
    let svg = ratings::svg(&rows, named, x, score, by_chance)?;
    let heading = capital(name);
    let caption = match answer.score {
        Score::AreaUnderRoc => "Area under the ROC curve of each bearing left out; the accuracy is the balanced one",
        Score::Spearman => "Rank correlation of predicted and true remaining life of each bearing left out",
        Score::Recall => {
            "Share of the segments of each record left out that are named right; p over all labels of the records; same: \
             the share where the first halves of all records train and the second halves are named, as is often published"
        }
    };
    Ok(Section::new(heading)
        .paragraph(sentences(answer))
        .figure(svg, format!("A dot for each bearing that was left out, the mean and its interval; {score}."))
        .table(caption, &head(answer), answer.sets.iter().map(|set| row(answer, set)).collect())
        .table(
            "What features gain on others, both beside RMS and kurtosis; --json has all comparisons",
            &gain_head(answer),
            gain_rows(answer),
        ))
}

fn head(answer: &Answer) -> Vec<&str> {
    let mut head = vec!["features", "number"];
    head.extend(answer.bearings.iter().map(String::as_str));
    head.extend(["mean", "95 %"]);
    match answer.score {
        Score::AreaUnderRoc => head.push("accuracy"),
        Score::Spearman => {}
        Score::Recall => head.extend(["p", "same"]),
    }
    head
}

fn row(answer: &Answer, set: &SetScore) -> Vec<Cell> {
    let mut row = vec![Cell::text(set.set.name()), Cell::number(set.features)];
    row.extend(set.scores.iter().map(|score| Cell::number(two(*score))));
    row.push(Cell::number(two(set.mean)));
    row.push(interval(set.interval95));
    match (answer.score, Answer::balanced_accuracy(set), set.p_value) {
        (Score::AreaUnderRoc, Some(accuracy), _) => row.push(Cell::number(two(accuracy))),
        (Score::Recall, _, Some(p_value)) => row.push(Cell::number(chance(p_value))),
        _ => {}
    }
    row.extend(set.same_bearings.map(|share| Cell::number(two(share))));
    row
}

fn gain_head(answer: &Answer) -> Vec<&str> {
    let mut head = vec!["features", "against"];
    head.extend(answer.bearings.iter().map(String::as_str));
    head.extend(["gain", "95 %", ""]);
    head
}

fn gain_rows(answer: &Answer) -> Vec<Vec<Cell>> {
    let row = |gain: &crate::features::answer::Gain| {
        let fitted = |set: FeatureSet| {
            Cell::text(match set.fitted {
                Some(_) => FeatureSet { classical: false, ..set }.name(),
                None => "nothing".into(),
            })
        };
        let mut row = vec![fitted(gain.with), fitted(gain.without)];
        row.extend(gain.bearings.iter().map(|gain| Cell::number(signed(*gain))));
        row.extend([Cell::number(signed(gain.gain)), interval(gain.interval95), Cell::text(verdict(gain.verdict))]);
        row
    };
    answer.gains.iter().filter(|gain| gain.with.classical).map(row).collect()
}

fn interval([low, high]: [f64; 2]) -> Cell {
    Cell::number(format!("{} to {}", two(low), two(high)))
}

/// Number with two digits.
pub fn two(value: f64) -> String {
    format!("{value:.2}").replace('-', "−")
}

/// Predicted remaining life of each bearing, by three sets.
fn predictions(own: &LifeAnswer) -> Result<Section, DrawError> {
    let sets = [
        (FeatureSet::CLASSICAL, "by RMS and kurtosis", EARLY),
        (FeatureSet::of_recording(1, false), "by Ξ2", LATE),
        (FeatureSet::of_null(1, 0, false), "by the null's Ξ2 (cyclic)", PREDICTED),
    ];
    let mut section = Section::new("Predicted remaining life").paragraph(
        "Share of the life that is left, predicted by the other bearings, with features as they are. A prediction that is off \
         by a constant, or beyond 0 to 1, can still order the recordings.",
    );
    for (n, name) in own.answer.bearings.iter().enumerate() {
        let count = own.answer.rows[n];
        let truth = Curve { name: "true", points: vec![(1.0, 1.0), (count as f64, 0.0)], color: INK };
        let predicted = sets.iter().filter_map(|(set, name, color)| {
            let outputs = &own.answer.of(*set)?.outputs[n];
            let values: Vec<f64> = outputs.iter().map(|output| output[0]).collect();
            let points = running_median(&values).into_iter().enumerate().map(|(n, value)| (n as f64 + 1.0, value));
            Some(Curve { name, points: points.collect(), color: *color })
        });
        let curves: Vec<Curve<'_>> = std::iter::once(truth).chain(predicted).collect();
        let names = Names { x: "recording", y: "remaining share of the life" };
        let svg = comparison::svg(&curves, 0.0..count as f64 + 1.0, names, &[])?;
        let median = SETTINGS.running_median;
        section = section
            .figure(svg, format!("{name}, predicted by the others; the median of {median} recordings is drawn."));
    }
    Ok(section)
}

fn running_median(values: &[f64]) -> Vec<f64> {
    let reach = SETTINGS.running_median / 2;
    let one = |n: usize| {
        let mut near = values[n.saturating_sub(reach)..values.len().min(n + reach + 1)].to_vec();
        near.sort_by(f64::total_cmp);
        near[near.len() / 2]
    };
    (0..values.len()).map(one).collect()
}
