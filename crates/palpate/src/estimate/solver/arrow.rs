//! Normal equations shaped like an arrow: a band for the coefficients of a spline, and a dense corner for unknowns that all samples share. The
//! band is eliminated first, so that a step costs in proportion to the length of the spline.

use crate::math::banded::{Banded, BandedCholesky};
use crate::math::spline::SUPPORT;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// JᵀJ and Jᵀe of some residuals e.
#[derive(Clone, Debug)]
pub(crate) struct Arrow {
    pub dense: DMatrix<f64>,
    pub dense_gradient: DVector<f64>,
    pub band: Banded,
    pub band_gradient: Vec<f64>,
    /// Dense unknown by coefficient of the spline: a column for each of the latter.
    pub cross: DMatrix<f64>,
}

/// Derivatives by six coefficients of the band, and the first of these.
pub(crate) type BandRow = (usize, [f64; SUPPORT]);

/// Residuals that are added to the dense corner in one product.
const BLOCK: usize = 64;

/// Adds residuals to an arrow.
pub(crate) struct ArrowBuilder {
    arrow: Arrow,
    block: DMatrix<f64>,
    filled: usize,
}

impl ArrowBuilder {
    /// For so many dense unknowns and coefficients of a spline.
    pub fn new(dense: usize, spline: usize) -> Self {
        let arrow = Arrow {
            dense: DMatrix::zeros(dense, dense),
            dense_gradient: DVector::zeros(dense),
            band: Banded::zeros(spline),
            band_gradient: vec![0.0; spline],
            cross: DMatrix::zeros(dense, spline),
        };
        Self { arrow, block: DMatrix::zeros(dense, BLOCK), filled: 0 }
    }

    /// Adds a residual with its derivatives by the dense unknowns, and by six coefficients of the spline from `first` on.
    pub fn add(&mut self, value: f64, dense: &[f64], (first, spline): BandRow) {
        self.block.column_mut(self.filled).copy_from_slice(dense);
        self.filled += 1;
        let column = self.block.column(self.filled - 1);
        self.arrow.dense_gradient.axpy(value, &column, 1.0);
        self.arrow.band.add_outer_product(first, &spline, 1.0);
        for (i, by) in spline.iter().enumerate() {
            self.arrow.band_gradient[first + i] += value * by;
            self.arrow.cross.column_mut(first + i).axpy(*by, &column, 1.0);
        }
        if self.filled == BLOCK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let block = self.block.columns(0, self.filled);
        self.arrow.dense.gemm(1.0, &block, &block.transpose(), 1.0);
        self.filled = 0;
    }

    pub fn finish(mut self) -> Arrow {
        self.flush();
        self.arrow
    }
}

impl Arrow {
    /// Adds `weight` times another.
    pub fn add(&mut self, weight: f64, other: &Self) {
        self.dense += weight * &other.dense;
        self.dense_gradient.axpy(weight, &other.dense_gradient, 1.0);
        self.band.add(weight, &other.band);
        self.band_gradient.iter_mut().zip(&other.band_gradient).for_each(|(sum, by)| *sum += weight * by);
        self.cross += weight * &other.cross;
    }

    /// Multiplies all by a weight.
    pub fn scale(&mut self, weight: f64) {
        self.dense *= weight;
        self.dense_gradient *= weight;
        self.band.scale(weight);
        self.band_gradient.iter_mut().for_each(|value| *value *= weight);
        self.cross *= weight;
    }

    /// The equations with the band eliminated. Every diagonal entry is enlarged by its share `damping`. `None` where they are singular.
    pub fn eliminated(&self, damping: f64) -> Option<Eliminated> {
        let mut band = self.band.clone();
        band.map_diagonal(|entry| entry * (1.0 + damping));
        let band = band.cholesky()?;
        let dense = self.dense.nrows();
        let mut half = self.cross.clone();
        band.solve_lower(half.as_mut_slice(), dense);
        let mut corner = self.dense.clone();
        (0..dense).for_each(|i| corner[(i, i)] *= 1.0 + damping);
        corner.gemm(-1.0, &half, &half.transpose(), 1.0);
        let factor = corner.clone().cholesky()?;
        Some(Eliminated { band, half, corner, factor })
    }
}

