//! Held-out stretches, as measured and as two rigs have them, with the faults that improve them.

use super::faults::Fault;
use super::select::Selection;
use super::settings::SdofSettings;
use super::validate::{Comparison, SimulatedFit, Windows, compare};
use super::verdict::{Case, Stretch};
use crate::identify::force_balance::shooting::{self, Span};
use crate::rig::effect::{EffectKind, ParameterKey};

const SETTINGS: SdofSettings = SdofSettings::DEFAULT;

impl Case<'_> {
    /// Errors of predictions one sample ahead.
    pub fn one_step_ahead(&self, selection: &Selection, faults: Vec<Fault>) -> (Comparison, Vec<Fault>, Vec<Stretch>) {
        let errors = [&selection.nothing, &selection.chosen].map(|model| self.table.step_errors(model));
        let (mut row, mut stretches) = (0, Vec::new());
        for track in &self.acquired.tracks {
            let measured = track.raw.clone();
            let (mut before, mut after) = (measured.clone(), measured.clone());
            let valid = (0..track.len()).filter(|k| !track.bad[*k]);
            for (count, k) in valid.enumerate() {
                // The first samples fix the diffuse start.
                if count >= SETTINGS.min_block {
                    before[k] -= errors[0][row];
                    after[k] -= errors[1][row];
                }
                row += 1;
            }
            if !track.healthy {
                stretches.push(Stretch { origin: track.origin, measured, before, after });
            }
        }
        let column = |of: fn(&Stretch) -> &Vec<f64>| stretches.iter().map(|s| of(s).clone()).collect::<Vec<_>>();
        let comparison = compare(&column(|s| &s.measured), &column(|s| &s.before), &column(|s| &s.after));
        (comparison, faults, stretches)
    }

    /// Errors of the rig and the corrected rig on what neither was fitted to, with the faults that improve them.
    pub fn compare(
        &self,
        before: Option<&SimulatedFit>,
        after: Option<&SimulatedFit>,
        windows: &Windows,
        faults: &[Fault],
    ) -> Option<(Comparison, Vec<Fault>, Vec<Stretch>)> {
        let after = after?.held_out(self.acquired, windows)?;
        let cut = faults.iter().any(|f| !f.lasts());
        let ends: Vec<(usize, usize, usize)> = windows.spans.iter().map(|span| self.end(*span)).collect();
        let measured: Vec<Vec<f64>> =
            windows.spans.iter().map(|s| self.acquired.tracks[s.track].raw[s.first..s.last].to_vec()).collect();
        let before = match before {
            Some(fit) if cut => self.across(fit, windows, &ends)?,
            Some(fit) => fit.held_out(self.acquired, windows)?,
            None => measured.iter().map(|m| vec![m.iter().sum::<f64>() / m.len() as f64; m.len()]).collect(),
        };
        let mut stand: Vec<Fault> = Vec::new();
        let mut corrected = after;
        for fault in faults {
            let with = if fault.lasts() { self.faulty(fault, &corrected, windows) } else { corrected.clone() };
            let gained =
                if fault.lasts() { compare(&measured, &corrected, &with) } else { compare(&measured, &before, &with) };
            // A single event is in one window: what the other windows gain is no replicate of it.
            if gained.after < gained.before && (!fault.lasts() || gained.p_value < SETTINGS.significance) {
                corrected = with;
                stand.push(fault.clone());
            }
        }
        let comparison = compare(&measured, &before, &corrected);
        let stretches = measured.into_iter().zip(before).zip(corrected).zip(&ends);
        let stretches = stretches.map(|(((measured, before), after), (origin, ..))| Stretch {
            origin: *origin,
            measured,
            before,
            after,
        });
        Some((comparison, stand, stretches.collect()))
    }

    /// Recording of a window, and its first and last sample there.
    fn end(&self, span: Span) -> (usize, usize, usize) {
        let track = &self.acquired.tracks[span.track];
        (track.origin, track.offset + span.first, track.offset + span.last)
    }

    /// Simulations that know nothing of a cut: windows on either side of it are one.
    fn across(&self, fit: &SimulatedFit, windows: &Windows, ends: &[(usize, usize, usize)]) -> Option<Vec<Vec<f64>>> {
        let mut spans: Vec<Span> = Vec::new();
        let mut parts: Vec<Vec<usize>> = Vec::new();
        for (n, (origin, first, last)) in ends.iter().enumerate() {
            let joined = n > 0 && windows.spans[n - 1].track != windows.spans[n].track && ends[n - 1].0 == *origin;
            if let (true, Some(span)) = (joined, spans.last_mut()) {
                span.last = *last;
                parts.last_mut()?.push(last - first);
            } else {
                spans.push(Span { track: *origin, first: *first, last: *last });
                parts.push(vec![last - first]);
            }
        }
        let mut original = self.original.clone();
        original.interpolation = self.acquired.interpolation;
        let runs = shooting::follow(&fit.rig, &original.observed(), &spans)?;
        let mut out = Vec::new();
        for (run, lengths) in runs.into_iter().zip(parts) {
            let mut rest = run.as_slice();
            for length in lengths {
                let (head, tail) = rest.split_at(length.min(rest.len()));
                out.push(head.to_vec());
                rest = tail;
            }
        }
        Some(out)
    }

    /// Simulations as the faulty acquisition would have recorded them.
    fn faulty(&self, fault: &Fault, simulated: &[Vec<f64>], windows: &Windows) -> Vec<Vec<f64>> {
        let level = fault.entry.number(ParameterKey::Value).unwrap_or_default().abs();
        let one = |(run, span): (&Vec<f64>, &Span)| -> Vec<f64> {
            let track = &self.acquired.tracks[span.track];
            let line = (span.first..span.last).map(|k| track.raw[k] - track.sensed[k]);
            let pairs = run.iter().zip(line);
            match fault.entry.kind {
                EffectKind::SensorClipping => pairs.map(|(x, _)| x.clamp(-level, level)).collect(),
                _ => pairs.map(|(x, line)| x + line).collect(),
            }
        };
        simulated.iter().zip(&windows.spans).map(one).collect()
    }
}
