//! Rows of the normal equations, eight samples in step: derivatives of height and offset by the coefficients of the shape, sums of outer products, and
//! squares of whitened rows. A sample is a row of its matrix, an unknown a column, so that eight samples lie side by side.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use crate::estimate::model::contact::supports;
use crate::estimate::solver::outer_products::OuterProducts;
use crate::math::lanes::{LANES, Lanes, Number, sin_cos};

/// Writes the derivatives of shares of r(θ) and d(θ) by (a₀, a₁ … a_K, b₁ … b_K) to the first columns of matrices, each of shares of its own.
pub(super) fn fill_curve_rows<const MATRICES: usize>(
    matrices: [&mut DMatrix<f64>; MATRICES],
    shares: [&[[f64; 2]]; MATRICES],
    order: usize,
    theta_rad: &[f64],
) {
    Arch::new().dispatch(Filling { matrices: matrices.map(|matrix| matrix.as_mut_slice()), shares, order, theta_rad });
}

/// The sum of w wᵀ over all rows w of these matrices, and that of w times its residual.
pub(super) fn sums_of_outer_products(
    parts: &[(&DMatrix<f64>, &[f64])],
    unknowns: usize,
) -> (DMatrix<f64>, DVector<f64>) {
    Arch::new().dispatch(Adding { parts, unknowns }).finish(unknowns)
}

/// |L⁻¹w|² of each row w, for a lower triangle L.
pub(super) fn whitened_squares(rows: &DMatrix<f64>, lower: &DMatrix<f64>) -> Vec<f64> {
    Arch::new().dispatch(Whitening { rows, lower })
}

/// Eight rows from one on, element by element: beyond the last row there is nothing.
#[inline(always)]
fn eight(column: &[f64], first: usize) -> Lanes {
    let rest = &column[first..];
    match rest.first_chunk() {
        Some(lanes) => Lanes(*lanes),
        None => Lanes::from_fn(|lane| rest.get(lane).copied().unwrap_or(0.0)),
    }
}

struct Filling<'a, const MATRICES: usize> {
    matrices: [&'a mut [f64]; MATRICES],
    shares: [&'a [[f64; 2]]; MATRICES],
    order: usize,
    theta_rad: &'a [f64],
}

impl<const MATRICES: usize> WithSimd for Filling<'_, MATRICES> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { mut matrices, shares, order, theta_rad } = self;
        // Only the waves are wanted.
        let none = vec![0.0; 2 * order + 1];
        let samples = theta_rad.len();
        for (block, theta_rad) in theta_rad.chunks(LANES).enumerate() {
            let (sin, cos) = sin_cos(Lanes::loaded(theta_rad));
            let first = block * LANES;
            let shares = shares.map(|shares| {
                let of_lane = |lane: usize| shares.get(first + lane);
                [0, 1].map(|which| Lanes::from_fn(|lane| of_lane(lane).map_or(0.0, |shares| shares[which])))
            });
            let mut write = |matrix: usize, column: usize, values: Lanes| {
                let place = &mut matrices[matrix][column * samples + first..][..theta_rad.len()];
                match place.first_chunk_mut() {
                    Some(eight) => *eight = values.0,
                    None => place.iter_mut().zip(values.0).for_each(|(element, value)| *element = value),
                }
            };
            for (matrix, [r_share, _]) in shares.iter().enumerate() {
                write(matrix, 0, *r_share);
            }
            supports(&none, [cos], [sin], |index, [cos], [sin]| {
                for (matrix, [r_share, d_share]) in shares.iter().enumerate() {
                    let k_share = *d_share * (index + 1) as f64;
                    write(matrix, index + 1, *r_share * cos + k_share * sin);
                    write(matrix, order + index + 1, *r_share * sin - k_share * cos);
                }
            });
        }
    }
}

struct Adding<'a> {
    parts: &'a [(&'a DMatrix<f64>, &'a [f64])],
    unknowns: usize,
}

impl WithSimd for Adding<'_> {
    type Output = OuterProducts;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> OuterProducts {
        let Self { parts, unknowns } = self;
        let rows = parts.iter().map(|(matrix, _)| matrix.nrows()).sum();
        let mut sums = OuterProducts::new(unknowns, rows);
        for (matrix, residuals) in parts {
            let (elements, samples) = (matrix.as_slice(), matrix.nrows());
            for first in (0..samples).step_by(LANES) {
                sums.push_block(unknowns, eight(residuals, first), |index| {
                    eight(&elements[index * samples..(index + 1) * samples], first)
                });
            }
        }
        sums
    }
}

