//! The file that says what is known of the rig of a pivoting grasp, TOML, and the same as a comment above a log of strokes.

use std::path::Path;

use palpate::pivot::{PadPose, PivotCalibration, PivotRig, PivotTolerances};

use crate::csv::bytes::read_bytes;
use crate::read_error::{ReadError, ReadProblem};
use crate::rig::comment::{EXACT, on_lines, on_one_line};

/// Reads what is known of the rig of a pivoting grasp: tables `pad` (base_x_m, base_y_m, tilt_rad), `calibration` (zero_m, scale, tilt_rad, height_m)
/// and `tolerances` (zero_sd_m, scale_sd, tilt_sd_rad, height_sd_m), and reading_sd_m and arm_sd_m. What is left out is 0 or unknown noise: the
/// constants of such a rig are exact.
///
/// # Errors
/// The file cannot be read, is no TOML, or has an entry that is not known.
pub fn read_pivot_rig(path: &Path) -> Result<PivotRig, ReadError> {
    let bytes = read_bytes(path)?;
    parse(&path.to_string_lossy(), &String::from_utf8_lossy(&bytes))
}

fn parse(file: &str, text: &str) -> Result<PivotRig, ReadError> {
    toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let problem = ReadProblem::PivotRig { message: error.message().to_owned() };
        ReadError { line, ..ReadError::in_file(file, problem) }
    })
}

/// The value of a comment `# rig: …` above a log of strokes, which says in one line what such a file says; [`read_strokes`](crate::read_strokes)
/// reads it.
///
/// ```
/// use palpate::pivot::{PadPose, PivotRig};
/// assert_eq!(palpate_io::pivot_rig_comment(&PivotRig::exact(PadPose::default())), "exact");
/// let tilted = PivotRig::exact(PadPose { tilt_rad: 0.1, ..PadPose::default() });
/// assert!(palpate_io::pivot_rig_comment(&tilted).starts_with("[pad] base_x_m = 0.0; base_y_m = 0.0; tilt_rad = 0.1; [calibration] "));
/// ```
pub fn pivot_rig_comment(rig: &PivotRig) -> String {
    if *rig == PivotRig::default() {
        return EXACT.to_owned();
    }
    let PivotRig { pad, calibration, tolerances, reading_sd_m, arm_sd_m } = *rig;
    let PadPose { base_x_m, base_y_m, tilt_rad: pad_tilt_rad } = pad;
    let PivotCalibration { zero_m, scale, tilt_rad, height_m } = calibration;
    let PivotTolerances { zero_sd_m, scale_sd, tilt_sd_rad, height_sd_m } = tolerances;
    let known =
        |name: &str, value: Option<f64>| value.map_or_else(String::new, |value| format!("{name} = {value:?}\n"));
    on_one_line(&format!(
        "{}{}[pad]\nbase_x_m = {base_x_m:?}\nbase_y_m = {base_y_m:?}\ntilt_rad = {pad_tilt_rad:?}\n\
         [calibration]\nzero_m = {zero_m:?}\nscale = {scale:?}\ntilt_rad = {tilt_rad:?}\nheight_m = {height_m:?}\n\
         [tolerances]\nzero_sd_m = {zero_sd_m:?}\nscale_sd = {scale_sd:?}\ntilt_sd_rad = {tilt_sd_rad:?}\nheight_sd_m = {height_sd_m:?}",
        known("reading_sd_m", reading_sd_m),
        known("arm_sd_m", arm_sd_m),
    ))
}

/// What such a comment says; `file` is what messages call the log.
pub(super) fn parse_pivot_rig_comment(file: &str, value: &str) -> Result<PivotRig, ReadError> {
    if value == EXACT {
        return Ok(PivotRig::default());
    }
    parse(file, &on_lines(value))
        .map_err(|error| ReadError::in_file(file, ReadProblem::RigComment { problem: error.problem.to_string() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_is_read_and_a_slip_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let read = |text: &str| {
            let path = folder.path().join("rig.toml");
            std::fs::write(&path, text).expect("it can be written");
            read_pivot_rig(&path)
        };
        let rig = read("reading_sd_m = 1e-4\n[pad]\ntilt_rad = 0.1\n[tolerances]\nzero_sd_m = 5e-4\n").expect("a rig");
        assert_eq!((rig.reading_sd_m, rig.pad.tilt_rad, rig.tolerances.zero_sd_m), (Some(1e-4), 0.1, 5e-4));
        let error = read("[pad]\ntilt_deg = 3\n").expect_err("an unknown entry");
        assert_eq!(error.line, Some(2));
        assert!(error.to_string().contains("tilt_deg"), "{error}");
    }

    #[test]
    fn a_rig_comes_back_from_its_comment() {
        let pad = PadPose { base_x_m: 0.1, base_y_m: -1.0 / 3.0, tilt_rad: 0.2 };
        let exact = PivotRig::exact(pad);
        for rig in [
            PivotRig::default(),
            exact,
            PivotRig::uncalibrated(pad),
            PivotRig { reading_sd_m: Some(1e-20), arm_sd_m: Some(2e-5), ..exact },
        ] {
            let comment = pivot_rig_comment(&rig);
            assert!(!comment.contains('\n'));
            assert_eq!(parse_pivot_rig_comment("log", &comment), Ok(rig), "{comment}");
        }
        let error = parse_pivot_rig_comment("log", "left hand").expect_err("no rig");
        assert_eq!((error.line, error.to_string().starts_with("log: ")), (None, true), "{error}");
    }
}
