//! The harness's `prepare` and `kernel` in Rust: a network of `ballrace-core`, plain nalgebra, or burn.
#![no_std]

use core::cell::UnsafeCell;

include!(concat!(env!("OUT_DIR"), "/sizes.rs"));

/// Memory of a single core without interrupts.
struct Static<T>(UnsafeCell<T>);

// SAFETY: the harness has one thread and no interrupt handler.
unsafe impl<T> Sync for Static<T> {}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

#[cfg(any(feature = "float", feature = "fixed"))]
mod ours {
    use super::*;
    use ballrace_core::network::{Arithmetic, Network};

    #[repr(C, align(4))]
    struct Aligned<T: ?Sized>(T);

    #[cfg(feature = "float")]
    static WORDS: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/float.bin")));
    #[cfg(feature = "fixed")]
    static WORDS: &Aligned<[u8]> = &Aligned(*include_bytes!(concat!(env!("OUT_DIR"), "/fixed.bin")));
    const ARITHMETIC: Arithmetic = if cfg!(feature = "fixed") { Arithmetic::Fixed } else { Arithmetic::Float };
    const SCRATCH: usize = if cfg!(feature = "fixed") { HIDDEN.div_ceil(2) } else { 2 * HIDDEN };

    static NETWORK: Static<Option<Network<'static>>> = Static(UnsafeCell::new(None));
    static MEMORY: Static<[f32; SCRATCH]> = Static(UnsafeCell::new([0.0; SCRATCH]));

    #[unsafe(no_mangle)]
    extern "C" fn prepare() {
        let widths = [INPUTS as u16, HIDDEN as u16, OUTPUTS as u16];
        // Opaque, or the compiler folds the sizes into the kernel.
        let words = core::hint::black_box(&WORDS.0).as_chunks().0;
        // SAFETY: nothing else has a reference.
        unsafe { *NETWORK.0.get() = Network::new(&widths, ARITHMETIC, words) };
    }

    #[unsafe(no_mangle)]
    extern "C" fn kernel(x: &[f32; INPUTS], y: &mut [f32; OUTPUTS]) {
        // SAFETY: only here, and the kernel does not call itself.
        let (network, memory) = unsafe { (&*NETWORK.0.get(), &mut *MEMORY.0.get()) };
        if let Some(network) = network {
            network.forward(x, y, memory);
        }
    }
}

#[cfg(feature = "nalgebra")]
mod plain {
    use super::*;
    use nalgebra::{SMatrix, SVector};

    /// Weights and biases of both layers, column by column.
    #[repr(C)]
    struct Layers {
        up: SMatrix<f32, HIDDEN, INPUTS>,
        up_bias: SVector<f32, HIDDEN>,
        down: SMatrix<f32, OUTPUTS, HIDDEN>,
        down_bias: SVector<f32, OUTPUTS>,
    }

    static LAYERS: Layers = Layers {
        up: SMatrix::from_array_storage(nalgebra::ArrayStorage(UP)),
        up_bias: SVector::from_array_storage(nalgebra::ArrayStorage([UP_BIAS])),
        down: SMatrix::from_array_storage(nalgebra::ArrayStorage(DOWN)),
        down_bias: SVector::from_array_storage(nalgebra::ArrayStorage([DOWN_BIAS])),
    };
    static HELD: Static<SVector<f32, HIDDEN>> =
        Static(UnsafeCell::new(SVector::from_array_storage(nalgebra::ArrayStorage([[0.0; HIDDEN]]))));

    #[unsafe(no_mangle)]
    extern "C" fn prepare() {}

    #[unsafe(no_mangle)]
    extern "C" fn kernel(x: &[f32; INPUTS], y: &mut [f32; OUTPUTS]) {
        let layers = core::hint::black_box(&LAYERS);
        // SAFETY: only here, and the kernel does not call itself.
        let hidden = unsafe { &mut *HELD.0.get() };
        hidden.copy_from(&layers.up_bias);
        hidden.gemv(1.0, &layers.up, &SVector::from_column_slice(x), 1.0);
        hidden.apply(|h| *h = 1.0 / (1.0 + libm::expf(-*h)));
        let mut out = layers.down_bias;
        out.gemv(1.0, &layers.down, hidden, 1.0);
        y.copy_from_slice(out.as_slice());
    }
}

#[cfg(feature = "burn")]
mod tensors {
    use core::mem::MaybeUninit;

    use super::*;
    use burn_tensor::activation::sigmoid;
    use burn_tensor::module::linear;
    use burn_tensor::{Device, Tensor};
    use cortex_m as _; // the critical section of the allocator
    use embedded_alloc::LlffHeap;

    /// Bytes of the heap: both layers, which burn takes from the flash into it, and, by trial, four times the hidden layer and half a
    /// kilobyte for what a pass holds beside them.
    const HEAP: usize = 4 * (INPUTS + 1 + OUTPUTS + 4) * HIDDEN + 512;

    #[global_allocator]
    static ALLOCATOR: LlffHeap = LlffHeap::empty();
    static MEMORY: Static<MaybeUninit<[u8; HEAP]>> = Static(UnsafeCell::new(MaybeUninit::uninit()));

    struct Layers {
        up: Tensor<2>,
        up_bias: Tensor<1>,
        down: Tensor<2>,
        down_bias: Tensor<1>,
    }

    static LAYERS: Static<Option<Layers>> = Static(UnsafeCell::new(None));

    #[unsafe(no_mangle)]
    extern "C" fn prepare() {
        // SAFETY: nothing else has a reference, and the memory is handed over once.
        unsafe { ALLOCATOR.init(MEMORY.0.get() as usize, HEAP) };
        let device = Device::flex();
        let layers = Layers {
            up: Tensor::from_data(UP, &device),
            up_bias: Tensor::from_data(UP_BIAS, &device),
            down: Tensor::from_data(DOWN, &device),
            down_bias: Tensor::from_data(DOWN_BIAS, &device),
        };
        // SAFETY: nothing else has a reference.
        unsafe { *LAYERS.0.get() = Some(layers) };
    }

    #[unsafe(no_mangle)]
    extern "C" fn kernel(x: &[f32; INPUTS], y: &mut [f32; OUTPUTS]) {
        // SAFETY: only here, and the kernel does not call itself.
        let Some(layers) = (unsafe { &*LAYERS.0.get() }) else { return };
        let input = Tensor::<2>::from_data([*x], &layers.up.device());
        let hidden = sigmoid(linear(input, layers.up.clone(), Some(layers.up_bias.clone())));
        let output = linear(hidden, layers.down.clone(), Some(layers.down_bias.clone())).into_data();
        if let Ok(values) = output.as_slice::<f32>() {
            y.copy_from_slice(values);
        }
    }
}
