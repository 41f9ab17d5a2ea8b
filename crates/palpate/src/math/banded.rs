//! Symmetric positive definite matrices with a narrow band: the normal equations of a spline, or of a motion with its second differences.

use crate::math::lanes::LANES;

/// Entries of a row of the band: those of a quintic spline reach five coefficients further than the diagonal.
const OF_SPLINE: usize = 6;

/// The lower triangle of a banded matrix: with a band of `ROW` entries, row i has the columns i + 1 − `ROW` to i, those below 0 are not used.
#[derive(Clone, Debug)]
pub(crate) struct Banded<const ROW: usize = OF_SPLINE> {
    rows: Vec<[f64; ROW]>,
}

impl<const ROW: usize> Banded<ROW> {
    /// Entries beside the diagonal.
    const HALF_BANDWIDTH: usize = ROW - 1;

    /// The zero matrix with so many rows.
    pub fn zeros(rows: usize) -> Self {
        Self { rows: vec![[0.0; ROW]; rows] }
    }

    /// Adds `weight` v vᵀ, where v has these entries from row `first` on.
    pub fn add_outer_product(&mut self, first: usize, v: &[f64; ROW], weight: f64) {
        for (i, vi) in v.iter().enumerate() {
            let row = &mut self.rows[first + i];
            let scaled = weight * vi;
            for (j, vj) in v[..=i].iter().enumerate() {
                row[Self::HALF_BANDWIDTH + j - i] += scaled * vj;
            }
        }
    }

    /// Adds to the entries of the diagonal.
    pub fn add_diagonal(&mut self, entries: impl Iterator<Item = f64>) {
        self.rows.iter_mut().zip(entries).for_each(|(row, entry)| row[Self::HALF_BANDWIDTH] += entry);
    }

    /// Adds `weight` times another matrix.
    pub fn add(&mut self, weight: f64, other: &Self) {
        for (row, others) in self.rows.iter_mut().zip(&other.rows) {
            row.iter_mut().zip(others).for_each(|(entry, by)| *entry += weight * by);
        }
    }

    /// Multiplies all by a weight.
    pub fn scale(&mut self, weight: f64) {
        self.rows.iter_mut().flatten().for_each(|entry| *entry *= weight);
    }

