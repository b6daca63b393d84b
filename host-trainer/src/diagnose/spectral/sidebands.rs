//! Weights of the orders of the cage beside a line: balls that pass unevenly put a line's power there, in all recordings of a machine
//! alike, and to some orders much more than to others.

use super::observation::Observation;
use super::settings::LikelihoodSettings;
use crate::signal::kinematics::Orders;

const SETTINGS: LikelihoodSettings = LikelihoodSettings::DEFAULT;

/// Sums over bins, for each order of the cage beside a line: the part of the mean that is of the order, in shares of the mean, as
/// observed and as expected.
pub type Shares = Vec<[f64; 2]>;

/// Power of each order of the cage beside a line, from the nearest to the middle between two lines, over that of all alike; theory
/// (130).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sidebands {
    /// Weights; none if all are alike.
    weights: Vec<f64>,
}

impl Sidebands {
    /// Weight of the order with a number from the line, of which 0 is the line itself.
    pub fn weight(&self, order: usize) -> f64 {
        order.checked_sub(1).and_then(|index| self.weights.get(index)).copied().unwrap_or(1.0)
    }

    /// −ln of the prior density, less that of all alike. The places of the balls are normal, so that the power of each order is
    /// exponential.
    pub fn prior(&self) -> f64 {
        self.weights.iter().map(|weight| weight - 1.0).sum()
    }

    /// Weights nearer to those that recordings show: where what is observed equals what is expected, they are most probable.
    pub fn towards(&self, shares: &Shares) -> Self {
        let of = |(n, [observed, expected]): (usize, &[f64; 2])| {
            let now = self.weight(n + 1);
            // Less than a bin says little.
            if *expected < 1.0 { now } else { (now * observed / (expected + now)).max(SETTINGS.least_sideband) }
        };
        Self::within(shares.iter().enumerate().map(of).collect())
    }

    /// Weights that are all `by` times as great, as far as they may be; the same if that is no number above 0.
    pub fn scaled(&self, by: f64) -> Self {
        let by = if by.is_normal() { by } else { 1.0 };
        Self::within(self.weights.iter().map(|weight| by * weight).collect())
    }

    /// Weights whose mean is within its range: what uneven balls take from a line is beside it.
    fn within(mut weights: Vec<f64>) -> Self {
        let [least, most] = SETTINGS.mean_sideband;
        let mean = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
        let by = mean.clamp(least, most) / mean.max(f64::MIN_POSITIVE);
        weights.iter_mut().for_each(|weight| *weight *= by);
        Self { weights }
    }

    /// Shares of the variance of the balls' places in the cosines of one turn of the cage, of two, ….
    pub fn of_turns(&self, balls: usize) -> impl Iterator<Item = f64> {
        let of = move |order: usize| {
            let sides = if 2 * order == balls { 1.0 } else { 2.0 };
            sides * self.weight(order) / (balls - 1) as f64
        };
        (1..=balls / 2).map(of)
    }
}

/// Bins from one order of the cage to the next; `None` where they are not told apart.
pub fn cage_bins(observation: &Observation, orders: &Orders) -> Option<f64> {
    let bins = observation.bins_of(orders.ftf);
    (bins > SETTINGS.cage_lobes * SETTINGS.lobe_bins).then_some(bins)
}

/// Number of the order of the cage from the nearest line, of each bin, 0 at a line. Empty where the orders are not told apart.
pub fn numbers(observation: &Observation, orders: &Orders) -> Vec<usize> {
    let Some(period) = cage_bins(observation, orders) else { return Vec::new() };
    let balls = orders.balls();
    let of = |k: usize| {
        let order = (k as f64 / period).round() as usize % balls;
        order.min(balls - order)
    };
    (0..observation.bins().end).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::spectral::data::{Data, Point};
    use crate::diagnose::spectral::fit::Model;
    use crate::diagnose::spectral::imperfect::testing::{observed, pitted};
    use crate::diagnose::spectral::unevenness::UnevenMachines;
    use crate::identify::likelihood::observed::Observed;
    use crate::rig::test_support::{condition, nominal};
    use crate::rig::{Start, simulate};

    /// Fit of a rig with a pit to its recordings, whose balls have places of a standard deviation, by its index in the settings, and of
    /// weights.
    fn fitted(spacing: usize, sidebands: &Sidebands) -> Point {
        let rig = pitted();
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let point = Point { spacing, sidebands: sidebands.clone(), ..Point::default() }.in_recordings(1, 0);
        let observations = [600.0, 700.0].map(|load_n| observed(&rig, load_n, &point));
        let data = Data::new(&observations, orders, UnevenMachines::default());
        let model = Model::fixed(&data, rig);
        model.search(model.start().unwrap(), 8).unwrap()
    }

    /// Of places that vary once around the cage, the lines beside a pit's are one order of the cage away.
    #[test]
    fn invariant_the_orders_of_the_cage_have_the_weights_of_the_balls_places() {
        let made = Sidebands { weights: vec![3.0, 0.1, 0.1, 0.1] };
        let found = fitted(3, &made);
        let beside = |spacing: usize, sidebands: &Sidebands, order: usize| {
            SETTINGS.spacing_rad[spacing].powi(2) * sidebands.weight(order)
        };
        let [first, second] = [1, 2].map(|order| beside(found.spacing, &found.sidebands, order));
        let share = first / beside(3, &made, 1);
        assert!(
            (0.5..2.0).contains(&share) && first > 10.0 * second,
            "{share} {} {:?}",
            found.spacing,
            found.sidebands
        );
    }

    #[test]
    fn null_even_balls_leave_all_orders_alike() {
        let found = fitted(0, &Sidebands::default());
        assert_eq!(found.spacing, 0);
        assert!((1..9).all(|order| found.sidebands.weight(order) == 1.0), "{:?}", found.sidebands);
    }

    #[test]
    fn invariant_the_numbers_of_the_orders_are_counted_from_the_nearest_line() {
        let rig = nominal();
        let run = simulate(&rig, &condition(30.0, 500.0, 25_600), &Start::seeded(1)).unwrap();
        let observation = Observation::new(&Observed::from_recording(&run).unwrap());
        let orders = rig.bearing().unwrap().bearing.geometry().orders();
        let numbers = numbers(&observation, &orders);
        let at = |order: f64| numbers[observation.bins_of(order).round() as usize];
        assert_eq!([-2.0, -1.0, 0.0, 1.0, 2.0].map(|n| at(3.0 * orders.bpfo + n * orders.ftf)), [2, 1, 0, 1, 2]);
        // In a short recording they are one.
        assert_eq!(super::numbers(&observation.beginning(0.2), &orders), Vec::<usize>::new());
    }

    #[test]
    fn invariant_weights_of_places_that_are_alike_share_their_variance() {
        for balls in [1, 2, 8, 9, 40] {
            let all: f64 = Sidebands::default().of_turns(balls).sum();
            assert!(balls == 1 || (all - 1.0).abs() < 1e-12, "{balls} {all}");
        }
    }
}
