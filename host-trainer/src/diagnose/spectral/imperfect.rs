//! What a run of a rig lacks of a machine: a wandering rotation, balls that are uneven in place and diameter, races out of round.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::data::Point;
use super::prediction::is_inner;
use super::settings::{FORMS, LikelihoodSettings};
use super::sidebands::Sidebands;
use super::stretch::Stretch;
use super::unevenness::with_roundness;
use crate::rig::{OperatingCondition, Rig, Start};
use crate::signal::interpolate::{Interpolator, held};
use crate::signal::kinematics::Orders;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;
/// Tones of a wandering rotation.
const TONES: usize = 16;

/// Imperfections of a machine in a recording, of the sizes that a fit has found there. A seed draws all but the balls' diameters, which
/// follow from that of the run.
#[derive(Clone, Debug)]
pub struct Imperfections {
    /// Standard deviation of the time of a ball pass, s.
    jitter_s: f64,
    /// Standard deviation of a ball's place in the cage, rad.
    spacing_rad: f64,
    /// Weights of the orders of the cage in the balls' places.
    sidebands: Sidebands,
    /// Standard deviation of the balls' diameters and amplitude of the races' roundness, m.
    form_m: [f64; FORMS],
    /// Stretch of the lines.
    stretch: Stretch,
    seed: u64,
}

impl Imperfections {
    /// Imperfections at a point in one of its recordings.
    pub fn of(point: &Point, recording: usize, seed: u64) -> Self {
        Self {
            jitter_s: SETTINGS.jitter_s[point.jitter[recording]],
            spacing_rad: SETTINGS.spacing_rad[point.spacing],
            sidebands: point.sidebands.clone(),
            form_m: std::array::from_fn(|form| SETTINGS.form_m[form][point.form[form]]),
            stretch: point.stretch[recording],
            seed,
        }
    }

    /// Rig whose races are out of round.
    pub fn rig(&self, rig: &Rig) -> Rig {
        let [_, roundness_m] = self.form_m;
        if roundness_m > 0.0 { with_roundness(rig, roundness_m, self.seed) } else { rig.clone() }
    }

    /// Start with balls of several diameters.
    pub fn start(&self, start: Start) -> Start {
        let [ball_std_m, _] = self.form_m;
        Start { ball_std_m, ..start }
    }

    /// Condition at the speed that gives the lines of a rig their frequencies; the rig is the one without imperfections.
    pub fn condition(&self, rig: &Rig, condition: OperatingCondition) -> OperatingCondition {
        let Stretch { outer, inner } = self.stretch;
        let stretch = if rig.effects.iter().any(is_inner) { inner } else { outer };
        OperatingCondition { shaft_hz: (1.0 + stretch) * condition.shaft_hz, ..condition }
    }

    /// Lines of a recording of an even machine as they are where each ball passes early or late, by its place in the cage and as the
    /// rotation wanders.
    pub fn delayed(&self, lines: &[f64], condition: &OperatingCondition, orders: &Orders) -> Vec<f64> {
        if self.jitter_s == 0.0 && self.spacing_rad == 0.0 {
            return lines.to_vec();
        }
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let OperatingCondition { shaft_hz, sample_rate_hz, .. } = *condition;
        let cage_hz = (orders.ftf * shaft_hz).max(f64::MIN_POSITIVE);
        let place_s = self.spacing_rad / (TAU * cage_hz);
        let balls = orders.balls();
        // Their Fourier series around the cage.
        let cosine = |share: f64| (place_s * (2.0 * share).sqrt(), TAU * random.random::<f64>());
        let cosines: Vec<(f64, f64)> = self.sidebands.of_turns(balls).map(cosine).collect();
        let place = |ball: usize| -> f64 {
            let turn = TAU * ball as f64 / balls as f64;
            let each = (1..).zip(&cosines);
            each.map(|(turns, (size, phase))| size * (f64::from(turns) * turn + phase).cos()).sum()
        };
        let places: Vec<f64> = (0..balls).map(place).collect();
        let tones: [[f64; 2]; TONES] =
            std::array::from_fn(|_| [SETTINGS.wander_hz * random.random::<f64>(), TAU * random.random::<f64>()]);
        let amplitude_s = self.jitter_s * (2.0 / TONES as f64).sqrt();
        let delay_s = |time_s: f64| {
            let pass = time_s * cage_hz * balls as f64;
            let (ball, share) = (pass as usize, pass.fract());
            let [last, next] = [0, 1].map(|ahead| places[(ball + ahead) % balls]);
            let wander: f64 = tones.iter().map(|[hz, phase]| (TAU * hz * time_s + phase).cos()).sum();
            // As great between two passes as at one.
            let place = ((1.0 - share) * last + share * next) / (1.0 - share).hypot(share);
            place + amplitude_s * wander
        };
        let interpolator = Interpolator::new();
        let of =
            |n: usize| interpolator.at(n as f64 + sample_rate_hz * delay_s(n as f64 / sample_rate_hz), held(lines));
        (0..lines.len()).map(of).collect()
    }
}

