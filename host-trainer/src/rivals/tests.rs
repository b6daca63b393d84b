//! What each network must learn, must not learn, and must not see.

use candle_core::{Device, Tensor};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::network::Network;
use super::settings::SETTINGS;
use super::training::Model;
use super::windows::{self, Windows, linear_r_squared};
use super::{Parts, Rival, Task, score};
use crate::model::fit::{FitConfig, Split};
use crate::recording::input::Series;

const ALL: [Rival; 3] = [Rival::Lstm, Rival::Tcn, Rival::PatchTransformer];

fn split(sample: impl FnMut(usize) -> f32) -> Split {
    let samples = (0..800).map(sample).collect();
    Split::holding_out(&[Series { name: "made".into(), samples }], 5, FitConfig::default().spec.warm_up())
}

/// Network of one channel and one output, before its training.
fn network(rival: Rival) -> Network {
    Model::new(rival, &Windows { channels: 1, outputs: 1, ..Windows::default() }, 1).unwrap().network
}

#[test]
fn literature_each_learns_the_next_sample_of_a_sine_and_the_same_twice() {
    let sine = split(|t| (0.4 * t as f32).sin());
    for rival in ALL {
        let first = score(rival, &sine, Task::NextSample, 1).unwrap();
        assert!(first.held_out > 0.99 && first.parameters > 1000, "{rival:?}: {first:?}");
        if rival == Rival::Lstm {
            assert_eq!(score(rival, &sine, Task::NextSample, 1).unwrap(), first);
        }
    }
}

#[test]
fn null_none_predicts_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let noise = split(|_| rng.random_range(-1.0..1.0));
    for rival in ALL {
        let found = score(rival, &noise, Task::NextSample, 1).unwrap();
        assert!(found.held_out < 0.05, "{rival:?}: {found:?}");
    }
}

#[test]
fn invariant_the_last_step_of_a_tcn_sees_the_whole_window() {
    // Samples back: two convolutions a block.
    const { assert!(1 + 2 * (SETTINGS.kernel - 1) * ((1 << SETTINGS.blocks) - 1) >= SETTINGS.window) };
    let network = network(Rival::Tcn);
    let window = |changed: Option<usize>| {
        let values: Vec<f32> =
            (0..SETTINGS.window).map(|t| (t as f32).sin() + if Some(t) == changed { 1.0 } else { 0.0 }).collect();
        let x = Tensor::from_vec(values, (1, SETTINGS.window, 1), &Device::Cpu).unwrap();
        network.forward(&x).unwrap().flatten_all().unwrap().to_vec1::<f32>().unwrap()[0]
    };
    assert!((0..SETTINGS.window).all(|t| window(Some(t)) != window(None)));
}

/// A window ends before its target, and a prediction depends on its own window alone.
#[test]
fn invariant_later_samples_do_not_change_an_earlier_prediction() {
    let count = 60;
    let series = |changed: usize| {
        let sample = |t: usize| (t as f32).sin() + if t >= changed { 1.0 } else { 0.0 };
        vec![Series { name: "made".into(), samples: (0..count).map(sample).collect() }]
    };
    let (as_it_is, changed_from) = (series(count), 40);
    let held_out = |changed| windows::of_signals([&as_it_is, &as_it_is, &series(changed)])[2].clone();
    let (own, changed) = (held_out(count), held_out(changed_from));
    // The last window that ends before the change has the first changed sample for its target.
    let same = changed_from - SETTINGS.window + 1;
    for rival in ALL {
        let network = network(rival);
        let predicted = |windows: &Windows| {
            let shape = (windows.len(), SETTINGS.window, 1);
            let x = Tensor::from_slice(&windows.inputs, shape, &Device::Cpu).unwrap();
            network.forward(&x).unwrap().flatten_all().unwrap().to_vec1::<f32>().unwrap()
        };
        let (own, changed) = (predicted(&own), predicted(&changed));
        assert_eq!(own[..same], changed[..same], "{rival:?}");
        assert!(own[same..].iter().zip(&changed[same..]).all(|(a, b)| a != b), "{rival:?}");
    }
}

/// Two rows of the states hold all samples of the first derivative, so that a window explains it exactly.
#[test]
fn invariant_the_derivatives_of_noise_are_a_subtraction_within_a_window() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let noise = split(|_| rng.random_range(-1.0..1.0));
    let parts = Parts::new(&noise, Task::Derivatives(FitConfig::default().spec));
    let [in_sample, held_out] = linear_r_squared(&parts.train, &parts.held_out).unwrap();
    assert!(in_sample > 0.999 && held_out > 0.999, "{in_sample} {held_out}");
}
