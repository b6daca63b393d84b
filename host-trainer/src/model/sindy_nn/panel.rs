//! Dense kernels over panels.
//!
//! A panel is a matrix of features × samples, a row being one feature of all samples of a block; the
//! lanes of a vector are samples. Weights are scalars that are broadcast. Three products are all a
//! network needs: rows of W·B, the same with Wᵀ, and dot products of rows for the weights' gradients.

use std::ops::Range;

use pulp::{Simd, WithSimd};

use super::real::Real;

/// Rows of a tile, computed at once.
pub const TILE: usize = 8;
/// Vectors of a row computed at once: 8 × 2 accumulators hide the latency of two FMA pipes.
const STRIP: usize = 2;
/// Rows of either side in a block of dot products.
const DOT: usize = 4;

/// A panel whose rows start on cache lines.
#[derive(Clone, Debug)]
pub struct Panel<T> {
    storage: Vec<T>,
    offset: usize,
    rows: usize,
    columns: usize,
}

impl<T: Real> Panel<T> {
    /// Panel of zeros; `columns` must be a multiple of every vector's lanes.
    pub fn new(rows: usize, columns: usize) -> Self {
        const LINE: usize = 64;
        debug_assert!((columns * size_of::<T>()).is_multiple_of(LINE));
        let storage = vec![T::ZERO; rows * columns + LINE / size_of::<T>()];
        let offset = storage.as_ptr().align_offset(LINE).min(LINE / size_of::<T>());
        Self { storage, offset, rows, columns }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// All values, row by row.
    #[inline(always)]
    pub fn values(&self) -> &[T] {
        &self.storage[self.offset..][..self.rows * self.columns]
    }

    /// All values, mutable, row by row.
    #[inline(always)]
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.storage[self.offset..][..self.rows * self.columns]
    }

    /// One row.
    #[inline(always)]
    pub fn row(&self, r: usize) -> &[T] {
        &self.values()[r * self.columns..][..self.columns]
    }

    /// One row, mutable.
    #[inline(always)]
    pub fn row_mut(&mut self, r: usize) -> &mut [T] {
        let columns = self.columns;
        &mut self.values_mut()[r * columns..][..columns]
    }
}

/// A matrix cut into tiles of [`TILE`] rows, each stored column by column, padded with zeros.
#[derive(Clone, Debug, Default)]
pub struct Tiles<T> {
    tiles: Vec<[T; TILE]>,
    columns: usize,
}

impl<T: Real> Tiles<T> {
    /// Packs the matrix whose entry (r, c) is `entry(r, c)`.
    pub fn pack(&mut self, rows: usize, columns: usize, entry: impl Fn(usize, usize) -> T) {
        self.columns = columns;
        self.tiles.clear();
        for first in (0..rows).step_by(TILE) {
            for c in 0..columns {
                let at = |k| if first + k < rows { entry(first + k, c) } else { T::ZERO };
                self.tiles.push(std::array::from_fn(at));
            }
        }
    }

    /// Tile `t`, an array of [`TILE`] rows for each column.
    #[inline(always)]
    pub fn tile(&self, t: usize) -> &[[T; TILE]] {
        self.columns(t, 0..self.columns)
    }

    /// Some columns of tile `t`.
    #[inline(always)]
    pub fn columns(&self, t: usize, chosen: Range<usize>) -> &[[T; TILE]] {
        &self.tiles[t * self.columns..][..self.columns][chosen]
    }
}

/// Computes out (rows of one tile, `columns` wide) = tile · B, or += with `accumulate`.
///
/// B's rows are `b[k · columns ..]`. `out` may have fewer rows than a tile.
#[inline(always)]
pub fn multiply<S: Simd, T: Real>(
    simd: S,
    tile: &[[T; TILE]],
    b: &[T],
    columns: usize,
    out: &mut [T],
    accumulate: bool,
) {
    simd.vectorize(Multiply { tile, b, columns, out, accumulate });
}

/// Arguments of [`multiply`]: a type of its own, so that the kernel is compiled once per instruction set.
struct Multiply<'a, T> {
    tile: &'a [[T; TILE]],
    b: &'a [T],
    columns: usize,
    out: &'a mut [T],
    accumulate: bool,
}

impl<T: Real> WithSimd for Multiply<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { tile, b, columns, out, accumulate } = self;
        let width = columns / T::lanes::<S>();
        let b = T::vectors::<S>(b);
        let out = T::vectors_mut::<S>(out);
        let mut first = 0;
        while first + STRIP <= width {
            strip::<S, T, STRIP>(simd, tile, b, width, first, out, accumulate);
            first += STRIP;
        }
        while first < width {
            strip::<S, T, 1>(simd, tile, b, width, first, out, accumulate);
            first += 1;
        }
    }
}

