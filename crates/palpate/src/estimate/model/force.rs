//! What the estimator asks of the balance: how exact it is, and how far it may be missed.

use crate::estimate::measurements::Problem;
use crate::estimate::model::contact::contacts;
use crate::mechanics::force_model::ForceModel;
use crate::mechanics::force_model::MotionState;
use crate::mechanics::frictionless::Frictionless;

/// Smooth errors that no shape explains (palms that are not quite slow, not quite straight) are forgiven up to this share
/// of the mean radius.
pub(crate) const MODEL_ALLOWANCE: f64 = 2e-3;

/// Standard deviation of the balance up to which statics holds, metres.
pub(crate) fn balance_limit_m(sensor_m: f64, mean_radius_m: f64) -> f64 {
    (3.0 * sensor_m).max(4.0 * MODEL_ALLOWANCE * mean_radius_m)
}

/// Samples that rest at a pose that is no minimum of the potential energy, by more than errors of the shape explain. The
/// balance is missed by `balance_m` as a rule.
pub(crate) fn unstable_samples(problem: &Problem, coefficients: &[f64], psi: &[f64], balance_m: f64) -> usize {
    let slack_m = STABILITY_SLACK * coefficients[0].abs();
    let poses = problem.instants.iter().zip(psi);
    poses
        .filter(|(instant, psi)| {
            let state = MotionState::at_rest(instant.palms, contacts(instant, coefficients, **psi));
            Frictionless.is_unstable(&Frictionless.residual(&state), slack_m, AT_REST * balance_m)
        })
        .count()
}

/// Stiffness that errors of the shape may feign, as a share of the mean radius.
const STABILITY_SLACK: f64 = 0.05;

/// A pose whose balance is missed by more standard deviations than this is on its way (ringing); only one that rests can rest unstably.
pub(crate) const AT_REST: f64 = 4.0;

/// The balance is inexact when it is missed by more than this share of the sensor noise.
pub(crate) const INEXACT: f64 = 0.5;

/// Contacts with more noise than this share of the mean radius are noisy.
const NOISY: f64 = 3e-4;

/// Whether the balance is missed by more than exact statics would, and contacts too noisy to tell why.
pub(crate) fn missed(sensor_m: f64, balance_m: f64, mean_radius_m: f64) -> bool {
    sensor_m > NOISY * mean_radius_m.abs() && balance_m > INEXACT * sensor_m
}
