//! The file that says what is known of the rig of a pivoting grasp, TOML.

use std::path::Path;

use palpate::pivot::PivotRig;

use crate::csv::bytes::read_bytes;
use crate::read_error::{ReadError, ReadProblem};

/// Reads what is known of the rig of a pivoting grasp: tables `pad` (base_x_m, base_y_m, tilt_rad), `calibration` (zero_m, scale, tilt_rad, height_m)
/// and `tolerances` (zero_sd_m, scale_sd, tilt_sd_rad, height_sd_m), and reading_sd_m and arm_sd_m. What is left out is 0 or unknown noise: the
/// constants of such a rig are exact.
///
/// # Errors
/// The file cannot be read, is no TOML, or has an entry that is not known.
pub fn read_pivot_rig(path: &Path) -> Result<PivotRig, ReadError> {
    let bytes = read_bytes(path)?;
    let text = String::from_utf8_lossy(&bytes);
    toml::from_str(&text).map_err(|error| {
        let line = error.span().map(|span| 1 + text[..span.start].matches('\n').count());
        let message = error.message().to_owned();
        let problem = ReadProblem::PivotRig { message };
        ReadError { line, ..ReadError::in_file(&path.to_string_lossy(), problem) }
    })
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
}
