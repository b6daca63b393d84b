//! Library Θ(z) of candidate functions, theory (7): the terms and their order for host and device.
//!
//! Order: the polynomial part by degree (constant, z_i, z_i z_j, …), within a degree in lexicographic
//! order of the sorted factors; then for each harmonic k = 1…n_F all sin(k z_i), then all cos(k z_i).
//! After them, if the library has powers, all |z_i|^⅔, then all sgn(z_i)|z_i|^⅔, rounded at 0: theory (112).
//! Counts are those of the paper, theory (8): C(n + n_D, n_D) and 2 n_F n; n_D = 0 means no polynomial part.
//! A monomial is always multiplied from left to right over its sorted factors.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::math;
use crate::states::MAX_DIMENSION;

/// Greatest polynomial degree n_D.
pub const MAX_DEGREE: usize = 11;

/// Sizes of a library: polynomial, Fourier, or both (the paper's "custom").
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Library {
    /// Number of variables z_i, 1 to [`MAX_DIMENSION`].
    pub variables: u8,
    /// Polynomial degree n_D, up to [`MAX_DEGREE`]; 0 for no polynomial part.
    pub degree: u8,
    /// Number of harmonics n_F; 0 for no Fourier part.
    pub harmonics: u16,
    /// Whether there are the powers ⅔ of each variable, even and odd: terms of a film of lubricant.
    #[serde(default, skip_serializing_if = "is_not")]
    pub powers: bool,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
const fn is_not(flag: &bool) -> bool {
    !*flag
}

/// Rounding radius ε of a power at 0, theory (112), in scaled units.
pub const POWER_RADIUS: f32 = 0.1;

/// One candidate function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// Product of variables.
    Monomial(Monomial),
    /// Sine sin(k z_i).
    Sin {
        /// Index i of the variable.
        variable: u8,
        /// Harmonic k.
        harmonic: u16,
    },
    /// Cosine cos(k z_i).
    Cos {
        /// Index i of the variable.
        variable: u8,
        /// Harmonic k.
        harmonic: u16,
    },
    /// Even power |z_i|^⅔, rounded at 0: (z_i² + ε²)^⅓.
    Power {
        /// Index i of the variable.
        variable: u8,
    },
    /// Odd power sgn(z_i)|z_i|^⅔, rounded at 0: z_i (z_i² + ε²)^−⅙.
    OddPower {
        /// Index i of the variable.
        variable: u8,
    },
}

/// A product of up to [`MAX_DEGREE`] variables, sorted factors; no factors is the constant 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Monomial {
    factors: [u8; MAX_DEGREE],
    degree: u8,
}

impl Monomial {
    /// Monomial of sorted variable indices; `None` if there are too many or they are not sorted.
    pub fn new(factors: &[u8]) -> Option<Self> {
        let mut out = Self { factors: [0; MAX_DEGREE], degree: u8::try_from(factors.len()).ok()? };
        out.factors.get_mut(..factors.len())?.copy_from_slice(factors);
        factors.is_sorted().then_some(out)
    }

    /// Indices of the factors, sorted.
    pub fn factors(&self) -> &[u8] {
        self.factors.get(..usize::from(self.degree)).unwrap_or(&[])
    }

    /// Value at `z`; NaN for a factor that `z` does not have.
    pub fn eval(&self, z: &[f32]) -> f32 {
        let mut factors = self.factors().iter().map(|&i| z.get(usize::from(i)).copied().unwrap_or(f32::NAN));
        let first = factors.next().unwrap_or(1.0);
        factors.fold(first, |product, z| product * z)
    }

    /// Advances to the next monomial of equal degree in `n` variables; returns the first factor that differs, so that
    /// running products can be kept, or `None` after the last.
    fn advance(&mut self, n: u8) -> Option<usize> {
        let degree = usize::from(self.degree);
        let changed = self.factors().iter().rposition(|&f| f + 1 < n)?;
        let next = self.factors.get(changed)? + 1;
        self.factors.get_mut(changed..degree)?.fill(next);
        Some(changed)
    }
}

/// Binomial coefficient C(n, k), saturating.
pub const fn binomial(n: usize, k: usize) -> usize {
    let mut value: usize = 1;
    let mut i = 0;
    while i < k {
        value = value.saturating_mul(n - i) / (i + 1);
        i += 1;
    }
    value
}

