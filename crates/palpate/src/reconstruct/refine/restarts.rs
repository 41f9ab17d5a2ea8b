//! The long valley of the cost along what is known least of a shape: where the centre of mass of a nearly round object is. Samples at
//! wrong poses, each at a minimum of its own, bar the way down it, so that other places of it are looked at.

use crate::estimate::measurements::Measurements;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother};

/// Standard deviations from the optimum at which the valley is looked at, up and down.
const FAR: f64 = 4.0;

/// A valley shorter than this share of the mean radius (one standard deviation) hides nothing.
const SHORT: f64 = 1e-3;

/// Estimates on both sides of an optimum; none where all of the shape is known well.
pub(crate) fn along_weakest_direction(measurements: &Measurements, fit: &Fit) -> Option<[Estimate; 2]> {
    let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior);
    let (sd_m, direction) = smoother.belief(&fit.estimate)?.weakest_direction()?;
    let long = sd_m > SHORT * fit.estimate.coefficients[0].abs();
    let step = direction * (FAR * sd_m);
    long.then(|| [-1.0, 1.0].map(|side| smoother.moved(&fit.estimate, &(&step * side))))
}

#[cfg(test)]
mod tests;
