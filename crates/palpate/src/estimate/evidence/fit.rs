//! The optimum for one number of harmonics, with noise and prior that follow the data.

use crate::estimate::evidence::laplace::log_evidence;
use crate::estimate::evidence::motion_prior::neg_log_prior;
use crate::estimate::evidence::variance_components::{
    VarianceComponents, updated_noise, updated_scale, with_balance_weights,
};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};

/// Times that noise and prior follow the data in one fit.
pub(crate) const ROUNDS: usize = 4;

/// An optimum, and the measurements with the weights of the balance that its residuals call for: where a further fit goes on.
#[derive(Clone, Debug)]
pub(crate) struct Fitted {
    pub fit: Fit,
    pub weighted: Measurements,
}

/// Runs the smoother, lets noise and prior follow the data, and runs it again, `rounds` times. `None` where no optimum is found.
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
        let stopping = StoppingCriteria { iterations: if round == 0 { 40 } else { 12 }, tolerance: 1e-7 };
        estimate = smoother.run(estimate.coefficients, estimate.psi, stopping);
        if !estimate.cost.is_finite() {
            break;
        }
        let normal = smoother.linearise(&estimate.coefficients, &estimate.psi);
        let factor = smoother.factor(&normal)?;
        let log_evidence =
            log_evidence(&smoother, &estimate, &normal, &factor) - neg_log_prior(&weighted, &estimate, noise.balance_m);
        let variance: Vec<f64> = factor.inverse().diagonal().iter().copied().collect();
        best = Some(Fit { estimate: estimate.clone(), order, noise, prior, log_evidence });
        let next = updated_noise(&smoother, &estimate, &variance, variance_components);
        prior.scale_m = updated_scale(&estimate.coefficients, &variance, prior);
        let settled = (next.sensor_m / noise.sensor_m).ln().abs() < SETTLED_SENSOR
            && (next.balance_m / noise.balance_m).ln().abs() < SETTLED_BALANCE;
        noise = next;
        weighted = with_balance_weights(weighted, &estimate, noise.balance_m);
        if settled {
            break;
        }
    }
    best.map(|fit| Fitted { fit, weighted })
}

/// Noise that changes by less than these shares of itself no longer follows the data: far below what a log tells of it.
const SETTLED_SENSOR: f64 = 0.01;
const SETTLED_BALANCE: f64 = 0.05;
