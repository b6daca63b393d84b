//! Report of `ballrace sweep --preset`: the paper's tables and figures, ours, the paper's and the null's side by side.

use plotters::style::RGBColor;

use super::phases;
use super::settings::ReportSettings;
use super::{Cell, Document, Section, Tone};
use crate::model::OwnedModel;
use crate::model::fit::verdict;
use crate::model::trace::Trace;
use crate::paper::{AgedBearing, PaperLibrary, TABLE_3, TABLE_4, aged_bearing};
use crate::recording::input::Series;
use crate::report::plot::comparison::{self, Curve, Names};
use crate::report::plot::style::{ALARM, EARLY, INK, LATE, PREDICTED};
use crate::report::plot::{DrawError, derivative};
use crate::rivals;
use crate::signal::phases::Rules;
use crate::signal::phases::machine::{Filter, Machine};
use crate::signal::surrogate::SurrogateKind;
use crate::sweep::config::Sizes;
use crate::sweep::job::Row;
use crate::sweep::method::Method;
use crate::sweep::preset::Preset;
use crate::sweep::table::text;

const SETTINGS: ReportSettings = ReportSettings::DEFAULT;

/// Everything that the page shows.
pub struct Page<'a> {
    /// Rows of each table and figure.
    pub presets: &'a [PresetRows<'a>],
    /// Bearings with their phases.
    pub machines: Vec<&'a Machine>,
    /// Name of the bearing of Tables 3 and 4 and of the figures.
    pub bearing: &'a str,
    /// Channel.
    pub channel: &'a str,
    /// Rules of the phases.
    pub rules: Rules,
    /// Linear baselines on the recordings of Table 4.
    pub baselines: Vec<Baseline>,
    /// Model of the paper's best library.
    pub model: &'a OwnedModel,
    /// Recording that it was fitted to.
    pub shown: &'a Series,
    /// Sample rate of the recordings, Hz.
    pub sample_rate_hz: f64,
}

/// Rows of a table or figure.
#[derive(Clone, Copy)]
pub struct PresetRows<'a> {
    /// The table or figure.
    pub preset: Preset,
    /// Its rows.
    pub rows: &'a [Row],
}

/// Linear baseline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Baseline {
    /// Name.
    pub name: &'static str,
    /// R² of the derivatives in sample.
    pub r2: Option<f64>,
    /// R² of the derivatives, held out.
    pub r2_held_out: Option<f64>,
    /// R² of the next sample, held out.
    pub r2_causal: Option<f64>,
}

/// Score of a row.
type RowScore = fn(&Row) -> Option<f64>;

/// Page of the paper.
///
/// # Errors
/// Errors of the drawing library.
pub fn document(page: &Page<'_>) -> Result<Document, DrawError> {
    let names: Vec<&str> = page.machines.iter().map(|machine| machine.name.as_str()).collect();
    let about = format!("Fang et al., Machines 14 (2026) 620, on {}", names.join(", "));
    let mut document = Document::new("The paper, reproduced", about, Tone::Open, summary(page))
        .section(reading())
        .section(figure_8(page)?);
    for PresetRows { preset, rows } in page.presets {
        document = document.section(match preset {
            Preset::Table3 => table_3(rows, page),
            Preset::Table4 => table_4(rows, page),
            Preset::Table5 => table_5(rows, page),
            Preset::Fig10 => figure_10(rows)?,
            Preset::Fig11 => figure_11(rows)?,
        });
    }
    Ok(document.section(figure_13(page)?))
}

/// How many fits are better than their null, in a sentence.
fn summary(page: &Page<'_>) -> String {
    let own = page.presets.iter().flat_map(|own| own.rows);
    let mut rows: Vec<&Row> = own.filter(|row| row.job.solver.rival().is_none()).collect();
    // A fit may be in two figures.
    let mut seen = Vec::new();
    rows.retain(|row| {
        let is_new = !seen.contains(&&row.job);
        seen.push(&row.job);
        is_new
    });
    let pairs: Vec<(f64, f64)> = rows.iter().filter_map(|row| Some((row.r2?, row.r2_null?))).collect();
    if pairs.is_empty() {
        return "No fit has a score with a null beside it.".into();
    }
    let above = pairs.iter().filter(|(own, null)| own > null).count();
    let mean = |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(pick).sum::<f64>() / pairs.len() as f64;
    format!(
        "Over {} comparisons R² is {:.3} on the recordings and {:.3} on their surrogates, which have no dynamics but a linear filter's; in {above} the fit to the recording is above that to its surrogate.",
        pairs.len(),
        mean(|(own, _)| *own),
        mean(|(_, null)| *null)
    )
}

