//! The log of a pivoting grasp to a CSV file.

use std::path::Path;

use palpate::pivot::{PivotLog, PivotSample};

use crate::csv::metadata::push_metadata;
use crate::csv::number::{number, push_row};
use crate::folder::write_whole;
use crate::log::log_reader::RECORDING;
use crate::strokes::comments::SWING_PERIOD;
use crate::strokes::reader::HEADER;
use crate::write_error::WriteError;

/// Writes a log of strokes as [`read_strokes`](crate::read_strokes) reads it: SI units, digits enough to read back the same numbers, and lines
/// `# key: value` above the header. The file is written whole or not at all, in place of an earlier one.
///
/// # Errors
/// The file cannot be written.
pub fn write_strokes(path: &Path, log: &PivotLog, metadata: &[(&str, String)]) -> Result<(), WriteError> {
    write_whole(path, strokes_csv(log, metadata).as_bytes())
}

/// The text of such a file.
pub fn strokes_csv(log: &PivotLog, metadata: &[(&str, String)]) -> String {
    let mut text = String::new();
    push_metadata(&mut text, metadata);
    if let Some(period_s) = log.swing_period_s {
        text += &format!("# {SWING_PERIOD}: {period_s}\n");
    }
    text += &format!("{HEADER}\n");
    log.samples.iter().for_each(|sample| push_strokes_row(&mut text, sample));
    text
}

/// The head of a log of strokes that is written sample by sample: its metadata and the header. A file that begins so may be cut off anywhere below it;
/// its readers leave out a last line that is not whole.
pub fn strokes_csv_header(metadata: &[(String, String)]) -> String {
    let mut text = format!("{RECORDING}\n");
    push_metadata(&mut text, metadata);
    text + HEADER + "\n"
}

/// The line of a sample, appended.
pub fn push_strokes_row(text: &mut String, sample: &PivotSample) {
    let numbers = [sample.time_s, sample.pivot_x_m, sample.pivot_y_m].map(number);
    push_row(text, numbers.into_iter().chain([sample.s_m.map(number).unwrap_or_default()]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strokes::reader::read_strokes;
    use palpate::pivot::PivotSample;

    #[test]
    fn what_is_written_reads_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("strokes.csv");
        let sample = |time_s: f64, s_m| PivotSample { time_s, pivot_x_m: 0.1 / 3.0, pivot_y_m: 0.03, s_m };
        let log =
            PivotLog { samples: vec![sample(0.0, None), sample(0.1, Some(0.2 / 7.0))], swing_period_s: Some(0.37) };
        write_strokes(&path, &log, &[("made by", "a test".to_owned())]).expect("it can be written");
        let read = read_strokes(&path).expect("it can be read");
        assert_eq!(read.log, log);
        assert_eq!(read.metadata[0], ("made by".to_owned(), "a test".to_owned()));
    }
}
