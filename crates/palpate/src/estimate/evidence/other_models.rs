//! Other models of a log than that of its answer, with their probabilities (J. A. Hoeting et al., *Bayesian model averaging: a tutorial*, Statistical
//! Science 14, 1999): other numbers of harmonics, and other scales of the prior. Where most of the boundary was felt only once, they have
//! optima with about the same evidence and other motions, and what one of them leaves open is less than what is unknown.

use crate::estimate::evidence::laplace::log_evidence;
use crate::estimate::evidence::motion_prior::neg_log_prior;
use crate::estimate::evidence::order::orders;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use rayon::prelude::*;

/// Numbers of harmonics that are tried on each side of that of the answer: the evidence is flat over one or two.
const NUMBERS: usize = 2;

/// Scales of the prior that are tried, as multiples of that of the answer: of the few harmonics that a short log determines, it is known to a
/// factor of two.
const SCALES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// Effort of the smoother for each.
const STOPPING: StoppingCriteria = StoppingCriteria { iterations: 60, tolerance: 1e-7 };

/// Least probability that counts: with less, a model a whole turn away adds less than a degree.
const LEAST_WEIGHT: f64 = 1e-5;

/// The optima of the other models, each with its probability, from that of the answer and with its noise.
pub(crate) fn other_models(measurements: &Measurements, answer: &Fit) -> Vec<(f64, Fit)> {
    let orders = orders(answer.prior.symmetry.order);
    let here = orders.iter().position(|&order| order >= answer.order).unwrap_or(orders.len());
    let numbers = &orders[here.saturating_sub(NUMBERS)..(here + NUMBERS + 1).min(orders.len())];
    let models: Vec<(usize, f64)> = numbers
        .iter()
        .flat_map(|order| SCALES.map(|scale| (*order, scale * answer.prior.scale_m)))
        .filter(|model| *model != (answer.order, answer.prior.scale_m))
        .collect();
    let optimum = |(order, scale_m): (usize, f64)| {
        let prior = Prior { scale_m, ..answer.prior };
        let smoother = Smoother::new(measurements, order, answer.noise, prior).strictly_convex();
        let Estimate { coefficients, psi, .. } = answer.estimate.clone();
        let estimate = smoother.run(coefficients, psi, STOPPING);
        if !estimate.cost.is_finite() {
            return None;
        }
        let normal = smoother.linearise(&estimate.coefficients, &estimate.psi);
        let log_evidence = log_evidence(&smoother, &estimate, &normal, &smoother.factor(&normal)?)
            - neg_log_prior(measurements, &estimate, answer.noise.balance_m, prior.symmetry.period_rad());
        log_evidence.is_finite().then_some(Fit { estimate, order, noise: answer.noise, prior, log_evidence })
    };
    let fits: Vec<Fit> = models.into_par_iter().filter_map(optimum).collect();
    let most = fits.iter().map(|fit| fit.log_evidence).fold(answer.log_evidence, f64::max);
    let odds = |fit: &Fit| (fit.log_evidence - most).exp();
    let sum = odds(answer) + fits.iter().map(odds).sum::<f64>();
    let weighted = fits.into_iter().map(|fit| (odds(&fit) / sum, fit));
    weighted.filter(|(weight, _)| *weight > LEAST_WEIGHT).collect()
}