fn reading() -> Section {
    Section::new("How to read this page")
        .paragraph(
            "R² is the paper's score: of the derivatives a^(1), a^(3), … from the states a^(0), a^(2), …, mean over the derivatives, on the first three fifths of a recording, to which the model is fitted. Held out is the same on the last fifth; the fifth between them chooses the threshold. Differences of neighbouring orders share samples, so this score is high for any signal.",
        )
        .paragraph(
            "The null is the same fit to a surrogate of the same recording. Only what a model scores above its null is dynamics. Unless another kind is named, the surrogate has the recording's spectrum, the distribution of its innovations, and the periodic changes of their level.",
        )
        .paragraph(
            "Causal is R² of the next sample, predicted from past samples alone, held out. No algebra of differences can raise it.",
        )
        .paragraph(
            "The paper does not say how its differences are aligned in time. Here even orders are centred and odd ones half a sample later.",
        )
}

/// Mean over rows of what is known of them, with its standard deviation.
fn mean<'a>(rows: impl IntoIterator<Item = &'a Row>, of: RowScore) -> Option<(f64, f64)> {
    let known: Vec<f64> = rows.into_iter().filter_map(of).collect();
    let n = known.len() as f64;
    let mean = known.iter().sum::<f64>() / n;
    let variance = known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (!known.is_empty()).then(|| (mean, variance.sqrt()))
}

fn cell<'a>(rows: impl IntoIterator<Item = &'a Row>, of: RowScore) -> Cell {
    Cell::number(mean(rows, of).map_or("–".to_owned(), |(mean, _)| format!("{mean:.4}")))
}

fn with_spread<'a>(rows: impl IntoIterator<Item = &'a Row>, of: RowScore) -> Cell {
    Cell::number(mean(rows, of).map_or("–".to_owned(), |(mean, std)| format!("{mean:.4} ± {std:.4}")))
}

fn table_3(rows: &[Row], page: &Page<'_>) -> Section {
    let of = |library: &PaperLibrary, solver: Method| {
        rows.iter()
            .filter(move |row| row.job.sizes.name == library.name && row.job.solver == solver)
            .collect::<Vec<_>>()
    };
    let line = |library: &PaperLibrary| {
        let (network, squares) = (of(library, Method::SindyNn), of(library, Method::Stlsq));
        let [nd, nmd, nf] = library.sizes;
        vec![
            Cell::text(library.name.replace('_', " ")),
            Cell::number(format!("{nd}, {nmd}, {nf}")),
            Cell::number(library.functions),
            Cell::number(format!("{:.4}", library.r2)),
            cell(network.iter().copied(), |row| row.r2),
            cell(network.iter().copied(), |row| row.r2_null),
            cell(network.iter().copied(), |row| row.r2_held_out),
            cell(squares.iter().copied(), |row| row.r2),
            cell(squares.iter().copied(), |row| row.r2_null),
        ]
    };
    let more = |library: &PaperLibrary| {
        let (network, squares) = (of(library, Method::SindyNn), of(library, Method::Stlsq));
        let terms = |rows: &[&Row]| {
            let mean = mean(rows.iter().copied(), |row| Some(row.terms? as f64));
            Cell::number(mean.map_or("–".into(), |(terms, _)| format!("{terms:.0}")))
        };
        vec![
            Cell::text(library.name.replace('_', " ")),
            terms(&network),
            terms(&squares),
            cell(squares.iter().copied(), |row| row.r2_causal),
            cell(squares.iter().copied(), |row| row.r2_causal_null),
            Cell::number(format!("{:.2}", library.seconds)),
            seconds(&network),
            seconds(&squares),
        ]
    };
    let above = |solver: Method| {
        let own = rows.iter().filter(|row| row.job.solver == solver);
        let pairs: Vec<(f64, f64)> = own.filter_map(|row| Some((row.r2?, row.r2_null?))).collect();
        format!("{} of {}", pairs.iter().filter(|(own, null)| own > null).count(), pairs.len())
    };
    let head = ["No.", "n_D, n_MD, n_F", "functions", "paper", "SINDy-NN", "null", "held out", "STLSQ", "null"];
    let more_head =
        ["No.", "terms, SINDy-NN", "terms, STLSQ", "causal, STLSQ", "null", "paper, s", "SINDy-NN, s", "STLSQ, s"];
    Section::new(format!("Table 3: libraries on {}", page.bearing))
        .paragraph(format!(
            "{} of the aging phase, channel {}. The paper's are of Bearing 3_3. Above their null are {} fits of SINDy-NN and {} of STLSQ. Seconds of ours are with the null, of STLSQ with the causal fits too, each beside another fit; the paper's are of one training on its own machine.",
            recordings(rows),
            page.channel,
            above(Method::SindyNn),
            above(Method::Stlsq)
        ))
        .table("R² in sample", &head, TABLE_3.iter().map(line).collect())
        .table("Terms that are not 0 over all equations, next sample, time", &more_head, TABLE_3.iter().map(more).collect())
        .paragraph(failures(rows))
}

