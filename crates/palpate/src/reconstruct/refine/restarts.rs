//! Restarts along the weakest direction of a shape, the eigenvector of the posterior covariance with the largest variance
//! (`docs/theory.md`, the search). The cost has a long valley there: the place of the centre of mass of a nearly round object.
//! Samples at wrong poses, each at a local minimum, can hold an optimum on the slope of the valley, so that fits from other
//! places along it are compared.

use crate::estimate::measurements::Measurements;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother};

/// Standard deviations from the optimum at which restarts begin, to both sides: held optima lie up to five away.
const RESTART_SDS: f64 = 4.0;

/// Least standard deviation along the weakest direction, as a share of the mean radius, for which restarts are made: a shorter
/// valley holds no optimum.
const LEAST_LENGTH: f64 = 1e-3;

/// Estimates on both sides of an optimum; none where every direction of the shape is known well.
pub(crate) fn along_weakest_direction(measurements: &Measurements, fit: &Fit) -> Option<[Estimate; 2]> {
    let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior);
    let (sd_m, direction) = smoother.posterior(&fit.estimate)?.weakest_direction()?;
    let long = sd_m > LEAST_LENGTH * fit.estimate.coefficients[0].abs();
    let step = direction * (RESTART_SDS * sd_m);
    long.then(|| [-1.0, 1.0].map(|side| smoother.moved(&fit.estimate, &(&step * side))))
}

#[cfg(test)]
mod tests;
