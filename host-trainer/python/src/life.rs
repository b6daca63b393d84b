//! Phases of a machine's life.

use std::path::PathBuf;

use ballrace::report::phases as report;
use ballrace::signal::phases::life::Timeline;
use ballrace::signal::phases::machine::{ChannelLife, Filter, Machine};
use ballrace::signal::phases::{Rules, not_positive};
use ballrace::signal::wavelet::Wavelet;
use ballrace::signal::wavelet::denoise::Denoising;
use ballrace::signal::wavelet::stationary::levels_below;
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::error::{choice, input, other};
use crate::look::with_page;
use crate::recording::Recordings;
use crate::run::run;

/// Finds when a machine began to age and to fail.
///
/// recordings: one machine's, in order from new to failed. Aging starts where the kurtosis leaves `sigmas` standard deviations
/// of the first `healthy` recordings (by default a quarter, 10 to 100), failure where an increment of the RMS is `ratio` times
/// the one that `failure` compares with: "successive", "rising" or "largest". Each channel is taken raw and denoised by a
/// stationary wavelet transform: wavelet is "db1" to "db10" or "sym2" to "sym10", threshold "universal", "minimax" or "sure",
/// shrinkage "soft" or "hard", noise "finest" or "each-level", and below_hz bounds its last approximation. name: the machine's,
/// by default its folder's.
///
/// Returns a dict, which shows its page in a notebook, of
/// `phases`: a dict for each channel, raw and denoised: `channel`, `denoised`, `healthy`, the count of healthy recordings,
/// `kurtosis` and `kurtosis_std` of these, `aging` and `failure`, indices from 0 of the recordings or None, with `_name` and
/// `_time_s`, s, of each, `in_a_row`, and `aging_recordings`, the count between both;
/// `features`: a dict of columns with a row for each channel, signal and recording: `channel`, `denoised`, `recording` (int64
/// index), `name`, `time_s` (float64, s since the first, NaN if unknown), `kurtosis` and `rms` (float64, in the channel's unit).
/// Both go into pandas.DataFrame as they are. Raises InputError for recordings too few or of several rates. Many machines:
/// `ballrace.fleet`.
#[pyfunction]
#[pyo3(signature = (recordings, *, healthy=None, sigmas=3.0, failure="largest", ratio=3.0, wavelet="db4",
    threshold="universal", shrinkage="soft", noise="each-level", below_hz=50.0, name=None))]
#[allow(clippy::too_many_arguments)]
pub fn phases<'py>(
    recordings: Recordings,
    healthy: Option<usize>,
    sigmas: f64,
    failure: &str,
    ratio: f64,
    wavelet: &str,
    threshold: &str,
    shrinkage: &str,
    noise: &str,
    below_hz: f64,
    name: Option<PathBuf>,
    py: Python<'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let rules = Rules { healthy, sigmas, failure: choice("failure", failure)?, ratio };
    let refused = rules.refused().or_else(|| not_positive("below_hz", below_hz, " of Hz"));
    if let Some((what, found, expected)) = refused {
        return Err(input(format!("{what}: found {found}, expected {expected}")));
    }
    let wavelet: Wavelet = wavelet.parse().map_err(|error| input(format!("wavelet: {error}")))?;
    let (rule, shrinkage) = (choice("threshold", threshold)?, choice("shrinkage", shrinkage)?);
    let noise = choice("noise", noise)?;
    let denoising = |sample_rate_hz| {
        let levels = levels_below(below_hz, sample_rate_hz);
        Denoising { wavelet, levels, rule, shrinkage, noise }
    };
    let folder = name.or_else(|| recordings.folder()).unwrap_or_else(|| "machine".into());
    let recordings = recordings.read(py)?;
    let machine = run(py, None, |_| Machine::new(&folder, &recordings, &rules, denoising))?.map_err(input)?;
    let out = PyDict::new(py);
    out.set_item("phases", rows(py, &machine)?)?;
    out.set_item("features", features(py, &machine)?)?;
    let page = report::document(std::slice::from_ref(&machine), &rules).map_err(other)?.html();
    with_page(&out, page)
}

/// Phases of each life.
fn rows<'py>(py: Python<'py>, machine: &Machine) -> PyResult<Bound<'py, PyList>> {
    let timeline = &machine.lives.timeline;
    let out = PyList::empty(py);
    for (life, phases) in machine.lives.channels.iter().zip(&machine.phases) {
        let Some(phases) = phases else { continue };
        let row = PyDict::new(py);
        row.set_item("channel", &life.channel)?;
        row.set_item("denoised", life.filter == Filter::Wavelet)?;
        row.set_item("healthy", phases.healthy)?;
        row.set_item("kurtosis", phases.mean)?;
        row.set_item("kurtosis_std", phases.std)?;
        for (what, index) in [("aging", phases.aging), ("failure", phases.failure)] {
            row.set_item(what, index)?;
            row.set_item(format!("{what}_name"), index.map(|index| timeline.names[index].as_str()))?;
            row.set_item(format!("{what}_time_s"), index.zip(timeline.times_s.as_ref()).map(|(n, times)| times[n]))?;
        }
        row.set_item("in_a_row", phases.in_a_row)?;
        row.set_item("aging_recordings", phases.between(life.features.len()))?;
        out.append(row)?;
    }
    Ok(out)
}

/// Features of each life as columns.
fn features<'py>(py: Python<'py>, machine: &Machine) -> PyResult<Bound<'py, PyDict>> {
    let Timeline { names, times_s, .. } = &machine.lives.timeline;
    let each: Vec<(&ChannelLife, usize)> =
        machine.lives.channels.iter().flat_map(|life| (0..life.features.len()).map(move |n| (life, n))).collect();
    let numbers =
        |of: &dyn Fn(&ChannelLife, usize) -> f64| -> Vec<f64> { each.iter().map(|(l, n)| of(l, *n)).collect() };
    let out = PyDict::new(py);
    out.set_item("channel", each.iter().map(|(life, _)| life.channel.as_str()).collect::<Vec<_>>())?;
    let denoised: Vec<bool> = each.iter().map(|(life, _)| life.filter == Filter::Wavelet).collect();
    out.set_item("denoised", denoised.into_pyarray(py))?;
    out.set_item("recording", each.iter().map(|(_, n)| *n as i64).collect::<Vec<_>>().into_pyarray(py))?;
    out.set_item("name", each.iter().map(|(_, n)| names[*n].as_str()).collect::<Vec<_>>())?;
    let time = |_: &ChannelLife, n: usize| times_s.as_ref().map_or(f64::NAN, |times| times[n]);
    out.set_item("time_s", numbers(&time).into_pyarray(py))?;
    out.set_item("kurtosis", numbers(&|life, n| life.features[n].kurtosis).into_pyarray(py))?;
    out.set_item("rms", numbers(&|life, n| life.features[n].rms).into_pyarray(py))?;
    Ok(out)
}
