//! Phases of every channel of a machine, raw and denoised.

use rayon::prelude::*;
use serde::Serialize;

use super::life::{Features, Timeline};
use super::{Phases, Rules, phases};
use crate::recording::Recording;
use crate::signal::wavelet::denoise::Denoising;

/// Signal of which features are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// As recorded.
    Raw,
    /// Denoised by a stationary wavelet transform.
    Wavelet,
}

/// Life of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelLife {
    /// Name of the channel.
    pub channel: String,
    /// Signal of which the features are taken.
    pub filter: Filter,
    /// Features of each recording.
    pub features: Vec<Features>,
}

/// Lives of all channels of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Lives {
    /// Order of the recordings.
    pub timeline: Timeline,
    /// Lives, each channel first raw and then denoised.
    pub channels: Vec<ChannelLife>,
}

impl Lives {
    /// Lives of the channels that all recordings have, except `tacho`.
    pub fn new(recordings: &[Recording], denoising: &Denoising) -> Self {
        let names = recordings.first().map_or(&[][..], |first| &first.channels).iter().map(|c| c.name.as_str());
        let in_all = |name: &&str| *name != "tacho" && recordings.iter().all(|r| r.channel(name).is_some());
        let of = |name: &str, filter: Filter| {
            let features = recordings.par_iter().filter_map(|recording| {
                let samples = &recording.channel(name)?.samples;
                Some(match filter {
                    Filter::Raw => Features::new(samples),
                    Filter::Wavelet => Features::new(&denoising.apply(samples)),
                })
            });
            ChannelLife { channel: name.into(), filter, features: features.collect() }
        };
        let channels = names.filter(in_all).flat_map(|name| [of(name, Filter::Raw), of(name, Filter::Wavelet)]);
        Self { channels: channels.collect(), timeline: Timeline::new(recordings) }
    }

    /// Phases of each life; `None` for recordings that are too few.
    pub fn phases(&self, rules: &Rules) -> Vec<Option<Phases>> {
        self.channels.iter().map(|life| phases(&life.features, &self.timeline.follows, rules)).collect()
    }
}
