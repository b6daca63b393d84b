//! Rotation of shaft and cage, with wander and drift in closed form.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Instant of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time from the first sample, s; negative while settling.
    pub time_s: f64,
    /// Shaft angle, rad.
    pub shaft_rad: f64,
    /// Shaft speed, rad/s.
    pub shaft_rad_per_s: f64,
    /// Angle of the cage, rad.
    pub cage_rad: f64,
    /// Speed of the cage, rad/s.
    pub cage_rad_per_s: f64,
}

impl Moment {
    /// Instant at a share of the step to another, angles as cubic polynomials that match both speeds.
    pub fn between(&self, next: &Self, share: f64) -> Self {
        let step = next.time_s - self.time_s;
        let (s, s2, s3) = (share, share * share, share.powi(3));
        let angle = |a: f64, va: f64, b: f64, vb: f64| {
            (2.0 * s3 - 3.0 * s2 + 1.0) * a
                + (s3 - 2.0 * s2 + s) * step * va
                + (3.0 * s2 - 2.0 * s3) * b
                + (s3 - s2) * step * vb
        };
        let line = |a: f64, b: f64| a + share * (b - a);
        Self {
            time_s: line(self.time_s, next.time_s),
            shaft_rad: angle(self.shaft_rad, self.shaft_rad_per_s, next.shaft_rad, next.shaft_rad_per_s),
            shaft_rad_per_s: line(self.shaft_rad_per_s, next.shaft_rad_per_s),
            cage_rad: angle(self.cage_rad, self.cage_rad_per_s, next.cage_rad, next.cage_rad_per_s),
            cage_rad_per_s: line(self.cage_rad_per_s, next.cage_rad_per_s),
        }
    }
}

/// Smooth random wander of a speed, as a share of it: a sum of slow tones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wander(Vec<[f64; 3]>);

impl Wander {
    /// Draws a wander of a root mean square, with tones in a range of frequencies, Hz.
    pub fn draw(rms: f64, [low_hz, high_hz]: [f64; 2], tones: usize, rng: &mut ChaCha8Rng) -> Self {
        let mut drawn: Vec<[f64; 3]> = (0..tones)
            .map(|_| {
                let hz = low_hz * (high_hz / low_hz).powf(rng.random::<f64>());
                // Slow wander is the greater.
                [rng.random_range(0.3..1.0) * (low_hz / hz).sqrt(), TAU * hz, rng.random_range(0.0..TAU)]
            })
            .collect();
        let size = (0.5 * drawn.iter().map(|[a, ..]| a * a).sum::<f64>()).sqrt();
        drawn.iter_mut().for_each(|tone| tone[0] *= rms / size.max(f64::MIN_POSITIVE));
        Self(drawn)
    }

    fn value(&self, time_s: f64) -> f64 {
        self.0.iter().map(|[a, w, phase]| a * (w * time_s + phase).cos()).sum()
    }

    /// Integral from time 0, s.
    fn integral(&self, time_s: f64) -> f64 {
        self.0.iter().map(|[a, w, phase]| a / w * ((w * time_s + phase).sin() - phase.sin())).sum()
    }
}

/// Change of the shaft's speed during a recording, as a share of it; none before the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drift {
    /// Even change of a rate, 1/s.
    Even {
        /// Rate, 1/s.
        rate_per_s: f64,
    },
    /// Change by a size between two times, along half a cosine.
    Smooth {
        /// Size at the end.
        size: f64,
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
    },
    /// Approach to a size, exponential.
    Approach {
        /// Size at infinite time.
        size: f64,
        /// Time constant, s.
        time_s: f64,
    },
}

impl Drift {
    /// Change and its integral from time 0.
    fn at(&self, time_s: f64) -> [f64; 2] {
        if time_s <= 0.0 {
            return [0.0; 2];
        }
        match *self {
            Self::Even { rate_per_s } => [rate_per_s * time_s, 0.5 * rate_per_s * time_s * time_s],
            Self::Smooth { size, from_s, to_s } => {
                let length = to_s - from_s;
                let x = ((time_s - from_s) / length).clamp(0.0, 1.0);
                let after = (time_s - to_s).max(0.0);
                let within = 0.5 * size * length * (x - (PI * x).sin() / PI);
                [0.5 * size * (1.0 - (PI * x).cos()), within + size * after]
            }
            Self::Approach { size, time_s: tau } => {
                let decay = 1.0 - (-time_s / tau).exp();
                [size * decay, size * (time_s - tau * decay)]
            }
        }
    }
}

/// Rotation of shaft and cage over a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace {
    /// Mean speed of the shaft, Hz.
    pub shaft_hz: f64,
    /// Shaft angle at time 0, rad.
    pub shaft_angle_rad: f64,
    /// Angle of the first ball at time 0, rad.
    pub cage_angle_rad: f64,
    /// Speed of the cage over that of the shaft, without slip.
    pub cage_ratio: f64,
    /// Slip of the cage.
    pub slip: f64,
    /// Wander of the shaft.
    pub shaft_wander: Wander,
    /// Wander of the cage against the shaft.
    pub cage_wander: Wander,
    /// Drift of the shaft.
    pub drift: Option<Drift>,
}

impl Pace {
    /// Rotation at a time, s.
    pub fn at(&self, time_s: f64) -> Moment {
        let omega = TAU * self.shaft_hz;
        let [drift, drifted] = self.drift.map_or([0.0; 2], |d| d.at(time_s));
        let turned = omega * (time_s + self.shaft_wander.integral(time_s) + drifted);
        let speed = omega * (1.0 + self.shaft_wander.value(time_s) + drift);
        // The wander of the cage acts on the mean speed: the product with the shaft's own wander is of second order.
        let ratio = self.cage_ratio * (1.0 - self.slip);
        Moment {
            time_s,
            shaft_rad: self.shaft_angle_rad + turned,
            shaft_rad_per_s: speed,
            cage_rad: self.cage_angle_rad + ratio * (turned + omega * self.cage_wander.integral(time_s)),
            cage_rad_per_s: ratio * (speed + omega * self.cage_wander.value(time_s)),
        }
    }
}
