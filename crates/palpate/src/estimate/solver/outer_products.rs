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
        // As many sums at a time as the registers hold, each in as many parts as make eight lanes of it.
        match S::F64_LANES {
            LANES => self.across::<S, 4, 1>(simd),
            4 => self.across::<S, 2, 2>(simd),
            2 => self.across::<S, 2, 4>(simd),
            _ => self.across::<S, 2, LANES>(simd),
        }
    }
}

impl Tiles<'_> {
    /// Every sum is one of eight lanes, whatever a register holds, so that processors of different widths find the same bits.
    #[inline(always)]
    fn across<S: Simd, const ACROSS: usize, const PARTS: usize>(self, simd: S) {
        let Self { columns, width, rows, room, count } = self;
        let element = |index: usize| S::as_simd_f64s(&rows[index * room..index * room + count]).0;
        for column in (0..width).step_by(ACROSS) {
            let across: [&[S::f64s]; ACROSS] = std::array::from_fn(|j| element(column + j));
            for row in (column / TILE * TILE..width).step_by(TILE) {
                let along: [&[S::f64s]; TILE] = std::array::from_fn(|i| &element(row + i)[..across[0].len()]);
                let mut sums = [[[simd.splat_f64s(0.0); TILE]; ACROSS]; PARTS];
                for (part, sums) in sums.iter_mut().enumerate() {
                    for lanes in (part..across[0].len()).step_by(PARTS) {
                        for (sums, across) in sums.iter_mut().zip(&across) {
                            for (sum, along) in sums.iter_mut().zip(&along) {
                                *sum = simd.mul_add_e_f64s(across[lanes], along[lanes], *sum);
                            }
                        }
                    }
                }
                for j in 0..ACROSS {
                    for i in 0..TILE {
                        // Halves are added to halves, as one register adds its own.
                        let mut parts: [S::f64s; PARTS] = std::array::from_fn(|part| sums[part][j][i]);
                        let mut half = PARTS / 2;
                        while half > 0 {
                            for part in 0..half {
                                parts[part] = simd.add_f64s(parts[part], parts[part + half]);
                            }
                            half /= 2;
                        }
                        columns[(column + j) * width + row + i] += simd.reduce_sum_f64s(parts[0]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of 26 bits, whose products are exact, so that fused and separate operations agree; sums of them are rounded.
    fn number(seed: usize) -> f64 {
        let bits = (seed as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 38;
        (bits as f64 - 2f64.powi(25)) * 2f64.powi(-(seed as i32 % 40))
    }

    #[test]
    fn every_processor_adds_in_the_same_order() {
        const UNKNOWNS: usize = 6;
        const BLOCKS: usize = 7;
        let element =
            |block: usize, index: usize| Lanes(std::array::from_fn(|lane| number(97 * block + 8 * index + lane)));
        let mut sum = OuterProducts::new(UNKNOWNS, BLOCKS * LANES);
        for block in 0..BLOCKS {
            sum.push_block(UNKNOWNS, element(block, UNKNOWNS), |index| element(block, index));
        }
        let (matrix, gradient) = sum.finish(UNKNOWNS);
        // In eight lanes, of which halves are added to halves.
        let expected = |i: usize, j: usize| {
            let mut lanes = [0.0; LANES];
            for block in 0..BLOCKS {
                let (a, b) = (element(block, i).0, element(block, j).0);
                lanes.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
            }
            let [a, b, c, d] = std::array::from_fn(|lane| lanes[lane] + lanes[lane + 4]);
            (a + c) + (b + d)
        };
        for i in 0..UNKNOWNS {
            assert_eq!(gradient[i].to_bits(), expected(i, UNKNOWNS).to_bits());
            for j in 0..UNKNOWNS {
                assert_eq!(matrix[(i, j)].to_bits(), expected(i, j).to_bits());
            }
        }
    }
}