/// Number of monomials of exactly `degree` in `n` variables: C(n + degree − 1, degree).
const fn monomials(n: usize, degree: usize) -> usize {
    if degree == 0 {
        1
    } else if n == 0 {
        0
    } else {
        binomial(n + degree - 1, degree)
    }
}

impl Library {
    /// Library of these sizes; `None` if a size is out of range or there is no term.
    pub fn new(variables: usize, degree: usize, harmonics: usize) -> Option<Self> {
        let library = Self {
            variables: u8::try_from(variables).ok()?,
            degree: u8::try_from(degree).ok()?,
            harmonics: u16::try_from(harmonics).ok()?,
            powers: false,
        };
        library.is_valid().then_some(library)
    }

    /// The library with or without powers.
    #[must_use]
    pub const fn with_powers(self, powers: bool) -> Self {
        Self { powers, ..self }
    }

    /// Whether all sizes are in range and there is at least one term.
    pub fn is_valid(&self) -> bool {
        (1..=MAX_DIMENSION).contains(&self.n())
            && usize::from(self.degree) <= MAX_DEGREE
            && (self.degree > 0 || self.harmonics > 0)
    }

    fn n(&self) -> usize {
        usize::from(self.variables)
    }

    /// Number of terms in the polynomial part.
    pub fn polynomial_len(&self) -> usize {
        match usize::from(self.degree) {
            0 => 0,
            degree => binomial(self.n() + degree, degree),
        }
    }

    /// Number of terms before the powers.
    fn powers_from(&self) -> usize {
        self.polynomial_len() + 2 * usize::from(self.harmonics) * self.n()
    }

    /// Number of terms, theory (8): C(n + n_D, n_D) + 2 n_F n, and 2 n powers.
    #[allow(clippy::len_without_is_empty)] // a valid library is never empty
    pub fn len(&self) -> usize {
        self.powers_from() + if self.powers { 2 * self.n() } else { 0 }
    }

    /// Term of an index in the module's order.
    pub fn term(&self, index: usize) -> Option<Term> {
        let polynomial = self.polynomial_len();
        if index < polynomial {
            return self.monomial(index).map(Term::Monomial);
        }
        if let Some(power) = index.checked_sub(self.powers_from()) {
            let variable = u8::try_from(power % self.n()).ok()?;
            let term = if power < self.n() { Term::Power { variable } } else { Term::OddPower { variable } };
            return (index < self.len()).then_some(term);
        }
        let index = index - polynomial;
        let harmonic = u16::try_from(index / (2 * self.n()) + 1).ok()?;
        let within = index % (2 * self.n());
        let variable = u8::try_from(within % self.n()).ok()?;
        (harmonic <= self.harmonics).then_some(if within < self.n() {
            Term::Sin { variable, harmonic }
        } else {
            Term::Cos { variable, harmonic }
        })
    }

    fn monomial(&self, mut index: usize) -> Option<Monomial> {
        let n = self.n();
        let mut degree = 0;
        while index >= monomials(n, degree) {
            index -= monomials(n, degree);
            degree += 1;
        }
        let mut m = Monomial { factors: [0; MAX_DEGREE], degree: u8::try_from(degree).ok()? };
        let mut smallest = 0;
        for (position, factor) in m.factors.get_mut(..degree)?.iter_mut().enumerate() {
            let left = degree - position - 1;
            while index >= monomials(n - smallest, left) {
                index -= monomials(n - smallest, left);
                smallest += 1;
            }
            *factor = u8::try_from(smallest).ok()?;
        }
        Some(m)
    }

    /// Index of a term; `None` if it is not one of this library's.
    pub fn index_of(&self, term: Term) -> Option<usize> {
        let n = self.n();
        let fourier = |variable: u8, harmonic: u16, offset: usize| {
            let inside = variable < self.variables && (1..=self.harmonics).contains(&harmonic);
            let before = usize::from(harmonic).checked_sub(1)? * 2 * n;
            inside.then_some(self.polynomial_len() + before + offset + usize::from(variable))
        };
        let power = |variable: u8, offset: usize| {
            let inside = self.powers && variable < self.variables;
            inside.then_some(self.powers_from() + offset + usize::from(variable))
        };
        match term {
            Term::Sin { variable, harmonic } => fourier(variable, harmonic, 0),
            Term::Cos { variable, harmonic } => fourier(variable, harmonic, n),
            Term::Power { variable } => power(variable, 0),
            Term::OddPower { variable } => power(variable, n),
            Term::Monomial(m) => {
                let degree = m.factors().len();
                if self.degree == 0 || degree > usize::from(self.degree) {
                    return None;
                }
                let mut index: usize = (0..degree).map(|d| monomials(n, d)).sum();
                let mut smallest = 0;
                for (position, &factor) in m.factors().iter().enumerate() {
                    let factor = usize::from(factor);
                    if factor >= n {
                        return None;
                    }
                    let left = degree - position - 1;
                    index += (smallest..factor).map(|v| monomials(n - v, left)).sum::<usize>();
                    smallest = factor;
                }
                Some(index)
            }
        }
    }

