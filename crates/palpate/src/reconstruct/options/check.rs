//! Validation of logs, starts and options before any computation.

use super::{FEWEST_SAMPLES, MOST_HARMONICS};
use crate::estimate::calibration::{constants, prior_sd};
use crate::log::{Log, Sample};
use crate::reconstruct::options::ReconstructOptions;
use crate::reconstruct::options::error::ReconstructError;
use crate::sensor::{Calibration, Rig};
use crate::shape::SupportFunction;

pub(crate) fn check_log(log: &Log, options: &ReconstructOptions) -> Result<(), ReconstructError> {
    if let Some(order) = options.harmonics {
        check_harmonics(order)?;
    }
    if let Some(sd) = options.sensor_sd_m
        && !(sd > 0.0 && sd.is_finite())
    {
        let text = format!("the standard deviation of the sensors must be a positive number of metres, not {sd}");
        return Err(ReconstructError::BadOption(text));
    }
    options.limits.check()?;
    check_rig(&options.rig)?;
    check_samples(log)?;
    if options.rig.calibration == Calibration::default() {
        return Ok(());
    }
    check_samples(&options.rig.calibration.corrected(log)).map_err(|error| match error {
        ReconstructError::BadSample { sample, what } => {
            ReconstructError::BadSample { sample, what: format!("corrected by the constants of the rig, {what}") }
        }
        other => other,
    })
}

fn check_rig(rig: &Rig) -> Result<(), ReconstructError> {
    let Rig { calibration, tolerances, .. } = rig;
    let values = constants(calibration).into_iter().chain(calibration.scale).chain(calibration.surface_m);
    if values.into_iter().any(|value| !value.is_finite() || value.abs() > LARGEST_VALUE) {
        return Err(ReconstructError::BadOption("a constant of the rig is not a finite number".to_owned()));
    }
    if calibration.scale.into_iter().any(|scale| scale <= 0.0) {
        return Err(ReconstructError::BadOption("the scale of a pad must be positive; 1 is without error".to_owned()));
    }
    let sds = prior_sd(tolerances).into_iter().chain(tolerances.scale_sd).chain(tolerances.surface_sd_m);
    if sds.into_iter().any(|sd| !(0.0..LARGEST_VALUE).contains(&sd)) {
        let text = "a standard deviation of the rig is negative or no number; 0 is exact".to_owned();
        return Err(ReconstructError::BadOption(text));
    }
    Ok(())
}

pub(crate) fn check_harmonics(order: usize) -> Result<(), ReconstructError> {
    if (2..=MOST_HARMONICS).contains(&order) {
        return Ok(());
    }
    let text = format!("the number of harmonics must be from 2 to {MOST_HARMONICS}, not {order}");
    Err(ReconstructError::BadOption(text))
}

pub(crate) fn check_start(log: &Log, shape: &SupportFunction, psi_rad: Option<&[f64]>) -> Result<(), ReconstructError> {
    let mean_m = shape.mean_radius_m();
    if shape.has_nonfinite() || mean_m <= 0.0 {
        let text = format!("the shape to start from is no object (its mean radius is {mean_m} m)");
        return Err(ReconstructError::BadOption(text));
    }
    let Some(psi_rad) = psi_rad else { return Ok(()) };
    let (orientations, samples) = (psi_rad.len(), log.samples.len());
    if orientations != samples {
        return Err(ReconstructError::StartOfOtherLength { orientations, samples });
    }
    match psi_rad.iter().position(|psi| !psi.is_finite() || psi.abs() > LARGEST_VALUE) {
        Some(index) => {
            let text = format!("the orientation to start from at sample {} (counted from 1) is no angle", index + 1);
            Err(ReconstructError::BadOption(text))
        }
        None => Ok(()),
    }
}

pub(crate) fn check_samples(log: &Log) -> Result<(), ReconstructError> {
    for (index, sample) in log.samples.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| &log.samples[before]);
        check_sample(before, sample)
            .map_err(|what| ReconstructError::BadSample { sample: index + 1, what: what.to_owned() })?;
    }
    let seen = log.samples.iter().filter(|sample| sample.s1_m.is_some() && sample.s2_m.is_some()).count();
    if seen < FEWEST_SAMPLES {
        return Err(ReconstructError::TooFewSamples { seen, needed: FEWEST_SAMPLES });
    }
    Ok(())
}

/// What is wrong with a sample, behind another.
pub(crate) fn check_sample(before: Option<&Sample>, sample: &Sample) -> Result<(), &'static str> {
    let palms = &sample.palms;
    let numbers = [sample.time_s, palms.phi1_rad, palms.phi2_rad]
        .into_iter()
        .chain(palms.base1_m)
        .chain(palms.base2_m)
        .chain([sample.s1_m, sample.s2_m, sample.s1_sd_m, sample.s2_sd_m].into_iter().flatten())
        .chain(sample.forces_n().into_iter().flatten());
    if numbers.into_iter().any(|value| !value.is_finite() || value.abs() > LARGEST_VALUE) {
        return Err("a value is not a finite number, or is far too large");
    }
    if palms.phi2_rad.sin().abs() < SMALLEST_OPENING {
        return Err("the palms are parallel");
    }
    if [sample.s1_sd_m, sample.s2_sd_m].into_iter().flatten().any(|sd| sd <= 0.0) {
        return Err("a standard deviation is not positive");
    }
    if sample.forces_n().into_iter().flatten().any(|force_n| force_n < 0.0) {
        return Err("a normal force is negative; a palm only pushes");
    }
    if before.is_some_and(|before| before.time_s > sample.time_s) {
        return Err("time runs backwards");
    }
    Ok(())
}

/// Palms closer to parallel than this (sine of the angle between them) are refused: the equations divide by it.
const SMALLEST_OPENING: f64 = 1e-3;

/// Largest time, angle or length of a log: beyond it sums lose their digits.
const LARGEST_VALUE: f64 = 1e12;
