//! Error bars: the posterior covariance of shape, motion and centre of mass at the optimum.
//!
//! A common rotation of shape and motion cannot be known and is no error: every standard deviation here is what is left
//! after the best rotation over the felt boundary (in geodesy: inner constraints). It is taken out by the projection
//! P = 1 − ρ(ρᵀG)/(ρᵀGρ), where ρ are the coefficients of r' and G is the Gram matrix of the basis over the felt boundary.

use nalgebra::{DMatrix, DVector};

use super::evidence::Fit;
use super::problem::{Instant, Problem};
use super::residuals::{contact_angles, support};
use super::smooth::{Normal, Smoother};

/// Posterior covariances in the gauge described above.
pub(super) struct Posterior {
    covariance: DMatrix<f64>,
    projection: DMatrix<f64>,
    normal: Normal,
    inflation: f64,
}

/// (1, cos kθ …, sin kθ …)
pub(super) fn basis(theta: f64, order: usize) -> DVector<f64> {
    let mut row = DVector::from_element(2 * order + 1, 1.0);
    for k in 1..=order {
        let (sin, cos) = (theta * k as f64).sin_cos();
        row[k] = cos;
        row[order + k] = sin;
    }
    row
}

impl Posterior {
    /// At the optimum `fit`; `felt` are the normal angles of the felt boundary; `inflation` multiplies every variance
    /// (errors of neighbouring samples that hang together).
    pub fn new(problem: &Problem, fit: &Fit, felt: &[f64], inflation: f64) -> Option<Self> {
        let smoother = Smoother::new(problem, fit.order, fit.noise, fit.prior).strictly_convex();
        let normal = smoother.linearise(&fit.estimate.coefficients, &fit.estimate.psi);
        let inverse = smoother.factor(&normal)?.inverse();
        let unknowns = 2 * fit.order + 1;
        let a = &fit.estimate.coefficients;
        let mut rotation = DVector::zeros(unknowns);
        for k in 1..=fit.order {
            rotation[k] = k as f64 * a[fit.order + k];
            rotation[fit.order + k] = -(k as f64) * a[k];
        }
        let mut weights = DVector::zeros(unknowns);
        for &theta in felt {
            let row = basis(theta, fit.order);
            weights += row.dot(&rotation) * row;
        }
        let scale = weights.dot(&rotation);
        let mut projection = DMatrix::identity(unknowns, unknowns);
        if scale > 0.0 {
            projection -= &rotation * weights.transpose() / scale;
        }
        let covariance = &projection * inverse * projection.transpose();
        Some(Self { covariance, projection, normal, inflation })
    }

    fn quadratic(&self, row: &DVector<f64>) -> f64 {
        (&self.covariance * row).dot(row).max(0.0)
    }

    /// Standard deviation of r(θ), metres.
    pub fn r_sd_m(&self, theta: f64) -> f64 {
        let order = self.covariance.nrows() / 2;
        (self.inflation * self.quadratic(&basis(theta, order))).sqrt()
    }

    /// Covariance matrix of the coefficients, inflation included.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.covariance * self.inflation
    }

    /// Standard deviations of ψ (radians) and of the centre of mass (metres) at one instant.
    pub fn pose_sd(&self, index: usize, instant: &Instant, coefficients: &[f64], psi: f64) -> (f64, f64) {
        let order = coefficients.len() / 2;
        let slope = DVector::from_row_slice(self.normal.psi_slope(index));
        let own = 1.0 / (self.normal.psi_information(index) + 1.0);
        let psi_variance = self.quadratic(&slope) + own;
        let (theta1, theta2) = contact_angles(instant, psi);
        let (basis1, basis2) = (basis(theta1, order), basis(theta2, order));
        let (one, two) = (support(coefficients, theta1), support(coefficients, theta2));
        let mut variance = 0.0;
        for (weight1, weight2) in [(instant.cos12, instant.cos1), (instant.sin12, instant.sin1)] {
            let by_psi = (one.d * weight1 + two.d * weight2) / instant.sin2;
            // The projection leaves ψ and shape turned together, so the centre of mass may use either gauge.
            let row = (&basis1 * weight1 + &basis2 * weight2) / instant.sin2 + &slope * by_psi;
            variance += self.quadratic(&row) + by_psi * by_psi * own;
        }
        ((self.inflation * psi_variance).sqrt(), (self.inflation * 0.5 * variance).sqrt())
    }

    /// The projection on the gauge, for tests.
    #[cfg(test)]
    pub fn projection(&self) -> &DMatrix<f64> {
        &self.projection
    }
}
