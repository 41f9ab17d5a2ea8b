//! The result folder of strokes: report.html, shape.csv, motion.csv and summary.json, there as a whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use palpate::pivot::{
    CenterOfMassEstimate, PivotCalibration, PivotDoubt, PivotReconstruction, PivotTolerances, PivotTruthError,
};
use serde::{Deserialize, Serialize};

use crate::csv::columns::{SHAPE_HEADER, point_row};
use crate::csv::number::{number, push_row};
use crate::folder::FolderKind;
use crate::write_error::{WriteError, WriteProblem};

const REPORT_FILE: &str = "report.html";
const SHAPE_FILE: &str = "shape.csv";
const MOTION_FILE: &str = "motion.csv";
const SUMMARY_FILE: &str = "summary.json";
const MOTION_HEADER: &str =
    "time_s,pivot_x_m,pivot_y_m,theta_rad,psi_rad,psi_sd_rad,segment,height_residual_m,offset_residual_m";

const RESULT: FolderKind<'static> = FolderKind {
    kind: "result",
    files: &[REPORT_FILE, SHAPE_FILE, MOTION_FILE, SUMMARY_FILE],
    numbered: None,
    folders: (&[], &[]),
    mark: SUMMARY_FILE,
    is_mark: |path| fs::read(path).is_ok_and(|bytes| serde_json::from_slice::<StrokesSummary>(&bytes).is_ok()),
};

/// What rig a result is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StrokesRig {
    /// An arm that holds the object at a pivot, and one pad.
    Pivot,
}

/// A reason why a result of strokes is not certified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrokesReason {
    /// Kind and numbers.
    #[serde(flatten)]
    pub doubt: PivotDoubt,
    /// In words.
    pub message: String,
    /// What to do about it.
    pub next_step: String,
}

/// `summary.json` of strokes. Lengths are metres, angles radians.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrokesSummary {
    /// `pivot`.
    pub rig: StrokesRig,
    /// Whether shape and motion are certified.
    pub certified: bool,
    /// Why not.
    pub reasons: Vec<StrokesReason>,
    /// Samples, and those with a contact that were placed.
    pub samples: usize,
    /// See above.
    pub placed: usize,
    /// Stretches of the motion with the contact kept.
    pub segments: usize,
    /// Fraction of the boundary that was felt, 0 to 1.
    pub coverage: f64,
    /// Mean radius (perimeter over 2π).
    pub mean_radius_m: f64,
    /// Standard deviation of the felt boundary, root mean square.
    pub r_sd_m: Option<f64>,
    /// Harmonics (a_k, b_k) of the support function about the pivot, k = 1 … K; a₀ is the mean radius.
    pub harmonics_m: Vec<[f64; 2]>,
    /// Squares of what the fit leaves over what the noise explains, per degree of freedom.
    pub chi2_per_dof: f64,
    /// Standard deviations of the offset of a contact and of the height of the pivot.
    pub sensor_sd_m: f64,
    /// See above.
    pub arm_sd_m: f64,
    /// Constants of the rig as the log has them, and how well.
    pub calibration: PivotCalibration,
    /// See above.
    pub calibration_sd: PivotTolerances,
    /// What resting angle and swinging say of the centre of mass.
    pub center_of_mass: Option<CenterOfMassEstimate>,
    /// Arrangements that fit equally well, this one among them.
    pub alternatives: usize,
    /// Errors against a known truth.
    pub truth: Option<StrokesTruth>,
}

/// Errors of a result of strokes against a known truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrokesTruth {
    /// Of the support function about the pivot over the felt boundary, root mean square.
    pub rms_r_m: f64,
    /// Largest distance between the felt boundary and the true one.
    pub hausdorff_m: f64,
    /// Of the orientation, root mean square.
    pub rms_psi_rad: f64,
}

impl StrokesSummary {
    /// Of a result, and its errors where the truth is known.
    pub fn new(found: &PivotReconstruction, truth: Option<&PivotTruthError>) -> Self {
        let reason = |doubt: &PivotDoubt| StrokesReason {
            doubt: *doubt,
            message: doubt.to_string(),
            next_step: doubt.next_step().to_owned(),
        };
        Self {
            rig: StrokesRig::Pivot,
            certified: found.is_certified(),
            reasons: found.doubts.iter().map(reason).collect(),
            samples: found.motion.len(),
            placed: found.motion.iter().filter(|pose| pose.psi_rad.is_some()).count(),
            segments: found.segments,
            coverage: found.coverage,
            mean_radius_m: found.shape.mean_radius_m(),
            r_sd_m: (found.coverage > 0.0).then(|| found.r_sd_m()),
            harmonics_m: found.shape.harmonics_m().to_vec(),
            chi2_per_dof: found.chi2_per_dof,
            sensor_sd_m: found.sensor_sd_m,
            arm_sd_m: found.arm_sd_m,
            calibration: found.calibration,
            calibration_sd: found.calibration_sd,
            center_of_mass: found.center_of_mass,
            alternatives: found.alternatives,
            truth: truth.map(|truth| StrokesTruth {
                rms_r_m: truth.rms_r_m,
                hausdorff_m: truth.hausdorff_m,
                rms_psi_rad: truth.rms_psi_rad,
            }),
        }
    }

    /// As the text of `summary.json`.
    ///
    /// # Errors
    /// A number that JSON cannot hold.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|json| json + "\n")
    }
}

/// Whether [`write_strokes_result`] could write to `dir`, asked before a long computation. Nothing is left behind.
///
/// # Errors
/// `dir` is a file, the current folder, or holds anything but an earlier result of strokes; or no folder can be made there.
pub fn check_strokes_target(dir: &Path) -> Result<(), WriteError> {
    RESULT.check(dir)
}

/// Writes the result folder of strokes: `report.html` (the page as it is given), `shape.csv` (columns as of palms, about the pivot), `motion.csv`
/// (a row per sample, empty cells where the object was not placed) and `summary.json`. An earlier result of strokes is replaced.
///
/// # Errors
/// As [`check_strokes_target`], or the disk is full. What was there before is then untouched.
pub fn write_strokes_result(
    dir: &Path,
    found: &PivotReconstruction,
    summary: &StrokesSummary,
    report: &str,
) -> Result<(), WriteError> {
    let mut shape = format!("{SHAPE_HEADER}\n");
    found.outline.iter().for_each(|point| push_row(&mut shape, point_row(point).map(number)));
    let mut motion = format!("{MOTION_HEADER}\n");
    for pose in &found.motion {
        let known = [pose.time_s, pose.pivot_x_m, pose.pivot_y_m].map(number);
        let segment = pose.segment.map(f64::from);
        let told =
            [pose.theta_rad, pose.psi_rad, pose.psi_sd_rad, segment, pose.height_residual_m, pose.offset_residual_m];
        push_row(&mut motion, known.into_iter().chain(told.map(|value| value.map(number).unwrap_or_default())));
    }
    let json = summary.to_json().map_err(|error| {
        let problem = WriteProblem::Io { kind: std::io::ErrorKind::InvalidData, message: error.to_string() };
        WriteError::new(&dir.join(SUMMARY_FILE), problem)
    })?;
    let files: [(PathBuf, &[u8]); 4] = [
        (REPORT_FILE.into(), report.as_bytes()),
        (SHAPE_FILE.into(), shape.as_bytes()),
        (MOTION_FILE.into(), motion.as_bytes()),
        (SUMMARY_FILE.into(), json.as_bytes()),
    ];
    RESULT.write(dir, &files)
}
