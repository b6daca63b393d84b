//! Course of a change over its duration.

use std::f64::consts::{LN_2, PI};

/// Course of a change from none of it to all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Course {
    /// In a straight line.
    #[default]
    Straight,
    /// Along half a cosine.
    Smooth,
    /// As a lag of first order follows a step.
    FirstOrder,
    /// As a critically damped lag of second order does.
    SecondOrder,
}

impl Course {
    /// All courses.
    pub const ALL: [Self; 4] = [Self::Straight, Self::Smooth, Self::FirstOrder, Self::SecondOrder];
    /// Names, as in a rig.
    pub const NAMES: [&str; 4] = ["straight", "smooth", "first-order", "second-order"];

    /// Name.
    pub const fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Course of a name.
    pub fn parse(name: &str) -> Option<Self> {
        Self::NAMES.iter().position(|known| *known == name).map(|index| Self::ALL[index])
    }

    /// Time from the beginning to half the change, over the duration or time constant.
    pub fn half(self) -> f64 {
        match self {
            Self::Straight | Self::Smooth => 0.5,
            Self::FirstOrder => LN_2,
            // Where 1 − (1 + t) e⁻ᵗ is one half.
            Self::SecondOrder => 1.678_346_990_016_661,
        }
    }

    /// Share of the change at a time after its half, over the duration or time constant.
    pub fn share(self, time: f64) -> f64 {
        let since = (time + self.half()).max(0.0);
        match self {
            Self::Straight => since.min(1.0),
            Self::Smooth => 0.5 - 0.5 * (PI * since.min(1.0)).cos(),
            Self::FirstOrder => -(-since).exp_m1(),
            Self::SecondOrder => 1.0 - (1.0 + since) * (-since).exp(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_course_has_a_name_begins_at_nothing_is_half_at_its_time_and_ends_at_all() {
        for (course, name) in Course::ALL.into_iter().zip(Course::NAMES) {
            assert_eq!(Course::parse(name), Some(course));
            let of = |time: f64| course.share(time);
            assert!(of(-course.half()) == 0.0 && of(-9.0) == 0.0 && (of(0.0) - 0.5).abs() < 1e-12, "{name}");
            assert!((of(40.0) - 1.0).abs() < 1e-12 && of(0.1) > of(-0.1), "{name}");
        }
        assert_eq!(Course::parse("sudden"), None);
    }
}
