//! The evidence: the probability of a log with shape and motion integrated out, by Laplace's approximation (D. J. C. MacKay,
//! *Bayesian interpolation*, Neural Computation 4, 1992; `docs/theory.md`, what the log says of itself).

use crate::estimate::model::contact::residuals;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother};
use crate::estimate::solver::normal_equations::Normal;
use nalgebra::{Cholesky, Dyn};

/// ln of the probability of the log, shape and motion integrated out. An object at rest has the orientation that balances it,
/// to within σ_b/g': the balance is a prior on ψ, with the density |g'|/σ_b at its peak, and not a
/// measurement. (A measurement would favour round shapes, which do not determine ψ.) `factor` is that of `normal`.
pub(crate) fn log_evidence(
    smoother: &Smoother,
    estimate: &Estimate,
    normal: &Normal,
    factor: &Cholesky<f64, Dyn>,
) -> f64 {
    let half_log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
    let mut sum = -0.5 * estimate.cost - half_log_determinant;
    sum -= smoother.prior.standard_deviations(smoother.order).iter().map(|sd| sd.ln()).sum::<f64>();
    for (index, (instant, &psi)) in smoother.measurements.instants.iter().zip(&estimate.psi).enumerate() {
        let seen = f64::from(instant.weight1 > 0.0) + f64::from(instant.weight2 > 0.0);
        sum -= seen * smoother.noise.sensor_m.ln();
        let stiffness = residuals(instant, &estimate.coefficients, psi).by_psi[2];
        let density = stiffness * smoother.noise.weights(instant)[2];
        sum += 0.5 * (density * density).ln_1p() - 0.5 * normal.psi_information(index).ln_1p();
    }
    sum
}
