//! Library Θ(z), theory (7), and its derivative over panels: core's terms in core's order, each from earlier rows.

use ballrace_core::library::{Library, Monomial, POWER_RADIUS, Term};
use pulp::Simd;

use super::panel::Panel;
use super::real::Real;

/// Operation that gives a row of Θ from z and earlier rows.
#[derive(Clone, Copy, Debug)]
enum Row {
    One,
    /// Row `prefix` times z_`variable`.
    Product {
        prefix: usize,
        variable: usize,
    },
    Sin {
        variable: usize,
        harmonic: usize,
    },
    Cos {
        variable: usize,
        harmonic: usize,
    },
    Power {
        variable: usize,
    },
    /// From row `power`, the even one.
    OddPower {
        power: usize,
        variable: usize,
    },
}

/// Latent variables in the first columns of a panel's rows.
#[derive(Clone, Copy, Debug)]
pub struct LatentRows<'a, T> {
    /// All values of the panel.
    pub values: &'a [T],
    /// Values in a row of the panel.
    pub stride: usize,
}

impl<'a, T> LatentRows<'a, T> {
    #[inline(always)]
    fn row(&self, variable: usize, columns: usize) -> &'a [T] {
        &self.values[variable * self.stride..][..columns]
    }
}

/// Core's library as a sequence of row operations.
#[derive(Clone, Debug)]
pub struct Terms {
    rows: Vec<Row>,
    variables: usize,
    /// First row of the Fourier part.
    fourier: usize,
}