    /// Visits all terms in order, with their values at `z` (which has [`Library::variables`] entries).
    pub fn for_each(&self, z: &[f32], mut visit: impl FnMut(usize, Term, f32)) {
        let mut index = 0;
        if self.degree > 0 {
            for degree in 0..=self.degree {
                let mut m = Monomial { factors: [0; MAX_DEGREE], degree };
                // products[p] is the product of the factors before p.
                let mut products = [1.0f32; MAX_DEGREE + 1];
                let mut from = 0;
                loop {
                    let mut product = products.get(from).copied().unwrap_or(f32::NAN);
                    for (p, &factor) in m.factors().iter().enumerate().skip(from) {
                        let z = z.get(usize::from(factor)).copied().unwrap_or(f32::NAN);
                        product = if p == 0 { z } else { product * z };
                        if let Some(slot) = products.get_mut(p + 1) {
                            *slot = product;
                        }
                    }
                    visit(index, Term::Monomial(m), product);
                    index += 1;
                    match m.advance(self.variables) {
                        Some(changed) => from = changed,
                        None => break,
                    }
                }
            }
        }
        for harmonic in 1..=self.harmonics {
            let sines = (0..self.variables).map(|variable| Term::Sin { variable, harmonic });
            let cosines = (0..self.variables).map(|variable| Term::Cos { variable, harmonic });
            for term in sines.chain(cosines) {
                visit(index, term, term.eval(z));
                index += 1;
            }
        }
        if self.powers {
            let even = (0..self.variables).map(|variable| Term::Power { variable });
            for term in even.chain((0..self.variables).map(|variable| Term::OddPower { variable })) {
                visit(index, term, term.eval(z));
                index += 1;
            }
        }
    }

    /// Computes the row Θ(z), theory (7); `out` takes [`Library::len`] values.
    pub fn row(&self, z: &[f32], out: &mut [f32]) {
        self.for_each(z, |index, _, value| {
            if let Some(out) = out.get_mut(index) {
                *out = value;
            }
        });
    }
}

impl Term {
    /// Value at `z`; NaN for a variable that `z` does not have.
    pub fn eval(&self, z: &[f32]) -> f32 {
        let z_of = |variable: u8| z.get(usize::from(variable)).copied().unwrap_or(f32::NAN);
        let angle = |variable: u8, harmonic: u16| f32::from(harmonic) * z_of(variable);
        let even = |z: f32| math::cbrt(z * z + POWER_RADIUS * POWER_RADIUS);
        match *self {
            Term::Monomial(m) => m.eval(z),
            Term::Sin { variable, harmonic } => math::sin(angle(variable, harmonic)),
            Term::Cos { variable, harmonic } => math::cos(angle(variable, harmonic)),
            Term::Power { variable } => even(z_of(variable)),
            Term::OddPower { variable } => z_of(variable) / math::sqrt(even(z_of(variable))),
        }
    }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Term::Monomial(m) if m.factors().is_empty() => f.write_str("1"),
            Term::Monomial(m) => {
                for (n, run) in m.factors().chunk_by(|a, b| a == b).enumerate() {
                    if n > 0 {
                        f.write_str("·")?;
                    }
                    write!(f, "z{}", run.first().unwrap_or(&0))?;
                    if run.len() > 1 {
                        write!(f, "^{}", run.len())?;
                    }
                }
                Ok(())
            }
            Term::Sin { variable, harmonic } => trigonometric(f, "sin", *variable, *harmonic),
            Term::Cos { variable, harmonic } => trigonometric(f, "cos", *variable, *harmonic),
            Term::Power { variable } => write!(f, "|z{variable}|^⅔"),
            Term::OddPower { variable } => write!(f, "sgn(z{variable})|z{variable}|^⅔"),
        }
    }
}