struct Whitening<'a> {
    rows: &'a DMatrix<f64>,
    lower: &'a DMatrix<f64>,
}

impl WithSimd for Whitening<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let Self { rows, lower } = self;
        let (elements, samples, unknowns) = (rows.as_slice(), rows.nrows(), rows.ncols());
        // The rows of the triangle one after another.
        let triangle: Vec<f64> =
            (0..unknowns).flat_map(|row| (0..=row).map(move |column| lower[(row, column)])).collect();
        let mut whitened = vec![Lanes::ZERO; unknowns];
        let mut squares = Vec::with_capacity(samples + LANES);
        for first in (0..samples).step_by(LANES) {
            let mut sum = Lanes::ZERO;
            for index in 0..unknowns {
                let row = &triangle[index * (index + 1) / 2..][..=index];
                let mut left = eight(&elements[index * samples..(index + 1) * samples], first);
                for (value, factor) in whitened.iter().zip(&row[..index]) {
                    left = left - *value * *factor;
                }
                whitened[index] = left * (1.0 / row[index]);
                sum = sum + whitened[index] * whitened[index];
            }
            squares.extend(sum.0);
        }
        squares.truncate(samples);
        squares
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pivot::smoother::curve_row;

    #[test]
    fn eight_samples_are_as_each_of_them() {
        for samples in [1, LANES, 2 * LANES + 3] {
            let theta: Vec<f64> = (0..samples).map(|index| 1.7 * index as f64 - 9.0).collect();
            let shares: Vec<[f64; 2]> = (0..samples).map(|index| [1.0 + index as f64, 0.3 - index as f64]).collect();
            let others: Vec<[f64; 2]> = shares.iter().map(|[r, d]| [-d, 2.0 * r]).collect();
            let mut matrices = [(); 2].map(|()| DMatrix::repeat(samples, 9, 5.0));
            fill_curve_rows(matrices.each_mut(), [&shares, &others], 3, &theta);
            for (matrix, shares) in matrices.iter().zip([shares, others]) {
                for (row, (theta, shares)) in matrix.row_iter().zip(theta.iter().zip(&shares)) {
                    let alone = curve_row(*theta, 3, *shares).transpose();
                    assert!((row.columns(0, 7) - alone).norm() < 1e-12 && row[7] == 5.0 && row[8] == 5.0);
                }
            }
        }
    }

    #[test]
    fn sums_are_those_of_products_of_matrices() {
        let of = |samples: usize, from: f64| DMatrix::from_fn(samples, 5, |j, i| (from + (3 * i + 7 * j) as f64).sin());
        let (first, second) = (of(19, 0.2), of(8, 1.1));
        let residuals: [Vec<f64>; 2] = [19, 8].map(|count| (0..count).map(|index| f64::from(index).cos()).collect());
        let (matrix, vector) = sums_of_outer_products(&[(&first, &residuals[0]), (&second, &residuals[1])], 5);
        let expected = first.transpose() * &first + second.transpose() * &second;
        let [left, right] = residuals.map(DVector::from_vec);
        let gradient = first.transpose() * left + second.transpose() * right;
        assert!((matrix - expected).norm() < 1e-12 && (vector - gradient).norm() < 1e-12);
    }

    #[test]
    fn whitened_rows_are_those_of_forward_substitution() {
        let rows = DMatrix::from_fn(11, 4, |i, j| ((2 * i + 5 * j) as f64).sin());
        let lower =
            DMatrix::from_fn(
                4,
                4,
                |i, j| {
                    if i == j { 1.5 } else { f64::from(u8::from(i > j)) * ((i + 3 * j) as f64).cos() }
                },
            );
        let squares = whitened_squares(&rows, &lower);
        assert_eq!(squares.len(), 11);
        for (row, square) in rows.row_iter().zip(squares) {
            let solved = lower.solve_lower_triangular(&row.transpose()).expect("a diagonal");
            assert!((solved.norm_squared() - square).abs() < 1e-12);
        }
    }
}
