//! Limits of the force balance g = 0 (`docs/theory.md`, balance): how exact it must be, and which poses at rest are stable.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::{AT_REST, contacts};
use crate::estimate::model::noise::Noise;
use crate::mechanics::Forces;
use crate::mechanics::force_model::{ForceModel, MotionState};

/// Systematic errors that no shape explains (palms that are not quite slow, not quite straight) are allowed up to this share of
/// the mean radius: with less, real palms would be refused; with more, wrong shapes would pass.
pub(crate) const MODEL_ALLOWANCE: f64 = 2e-3;

/// Balance holds while its standard deviation is at most so many times that of the contact positions, or so many times
/// [`MODEL_ALLOWANCE`]: friction and fast palms exceed both.
pub(crate) const BALANCE_SENSOR_SDS: f64 = 3.0;
pub(crate) const BALANCE_ALLOWANCES: f64 = 4.0;

/// Standard deviation of the balance up to which statics holds, metres.
pub(crate) fn balance_limit_m(sensor_m: f64, mean_radius_m: f64) -> f64 {
    (BALANCE_SENSOR_SDS * sensor_m).max(BALANCE_ALLOWANCES * MODEL_ALLOWANCE * mean_radius_m)
}

/// Number of samples at rest at a pose that is no minimum of the potential energy. `slack_m` is allowed for errors of the
/// stiffness; `balance_m` is the standard deviation of the balance.
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

/// Error of the stiffness that errors of the shape cause, as a share of the mean radius: a pose is unstable beyond it.
pub(crate) const STABILITY_SLACK: f64 = 0.05;

/// The balance is inexact when its standard deviation exceeds this share of the sensor noise; an exact log has a tenth of it.
pub(crate) const INEXACT_BALANCE: f64 = 0.5;

/// Standard deviation of the balance, over that of the contacts, of exact statics as a fit begins with it; and the one above which a balance
/// is loose.
pub(crate) const EXACT_BALANCE: f64 = 0.1;
const LOOSE_BALANCE: f64 = 0.2;

/// Where the balance is loose, the same noise with an exact one: wrong poses can make it seem loose, and a loose balance holds them.
pub(crate) fn with_exact_balance(noise: Noise) -> Option<Noise> {
    let Noise { sensor_m, balance_m } = noise;
    (balance_m > LOOSE_BALANCE * sensor_m).then_some(Noise { sensor_m, balance_m: EXACT_BALANCE * sensor_m })
}

/// Contacts with more noise than this share of the mean radius are noisy: below it the contacts alone determine every pose.
const NOISY_CONTACTS: f64 = 3e-4;

/// Whether the balance is missed by more than in exact statics, while the contacts are too noisy to show the cause.
pub(crate) fn balance_is_missed(sensor_m: f64, balance_m: f64, mean_radius_m: f64) -> bool {
    sensor_m > NOISY_CONTACTS * mean_radius_m.abs() && balance_m > INEXACT_BALANCE * sensor_m
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS_M: f64 = 0.03;

    #[test]
    fn the_balance_is_missed_only_above_its_share_of_the_sensor_noise() {
        let sensor_m = 2.0 * NOISY_CONTACTS * RADIUS_M;
        assert!(balance_is_missed(sensor_m, 1.001 * INEXACT_BALANCE * sensor_m, RADIUS_M));
        assert!(!balance_is_missed(sensor_m, 0.999 * INEXACT_BALANCE * sensor_m, RADIUS_M));
        assert!(!balance_is_missed(sensor_m, INEXACT_BALANCE * sensor_m, RADIUS_M), "the limit itself is not above it");
    }

    #[test]
    fn the_balance_is_missed_only_where_the_contacts_are_noisy() {
        let balance_m = RADIUS_M;
        assert!(balance_is_missed(1.001 * NOISY_CONTACTS * RADIUS_M, balance_m, RADIUS_M));
        assert!(!balance_is_missed(0.999 * NOISY_CONTACTS * RADIUS_M, balance_m, RADIUS_M));
        assert!(!balance_is_missed(NOISY_CONTACTS * RADIUS_M, balance_m, RADIUS_M), "the limit itself is not above it");
    }

    #[test]
    fn a_balance_is_made_exact_where_it_is_loose() {
        let at = |share: f64| with_exact_balance(Noise { sensor_m: 1e-4, balance_m: share * 1e-4 });
        assert_eq!(at(1.001 * LOOSE_BALANCE), Some(Noise { sensor_m: 1e-4, balance_m: EXACT_BALANCE * 1e-4 }));
        assert_eq!(at(0.999 * LOOSE_BALANCE), None);
    }

    #[test]
    fn the_sign_of_the_mean_radius_does_not_matter() {
        assert!(balance_is_missed(1.001 * NOISY_CONTACTS * RADIUS_M, RADIUS_M, -RADIUS_M));
        assert!(!balance_is_missed(0.999 * NOISY_CONTACTS * RADIUS_M, RADIUS_M, -RADIUS_M));
    }
}
