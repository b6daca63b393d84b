//! The three networks on candle: [batch, steps, channels] → [batch, outputs].

use candle_core::{D, Result, Tensor};
use candle_nn::{Conv1d, Conv1dConfig, LSTM, LSTMConfig, Linear, Module, RNN, VarBuilder, conv1d, linear, lstm, ops};

use super::Rival;
use super::settings::SETTINGS;

/// A rival's layers.
pub enum Network {
    /// [`Rival::Lstm`]: one layer; its last hidden state is read.
    Lstm(LSTM, Linear),
    /// [`Rival::Tcn`]: residual blocks of two causal dilated convolutions; the last step is read.
    Tcn(Vec<Block>, Linear),
    /// [`Rival::PatchTransformer`]: patches, their places, layers of attention; all patches are read.
    PatchTransformer {
        /// From a patch to the width.
        embedding: Linear,
        /// Patches × width, learned.
        places: Tensor,
        /// Layers.
        layers: Vec<Layer>,
        /// From all patches to the outputs.
        head: Linear,
    },
}

/// Block of a TCN.
pub struct Block {
    convolutions: [Conv1d; 2],
    /// 1 × 1, where the channels differ.
    shortcut: Option<Conv1d>,
    /// Zeros before the first step, so that no step sees a later one.
    padding: usize,
}

/// Layer of a transformer: attention and a feed-forward part, each after a normalisation.
pub struct Layer {
    norms: [Norm; 2],
    queries_keys_values: Linear,
    joined: Linear,
    forward: [Linear; 2],
}

/// Layer normalisation by differentiable steps: candle's own layer has no gradient on the CPU.
struct Norm {
    weight: Tensor,
    bias: Tensor,
}

impl Norm {
    fn new(vb: VarBuilder<'_>) -> Result<Self> {
        Ok(Self { weight: vb.get(SETTINGS.width, "weight")?, bias: vb.get(SETTINGS.width, "bias")? })
    }

    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        ops::layer_norm_slow(x, &self.weight, &self.bias, 1e-5)
    }
}

/// Number of patches of a window.
const PATCHES: usize = (SETTINGS.window - SETTINGS.patch) / SETTINGS.stride + 1;

impl Network {
    /// Layers of a rival, their parameters from `vb`.
    ///
    /// # Errors
    /// Errors of the framework.
    pub fn new(rival: Rival, channels: usize, outputs: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let width = SETTINGS.width;
        Ok(match rival {
            Rival::Lstm => Self::Lstm(
                lstm(channels, width, LSTMConfig::default(), vb.pp("lstm"))?,
                linear(width, outputs, vb.pp("head"))?,
            ),
            Rival::Tcn => {
                let block = |n: usize| Block::new(if n == 0 { channels } else { width }, 1 << n, vb.pp(n));
                Self::Tcn(
                    (0..SETTINGS.blocks).map(block).collect::<Result<_>>()?,
                    linear(width, outputs, vb.pp("head"))?,
                )
            }
            Rival::PatchTransformer => Self::PatchTransformer {
                embedding: linear(SETTINGS.patch * channels, width, vb.pp("embedding"))?,
                places: vb.get((PATCHES, width), "places")?,
                layers: (0..SETTINGS.layers).map(|n| Layer::new(vb.pp(n))).collect::<Result<_>>()?,
                head: linear(PATCHES * width, outputs, vb.pp("head"))?,
            },
        })
    }

    /// Predictions for windows.
    ///
    /// # Errors
    /// Errors of the framework.
    pub fn forward(&self, x: &Tensor) -> Result<Tensor> {
        match self {
            Self::Lstm(lstm, head) => {
                let states = lstm.seq(x)?;
                head.forward(states[states.len() - 1].h())
            }
            Self::Tcn(blocks, head) => {
                let mut x = x.transpose(1, 2)?.contiguous()?;
                for block in blocks {
                    x = block.forward(&x)?;
                }
                head.forward(&x.narrow(D::Minus1, SETTINGS.window - 1, 1)?.squeeze(D::Minus1)?)
            }
            Self::PatchTransformer { embedding, places, layers, head } => {
                let batch = x.dim(0)?;
                let patch = |n: usize| x.narrow(1, n * SETTINGS.stride, SETTINGS.patch)?.flatten_from(1);
                let patches = (0..PATCHES).map(patch).collect::<Result<Vec<_>>>()?;
                let mut x = embedding.forward(&Tensor::stack(&patches, 1)?)?.broadcast_add(places)?;
                for layer in layers {
                    x = layer.forward(&x)?;
                }
                head.forward(&x.reshape((batch, PATCHES * SETTINGS.width))?)
            }
        }
    }
}

impl Block {
    fn new(channels: usize, dilation: usize, vb: VarBuilder<'_>) -> Result<Self> {
        let (width, kernel) = (SETTINGS.width, SETTINGS.kernel);
        let dilated = Conv1dConfig { dilation, ..Conv1dConfig::default() };
        let plain = Conv1dConfig::default();
        Ok(Self {
            convolutions: [
                conv1d(channels, width, kernel, dilated, vb.pp("first"))?,
                conv1d(width, width, kernel, dilated, vb.pp("second"))?,
            ],
            shortcut: (channels != width).then(|| conv1d(channels, width, 1, plain, vb.pp("shortcut"))).transpose()?,
            padding: (kernel - 1) * dilation,
        })
    }

    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let mut y = x.clone();
        for convolution in &self.convolutions {
            y = convolution.forward(&y.pad_with_zeros(D::Minus1, self.padding, 0)?)?.relu()?;
        }
        match &self.shortcut {
            Some(shortcut) => y + shortcut.forward(x)?,
            None => y + x,
        }
    }
}

impl Layer {
    fn new(vb: VarBuilder<'_>) -> Result<Self> {
        let width = SETTINGS.width;
        Ok(Self {
            norms: [Norm::new(vb.pp("norm_attention"))?, Norm::new(vb.pp("norm_forward"))?],
            queries_keys_values: linear(width, 3 * width, vb.pp("queries_keys_values"))?,
            joined: linear(width, width, vb.pp("joined"))?,
            forward: [linear(width, 2 * width, vb.pp("up"))?, linear(2 * width, width, vb.pp("down"))?],
        })
    }

    fn forward(&self, x: &Tensor) -> Result<Tensor> {
        let x = (x + self.attention(&self.norms[0].forward(x)?)?)?;
        let [up, down] = &self.forward;
        let added = down.forward(&up.forward(&self.norms[1].forward(&x)?)?.gelu()?)?;
        x + added
    }

    fn attention(&self, x: &Tensor) -> Result<Tensor> {
        let (batch, patches, width) = x.dims3()?;
        let (heads, size) = (SETTINGS.heads, width / SETTINGS.heads);
        let all = self.queries_keys_values.forward(x)?.reshape((batch, patches, 3, heads, size))?;
        // Each batch × heads × patches × size.
        let part = |n: usize| all.narrow(2, n, 1)?.squeeze(2)?.transpose(1, 2)?.contiguous();
        let (queries, keys, values) = (part(0)?, part(1)?, part(2)?);
        let scores = (queries.matmul(&keys.transpose(2, 3)?.contiguous()?)? / (size as f64).sqrt())?;
        let mixed = ops::softmax(&scores, D::Minus1)?.matmul(&values)?;
        self.joined.forward(&mixed.transpose(1, 2)?.reshape((batch, patches, width))?)
    }
}
