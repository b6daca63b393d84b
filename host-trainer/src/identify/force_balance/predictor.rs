//! One-step predictions of a linear rig of one degree of freedom, and what forces and sensor signals add to them.
//!
//! m q̈ + c q̇ + k q = f + w with white force noise w, y = q + e (or q̈ + e) with white sensor noise: the Kalman filter's
//! innovations are white, and linear in whatever drives them (R. E. Kalman, J. Basic Eng. 82 (1960) 35–45; T. Söderström,
//! P. Stoica, "System Identification", 1989, section 7). A force known at a few parameters is then a column of a regression, in
//! which model error counts as force noise and sensor noise as sensor noise, whichever rules: with much force noise it is the
//! force balance, without any it is the output error. The start of each recording is diffuse, so that no sample is lost.

type Vec2 = [f64; 2];
type Mat2 = [[f64; 2]; 2];

/// Linear part of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operator {
    /// Mass, kg.
    pub mass: f64,
    /// Damping, N s/m.
    pub damping: f64,
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Whether the sensor measures q̈, not q.
    pub accelerometer: bool,
}

/// Grid of a recording.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// Time between samples, s.
    pub step_s: f64,
    /// Grid points a step.
    pub fine: usize,
    /// Whether each sample is invalid.
    pub bad: &'a [bool],
    /// Sizes of position and velocity, for the diffuse start.
    pub sizes: Vec2,
}

/// Filter of a recording, with its gains.
#[derive(Clone, Debug)]
pub struct Predictor {
    operator: Operator,
    fine: usize,
    transition: Mat2,
    /// Weights of a force at the start and the end of a grid step, if it goes in a straight line.
    line: [Vec2; 2],
    /// Weight of a force that is held over a grid step.
    held: Vec2,
    output: Vec2,
    /// Gain, and 1/√ of the innovation's variance in units of the sensor noise's; `None` at an invalid sample.
    gains: Vec<Option<(Vec2, f64)>>,
    /// Sum of the logarithms of the innovations' variances.
    pub log_variance: f64,
}

