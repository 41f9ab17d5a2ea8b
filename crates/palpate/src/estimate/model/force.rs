//! What the estimator asks of the balance: how exact it is, and how far it may be missed.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::{AT_REST, contacts};
use crate::mechanics::Forces;
use crate::mechanics::force_model::{ForceModel, MotionState};

/// Smooth errors that no shape explains (palms that are not quite slow, not quite straight) are forgiven up to this share
/// of the mean radius.
pub(crate) const MODEL_ALLOWANCE: f64 = 2e-3;

/// Balance holds while its standard deviation is at most so many of the contact positions', or so many times [`MODEL_ALLOWANCE`].
pub(crate) const BALANCE_SENSOR_SDS: f64 = 3.0;
pub(crate) const BALANCE_ALLOWANCES: f64 = 4.0;

/// Standard deviation of the balance up to which statics holds, metres.
pub(crate) fn balance_limit_m(sensor_m: f64, mean_radius_m: f64) -> f64 {
    (BALANCE_SENSOR_SDS * sensor_m).max(BALANCE_ALLOWANCES * MODEL_ALLOWANCE * mean_radius_m)
}

/// Samples that rest at a pose that is no minimum of the potential energy, by more than errors of the shape explain.
/// `slack_m` is forgiven in the stiffness; the balance is missed by `balance_m` as a rule.
pub(crate) fn unstable_samples(
    measurements: &Measurements,
    coefficients: &[f64],
    psi: &[f64],
    slack_m: f64,
    balance_m: f64,
) -> usize {
    let poses = measurements.instants.iter().zip(psi);
    poses
        .filter(|(instant, psi)| {
            let state = MotionState::at_rest(instant.palms, contacts(instant, coefficients, **psi));
            Forces::default().is_unstable(&Forces::default().residual(&state), slack_m, AT_REST * balance_m)
        })
        .count()
}

/// Stiffness that errors of the shape may feign, as a share of the mean radius.
pub(crate) const STABILITY_SLACK: f64 = 0.05;

/// The balance is inexact when it is missed by more than this share of the sensor noise.
pub(crate) const INEXACT: f64 = 0.5;

/// Contacts with more noise than this share of the mean radius are noisy.
const NOISY: f64 = 3e-4;

/// Whether the balance is missed by more than exact statics would, and contacts too noisy to tell why.
pub(crate) fn balance_is_missed(sensor_m: f64, balance_m: f64, mean_radius_m: f64) -> bool {
    sensor_m > NOISY * mean_radius_m.abs() && balance_m > INEXACT * sensor_m
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_M: f64 = 0.03;

    #[test]
    fn the_balance_is_missed_only_above_its_share_of_the_sensor_noise() {
        let sensor_m = 2.0 * NOISY * RADIUS_M;
        assert!(balance_is_missed(sensor_m, 1.001 * INEXACT * sensor_m, RADIUS_M));
        assert!(!balance_is_missed(sensor_m, 0.999 * INEXACT * sensor_m, RADIUS_M));
        assert!(!balance_is_missed(sensor_m, INEXACT * sensor_m, RADIUS_M), "the limit itself is not above it");
    }

    #[test]
    fn the_balance_is_missed_only_where_the_contacts_are_noisy() {
        let balance_m = RADIUS_M;
        assert!(balance_is_missed(1.001 * NOISY * RADIUS_M, balance_m, RADIUS_M));
        assert!(!balance_is_missed(0.999 * NOISY * RADIUS_M, balance_m, RADIUS_M));
        assert!(!balance_is_missed(NOISY * RADIUS_M, balance_m, RADIUS_M), "the limit itself is not above it");
    }

    #[test]
    fn a_mean_radius_that_comes_out_negative_limits_the_noise_as_its_size_does() {
        assert!(balance_is_missed(1.001 * NOISY * RADIUS_M, RADIUS_M, -RADIUS_M));
        assert!(!balance_is_missed(0.999 * NOISY * RADIUS_M, RADIUS_M, -RADIUS_M));
    }
}
