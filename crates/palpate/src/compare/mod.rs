//! How far a reconstruction is from the truth.
//!
//! A reconstruction knows neither the orientation of the object at its first sample nor, when balance is in doubt, its
//! centre of mass; both are taken out by the best fit before errors are measured, and only there.

mod alignment;
mod hausdorff;

use std::f64::consts::TAU;

use thiserror::Error;

use crate::math::angle::{mean_direction, wrapped_to};
pub use crate::math::procrustes::{RigidMotion, procrustes, procrustes_rotation_rad};
use crate::reconstruct::{OutlinePoint, Reconstruction};
use crate::shape::{ShapeError, SupportFunction};
use crate::truth::Truth;
use alignment::Felt;

/// Harmonics that a sampled true support function is fitted with, at most.
const TRUTH_ORDER: usize = 90;

/// Errors of a reconstruction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthError {
    /// RMS error of the support function over the felt outline after the best rotation, metres.
    pub rms_r_m: f64,
    /// The same with a translation taken out as well: the error of the form alone, metres.
    pub rms_form_m: f64,
    /// Hausdorff distance of the felt boundary after the best rotation, metres: the largest distance of a felt point of
    /// the reconstruction to the true outline, or of its true counterpart to the reconstructed outline.
    pub hausdorff_m: f64,
    /// RMS error of ψ over all samples after the best constant offset, radians. Of an object that was found to be symmetric, up to
    /// multiples of the period of its symmetry.
    pub rms_psi_rad: f64,
    /// RMS distance of the centre of mass over all samples, in the global frame, metres.
    pub rms_com_m: f64,
}

/// Why a reconstruction cannot be compared with a truth.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CompareError {
    /// The truth belongs to another log.
    #[error("the truth has {truth} poses, the reconstruction {reconstruction}: they do not belong to the same log")]
    OtherLog {
        /// Number of true poses.
        truth: usize,
        /// Number of reconstructed poses.
        reconstruction: usize,
    },
    /// The true shape is unusable.
    #[error("the true shape is unusable: {0}")]
    TrueShape(#[from] ShapeError),
    /// No part of the outline was felt, or there are no poses.
    #[error("there is nothing to compare: no part of the outline was felt, or there are no poses")]
    Nothing,
}

/// Errors of `reconstruction` against `truth`, whose poses belong to the same samples in the same order.
///
/// The true support function, given as samples, is fitted with as many harmonics as they allow, at most 90.
///
/// # Errors
/// When the two do not belong together or one of them is empty.
pub fn compare(reconstruction: &Reconstruction, truth: &Truth) -> Result<TruthError, CompareError> {
    let poses = reconstruction.motion.len();
    if poses != truth.motion.len() {
        return Err(CompareError::OtherLog { truth: truth.motion.len(), reconstruction: poses });
    }
    let true_shape = true_support(truth)?;
    let felt = felt(&reconstruction.outline);
    if felt.is_empty() || poses == 0 {
        return Err(CompareError::Nothing);
    }
    let differences: Vec<f64> =
        reconstruction.motion.iter().zip(&truth.motion).map(|(found, real)| real.psi_rad - found.psi_rad).collect();
    let (offset, rms_psi_rad) = mean_angle(&differences, reconstruction.symmetry.symmetry.period_rad());
    let errors = BoundaryErrors::of(&felt, &reconstruction.shape, &true_shape, offset);
    let squares = reconstruction.motion.iter().zip(&truth.motion).map(|(found, real)| {
        let (x, y) = (found.com_x_m - real.com_x_m, found.com_y_m - real.com_y_m);
        x * x + y * y
    });
    Ok(TruthError {
        rms_r_m: errors.rms_r_m,
        rms_form_m: errors.rms_form_m,
        hausdorff_m: errors.hausdorff_m,
        rms_psi_rad,
        rms_com_m: (squares.sum::<f64>() / poses as f64).sqrt(),
    })
}

/// Errors of the felt boundary, as in [`TruthError`], and the rotation that lays the true shape best on the one found, radians.
pub(crate) struct BoundaryErrors {
    pub rms_r_m: f64,
    pub rms_form_m: f64,
    pub hausdorff_m: f64,
    pub rotation_rad: f64,
}

impl BoundaryErrors {
    /// Of a shape that was felt there, where motions agree with the true shape turned by `start_rad`.
    pub fn of(felt: &[Felt], found: &SupportFunction, truth: &SupportFunction, start_rad: f64) -> Self {
        let turned = alignment::best(felt, truth, start_rad, false);
        let moved = alignment::best(felt, truth, start_rad, true);
        Self {
            rms_r_m: turned.rms_m,
            rms_form_m: moved.rms_m.min(turned.rms_m),
            hausdorff_m: hausdorff::distance_m(felt, found, truth, turned.angle_rad),
            rotation_rad: turned.angle_rad,
        }
    }
}

/// The points of an outline that were felt.
pub(crate) fn felt(outline: &[OutlinePoint]) -> Vec<Felt> {
    let is_felt = |point: &&OutlinePoint| point.touches > 0 && point.r_m.is_finite() && point.theta_rad.is_finite();
    outline.iter().filter(is_felt).map(|point| Felt { theta_rad: point.theta_rad, r_m: point.r_m }).collect()
}

/// The true support function as a Fourier series.
///
/// # Errors
/// When the samples are fewer than three, not finite, or leave too wide a gap.
pub fn true_support(truth: &Truth) -> Result<SupportFunction, ShapeError> {
    let samples = truth.support.len();
    let order = TRUTH_ORDER.min(samples.saturating_sub(1) / 3).max(1);
    SupportFunction::from_samples(&truth.support, order)
}

/// The constant closest to some angles, and the RMS of what is left, both radians; multiples of `period` do not count.
pub(crate) fn mean_angle(angles: &[f64], period: f64) -> (f64, f64) {
    let times = TAU / period;
    let mut mean = mean_direction(angles.iter().map(|angle| times * angle)) / times;
    let count = angles.len() as f64;
    // The mean direction is a start; the least squares of the wrapped differences is the mean of them, repeated.
    for _ in 0..20 {
        let step = angles.iter().map(|angle| wrapped_to(angle - mean, period)).sum::<f64>() / count;
        mean += step;
        if step.abs() < 1e-15 {
            break;
        }
    }
    let square = angles.iter().map(|angle| wrapped_to(angle - mean, period).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}

#[cfg(test)]
mod tests;
