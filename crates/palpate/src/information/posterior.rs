//! What a reconstruction has learnt of the shape, as a covariance.

use super::error::InformationError;
use super::shape_covariance::{Information, check};
use crate::estimate::calibration::CalibrationPosterior;
use crate::estimate::evidence::symmetry::turn_to_axis;
use crate::estimate::evidence::variance_components::{updated_scale, with_balance_weights};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::rotate;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::log::Log;
use crate::math::statistics::correlation_time;
use crate::reconstruct::{CalibrationEstimate, Reconstruction};

/// The posterior covariance of a shape that was reconstructed from `log` by [`Method::Likelihood`](crate::reconstruct::Method): what the
/// error bars of its [`outline`](Reconstruction::outline) are made of, in the frame of the result. It is computed anew, from the result
/// and the log (as it was read, where constants of the rig were open), and agrees with those error bars to a few percent. Samples whose pose cannot be told count as placed where the result has
/// them.
///
/// # Errors
/// When `log` has another number of samples, a number is not finite or not positive (as the balance of the methods that integrate may be),
/// or the log does not determine the shape.
pub fn posterior(log: &Log, reconstruction: &Reconstruction) -> Result<Information, InformationError> {
    let Reconstruction { shape, sensor_sd_m, balance_sd_m, .. } = reconstruction;
    let (sensor_m, balance_m) = (*sensor_sd_m, *balance_sd_m);
    let psi: Vec<f64> = reconstruction.motion.iter().map(|pose| pose.psi_rad).collect();
    check(log, shape, &psi, sensor_m)?;
    if !(balance_m > 0.0 && balance_m.is_finite()) {
        let what =
            format!("the standard deviation of the balance must be a positive number of metres, not {balance_m}");
        return Err(InformationError::BadNumber { what });
    }
    let rig = reconstruction.calibration.as_ref().map(CalibrationEstimate::prior_rig).unwrap_or_default();
    let log = &rig.calibration.corrected(log);
    let measurements = Measurements::new(log, Some(sensor_m));
    let size_m = measurements.size_m();
    // A mirror holds in the frame in which its axis is at θ = 0.
    let (mut coefficients, symmetry) = (shape.coefficients(), reconstruction.symmetry.symmetry);
    let turn = turn_to_axis(&coefficients, symmetry);
    rotate(&mut coefficients, turn);
    let psi = psi.into_iter().map(|psi| psi - turn).collect();
    let estimate = Estimate { coefficients, psi, cost: 0.0 };
    let measurements = with_balance_weights(measurements, &estimate, balance_m);
    let order = shape.harmonics_m().len();
    let noise = Noise { sensor_m, balance_m };
    let of = |prior: Prior| Fit { estimate: estimate.clone(), order, noise, prior, evidence: Evidence::NONE };
    let felt_rad: Vec<f64> =
        reconstruction.outline.iter().filter(|point| point.touches > 0).map(|point| point.theta_rad).collect();
    let felt_there: Vec<f64> = felt_rad.iter().map(|theta_rad| theta_rad + turn).collect();
    let poses = &reconstruction.motion;
    let left1: Vec<f64> = poses.iter().filter_map(|pose| pose.residual1_m).collect();
    let left2: Vec<f64> = poses.iter().filter_map(|pose| pose.residual2_m).collect();
    let inflation = 0.5 * (correlation_time(&left1) + correlation_time(&left2));
    // The estimator's own prior of the harmonics follows the data; so does this one.
    let mut prior = Prior { symmetry, ..Prior::new(size_m, 0.5 * size_m) };
    let constants = |prior: Prior| {
        let fit = of(prior);
        let open = CalibrationPosterior::new(log, &measurements, &fit, &rig, &rig.calibration)?;
        Some(open.borne_out_by(&measurements, &fit).open_constants())
    };
    for _ in 0..ROUNDS {
        let information = Information::at(&measurements, &of(prior), felt_there.clone(), 1.0, constants(prior))?;
        prior.scale_m = updated_scale(&estimate.coefficients, &information.variances_m2(), prior);
    }
    Ok(Information::at(&measurements, &of(prior), felt_there, inflation, constants(prior))?.turned(-turn, felt_rad))
}

/// Times that the prior follows the data.
const ROUNDS: usize = 3;
