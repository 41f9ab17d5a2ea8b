//! Variance components: the standard deviations of contacts and balance from squared residuals over their redundancy, and the
//! scale of the prior by expectation-maximisation (`docs/theory.md`, what the log says of itself).

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother};

/// Which standard deviations are estimated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarianceComponents {
    /// Whether the sensor noise is estimated (not stated by log or user).
    pub sensor: bool,
    /// Least standard deviation of a sensor, metres.
    pub floor_m: f64,
    /// Least standard deviation of the balance, as a share of that of a sensor.
    pub least_balance_share: f64,
}

/// The balance is never taken to be more exact than this share of the sensor noise, which leaves each orientation to the contacts no more. With a
/// tenth, orientations of a log that was felt once took up the noise of its sensors, and shapes that let them do so were preferred (J. Neyman and
/// E. L. Scott, *Consistent estimates based on partially consistent observations*, Econometrica 16, 1948).
pub(crate) const LEAST_BALANCE_SHARE: f64 = 0.02;

/// The same where motions are still compared and samples at wrong poses are to be found: a balance that is more exact holds them there.
pub(crate) const LEAST_BALANCE_SHARE_AT_FIRST: f64 = 0.1;

/// Least share of the redundancy that the coefficients leave, for logs with hardly more readings than coefficients.
const LEAST_FREE_SHARE: f64 = 0.05;

/// Largest factor by which one update changes a standard deviation, so that a poor first fit does not mislead the next; and its
/// inverse.
const LARGEST_STEP: f64 = 5.0;
const SMALLEST_STEP: f64 = 0.2;

/// Floors of information and redundancy: no division by zero.
const LEAST_INFORMATION: f64 = 1e-300;
const LEAST_REDUNDANCY: f64 = 1e-9;

/// Range of the scale of the prior, as shares of the size of the object: from a near-circular one to harmonics as large as the
/// object.
const SCALES: [f64; 2] = [0.02, 2.0];

/// The measurements with the weights of the balance at an estimate. The balance fails in bursts (ringing after a jump, stick and
/// slip), so that its errors follow Student's t, not a Gaussian: iteratively reweighted, each sample has the weight (ν + 1)/(ν +
/// (g/σ_b)²).
pub(crate) fn with_balance_weights(
    mut measurements: Measurements,
    estimate: &Estimate,
    balance_m: f64,
) -> Measurements {
    let counted =
        measurements.instants.iter_mut().zip(&estimate.psi).filter(|(instant, _)| instant.balance_weight > 0.0);
    for (instant, &psi) in counted {
        let g = residuals(instant, &estimate.coefficients, psi).value[2];
        instant.balance_weight = balance_weight(g / balance_m);
    }
    measurements
}

/// The weight of a balance that is missed by so many standard deviations.
pub(crate) fn balance_weight(missed_sds: f64) -> f64 {
    ((STUDENT + 1.0) / (STUDENT + missed_sds.powi(2))).sqrt()
}

/// Variance components: squared residuals of each kind over their redundancy.
pub(crate) fn updated_noise(
    smoother: &Smoother,
    estimate: &Estimate,
    variance: &[f64],
    variance_components: VarianceComponents,
) -> Noise {
    let Noise { sensor_m, balance_m } = smoother.noise;
    let (mut squares, mut redundancy) = ([0.0; 2], [0.0; 2]);
    for (instant, &psi) in smoother.measurements.instants.iter().zip(&estimate.psi) {
        let at = residuals(instant, &estimate.coefficients, psi);
        let weights = smoother.noise.weights(instant);
        let information: f64 = (0..3).map(|j| (weights[j] * at.by_psi[j]).powi(2)).sum();
        for (kind, weight, value, by_psi) in [
            (0, weights[0], at.value[0], at.by_psi[0]),
            (0, weights[1], at.value[1], at.by_psi[1]),
            (1, weights[2], at.value[2], at.by_psi[2]),
        ] {
            if weight > 0.0 {
                squares[kind] += (weight * value).powi(2);
                redundancy[kind] += 1.0 - (weight * by_psi).powi(2) / information.max(LEAST_INFORMATION);
            }
        }
    }
    let priors = smoother.prior.standard_deviations(smoother.order);
    let free: f64 = variance.iter().zip(&priors).map(|(variance, sd)| 1.0 - variance / (sd * sd)).sum();
    let total = redundancy[0] + redundancy[1];
    let share = ((total - free) / total).max(LEAST_FREE_SHARE);
    let step = |kind: usize| {
        let ratio: f64 = squares[kind] / (redundancy[kind] * share).max(LEAST_REDUNDANCY);
        ratio.sqrt().clamp(SMALLEST_STEP, LARGEST_STEP)
    };
    let sensor =
        if variance_components.sensor { (sensor_m * step(0)).max(variance_components.floor_m) } else { sensor_m };
    Noise { sensor_m: sensor, balance_m: (balance_m * step(1)).max(variance_components.least_balance_share * sensor) }
}

/// Expectation-maximisation step for the scale c of the prior: c² is the mean of k⁴ a² and k⁴ b², each with its posterior
/// variance added, and over the square of the share of c/k² that is left to it.
pub(crate) fn updated_scale(coefficients: &[f64], variance: &[f64], prior: Prior) -> f64 {
    let order = Layout::of_coefficients(coefficients).order;
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 2..=order {
        for (index, free) in [k, order + k].into_iter().zip(prior.is_free(k)) {
            if !free {
                continue;
            }
            sum += (k as f64).powi(4) * (coefficients[index].powi(2) + variance[index]) / prior.share(k).powi(2);
            count += 1.0;
        }
    }
    if count == 0.0 {
        prior.scale_m
    } else {
        (sum / count).sqrt().clamp(SCALES[0] * prior.size_m, SCALES[1] * prior.size_m)
    }
}
