//! The normal matrix as a sum of outer products of rows (a symmetric rank-k update), in tiles that the registers hold.

use crate::math::lanes::{LANES, Lanes};
use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

/// The sum of outer products of rows, each with its residual as the last element: the normal matrix, and in its last row the
/// gradient. Only the lower triangle (and a little above it) is kept.
pub(crate) struct OuterProducts {
    /// Length of a row with its residual, filled up to whole tiles.
    width: usize,
    /// Rows not yet added, element by element: first the first elements of all rows, then the second ones.
    waiting: Vec<f64>,
    /// Capacity in rows.
    room: usize,
    filled: usize,
    columns: Vec<f64>,
}

/// Rows that are added at a time at most: each element of the sum is read and written once for all of them.
const BATCH: usize = 24 * LANES;

/// Elements of the sum that are computed together, along a column.
const TILE: usize = 4;

impl OuterProducts {
    /// For about `rows` rows (more may be added) of `unknowns` elements and a residual each.
    pub fn new(unknowns: usize, rows: usize) -> Self {
        let width = (unknowns + 1).next_multiple_of(TILE);
        let room = rows.next_multiple_of(LANES).clamp(LANES, BATCH);
        Self { width, waiting: vec![0.0; room * width], room, filled: 0, columns: vec![0.0; width * width] }
    }

    /// Adds the rows of eight samples: `element` gives one element of all of them; the residuals come last.
    #[inline(always)]
    pub fn push_block(&mut self, unknowns: usize, residuals: Lanes, mut element: impl FnMut(usize) -> Lanes) {
        let (filled, room) = (self.filled, self.room);
        for (index, waiting) in self.waiting.chunks_exact_mut(room).take(unknowns).enumerate() {
            waiting[filled..filled + LANES].copy_from_slice(&element(index).0);
        }
        self.waiting[unknowns * room + filled..][..LANES].copy_from_slice(&residuals.0);
        self.filled += LANES;
        if self.filled == room {
            self.flush();
        }
    }

    /// Adds another sum over rows of the same length.
    pub fn add(&mut self, mut other: Self) {
        other.flush();
        self.columns.iter_mut().zip(other.columns).for_each(|(sum, other)| *sum += other);
    }

    fn flush(&mut self) {
        Arch::new().dispatch(Tiles {
            columns: &mut self.columns,
            width: self.width,
            rows: &self.waiting,
            room: self.room,
            count: self.filled,
        });
        self.filled = 0;
    }

    /// The matrix, and the gradient.
    pub fn finish(mut self, unknowns: usize) -> (DMatrix<f64>, DVector<f64>) {
        self.flush();
        let at = |row: usize, column: usize| self.columns[column * self.width + row];
        let matrix = DMatrix::from_fn(unknowns, unknowns, |row, column| at(row.max(column), row.min(column)));
        (matrix, DVector::from_fn(unknowns, |column, _| at(unknowns, column)))
    }
}

/// Adds the outer products of the first `count` rows to the lower triangle of a matrix, given by its columns.
struct Tiles<'a> {
    columns: &'a mut [f64],
    width: usize,
    rows: &'a [f64],
    room: usize,
    count: usize,
}

impl WithSimd for Tiles<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // As many sums at a time as the registers hold.
        if S::F64_LANES < LANES { self.across::<S, 2>(simd) } else { self.across::<S, 4>(simd) }
    }
}

impl Tiles<'_> {
    #[inline(always)]
    fn across<S: Simd, const ACROSS: usize>(self, simd: S) {
        let Self { columns, width, rows, room, count } = self;
        let element = |index: usize| S::as_simd_f64s(&rows[index * room..index * room + count]).0;
        for column in (0..width).step_by(ACROSS) {
            let across: [&[S::f64s]; ACROSS] = std::array::from_fn(|j| element(column + j));
            for row in (column / TILE * TILE..width).step_by(TILE) {
                let along: [&[S::f64s]; TILE] = std::array::from_fn(|i| &element(row + i)[..across[0].len()]);
                let mut sums = [[simd.splat_f64s(0.0); TILE]; ACROSS];
                for lanes in 0..across[0].len() {
                    for (sums, across) in sums.iter_mut().zip(&across) {
                        for (sum, along) in sums.iter_mut().zip(&along) {
                            *sum = simd.mul_add_e_f64s(across[lanes], along[lanes], *sum);
                        }
                    }
                }
                for (j, sums) in sums.into_iter().enumerate() {
                    for (i, sum) in sums.into_iter().enumerate() {
                        columns[(column + j) * width + row + i] += simd.reduce_sum_f64s(sum);
                    }
                }
            }
        }
    }
}
