//! Posterior of the names of what has changed.

use super::change::{Change, MovedMode};
use super::comb::Comb;
use super::pattern::Pattern;
use super::settings::{ChangeSettings, NameSettings};
use crate::rig::effect::EffectKind;

const SETTINGS: NameSettings = NameSettings::DEFAULT;

/// A comb of a channel beside the baseline's.
#[derive(Clone, Debug)]
pub struct CombNow {
    /// The comb.
    pub comb: Comb,
    /// Index of the channel.
    pub channel: usize,
    /// Depth of the same pattern in the same band of the baseline.
    pub healthy_depth: Option<f64>,
}

impl CombNow {
    /// Depth beyond what the baseline has.
    pub fn new_depth(&self) -> f64 {
        let healthy = SETTINGS.times_baseline * self.healthy_depth.unwrap_or_default();
        (self.comb.depth.powi(2) - healthy.powi(2)).max(0.0).sqrt()
    }

    /// Depth over the baseline's, dB.
    pub fn over_healthy_db(&self) -> Option<f64> {
        self.healthy_depth.map(|healthy| 20.0 * (self.comb.depth / healthy.max(1e-3)).log10())
    }

    /// Log-odds lost if decoys have such a comb too.
    fn chance(&self) -> f64 {
        // Its many lines meet those of another machine.
        let usual = if self.comb.pattern == Pattern::Ball { SETTINGS.ball_p_value } else { SETTINGS.decoy_p_value };
        SETTINGS.decoy_slope * (usual / self.comb.p_value.max(1e-12)).ln().min(0.0)
    }

    fn is_race(&self) -> bool {
        matches!(self.comb.pattern, Pattern::Outer | Pattern::Inner)
    }

    /// Log-odds of the defect against none, given the other combs of the channel.
    fn log_odds(&self, all: &[Self]) -> f64 {
        let depth = self.new_depth().max(1e-6);
        if self.is_race() {
            // A defect of a ball modulates at the rates of both races, and at the cage's.
            let significant = |c: &&Self| c.comb.p_value < SETTINGS.decoy_p_value.sqrt();
            let others = all.iter().filter(|c| c.comb.pattern != self.comb.pattern && c.comb.pattern != Pattern::Ball);
            let rival = others.filter(significant).map(Self::new_depth).fold(0.0, f64::max);
            let pure = if self.healthy_depth.is_some() { SETTINGS.race_depth_now } else { SETTINGS.race_depth };
            let even = pure + SETTINGS.impure_depth * (rival / depth).min(1.0);
            return SETTINGS.race_slope * (depth / even).ln() + self.chance();
        }
        let (least, slope) = match self.comb.pattern {
            Pattern::Cage => (SETTINGS.cage_depth, SETTINGS.cage_slope),
            _ => (SETTINGS.race_depth + SETTINGS.impure_depth, SETTINGS.race_slope),
        };
        // A race's defect is modulated by the cage as well: balls differ in load.
        let races = all.iter().filter(|c| c.is_race() && c.comb.p_value < SETTINGS.decoy_p_value.sqrt());
        let deepest = races.map(Self::new_depth).fold(0.0, f64::max);
        let rival = (deepest / SETTINGS.rival_depth).max(1.0).ln();
        slope * (depth / least).ln() + self.chance() - SETTINGS.cage_slope * rival
    }
}

/// Evidence for a name.
#[derive(Clone, Debug)]
pub enum Evidence {
    /// A comb of modulation lines.
    Comb(CombNow),
    /// Change of the orders of the shaft in a channel: order, mean dB.
    Order {
        /// Index of the channel.
        channel: usize,
        /// Order of the shaft.
        order: usize,
        /// Change, dB.
        change_db: f64,
    },
    /// Half orders of the shaft in a channel, as of a part that strikes a stop every other turn.
    HalfOrders {
        /// Index of the channel.
        channel: usize,
        /// Change, dB.
        change_db: f64,
    },
    /// A mode that is elsewhere in a channel.
    Mode {
        /// Index of the channel.
        channel: usize,
        /// The mode.
        moved: MovedMode,
    },
    /// The same change everywhere in a channel, dB.
    Gain {
        /// Index of the channel.
        channel: usize,
        /// Change, dB.
        change_db: f64,
    },
}

/// Kinds of evidence that say nothing of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Modulation at the rates of the bearing.
    Bearing,
    /// Lines of the shaft.
    Shaft,
    /// Level or modes of a channel.
    Level,
}