/// Normal equations with the band eliminated.
#[derive(Clone)]
pub(crate) struct Eliminated {
    band: BandedCholesky,
    /// The cross terms times the inverse of the factor of the band.
    half: DMatrix<f64>,
    /// What is left for the dense unknowns, and its factor.
    corner: DMatrix<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl Eliminated {
    /// The step of the dense unknowns and of the spline against a gradient.
    pub fn step(&self, arrow: &Arrow) -> (DVector<f64>, Vec<f64>) {
        let mut spline = arrow.band_gradient.clone();
        self.band.solve_lower(&mut spline, 1);
        let left = DVector::from_column_slice(&spline);
        let dense = -self.factor.solve(&(&arrow.dense_gradient - &self.half * &left));
        let mut spline: Vec<f64> = (-left - self.half.tr_mul(&dense)).as_slice().to_vec();
        self.band.solve_upper(&mut spline, 1);
        (dense, spline)
    }

    /// The information on the dense unknowns, whatever the spline.
    pub fn information(&self) -> &DMatrix<f64> {
        &self.corner
    }

    /// The covariance of the dense unknowns, whatever the spline.
    pub fn covariance(&self) -> DMatrix<f64> {
        self.factor.inverse()
    }

    /// Makes the standard deviation of a linear function of the dense unknowns larger by a factor of at least 1, and with it the covariance of all that
    /// depends on it: Λ − (1 − 1/f²) g gᵀ/(gᵀ Λ⁻¹ g).
    pub fn loosen(&mut self, function: &DVector<f64>, factor: f64) {
        let variance = function.dot(&self.factor.solve(function));
        self.inform(function, -(1.0 - factor.powi(-2)) / variance);
    }

    /// Adds so much information on a linear function of the dense unknowns, as long as what is left determines them: Λ + i g gᵀ.
    pub fn inform(&mut self, function: &DVector<f64>, information: f64) {
        let mut corner = self.corner.clone();
        corner.ger(information, function, function, 1.0);
        if let Some(informed) = corner.clone().cholesky() {
            (self.corner, self.factor) = (corner, informed);
        }
    }

    /// ln of the determinant of the whole matrix.
    pub fn ln_determinant(&self) -> f64 {
        self.band.ln_determinant() + 2.0 * self.factor.l_dirty().diagonal().iter().map(|entry| entry.ln()).sum::<f64>()
    }

    /// What the spline is given the dense unknowns.
    pub fn given_dense(&self) -> SplineGivenDense {
        let dense = self.half.nrows();
        let mut slopes = self.half.clone();
        self.band.solve_upper(slopes.as_mut_slice(), dense);
        SplineGivenDense { slopes, covariance: self.band.inverse_in_band() }
    }
}

/// How the coefficients of the spline follow the dense unknowns, and their covariance when those are held.
pub(crate) struct SplineGivenDense {
    /// Minus their derivatives: a column for each coefficient.
    slopes: DMatrix<f64>,
    covariance: Banded,
}

impl SplineGivenDense {
    /// Derivative by the dense unknowns of what is a row of six coefficients from the first on.
    pub fn slope(&self, (first, row): BandRow) -> DVector<f64> {
        let mut slope = DVector::zeros(self.slopes.nrows());
        for (i, by) in row.iter().enumerate() {
            slope.axpy(-by, &self.slopes.column(first + i), 1.0);
        }
        slope
    }

    /// Its variance when they are held.
    pub fn variance(&self, (first, row): BandRow) -> f64 {
        self.covariance.quadratic(first, &row)
    }

