//! Loss and gradient of a batch: blocks in parallel, added up in an order that does not depend on the number of
//! threads, and so bit-identical.

use pulp::Arch;
use rayon::prelude::*;

use super::gradient::{Block, Lambdas, Losses, Packed, Pass, SparsityNorm};
use super::layout::Layout;
use super::real::Real;
use super::settings::EngineSettings;
use crate::model::samples::Samples;

const BLOCK: usize = EngineSettings::DEFAULT.block;

/// Memory and weights in kernel form for batches of any size.
pub struct Engine<T> {
    layout: Layout,
    arch: Arch,
    packed: Packed<T>,
    blocks: Vec<Block<T>>,
    /// Gradient of the last batch.
    pub gradient: Vec<T>,
}

impl<T: Real> Engine<T> {
    /// Engine for batches of up to `batch` samples.
    pub fn new(layout: Layout, batch: usize) -> Self {
        let blocks = (0..batch.div_ceil(BLOCK)).map(|_| Block::new(&layout, BLOCK)).collect();
        let gradient = vec![T::ZERO; layout.parameter_count()];
        Self { layout, arch: Arch::new(), packed: Packed::default(), blocks, gradient }
    }

    /// Sizes and parameter layout.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Largest batch, samples.
    pub fn capacity(&self) -> usize {
        self.blocks.len() * BLOCK
    }

    /// Losses of the samples `chosen` (at most [`Engine::capacity`]), theory (13); stores the gradient of the total
    /// loss, theory (14), in [`Engine::gradient`]. A coefficient of Ξ that is exactly zero is masked: L_reg skips it.
    pub fn evaluate(&mut self, parameters: &[T], samples: &Samples<T>, chosen: &[u32], lambdas: Lambdas) -> Losses {
        self.packed.pack(&self.layout, parameters);
        let batch = chosen.len();
        let blocks = &mut self.blocks[..batch.div_ceil(BLOCK)];
        let (layout, packed, arch) = (&self.layout, &self.packed, self.arch);
        blocks.par_iter_mut().zip(chosen.par_chunks(BLOCK)).with_max_len(1).for_each(|(block, chosen)| {
            block.fill(chosen.iter().map(|s| samples.row(*s as usize)));
            arch.dispatch(Pass { layout, packed, lambdas, batch, block });
        });
        let mut losses = Losses::default();
        self.gradient.fill(T::ZERO);
        for block in blocks {
            losses.add(&block.losses);
            arch.dispatch(|| self.gradient.iter_mut().zip(&block.gradient).for_each(|(sum, g)| *sum += *g));
        }
        let xi = self.layout.xi();
        let count = match lambdas.norm {
            SparsityNorm::Mean => xi.len() as f64,
            SparsityNorm::Sum => 1.0,
        };
        for (value, gradient) in parameters[xi.clone()].iter().zip(&mut self.gradient[xi]) {
            let value = value.to_f64();
            if value != 0.0 {
                losses.sparsity += value.abs() / count;
                *gradient = T::from_f64(gradient.to_f64() + lambdas.sparsity * value.signum() / count);
            }
        }
        losses
    }
}
