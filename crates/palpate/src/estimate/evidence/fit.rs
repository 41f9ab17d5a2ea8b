//! The optimum for one number of harmonics, alternating with variance components: the smoother, updates of noise, prior and
//! weights of the balance, and the smoother again.

use crate::estimate::evidence::laplace::laplace_evidence;
use crate::estimate::evidence::motion_prior::neg_log_prior;
use crate::estimate::evidence::variance_components::{
    VarianceComponents, updated_noise, updated_scale, with_balance_weights,
};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use nalgebra::{Cholesky, Dyn};

/// Updates of noise and prior in one fit: they converge in two or three, and a later fit continues from them.
pub(crate) const ROUNDS: usize = 4;

/// Steps of the smoother at most: from the start, and after an update, which moves the optimum little.
const FIRST_STEPS: usize = 40;
const FURTHER_STEPS: usize = 12;

/// Relative fall of the cost at which the smoother ends: differences of the log evidence by one stand out.
const TOLERANCE: f64 = 1e-7;

/// An optimum, and the measurements with the weights of the balance (Student's t) at its residuals, with which a further fit goes
/// on.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub fit: Fit,
    pub weighted: Measurements,
}

/// The evidence at an optimum, with the prior of its motion, and the Cholesky factor of the information on the shape there. `None` where that
/// does not determine every unknown.
pub(crate) fn evidence_at(smoother: &Smoother, estimate: &Estimate) -> Option<(Evidence, Cholesky<f64, Dyn>)> {
    let normal = smoother.linearise_without_convexity(&estimate.coefficients, &estimate.psi);
    let evidence = laplace_evidence(smoother, estimate, &normal)?;
    let factor = smoother.factor(&smoother.held_convex(normal, &estimate.coefficients))?;
    let period = smoother.prior.symmetry.period_rad();
    let of_motion = neg_log_prior(smoother.measurements, estimate, smoother.noise.balance_m, period);
    Some((evidence.with(-of_motion), factor))
}

/// Runs the smoother, updates noise, prior and weights, and runs it again, at most `rounds` times. `None` where no optimum is
/// found.
pub(crate) fn fit(
    measurements: &Measurements,
    order: usize,
    start: Estimate,
    mut noise: Noise,
    mut prior: Prior,
    variance_components: VarianceComponents,
    rounds: usize,
) -> Option<Fitted> {
    let mut estimate = start;
    let mut weighted = measurements.clone();
    let mut best: Option<Fit> = None;
    for round in 0..=rounds {
        let smoother = Smoother::new(&weighted, order, noise, prior).strictly_convex();
        let stopping =
            StoppingCriteria { iterations: if round == 0 { FIRST_STEPS } else { FURTHER_STEPS }, tolerance: TOLERANCE };
        estimate = smoother.run(estimate.coefficients, estimate.psi, stopping);
        if !estimate.cost.is_finite() {
            break;
        }
        let (evidence, factor) = evidence_at(&smoother, &estimate)?;
        let variance: Vec<f64> = factor.inverse().diagonal().iter().copied().collect();
        best = Some(Fit { estimate: estimate.clone(), order, noise, prior, evidence });
        let next = updated_noise(&smoother, &estimate, &variance, variance_components);
        prior.scale_m = updated_scale(&estimate.coefficients, &variance, prior);
        let converged = (next.sensor_m / noise.sensor_m).ln().abs() < CONVERGED_SENSOR
            && (next.balance_m / noise.balance_m).ln().abs() < CONVERGED_BALANCE;
        noise = next;
        weighted = with_balance_weights(weighted, &estimate, noise.balance_m);
        if converged {
            break;
        }
    }
    best.map(|fit| Fitted { fit, weighted })
}

/// Relative changes of the noise below which the updates have converged: far below the standard deviations of the estimates.
const CONVERGED_SENSOR: f64 = 0.01;
const CONVERGED_BALANCE: f64 = 0.05;
