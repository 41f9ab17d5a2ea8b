//! The posterior of the shape: the Gaussian that the log leaves of its coefficients.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::pivot::smoother::curve_row;
use crate::shape::SupportFunction;

/// A Gaussian over shapes, a common rotation taken out.
#[derive(Clone, Debug, PartialEq)]
pub struct PivotPosterior {
    mean: DVector<f64>,
    /// A root of the covariance.
    root: DMatrix<f64>,
    turn_rad: f64,
}

impl PivotPosterior {
    /// From mean and covariance (by columns) of the coefficients, to be turned by an angle.
    pub(super) fn new(mean: &[f64], covariance_m2: Vec<f64>, turn_rad: f64) -> Self {
        let unknowns = mean.len();
        let eigen = DMatrix::from_vec(unknowns, unknowns, covariance_m2).symmetric_eigen();
        let scales = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
        let root = eigen.eigenvectors * DMatrix::from_diagonal(&scales);
        Self { mean: DVector::from_column_slice(mean), root, turn_rad }
    }

    /// A shape that is known exactly.
    pub fn known(shape: &SupportFunction) -> Self {
        let mean = shape.coefficients();
        let unknowns = mean.len();
        Self { mean: DVector::from_vec(mean), root: DMatrix::zeros(unknowns, unknowns), turn_rad: 0.0 }
    }

    /// The most likely shape.
    pub fn mean(&self) -> SupportFunction {
        SupportFunction::from_coefficients(self.mean.as_slice()).rotated(self.turn_rad)
    }

    /// Variance of a combination of height r and offset d at an angle: that with these shares of each.
    pub(super) fn variance(&self, theta_rad: f64, shares: [f64; 2]) -> f64 {
        let row = curve_row(theta_rad - self.turn_rad, self.mean.len() / 2, shares);
        (self.root.transpose() * row).norm_squared()
    }

    /// A shape drawn from it; the same seed gives the same shape. Where the boundary was not felt it may be hollow.
    pub fn draw(&self, seed: u64) -> SupportFunction {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let normal = DVector::from_fn(self.mean.len(), |_, _| rng.sample::<f64, _>(StandardNormal));
        let drawn = &self.mean + &self.root * normal;
        SupportFunction::from_coefficients(drawn.as_slice()).rotated(self.turn_rad)
    }
}
