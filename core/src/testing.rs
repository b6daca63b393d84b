//! Test model: small, with every part in use.

extern crate std;
use std::vec::Vec;

use crate::dynamics::{Dynamics, TERM_WORDS, encode_term};
use crate::input_check::ScreenConfig;
use crate::library::{Library, Term};
use crate::model::{Input, Model, Scaling};
use crate::monitor::MonitorConfig;
use crate::network::{Arithmetic, Network, fixed, float::word_count, to_fixed};
use crate::states::StateSpec;
use crate::{Floats, Word};

/// A smooth made-up acceleration without repeated values.
pub fn samples(count: usize) -> Vec<f32> {
    (0..count).map(|i| (i as f32 * 0.37).sin() + 0.3 * (i as f32 * 1.9).cos()).collect()
}

/// Owned storage of a [`Model`].
pub struct Parts {
    spec: StateSpec,
    /// Whether the states are given rather than streamed.
    pub direct: bool,
    scales: [Vec<Word>; 5],
    encoder: (Vec<u16>, Vec<Word>),
    decoder: (Vec<u16>, Vec<Word>),
    arithmetic: [Arithmetic; 2],
    library: Library,
    terms: Vec<[Word; TERM_WORDS]>,
    ends: Vec<Word>,
    equations: Vec<Word>,
    coefficients: Vec<Word>,
}

impl Parts {
    pub fn new(spec: StateSpec) -> Self {
        let n = spec.dimension;
        let values = |count: usize, seed: f32, offset: f32| -> Vec<Word> {
            (0..count).map(|i| (offset + 0.4 * (i as f32 * 1.7 + seed).sin()).to_le_bytes()).collect()
        };
        let latent = 2;
        let library = Library::new(latent, 3, 2).unwrap();
        let (up, down) = (std::vec![n as u16, 11, latent as u16], std::vec![latent as u16, 9, n as u16]);
        let used = [0, 1, 4, 7, 11, 15];
        Self {
            spec,
            direct: false,
            scales: [
                values(n, 0.0, 0.0),
                values(n, 1.0, 1.0),
                values(n, 3.0, 0.0),
                values(n, 2.0, 1.0),
                values(n, 4.0, 1.0),
            ],
            encoder: (up.clone(), values(word_count(&up), 5.0, 0.0)),
            decoder: (down.clone(), values(word_count(&down), 6.0, 0.0)),
            arithmetic: [Arithmetic::Float; 2],
            library,
            terms: used.iter().map(|&i| encode_term(library.term(i).unwrap())).collect(),
            ends: (1..=used.len() as u32).map(|i| (2 * i).to_le_bytes()).collect(),
            equations: (0..2 * used.len() as u32).map(|i| (i % 2).to_le_bytes()).collect(),
            coefficients: values(2 * used.len(), 7.0, 0.0),
        }
    }

    /// The same parts with two powers in the library, in place of its last two terms.
    pub fn with_powers(mut self) -> Self {
        self.library = self.library.with_powers(true);
        let terms = [Term::Power { variable: 1 }, Term::OddPower { variable: 0 }].map(encode_term);
        let kept = self.terms.len() - terms.len();
        self.terms.truncate(kept);
        self.terms.extend(terms);
        self
    }

    /// The same parts with networks in these arithmetics.
    pub fn with_arithmetic(mut self, arithmetic: [Arithmetic; 2]) -> Self {
        for ((widths, words), arithmetic) in [&mut self.encoder, &mut self.decoder].into_iter().zip(arithmetic) {
            if arithmetic == Arithmetic::Fixed {
                let mut fixed = std::vec![Word::default(); fixed::word_count(widths).unwrap()];
                to_fixed(&Network::new(widths, Arithmetic::Float, words).unwrap(), &mut fixed).unwrap();
                *words = fixed;
            }
        }
        self.arithmetic = arithmetic;
        self
    }

    /// First scale (2) or mean (3) of the derivatives.
    pub fn scale(&self, which: usize) -> f32 {
        let array = if which == 2 { &self.scales[3] } else { &self.scales[2] };
        f32::from_le_bytes(array[0])
    }

    pub fn model(&self) -> Model<'_> {
        let [mean, scale, d_mean, d_scale, spread] = self.scales.each_ref().map(|words| Floats(words));
        Model::new(Model {
            sample_rate_hz: 25_600.0,
            input: if self.direct { Input::Direct(self.spec.dimension) } else { Input::VirtualStates(self.spec) },
            states: Scaling { mean, scale },
            derivatives: Scaling { mean: d_mean, scale: d_scale },
            encoder: Network::new(&self.encoder.0, self.arithmetic[0], &self.encoder.1).unwrap(),
            decoder: Network::new(&self.decoder.0, self.arithmetic[1], &self.decoder.1).unwrap(),
            library: self.library,
            dynamics: Dynamics {
                terms: &self.terms,
                ends: &self.ends,
                equations: &self.equations,
                coefficients: Floats(&self.coefficients),
            },
            residual_spread: spread,
            screen: ScreenConfig { full_scale: 50.0, stuck_after: 8 },
            monitor: MonitorConfig::new(32, 0.0, 0.2),
        })
        .unwrap()
    }
}
