//! The predictive shape, a Gaussian over the coefficients, and the predictive (marginal) likelihood of one sample at an
//! orientation: −2 ln p = eᵀS⁻¹e + ln det S with S = 1 + JΣJᵀ (`docs/theory.md`, section on the decoded motion). Boundary that
//! was hardly felt can explain a sample as well, at the price of its uncertainty.

use crate::estimate::association::candidates::minima;
use crate::estimate::association::transitions::near;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::Linearised;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::solver::gauss_newton::{Fit, Smoother};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Other orientations of a sample that are reported at most: every one of them costs a fit.
const OTHER_ORIENTATIONS: usize = 4;

/// The posterior of the shape given some of the samples.
pub(crate) struct PredictiveShape {
    coefficients: Vec<f64>,
    covariance: DMatrix<f64>,
    noise: Noise,
}

impl PredictiveShape {
    /// The posterior at a fit, given these samples. `None` when they do not determine it.
    pub fn from(measurements: &Measurements, fit: &Fit) -> Option<Self> {
        let belief = Smoother::new(measurements, fit.order, fit.noise, fit.prior).belief(&fit.estimate)?;
        let covariance = belief.covariance()?;
        Some(Self { coefficients: belief.mean.as_slice().to_vec(), covariance, noise: fit.noise })
    }

    /// −2 ln of the predictive density of a sample at an orientation, the shape integrated out, up to a constant.
    pub fn neg_log_predictive(&self, instant: &Instant, psi: f64) -> f64 {
        let mut linearised = Linearised::new(Layout::of_coefficients(&self.coefficients).order);
        let value = linearised.at(instant, &self.coefficients, psi).value;
        let weights = self.noise.weights(&Instant { balance_weight: 1.0, ..*instant });
        let mut rows = DMatrix::zeros(self.coefficients.len(), 3);
        for (j, weight) in weights.into_iter().enumerate() {
            let share = std::array::from_fn(|i| if i == j { weight } else { 0.0 });
            linearised.mixed_row(instant, share, rows.column_mut(j).as_mut_slice());
        }
        let spread = rows.tr_mul(&(&self.covariance * &rows));
        // In units of the noise; a contact that was not seen has rows of zeros and contributes nothing.
        let covariance = Matrix3::from_fn(|i, j| spread[(i, j)] + if i == j { 1.0 } else { 0.0 });
        let missed = Vector3::from_fn(|j, _| weights[j] * value[j]);
        let Some(factor) = covariance.cholesky() else { return f64::INFINITY };
        let Some(independent) = factor.l().solve_lower_triangular(&missed) else { return f64::INFINITY };
        let [first, second, balance] = [independent[0], independent[1], independent[2]];
        let spread = 2.0 * factor.l_dirty().diagonal().iter().map(|l| l.ln()).sum::<f64>();
        // The innovation of the balance given both contacts follows Student's t, as everywhere.
        first * first + second * second + (STUDENT + 1.0) * (balance * balance / STUDENT).ln_1p() + spread
    }

    /// Margin (−2 ln of the ratio of predictive densities) of the orientation near `psi` over the most likely other one, and the
    /// most likely other orientations, best first.
    pub fn elsewhere(&self, instant: &Instant, psi: f64, period: f64) -> (f64, Vec<f64>) {
        let mut here = self.neg_log_predictive(instant, psi);
        let mut others = Vec::new();
        for (other, neg_log_predictive) in minima(psi, period, &|psi| self.neg_log_predictive(instant, psi)) {
            if near(psi, other, period) {
                here = here.min(neg_log_predictive);
            } else {
                others.push((other, neg_log_predictive));
            }
        }
        others.sort_by(|a, b| a.1.total_cmp(&b.1));
        others.truncate(OTHER_ORIENTATIONS);
        let margin = others.first().map_or(f64::INFINITY, |(_, neg_log_predictive)| neg_log_predictive - here);
        (margin, others.into_iter().map(|(psi, _)| psi).collect())
    }
}

#[cfg(test)]
mod tests;