impl Terms {
    /// The rows of a valid library.
    pub fn new(library: Library) -> Self {
        let row = |index| match library.term(index).expect("an index below len") {
            Term::Sin { variable, harmonic } => Row::Sin { variable: variable.into(), harmonic: harmonic.into() },
            Term::Cos { variable, harmonic } => Row::Cos { variable: variable.into(), harmonic: harmonic.into() },
            Term::Power { variable } => Row::Power { variable: variable.into() },
            Term::OddPower { variable } => {
                let power = library.index_of(Term::Power { variable }).expect("a library with powers");
                Row::OddPower { power, variable: variable.into() }
            }
            Term::Monomial(m) => match m.factors().split_last() {
                None => Row::One,
                Some((last, prefix)) => {
                    let prefix = Monomial::new(prefix).expect("a prefix of sorted factors");
                    let prefix = library.index_of(Term::Monomial(prefix)).expect("a smaller degree");
                    Row::Product { prefix, variable: (*last).into() }
                }
            },
        };
        Self {
            rows: (0..library.len()).map(row).collect(),
            variables: library.variables.into(),
            fourier: library.polynomial_len(),
        }
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    fn sine(&self, variable: usize, harmonic: usize) -> usize {
        self.fourier + (harmonic - 1) * 2 * self.variables + variable
    }

    fn cosine(&self, variable: usize, harmonic: usize) -> usize {
        self.sine(variable, harmonic) + self.variables
    }

    /// Computes theta (terms × S) from z (variables × S).
    #[inline(always)]
    pub fn forward<S: Simd, T: Real>(&self, simd: S, z_rows: LatentRows<'_, T>, theta: &mut Panel<T>, columns: usize) {
        for (index, row) in self.rows.iter().enumerate() {
            let (before, here) = theta.values_mut().split_at_mut(index * columns);
            let out = T::vectors_mut::<S>(&mut here[..columns]);
            let earlier = |r: usize| T::vectors::<S>(&before[r * columns..][..columns]);
            let z = |variable: usize| T::vectors::<S>(z_rows.row(variable, columns));
            match *row {
                Row::One => out.fill(T::splat(simd, T::from_f64(1.0))),
                Row::Product { prefix, variable } => {
                    for ((out, a), b) in out.iter_mut().zip(earlier(prefix)).zip(z(variable)) {
                        *out = T::mul(simd, *a, *b);
                    }
                }
                Row::Sin { variable, harmonic: 1 } => {
                    out.iter_mut().zip(z(variable)).for_each(|(out, z)| *out = T::sin_cos(simd, *z).0);
                }
                Row::Cos { variable, harmonic: 1 } => {
                    out.iter_mut().zip(z(variable)).for_each(|(out, z)| *out = T::sin_cos(simd, *z).1);
                }
                // sin kz = sin (k−1)z cos z + cos (k−1)z sin z, and likewise the cosine.
                Row::Sin { variable, harmonic } => {
                    let (s, c) =
                        (earlier(self.sine(variable, harmonic - 1)), earlier(self.cosine(variable, harmonic - 1)));
                    let (s1, c1) = (earlier(self.sine(variable, 1)), earlier(self.cosine(variable, 1)));
                    for i in 0..out.len() {
                        out[i] = T::mul_add(simd, s[i], c1[i], T::mul(simd, c[i], s1[i]));
                    }
                }
                Row::Cos { variable, harmonic } => {
                    let (s, c) =
                        (earlier(self.sine(variable, harmonic - 1)), earlier(self.cosine(variable, harmonic - 1)));
                    let (s1, c1) = (earlier(self.sine(variable, 1)), earlier(self.cosine(variable, 1)));
                    for i in 0..out.len() {
                        out[i] = T::sub(simd, T::mul(simd, c[i], c1[i]), T::mul(simd, s[i], s1[i]));
                    }
                }
                Row::Power { variable } => {
                    let z = z_rows.row(variable, columns);
                    here[..columns].iter_mut().zip(z).for_each(|(out, z)| *out = T::from_f64(power(z.to_f64()).0));
                }
                Row::OddPower { power, variable } => {
                    let (even, z) = (&before[power * columns..][..columns], z_rows.row(variable, columns));
                    for ((out, even), z) in here[..columns].iter_mut().zip(even).zip(z) {
                        *out = T::from_f64(z.to_f64() / even.to_f64().sqrt());
                    }
                }
            }
        }
    }

    /// Adds (∂Θ/∂z)ᵀ `theta_adjoint` to `z_adjoint`; overwrites the former.
    #[inline(always)]
    pub fn backward<S: Simd, T: Real>(
        &self,
        simd: S,
        z: LatentRows<'_, T>,
        theta: &Panel<T>,
        theta_adjoint: &mut Panel<T>,
        z_adjoint: &mut [T],
        columns: usize,
    ) {
        for (index, row) in self.rows.iter().enumerate().rev() {
            let (before, here) = theta_adjoint.values_mut().split_at_mut(index * columns);
            let adjoint = T::vectors::<S>(&here[..columns]);
            match *row {
                Row::One => {}
                Row::Product { prefix, variable } => {
                    let below = T::vectors::<S>(theta.row(prefix));
                    let stride = z.stride;
                    let z = T::vectors::<S>(z.row(variable, columns));
                    let z_adjoint = T::vectors_mut::<S>(&mut z_adjoint[variable * stride..][..columns]);
                    let below_adjoint = T::vectors_mut::<S>(&mut before[prefix * columns..][..columns]);
                    for i in 0..adjoint.len() {
                        z_adjoint[i] = T::mul_add(simd, adjoint[i], below[i], z_adjoint[i]);
                        below_adjoint[i] = T::mul_add(simd, adjoint[i], z[i], below_adjoint[i]);
                    }
                }
                Row::Power { variable } | Row::OddPower { variable, .. } => {
                    let is_odd = matches!(row, Row::OddPower { .. });
                    let latent = z.row(variable, columns);
                    let z_adjoint = &mut z_adjoint[variable * z.stride..][..columns];
                    for ((out, adjoint), z) in z_adjoint.iter_mut().zip(&here[..columns]).zip(latent) {
                        let (_, slope, odd_slope) = power(z.to_f64());
                        *out += T::from_f64(adjoint.to_f64() * if is_odd { odd_slope } else { slope });
                    }
                }
                Row::Sin { variable, harmonic } | Row::Cos { variable, harmonic } => {
                    let (slope, sign) = match row {
                        Row::Sin { .. } => (self.cosine(variable, harmonic), 1.0),
                        _ => (self.sine(variable, harmonic), -1.0),
                    };
                    let stride = z.stride;
                    let factor = T::splat(simd, T::from_f64(sign * harmonic as f64));
                    let slope = T::vectors::<S>(theta.row(slope));
                    let z_adjoint = T::vectors_mut::<S>(&mut z_adjoint[variable * stride..][..columns]);
                    for i in 0..adjoint.len() {
                        let scaled = T::mul(simd, adjoint[i], factor);
                        z_adjoint[i] = T::mul_add(simd, scaled, slope[i], z_adjoint[i]);
                    }
                }
            }
        }
    }
}

/// Even power of theory (112), its slope, and the slope of the odd one.
fn power(z: f64) -> (f64, f64, f64) {
    let radius = f64::from(POWER_RADIUS);
    let square = z * z + radius * radius;
    let even = square.cbrt();
    (even, 2.0 / 3.0 * z / (even * even), (1.0 - z * z / (3.0 * square)) / even.sqrt())
}
