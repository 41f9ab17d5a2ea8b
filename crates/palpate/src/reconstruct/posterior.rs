//! Error bars: the posterior covariance of shape, motion and centre of mass at the optimum.
//!
//! A common rotation of shape and motion cannot be known and is no error: every standard deviation here is what is left
//! after the best rotation over the felt boundary (in geodesy: inner constraints). It is taken out by the projection
//! P = 1 − ρ(ρᵀG)/(ρᵀGρ), where ρ are the coefficients of r' and G is the Gram matrix of the basis over the felt boundary.

use nalgebra::{DMatrix, DVector};

use super::evidence::Fit;
use super::problem::{Instant, Problem};
use super::residuals::{contact_angles, residuals, support};
use super::smooth::{Normal, Smoother};

/// Posterior covariances in the gauge described above.
pub(super) struct Posterior {
    covariance: DMatrix<f64>,
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
        Some(Self { covariance, normal, inflation })
    }

    fn quadratic(&self, row: &DVector<f64>) -> f64 {
        (&self.covariance * row).dot(row).max(0.0)
    }

    /// Standard deviation of r(θ), metres.
    pub fn r_sd_m(&self, theta: f64) -> f64 {
        let order = self.covariance.nrows() / 2;
        (self.inflation * self.quadratic(&basis(theta, order))).sqrt()
    }

    /// Standard deviations of ψ (radians) and of the centre of mass (metres) at one instant, the palm angles being known to
    /// `angle_sd` (radians).
    pub fn pose_sd(&self, index: usize, instant: &Instant, fit: &Fit, angle_sd: f64) -> (f64, f64) {
        let coefficients = &fit.estimate.coefficients;
        let psi = fit.estimate.psi[index];
        let slope = DVector::from_row_slice(self.normal.psi_slope(index));
        let own = 1.0 / (self.normal.psi_information(index) + 1.0);
        let psi_variance = self.quadratic(&slope) + own;
        let (theta1, theta2) = contact_angles(instant, psi);
        let (basis1, basis2) = (basis(theta1, fit.order), basis(theta2, fit.order));
        let (one, two) = (support(coefficients, theta1), support(coefficients, theta2));
        let mut variance = 0.0;
        for (weight1, weight2) in [(instant.cos12, instant.cos1), (instant.sin12, instant.sin1)] {
            let by_psi = (one.d * weight1 + two.d * weight2) / instant.sin2;
            // The projection leaves ψ and shape turned together, so the centre of mass may use either gauge.
            let row = (&basis1 * weight1 + &basis2 * weight2) / instant.sin2 + &slope * by_psi;
            variance += self.quadratic(&row) + by_psi * by_psi * own;
        }
        let (psi_by_angle, com_by_angle) = angle_sensitivity(instant, fit, psi);
        let angle_variance = angle_sd * angle_sd;
        (
            (self.inflation * psi_variance + angle_variance * psi_by_angle).sqrt(),
            (self.inflation * 0.5 * variance + angle_variance * 0.5 * com_by_angle).sqrt(),
        )
    }
}

/// By how much errors of the two palm angles move the pose of one sample, the shape being known: sums of squares of the
/// derivatives of ψ and of the centre of mass (m²/rad²).
fn angle_sensitivity(instant: &Instant, fit: &Fit, psi: f64) -> (f64, f64) {
    const STEP: f64 = 1e-6;
    let coefficients = &fit.estimate.coefficients;
    let weights = fit.noise.weights(instant);
    let center = |instant: &Instant, psi: f64| {
        let (theta1, theta2) = contact_angles(instant, psi);
        let (r1, r2) = (support(coefficients, theta1).r, support(coefficients, theta2).r);
        [
            (r1 * instant.cos12 + r2 * instant.cos1) / instant.sin2,
            (r1 * instant.sin12 + r2 * instant.sin1) / instant.sin2,
        ]
    };
    let here = residuals(instant, coefficients, psi);
    let at = center(instant, psi);
    let information: f64 = (0..3).map(|j| (weights[j] * here.by_psi[j]).powi(2)).sum();
    let (mut by_psi, mut by_center) = (0.0, 0.0);
    for turned in [instant.turned(STEP, 0.0), instant.turned(0.0, STEP)] {
        let there = residuals(&turned, coefficients, psi);
        let pull: f64 = (0..3).map(|j| weights[j].powi(2) * here.by_psi[j] * (there.value[j] - here.value[j])).sum();
        let step = -pull / (information + 1.0);
        let moved = center(&turned, psi + step);
        by_psi += (step / STEP).powi(2);
        by_center += ((moved[0] - at[0]) / STEP).powi(2) + ((moved[1] - at[1]) / STEP).powi(2);
    }
    (by_psi, by_center)
}
