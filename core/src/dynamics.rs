//! Sparse dynamics ż = Θ(z) Ξ, theory (10).
//!
//! Ξ is stored term by term: only terms that some equation uses, and of each only its nonzero
//! coefficients. A step costs one evaluation per used term and one multiply-add per nonzero.

use crate::library::{Library, MAX_DEGREE, Monomial, Term};
use crate::states::MAX_DIMENSION;
use crate::{Floats, Word};

/// Words of a term's code.
pub const TERM_WORDS: usize = 3;

const MONOMIAL: u8 = 0;
const SIN: u8 = 1;
const COS: u8 = 2;
const POWER: u8 = 3;
const ODD_POWER: u8 = 4;
/// Padding in a monomial's code after its last factor.
const NO_FACTOR: u8 = 0xff;
/// Places for the variables and, behind them, for ones. The last is the place of no factor, modulo this number.
pub const FACTORS: usize = 2 * MAX_DIMENSION;

/// Code of a term, 12 bytes: kind; for a monomial its factors, for sin and cos variable and harmonic, for a power the variable.
pub fn encode_term(term: Term) -> [Word; TERM_WORDS] {
    let mut code = [NO_FACTOR; 4 * TERM_WORDS];
    match term {
        Term::Monomial(m) => {
            code[0] = MONOMIAL;
            code.iter_mut().skip(1).zip(m.factors()).for_each(|(to, from)| *to = *from);
        }
        Term::Sin { variable, harmonic } | Term::Cos { variable, harmonic } => {
            let [low, high] = harmonic.to_le_bytes();
            let kind = if matches!(term, Term::Sin { .. }) { SIN } else { COS };
            [code[0], code[1], code[2], code[3]] = [kind, variable, low, high];
        }
        Term::Power { variable } => [code[0], code[1]] = [POWER, variable],
        Term::OddPower { variable } => [code[0], code[1]] = [ODD_POWER, variable],
    }
    let [a, b, c, d, e, f, g, h, i, j, k, l] = code;
    [[a, b, c, d], [e, f, g, h], [i, j, k, l]]
}

/// Term of a code; `None` if it is not one of `library`'s.
pub fn decode_term(code: &[Word; TERM_WORDS], library: &Library) -> Option<Term> {
    let [kind, rest @ ..] = code.as_flattened() else { return None };
    let harmonic = u16::from_le_bytes([*rest.get(1)?, *rest.get(2)?]);
    let variable = *rest.first()?;
    let fourier = (1..=library.harmonics).contains(&harmonic) && variable < library.variables;
    let power = library.powers && variable < library.variables;
    match *kind {
        MONOMIAL => {
            let degree = rest.iter().position(|&f| f == NO_FACTOR).unwrap_or(MAX_DEGREE);
            let (factors, padding) = rest.split_at_checked(degree)?;
            let fits = library.degree > 0
                && degree <= usize::from(library.degree)
                && factors.iter().all(|&f| f < library.variables)
                && padding.iter().all(|&f| f == NO_FACTOR);
            Monomial::new(factors).filter(|_| fits).map(Term::Monomial)
        }
        SIN if fourier => Some(Term::Sin { variable, harmonic }),
        COS if fourier => Some(Term::Cos { variable, harmonic }),
        POWER if power => Some(Term::Power { variable }),
        ODD_POWER if power => Some(Term::OddPower { variable }),
        _ => None,
    }
}

/// Coefficients Ξ without zeros, in flash.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dynamics<'a> {
    /// Codes of the used terms.
    pub terms: &'a [[Word; TERM_WORDS]],
    /// End of each used term's run in `equations` and `coefficients` (u32).
    pub ends: &'a [Word],
    /// Index of each coefficient's equation (the output) (u32).
    pub equations: &'a [Word],
    /// Nonzero coefficients, in scaled units.
    pub coefficients: Floats<'a>,
}

impl<'a> Dynamics<'a> {
    /// Computes rate = Θ(z) Ξ, theory (10); `z` are the variables, then ones, and `rate` has one entry for each equation.
    pub fn rate(&self, z: &[f32; FACTORS], rate: &mut [f32]) {
        rate.iter_mut().for_each(|rate| *rate = 0.0);
        let mut entries = self.equations.iter().zip(self.coefficients.0);
        let mut start = 0;
        for (code, end) in self.terms.iter().zip(self.ends) {
            let theta = value(code, z);
            let end = u32::from_le_bytes(*end);
            for (equation, coefficient) in entries.by_ref().take(end.saturating_sub(start) as usize) {
                if let Some(rate) = rate.get_mut(u32::from_le_bytes(*equation) as usize) {
                    *rate += f32::from_le_bytes(*coefficient) * theta;
                }
            }
            start = end;
        }
    }

