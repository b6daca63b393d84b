//! Loss of a ball's deflection over a local defect, theory (44) and (45).
//!
//! A half sine over the defect's width, d(θ) = depth · cos(πθ/width) for |θ| < width/2: J. Liu, Y. Shao, T. C. Lim,
//! "Vibration analysis of ball bearings with a localized defect applying piecewise response function", Mechanism and
//! Machine Theory 56 (2012) 156–169, for defects no longer than the ball sinks into. The patch of contact, some 0.1 mm
//! long, rounds the edges of so shallow a defect: the rectangle of N. Sawalhi, R. B. Randall ("Simulating gear and bearing
//! interactions in the presence of faults, Part I", MSSP 22 (2008) 1924–1951) and the arcs of a ball that rolls over
//! sharp edges (the same, MSSP 25 (2011) 846–870) give several times the acceleration at high frequency. Or a bottom between
//! flanks that are half a cosine each, the Tukey window of F. J. Harris, "On the use of windows for harmonic analysis with the
//! discrete Fourier transform", Proc. IEEE 66 (1978) 51–83: with flanks of half its width a raised cosine, with short ones a trough.

use std::f64::consts::{PI, TAU};

use super::{ParameterKey, Values};
use crate::rig::EffectEntry;
use crate::rig::config::RigKind;
use crate::rig::state::Instant;

/// A local defect: depth in m, half the width in rad, and flank as a share of the width, at most a half; 0 for a half sine.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalDefect {
    depth: f64,
    half_width: f64,
    flank: f64,
}

/// Loss of deflection over the angle from the middle of an effect's local defect, m over rad; `None` if the effect is at fault.
pub fn profile(effect: &EffectEntry) -> Option<impl Fn(f64) -> f64> {
    let defect = LocalDefect::new(&Values::new(effect, RigKind::Bearing5Dof)?);
    Some(move |angle| defect.loss(angle))
}

/// A ball that is over a defect in some part of a step.
#[derive(Clone, Copy, Debug)]
pub struct Passage {
    /// The ball.
    pub ball: usize,
    defect: LocalDefect,
    /// Angles of the ball from the middle of the defect at the start and the end of the step, rad.
    angles: [f64; 2],
}

impl LocalDefect {
    /// Defect by the parameters of an effect.
    pub(super) fn new(v: &Values) -> Self {
        let [depth, width, flank] =
            [ParameterKey::DepthM, ParameterKey::WidthRad, ParameterKey::Flank].map(|key| v.number(key));
        Self { depth, half_width: 0.5 * width, flank: flank.min(0.5) }
    }

    /// Its loss of deflection at an angle θ from its middle, in symbols.
    pub(super) fn equation(&self) -> String {
        let Self { depth, half_width, flank } = *self;
        let width = 2.0 * half_width;
        match flank {
            0.0 => format!("d(θ) = {depth:.4e} m · cos(πθ/{width:.5}) for |θ| < {width:.5}/2"),
            _ => format!(
                "d(θ) = {depth:.4e} m for |θ| < {width:.5}/2, which it reaches by raised cosines over {:.5} at both ends",
                flank * width
            ),
        }
    }

    /// Steepest slope over the depth for each rad that a ball turns past it: where it is so deep that the contact is lost, it
    /// is not moments alone that count.
    pub(super) fn rate(&self) -> f64 {
        let half_sine = 0.5 * PI / self.half_width;
        if self.flank == 0.0 { half_sine } else { 0.5 * half_sine / self.flank }
    }

    /// Loss of deflection at an angle from its middle, m.
    fn loss(&self, angle: f64) -> f64 {
        if angle.abs() >= self.half_width {
            return 0.0;
        }
        let edge = self.half_width - angle.abs();
        let rise = 2.0 * self.half_width * self.flank;
        self.depth
            * match edge {
                _ if rise == 0.0 => (0.5 * PI * angle / self.half_width).cos(),
                _ if edge < rise => 0.5 * (1.0 - (PI * edge / rise).cos()),
                _ => 1.0,
            }
    }

