//! The optimum for one number of harmonics, with noise and prior that follow the data.

use crate::estimate::evidence::laplace::log_evidence;
use crate::estimate::evidence::motion_prior::neg_log_prior;
use crate::estimate::evidence::variance_components::{VarianceComponents, updated_noise, updated_scale, weigh_balance};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};

/// Times that noise and prior follow the data in one fit.
pub(crate) const ROUNDS: usize = 4;

/// Runs the smoother, lets noise and prior follow the data, and runs it again, `rounds` times.
pub(crate) fn fit(
    measurements: &mut Measurements,
    order: usize,
    start: Estimate,
    mut noise: Noise,
    mut prior: Prior,
    variance_components: VarianceComponents,
    rounds: usize,
) -> Option<Fit> {
    let mut estimate = start;
    let mut best: Option<Fit> = None;
    for round in 0..=rounds {
        let smoother = Smoother::new(measurements, order, noise, prior).strictly_convex();
        let effort = StoppingCriteria { iterations: if round == 0 { 40 } else { 12 }, tolerance: 1e-7 };
        estimate = smoother.run(estimate.coefficients, estimate.psi, effort);
        if !estimate.cost.is_finite() {
            return best;
        }
        let normal = smoother.linearise(&estimate.coefficients, &estimate.psi);
        let factor = smoother.factor(&normal)?;
        let log_evidence = log_evidence(&smoother, &estimate, &normal, &factor)
            - neg_log_prior(measurements, &estimate, noise.balance_m);
        let variance: Vec<f64> = factor.inverse().diagonal().iter().copied().collect();
        best = Some(Fit { estimate: estimate.clone(), order, noise, prior, log_evidence });
        let next = updated_noise(&smoother, &estimate, &variance, variance_components);
        prior.scale_m = updated_scale(&estimate.coefficients, &variance, prior);
        let settled =
            (next.sensor_m / noise.sensor_m).ln().abs() < 0.01 && (next.balance_m / noise.balance_m).ln().abs() < 0.05;
        noise = next;
        weigh_balance(measurements, &estimate, noise.balance_m);
        if settled {
            break;
        }
    }
    best
}
