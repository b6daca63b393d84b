//! One step of the exponential Runge–Kutta method of order four, theory (40): Cox and Matthews, "Exponential time
//! differencing for stiff systems", J. Comput. Phys. 176 (2002) 430–455, equations (26) to (29).
//!
//! In short: a = e^{Ah/2} z + A₂₁ n(z), b = e^{Ah/2} z + A₂₁ n(a),
//! c = e^{Ah/2} a + A₂₁ (2 n(b) − n(z)), and z⁺ = e^{Ah} z + B₁ n(z) + B₂ (n(a) + n(b)) + B₃ n(c).

use super::phi::{Matrix, Phi, combination, identity};

/// Number of states: x_s, x_p and their velocities; y_s, y_p, y_b and theirs.
pub(super) const STATES: usize = 10;

/// The matrices of a step for N states (positions, then velocities) and M forces.
#[derive(Clone)]
pub(super) struct Step<const N: usize, const M: usize> {
    /// Matrix e^{Ah/2}.
    pub half: Matrix<N>,
    /// Matrix e^{Ah}.
    pub full: Matrix<N>,
    /// Matrix A₂₁ = h/2 φ₁(Ah/2) B.
    pub a: [[f64; M]; N],
    /// Matrix (e^{Ah/2} − I) A₂₁: with c written out as e^{Ah} z + `c1` n(z) + 2 A₂₁ n(b), a itself is not needed.
    pub c1: [[f64; M]; N],
    /// Matrix B₁ = h (φ₁ − 3 φ₂ + 4 φ₃) B.
    pub b1: [[f64; M]; N],
    /// Matrix B₂ = h (2 φ₂ − 4 φ₃) B.
    pub b2: [[f64; M]; N],
    /// Matrix B₃ = h (4 φ₃ − φ₂) B.
    pub b3: [[f64; M]; N],
}

impl<const N: usize, const M: usize> Step<N, M> {
    /// Matrices of a step of `h` s, with A `system` and the M entries of B `inverse_mass`, 1/kg.
    pub(super) fn new(system: &Matrix<N>, inverse_mass: &[f64; M], h: f64) -> Self {
        // Velocities in units of the fastest mode's, so that the norm of A measures its size.
        let fastest = system[M..].iter().flatten().fold(1.0f64, |w, v| w.max(v.abs().sqrt()));
        let unit = |i: usize| if i < M { 1.0 } else { fastest };
        let scaled: Matrix<N> =
            std::array::from_fn(|i| std::array::from_fn(|j| system[i][j] * unit(j) / unit(i) * 0.5 * h));
        let unscale = |m: &Matrix<N>| -> Matrix<N> {
            std::array::from_fn(|i| std::array::from_fn(|j| m[i][j] * unit(i) / unit(j)))
        };
        let input = |m: &Matrix<N>| -> [[f64; M]; N] {
            std::array::from_fn(|i| std::array::from_fn(|k| m[i][M + k] * inverse_mass[k]))
        };
        let [half, half1, ..] = Phi::from_matrix(&scaled).0.map(|m| unscale(&m));
        let doubled = combination(&[(2.0, &scaled)]);
        let [full, p1, p2, p3] = Phi::from_matrix(&doubled).0.map(|m| unscale(&m));
        let a_matrix = combination(&[(0.5 * h, &half1)]);
        let a = input(&a_matrix);
        let less_one = combination(&[(1.0, &half), (-1.0, &identity())]);
        let c1 = std::array::from_fn(|i| std::array::from_fn(|k| (0..N).map(|j| less_one[i][j] * a[j][k]).sum()));
        Self {
            half,
            full,
            a,
            c1,
            b1: input(&combination(&[(h, &p1), (-3.0 * h, &p2), (4.0 * h, &p3)])),
            b2: input(&combination(&[(2.0 * h, &p2), (-4.0 * h, &p3)])),
            b3: input(&combination(&[(4.0 * h, &p3), (-h, &p2)])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_constant_force_is_exact() {
        // A damped mass on a spring under a constant force from rest: q = F/k (1 − e^{−ζωt}(cos ω_d t + ζω/ω_d sin ω_d t)).
        let (mass, stiffness, damping, force) = (2.0, 5e7, 900.0, 30.0);
        let h = 3e-5;
        let system = [[0.0, 1.0], [-stiffness / mass, -damping / mass]];
        let step = Step::<2, 1>::new(&system, &[1.0 / mass], h);
        let mut z = [0.0, 0.0];
        for _ in 0..1000 {
            z = std::array::from_fn(|i| {
                let free: f64 = (0..2).map(|j| step.full[i][j] * z[j]).sum();
                free + (step.b1[i][0] + 2.0 * step.b2[i][0] + step.b3[i][0]) * force
            });
        }
        let t = 1000.0 * h;
        let decay = damping / (2.0 * mass);
        let damped = (stiffness / mass - decay * decay).sqrt();
        let exact =
            force / stiffness * (1.0 - (-decay * t).exp() * ((damped * t).cos() + decay / damped * (damped * t).sin()));
        assert!((z[0] / exact - 1.0).abs() < 1e-11, "{} against {exact}", z[0]);
    }
}