impl Predictor {
    /// Filter at a ratio of the force noise's power spectral density (N²/Hz, two-sided) to the sensor noise's variance.
    pub fn new(operator: Operator, grid: &Grid, ratio: f64) -> Self {
        let h = grid.step_s / grid.fine as f64;
        let Operator { mass, damping, stiffness, accelerometer } = operator;
        let a = [[0.0, 1.0], [-stiffness / mass, -damping / mass]];
        let augmented =
            [[a[0][0], a[0][1], 0.0, 0.0], [a[1][0], a[1][1], 1.0 / mass, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0; 4]];
        let e = exponential(&augmented, h);
        let transition = [[e[0][0], e[0][1]], [e[1][0], e[1][1]]];
        let held = [e[0][2], e[1][2]];
        let end = [e[0][3] / h, e[1][3] / h];
        let line = [[held[0] - end[0], held[1] - end[1]], end];
        let noise = force_noise(&a, ratio / (mass * mass), h);
        let output = if accelerometer { a[1] } else { [1.0, 0.0] };
        let mut spread = [[grid.sizes[0].powi(2), 0.0], [0.0, grid.sizes[1].powi(2)]];
        let mut gains = Vec::with_capacity(grid.bad.len());
        let mut log_variance = 0.0;
        for (k, bad) in grid.bad.iter().enumerate() {
            if k > 0 {
                for _ in 0..grid.fine {
                    spread = sum(&sandwich(&transition, &spread), &noise);
                }
            }
            if *bad {
                gains.push(None);
                continue;
            }
            let seen = multiply(&spread, &output);
            let variance = dot(&output, &seen) + 1.0;
            let gain = [seen[0] / variance, seen[1] / variance];
            let keep: Mat2 =
                std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)) - gain[i] * output[j]));
            spread = sandwich(&keep, &spread);
            (0..2).for_each(|i| (0..2).for_each(|j| spread[i][j] += gain[i] * gain[j]));
            gains.push(Some((gain, 1.0 / variance.sqrt())));
            log_variance += variance.ln();
        }
        Self { operator, fine: grid.fine, transition, line, held, output, gains, log_variance }
    }

    /// Standard deviation of each valid sample's innovation, in units of the sensor noise's.
    pub fn deviations(&self) -> Vec<f64> {
        self.gains.iter().flatten().map(|(_, weight)| 1.0 / weight).collect()
    }

    /// What a force on the grid adds to the whitened predictions, a row for each valid sample.
    pub fn of_force(&self, force: &[f64], is_held: bool) -> Vec<f64> {
        let feed = if self.operator.accelerometer { 1.0 / self.operator.mass } else { 0.0 };
        let mut x = [0.0; 2];
        let mut rows = Vec::with_capacity(self.gains.len());
        for (k, gain) in self.gains.iter().enumerate() {
            if k > 0 {
                for part in (k - 1) * self.fine..k * self.fine {
                    let (from, to) = (force[part], force[part + 1]);
                    let free = multiply(&self.transition, &x);
                    x = if is_held {
                        [free[0] + self.held[0] * from, free[1] + self.held[1] * from]
                    } else {
                        std::array::from_fn(|i| free[i] + self.line[0][i] * from + self.line[1][i] * to)
                    };
                }
            }
            if let Some((gain, weight)) = gain {
                let seen = dot(&self.output, &x) + feed * force[k * self.fine];
                rows.push(weight * seen);
                (0..2).for_each(|i| x[i] -= gain[i] * seen);
            }
        }
        rows
    }

    /// Whitened innovations of a sensor signal, a row for each valid sample.
    pub fn of_sensor(&self, signal: &[f64]) -> Vec<f64> {
        let mut x = [0.0; 2];
        let mut rows = Vec::with_capacity(self.gains.len());
        for (k, (gain, value)) in self.gains.iter().zip(signal).enumerate() {
            if k > 0 {
                for _ in 0..self.fine {
                    x = multiply(&self.transition, &x);
                }
            }
            if let Some((gain, weight)) = gain {
                let error = value - dot(&self.output, &x);
                rows.push(weight * error);
                (0..2).for_each(|i| x[i] += gain[i] * error);
            }
        }
        rows
    }
}

/// Covariance of the state after a time h of white noise in the acceleration, by doubling.
fn force_noise(a: &Mat2, density: f64, h: f64) -> Mat2 {
    let rate = a.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs().sqrt()).max(if *x < 0.0 { -x } else { 0.0 }));
    let doublings = (h * rate * 50.0).max(1.0).log2().ceil() as i32;
    let small = h / 2f64.powi(doublings);
    let mut phi = {
        let square = product(a, a);
        let mut one: Mat2 =
            std::array::from_fn(|i| std::array::from_fn(|j| small * a[i][j] + 0.5 * small * small * square[i][j]));
        (0..2).for_each(|i| one[i][i] += 1.0);
        one
    };
    let mut noise = [
        [density * small.powi(3) / 3.0, density * small.powi(2) / 2.0],
        [density * small.powi(2) / 2.0, density * small],
    ];
    for _ in 0..doublings {
        noise = sum(&sandwich(&phi, &noise), &noise);
        phi = product(&phi, &phi);
    }
    noise
}

/// e^(A h) by scaling and squaring.
fn exponential(a: &[[f64; 4]; 4], h: f64) -> [[f64; 4]; 4] {
    let times = |x: &[[f64; 4]; 4], y: &[[f64; 4]; 4]| -> [[f64; 4]; 4] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| x[i][k] * y[k][j]).sum()))
    };
    let rate = a[1][0].abs().sqrt().max(a[1][1].abs()) + 1.0 / h;
    let squarings = (8.0 * h * rate).log2().ceil().max(0.0) as i32;
    let small = h / 2f64.powi(squarings);
    // Position, velocity, force and its slope in units in which all entries are about 1.
    let unit = [1.0, small, 1.0, small];
    let scaled: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| small * a[i][j] * unit[i] / unit[j]));
    let one: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let (mut sum, mut term) = (one, one);
    for order in 1..=14 {
        term = times(&term, &scaled);
        term.iter_mut().flatten().for_each(|x| *x /= f64::from(order));
        (0..4).for_each(|i| (0..4).for_each(|j| sum[i][j] += term[i][j]));
    }
    for _ in 0..squarings {
        sum = times(&sum, &sum);
    }
    std::array::from_fn(|i| std::array::from_fn(|j| sum[i][j] * unit[j] / unit[i]))
}

