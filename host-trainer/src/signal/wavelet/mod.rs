//! Stationary wavelet transform and denoising.
//!
//! | module | holds |
//! |---|---|
//! | this one | wavelets and their filters |
//! | [`stationary`] | the transform and its inverse, the number of levels |
//! | [`denoise`] | shrinkage of the details |

pub mod denoise;
pub mod stationary;

use std::fmt;
use std::str::FromStr;

use osclet::{DaubechiesFamily, SymletFamily, WaveletFilterProvider};

/// Orthogonal wavelet: Daubechies' `db1` (Haar) to `db10`, with the least phase, or symlets `sym2` to `sym10`, nearly symmetric
/// (I. Daubechies, "Ten Lectures on Wavelets", 1992).
#[derive(Clone, Debug, PartialEq)]
pub struct Wavelet {
    name: String,
    /// Low-pass analysis filter; its squares sum to 1, it itself to √2.
    low: Vec<f64>,
    /// High-pass analysis filter, g_k = (−1)^(k+1) h_(L−1−k).
    high: Vec<f64>,
}

/// Name of no wavelet.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("found `{found}`, expected a wavelet: haar, db1 to db10, or sym2 to sym10")]
pub struct UnknownWavelet {
    /// Name that was asked for.
    pub found: String,
}

impl Wavelet {
    /// Names of all wavelets.
    pub fn names() -> impl Iterator<Item = String> {
        (1..=DAUBECHIES.len()).map(|n| format!("db{n}")).chain((2..SYMLETS.len() + 2).map(|n| format!("sym{n}")))
    }

    fn new(name: &str, synthesis: &[f64]) -> Self {
        let low: Vec<f64> = synthesis.iter().rev().copied().collect();
        let sign = |k: usize| if k.is_multiple_of(2) { -1.0 } else { 1.0 };
        let high = synthesis.iter().enumerate().map(|(k, h)| sign(k) * h).collect();
        Self { name: name.into(), low, high }
    }
}

impl fmt::Display for Wavelet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl FromStr for Wavelet {
    type Err = UnknownWavelet;

    fn from_str(name: &str) -> Result<Self, UnknownWavelet> {
        let order = |prefix: &str| name.strip_prefix(prefix).and_then(|n| n.parse::<usize>().ok());
        if name == "haar" {
            return Ok(Self::new(name, &DAUBECHIES[0].get_wavelet()));
        }
        let daubechies = order("db").and_then(|n| DAUBECHIES.get(n.checked_sub(1)?));
        let symlet = order("sym").and_then(|n| SYMLETS.get(n.checked_sub(2)?));
        match (daubechies, symlet) {
            (Some(family), _) => Ok(Self::new(name, &family.get_wavelet())),
            (_, Some(family)) => Ok(Self::new(name, &family.get_wavelet())),
            _ => Err(UnknownWavelet { found: name.into() }),
        }
    }
}

/// Daubechies' wavelets of 1 to 10 vanishing moments.
const DAUBECHIES: [DaubechiesFamily; 10] = [
    DaubechiesFamily::Db1,
    DaubechiesFamily::Db2,
    DaubechiesFamily::Db3,
    DaubechiesFamily::Db4,
    DaubechiesFamily::Db5,
    DaubechiesFamily::Db6,
    DaubechiesFamily::Db7,
    DaubechiesFamily::Db8,
    DaubechiesFamily::Db9,
    DaubechiesFamily::Db10,
];

/// Symlets of 2 to 10 vanishing moments.
const SYMLETS: [SymletFamily; 9] = [
    SymletFamily::Sym2,
    SymletFamily::Sym3,
    SymletFamily::Sym4,
    SymletFamily::Sym5,
    SymletFamily::Sym6,
    SymletFamily::Sym7,
    SymletFamily::Sym8,
    SymletFamily::Sym9,
    SymletFamily::Sym10,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_filters_are_orthogonal_to_their_even_shifts() {
        for name in Wavelet::names() {
            let wavelet: Wavelet = name.parse().unwrap();
            let product =
                |a: &[f64], b: &[f64], shift: usize| a.iter().skip(shift).zip(b).map(|(a, b)| a * b).sum::<f64>();
            for shift in (0..wavelet.low.len()).step_by(2) {
                let one = if shift == 0 { 1.0 } else { 0.0 };
                assert!((product(&wavelet.low, &wavelet.low, shift) - one).abs() < 1e-10, "{name} {shift}");
                assert!(product(&wavelet.low, &wavelet.high, shift).abs() < 1e-10, "{name} {shift}");
            }
        }
    }

    #[test]
    fn an_unknown_wavelet_is_refused_by_name() {
        for name in ["db0", "db11", "sym1", "coif1", "", "db", "db-1"] {
            let error = name.parse::<Wavelet>().unwrap_err().to_string();
            assert!(error.contains(&format!("`{name}`")) && error.contains("sym10"), "{error}");
        }
    }
}
