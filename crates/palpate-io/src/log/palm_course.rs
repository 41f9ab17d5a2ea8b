//! How palms moved, or are to move: times, palm angles and base points of a CSV file, read and written.

use std::path::Path;

use palpate::palms::PalmPair;

use crate::csv::bytes::read_bytes;
use crate::csv::metadata::push_metadata;
use crate::csv::number::{number, push_row};
use crate::csv::table::{Column, Quantity, Table};
use crate::csv::text;
use crate::folder::write_whole;
use crate::log::log_reader::{
    BASE1_X, BASE1_Y, BASE2_X, BASE2_Y, PHI1, PHI2, TIME, base_coordinate, palm1_angle, palm2_angle,
};
use crate::read_error::{ReadError, ReadProblem};
use crate::write_error::WriteError;

/// Metadata of a course: the orientation at which the object is let go between the palms, radians.
const START_PSI: &str = "start_psi_rad";

const HEADER: &str = "time_s,phi1_rad,phi2_rad";
const BASES: &str = "base1_x_m,base1_y_m,base2_x_m,base2_y_m";

/// Palms over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PalmCourse {
    /// Times in seconds, which increase, and the palms.
    pub palms: Vec<(f64, PalmPair)>,
    /// Orientation at which the object is let go before the motion starts, radians, where the file says so (`# start_psi_rad: 1.2`).
    pub start_psi_rad: Option<f64>,
}

/// Reads how palms moved: the times, palm angles and base points of a palm log, with contacts or without, or of a planned motion.
///
/// # Errors
/// As [`read_log`](crate::read_log), but for the contacts, of which nothing is asked; or the orientation at the start is no number.
pub fn read_palm_course(path: &Path) -> Result<PalmCourse, ReadError> {
    const PALMS: [Quantity; 7] = [TIME, PHI1, PHI2, BASE1_X, BASE1_Y, BASE2_X, BASE2_Y];
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    let table = Table::parse(&name, &bytes, HEADER)?;
    let [time, phi1, phi2] = table.require_all([TIME, PHI1, PHI2], &PALMS)?;
    let [base1_x, base1_y, base2_x, base2_y] =
        [BASE1_X, BASE1_Y, BASE2_X, BASE2_Y].map(|base| table.find(base, &PALMS));
    let (base1, base2) = ([base1_x?, base1_y?], [base2_x?, base2_y?]);
    table.require_rows()?;
    let given = [base1, base2].into_iter().flatten().flatten();
    table.require_one_decimal_mark(&[time, phi1, phi2].into_iter().chain(given).collect::<Vec<_>>())?;
    let mut palms: Vec<(f64, PalmPair)> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let coordinate = |column: Option<Column>| column.map_or(Ok(0.0), |column| base_coordinate(&table, row, column));
        let time_s = table.number(row, time)?;
        if let Some((before_s, _)) = palms.last() {
            table.require_increase(row, time, *before_s, time_s, "time")?;
        }
        let pair = PalmPair {
            phi1_rad: palm1_angle(&table, row, phi1, 1.0)?,
            phi2_rad: palm2_angle(&table, row, phi2, 1.0)?,
            base1_m: [coordinate(base1[0])?, coordinate(base1[1])?],
            base2_m: [coordinate(base2[0])?, coordinate(base2[1])?],
        };
        palms.push((time_s, pair));
    }
    let start_psi_rad = table.metadata.iter().find(|(key, _)| key == START_PSI).map(|(_, value)| {
        let psi_rad = value.parse::<f64>().ok().filter(|psi_rad| psi_rad.is_finite());
        psi_rad.ok_or_else(|| ReadError::in_file(&name, ReadProblem::StartPsi { text: text::quoted(value) }))
    });
    Ok(PalmCourse { palms, start_psi_rad: start_psi_rad.transpose()? })
}

/// Writes a course as [`read_palm_course`] reads it: SI units, digits enough to read back the same numbers, base points where they are not both in the
/// origin, and lines `# key: value` above the header. The file is written whole or not at all, in place of an earlier one.
///
/// # Errors
/// The file cannot be written.
pub fn write_palm_course(path: &Path, course: &PalmCourse, metadata: &[(&str, String)]) -> Result<(), WriteError> {
    let mut text = String::new();
    push_metadata(&mut text, metadata);
    if let Some(psi_rad) = course.start_psi_rad {
        text += &format!("# {START_PSI}: {}\n", number(psi_rad));
    }
    let are_apart = course.palms.iter().any(|(_, pair)| pair.base1_m != [0.0; 2] || pair.base2_m != [0.0; 2]);
    text += &if are_apart { format!("{HEADER},{BASES}\n") } else { format!("{HEADER}\n") };
    for (time_s, pair) in &course.palms {
        let angles = [*time_s, pair.phi1_rad, pair.phi2_rad].into_iter();
        let bases = pair.base1_m.into_iter().chain(pair.base2_m).take(if are_apart { 4 } else { 0 });
        push_row(&mut text, angles.chain(bases).map(number));
    }
    write_whole(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("motion.csv");
        let hinged = |index: u32| (0.1 * f64::from(index), PalmPair::hinged(1.0 / 3.0, 1.2));
        let course = PalmCourse { palms: (0..3).map(hinged).collect(), start_psi_rad: Some(2.0 / 3.0) };
        write_palm_course(&path, &course, &[("made by", "a\ntest".to_owned())]).expect("it can be written");
        assert_eq!(read_palm_course(&path).expect("it can be read"), course);
        let mut apart = PalmCourse { start_psi_rad: None, ..course };
        apart.palms[1].1.base2_m = [-0.01, 0.0];
        write_palm_course(&path, &apart, &[]).expect("it can be written");
        assert_eq!(read_palm_course(&path).expect("it can be read"), apart);
    }

    #[test]
    fn an_orientation_that_is_no_number_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("motion.csv");
        std::fs::write(&path, "# start_psi_rad: upright\ntime_s,phi1_rad,phi2_rad\n0,1,1.2\n").expect("a file");
        let error = read_palm_course(&path).expect_err("no number");
        assert!(error.to_string().contains("start_psi_rad is upright"), "{error}");
    }
}
