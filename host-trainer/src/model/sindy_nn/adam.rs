//! Adam (Kingma and Ba 2015), theory (15), with coefficients that stay zero once masked.

use pulp::Arch;

use super::settings::AdamSettings;

const SETTINGS: AdamSettings = AdamSettings::DEFAULT;

/// Moments of every parameter.
#[derive(Clone, Debug)]
pub struct Adam {
    first: Vec<f32>,
    second: Vec<f32>,
    steps: i32,
}

const BETA: [f32; 2] = [SETTINGS.first_decay, SETTINGS.second_decay];
const EPSILON: f32 = SETTINGS.epsilon;

impl Adam {
    /// Moments before the first step.
    pub fn new(parameters: usize) -> Self {
        Self { first: vec![0.0; parameters], second: vec![0.0; parameters], steps: 0 }
    }

    /// One step down the gradient; each parameter's learning rate is multiplied by its `rates`, 0 where it is masked.
    pub fn step(&mut self, parameters: &mut [f32], gradient: &[f32], rates: &[f32], learning_rate: f32) {
        self.steps += 1;
        let bias = BETA.map(|b| 1.0 - b.powi(self.steps));
        let rate = learning_rate / bias[0];
        let scale = 1.0 / bias[1];
        Arch::new().dispatch(|| {
            let moments = self.first.iter_mut().zip(&mut self.second);
            for (((p, g), own), (m, v)) in parameters.iter_mut().zip(gradient).zip(rates).zip(moments) {
                *m = BETA[0] * *m + (1.0 - BETA[0]) * g;
                *v = BETA[1] * *v + (1.0 - BETA[1]) * g * g;
                *p -= rate * own * *m / ((*v * scale).sqrt() + EPSILON);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_first_step_is_the_learning_rate_and_minimum_is_found() {
        let mut adam = Adam::new(3);
        let mut p = [1.0f32, -1.0, 0.0];
        adam.step(&mut p, &[5.0, -0.1, 3.0], &[1.0, 1.0, 0.0], 0.01);
        // Whatever the gradient, the first step is the learning rate (section 2.1 of the paper).
        assert!((p[0] - 0.99).abs() < 1e-6 && (p[1] + 0.99).abs() < 1e-6);
        assert_eq!(p[2], 0.0);
        for _ in 0..3000 {
            let gradient = [p[0] - 0.3, 4.0 * (p[1] - 0.7), 1.0];
            adam.step(&mut p, &gradient, &[1.0, 1.0, 0.0], 0.01);
        }
        assert!((p[0] - 0.3).abs() < 1e-3 && (p[1] - 0.7).abs() < 1e-3 && p[2] == 0.0);
    }
}