    /// Adds the passage of a ball from one angle to another.
    pub(super) fn pass(&self, ball: usize, angles: [f64; 2], passages: &mut Vec<Passage>) {
        if angles[0].min(angles[1]) < self.half_width && angles[0].max(angles[1]) > -self.half_width {
            passages.push(Passage { ball, defect: *self, angles });
        }
    }

    /// Adds the passages of `balls` on a race whose defect is at an angle that depends on the moment.
    pub(super) fn pass_all(
        &self,
        at: impl Fn(&Instant) -> f64,
        moments: &[Instant; 2],
        balls: usize,
        out: &mut Vec<Passage>,
    ) {
        let pitch = TAU / balls as f64;
        let [from, to] = moments.each_ref().map(|moment| (at(moment) - moment.cage_rad) / pitch);
        let nearest = from.round();
        // Balls to each side that it reaches within the step, where it is wider than their pitch.
        let reach = ((self.half_width / pitch + (to - from).abs() + 0.5).floor()).min(0.5 * (balls - 1) as f64) as i64;
        for offset in -reach..=reach {
            let ball = nearest + offset as f64;
            let number = ball.rem_euclid(balls as f64) as usize % balls;
            self.pass(number, [from, to].map(|place| (place - ball) * pitch), out);
        }
    }
}

impl Passage {
    /// Loss of deflection where the step begins, m.
    pub fn at_start(&self) -> f64 {
        self.defect.loss(self.angles[0])
    }

    /// Loss of deflection at the beginning, the middle and the end of the step, m, of the parabola that has its integral
    /// and its first and second moment over the step: what moves slowly is moved as by the defect itself, however short the
    /// time is in which it is passed.
    pub fn over_step(&self) -> [f64; 3] {
        let ([from, to], reach) = (self.angles, self.defect.half_width);
        let turn = to - from;
        // Shares of the step at which the defect begins and ends.
        let [one, other] = [-reach, reach].map(|edge| if turn == 0.0 { 0.0 } else { (edge - from) / turn });
        let (first, last) = if turn == 0.0 { (0.0, 1.0) } else { (one.min(other).max(0.0), one.max(other).min(1.0)) };
        let half = 0.5 * (last - first).max(0.0);
        let mut of_legendre = [0.0; 3];
        for (node, weight) in GAUSS {
            let share = first + half * (1.0 + node);
            let loss = half * weight * self.defect.loss(from + share * turn);
            let p1 = 2.0 * share - 1.0;
            let p = [1.0, p1, 1.5 * p1 * p1 - 0.5];
            (0..3).for_each(|k| of_legendre[k] += (2 * k + 1) as f64 * loss * p[k]);
        }
        let [c0, c1, c2] = of_legendre;
        [c0 - c1 + c2, c0 - 0.5 * c2, c0 + c1 + c2]
    }
}

/// Nodes and weights of the Gauss–Legendre rule of five points on [−1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_a_flank_of_half_the_width_is_a_raised_cosine_and_a_shorter_one_leaves_a_bottom() {
        let of = |flank: f64| LocalDefect { depth: 2e-6, half_width: 0.02, flank };
        for n in -25i32..=25 {
            let angle = 1e-3 * f64::from(n);
            let raised = if n.abs() < 20 { 1e-6 * (1.0 + (PI * angle / 0.02).cos()) } else { 0.0 };
            assert!((of(0.5).loss(angle) - raised).abs() < 1e-18, "{angle}");
            // Flanks of 0.008 rad.
            assert_eq!(of(0.2).loss(angle) == 2e-6, n.abs() <= 12, "{angle}");
        }
        // Half a cosine is steepest in its middle: ½π over the flank.
        assert!((of(0.2).rate() - 0.5 * PI / 0.008).abs() < 1e-9 && (of(0.5).rate() - of(0.0).rate()).abs() < 1e-9);
        assert!((of(0.2).loss(0.016) - 1e-6).abs() < 1e-18);
    }
}