/// Number of recordings of rows, in words.
fn recordings(rows: &[Row]) -> String {
    let names: std::collections::BTreeSet<&String> = rows.iter().filter_map(|row| row.job.recording.as_ref()).collect();
    match names.len() {
        1 => "One recording".into(),
        many => format!("{many} recordings"),
    }
}

/// Fits that failed, in words; empty for none.
fn failures<'a>(rows: impl IntoIterator<Item = &'a Row>) -> String {
    let failed = rows.into_iter().filter_map(|row| {
        let Sizes { nd, nmd, nf, .. } = row.job.sizes;
        Some(format!("n_D {nd}, n_MD {nmd}, n_F {nf}: {}", row.error.as_ref()?))
    });
    let failed: Vec<String> = failed.collect();
    if failed.is_empty() { String::new() } else { format!("Failed: {}.", failed.join("; ")) }
}

fn table_4(rows: &[Row], page: &Page<'_>) -> Section {
    let same = |a: &Row, b: &Row| {
        (a.job.solver, &a.job.sizes, a.job.null_kind) == (b.job.solver, &b.job.sizes, b.job.null_kind)
    };
    let mut sorted: Vec<&Row> = rows.iter().collect();
    let is_rival = |row: &Row| row.job.solver.rival().is_some();
    sorted.sort_by_key(|row| (!is_rival(row), row.job.sizes.nd, row.job.solver, row.job.null_kind as u8));
    let own =
        sorted.chunk_by(|a, b| same(a, b)).map(|group| {
            let job = &group[0].job;
            let method = job.solver;
            let name = match (method, job.sizes.nd) {
                (Method::Stlsq, 1) => "linear: STLSQ, n_D 1".into(),
                (Method::Stlsq | Method::SindyNn, _) => format!("{}, No. 11", method.paper_name()),
                _ => format!("{}, {} parameters", method.paper_name(), group[0].terms.unwrap_or(0)),
            };
            let paper = TABLE_4.iter().find(|model| model.name == method.paper_name());
            let null = mean(group.iter().copied(), |row| row.r2_null);
            vec![
                Cell::text(name),
                Cell::number(paper.map_or("–".into(), |model| format!("{:.4}", model.r2))),
                with_spread(group.iter().copied(), |row| row.r2),
                Cell::text(null.map_or("–".into(), |(mean, _)| {
                    format!("{mean:.4}, {}", text(job.null_kind).unwrap_or_default())
                })),
                cell(group.iter().copied(), |row| row.r2_held_out),
                cell(group.iter().copied(), |row| row.r2_causal),
                cell(group.iter().copied(), |row| row.r2_causal_null),
                Cell::number(paper.map_or("–".into(), |model| format!("{:.1}", model.seconds))),
                seconds(group),
            ]
        });
    let number = |r2: Option<f64>| Cell::number(r2.map_or("–".into(), |r2| format!("{r2:.4}")));
    let linear = page.baselines.iter().map(|baseline| {
        let Baseline { name, r2, r2_held_out, r2_causal } = baseline;
        let none = || Cell::number("–");
        vec![
            Cell::text(*name),
            none(),
            number(*r2),
            none(),
            number(*r2_held_out),
            number(*r2_causal),
            none(),
            none(),
            none(),
        ]
    });
    let head = ["model", "paper", "ours", "null, kind", "held out", "causal", "causal null", "paper, s", "ours, s"];
    let rivals = if rows.iter().any(is_rival) {
        format!(
            "LSTM, TCN and PatchTransformer see a window of {} rows of the states, or of as many samples; learning rate and stop are chosen on the validation part. The states of a window hold the samples of which the derivatives are differences, so that least squares on it is exact: in this table a rival's score says how well it finds a subtraction. Causal is another training of the same network.",
            rivals::settings::SETTINGS.window
        )
    } else {
        let missing = TABLE_4.iter().filter(|model| model.name != Method::SindyNn.paper_name());
        let missing = missing.map(|model| format!("{} {:.4}", model.name, model.r2));
        format!(
            "The paper's rivals ({}) are in builds with the feature rivals: cargo build --release --features rivals.",
            missing.collect::<Vec<_>>().join(", ")
        )
    };
    let kind = |kind: &SurrogateKind| format!("{} {}", text(kind).unwrap_or_default(), verdict::kept(*kind));
    let kinds: Vec<String> = SurrogateKind::ALL.iter().map(kind).collect();
    Section::new(format!("Table 4: rivals on {}", page.bearing))
        .paragraph(format!(
            "{} of the aging phase, channel {}, each a fit of its own. The paper's are of Bearing 3_3. Seconds of ours are with null and causal fits. An autoregression is the baseline that the paper lacks, fitted and held out as the models are. What a null has of the recording: {}.",
            recordings(rows),
            page.channel,
            kinds.join(", ")
        ))
        .paragraph(rivals)
        .table("", &head, own.chain(linear).collect())
        .paragraph(failures(rows))
}

