//! The evidence: the probability of a log with shape and motion integrated out, by Laplace's approximation (D. J. C. MacKay,
//! *Bayesian interpolation*, Neural Computation 4, 1992; `docs/theory.md`, what the log says of itself).

use crate::estimate::model::contact::residuals;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother};
use crate::estimate::solver::normal_equations::Normal;

/// The probability of the log, shape and motion integrated out. An object at rest has the orientation that balances it,
/// to within σ_b/g': the balance is a prior on ψ, with the density |g'|/σ_b at its peak, and not a
/// measurement. (A measurement would favour round shapes, which do not determine ψ.)
///
/// Where motions are compared, `normal` is that of samples and prior alone: that the object is convex cuts the posterior off and measures
/// nothing. The nodes that hold the shape convex would each count as a sharp measurement, of seven nats for every one more that a motion happens
/// to press on. `None` where `normal` does not determine the shape.
pub(crate) fn laplace_evidence(smoother: &Smoother, estimate: &Estimate, normal: &Normal) -> Option<Evidence> {
    let factor = smoother.factor(normal)?;
    let half_log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
    let of_shape = smoother.shape_cost(&estimate.coefficients);
    let mut sum = -0.5 * (estimate.cost - of_shape);
    for (index, (instant, &psi)) in smoother.measurements.instants.iter().zip(&estimate.psi).enumerate() {
        let seen = f64::from(instant.weight1 > 0.0) + f64::from(instant.weight2 > 0.0);
        sum -= seen * smoother.noise.sensor_m.ln();
        let stiffness = residuals(instant, &estimate.coefficients, psi).by_psi[2];
        let density = stiffness * smoother.noise.weights(instant)[2];
        sum += 0.5 * (density * density).ln_1p() - 0.5 * normal.psi_information(index).ln_1p();
    }
    let prior_sds = smoother.prior.standard_deviations(smoother.order);
    let besides = -0.5 * of_shape - half_log_determinant - prior_sds.iter().map(|sd| sd.ln()).sum::<f64>();
    Some(Evidence { of_samples: sum, besides, samples_per_error: 1.0 })
}
