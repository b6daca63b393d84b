//! Sentences, tests and caveats of a machine's diagnosis.

use std::ops::Range;

use super::change::Change;
use super::names::{Candidate, CombNow, Evidence};
use super::observation::Observation;
use super::pattern::Pattern;
use super::settings::{ChangeSettings, NameSettings};
use super::{Data, Verdict};
use crate::diagnose::result::{Aspect, Test};
use crate::identify::likelihood::observed::CHANNELS;
use crate::signal::kinematics::Geometry;
use crate::stats::format::by_chance;
use crate::stats::significance::{two_sided, two_sided_of_few};

/// Depth from which a race's comb deserves the verdict `unexplained` where no name stands. By hand: half of what the
/// deepest healthy bearing lacks to a defect.
const DESERVES: f64 = 0.25;
/// Fewest healthy recordings under each condition from which their scatter is known.
const FEW: usize = 6;

/// Whether a comb of a race stands out though no name does.
pub fn stands_out(combs: &[CombNow]) -> bool {
    let race = |c: &CombNow| matches!(c.comb.pattern, Pattern::Outer | Pattern::Inner);
    combs.iter().any(|c| race(c) && c.new_depth() > DESERVES && c.comb.p_value < NameSettings::DEFAULT.decoy_p_value)
}

fn band(of: &Range<f64>) -> String {
    format!("{:.0} to {:.0} Hz", of.start, of.end)
}

/// Evidence of a cause in one sentence.
pub fn evidence(candidate: &Candidate, bands: &[Range<f64>], data: &Data, geometry: &Geometry) -> String {
    match &candidate.evidence {
        Evidence::Comb(now) => {
            let [part, line] = now.comb.pattern.names();
            let (slip, first) = (now.comb.slip.first().copied().unwrap_or_default(), data.fitted.first());
            let order = now.comb.pattern.fundamental(geometry, slip);
            let shaft_hz = first.map_or(0.0, |r| r.shaft_hz);
            let over = now
                .over_healthy_db()
                .map_or_else(String::new, |db| format!(", {db:.0} dB over the healthy machine's"));
            format!(
                "{part}: in {} of {} the power is modulated at {line}, {:.1} Hz at {shaft_hz:.2} Hz of the shaft (order {order:.3}), \
                 and its family to a depth of {:.2}{over}; a comb at a random order is as high {}.",
                band(&bands[now.comb.band]),
                CHANNELS[now.channel],
                order * shaft_hz,
                now.comb.depth,
                by_chance(now.comb.p_value)
            )
        }
        Evidence::Order { channel, order, change_db } => {
            let others: Vec<&str> = data.fitted.iter().map(|r| r.name.as_str()).collect();
            format!(
                "{}: the amplitude at {order} × shaft speed is {change_db:.1} dB over the healthy machine's, its scatter taken \
                 off, in {} recordings ({}).",
                CHANNELS[*channel],
                others.len(),
                others.join(", ")
            )
        }
        Evidence::HalfOrders { channel, change_db } => format!(
            "{}: half orders of the shaft stand out {change_db:.1} dB more than the healthy machine's, their scatter taken off, as \
             where a loose part strikes a stop every other turn.",
            CHANNELS[*channel]
        ),
        Evidence::Mode { channel, moved } => format!(
            "{}: at least {:.1} dB of the power around {:.0} Hz are now around {:.0} Hz: a mode's frequency changed by some {:+.0} %, its \
             stiffness by some {:+.0} % or its mass the other way.",
            CHANNELS[*channel],
            moved.by_db,
            moved.from_hz,
            moved.to_hz,
            100.0 * (moved.to_hz / moved.from_hz - 1.0),
            100.0 * ((moved.to_hz / moved.from_hz).powi(2) - 1.0)
        )
        .replace('-', "−"),
        Evidence::Gain { channel, change_db } => format!(
            "{}: the power at all frequencies and in all recordings is {change_db:.1} dB over the healthy machine's.",
            CHANNELS[*channel]
        ),
    }
}

