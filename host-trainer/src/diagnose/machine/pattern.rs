//! Lines that a local defect of each part of a bearing leaves in the spectrum of the squared envelope.

use crate::rig::effect::EffectKind;
use crate::signal::kinematics::Geometry;

/// Pattern of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Ball passes of the outer race.
    Outer,
    /// Ball passes of the inner race with sidebands of the shaft.
    Inner,
    /// Strikes of a ball with sidebands of the cage.
    Ball,
    /// Multiples of the cage's speed: one ball differs from the others.
    Cage,
}

impl Pattern {
    /// All patterns.
    pub const ALL: [Self; 4] = [Self::Outer, Self::Inner, Self::Ball, Self::Cage];

    /// Defect that leaves the pattern.
    pub fn defect(self) -> EffectKind {
        match self {
            Self::Outer => EffectKind::OuterRaceDefect,
            Self::Inner => EffectKind::InnerRaceDefect,
            Self::Ball | Self::Cage => EffectKind::BallDefect,
        }
    }

    /// Names of the part and of its first line.
    pub fn names(self) -> [&'static str; 2] {
        match self {
            Self::Outer => ["outer race", "BPFO"],
            Self::Inner => ["inner race", "BPFI"],
            Self::Ball => ["ball", "2×BSF"],
            Self::Cage => ["one ball, seen once a turn of the cage", "FTF"],
        }
    }

    /// Order of the first line at a slip of the cage, theory (27).
    pub fn fundamental(self, geometry: &Geometry, slip: f64) -> f64 {
        let orders = geometry.orders();
        match self {
            Self::Outer => orders.bpfo * (1.0 - slip),
            Self::Inner => geometry.balls as f64 - orders.bpfo * (1.0 - slip),
            Self::Ball => orders.ball_strikes() * (1.0 - slip),
            Self::Cage => orders.ftf * (1.0 - slip),
        }
    }

    /// Orders of all lines; `decoy` stands in for the first line at pure rolling.
    pub fn lines(self, geometry: &Geometry, slip: f64, decoy: Option<f64>) -> Vec<f64> {
        let cage = geometry.orders().ftf * (1.0 - slip);
        let first = match (decoy, self) {
            (None, _) => self.fundamental(geometry, slip),
            (Some(order), Self::Inner) => order * (1.0 + slip),
            (Some(order), _) => order * (1.0 - slip),
        };
        match self {
            Self::Outer => (1..=4).map(|h| f64::from(h) * first).collect(),
            Self::Inner => (1..=3).flat_map(|h| [0.0, -1.0, 1.0].map(|side| f64::from(h) * first + side)).collect(),
            Self::Ball => {
                let with_sides = (1..=2).flat_map(|h| [0.0, -1.0, 1.0].map(|side| f64::from(h) * first + side * cage));
                with_sides.chain([0.5 * first, 1.5 * first]).collect()
            }
            Self::Cage => [1.0, 2.0, 3.0, 4.0, 6.0].map(|h| h * first).to_vec(),
        }
    }

    /// Lines of other families that may coincide.
    pub fn rivals(self, geometry: &Geometry, slip: f64) -> Vec<f64> {
        let outer = Self::Outer.fundamental(geometry, slip);
        let inner = Self::Inner.fundamental(geometry, slip);
        let outer_lines = |sides: i32| {
            (1..=5).flat_map(move |h| (-sides..=sides).map(move |side| f64::from(h) * outer + f64::from(side)))
        };
        let inner_lines = (1..=3).flat_map(|h| (-2..=2).map(move |side| f64::from(h) * inner + f64::from(side)));
        match self {
            Self::Outer => inner_lines.collect(),
            Self::Inner => outer_lines(0).collect(),
            Self::Ball | Self::Cage => outer_lines(1).chain(inner_lines).collect(),
        }
    }

    /// Range of orders in which decoys are drawn.
    pub fn decoys(self, geometry: &Geometry) -> [f64; 2] {
        match self {
            Self::Cage => [0.29, 0.49],
            _ => [2.3, (geometry.balls as f64 - 1.0).max(4.0)],
        }
    }

    /// Orders that a decoy must stay clear of.
    pub fn clear_of(self, geometry: &Geometry) -> Vec<f64> {
        let o = geometry.orders();
        let races = [o.bpfo, o.bpfi].into_iter().flat_map(|order| [0.5 * order, order - 1.0, order, order + 1.0]);
        match self {
            Self::Cage => vec![o.ftf, 1.0 / 3.0, 0.5],
            _ => races.chain([2.0 * o.bpfo, o.bsf, 2.0 * o.bsf, 2.0 * o.bsf - o.ftf, 2.0 * o.bsf + o.ftf]).collect(),
        }
    }
}