/// Mean seconds of rows.
fn seconds(rows: &[&Row]) -> Cell {
    let mean = mean(rows.iter().copied(), |row| Some(row.seconds));
    Cell::number(mean.map_or("–".into(), |(seconds, _)| format!("{seconds:.2}")))
}

fn table_5(rows: &[Row], page: &Page<'_>) -> Section {
    let line = |machine: &&Machine| {
        let of = |solver: Method| {
            let is_own = |row: &&Row| {
                let folder = row.job.recording.as_ref().and_then(|name| name.split('/').next());
                folder == Some(machine.name.as_str()) && row.job.solver == solver
            };
            rows.iter().filter(is_own).collect::<Vec<_>>()
        };
        let (network, squares) = (of(Method::SindyNn), of(Method::Stlsq));
        let paper = aged_bearing(&machine.name);
        let paper_r2 = |AgedBearing { r2, r2_std, .. }: AgedBearing| format!("{r2:.4} ± {r2_std:.4}");
        let raw = machine.lives.channels.iter().zip(&machine.phases).find(|(life, _)| life.filter == Filter::Raw);
        let between = raw.and_then(|(life, phases)| phases.as_ref()?.between(life.features.len()));
        vec![
            Cell::text(&machine.name),
            Cell::number(paper.map_or("–".into(), |bearing| bearing.aging_recordings.to_string())),
            Cell::number(between.map_or("–".into(), |count| count.to_string())),
            Cell::number(paper.map_or("–".into(), paper_r2)),
            with_spread(network.iter().copied(), |row| row.r2),
            with_spread(network.iter().copied(), |row| row.r2_null),
            with_spread(squares.iter().copied(), |row| row.r2),
            with_spread(squares.iter().copied(), |row| row.r2_null),
            cell(squares.iter().copied(), |row| row.r2_causal),
            cell(squares.iter().copied(), |row| row.r2_causal_null),
        ]
    };
    let head = [
        "bearing",
        "aging recordings, paper",
        "ours",
        "R², paper",
        "SINDy-NN",
        "null",
        "STLSQ",
        "null",
        "causal",
        "causal null",
    ];
    Section::new("Table 5: library No. 11 on each bearing")
        .paragraph(format!("Mean and standard deviation over recordings spread evenly over the aging phase, channel {}. The aging phase is that of the raw kurtosis, by the rule of the consecutive 3 σ.", page.channel))
        .table("", &head, page.machines.iter().map(line).collect())
        .paragraph(failures(rows))
}

fn figure_8(page: &Page<'_>) -> Result<Section, DrawError> {
    let mut section = Section::new("Figure 8: aging phases").paragraph(
        "Kurtosis and RMS of each recording from new to failed, with the start of aging and of failure. More of this: ballrace phases.",
    );
    for machine in &page.machines {
        section = phases::pictures(section.paragraph(phases::verdict(machine)), machine, &page.rules)?;
    }
    Ok(section)
}