    /// The entry at row i and column j, which are no further apart than the band reaches.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        let (low, high) = (i.min(j), i.max(j));
        self.rows[high][Self::HALF_BANDWIDTH + low - high]
    }

    /// vᵀ times the matrix times v, where v has these entries from row `first` on.
    pub fn quadratic(&self, first: usize, v: &[f64; ROW]) -> f64 {
        let entries = v.iter().enumerate().flat_map(|a| v.iter().enumerate().map(move |b| (a, b)));
        entries.map(|((i, vi), (j, vj))| vi * vj * self.at(first + i, first + j)).sum()
    }

    /// The trace of the product with another symmetric matrix, of which only the band matters.
    pub fn trace_of_product(&self, other: impl Fn(usize, usize) -> f64) -> f64 {
        let of_row = |(i, row): (usize, &[f64; ROW])| {
            let below: f64 = (i.saturating_sub(Self::HALF_BANDWIDTH)..i)
                .map(|j| row[Self::HALF_BANDWIDTH + j - i] * other(i, j))
                .sum();
            2.0 * below + row[Self::HALF_BANDWIDTH] * other(i, i)
        };
        self.rows.iter().enumerate().map(of_row).sum()
    }

    /// Changes the entries of the diagonal.
    pub fn map_diagonal(&mut self, change: impl Fn(f64) -> f64) {
        self.rows.iter_mut().for_each(|row| row[Self::HALF_BANDWIDTH] = change(row[Self::HALF_BANDWIDTH]));
    }

    /// The Cholesky factor; `None` where the matrix is not positive definite.
    pub fn cholesky(mut self) -> Option<BandedCholesky<ROW>> {
        for i in 0..self.rows.len() {
            for j in i.saturating_sub(Self::HALF_BANDWIDTH)..=i {
                let mut sum = self.rows[i][Self::HALF_BANDWIDTH + j - i];
                for k in i.saturating_sub(Self::HALF_BANDWIDTH)..j {
                    let reaches = k + Self::HALF_BANDWIDTH >= j;
                    if reaches {
                        sum -= self.rows[i][Self::HALF_BANDWIDTH + k - i] * self.rows[j][Self::HALF_BANDWIDTH + k - j];
                    }
                }
                self.rows[i][Self::HALF_BANDWIDTH + j - i] = if j < i {
                    sum / self.rows[j][Self::HALF_BANDWIDTH]
                } else if sum > 0.0 && sum.is_finite() {
                    sum.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(BandedCholesky { rows: self.rows })
    }
}

/// L of L Lᵀ.
#[derive(Clone, Debug)]
pub(crate) struct BandedCholesky<const ROW: usize = OF_SPLINE> {
    rows: Vec<[f64; ROW]>,
}

impl<const ROW: usize> BandedCholesky<ROW> {
    /// Entries beside the diagonal.
    const HALF_BANDWIDTH: usize = ROW - 1;

    /// Replaces right-hand sides, `columns` of them side by side in each row, by L⁻¹ times them.
    pub fn solve_lower(&self, sides: &mut [f64], columns: usize) {
        for (i, row) in self.rows.iter().enumerate() {
            let (above, here) = sides.split_at_mut(i * columns);
            let here = &mut here[..columns];
            for j in i.saturating_sub(Self::HALF_BANDWIDTH)..i {
                let factor = row[Self::HALF_BANDWIDTH + j - i];
                let there = &above[j * columns..(j + 1) * columns];
                here.iter_mut().zip(there).for_each(|(here, there)| *here -= factor * there);
            }
            let scale = 1.0 / row[Self::HALF_BANDWIDTH];
            here.iter_mut().for_each(|value| *value *= scale);
        }
    }

    /// The same of right-hand sides that lie one after another, eight of them in step.
    pub fn solve_lower_stacked(&self, sides: &mut [f64]) {
        if !self.rows.is_empty() {
            sides.chunks_mut(LANES * self.rows.len()).for_each(|eight| self.solve_lower_eight(eight));
        }
    }

    /// Up to eight of them.
    fn solve_lower_eight(&self, sides: &mut [f64]) {
        let mut sides: Vec<&mut [f64]> = sides.chunks_exact_mut(self.rows.len()).collect();
        let mut before = [[0.0; LANES]; ROW];
        for (i, row) in self.rows.iter().enumerate() {
            let mut here = [0.0; LANES];
            here.iter_mut().zip(&sides).for_each(|(here, side)| *here = side[i]);
            let scale = 1.0 / row[Self::HALF_BANDWIDTH];
            for (factor, before) in row.iter().zip(&before[1..]) {
                here.iter_mut().zip(before).for_each(|(here, before)| *here -= factor * before);
            }
            here.iter_mut().for_each(|value| *value *= scale);
            sides.iter_mut().zip(here).for_each(|(side, here)| side[i] = here);
            before.rotate_left(1);
            before[Self::HALF_BANDWIDTH] = here;
        }
    }

    /// [`solve_lower`](Self::solve_lower) with (Lᵀ)⁻¹.
    pub fn solve_upper(&self, sides: &mut [f64], columns: usize) {
        for i in (0..self.rows.len()).rev() {
            let (before, after) = sides.split_at_mut((i + 1) * columns);
            let here = &mut before[i * columns..];
            for j in i + 1..(i + Self::HALF_BANDWIDTH + 1).min(self.rows.len()) {
                let factor = self.rows[j][Self::HALF_BANDWIDTH + i - j];
                let there = &after[(j - i - 1) * columns..(j - i) * columns];
                here.iter_mut().zip(there).for_each(|(here, there)| *here -= factor * there);
            }
            let scale = 1.0 / self.rows[i][Self::HALF_BANDWIDTH];
            here.iter_mut().for_each(|value| *value *= scale);
        }
    }

    /// The inverse of the matrix within the band, by the recursion of Takahashi, Fagan and Chen (1973).
    pub fn inverse_in_band(&self) -> Banded<ROW> {
        let rows = self.rows.len();
        let mut inverse = Banded::zeros(rows);
        for i in (0..rows).rev() {
            let below = i + 1..(i + Self::HALF_BANDWIDTH + 1).min(rows);
            let scale = 1.0 / self.rows[i][Self::HALF_BANDWIDTH];
            for j in (i..below.end).rev() {
                let sum: f64 =
                    below.clone().map(|k| self.rows[k][Self::HALF_BANDWIDTH + i - k] * inverse.at(k, j)).sum();
                let of_factor = if j == i { scale } else { 0.0 };
                inverse.rows[j][Self::HALF_BANDWIDTH + i - j] = scale * (of_factor - sum);
            }
        }
        inverse
    }

    /// ln of the determinant of the matrix.
    pub fn ln_determinant(&self) -> f64 {
        2.0 * self.rows.iter().map(|row| row[Self::HALF_BANDWIDTH].ln()).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    const ROWS: usize = 12;
    const HALF_BANDWIDTH: usize = OF_SPLINE - 1;

    /// A matrix as a band, and in full.
    fn both() -> (Banded, DMatrix<f64>) {
        let (mut banded, mut full): (Banded, _) = (Banded::zeros(ROWS), DMatrix::zeros(ROWS, ROWS));
        for first in 0..ROWS - HALF_BANDWIDTH {
            for which in 0..3 {
                let v: [f64; 6] =
                    std::array::from_fn(|i| (1.3 * (first + 7 * which) as f64 + 0.8 * (i * i) as f64).sin());
                banded.add_outer_product(first, &v, 0.5 + which as f64);
                let mut row = DVector::zeros(ROWS);
                row.rows_mut(first, 6).copy_from_slice(&v);
                full += (0.5 + which as f64) * &row * row.transpose();
            }
        }
        banded.map_diagonal(|entry| entry + 0.1);
        (banded, full + 0.1 * DMatrix::identity(ROWS, ROWS))
    }

    #[test]
    fn a_band_is_solved_as_the_full_matrix_is() {
        let (banded, full) = both();
        let sides = DMatrix::from_fn(ROWS, 2, |i, j| (i as f64 - 3.0 * j as f64).cos());
        let expected = full.clone().cholesky().expect("positive definite").solve(&sides);
        let factor = banded.cholesky().expect("positive definite");
        let mut found: Vec<f64> = sides.row_iter().flat_map(|row| [row[0], row[1]]).collect();
        factor.solve_lower(&mut found, 2);
        factor.solve_upper(&mut found, 2);
        for (i, pair) in found.chunks_exact(2).enumerate() {
            assert!((pair[0] - expected[(i, 0)]).abs() < 1e-12 && (pair[1] - expected[(i, 1)]).abs() < 1e-12);
        }
        let (inverse, whole) =
            (factor.inverse_in_band(), full.clone().cholesky().expect("positive definite").inverse());
        for i in 0..ROWS {
            for j in i.saturating_sub(HALF_BANDWIDTH)..=i {
                assert!((inverse.at(i, j) - whole[(i, j)]).abs() < 1e-12);
            }
        }
        assert!((factor.ln_determinant() - full.determinant().ln()).abs() < 1e-10);
    }

    #[test]
    fn sides_one_after_another_are_as_side_by_side() {
        let factor = both().0.cholesky().expect("positive definite");
        for columns in [1, LANES, LANES + 3] {
            let sides = DMatrix::from_fn(ROWS, columns, |i, j| (2.0 * i as f64 - 3.0 * j as f64).cos());
            let mut beside: Vec<f64> = sides.transpose().as_slice().to_vec();
            factor.solve_lower(&mut beside, columns);
            let mut stacked: Vec<f64> = sides.as_slice().to_vec();
            factor.solve_lower_stacked(&mut stacked);
            let off = |i: usize, j: usize| stacked[j * ROWS + i] - beside[i * columns + j];
            assert!((0..ROWS * columns).all(|index| off(index / columns, index % columns).abs() < 1e-12));
        }
    }

    #[test]
    fn what_is_not_positive_definite_has_no_factor() {
        let (mut banded, _) = both();
        banded.map_diagonal(|entry| entry - 10.0);
        assert!(banded.cholesky().is_none());
    }
}
