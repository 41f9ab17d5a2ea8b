//! A palm log line by line, as it comes from a program or a growing file.

use palpate::Sample;

use super::log_reader::{Columns, HEADER};
use crate::csv::table::Table;
use crate::read_error::ReadError;
use crate::rig::conventions::Conventions;

/// Reads one line of a palm log at a time, by the rules of [`read_log`](crate::read_log), as far as they concern one line: what comes before
/// and after is for the caller to look at, times that do not increase above all.
///
/// ```
/// use palpate_io::{Conventions, RowReader};
/// let reader = RowReader::new("stdin", "time_ms,phi1_deg,phi2_deg,s1_mm,s2_mm", 1, Conventions::default())?;
/// assert_eq!(reader.sample("50,60,74,29.7,", 2)?.map(|sample| sample.s1_m), Some(Some(0.0297)));
/// assert_eq!(reader.sample("# a comment", 3)?, None);
/// assert_eq!(reader.sample("50,60,74,-3,31", 4).unwrap_err().line, Some(4));
/// # Ok::<(), palpate_io::ReadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RowReader {
    name: String,
    header: String,
    conventions: Conventions,
}

impl RowReader {
    /// A reader of the lines below this header, which stands in line `line` of what messages call `name`. Angles are checked as the conventions
    /// have them, and given as they are written.
    ///
    /// # Errors
    /// The header is none, misses a column, or has one in an unknown unit.
    pub fn new(name: &str, header: &str, line: usize, conventions: Conventions) -> Result<Self, ReadError> {
        let in_place = |error| at(error, line);
        let table = Table::parse(name, header.as_bytes(), HEADER).map_err(in_place)?;
        Columns::find(&table).map_err(in_place)?;
        Ok(Self { name: name.to_owned(), header: header.trim_end().to_owned(), conventions })
    }

    /// The sample in a line; `None` for a comment or a blank line.
    ///
    /// # Errors
    /// As of a line of a log, with `line` as its number.
    pub fn sample(&self, text: &str, line: usize) -> Result<Option<Sample>, ReadError> {
        let both = format!("{}\n{}\n", self.header, text.trim_end());
        let in_place = |error| at(error, line);
        let table = Table::parse(&self.name, both.as_bytes(), HEADER).map_err(in_place)?;
        if table.rows() == 0 {
            return Ok(None);
        }
        let signs = self.conventions.angle_signs;
        let mut columns = Columns::find(&table).map_err(in_place)?;
        columns.signs = signs;
        let mut sample = columns.sample(&table, 0).map_err(in_place)?;
        sample.palms.phi1_rad *= signs[0];
        sample.palms.phi2_rad *= signs[1];
        Ok(Some(sample))
    }
}

/// An error in the only line of a table, where that line is.
fn at(error: ReadError, line: usize) -> ReadError {
    ReadError { line: Some(line), ..error }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_as_written_and_checked_as_the_rig_has_it() {
        let conventions = Conventions { angle_signs: [1.0, -1.0], ..Conventions::default() };
        let header = "s2_m,time_s,phi2_rad,phi1_rad,s1_m,force1_n";
        let reader = RowReader::new("log", header, 1, conventions).expect("a header");
        let sample = reader.sample("0.03,1,-1.25,0.5,,2", 2).expect("a line").expect("a sample");
        assert_eq!((sample.palms.phi1_rad, sample.palms.phi2_rad), (0.5, -1.25));
        assert_eq!((sample.s1_m, sample.s2_m, sample.force1_n), (None, Some(0.03), Some(2.0)));
        let error = reader.sample("0.03,1,1.25,0.5,,2", 7).expect_err("a negative angle");
        assert_eq!((error.line, error.column.as_deref()), (Some(7), Some("phi2_rad")));
    }

    #[test]
    fn faulty_headers_and_lines_are_named_by_their_place() {
        let error = RowReader::new("log", "time_s,phi1_rad", 5, Conventions::default()).expect_err("columns missing");
        assert_eq!(error.line, Some(5));
        let reader = RowReader::new("log", HEADER, 1, Conventions::default()).expect("a header");
        for text in ["1,2", "1,0.5,1.2,a,0.03", "1,0.5,1.2,0.03,0.03,9", "1,0.5,1.2,\"0.03,0.03"] {
            assert_eq!(reader.sample(text, 9).expect_err(text).line, Some(9), "{text}");
        }
        assert_eq!(reader.sample(" ", 2), Ok(None));
    }
}
