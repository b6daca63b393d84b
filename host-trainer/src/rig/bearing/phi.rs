//! φ functions of a small matrix, k ≤ 3: theory (39).
//!
//! Hochbruck and Ostermann, "Exponential integrators", Acta Numerica 19 (2010) 209–286, section 2.

/// A square matrix of at most 6 × 6, row by row.
pub(super) type Matrix<const N: usize> = [[f64; N]; N];

/// Functions φ₀ … φ₃ of one matrix.
pub(super) struct Phi<const N: usize>(pub [Matrix<N>; 4]);

fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..N).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Linear combination Σ cₖ Mₖ.
pub(super) fn combination<const N: usize>(terms: &[(f64, &Matrix<N>)]) -> Matrix<N> {
    std::array::from_fn(|i| std::array::from_fn(|j| terms.iter().map(|(c, m)| c * m[i][j]).sum()))
}

pub(super) fn identity<const N: usize>() -> Matrix<N> {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

impl<const N: usize> Phi<N> {
    /// Taylor series of φ₃ at X/2ˢ, the others from it, then s doublings
    /// φₖ(2X) = 2⁻ᵏ (φ₀(X) φₖ(X) + Σⱼ φⱼ(X)/(k−j)!, j = 1…k).
    pub(super) fn from_matrix(x: &Matrix<N>) -> Self {
        let norm = x.iter().map(|row| row.iter().map(|v| v.abs()).sum::<f64>()).fold(0.0, f64::max);
        let doublings = (norm / 0.5).log2().ceil().clamp(0.0, 60.0) as i32;
        let x = combination(&[(0.5f64.powi(doublings), x)]);
        let one = identity::<N>();
        // 14 terms: the next is below 0.5¹⁴/17! of the first.
        let mut phi3 = combination(&[(1.0, &one)]);
        for k in (4..=17).rev() {
            phi3 = combination(&[(1.0, &one), (1.0 / f64::from(k), &product(&x, &phi3))]);
        }
        let phi3 = combination(&[(1.0 / 6.0, &phi3)]);
        let phi2 = combination(&[(0.5, &one), (1.0, &product(&x, &phi3))]);
        let phi1 = combination(&[(1.0, &one), (1.0, &product(&x, &phi2))]);
        let phi0 = combination(&[(1.0, &one), (1.0, &product(&x, &phi1))]);
        let mut p = [phi0, phi1, phi2, phi3];
        for _ in 0..doublings {
            let [p0, p1, p2, p3] = &p;
            p = [
                product(p0, p0),
                combination(&[(0.5, &product(p0, p1)), (0.5, p1)]),
                combination(&[(0.25, &product(p0, p2)), (0.25, p1), (0.25, p2)]),
                combination(&[(0.125, &product(p0, p3)), (0.0625, p1), (0.125, p2), (0.125, p3)]),
            ];
        }
        Self(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_phi_of_a_rotation() {
        // X = θ J: eˣ is the rotation by θ, X φ₁ = eˣ − I, X φ₂ = φ₁ − I, X φ₃ = φ₂ − I/2.
        for theta in [1e-3, 0.7, 40.0] {
            let x = [[0.0, -theta], [theta, 0.0]];
            let Phi([p0, p1, p2, p3]) = Phi::from_matrix(&x);
            let (s, c) = f64::sin_cos(theta);
            let one = identity::<2>();
            let close = |a: Matrix<2>, b: Matrix<2>| {
                let worst = (0..4).map(|k| (a[k / 2][k % 2] - b[k / 2][k % 2]).abs()).fold(0.0, f64::max);
                assert!(worst < 2e-14, "{theta}: {a:?} {b:?}");
            };
            close(p0, [[c, -s], [s, c]]);
            close(product(&x, &p1), combination(&[(1.0, &p0), (-1.0, &one)]));
            close(product(&x, &p2), combination(&[(1.0, &p1), (-1.0, &one)]));
            close(product(&x, &p3), combination(&[(1.0, &p2), (-0.5, &one)]));
        }
    }
}