/// Colours of the curves of a study.
const COLOURS: [RGBColor; 5] = [EARLY, LATE, PREDICTED, ALARM, INK];

fn figure_10(rows: &[Row]) -> Result<Section, DrawError> {
    let section = Section::new("Figure 10: degree n_D and dimension n_MD").paragraph(
        "Polynomial libraries by STLSQ, one curve for each degree. The first step of the library's construction takes the degrees that reach R² 0.90, the second the dimension.",
    );
    let degrees: Vec<(String, Vec<&Row>)> =
        (1..=5).map(|nd| (format!("n_D {nd}"), rows.iter().filter(|row| row.job.sizes.nd == nd).collect())).collect();
    studies(section, &degrees, ("dimension n_MD", |row| row.job.sizes.nmd), 0.5..8.5)
}

fn figure_11(rows: &[Row]) -> Result<Section, DrawError> {
    let section = Section::new("Figure 11: harmonics n_F").paragraph(
        "Custom libraries by STLSQ, one curve for each n_D and n_MD: the third step of the library's construction.",
    );
    let mut bases: Vec<(usize, usize)> = rows.iter().map(|row| (row.job.sizes.nd, row.job.sizes.nmd)).collect();
    bases.dedup();
    let is_of = |row: &&Row, base: (usize, usize)| (row.job.sizes.nd, row.job.sizes.nmd) == base;
    let curves: Vec<(String, Vec<&Row>)> = bases
        .iter()
        .map(|base| (format!("n_D {}, n_MD {}", base.0, base.1), rows.iter().filter(|row| is_of(row, *base)).collect()))
        .collect();
    studies(section, &curves, ("harmonics n_F", |row| row.job.sizes.nf), -0.5..6.5)
}

/// Three pictures of a study: R² in sample, what of it is above the null, and held out.
fn studies(
    mut section: Section,
    curves: &[(String, Vec<&Row>)],
    (x_name, size): (&str, fn(&Row) -> usize),
    x: std::ops::Range<f64>,
) -> Result<Section, DrawError> {
    let beyond = |row: &Row| Some(row.r2? - row.r2_null?);
    let scores: [(&str, &str, RowScore); 3] = [
        ("R² in sample", "In sample, the paper's score.", |row| row.r2),
        ("R² above the null", "In sample, less that of the surrogate: below 0 the surrogate is fitted better.", beyond),
        ("R² held out", "On the last fifth of the recording.", |row| row.r2_held_out),
    ];
    for (y_name, caption, of) in scores {
        let drawn: Vec<Curve<'_>> = curves
            .iter()
            .zip(COLOURS)
            .map(|((name, rows), color)| {
                let mut sizes: Vec<usize> = rows.iter().map(|row| size(row)).collect();
                sizes.dedup();
                let point = |at: usize| {
                    let (mean, _) = mean(rows.iter().copied().filter(|row| size(row) == at), of)?;
                    Some((at as f64, mean))
                };
                Curve { name, points: sizes.into_iter().filter_map(point).collect(), color }
            })
            .collect();
        let svg = comparison::svg(&drawn, x.clone(), Names { x: x_name, y: y_name }, &[])?;
        section = section.figure(svg, caption);
    }
    Ok(section.paragraph(curves.iter().map(|(_, rows)| failures(rows.iter().copied())).collect::<Vec<_>>().join(" ")))
}

fn figure_13(page: &Page<'_>) -> Result<Section, DrawError> {
    let first = page.shown.samples.len() * 9 / 10;
    let range = first..(first + SETTINGS.close_window).min(page.shown.samples.len());
    let trace = Trace::record(&page.model.view(), &page.shown.samples, page.sample_rate_hz, range);
    let shown: Vec<usize> = (0..trace.names.len().min(SETTINGS.panels)).collect();
    let caption = format!(
        "{}, held-out end. Measured and predicted derivatives of the lowest orders, in standard deviations of each.",
        page.shown.name
    );
    Ok(Section::new("Figure 13: measured and predicted derivatives")
        .paragraph("SINDy-NN with library No. 11. How far the curves lie on each other is what R² says; what of it is dynamics, only the null can say.")
        .figure(derivative::svg(&trace, &shown)?, caption))
}