/// What tells a cause, with units, for a sentence.
pub fn signs(candidate: &Candidate, bands: &[Range<f64>], data: &Data, geometry: &Geometry) -> String {
    let shaft_hz = data.fitted.first().map_or(0.0, |r| r.shaft_hz);
    let over = |db: f64, channel: usize| format!("{db:.0} dB over the healthy machine in {}", CHANNELS[channel]);
    match &candidate.evidence {
        Evidence::Comb(now) => {
            let slip = now.comb.slip.first().copied().unwrap_or_default();
            let place = format!("in {} of {}", band(&bands[now.comb.band]), CHANNELS[now.channel]);
            format!(
                "{} {:.1} Hz{} {place}",
                now.comb.pattern.names()[1],
                now.comb.pattern.fundamental(geometry, slip) * shaft_hz,
                now.over_healthy_db().map_or_else(String::new, |db| format!(", {db:.0} dB over the healthy machine")),
            )
        }
        Evidence::Order { channel, order, change_db } => {
            format!("{:.1} Hz, {}", *order as f64 * shaft_hz, over(*change_db, *channel))
        }
        Evidence::HalfOrders { channel, change_db } => {
            format!("looseness: half orders of the shaft {}", over(*change_db, *channel))
        }
        Evidence::Mode { channel, moved } => {
            let [from, to] = [moved.from_hz, moved.to_hz].map(|hz| format!("{hz:.0} Hz"));
            format!("a mode of {from} is at {to} in {}; its mass may have changed instead", CHANNELS[*channel])
        }
        Evidence::Gain { channel, change_db } => {
            format!("{change_db:.1} dB at all frequencies of {}", CHANNELS[*channel]).replace('-', "−")
        }
    }
}

/// What a cause adds.
pub fn equation(candidate: &Candidate) -> String {
    match &candidate.evidence {
        Evidence::Comb(now) => {
            let first = match now.comb.pattern {
                Pattern::Outer => "f_BPFO",
                Pattern::Inner => "f_BPFI",
                Pattern::Ball => "2 f_BSF",
                Pattern::Cage => "f_FTF",
            };
            format!("a(t) = h(t) * Σ_j A_j δ(t − t_j), t_j at the rate {first}")
        }
        Evidence::Order { order: 1, .. } => "f_x += m e ω² cos ψ, f_y += m e ω² sin ψ".into(),
        Evidence::Order { order, .. } => format!("f_y += F cos({order} ψ + φ)"),
        Evidence::HalfOrders { .. } => "f += k (q − g), q > g".into(),
        Evidence::Mode { moved, .. } => format!("k/m → {:.3} k/m", (moved.to_hz / moved.from_hz).powi(2)),
        Evidence::Gain { change_db, .. } => format!("a → {:.3} a", 10f64.powf(change_db / 20.0)),
    }
}

/// Reason why a name does not stand.
pub fn rejected(candidate: &Candidate, bands: &[Range<f64>]) -> String {
    match &candidate.evidence {
        Evidence::Comb(now) => format!(
            "modulation at {} to a depth of {:.2} in {}{}; random orders reach its level {}",
            now.comb.pattern.names()[1],
            now.comb.depth,
            band(&bands[now.comb.band]),
            now.healthy_depth.map_or_else(String::new, |healthy| format!(" ({healthy:.2} healthy)")),
            by_chance(now.comb.p_value)
        ),
        Evidence::Order { order, change_db, .. } => format!(
            "order {order} changed by {change_db:.1} dB; {:.0} dB would be as probable as not",
            NameSettings::DEFAULT.order_db
        ),
        Evidence::HalfOrders { change_db, .. } => format!(
            "half orders changed by {change_db:.1} dB; {:.0} dB would be as probable as not",
            NameSettings::DEFAULT.half_order[0]
        ),
        Evidence::Mode { moved, .. } => format!(
            "beside each other the power rises and falls by {:.1} dB at most; {:.1} dB would be as probable as not",
            moved.by_db,
            NameSettings::DEFAULT.moved_mode[0]
        ),
        Evidence::Gain { change_db, .. } => format!("an even change by {change_db:.1} dB"),
    }
}