#[cfg(test)]
pub mod testing {
    use super::*;
    use crate::diagnose::spectral::observation::Observation;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::effect::{EffectKind, ParameterKey};
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{EffectEntry, simulate};

    /// Nominal rig with a pit in its outer race.
    pub fn pitted() -> Rig {
        let pit = [(ParameterKey::DepthM, 1e-6), (ParameterKey::WidthRad, 0.04), (ParameterKey::AngleRad, 1.5)];
        nominal().with_effect(EffectEntry::new(EffectKind::OuterRaceDefect, &pit))
    }

    /// Recording of a rig, 1 s, whose balls pass as a point of one recording says.
    pub fn observed(rig: &Rig, load_n: f64, point: &Point) -> Observation {
        let condition = condition(30.0, load_n, 25_600);
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let mut run = simulate(rig, &condition, &Start::seeded(load_n as u64)).unwrap();
        let imperfections = Imperfections::of(point, 0, 5);
        for channel in &mut run.channels {
            channel.samples = imperfections.delayed(&channel.samples, &condition, &orders);
        }
        Observation::new(&Observed::from_recording(&run).unwrap())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::test_support::{condition, nominal};

    /// Passes that come early and late, as the rotation wanders or by their place in the cage, take the share of a line's power that
    /// (93) says.
    #[test]
    fn invariant_delays_take_the_share_of_a_line_that_the_likelihood_says() {
        let condition = condition(30.0, 500.0, 65_536);
        let orders = nominal().bearing().unwrap().bearing.geometry().orders();
        let (hz, cage_hz) = (700.0, orders.ftf * 30.0);
        let turns = |n: usize| TAU * hz * n as f64 / condition.sample_rate_hz;
        let tone: Vec<f64> = (0..condition.samples).map(|n| turns(n).cos()).collect();
        let coherent = |jitter_s: f64, spacing_rad: f64| {
            let of = |seed: u64| {
                let (form_m, stretch, sidebands) = ([0.0; FORMS], Stretch::default(), Sidebands::default());
                let made = Imperfections { jitter_s, spacing_rad, sidebands, form_m, stretch, seed };
                let made = made.delayed(&tone, &condition, &orders);
                let sum = |wave: fn(f64) -> f64| made.iter().enumerate().map(|(n, v)| wave(turns(n)) * v).sum::<f64>();
                (2.0 / tone.len() as f64).powi(2) * (sum(f64::cos).powi(2) + sum(f64::sin).powi(2))
            };
            (0..30).map(of).sum::<f64>() / 30.0
        };
        assert!((coherent(0.0, 0.0) - 1.0).abs() < 1e-3);
        let said = |phase: f64| (-phase * phase).exp();
        let (jitter_s, spacing_rad) = (2e-4, 0.02);
        let (wandering, uneven) = (coherent(jitter_s, 0.0), coherent(0.0, spacing_rad));
        assert!((wandering - said(TAU * hz * jitter_s)).abs() < 0.1, "{wandering}");
        // A few balls, of which each passes often.
        assert!((uneven - said(hz / cage_hz * spacing_rad)).abs() < 0.2, "{uneven}");
    }
}
