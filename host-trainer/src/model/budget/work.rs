//! Work of a sample: how often the device does what, from the sizes of a model.

use ballrace_core::dynamics::decode_term;
use ballrace_core::library::Term;
use ballrace_core::model::{Input, Model};
use ballrace_core::network::float::PANEL;
use ballrace_core::network::{Arithmetic, Network, fixed};
use ballrace_core::states::{Alignment, Estimator, StateSpec};
use serde::Serialize;

/// Stage of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Check of the sample.
    Screen,
    /// Virtual states.
    States,
    /// Encoder, without its activation.
    Encoder,
    /// Sigmoids of encoder and decoder.
    Activation,
    /// Candidate functions.
    Library,
    /// The sum over Ξ.
    Xi,
    /// Derivative of the decoder, without its activation.
    Decoder,
    /// Residual, blocks, limit.
    Monitor,
    /// All else: scaling, prediction of the next sample, the loop over the samples.
    Other,
}

impl Stage {
    /// Stages in the order of a sample.
    pub const ALL: [Self; 9] = [
        Self::Screen,
        Self::States,
        Self::Encoder,
        Self::Activation,
        Self::Library,
        Self::Xi,
        Self::Decoder,
        Self::Monitor,
        Self::Other,
    ];

    /// Name in tables and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Screen => "screen",
            Self::States => "states",
            Self::Encoder => "encoder",
            Self::Activation => "activation",
            Self::Library => "library",
            Self::Xi => "xi",
            Self::Decoder => "decoder",
            Self::Monitor => "monitor",
            Self::Other => "other",
        }
    }
}