/// Sentence of a change that no name explains.
pub fn unexplained(changes: &[(usize, Change)]) -> String {
    let most = changes.iter().max_by(|a, b| a.1.shape_db.total_cmp(&b.1.shape_db));
    match most {
        Some((channel, change)) if change.shape_db <= ChangeSettings::DEFAULT.shape_db => format!(
            "{}: against the healthy machine the power from {:.0} to {:.0} Hz changed by {:.1} dB more than elsewhere; healthy machines \
             of one make stay below {:.0} dB, and no line that would name the cause stands out.",
            CHANNELS[*channel],
            change.wide_hz[0],
            change.wide_hz[1],
            change.wide_db,
            ChangeSettings::DEFAULT.wide_db
        ),
        Some((channel, change)) => format!(
            "{}: against the healthy machine the power in third-octave bands changed by {:.1} dB (median) and, around that, by \
             {:.1} dB (root mean square); healthy machines of one make stay below {:.0} dB, and no line that would name the \
             cause stands out.",
            CHANNELS[*channel],
            change.gain_db,
            change.shape_db,
            ChangeSettings::DEFAULT.shape_db
        ),
        None => {
            "The power is modulated at rates of more than one part of the bearing, none of which clearly leads.".into()
        }
    }
}

/// Test of a comb among its decoys.
pub fn comb_test(now: &CombNow, bands: &[Range<f64>], geometry: &Geometry) -> Test {
    let (channel, range) = (CHANNELS[now.channel], &bands[now.comb.band]);
    let slip = now.comb.slip.first().copied().unwrap_or_default();
    Test {
        aspect: Aspect::Comb,
        channel,
        at: Some([range.start, range.end]),
        what: format!(
            "{channel}, comb of {} (order {:.3}) in the squared envelope of {}, depth {:.2}",
            now.comb.pattern.names()[1],
            now.comb.pattern.fundamental(geometry, slip),
            band(range),
            now.comb.depth
        ),
        z: now.comb.level - now.comb.decoy_level,
        p_value: now.comb.p_value,
        q_value: 1.0,
    }
}

/// Tests of a channel's change against the scatter that healthy machines of one make are granted.
pub fn change_tests(channel: usize, change: &Change) -> Vec<Test> {
    let (name, settings) = (CHANNELS[channel], ChangeSettings::DEFAULT);
    let test = |aspect, at, what, z: f64| Test {
        aspect,
        channel: name,
        at: Some(at),
        what,
        z,
        p_value: two_sided(z),
        q_value: 1.0,
    };
    let orders = (1..=settings.orders).filter_map(|order| {
        let [db, error] = change.order_db(order)?;
        let what = format!("{name}, order {order} against the healthy machine, {db:.1} dB");
        let z = db / error.hypot(0.5 * NameSettings::DEFAULT.order_db);
        let p_value = two_sided_of_few(z, change.orders.len() + 1);
        Some(Test { p_value, ..test(Aspect::Order, [order as f64; 2], what, z) })
    });
    let bands = change.bands.iter().map(|(at, db)| {
        let around = db - change.gain_db;
        let what =
            format!("{name}, power from {:.0} to {:.0} Hz against the healthy machine, {db:.1} dB", at[0], at[1]);
        test(Aspect::Spectrum, *at, what, around / settings.shape_db)
    });
    orders.chain(bands).collect()
}

/// Caveats.
pub fn caveats(verdict: Verdict, baseline: &[Observation], halves: bool) -> Vec<String> {
    let mut out = vec![
        "The structure between bearing and sensor is unknown: names rest on rates and ratios, and no size of a defect or force was \
         estimated. rig.corrected.toml is therefore the rig as it was."
            .to_owned(),
    ];
    if halves {
        out.push(
            "There is one recording: the cause was sought in all of it, its path and depth were fitted to the first half and \
             are judged on the second."
                .into(),
        );
    }
    if baseline.is_empty() {
        out.push(match verdict {
            Verdict::NoMismatch => {
                "Without recordings of the healthy machine only local defects of the bearing can be told; there is no evidence \
                 of one."
                    .into()
            }
            _ => "Without recordings of the healthy machine only local defects of the bearing can be told.".into(),
        });
    } else if baseline.len() < FEW {
        out.push(format!(
            "Recordings of the healthy machine: {}. What healthy machines of one make differ by is therefore assumed, {:.0} dB in \
             third-octave bands.",
            baseline.len(),
            ChangeSettings::DEFAULT.shape_db
        ));
    }
    out
}
