//! Noise and size of the prior, as large as the data have them (variance components, expectation-maximisation).

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother};

/// Which standard deviations the data may change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VarianceComponents {
    /// The sensor noise is estimated (not stated by log or user).
    pub sensor: bool,
    /// Smallest standard deviation of a sensor that makes sense, metres.
    pub floor_m: f64,
}

/// The balance is never believed to be more exact than this share of the sensor noise.
const STRICTEST_BALANCE: f64 = 0.1;

/// The measurements with other weights of the balance. It is missed in bursts (ringing after a jump, a stick and a slip), so its errors
/// follow Student's t, not a Gaussian: each sample weighs (ν + 1)/(ν + (g/σ_b)²).
pub(crate) fn with_balance_weights(
    mut measurements: Measurements,
    estimate: &Estimate,
    balance_m: f64,
) -> Measurements {
    let counted =
        measurements.instants.iter_mut().zip(&estimate.psi).filter(|(instant, _)| instant.balance_weight > 0.0);
    for (instant, &psi) in counted {
        let g = residuals(instant, &estimate.coefficients, psi).value[2];
        instant.balance_weight = ((STUDENT + 1.0) / (STUDENT + (g / balance_m).powi(2))).sqrt();
    }
    measurements
}

/// Variance components: squared residuals of each kind over the redundancy that the fit leaves them.
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
                redundancy[kind] += 1.0 - (weight * by_psi).powi(2) / information.max(1e-300);
            }
        }
    }
    let priors = smoother.prior.standard_deviations(smoother.order);
    let free: f64 = variance.iter().zip(&priors).map(|(variance, sd)| 1.0 - variance / (sd * sd)).sum();
    let total = redundancy[0] + redundancy[1];
    let share = ((total - free) / total).max(0.05);
    let step = |kind: usize| {
        let ratio: f64 = squares[kind] / (redundancy[kind] * share).max(1e-9);
        ratio.sqrt().clamp(0.2, 5.0)
    };
    let sensor =
        if variance_components.sensor { (sensor_m * step(0)).max(variance_components.floor_m) } else { sensor_m };
    Noise { sensor_m: sensor, balance_m: (balance_m * step(1)).max(STRICTEST_BALANCE * sensor) }
}

/// Expectation-maximisation step for the prior's c: the mean of k⁴(a² + b²), with what is uncertain of each added.
pub(crate) fn updated_scale(coefficients: &[f64], variance: &[f64], prior: Prior) -> f64 {
    let order = Layout::of_coefficients(coefficients).order;
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 2..=order {
        for index in [k, order + k] {
            sum += (k as f64).powi(4) * (coefficients[index].powi(2) + variance[index]);
            count += 1.0;
        }
    }
    if count == 0.0 { prior.scale_m } else { (sum / count).sqrt().clamp(0.02 * prior.size_m, 2.0 * prior.size_m) }
}
