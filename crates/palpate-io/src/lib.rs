//! Everything of palpate that touches the outside: palm logs, rig files, truth folders and result folders.
//!
//! A palm log is a CSV file that says what a robot knew while two tactile palms carried an object: the palm angles and where each
//! palm felt it. [`read_log`] takes it in, or says in one sentence which line and column is wrong and what to do about it.
//! Every column carries its unit in its name, so that nothing is guessed:
//!
//! ```
//! let mut text = String::from("# robot: left hand\ntime_ms,phi1_deg,phi2_deg,s1_mm,s2_mm\n");
//! for sample in 0..12 {
//!     text += &format!("{},60,{},29.7,31.8\n", 50 * sample, 74 + sample);
//! }
//! text += "600,60,74,,31.8\n"; // palm 1 saw no contact
//!
//! let file = palpate_io::parse_log("trial.csv", text.as_bytes())?;
//! assert_eq!(file.log.samples[0].s1_m, Some(0.0297));
//! assert_eq!(file.log.samples[12].s1_m, None);
//! assert_eq!(file.metadata, [("robot".to_string(), "left hand".to_string())]);
//!
//! let error = palpate_io::parse_log("trial.csv", text.replace("s2_mm", "s2_inch").as_bytes()).unwrap_err();
//! assert_eq!(
//!     error.to_string(),
//!     "trial.csv, line 2, column s2_inch: the unit \"inch\" is unknown; convert the column and name it s2_m, s2_cm, s2_mm or s2_um"
//! );
//! # Ok::<(), palpate_io::ReadError>(())
//! ```
//!
//! [`RowReader`] reads a log line by line as it comes ([`StrokesRowReader`] one of strokes, [`StrokesComments`] what stands above it), [`log_csv_header`] and [`push_log_row`] write one so
//! ([`strokes_csv_header`] and [`push_strokes_row`]).
//!
//! [`write_result`] puts a [`Reconstruction`](palpate::Reconstruction) into a folder that is written aside and renamed, so that it
//! is there as a whole or not at all; a folder that holds anything but an earlier result is left alone. [`check_result_target`]
//! asks the same questions before a long computation. [`Summary`] is what `summary.json` holds.
//!
//! A log that knows its truth (from a simulator, a vision system or a drawing) has it beside it: `NAME.truth/` for `NAME.csv`, see
//! [`truth_dir_of`], [`read_truth`] and [`write_truth`].
//!
//! A rig file says what is known of the palms and pads before a log is read: calibration constants with their standard deviations, and
//! conventions that differ from those of a palm log. See [`read_rig`], [`rig_to_toml`] and the commented [`rig_template`].
//!
//! The other rig, a pivoting grasp, has logs of its own: [`read_strokes`], [`read_pivot_rig`], [`write_strokes_result`],
//! and files of planned strokes: [`read_planned_strokes`].
//!
//! The outline of an object comes from points in a CSV file, a support function, or a drawing in SVG: see [`read_outline`].
//!
//! Nothing here knows how a shape is estimated.
#![forbid(unsafe_code)]

mod csv;
mod folder;
mod log;
mod outline;
mod read_error;
mod result;
mod rig;
mod strokes;
mod truth;
mod write_error;

pub use csv::bytes::{bytes_from, read_bytes};
pub use csv::columns::{point_of, point_row, pose_of, pose_row};
pub use folder::write_whole;
pub use log::log_reader::{
    LogFile, MIN_SAMPLES, fault_of, is_palm_log, log_from_columns, name_in_seconds, parse_log, parse_log_as,
    parse_log_with_rig, read_log, read_log_as, read_log_with_rig, rig_of_comment,
};
pub use log::log_writer::{log_csv, log_csv_header, push_log_row, write_log};
pub use log::palm_course::{PalmCourse, read_palm_course, write_palm_course};
pub use log::row_reader::RowReader;
pub use outline::{Outline, OutlineFile, parse_outline, read_outline};
pub use read_error::{MissingColumn, ReadError, ReadProblem};
pub use result::figures::{check_figures_target, write_figures};
pub use result::summary::{CoefficientSummary, ConstantSummary, FrictionSummary, JumpSummary, Summary, TruthSummary};
pub use result::{
    alternative_dir_of, alternatives_dir_of, check_result_target, read_motion_csv, read_shape_csv, read_summary,
    write_result, write_result_with_diagnostics,
};
pub use rig::comment::{parse_rig_comment, rig_comment};
pub use rig::conventions::{Conventions, Direction, PalmConventions};
pub use rig::parse::{parse_rig, read_rig};
pub use rig::rig_error::{RigError, RigProblem};
pub use rig::to_toml::rig_to_toml;
pub use rig::{Pad, RigFile, rig_template};
pub use strokes::comments::StrokesComments;
pub use strokes::planned::{read_planned_strokes, write_planned_strokes};
pub use strokes::reader::{FURTHEST_M, StrokesFile, is_strokes_log, parse_strokes, read_strokes};
pub use strokes::result::{
    StrokesReason, StrokesRig, StrokesSummary, StrokesTruth, check_strokes_target, write_strokes_result,
};
pub use strokes::rig::{pivot_rig_comment, read_pivot_rig};
pub use strokes::row_reader::StrokesRowReader;
pub use strokes::writer::{push_strokes_row, strokes_csv, strokes_csv_header, write_strokes};
pub use truth::{read_truth, truth_dir_of, write_truth};
pub use write_error::{WriteError, WriteProblem};
