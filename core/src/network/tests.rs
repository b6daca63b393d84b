//! Tests of both arithmetics against plain definitions.

extern crate std;
use super::float::weight_index;
use super::*;
use crate::math;
use std::vec::Vec;

/// The definition: row-major weights, one output after the other.
struct Plain {
    widths: Vec<u16>,
    layers: Vec<(Vec<Vec<f32>>, Vec<f32>)>,
}

fn plain(widths: &[u16]) -> Plain {
    let mut seed = 12345u32;
    let mut next = move || {
        seed = seed.wrapping_mul(1664525).wrapping_add(1013904223);
        (seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    let layers = widths
        .windows(2)
        .map(|w| {
            let weights = (0..w[1]).map(|_| (0..w[0]).map(|_| next()).collect()).collect();
            (weights, (0..w[1]).map(|_| next()).collect())
        })
        .collect();
    Plain { widths: widths.to_vec(), layers }
}

impl Plain {
    fn words(&self) -> Vec<Word> {
        let mut out = Vec::new();
        for (weights, biases) in &self.layers {
            let (outputs, inputs) = (weights.len(), weights[0].len());
            let mut packed = std::vec![[0; 4]; outputs * inputs];
            for (o, row) in weights.iter().enumerate() {
                for (i, w) in row.iter().enumerate() {
                    packed[weight_index(inputs, outputs, o, i)] = w.to_le_bytes();
                }
            }
            out.extend(packed);
            out.extend(biases.iter().map(|b| b.to_le_bytes()));
        }
        out
    }

    fn forward(&self, x: &[f32]) -> Vec<f32> {
        let mut h = x.to_vec();
        for (n, (weights, biases)) in self.layers.iter().enumerate() {
            h = weights
                .iter()
                .zip(biases)
                .map(|(row, b)| row.iter().zip(&h).fold(*b, |sum, (w, x)| sum + w * x))
                .map(|a| if n + 1 < self.layers.len() { math::sigmoid(a) } else { a })
                .collect();
        }
        h
    }
}

#[test]
fn forward_equals_the_plain_definition_to_the_bit() {
    for widths in [&[8u16, 256, 8][..], &[128, 64, 32, 3], &[3, 5], &[1, 1, 1], &[9, 17, 11, 7, 2]] {
        let plain = plain(widths);
        let words = plain.words();
        let network = Network::new(&plain.widths, Arithmetic::Float, &words).unwrap();
        let x: Vec<f32> = (0..widths[0]).map(|i| (f32::from(i) * 0.7).sin()).collect();
        let mut y = std::vec![f32::NAN; usize::from(*widths.last().unwrap())];
        let mut scratch = std::vec![f32::NAN; network.forward_scratch_len()];
        network.forward(&x, &mut y, &mut scratch);
        assert_eq!(y, plain.forward(&x), "{widths:?}");
    }
}

#[test]
fn tangent_is_the_derivative() {
    for widths in [&[8u16, 64, 8][..], &[12, 9, 5, 3], &[3, 5]] {
        let plain = plain(widths);
        let words = plain.words();
        let network = Network::new(&plain.widths, Arithmetic::Float, &words).unwrap();
        let n = usize::from(widths[0]);
        let x: Vec<f32> = (0..n).map(|i| (i as f32 * 0.7).sin()).collect();
        let dx: Vec<f32> = (0..n).map(|i| (i as f32 * 1.3).cos()).collect();
        let mut dy = std::vec![f32::NAN; usize::from(*widths.last().unwrap())];
        let mut scratch = std::vec![f32::NAN; network.tangent_scratch_len()];
        network.tangent(&x, &dx, &mut dy, &mut scratch);
        let at = |h: f32| plain.forward(&x.iter().zip(&dx).map(|(x, d)| x + h * d).collect::<Vec<_>>());
        let h = 1e-2;
        // The approximate sigmoid's slope is that of its table's chords.
        let tolerance = if cfg!(feature = "approx") { 5e-2 } else { 2e-3 };
        for ((got, plus), minus) in dy.iter().zip(at(h)).zip(at(-h)) {
            assert!((got - (plus - minus) / (2.0 * h)).abs() < tolerance * (1.0 + got.abs()), "{widths:?}");
        }
    }
}

#[test]
fn identity_and_refusals() {
    let identity = Network::new(&[], Arithmetic::Float, &[]).unwrap();
    let (mut y, mut dy) = ([0.0; 2], [0.0; 2]);
    identity.forward(&[1.0, 2.0], &mut y, &mut []);
    identity.tangent(&[1.0, 2.0], &[3.0, 4.0], &mut dy, &mut []);
    assert_eq!((y, dy), ([1.0, 2.0], [3.0, 4.0]));
    let words = [[0; 4]; 6];
    assert!(Network::new(&[2, 2], Arithmetic::Float, &words).is_some());
    assert!(Network::new(&[2, 2], Arithmetic::Float, &words[..5]).is_none());
    assert!(Network::new(&[2], Arithmetic::Float, &[]).is_none());
    assert!(Network::new(&[0, 2], Arithmetic::Float, &words[..2]).is_none());
    assert!(Network::new(&[1; 8], Arithmetic::Float, &[[0; 4]; 14]).is_none());
}

/// The same network in fixed point.
fn fixed_words(network: &Network<'_>) -> Vec<Word> {
    let mut words = std::vec![[0; 4]; word_count(network.widths(), Arithmetic::Fixed).unwrap()];
    to_fixed(network, &mut words).unwrap();
    words
}

/// Root mean squares of the difference and of what is expected, over many inputs of standard deviation near `level`.
fn difference(widths: &[u16], level: f32, rates: bool) -> (f32, f32) {
    let plain = plain(widths);
    let words = plain.words();
    let float = Network::new(widths, Arithmetic::Float, &words).unwrap();
    let words = fixed_words(&float);
    let fixed = Network::new(widths, Arithmetic::Fixed, &words).unwrap();
    let (n, m) = (usize::from(widths[0]), usize::from(widths[2]));
    let mut scratch = std::vec![0.0; float.tangent_scratch_len()];
    let (mut wrong, mut power, mut count) = (0.0f32, 0.0, 0.0);
    for t in 0..200 {
        let x: Vec<f32> = (0..n).map(|i| level * (t as f32 * (0.31 + 0.17 * i as f32)).sin() * 1.4).collect();
        let dx: Vec<f32> = (0..n).map(|i| level * (t as f32 * (0.23 + 0.13 * i as f32)).cos() * 1.4).collect();
        let (mut y, mut z) = (std::vec![f32::NAN; m], std::vec![f32::NAN; m]);
        if rates {
            float.tangent(&x, &dx, &mut y, &mut scratch);
            fixed.tangent(&x, &dx, &mut z, &mut scratch);
        } else {
            float.forward(&x, &mut y, &mut scratch);
            fixed.forward(&x, &mut z, &mut scratch);
        }
        for (y, z) in y.iter().zip(&z) {
            wrong += (y - z) * (y - z);
            power += y * y;
            count += 1.0;
        }
    }
    ((wrong / count).sqrt(), (power / count).sqrt())
}

#[test]
fn fixed_point_is_the_network_within_three_thousandths() {
    for widths in [[8u16, 256, 8], [8, 64, 8], [3, 11, 2], [16, 40, 9], [1, 1, 1]] {
        for level in [1e-3, 0.1, 1.0, 30.0] {
            for rates in [false, true] {
                let (wrong, rms) = difference(&widths, level, rates);
                // Rates have no bias to be small beside.
                let least = if rates { 0.0 } else { 0.1 };
                assert!(wrong < 3e-3 * rms.max(least), "{widths:?}, level {level}, {rates}: {wrong} of {rms}");
            }
        }
    }
}

#[test]
fn fixed_point_has_nothing_for_what_it_cannot_hold() {
    let plain = plain(&[3, 4, 2]);
    let words = plain.words();
    let float = Network::new(&plain.widths, Arithmetic::Float, &words).unwrap();
    let words = fixed_words(&float);
    let fixed = Network::new(&plain.widths, Arithmetic::Fixed, &words).unwrap();
    let mut scratch = std::vec![0.0; fixed.forward_scratch_len()];
    for broken in [f32::NAN, f32::INFINITY, 1e30] {
        let (mut y, mut dy) = ([0.0; 2], [0.0; 2]);
        fixed.forward(&[0.0, broken, 0.0], &mut y, &mut scratch);
        fixed.tangent(&[0.0; 3], &[0.0, broken, 0.0], &mut dy, &mut scratch);
        assert!(y.iter().chain(&dy).all(|v| v.is_nan()), "{broken}: {y:?} {dy:?}");
    }
    let mut y = [0.0; 2];
    fixed.forward(&[0.0; 3], &mut y, &mut scratch);
    assert!(y.iter().all(|v| v.is_finite()));
}

#[test]
fn fixed_point_refuses_other_shapes_sizes_and_exponents() {
    let deep = plain(&[3, 4, 4, 2]);
    let words = deep.words();
    let network = Network::new(&deep.widths, Arithmetic::Float, &words).unwrap();
    assert_eq!(to_fixed(&network, &mut []), Err(FixedError::Shape));
    let shallow = plain(&[3, 4, 2]);
    let mut words = shallow.words();
    let network = Network::new(&shallow.widths, Arithmetic::Float, &words).unwrap();
    assert!(matches!(to_fixed(&network, &mut []), Err(FixedError::Buffer { found: 0, .. })));
    let good = fixed_words(&network);
    assert!(Network::new(&shallow.widths, Arithmetic::Fixed, &good).is_some());
    assert!(Network::new(&shallow.widths, Arithmetic::Fixed, &good[1..]).is_none());
    assert!(Network::new(&[3, 4, 17], Arithmetic::Fixed, &good).is_none());
    for wrong in [-1i32, 28] {
        let mut bad = good.clone();
        bad[0] = wrong.to_le_bytes();
        assert!(Network::new(&shallow.widths, Arithmetic::Fixed, &bad).is_none());
    }
    words[0] = 1e6f32.to_le_bytes();
    let network = Network::new(&shallow.widths, Arithmetic::Float, &words).unwrap();
    let mut out = std::vec![[0; 4]; good.len()];
    assert_eq!(to_fixed(&network, &mut out), Err(FixedError::Weights { layer: 0 }));
}

#[test]
fn no_sum_of_fixed_point_wraps() {
    // Weights all of one sign and inputs at their limit: the greatest sums there are.
    let widths = [8u16, 64, 4];
    let words: Vec<Word> = (0..float::word_count(&widths)).map(|_| 0.73f32.to_le_bytes()).collect();
    let float = Network::new(&widths, Arithmetic::Float, &words).unwrap();
    let words = fixed_words(&float);
    let fixed = Network::new(&widths, Arithmetic::Fixed, &words).unwrap();
    let mut scratch = std::vec![0.0; float.tangent_scratch_len()];
    let x = [0.999_999f32; 8];
    let (mut y, mut z) = ([0.0; 4], [0.0; 4]);
    float.forward(&x, &mut y, &mut scratch);
    fixed.forward(&x, &mut z, &mut scratch);
    assert!(y.iter().zip(&z).all(|(y, z)| (y - z).abs() < 2e-3 * y.abs()), "{y:?} {z:?}");
    float.tangent(&x, &x, &mut y, &mut scratch);
    fixed.tangent(&x, &x, &mut z, &mut scratch);
    assert!(y.iter().zip(&z).all(|(y, z)| (y - z).abs() < 0.1 * y.abs()), "{y:?} {z:?}");
}
