//! A log of strokes line by line, as it comes from a program or a growing file.

use palpate::pivot::PivotSample;

use crate::csv::table::Table;
use crate::read_error::ReadError;
use crate::strokes::reader::{Columns, HEADER};

/// Reads one line of a log of strokes at a time, by the rules of [`read_strokes`](crate::read_strokes), as far as they concern one line: what comes
/// before and after is for the caller to look at, times that do not increase above all.
///
/// ```
/// use palpate_io::StrokesRowReader;
/// let reader = StrokesRowReader::new("stdin", "time_ms,pivot_x_mm,pivot_y_mm,s_mm", 1)?;
/// assert_eq!(reader.sample("50,500,31,", 3)?.map(|sample| (sample.time_s, sample.s_m)), Some((0.05, None)));
/// assert_eq!(reader.sample("# a comment", 4)?, None);
/// assert_eq!(reader.sample("50,x,31,500", 5).unwrap_err().line, Some(5));
/// # Ok::<(), palpate_io::ReadError>(())
/// ```
#[derive(Clone, Debug)]
pub struct StrokesRowReader {
    name: String,
    header: String,
}

impl StrokesRowReader {
    /// A reader of the lines below this header, which stands in line `line` of what messages call `name`. What the comments above it say is for
    /// [`StrokesComments`](crate::StrokesComments).
    ///
    /// # Errors
    /// The header is none, misses a column, or has one in an unknown unit.
    pub fn new(name: &str, header: &str, line: usize) -> Result<Self, ReadError> {
        let in_place = |error| ReadError { line: Some(line), ..error };
        let table = Table::parse(name, header.as_bytes(), HEADER).map_err(in_place)?;
        Columns::find(&table).map_err(in_place)?;
        Ok(Self { name: name.to_owned(), header: header.trim_end().to_owned() })
    }

    /// The sample in a line; `None` for a comment or a blank line.
    ///
    /// # Errors
    /// As of a line of a log, with `line` as its number.
    pub fn sample(&self, text: &str, line: usize) -> Result<Option<PivotSample>, ReadError> {
        let both = format!("{}\n{}\n", self.header, text.trim_end());
        let in_place = |error| ReadError { line: Some(line), ..error };
        let table = Table::parse(&self.name, both.as_bytes(), HEADER).map_err(in_place)?;
        if table.rows() == 0 {
            return Ok(None);
        }
        let columns = Columns::find(&table).map_err(in_place)?;
        columns.sample(&table, 0).map(Some).map_err(in_place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faulty_headers_and_lines_are_named_by_their_place() {
        let error = StrokesRowReader::new("log", "time_s,pivot_x_m,s_m", 3).expect_err("a column is missing");
        assert_eq!(error.line, Some(3));
        let reader = StrokesRowReader::new("log", "time_s,pivot_x_m,pivot_y_m,s_m\n", 1).expect("a header");
        for text in ["1,2", "1,0.5,0.03,a", "1,0.5,0.03,0.5,9", "1,50,0.03,0.5", "1,0.5,0.03,\"0.5"] {
            assert_eq!(reader.sample(text, 9).expect_err(text).line, Some(9), "{text}");
        }
        assert_eq!(reader.sample(" ", 2), Ok(None));
    }
}