    /// Nonzero coefficients: term, equation, coefficient.
    pub fn nonzeros(&self, library: Library) -> impl Iterator<Item = (Term, usize, f32)> + use<'a> {
        let Dynamics { terms, ends, equations, coefficients } = *self;
        let mut start = 0;
        terms.iter().zip(ends).flat_map(move |(code, end)| {
            let from = start;
            start = u32::from_le_bytes(*end) as usize;
            let term = decode_term(code, &library);
            (from..start).filter_map(move |k| {
                let equation = u32::from_le_bytes(*equations.get(k)?) as usize;
                Some((term?, equation, coefficients.get(k)?))
            })
        })
    }
}

/// Value of a term from its code, without building the term; `factors` are the variables, then ones.
#[inline(always)]
fn value(code: &[Word; TERM_WORDS], factors: &[f32; FACTORS]) -> f32 {
    let [head, rest @ ..] = code;
    let &[kind, first, second, third] = head;
    let factor = |i: u8| factors[usize::from(i) % FACTORS];
    if kind == MONOMIAL {
        // A factor that is none is 1, so that degrees 0 to 2 take the same path.
        let product = factor(first) * factor(second);
        if third == NO_FACTOR {
            return product;
        }
        let more = rest.as_flattened().iter().take_while(|&&i| i != NO_FACTOR);
        return more.fold(product * factor(third), |product, i| product * factor(*i));
    }
    let harmonic = u16::from_le_bytes([second, third]);
    let term = match kind {
        SIN => Term::Sin { variable: 0, harmonic },
        COS => Term::Cos { variable: 0, harmonic },
        POWER => Term::Power { variable: 0 },
        ODD_POWER => Term::OddPower { variable: 0 },
        _ => return f32::NAN,
    };
    term.eval(&[factor(first)])
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn factors(z: &[f32]) -> [f32; FACTORS] {
        let mut factors = [1.0; FACTORS];
        factors[..z.len()].copy_from_slice(z);
        factors
    }

    #[test]
    fn codes_round_trip_and_values_agree_to_the_bit() {
        let library = Library::new(3, 11, 300).unwrap().with_powers(true);
        let z = [0.9f32, -1.1, 0.4];
        for index in 0..library.len() {
            let term = library.term(index).unwrap();
            let code = encode_term(term);
            assert_eq!(decode_term(&code, &library), Some(term));
            assert_eq!(value(&code, &factors(&z)).to_bits(), term.eval(&z).to_bits());
        }
    }

    #[test]
    fn codes_outside_the_library_are_refused() {
        let small = Library::new(2, 2, 1).unwrap();
        let large = Library::new(3, 3, 2).unwrap();
        let inside = (0..small.len()).filter(|&i| decode_term(&encode_term(large.term(i).unwrap()), &small).is_some());
        assert!(inside.count() < small.len());
        assert!(decode_term(&[[9; 4]; 3], &large).is_none());
        let unsorted = [[MONOMIAL, 1, 0, NO_FACTOR], [NO_FACTOR; 4], [NO_FACTOR; 4]];
        assert!(decode_term(&unsorted, &large).is_none());
    }

    #[test]
    fn sparse_equals_dense() {
        let library = Library::new(3, 2, 1).unwrap();
        let z = [0.5f32, -0.25, 1.5];
        let dense = |term: usize, equation: usize| {
            if (term * 7 + equation * 3).is_multiple_of(4) { term as f32 * 0.1 - equation as f32 } else { 0.0 }
        };
        let (mut terms, mut ends, mut equations, mut coefficients) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for t in 0..library.len() {
            let used: Vec<_> = (0..3).filter(|&e| dense(t, e) != 0.0).collect();
            if used.is_empty() {
                continue;
            }
            for e in used {
                equations.push((e as u32).to_le_bytes());
                coefficients.push(dense(t, e).to_le_bytes());
            }
            terms.push(encode_term(library.term(t).unwrap()));
            ends.push((equations.len() as u32).to_le_bytes());
        }
        let dynamics =
            Dynamics { terms: &terms, ends: &ends, equations: &equations, coefficients: Floats(&coefficients) };
        let mut rate = [f32::NAN; 3];
        dynamics.rate(&factors(&z), &mut rate);
        let mut row = std::vec![0.0; library.len()];
        library.row(&z, &mut row);
        for (e, rate) in rate.iter().enumerate() {
            let sum = row.iter().enumerate().fold(
                0.0,
                |s, (t, theta)| {
                    if dense(t, e) == 0.0 { s } else { s + dense(t, e) * theta }
                },
            );
            assert_eq!(sum.to_bits(), rate.to_bits());
        }
        assert_eq!(dynamics.nonzeros(library).count(), coefficients.len());
    }
}