macro_rules! works {
    ($($(#[$doc:meta])* $name:ident: $stage:ident,)*) => {
        /// Kind of work.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Work {
            $($(#[$doc])* $name,)*
        }

        impl Work {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$name,)*];

            /// Stage that the work belongs to.
            pub const fn stage(self) -> Stage {
                match self {
                    $(Self::$name => Stage::$stage,)*
                }
            }
        }
    };
}

works! {
    /// Check of a sample.
    ScreenSample: Screen,
    /// Sample taken by finite differences.
    DifferencesSample: States,
    /// Order of difference.
    DifferencesOrder: States,
    /// State with its target, by differences.
    DifferencesState: States,
    /// Value that goes through a delay line.
    DifferencesDelay: States,
    /// Sample taken by the Kalman filter.
    KalmanSample: States,
    /// State by the Kalman filter.
    KalmanState: States,
    /// Sample taken by Savitzky–Golay windows.
    WindowSample: States,
    /// State by a window.
    WindowState: States,
    /// Sample of a window.
    WindowTap: States,
    /// State of a causal model at the newest sample.
    CausalState: States,
    /// Layer of the encoder.
    EncoderLayer: Encoder,
    /// Output of a layer.
    EncoderOutput: Encoder,
    /// Panel of outputs.
    EncoderPanel: Encoder,
    /// Step of a full panel over one input.
    EncoderPanelStep: Encoder,
    /// Step of a last, narrower panel over one input.
    EncoderNarrowStep: Encoder,
    /// Multiply-add of such a step.
    EncoderNarrowMultiplyAdd: Encoder,
    /// Encoder in fixed point.
    FixedEncoder: Encoder,
    /// Input of it, made an integer.
    FixedEncoderInput: Encoder,
    /// Word of weights of its hidden layer.
    FixedEncoderWord: Encoder,
    /// Two hidden units on a group of outputs.
    FixedEncoderProduct: Encoder,
    /// Output.
    FixedEncoderOutput: Encoder,
    /// Sigmoid.
    Sigmoid: Activation,
    /// Sigmoid in fixed point.
    FixedSigmoid: Activation,
    /// Monomial.
    Monomial: Library,
    /// Factor of a monomial.
    Factor: Library,
    /// Sine or cosine.
    Sine: Library,
    /// Even power.
    Power: Library,
    /// Odd power.
    OddPower: Library,
    /// Sum over Ξ.
    XiSample: Xi,
    /// Term used.
    XiTerm: Xi,
    /// Nonzero coefficient.
    XiCoefficient: Xi,
    /// Layer of the decoder.
    DecoderLayer: Decoder,
    /// Output of a layer.
    DecoderOutput: Decoder,
    /// Hidden unit: value and tangent.
    DecoderHidden: Decoder,
    /// Panel of outputs.
    DecoderPanel: Decoder,
    /// Step of a full panel over one input.
    DecoderPanelStep: Decoder,
    /// Step of a last, narrower panel over one input.
    DecoderNarrowStep: Decoder,
    /// Multiply-add of such a step.
    DecoderNarrowMultiplyAdd: Decoder,
    /// Decoder in fixed point.
    FixedDecoder: Decoder,
    /// Input of it, made an integer with its rate.
    FixedDecoderInput: Decoder,
    /// Word of weights of its hidden layer.
    FixedDecoderWord: Decoder,
    /// Two hidden units on a group of outputs.
    FixedDecoderProduct: Decoder,
    /// Output.
    FixedDecoderOutput: Decoder,
    /// Sample taken by the monitor.
    MonitorSample: Monitor,
    /// Residual of a derivative.
    MonitorResidual: Monitor,
    /// Sample, outside of all other stages.
    OtherSample: Other,
    /// State and derivative scaled.
    OtherState: Other,
    /// Prediction of the next sample.
    NextSample: Other,
}

/// Work of a sample that the model is evaluated for.
pub fn work(model: &Model<'_>) -> Vec<(Work, f64)> {
    let inputs = model.input.len();
    let mut all = vec![
        (Work::ScreenSample, 1),
        (Work::MonitorSample, 1),
        (Work::MonitorResidual, inputs),
        (Work::OtherSample, 1),
        (Work::OtherState, inputs),
    ];
    if let Input::VirtualStates(spec) = model.input {
        all.extend(of_states(spec));
    }
    let networks = [&model.encoder, &model.decoder];
    let [in_encoder, in_decoder] = networks.map(FixedSizes::of);
    all.extend(match &in_encoder {
        Some(sizes) => vec![
            (Work::FixedEncoder, 1),
            (Work::FixedEncoderInput, sizes.inputs),
            (Work::FixedEncoderWord, sizes.words),
            (Work::FixedEncoderProduct, sizes.products),
            (Work::FixedEncoderOutput, sizes.outputs),
        ],
        None => of_encoder(&model.encoder).to_vec(),
    });
    let sigmoids = |network: &&Network<'_>| if FixedSizes::of(network).is_none() { network.sigmoids() } else { 0 };
    all.push((Work::Sigmoid, networks.iter().map(sigmoids).sum()));
    all.push((Work::FixedSigmoid, [&in_encoder, &in_decoder].into_iter().flatten().map(|sizes| sizes.units).sum()));
    all.extend(of_library(model));
    all.extend(match &in_decoder {
        Some(sizes) => vec![
            (Work::FixedDecoder, 1),
            (Work::FixedDecoderInput, sizes.inputs),
            (Work::FixedDecoderWord, sizes.words),
            (Work::FixedDecoderProduct, sizes.products),
            (Work::FixedDecoderOutput, sizes.outputs),
        ],
        None => of_decoder(&model.decoder).to_vec(),
    });
    let counted = |(work, count): (Work, usize)| (count > 0).then_some((work, count as f64));
    all.into_iter().filter_map(counted).collect()
}

fn of_states(spec: StateSpec) -> Vec<(Work, usize)> {
    let dimension = spec.dimension;
    let highest = spec.orders.highest(dimension);
    let causal = spec.alignment == Alignment::Causal;
    let mut all = vec![(Work::CausalState, if causal { dimension } else { 0 }), (Work::NextSample, causal.into())];
    match spec.estimator {
        Estimator::Differences => all.extend([
            (Work::DifferencesSample, 1),
            (Work::DifferencesOrder, highest + 1),
            (Work::DifferencesState, dimension),
            (Work::DifferencesDelay, delayed(spec)),
        ]),
        Estimator::Kalman { .. } => all.extend([(Work::KalmanSample, 1), (Work::KalmanState, dimension)]),
        Estimator::SavitzkyGolay { excess, stretch } => {
            let window = |i: usize| ((spec.orders.state(i) + usize::from(excess) + 1) as f32 * stretch).ceil() as usize;
            all.extend([
                (Work::WindowSample, 1),
                (Work::WindowState, dimension - 1),
                (Work::WindowTap, (1..dimension).map(window).sum()),
            ]);
        }
    }
    all
}

/// Number of values that go through a delay line: those that do not need the newest sample.
fn delayed(spec: StateSpec) -> usize {
    let highest = spec.orders.highest(spec.dimension);
    let delay = |order: usize, target: bool| match spec.alignment {
        Alignment::Forward => highest - order,
        Alignment::Half => highest.div_ceil(2) - order.div_ceil(2),
        Alignment::Causal => usize::from(!target),
    };
    let orders = (0..spec.dimension).map(|i| spec.orders.state(i));
    orders.flat_map(|order| [delay(order, false), delay(order + 1, true)]).filter(|delay| *delay > 0).count()
}

/// Sizes of a network in fixed point.
struct FixedSizes {
    inputs: usize,
    /// Hidden units, an even number.
    units: usize,
    words: usize,
    products: usize,
    outputs: usize,
}

impl FixedSizes {
    /// `None` in single precision.
    fn of(network: &Network<'_>) -> Option<Self> {
        let (&[inputs, hidden, outputs], Arithmetic::Fixed) = (network.widths(), network.arithmetic()) else {
            return None;
        };
        let (inputs, outputs) = (usize::from(inputs), usize::from(outputs));
        let units = usize::from(hidden).next_multiple_of(2);
        let products = outputs.div_ceil(fixed::GROUP) * units / 2;
        Some(Self { inputs, units, words: units * fixed::pairs(inputs), products, outputs })
    }
}

/// Work of products with the weights of a layer.
#[derive(Default)]
struct Products {
    panels: usize,
    panel_steps: usize,
    narrow_steps: usize,
    narrow_multiply_adds: usize,
}

impl Products {
    fn add(&mut self, inputs: usize, outputs: usize, times: usize) {
        let narrow = outputs % PANEL;
        self.panels += times * (outputs / PANEL);
        self.panel_steps += times * (outputs / PANEL) * inputs;
        self.narrow_steps += if narrow > 0 { times * inputs } else { 0 };
        self.narrow_multiply_adds += times * narrow * inputs;
    }
}

fn layers(network: &Network<'_>) -> impl ExactSizeIterator<Item = (usize, usize)> {
    network.widths().windows(2).map(|w| (usize::from(w[0]), usize::from(w[1]))).collect::<Vec<_>>().into_iter()
}

fn of_encoder(network: &Network<'_>) -> [(Work, usize); 6] {
    let mut products = Products::default();
    layers(network).for_each(|(inputs, outputs)| products.add(inputs, outputs, 1));
    [
        (Work::EncoderLayer, layers(network).len()),
        (Work::EncoderOutput, layers(network).map(|(_, outputs)| outputs).sum()),
        (Work::EncoderPanel, products.panels),
        (Work::EncoderPanelStep, products.panel_steps),
        (Work::EncoderNarrowStep, products.narrow_steps),
        (Work::EncoderNarrowMultiplyAdd, products.narrow_multiply_adds),
    ]
}

fn of_decoder(network: &Network<'_>) -> [(Work, usize); 7] {
    let mut products = Products::default();
    let last = layers(network).len().saturating_sub(1);
    // Hidden layers carry value and tangent, the last only the tangent.
    layers(network).enumerate().for_each(|(n, (inputs, outputs))| {
        products.add(inputs, outputs, if n == last { 1 } else { 2 });
    });
    [
        (Work::DecoderLayer, layers(network).len()),
        (Work::DecoderOutput, layers(network).map(|(_, outputs)| outputs).sum()),
        (Work::DecoderHidden, network.sigmoids()),
        (Work::DecoderPanel, products.panels),
        (Work::DecoderPanelStep, products.panel_steps),
        (Work::DecoderNarrowStep, products.narrow_steps),
        (Work::DecoderNarrowMultiplyAdd, products.narrow_multiply_adds),
    ]
}

fn of_library(model: &Model<'_>) -> [(Work, usize); 8] {
    let dynamics = &model.dynamics;
    let (mut monomials, mut factors, mut sines, mut powers, mut odd_powers) = (0, 0, 0, 0, 0);
    for term in dynamics.terms.iter().filter_map(|code| decode_term(code, &model.library)) {
        match term {
            Term::Monomial(monomial) => {
                monomials += 1;
                factors += monomial.factors().len();
            }
            Term::Sin { .. } | Term::Cos { .. } => sines += 1,
            Term::Power { .. } => powers += 1,
            Term::OddPower { .. } => odd_powers += 1,
        }
    }
    [
        (Work::Monomial, monomials),
        (Work::Factor, factors),
        (Work::Sine, sines),
        (Work::Power, powers),
        (Work::OddPower, odd_powers),
        (Work::XiSample, 1),
        (Work::XiTerm, dynamics.terms.len()),
        (Work::XiCoefficient, dynamics.coefficients.len()),
    ]
}
