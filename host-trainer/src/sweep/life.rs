//! Bearings run to failure, as the presets take them.

use super::config::MaterialError;
use super::job::{Job, Material};
use super::preset::{Bearing, PAPER_BEARING, Preset};
use crate::recording::Recording;
use crate::recording::input::{Input, InputError, Series};
use crate::signal::phases::machine::{Filter, Lives};
use crate::signal::phases::{Phases, Rules};
use crate::signal::wavelet::Wavelet;
use crate::signal::wavelet::denoise::Denoising;

/// Bearing run to failure, with what the page of the paper shows of it.
pub struct Life {
    /// Names of its recordings, and its aging phase by the raw channel.
    pub bearing: Bearing,
    /// Channel of each recording, named `BEARING/RECORDING`.
    pub series: Vec<Series>,
    /// Sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Features of the channel, raw and denoised.
    pub lives: Lives,
    /// Phases of both.
    pub phases: Vec<Option<Phases>>,
}

impl Life {
    /// Life of a bearing; `None` if its channel does not age.
    ///
    /// # Errors
    /// Recordings without the channel, or of several rates.
    pub fn new(
        name: &str,
        recordings: &[Recording],
        channel: &str,
        wavelet: Wavelet,
    ) -> Result<Option<Self>, InputError> {
        let mut input = Input::from_recordings(recordings, Some(channel))?;
        input.series.iter_mut().for_each(|series| series.name = format!("{name}/{}", series.name));
        let lives = Lives::new(recordings, &Denoising::of_paper(wavelet, input.sample_rate_hz));
        let phases = lives.phases(&Rules::default());
        let raw = lives.channels.iter().zip(&phases).find(|(life, _)| life.filter == Filter::Raw);
        let aging = raw.and_then(|(_, phases)| {
            let phases = (*phases)?;
            Some(phases.aging?..phases.failure.unwrap_or(input.series.len()))
        });
        let Some(aging) = aging else { return Ok(None) };
        let recordings = input.series.iter().map(|series| series.name.clone()).collect();
        Ok(Some(Self {
            bearing: Bearing { name: name.to_owned(), recordings, aging },
            series: input.series,
            sample_rate_hz: input.sample_rate_hz,
            lives,
            phases,
        }))
    }
}

/// The bearing of the paper's Tables 3 and 4, or the first.
///
/// # Errors
/// No bearing.
pub fn of_paper(lives: &[Life]) -> Result<&Life, MaterialError> {
    lives.iter().find(|life| life.bearing.name == PAPER_BEARING).or(lives.first()).ok_or(MaterialError::NoAging)
}

/// Recordings of all bearings, and the jobs of each preset; `count` recordings of each aging phase, by default those of the preset.
///
/// # Errors
/// No bearing, or bearings of different sample rates.
pub fn grid(
    lives: &[Life],
    presets: &[Preset],
    count: Option<usize>,
) -> Result<(Material, Vec<Vec<Job>>), MaterialError> {
    let sample_rate_hz = of_paper(lives)?.sample_rate_hz;
    if let Some(other) = lives.iter().find(|life| life.sample_rate_hz != sample_rate_hz) {
        let (bearing, found_hz) = (other.bearing.name.clone(), other.sample_rate_hz);
        return Err(MaterialError::Rate { bearing, found_hz, expected_hz: sample_rate_hz });
    }
    let bearings: Vec<Bearing> = lives.iter().map(|life| life.bearing.clone()).collect();
    let material = Material { series: lives.iter().flat_map(|life| life.series.clone()).collect(), sample_rate_hz };
    Ok((material, presets.iter().map(|preset| preset.jobs(&bearings, count)).collect()))
}
