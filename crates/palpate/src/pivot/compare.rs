//! How far a reconstruction from strokes is from the truth, after the best rotation: neither knows the other's frame.

use crate::compare::{BoundaryErrors, CompareError, felt, mean_angle, true_support};
use crate::math::angle::mean_direction;
use crate::pivot::result::PivotReconstruction;
use crate::truth::Truth;

/// Errors of a reconstruction from strokes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PivotTruthError {
    /// RMS error of the support function about the pivot over the felt boundary after the best rotation, metres.
    pub rms_r_m: f64,
    /// The same with a translation taken out as well: the error of the form alone, metres.
    pub rms_form_m: f64,
    /// Hausdorff distance of the felt boundary after the best rotation, metres.
    pub hausdorff_m: f64,
    /// RMS error of ψ over the samples with a contact that were placed, after the best constant offset, radians.
    pub rms_psi_rad: f64,
    /// Rotation that lays the true shape best on the one found, radians.
    pub rotation_rad: f64,
}

/// Errors of `reconstruction` against `truth`, whose poses belong to the same samples and whose support function is about the pivot.
///
/// # Errors
/// When the two do not belong together or one of them is empty.
pub fn compare_strokes(reconstruction: &PivotReconstruction, truth: &Truth) -> Result<PivotTruthError, CompareError> {
    let poses = reconstruction.motion.len();
    if poses != truth.motion.len() {
        return Err(CompareError::OtherLog { truth: truth.motion.len(), reconstruction: poses });
    }
    let true_shape = true_support(truth)?;
    let felt = felt(&reconstruction.outline);
    let differences: Vec<f64> = reconstruction
        .motion
        .iter()
        .zip(&truth.motion)
        .filter_map(|(found, real)| found.psi_rad.map(|psi| real.psi_rad - psi))
        .collect();
    if felt.is_empty() || differences.is_empty() {
        return Err(CompareError::Nothing);
    }
    let (start_rad, rms_psi_rad) = mean_angle(&differences, std::f64::consts::TAU);
    let errors = BoundaryErrors::of(&felt, &reconstruction.shape, &true_shape, mean_direction([start_rad]));
    Ok(PivotTruthError {
        rms_r_m: errors.rms_r_m,
        rms_form_m: errors.rms_form_m,
        hausdorff_m: errors.hausdorff_m,
        rms_psi_rad,
        rotation_rad: errors.rotation_rad,
    })
}
