//! The evidence: the probability of a log with shape and motion integrated out, by Laplace's approximation (D. J. C. MacKay,
//! *Bayesian interpolation*, Neural Computation 4, 1992; `docs/theory.md`, what the log says of itself).

use crate::estimate::model::contact::residuals;
use crate::estimate::model::noise::STUDENT;
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
    // The square of the balance is in the cost.
    with_balance(smoother, estimate, normal, factor, |weight, _, stiffness| 0.5 * (weight * stiffness).powi(2).ln_1p())
}

/// The same with Student's t for the balance, whose weights the cost has. A balance that a motion misses is worth as little to that motion as to
/// any other by its weight alone; what it costs to miss it is not in the square.
pub(crate) fn robust_log_evidence(
    smoother: &Smoother,
    estimate: &Estimate,
    normal: &Normal,
    factor: &Cholesky<f64, Dyn>,
) -> f64 {
    let sharp = 1.0 / smoother.noise.balance_m;
    with_balance(smoother, estimate, normal, factor, |weight, balance, stiffness| {
        if weight == 0.0 {
            return 0.0;
        }
        let tails = (STUDENT + 1.0) * ((sharp * balance).powi(2) / STUDENT).ln_1p();
        0.5 * ((weight * balance).powi(2) - tails + (sharp * stiffness).powi(2).ln_1p())
    })
}

/// Laplace's approximation with what the balance of a sample adds to it beside the cost, by its weight (1/m), its residual g and g' (metres).
fn with_balance(
    smoother: &Smoother,
    estimate: &Estimate,
    normal: &Normal,
    factor: &Cholesky<f64, Dyn>,
    of_balance: impl Fn(f64, f64, f64) -> f64,
) -> f64 {
    let half_log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
    let mut sum = -0.5 * estimate.cost - half_log_determinant;
    sum -= smoother.prior.standard_deviations(smoother.order).iter().map(|sd| sd.ln()).sum::<f64>();
    for (index, (instant, &psi)) in smoother.measurements.instants.iter().zip(&estimate.psi).enumerate() {
        let seen = f64::from(instant.weight1 > 0.0) + f64::from(instant.weight2 > 0.0);
        sum -= seen * smoother.noise.sensor_m.ln();
        let at = residuals(instant, &estimate.coefficients, psi);
        sum += of_balance(smoother.noise.weights(instant)[2], at.value[2], at.by_psi[2]);
        sum -= 0.5 * normal.psi_information(index).ln_1p();
    }
    sum
}
