//! Rows of the normal equations, eight samples in step: derivatives of height and offset by the coefficients of the shape, and sums of outer products.
//! A sample is a column of its matrix, so that its row lies in one piece.

use nalgebra::{DMatrix, DVector};
use pulp::{Arch, Simd, WithSimd};

use crate::estimate::model::contact::supports;
use crate::estimate::solver::outer_products::OuterProducts;
use crate::math::lanes::{LANES, Lanes, sin_cos};

/// Writes the derivative of shares of r(θ) and d(θ) by (a₀, a₁ … a_K, b₁ … b_K) to the first rows of each column.
pub(super) fn fill_curve_rows(columns: &mut DMatrix<f64>, order: usize, theta_rad: &[f64], shares: &[[f64; 2]]) {
    let unknowns = columns.nrows();
    if unknowns > 0 {
        Arch::new().dispatch(Filling { columns: columns.as_mut_slice(), unknowns, order, theta_rad, shares });
    }
}

/// The sum of w wᵀ over all columns w of these matrices, and that of w times its residual.
pub(super) fn sums_of_outer_products(
    parts: &[(&DMatrix<f64>, &[f64])],
    unknowns: usize,
) -> (DMatrix<f64>, DVector<f64>) {
    Arch::new().dispatch(Adding { parts, unknowns }).finish(unknowns)
}

struct Filling<'a> {
    columns: &'a mut [f64],
    unknowns: usize,
    order: usize,
    theta_rad: &'a [f64],
    shares: &'a [[f64; 2]],
}

impl WithSimd for Filling<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { columns, unknowns, order, theta_rad, shares } = self;
        // Only the waves are wanted.
        let none = vec![0.0; 2 * order + 1];
        let samples = theta_rad.chunks(LANES).zip(shares.chunks(LANES)).zip(columns.chunks_mut(LANES * unknowns));
        for ((theta_rad, shares), columns) in samples {
            let (sin, cos) = sin_cos(Lanes::loaded(theta_rad));
            let share = |which: usize| Lanes::from_fn(|lane| shares.get(lane).map_or(0.0, |shares| shares[which]));
            let (r_share, d_share) = (share(0), share(1));
            let mut write = |place: usize, values: Lanes| {
                let each = columns.iter_mut().skip(place).step_by(unknowns);
                each.zip(values.0).for_each(|(element, value)| *element = value);
            };
            write(0, r_share);
            supports(&none, [cos], [sin], |index, [cos], [sin]| {
                let k_share = d_share * (index + 1) as f64;
                write(index + 1, r_share * cos + k_share * sin);
                write(order + index + 1, r_share * sin - k_share * cos);
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
        let rows = parts.iter().map(|(columns, _)| columns.ncols()).sum();
        let mut sums = OuterProducts::new(unknowns, rows);
        for (columns, residuals) in parts {
            let blocks = columns.as_slice().chunks(LANES * unknowns.max(1)).zip(residuals.chunks(LANES));
            for (columns, residuals) in blocks {
                let residuals = Lanes::from_fn(|lane| residuals.get(lane).copied().unwrap_or(0.0));
                sums.push_block(unknowns, residuals, |index| {
                    Lanes::from_fn(|lane| columns.get(lane * unknowns + index).copied().unwrap_or(0.0))
                });
            }
        }
        sums
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
            let mut columns = DMatrix::repeat(9, samples, 5.0);
            fill_curve_rows(&mut columns, 3, &theta, &shares);
            for (column, (theta, shares)) in columns.column_iter().zip(theta.iter().zip(&shares)) {
                let alone = curve_row(*theta, 3, *shares);
                assert!((column.rows(0, 7) - alone).norm() < 1e-12 && column[7] == 5.0 && column[8] == 5.0);
            }
        }
    }

    #[test]
    fn sums_are_those_of_products_of_matrices() {
        let of = |samples: usize, from: f64| DMatrix::from_fn(5, samples, |i, j| (from + (3 * i + 7 * j) as f64).sin());
        let (first, second) = (of(19, 0.2), of(8, 1.1));
        let residuals: [Vec<f64>; 2] = [19, 8].map(|count| (0..count).map(|index| f64::from(index).cos()).collect());
        let (matrix, vector) = sums_of_outer_products(&[(&first, &residuals[0]), (&second, &residuals[1])], 5);
        let expected = &first * first.transpose() + &second * second.transpose();
        let [left, right] = residuals.map(DVector::from_vec);
        assert!((matrix - expected).norm() < 1e-12 && (vector - first * left - second * right).norm() < 1e-12);
    }
}