    /// The share of the unknowns that some residuals determine: the trace of the covariance times their normal equations. `covariance` is that of
    /// the dense unknowns.
    pub fn determined_by(&self, residuals: &Arrow, covariance: &DMatrix<f64>) -> f64 {
        let of_dense = covariance.component_mul(&residuals.dense).sum();
        // The slopes are −dq/dz, so that cov(q, z) = −slopesᵀ covariance.
        let joint = covariance * &self.slopes;
        let of_both = -2.0 * joint.component_mul(&residuals.cross).sum();
        let of_spline = residuals
            .band
            .trace_of_product(|i, j| self.covariance.at(i, j) + joint.column(i).dot(&self.slopes.column(j)));
        of_dense + of_both + of_spline
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::spline::SplineBasis;

    const DENSE: usize = 4;

    /// Residuals of one kind, as an arrow and in full.
    struct Kind {
        arrow: Arrow,
        jacobian: DMatrix<f64>,
        value: DVector<f64>,
    }

    fn kind(basis: &SplineBasis, order: usize, count: usize) -> Kind {
        let mut builder = ArrowBuilder::new(DENSE, basis.len());
        let (mut jacobian, mut value) = (DMatrix::zeros(count, DENSE + basis.len()), DVector::zeros(count));
        for i in 0..count {
            let row = basis.at(3.0 * (i as f64 + 0.5) / count as f64);
            let dense: [f64; DENSE] = std::array::from_fn(|j| (0.3 * (i * (j + 1)) as f64 + order as f64).sin());
            value[i] = (1.7 * i as f64).cos();
            builder.add(value[i], &dense, (row.first, row.derivatives[order]));
            (0..DENSE).for_each(|j| jacobian[(i, j)] = dense[j]);
            (0..SUPPORT).for_each(|j| jacobian[(i, DENSE + row.first + j)] = row.derivatives[order][j]);
        }
        Kind { arrow: builder.finish(), jacobian, value }
    }

    #[test]
    fn steps_covariances_and_redundancies_are_those_of_the_full_matrix() {
        let basis = SplineBasis::new(&[0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        let Kind { arrow: one, jacobian: j1, value: e1 } = kind(&basis, 0, 150);
        let Kind { arrow: two, jacobian: j2, value: e2 } = kind(&basis, 1, 70);
        let mut sum = one;
        sum.add(0.25, &two);
        let full = j1.tr_mul(&j1) + 0.25 * j2.tr_mul(&j2);
        let gradient = j1.tr_mul(&e1) + 0.25 * j2.tr_mul(&e2);
        let factor = full.clone().cholesky().expect("determined");
        let eliminated = sum.eliminated(0.0).expect("determined");
        let expected = -factor.solve(&gradient);
        let (dense, spline) = eliminated.step(&sum);
        (0..DENSE).for_each(|i| assert!((dense[i] - expected[i]).abs() < 1e-9 * expected.amax()));
        (0..basis.len()).for_each(|i| assert!((spline[i] - expected[DENSE + i]).abs() < 1e-9 * expected.amax()));
        assert!((eliminated.ln_determinant() - 2.0 * factor.l().diagonal().map(f64::ln).sum()).abs() < 1e-9);
        let inverse = factor.inverse();
        let covariance = eliminated.covariance();
        assert!((&covariance - inverse.view((0, 0), (DENSE, DENSE))).amax() < 1e-9 * covariance.amax());
        let given = eliminated.given_dense();
        let determined = 0.25 * given.determined_by(&two, &covariance);
        let expected = 0.25 * (&inverse * j2.tr_mul(&j2)).trace();
        assert!((determined - expected).abs() < 1e-8, "{determined} {expected}");
        // The spline at some time: slope and variance.
        let row = basis.at(1.3);
        let mut of_spline = DVector::zeros(DENSE + basis.len());
        (0..SUPPORT).for_each(|j| of_spline[DENSE + row.first + j] = row.derivatives[0][j]);
        let row = row.of_value();
        let slope = given.slope(row);
        let variance = given.variance(row) + (&covariance * &slope).dot(&slope);
        assert!((variance / (&inverse * &of_spline).dot(&of_spline) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_is_loosened_is_known_less_and_all_else_by_as_much_as_it_depends_on_that() {
        let basis = SplineBasis::new(&[0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        let mut eliminated = kind(&basis, 0, 150).arrow.eliminated(0.0).expect("determined");
        let before = eliminated.covariance();
        let function = DVector::from_column_slice(&[0.0, 0.6, -0.8, 0.0]);
        let carried = &before * &function;
        let expected = &before + (3.0_f64.powi(2) - 1.0) * &carried * carried.transpose() / function.dot(&carried);
        eliminated.loosen(&function, 3.0);
        assert!((eliminated.covariance() - &expected).amax() < 1e-9 * expected.amax());
        eliminated.loosen(&function, 1.0);
        assert!((eliminated.covariance() - &expected).amax() < 1e-9 * expected.amax());
        // As much information as there was about it halves its variance.
        let variance = function.dot(&(&expected * &function));
        eliminated.inform(&function, 1.0 / variance);
        assert!((function.dot(&(eliminated.covariance() * &function)) / variance - 0.5).abs() < 1e-9);
    }
}