impl Evidence {
    /// Kind of the evidence.
    pub fn class(&self) -> Class {
        match self {
            Self::Comb(_) => Class::Bearing,
            Self::Order { .. } | Self::HalfOrders { .. } => Class::Shaft,
            Self::Gain { .. } | Self::Mode { .. } => Class::Level,
        }
    }
}

/// A name with its evidence.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Name.
    pub kind: EffectKind,
    /// Log-odds against no cause.
    pub log_odds: f64,
    /// Posterior probability among the candidates of its class and none.
    pub probability: f64,
    /// Evidence.
    pub evidence: Evidence,
}

/// Candidates with their posterior, the most probable first; each name once.
pub fn candidates(combs: &[CombNow], changes: &[(usize, Change)]) -> Vec<Candidate> {
    let mut found: Vec<Candidate> = Vec::new();
    let mut offer =
        |kind: EffectKind, log_odds: f64, evidence: Evidence| match found.iter_mut().find(|c| c.kind == kind) {
            Some(known) if known.log_odds >= log_odds => {}
            Some(known) => (known.log_odds, known.evidence) = (log_odds, evidence),
            None => found.push(Candidate { kind, log_odds, probability: 0.0, evidence }),
        };
    for comb in combs {
        let beside: Vec<CombNow> = combs.iter().filter(|c| c.channel == comb.channel).cloned().collect();
        offer(comb.comb.pattern.defect(), comb.log_odds(&beside), Evidence::Comb(comb.clone()));
    }
    // Where all has changed, a rise beside a fall says nothing.
    let local = changes.iter().all(|(_, change)| !is_beyond_healthy(change));
    for (channel, change) in changes {
        if let Some(moved) = change.moved.filter(|_| local) {
            let [even, slope] = SETTINGS.moved_mode;
            let apart = ChangeSettings::DEFAULT.per_speed_db * change.apart;
            let odds = slope * (moved.by_db - even - apart);
            offer(EffectKind::StiffnessChange, odds, Evidence::Mode { channel: *channel, moved });
        }
        // What the scatter over recordings leaves doubtful does not count.
        let order = |order: usize| change.order_db(order).map_or(f64::NEG_INFINITY, |[mean, error]| mean - error);
        let (first, second) = (order(1), order(2));
        let halves = change.half_orders_db().map_or(0.0, |[mean, error]| (mean - error).max(0.0));
        let [half_db, half_slope] = SETTINGS.half_order;
        let evidence = Evidence::HalfOrders { channel: *channel, change_db: halves };
        offer(EffectKind::EndStopContact, half_slope * (halves - half_db), evidence);
        // A loose part raises all orders.
        let loose = if halves > half_db { halves } else { 0.0 };
        let odds = |db: f64| SETTINGS.order_slope * (db - SETTINGS.order_db);
        let evidence = |order: usize, change_db: f64| Evidence::Order { channel: *channel, order, change_db };
        offer(EffectKind::Unbalance, odds(first - loose), evidence(1, first));
        // What raises the second order through the first is not a force of its own.
        offer(EffectKind::Misalignment, odds(second - first.max(0.0) - loose), evidence(2, second));
        let [over_spread, other_gain, other_spread] = ChangeSettings::DEFAULT.one_of_two;
        let is_still = |other: &Change| other.gain_db.abs() < other_gain && other.spread_db < other_spread;
        let one_of_two = change.gain_db.abs() > over_spread * change.spread_db
            && changes.iter().any(|(n, other)| n != channel && is_still(other));
        let even = change.spread_db < ChangeSettings::DEFAULT.even_db;
        if (even || one_of_two) && change.gain_db.abs() > 1.0 {
            let gain = Evidence::Gain { channel: *channel, change_db: change.gain_db };
            offer(EffectKind::SensorGain, change.gain_db.abs() - 1.0, gain);
        }
    }
    let odds = |class: Class| -> f64 {
        found.iter().filter(|c| c.evidence.class() == class).map(|c| c.log_odds.min(50.0).exp()).sum()
    };
    let totals = [Class::Bearing, Class::Shaft, Class::Level].map(odds);
    for candidate in &mut found {
        let total = totals[candidate.evidence.class() as usize];
        candidate.probability = (candidate.log_odds.min(50.0).exp() / (1.0 + total)).min(SETTINGS.most);
    }
    found.sort_by(|a, b| b.log_odds.total_cmp(&a.log_odds));
    found
}

/// Whether the change is beyond what healthy machines of one make have.
pub fn is_beyond_healthy(change: &Change) -> bool {
    let settings = ChangeSettings::DEFAULT;
    let apart = settings.per_speed_db * change.apart;
    change.shape_db > settings.shape_db + apart
        || change.wide_db > settings.wide_db + apart
        || change.gain_db > settings.gain_db + apart
}
