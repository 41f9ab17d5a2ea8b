//! The result of a reconstruction from strokes: plain data, shared by files, the report and Python.

use std::f64::consts::TAU;

use crate::compare::mean_angle;
use crate::math::statistics::root_mean_square;
use crate::pivot::calibration::{PivotCalibration, PivotTolerances};
use crate::pivot::verdict::PivotDoubt;
use crate::reconstruct::OutlinePoint;
use crate::shape::SupportFunction;

/// Motions that are further apart than this, root mean square in radians, are not the same.
pub(super) const OTHERWISE_RAD: f64 = 0.05;

/// Shape about the pivot and motion of the object behind a log of strokes, with error bars and a verdict.
///
/// The object frame has its origin at the pivot and is turned so that ψ of the first sample with a contact is 0.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PivotReconstruction {
    /// Support function about the pivot.
    pub shape: SupportFunction,
    /// The boundary at 720 equally spaced normal angles over [0, 2π), with error bars.
    pub outline: Vec<OutlinePoint>,
    /// One pose per sample of the log, in the same order.
    pub motion: Vec<PivotPose>,
    /// Why the result is not certified; empty where it is.
    pub doubts: Vec<PivotDoubt>,
    /// Squares of what the fit leaves over what the noise explains, per degree of freedom.
    pub chi2_per_dof: f64,
    /// Fraction of the boundary (in normal angle) that was felt, 0 to 1.
    pub coverage: f64,
    /// Number of distinct arrangements of the segments that fit equally well; 1 when the answer is unique.
    pub alternatives: usize,
    /// The arrangements besides this one that fit equally well (at most four).
    pub others: Vec<PivotReconstruction>,
    /// Number of segments: stretches of the motion with the contact kept.
    pub segments: usize,
    /// Standard deviation of the offset of the contact from the foot of the pivot, metres: pad and arm together.
    pub sensor_sd_m: f64,
    /// Standard deviation of the height of the pivot over the pad, metres: the arm.
    pub arm_sd_m: f64,
    /// Constants of the rig, as the log has them: zero, scale and tilt; and as stated.
    pub calibration: PivotCalibration,
    /// What is left of their tolerances.
    pub calibration_sd: PivotTolerances,
    /// What the resting angle, and the period of swinging where the log has it, say of the centre of mass; `None` where strokes do not begin
    /// at the same angle: contact alone never tells it.
    pub center_of_mass: Option<CenterOfMassEstimate>,
}

impl PivotReconstruction {
    /// Shape and motion are statistically consistent with the log, unique and convex.
    pub fn is_certified(&self) -> bool {
        self.doubts.is_empty()
    }

    /// Standard deviation of the felt boundary, root mean square, metres; 0 where nothing was felt.
    pub fn r_sd_m(&self) -> f64 {
        let felt = self.outline.iter().filter(|point| point.touches > 0);
        root_mean_square(&felt.map(|point| point.r_sd_m).collect::<Vec<f64>>())
    }

    /// Standard deviation of ψ over the samples that were placed, root mean square, radians.
    pub fn psi_sd_rad(&self) -> f64 {
        root_mean_square(&self.motion.iter().filter_map(|pose| pose.psi_sd_rad).collect::<Vec<f64>>())
    }

    /// Whether another result of the same log has the object turn otherwise.
    pub(super) fn turns_otherwise(&self, other: &Self) -> bool {
        let both = self.motion.iter().zip(&other.motion).filter_map(|(a, b)| a.psi_rad.zip(b.psi_rad));
        let (_, off_rad) = mean_angle(&both.map(|(a, b)| a - b).collect::<Vec<f64>>(), TAU);
        off_rad > OTHERWISE_RAD
    }
}

/// The reconstructed pose at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PivotPose {
    /// Time in seconds.
    pub time_s: f64,
    /// Pivot, X in the global frame, metres, as the arm gave it.
    pub pivot_x_m: f64,
    /// Pivot, Y, metres.
    pub pivot_y_m: f64,
    /// Body angle of the contact, radians, unwrapped within a segment; `None` without a contact, or where it could not be placed.
    pub theta_rad: Option<f64>,
    /// Orientation ψ of the object, radians; `None` as above.
    pub psi_rad: Option<f64>,
    /// Posterior standard deviation of both, radians.
    pub psi_sd_rad: Option<f64>,
    /// Counts the segments from 0.
    pub segment: Option<u32>,
    /// Measured minus predicted height of the pivot over the pad, metres.
    pub height_residual_m: Option<f64>,
    /// Measured minus predicted offset of the contact from the foot of the pivot, metres.
    pub offset_residual_m: Option<f64>,
}

/// Where the centre of mass is, seen from the pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CenterOfMassEstimate {
    /// Direction from the pivot in the object frame, radians.
    pub direction_rad: f64,
    /// Its standard deviation, radians.
    pub direction_sd_rad: f64,
    /// Distance from the pivot, metres, from the period of swinging and the radius of gyration of an even mass; `None` where the log has no
    /// period, or it fits no such object.
    pub distance_m: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turning(psi_rad: impl Fn(usize) -> f64) -> PivotReconstruction {
        let pose = |index: usize| PivotPose {
            time_s: 0.1 * index as f64,
            pivot_x_m: 0.0,
            pivot_y_m: 0.03,
            theta_rad: None,
            psi_rad: (index > 0).then(|| psi_rad(index)),
            psi_sd_rad: (index > 0).then_some(0.02),
            segment: None,
            height_residual_m: None,
            offset_residual_m: None,
        };
        let point = |touches: u32| OutlinePoint {
            theta_rad: 0.0,
            r_m: 0.03,
            r_sd_m: if touches > 0 { 3e-5 } else { 1.0 },
            x_m: 0.03,
            y_m: 0.0,
            curvature_radius_m: 0.03,
            touches,
        };
        PivotReconstruction {
            shape: SupportFunction::new(0.03, vec![]),
            outline: vec![point(2), point(0)],
            motion: (0..101).map(pose).collect(),
            doubts: Vec::new(),
            chi2_per_dof: 1.0,
            coverage: 0.5,
            alternatives: 1,
            others: Vec::new(),
            segments: 1,
            sensor_sd_m: 1e-4,
            arm_sd_m: 2e-5,
            calibration: PivotCalibration::default(),
            calibration_sd: PivotTolerances::default(),
            center_of_mass: None,
        }
    }

    #[test]
    fn motions_that_differ_by_a_constant_are_the_same_and_others_are_not() {
        let one = turning(|index| 0.03 * index as f64);
        assert!(!one.turns_otherwise(&turning(|index| 2.0 + 0.03 * index as f64)));
        // Half of the samples to either side of the mean.
        let apart = |by: f64| turning(move |index| 0.03 * index as f64 + if index % 2 == 0 { by } else { -by });
        assert!(
            !one.turns_otherwise(&apart(0.99 * OTHERWISE_RAD)) && one.turns_otherwise(&apart(1.01 * OTHERWISE_RAD))
        );
    }

    #[test]
    fn error_bars_are_of_what_was_felt_and_placed() {
        let one = turning(|_| 0.0);
        assert!((one.r_sd_m() - 3e-5).abs() < 1e-18 && (one.psi_sd_rad() - 0.02).abs() < 1e-15);
    }
}