fn trigonometric(f: &mut fmt::Formatter<'_>, name: &str, variable: u8, harmonic: u16) -> fmt::Result {
    match harmonic {
        1 => write!(f, "{name}(z{variable})"),
        k => write!(f, "{name}({k} z{variable})"),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;
    use std::vec::Vec;

    #[test]
    fn literature_counts_of_table_3() {
        for (n_d, n_md, n_f, functions) in [
            (1, 8, 1, 25),
            (2, 7, 4, 92),
            (2, 8, 2, 77),
            (3, 5, 6, 116),
            (5, 4, 0, 126),
            (9, 4, 0, 715),
            (0, 4, 316, 2528),
        ] {
            assert_eq!(Library::new(n_md, n_d, n_f).unwrap().len(), functions);
        }
    }

    #[test]
    fn row_term_and_order_agree() {
        let z = [0.7f32, -1.3, 0.2, 2.1];
        for (n, degree, harmonics) in [(4, 5, 3), (1, 11, 0), (3, 0, 7), (2, 11, 400), (4, 11, 0)] {
            let library = Library::new(n, degree, harmonics).unwrap().with_powers(n != 3);
            let mut count = 0;
            let mut last: Option<Monomial> = None;
            library.for_each(&z[..n], |index, term, value| {
                assert_eq!(index, count);
                count += 1;
                assert_eq!(library.term(index), Some(term));
                assert_eq!(library.index_of(term), Some(index));
                assert_eq!(term.eval(&z[..n]).to_bits(), value.to_bits());
                if let Term::Monomial(m) = term {
                    assert!(Monomial::new(m.factors()).is_some());
                    if let Some(last) = last {
                        assert!((last.factors().len(), last.factors()) < (m.factors().len(), m.factors()));
                    }
                    last = Some(m);
                }
            });
            assert_eq!(count, library.len());
            assert_eq!(library.term(count), None);
        }
    }

    #[test]
    fn terms_print_as_the_field_writes_them() {
        let library = Library::new(4, 3, 2).unwrap();
        let names: Vec<_> = (0..library.len()).map(|i| library.term(i).unwrap().to_string()).collect();
        assert_eq!(names[0], "1");
        assert_eq!(names[1..5], ["z0", "z1", "z2", "z3"]);
        assert!(names.contains(&"z0^2·z3".to_string()));
        assert!(names.contains(&"z0·z1·z3".to_string()));
        assert_eq!(names[35], "sin(z0)");
        assert_eq!(names[35 + 4], "cos(z0)");
        assert!(names.contains(&"sin(2 z1)".to_string()));
    }

    #[test]
    fn golden_row_by_hand() {
        let library = Library::new(2, 2, 1).unwrap();
        let mut row = [0.0; 10];
        library.row(&[2.0, 3.0], &mut row);
        assert_eq!(row[..6], [1.0, 2.0, 3.0, 4.0, 6.0, 9.0]);
        assert_eq!(row[6..], [math::sin(2.0), math::sin(3.0), math::cos(2.0), math::cos(3.0)]);
    }

    #[test]
    fn literature_powers_are_those_of_the_film_s_thickness_away_from_0() {
        for z in [-30.0f32, -2.0, 1.0, 7.0] {
            let [even, odd] = [Term::Power { variable: 0 }, Term::OddPower { variable: 0 }].map(|t| t.eval(&[z]));
            let power = f64::from(z).abs().powf(2.0 / 3.0) as f32;
            assert!((even / power - 1.0).abs() < 4e-3 && (odd / power - z.signum()).abs() < 2e-3, "{z} {even} {odd}");
        }
        assert_eq!(Term::OddPower { variable: 0 }.eval(&[0.0]), 0.0);
        assert!(Term::Power { variable: 0 }.eval(&[f32::NAN]).is_nan());
        let library = Library::new(3, 2, 1).unwrap();
        assert_eq!(library.with_powers(true).len(), library.len() + 6);
    }

    #[test]
    fn refuses_impossible_sizes() {
        assert!(Library::new(0, 2, 1).is_none());
        assert!(Library::new(17, 2, 1).is_none());
        assert!(Library::new(4, 12, 1).is_none());
        assert!(Library::new(4, 0, 0).is_none());
    }
}
