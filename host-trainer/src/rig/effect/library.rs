//! Terms of the device's library that come nearest to an effect.
//!
//! The device computes monomials, sines and cosines of the virtual states, no other functions. An effect that is a
//! function of the state adds the lowest monomials of its shape, an additional mode adds the states that the mode needs,
//! and a force that depends on angle or time adds nothing.

/// Terms that an effect adds to a library, and why those.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LibraryTerms {
    /// Terms.
    pub adds: Adds,
    /// Reason, as a clause.
    pub why: &'static str,
}

/// Kind of terms that an effect adds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Adds {
    /// Monomials up to this degree: n_D becomes at least that.
    Degree(usize),
    /// Powers of two thirds, theory (112).
    Powers,
    /// States of a further mode: two orders of difference.
    Mode,
    /// Nothing.
    Nothing,
}

use Adds::{Degree, Mode, Nothing, Powers};

const fn terms(adds: Adds, why: &'static str) -> LibraryTerms {
    LibraryTerms { adds, why }
}

impl LibraryTerms {
    /// Terms of a force that depends on an angle.
    pub const ANGLE: Self = terms(Nothing, "its force goes by an angle, which is no function of the states");
    /// Terms of a force from outside.
    pub const OUTSIDE: Self = terms(Nothing, "it pushes from outside, which is no function of the states");
    /// Terms of a change of speed.
    pub const PACE: Self = terms(Nothing, "it changes how fast angles pass, which is no function of the states");
    /// Terms of a fault of the acquisition.
    pub const SENSOR: Self = terms(Nothing, "it is not the machine's, and a model of the machine must not learn it");
    /// Terms of a change of a linear parameter.
    pub const LINEAR: Self = terms(Degree(1), "it is linear in the states");
    /// Terms of a constant force.
    pub const CONSTANT: Self = terms(Degree(1), "it is a constant, which comes with the polynomial part");
    /// Terms of a quadratic spring.
    pub const QUADRATIC: Self = terms(Degree(2), "its force is quadratic");
    /// Terms of a force that acts on one side.
    pub const EVEN: Self =
        terms(Degree(2), "it acts on one side only, and squares are the lowest powers that tell the sides apart");
    /// Terms of a film of lubricant.
    pub const FILM: Self =
        terms(Powers, "its thickness goes with the speed to the power of two thirds, which no monomial does");
    /// Terms of a cubic spring.
    pub const CUBIC: Self = terms(Degree(3), "its force is cubic");
    /// Terms of an odd law.
    pub const ODD: Self = terms(Degree(3), "it is odd, and cubes are the lowest odd powers that bend");
    /// Terms of an additional mode.
    pub const MODE: Self = terms(Mode, "a mode takes two orders of difference more");
}
