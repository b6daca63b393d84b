//! Training of a rival: Adam, early stop and learning rate by the validation part.

use candle_core::{DType, Device, Result, Tensor, Var};
use candle_nn::{AdamW, Optimizer, ParamsAdamW, VarBuilder, VarMap, loss};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::network::Network;
use super::settings::SETTINGS;
use super::windows::Windows;
use super::{Parts, Rival, RivalScores};

/// Tensors of windows.
struct Data {
    inputs: Tensor,
    targets: Tensor,
}

impl Data {
    fn new(windows: &Windows) -> Result<Self> {
        let (count, cpu) = (windows.len(), &Device::Cpu);
        Ok(Self {
            inputs: Tensor::from_slice(&windows.inputs, (count, SETTINGS.window, windows.channels), cpu)?,
            targets: Tensor::from_slice(&windows.targets, (count, windows.outputs), cpu)?,
        })
    }
}

/// Network with its parameters.
pub(super) struct Model {
    pub(super) network: Network,
    parameters: Vec<Var>,
}

impl Model {
    /// Parameters drawn from `seed`, uniform within ±1/√(inputs of a unit), as PyTorch draws them.
    pub(super) fn new(rival: Rival, windows: &Windows, seed: u64) -> Result<Self> {
        let map = VarMap::new();
        let builder = VarBuilder::from_varmap(&map, DType::F32, &Device::Cpu);
        let network = Network::new(rival, windows.channels, windows.outputs, builder)?;
        let mut named: Vec<(String, Var)> = match map.data().lock() {
            Ok(data) => data.iter().map(|(name, var)| (name.clone(), var.clone())).collect(),
            Err(_) => Vec::new(),
        };
        named.sort_by(|a, b| a.0.cmp(&b.0));
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (name, var) in &named {
            let (count, shape) = (var.elem_count(), var.dims().to_vec());
            let bound = 1.0 / ((count / shape[0]).max(SETTINGS.width) as f32).sqrt();
            let values: Vec<f32> = match (name.contains("norm"), name.ends_with("weight")) {
                (true, is_weight) => vec![f32::from(u8::from(is_weight)); count],
                (false, _) => (0..count).map(|_| rng.random_range(-bound..bound)).collect(),
            };
            var.set(&Tensor::from_vec(values, shape, &Device::Cpu)?)?;
        }
        Ok(Self { network, parameters: named.into_iter().map(|(_, var)| var).collect() })
    }

    fn error(&self, data: &Data) -> Result<f64> {
        Ok(loss::mse(&self.network.forward(&data.inputs)?.detach(), &data.targets)?.to_scalar::<f32>()?.into())
    }

    fn kept(&self) -> Result<Vec<Tensor>> {
        self.parameters.iter().map(|var| var.as_tensor().copy()).collect()
    }

    fn restore(&self, kept: &[Tensor]) -> Result<()> {
        self.parameters.iter().zip(kept).try_for_each(|(var, kept)| var.set(kept))
    }

    /// Trains until the validation error has not fallen for some epochs; restores the best parameters, and returns their error.
    fn train(&self, parts: [&Data; 2], learning_rate: f64, seed: u64) -> Result<f64> {
        let [train, validation] = parts;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let options = ParamsAdamW { lr: learning_rate, weight_decay: 0.0, ..ParamsAdamW::default() };
        let mut optimizer = AdamW::new(self.parameters.clone(), options)?;
        let mut order: Vec<u32> = (0..train.inputs.dim(0)? as u32).collect();
        let (mut best, mut kept, mut since) = (self.error(validation)?, self.kept()?, 0);
        for _ in 0..SETTINGS.epochs {
            order.shuffle(&mut rng);
            for chosen in order.chunks(SETTINGS.batch) {
                let chosen = Tensor::from_slice(chosen, chosen.len(), &Device::Cpu)?;
                let (x, y) = (train.inputs.index_select(&chosen, 0)?, train.targets.index_select(&chosen, 0)?);
                optimizer.backward_step(&loss::mse(&self.network.forward(&x)?, &y)?)?;
            }
            let error = self.error(validation)?;
            since += 1;
            if error < best {
                (best, kept, since) = (error, self.kept()?, 0);
            }
            if since >= SETTINGS.patience || !error.is_finite() {
                break;
            }
        }
        self.restore(&kept)?;
        Ok(best)
    }

    /// Predictions for windows.
    fn predict(&self, data: &Data) -> Result<Vec<f32>> {
        self.network.forward(&data.inputs)?.flatten_all()?.to_vec1()
    }
}

/// Trains a rival at each learning rate and scores the one of the least validation error.
///
/// # Errors
/// Errors of the framework.
pub fn train(rival: Rival, parts: &Parts, seed: u64) -> Result<RivalScores> {
    // Two threads in a product of matrices this small cost five times what they save; jobs run side by side instead.
    gemm::set_threading_threshold(usize::MAX);
    let [train, validation, held_out] = [&parts.train, &parts.validation, &parts.held_out].map(Data::new);
    let (train, validation, held_out) = (train?, validation?, held_out?);
    let mut best: Option<(f64, Model)> = None;
    for learning_rate in SETTINGS.learning_rates {
        let model = Model::new(rival, &parts.train, seed)?;
        let error = model.train([&train, &validation], learning_rate, seed)?;
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, model));
        }
    }
    let Some((_, model)) = best else { candle_core::bail!("no learning rate") };
    Ok(RivalScores {
        in_sample: parts.train.r_squared(&model.predict(&train)?),
        validation: parts.validation.r_squared(&model.predict(&validation)?),
        held_out: parts.held_out.r_squared(&model.predict(&held_out)?),
        parameters: model.parameters.iter().map(|var| var.elem_count()).sum(),
    })
}
