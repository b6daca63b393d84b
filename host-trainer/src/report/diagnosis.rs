//! Report of `ballrace diagnose`, to be read in two minutes.

use std::path::Path;

use super::held_out::{self, Quantity, Rigs};
use super::machine;
use super::settings::ReportSettings;
use super::{Cell, Document, Section, Tone};
use crate::diagnose::machine::is_unknown;
use crate::diagnose::result::{Aspect, Cause, DiagnosisResult, FDR_LEVEL, HeldOut, Parameter, Test, Verdict};
use crate::diagnose::write::{self, REPORT, StoreError};
use crate::diagnose::{Task, shown};
use crate::recording::Recording;
use crate::report::plot::DrawError;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::style::LATE;
use crate::rig::config::RigKey;
use crate::rig::{Machine, Rig};
use crate::stats::format::{by_chance, capital, chance, significant};
use crate::stats::units::{NamedUnit, in_words};

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Error of writing a diagnosis with its report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FolderError {
    /// The report could not be drawn.
    #[error("{REPORT}: {0}")]
    Draw(#[from] DrawError),
    /// The folder could not be written.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Writes a diagnosis as a folder, with its report.
///
/// # Errors
/// Those of [`write::folder`], and errors of the drawing library.
pub fn folder(out: &Path, task: &Task, outcome: &DiagnosisResult) -> Result<(), FolderError> {
    Ok(write::folder(out, outcome, &document(task, outcome)?.html())?)
}

/// Report of a diagnosis.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(task: &Task, outcome: &DiagnosisResult) -> Result<Document, DrawError> {
    let before = task.rig;
    let (tone, sentence) = verdict(outcome);
    let mut document = Document::new(Words::of(before).title, about(task), tone, sentence);
    if let Some(section) = seen(before, outcome)? {
        document = document.section(section);
    }
    document = document.sections(machine::envelopes(task, outcome)?);
    let causes = outcome.diagnosis.causes.iter().enumerate().map(|(index, c)| cause(index, c));
    document = document.sections(causes).section(fit(before, outcome));
    Ok(document.sections(
        [alternatives(outcome), place(outcome)?, tests(outcome), fitted(before, outcome), caveats(outcome)]
            .into_iter()
            .flatten(),
    ))
}

/// Names, count and length of the diagnosed recordings.
fn about(task: &Task) -> String {
    let seconds: f64 = task.recordings.iter().map(Recording::duration_s).sum();
    let compared = task.baseline.map_or(String::new(), |b| format!(", baseline recordings: {}", b.len()));
    let count = match task.recordings {
        [one] => one.name(),
        [first, .., last] => format!("{} recordings, {} to {}", task.recordings.len(), first.name(), last.name()),
        [] => String::new(),
    };
    format!("{count}, {seconds:.1} s{compared}")
}

/// Words for a rig that is simulated, or for a machine of unknown structure, of which nothing is.
struct Words {
    title: &'static str,
    differs: &'static str,
    unlike: &'static str,
    correction: &'static str,
    /// What a recording is compared with in a sentence, without the causes and with them.
    compared: [&'static str; 2],
    /// Names of the curves without causes and with them.
    curves: [&'static str; 2],
}

impl Words {
    fn of(rig: &Rig) -> Self {
        if is_unknown(rig) {
            return Self {
                title: "What the machine shows",
                differs: "shows",
                unlike: "is not as a healthy one",
                correction: "that",
                compared: ["what is predicted without it", "what is predicted with it"],
                curves: ["the prediction without a cause", "the prediction with the cause"],
            };
        }
        let is_as_it_was = rig.unknown.is_empty();
        Self {
            title: "What the simulation left out",
            differs: "differs from the rig by",
            unlike: "differs from the rig",
            correction: "this correction",
            compared: ["the rig", "the corrected one"],
            curves: [
                if is_as_it_was { "the rig as it was" } else { "the rig, its unknowns fitted" },
                "the corrected rig",
            ],
        }
    }
}

/// Tone and sentence of the verdict.
pub fn verdict(outcome: &DiagnosisResult) -> (Tone, String) {
    let diagnosis = &outcome.diagnosis;
    let fit = &diagnosis.fit;
    let unit = if fit.metric == shown::METRIC { " dB" } else { "" };
    let numbers = [fit.before, fit.after, fit.noise_floor].map(|v| significant(v, 3) + unit);
    let chance = by_chance(fit.p_value);
    match diagnosis.verdict {
        Verdict::Mismatch => {
            let named: Vec<String> = diagnosis.causes.iter().map(short).collect();
            let named = listed(&named);
            let words = Words::of(&outcome.rig);
            let gain = if fit.after < fit.before {
                format!(
                    "With {} the held-out error falls from {} to {} (noise floor {}; {chance}).{}",
                    words.correction,
                    numbers[0],
                    numbers[1],
                    numbers[2],
                    strongest_band(outcome, &words)
                )
            } else {
                "The evidence, given below, is in the samples themselves.".to_owned()
            };
            (Tone::Bad, format!("The machine {} {named}. {gain}", words.differs))
        }
        Verdict::NoMismatch => {
            // In spectra the rig is compared under all that a machine is beyond its drawing, which is more than chance.
            let text = if fit.metric == shown::METRIC {
                format!(
                    "No mismatch: what the held-out recordings show beyond the rig (error {}, noise floor {}) is no more than \
                     the tolerances of make, speed, load and colour of the noise allow.",
                    numbers[0], numbers[2]
                )
            } else {
                let why = if fit.before < SETTINGS.near_noise * fit.noise_floor {
                    "the residual of held-out recordings is within chance"
                } else {
                    "what held-out recordings have beyond the sensor's noise is a random force, or within the tolerance of what \
                     is stated"
                };
                format!("No mismatch: {why} (error {}, noise floor {}).", numbers[0], numbers[2])
            };
            (Tone::Good, machine::quiet(&outcome.rig, fit.before).unwrap_or(text))
        }
        Verdict::Unexplained => {
            let text = format!(
                "The machine {}, but no cause of the vocabulary explains how: the held-out error is {}, the noise floor {}.{}",
                Words::of(&outcome.rig).unlike,
                numbers[0],
                numbers[2],
                most_telling(outcome)
            );
            (Tone::Open, text)
        }
    }
}

/// Band in which the correction brings the rig nearest to the recordings, as a sentence; empty where spectra are no measure.
fn strongest_band(outcome: &DiagnosisResult, words: &Words) -> String {
    if outcome.diagnosis.fit.metric != shown::METRIC {
        return String::new();
    }
    let band = shown::strongest_band(&outcome.held_out);
    band.map_or_else(String::new, |band| {
        let [from, to] = band.hz.map(|hz| significant(hz, 3));
        let [before, after] =
            band.over_db.map(|db| format!("{:.1} dB {}", db.abs(), if db < 0.0 { "below" } else { "above" }));
        let [without, with] = words.compared;
        format!(" In {} from {from} to {to} Hz the recording is {before} {without} and {after} {with}.", band.name)
    })
}

/// What tells most of an unexplained mismatch, as sentences: the change of a machine against its baseline, or the most significant
/// test of the residual; empty if none is significant.
fn most_telling(outcome: &DiagnosisResult) -> String {
    let change = outcome.diagnosis.causes.first().map(|change| format!(" {}", change.evidence));
    let significant = || outcome.tests.first().filter(|t| t.is_significant());
    let test = || Some(significant()?).map(|t| format!(" Most significant: {} ({}).", t.what, by_chance(t.p_value)));
    change.or_else(test).unwrap_or_default()
}

/// Name and parameters of a cause and, below one half, its probability, for a sentence.
fn short(cause: &Cause) -> String {
    let one = |(name, value): (&String, &Parameter)| match value {
        Parameter::Number(v) => in_words(cause.key_with_unit(name), *v, cause.interval95.get(name).copied()),
        Parameter::Name(text) => format!("{name} {text}"),
    };
    let (names, numbers): (Vec<_>, Vec<_>) =
        cause.parameters.iter().partition(|(_, v)| matches!(v, Parameter::Name(_)));
    let signs = Some(&cause.signs).filter(|signs| !signs.is_empty());
    let doubt = (cause.probability < 0.5).then(|| format!("probability {}", percent(cause.probability)));
    let told: Vec<String> = numbers.into_iter().chain(names).map(one).chain(signs.cloned()).chain(doubt).collect();
    if told.is_empty() { cause.name.clone() } else { format!("{} ({})", cause.name, told.join(", ")) }
}

/// Probability in percent, never rounded to 0 % or 100 %.
pub fn percent(probability: f64) -> String {
    match 100.0 * probability {
        p if p >= 99.5 => "over 99 %".into(),
        p if p < 0.5 => "under 1 %".into(),
        p => format!("{p:.0} %"),
    }
}

fn listed(names: &[String]) -> String {
    match names {
        [] => "nothing".into(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Pictures of the first held-out recording of the channel with the largest mismatch.
fn seen(before: &Rig, outcome: &DiagnosisResult) -> Result<Option<Section>, DrawError> {
    let location = &outcome.diagnosis.location;
    let of_channel = |h: &&HeldOut| !location.channel.is_empty() && h.name.ends_with(&location.channel);
    let held = outcome.held_out.iter();
    let Some(held) = held.clone().find(of_channel).or(held.clone().next()).filter(|h| !h.measured.is_empty()) else {
        return Ok(None);
    };
    let quantity = Quantity::for_channel(before, &location.channel);
    let [without, with] = Words::of(before).curves;
    // It may be corrected by what has no name.
    let is_corrected = !outcome.diagnosis.causes.is_empty() || outcome.rig.effects.len() > before.effects.len();
    let rigs = Rigs { before: without, after: if is_corrected { with } else { without } };
    let section = Section::new("A held-out recording, measured and simulated");
    let mut section = held_out::pictures(section, held, quantity, rigs, location)?;
    if outcome.held_out.len() > 1 || quantity == Quantity::Acceleration {
        let (head, rows) = held_out::table(&outcome.held_out, quantity);
        section = section.table("All held-out recordings.", &head, rows);
    }
    let is_simulated = matches!(before.model, Machine::Bearing(_)) && !is_unknown(before);
    if quantity == Quantity::Acceleration && is_simulated {
        section = section.paragraph(
            "Process force and sensor noise of a simulation are independent of the machine's: noise bounds the error sample \
             by sample from below, while spectra compare what both have in common.",
        );
    }
    Ok(Some(section))
}

fn cause(index: usize, cause: &Cause) -> Section {
    let heading = format!("{}. {}, probability {}", index + 1, cause.name, percent(cause.probability));
    let mut evidence = cause.evidence.clone();
    if !evidence.ends_with('.') {
        evidence.push('.');
    }
    let mut section = Section::new(heading).paragraph(evidence);
    if !cause.equation.is_empty() {
        section = section.equations(vec![cause.equation.clone()]);
    }
    let rows: Vec<Vec<Cell>> = cause.parameters.iter().map(|(name, value)| parameter(cause, name, value)).collect();
    if rows.is_empty() { section } else { section.table("", &["parameter", "value", "95 % interval", "unit"], rows) }
}

/// Row of a table: name of a parameter, value, 95 % interval, unit.
pub fn parameter(cause: &Cause, name: &str, value: &Parameter) -> Vec<Cell> {
    let (name, (value, interval), unit) = match value {
        Parameter::Number(v) => {
            let named = NamedUnit::new(cause.key_with_unit(name), *v);
            let texts = named.texts(*v, cause.interval95.get(name).copied());
            (named.name, texts, named.unit)
        }
        Parameter::Name(text) => (name.to_owned(), (text.clone(), String::new()), String::new()),
    };
    vec![Cell::text(name), Cell::number(value), Cell::number(interval), Cell::text(unit)]
}

fn fit(before: &Rig, outcome: &DiagnosisResult) -> Section {
    let fit = &outcome.diagnosis.fit;
    let numbers = [fit.before, fit.after, fit.noise_floor].map(|v| Cell::number(significant(v, 4)));
    let row = numbers.into_iter().chain([Cell::number(chance(fit.p_value))]).collect();
    let files = match outcome.held_out.len() {
        0 => String::new(),
        _ => " The signals are in heldout/.".to_owned(),
    };
    let [kind, _] = Words::of(before).curves;
    Section::new("Fit to held-out recordings")
        .paragraph(format!("{}. Held out: {}. Before: {kind}.{files}", capital(&fit.metric), fit.held_out))
        .table("", &["before", "after", "noise floor", "p"], vec![row])
}

fn alternatives(outcome: &DiagnosisResult) -> Option<Section> {
    let rejected = &outcome.diagnosis.rejected;
    let rows: Vec<Vec<Cell>> = rejected.iter().map(|r| vec![Cell::text(&r.name), Cell::text(&r.why)]).collect();
    let section = Section::new("Rejected causes");
    (!rows.is_empty()).then(|| section.table("", &["cause", "reason"], rows))
}

/// Location of the mismatch: a table with p-values, and pictures over frequency and time.
fn place(outcome: &DiagnosisResult) -> Result<Option<Section>, DrawError> {
    let location = &outcome.diagnosis.location;
    let span = |[from, to]: [f64; 2]| format!("{} to {}", significant(from, 3), significant(to, 3));
    let spans = |name, list: &[[f64; 2]], aspect: Aspect| -> Vec<(&str, String, Option<f64>)> {
        list.iter().map(|at| (name, span(*at), p_within(outcome, &[aspect], *at))).collect()
    };
    let angle = |at: &[f64; 2]| {
        ("angle of the shaft, °", span(at.map(f64::to_degrees)), p_within(outcome, &[Aspect::ShaftAngle], *at))
    };
    let order = |o: &f64| {
        ("order of the shaft", significant(*o, 4), p_within(outcome, &[Aspect::Order, Aspect::Envelope], [*o, *o]))
    };
    let said = |name, text: &String| (name, text.clone(), None);
    let rows = [
        spans("time, s", &location.time_s, Aspect::Time),
        spans("frequency, Hz", &location.frequency_hz, Aspect::Spectrum),
        location.order.iter().map(order).collect(),
        location.angle_rad.iter().map(angle).collect(),
        vec![said("state", &location.state), said("channel", &location.channel)],
    ];
    let rows: Vec<Vec<Cell>> = rows
        .into_iter()
        .flatten()
        .filter(|(_, text, _)| !text.is_empty())
        .map(|(name, text, p)| {
            vec![Cell::text(name), Cell::text(text), Cell::number(p.map_or_else(String::new, chance))]
        })
        .collect();
    let shown = outcome.diagnosis.verdict != Verdict::NoMismatch && !rows.is_empty();
    if !shown {
        return Ok(None);
    }
    let mut section =
        Section::new("Location of the mismatch").table("", &["", "where", "smallest p of a test there"], rows);
    for (aspect, x) in [(Aspect::Spectrum, "frequency, Hz"), (Aspect::Time, "time, s")] {
        let of = |t: &&Test| t.aspect == aspect && t.channel == location.channel;
        let mut at: Vec<([f64; 2], f64)> = outcome.tests.iter().filter(of).filter_map(|t| Some((t.at?, t.z))).collect();
        at.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let (Some(first), Some(last)) = (at.first(), at.last()) else { continue };
        let range = first.0[0]..last.0[1];
        let points = at.iter().flat_map(|([from, to], y)| [(*from, *y), (*to, *y)]).collect();
        let curve = Curve { name: "without causes", points, color: LATE };
        let names = Names { x, y: "standard deviations" };
        section = section.figure(
            comparison::svg(&[curve], range, names, &[])?,
            format!("{}: {}, in standard deviations of the null distribution.", location.channel, aspect.text()),
        );
    }
    Ok(Some(section))
}

/// Smallest p-value of the tests of these aspects within an interval.
fn p_within(outcome: &DiagnosisResult, aspects: &[Aspect], [from, to]: [f64; 2]) -> Option<f64> {
    let slack = 1e-3 * to.abs();
    let within = |t: &&Test| {
        aspects.contains(&t.aspect)
            && t.channel == outcome.diagnosis.location.channel
            && t.at.is_some_and(|[low, high]| low >= from - slack && high <= to + slack)
    };
    outcome.tests.iter().filter(within).map(|t| t.p_value).min_by(f64::total_cmp)
}

fn tests(outcome: &DiagnosisResult) -> Option<Section> {
    let all = &outcome.tests;
    let significant = all.iter().filter(|t| t.is_significant()).count();
    let section = Section::new("Tests of the residual without causes").paragraph(format!(
        "{significant} of {} tests are significant at a false discovery rate of {:.0} %. z is in standard deviations of \
         the test's null distribution, p belongs to the single test, q is the false discovery rate at which it is \
         significant.",
        all.len(),
        100.0 * FDR_LEVEL
    ));
    let mut aspects: Vec<Aspect> = Vec::new();
    // The aspect of the most significant test first.
    for test in all.iter().filter(|t| t.aspect != Aspect::Force) {
        if !aspects.contains(&test.aspect) {
            aspects.push(test.aspect);
        }
    }
    let numbers = |t: &Test| {
        let z = format!("{:.1}", t.z).replace('-', "−");
        [z, chance(t.p_value), chance(t.q_value)].map(Cell::number)
    };
    let of_aspect = |aspect: &Aspect| {
        let of: Vec<&Test> = all.iter().filter(|t| t.aspect == *aspect).collect();
        let standing = of.iter().filter(|t| t.is_significant()).count();
        let first = of.first()?;
        let words =
            [Cell::text(aspect.text()), Cell::number(format!("{standing} of {}", of.len())), Cell::text(&first.what)];
        Some(words.into_iter().chain(numbers(first)).collect())
    };
    let rows: Vec<Vec<Cell>> = aspects.iter().filter_map(of_aspect).collect();
    if !rows.is_empty() {
        let head = ["quantity", "significant", "most significant test", "z", "p", "q"];
        return Some(section.table("", &head, rows));
    }
    let row = |t: &Test| std::iter::once(Cell::text(&t.what)).chain(numbers(t)).collect();
    let listed = SETTINGS.tests;
    let rows: Vec<Vec<Cell>> = all.iter().take(listed).map(row).collect();
    let caption = match all.len() {
        all if all > listed => format!("The {listed} most significant of {all} tests."),
        _ => String::new(),
    };
    (!rows.is_empty()).then(|| section.table(caption, &["test", "z", "p", "q"], rows))
}

fn fitted(before: &Rig, outcome: &DiagnosisResult) -> Option<Section> {
    let row = |(name, value, interval): &(String, f64, [f64; 2])| {
        let named = NamedUnit::new(name, *value);
        let (value, interval) = named.texts(*value, Some(*interval));
        let given = RigKey::parse(name).and_then(|key| before.get(key));
        let given = given.map_or("–".into(), |v| significant(named.factor * v, 4));
        let numbers = [given, value, interval].map(Cell::number);
        [Cell::text(named.name)].into_iter().chain(numbers).chain([Cell::text(named.unit)]).collect()
    };
    let rows: Vec<Vec<Cell>> = outcome.fitted.iter().map(row).collect();
    let section = Section::new("Unknown parameters of the rig, fitted jointly");
    (!rows.is_empty()).then(|| section.table("", &["parameter", "given", "fitted", "95 % interval", "unit"], rows))
}

fn caveats(outcome: &DiagnosisResult) -> Option<Section> {
    let section = Section::new("Caveats");
    (!outcome.caveats.is_empty())
        .then(|| outcome.caveats.iter().fold(section, |section, caveat| section.paragraph(caveat)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::result::{Diagnosis, Fit, Left, Location, Rejected, SCHEMA};
    use crate::report::html::tests::assert_well_formed;
    use crate::rig::EffectEntry;
    use crate::rig::config::ModelKey;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::nominal;

    fn outcome(verdict: Verdict, causes: Vec<Cause>, after: f64) -> DiagnosisResult {
        let signal = |size: f64| (0..4096).map(|k| size * (0.37 * f64::from(k)).sin()).collect::<Vec<f64>>();
        let held = |name: &str| HeldOut {
            name: name.into(),
            sample_rate_hz: 25_600.0,
            measured: signal(1.0),
            before: signal(0.4),
            after: signal(0.9),
        };
        let test = |k: u32| Test {
            aspect: Aspect::Spectrum,
            channel: "ay",
            at: Some([200.0 * f64::from(k), 200.0 * f64::from(k + 1)]),
            what: format!("band <{k}>"),
            z: 9.0 - f64::from(k),
            p_value: 1e-12,
            q_value: if k < 9 { 1e-10 } else { 0.5 },
        };
        DiagnosisResult {
            diagnosis: Diagnosis {
                schema: SCHEMA.into(),
                verdict,
                causes,
                rejected: vec![Rejected { name: "shock".into(), why: "no <burst> & no jump".into() }],
                location: Location {
                    frequency_hz: vec![[1400.0, 1600.0]],
                    channel: "ay".into(),
                    ..Location::default()
                },
                terms: Vec::new(),
                nuisance: Vec::new(),
                left: Left::default(),
                fit: Fit {
                    metric: "log-spectral distance, dB".into(),
                    held_out: "r04".into(),
                    before: 4.0,
                    after,
                    noise_floor: 0.9,
                    p_value: 1e-6,
                },
            },
            rig: nominal(),
            held_out: vec![held("r04-ax"), held("r04-ay")],
            tests: (0..20).map(test).collect(),
            fitted: vec![(ModelKey::OuterStiffness.to_string(), 1e7, [f64::NEG_INFINITY, f64::INFINITY])],
            caveats: vec!["Mind the <gap>.".into()],
            settings: serde_json::Value::Null,
        }
    }

    fn page(outcome: &DiagnosisResult) -> Document {
        document(&Task { rig: &nominal(), baseline: None, recordings: &[], seed: 0 }, outcome).unwrap()
    }

    #[test]
    fn a_bearing_has_spectra_causes_and_the_most_telling_test_of_each_aspect() {
        let cause = Cause {
            name: "outer-race-defect".into(),
            probability: 0.998,
            parameters: [("depth_m".to_owned(), Parameter::Number(1.234e-5))].into(),
            interval95: [("depth_m".to_owned(), [1.2e-5, 1.3e-5])].into(),
            evidence: "Lines at <BPFO>".into(),
            equation: "c becomes c + d".into(),
            ..Cause::default()
        };
        let html = page(&outcome(Verdict::Mismatch, vec![cause], 1.0)).html();
        assert_well_formed(&html);
        for expected in ["by outer-race-defect (depth 12.3 µm)", "probability over 99 %", "12.0 to 13.0", "<td>µm</td>"]
        {
            assert!(html.contains(expected), "{expected}");
        }
        // The channel that shows it most is drawn.
        assert!(html.contains("r04-ay: power spectral density") && !html.contains("r04-ax: power"));
        assert!(
            html.contains("9 of 20 tests are significant")
                && html.contains("band &lt;0&gt;")
                && !html.contains("lt;1&gt;")
        );
        // The band that is named has the p-value of the test within it, and both are drawn.
        assert!(html.contains("1400 to 1600") && html.contains("ay: power in bands, in standard deviations"));
    }

    #[test]
    fn a_verdict_without_causes_says_so() {
        let of = |verdict| super::verdict(&outcome(verdict, Vec::new(), 4.0));
        let (tone, text) = of(Verdict::NoMismatch);
        assert!(tone == Tone::Good && text.starts_with("No mismatch"), "{text}");
        let (tone, text) = of(Verdict::Unexplained);
        assert!(tone == Tone::Open && text.contains("no cause of the vocabulary"), "{text}");
        let mut unexplained = outcome(Verdict::Unexplained, Vec::new(), 4.0);
        let html = page(&unexplained).html();
        assert_well_formed(&html);
        assert!(!html.contains("the corrected rig"));
        // Corrected by what has no name.
        unexplained
            .rig
            .effects
            .push(EffectEntry::new(EffectKind::TransverseSensitivity, &[(ParameterKey::Value, 0.1)]));
        assert!(page(&unexplained).html().contains("the corrected rig"));
    }
}