fn product(a: &Mat2, b: &Mat2) -> Mat2 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

fn sum(a: &Mat2, b: &Mat2) -> Mat2 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// A P Aᵀ.
fn sandwich(a: &Mat2, p: &Mat2) -> Mat2 {
    let left = product(a, p);
    std::array::from_fn(|i| std::array::from_fn(|j| left[i][0] * a[j][0] + left[i][1] * a[j][1]))
}

fn multiply(a: &Mat2, x: &Vec2) -> Vec2 {
    [a[0][0] * x[0] + a[0][1] * x[1], a[1][0] * x[0] + a[1][1] * x[1]]
}

fn dot(a: &Vec2, b: &Vec2) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::force_balance::testing::white;

    /// An oscillator under a tone and noise of force and sensor: with the right ratio and force, the innovations are white
    /// and of the sensor noise's variance.
    #[test]
    fn invariant_innovations_are_white() {
        let operator = Operator { mass: 2.0, damping: 4.0, stiffness: 800.0, accelerometer: false };
        let (h, fine, count) = (0.01, 1, 8000);
        let density = 1e-3;
        let (mut q, mut v) = (0.0, 0.0);
        let (force_noise, sensor_noise) = (white(1, 1.0, 20 * count), white(2, 1e-3, count));
        let tone = |t: f64| 5.0 * (9.0 * t).sin();
        let mut measured = Vec::new();
        for k in 0..count {
            measured.push(q + sensor_noise[k]);
            for part in 0..20 {
                let small = h / 20.0;
                let t = h * k as f64 + small * f64::from(part);
                let w = force_noise[20 * k + part as usize] * (density / small).sqrt();
                v += small * (tone(t) + w - 4.0 * v - 800.0 * q) / 2.0;
                q += small * v;
            }
        }
        let grid = Grid { step_s: h, fine, bad: &vec![false; count], sizes: [1.0, 10.0] };
        let predictor = Predictor::new(operator, &grid, density / 1e-6);
        let force: Vec<f64> = (0..count).map(|k| tone(h * k as f64)).collect();
        let (y, f) = (predictor.of_sensor(&measured), predictor.of_force(&force, false));
        let left: Vec<f64> = y.iter().zip(&f).map(|(y, f)| y - f).skip(10).collect();
        let variance = left.iter().map(|e| e * e).sum::<f64>() / left.len() as f64;
        assert!((variance / 1e-6 - 1.0).abs() < 0.06, "{variance}");
        for lag in 1..4 {
            let share = left.windows(lag + 1).map(|w| w[0] * w[lag]).sum::<f64>() / left.len() as f64 / variance;
            assert!(share.abs() < 0.05, "{lag} {share}");
        }
    }

    /// A mass of next to nothing on a damper: the exact step does not overflow, and a held force moves it at f/c.
    #[test]
    fn invariant_a_stiff_rig_is_exact() {
        let operator = Operator { mass: 1e-3, damping: 700.0, stiffness: 0.0, accelerometer: false };
        let grid = Grid { step_s: 0.02, fine: 1, bad: &[false; 3], sizes: [0.0, 0.0] };
        let predictor = Predictor::new(operator, &grid, 0.0);
        let rows = predictor.of_force(&[7.0; 3], true);
        assert!((rows[1] - 7.0 / 700.0 * 0.02).abs() < 1e-7 && (rows[2] - 2.0 * rows[1]).abs() < 1e-7, "{rows:?}");
    }
}