#[inline(always)]
fn strip<S: Simd, T: Real, const W: usize>(
    simd: S,
    tile: &[[T; TILE]],
    b: &[T::V<S>],
    width: usize,
    first: usize,
    out: &mut [T::V<S>],
    accumulate: bool,
) {
    let mut sums = [[T::splat(simd, T::ZERO); W]; TILE];
    if accumulate {
        for (sums, row) in sums.iter_mut().zip(out.chunks_exact(width)) {
            sums.copy_from_slice(&row[first..first + W]);
        }
    }
    for (weights, row) in tile.iter().zip(b.chunks_exact(width)) {
        let row: &[T::V<S>; W] = row[first..first + W].try_into().expect("W vectors");
        for (sums, weight) in sums.iter_mut().zip(weights) {
            let weight = T::splat(simd, *weight);
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum = T::mul_add(simd, weight, *value, *sum);
            }
        }
    }
    for (sums, row) in sums.iter().zip(out.chunks_exact_mut(width)) {
        row[first..first + W].copy_from_slice(sums);
    }
}

/// Dot products out\[i · stride + j\] = a_i · b_j of all rows of `a` and `b`.
#[inline(always)]
pub fn dots<S: Simd, T: Real>(simd: S, a: &[T], b: &[T], columns: usize, out: &mut [T], stride: usize) {
    simd.vectorize(Dots { a, b, columns, out, stride });
}

/// Arguments of [`dots`].
struct Dots<'a, T> {
    a: &'a [T],
    b: &'a [T],
    columns: usize,
    out: &'a mut [T],
    stride: usize,
}

impl<T: Real> WithSimd for Dots<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { a, b, columns, out, stride } = self;
        let width = columns / T::lanes::<S>();
        let (a, b) = (T::vectors::<S>(a), T::vectors::<S>(b));
        let (rows_a, rows_b) = (a.len() / width, b.len() / width);
        let (full_a, full_b) = (rows_a - rows_a % DOT, rows_b - rows_b % DOT);
        for i in (0..full_a).step_by(DOT) {
            for j in (0..full_b).step_by(DOT) {
                let sums = dot_block::<S, T>(simd, &a[i * width..], &b[j * width..], width);
                for (k, sums) in sums.iter().enumerate() {
                    let out = &mut out[(i + k) * stride + j..][..DOT];
                    for (out, sum) in out.iter_mut().zip(sums) {
                        *out = T::sum(simd, *sum);
                    }
                }
            }
        }
        // The edges, row by row.
        for i in 0..rows_a {
            for j in if i < full_a { full_b } else { 0 }..rows_b {
                let (a, b) = (&a[i * width..][..width], &b[j * width..][..width]);
                let zero = T::splat(simd, T::ZERO);
                let sum = a.iter().zip(b).fold(zero, |sum, (a, b)| T::mul_add(simd, *a, *b, sum));
                out[i * stride + j] = T::sum(simd, sum);
            }
        }
    }
}

/// Lane sums of the products of four rows with four rows.
#[inline(always)]
fn dot_block<S: Simd, T: Real>(simd: S, a: &[T::V<S>], b: &[T::V<S>], width: usize) -> [[T::V<S>; DOT]; DOT] {
    let mut sums = [[T::splat(simd, T::ZERO); DOT]; DOT];
    for (a, b) in four_rows(a, width).zip(four_rows(b, width)) {
        for (sums, a) in sums.iter_mut().zip(a) {
            for (sum, b) in sums.iter_mut().zip(b) {
                *sum = T::mul_add(simd, *a, *b, *sum);
            }
        }
    }
    sums
}

/// Columns of four rows; zipped, so that one bounds check serves all.
#[inline(always)]
fn four_rows<V>(rows: &[V], width: usize) -> impl Iterator<Item = [&V; DOT]> {
    let row = |k: usize| rows[k * width..][..width].iter();
    row(0).zip(row(1)).zip(row(2).zip(row(3))).map(|((a, b), (c, d))| [a, b, c, d])
}

/// Sum of the values.
#[inline(always)]
pub fn total<S: Simd, T: Real>(simd: S, values: &[T]) -> T {
    let zero = T::splat(simd, T::ZERO);
    T::sum(simd, T::vectors::<S>(values).iter().fold(zero, |sum, v| T::add(simd, sum, *v)))
}
