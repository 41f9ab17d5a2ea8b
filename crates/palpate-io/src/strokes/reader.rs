//! The log of a pivoting grasp from a CSV file.

use std::path::Path;

use palpate::pivot::{PivotLog, PivotRig, PivotSample};

use crate::csv::bytes::read_bytes;
use crate::csv::table::{Column, Quantity, Table, header_has};
use crate::csv::unit::Dimension;
use crate::log::log_reader::whole_lines;
use crate::read_error::ReadError;
use crate::strokes::comments::StrokesComments;

const TIME: Quantity = Quantity::new("time", Dimension::Time).also_named(&["timestamp", "time_stamp"]);
pub(crate) const PIVOT_X: Quantity = Quantity::new("pivot_x", Dimension::Length);
const PIVOT_Y: Quantity = Quantity::new("pivot_y", Dimension::Length);
const S: Quantity = Quantity::or_empty("s", Dimension::Length, "no contact was seen");
const ALL: [Quantity; 4] = [TIME, PIVOT_X, PIVOT_Y, S];
pub(super) const HEADER: &str = "time_s,pivot_x_m,pivot_y_m,s_m";

/// Arms and pads of strokes reach no further, metres: beyond, lengths are in another unit than their name says.
pub const FURTHEST_M: f64 = 10.0;

/// A log of strokes as it came from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrokesFile {
    /// The samples, in SI units.
    pub log: PivotLog,
    /// The `# key: value` lines, in the order of the file.
    pub metadata: Vec<(String, String)>,
    /// What its comment `# rig: …` says, where it has one.
    pub rig: Option<PivotRig>,
    /// What the user may want to know about the file, a sentence each: a last line that was cut off.
    pub notes: Vec<String>,
}

/// Whether the header of a file has the columns of a pivot: it is a log of strokes and no palm log.
pub fn is_strokes_log(bytes: &[u8]) -> bool {
    header_has(bytes, PIVOT_X)
}

/// Reads a log of strokes of a pivoting grasp (Moll & Erdmann 2001, figure 9).
///
/// Columns are found by name, in any order and with other units if the names say so, as in [`read_log`](crate::read_log). Required: time,
/// pivot_x and pivot_y (where the arm holds the object), s (where the pad feels it, along the pad from its base). An empty cell in s means that no
/// contact was seen. A comment `# swing_period_s: 0.41` gives the period of small swings of the lifted object, `# rig: …` what is known of the rig.
///
/// # Errors
/// The file cannot be read or is no such log; time must increase, lengths must be within 10 m.
pub fn read_strokes(path: &Path) -> Result<StrokesFile, ReadError> {
    parse_strokes(&path.to_string_lossy(), &read_bytes(path)?)
}

/// The same from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_strokes`].
pub fn parse_strokes(name: &str, bytes: &[u8]) -> Result<StrokesFile, ReadError> {
    let (bytes, cut_off) = whole_lines(bytes);
    let table = Table::parse(name, bytes, HEADER)?;
    let columns = Columns::find(&table)?;
    table.require_rows()?;
    let Columns { time, x, y, s } = columns;
    table.require_one_decimal_mark(&[time, x, y, s])?;
    let mut samples: Vec<PivotSample> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let sample = columns.sample(&table, row)?;
        if let Some(before) = samples.last() {
            table.require_increase(row, time, before.time_s, sample.time_s, "time")?;
        }
        samples.push(sample);
    }
    let StrokesComments { rig, swing_period_s } = StrokesComments::of(name, &table.metadata)?;
    let log = PivotLog { samples, swing_period_s };
    Ok(StrokesFile { log, metadata: table.metadata, rig, notes: cut_off.into_iter().collect() })
}

/// Where a table has what.
#[derive(Clone, Copy, Debug)]
pub(super) struct Columns {
    time: Column,
    x: Column,
    y: Column,
    s: Column,
}

impl Columns {
    pub(super) fn find(table: &Table) -> Result<Self, ReadError> {
        let [time, x, y, s] = table.require_all(ALL, &ALL)?;
        Ok(Self { time, x, y, s })
    }

    pub(super) fn sample(&self, table: &Table, row: usize) -> Result<PivotSample, ReadError> {
        let length = |column, length_m| table.within(row, column, length_m, FURTHEST_M);
        Ok(PivotSample {
            time_s: table.number(row, self.time)?,
            pivot_x_m: length(self.x, table.number(row, self.x)?)?,
            pivot_y_m: length(self.y, table.number(row, self.y)?)?,
            s_m: table.value(row, self.s)?.map(|s_m| length(self.s, s_m)).transpose()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_are_read_in_any_unit_and_order() {
        let text = "# swing_period_s: 0.4\ns_mm,time_ms,Pivot_X (cm),pivot_y_m\n12.5,0,1.5,0.03\n,50,1.6,0.04\n";
        let palms = b"time_s,phi1_rad,phi2_rad,s1_m,s2_m\n";
        assert!(is_strokes_log(text.as_bytes()) && !is_strokes_log(palms));
        assert!(crate::is_palm_log(palms) && !crate::is_palm_log(text.as_bytes()));
        let error = crate::parse_log("log", text.as_bytes()).expect_err("it is no palm log");
        assert!(error.to_string().contains("reconstruct_strokes"), "{error}");
        let file = parse_strokes("log", text.as_bytes()).expect("a log");
        assert_eq!(file.log.swing_period_s, Some(0.4));
        let [first, second] = file.log.samples[..] else { panic!("two samples") };
        assert_eq!((first.time_s, first.pivot_x_m, first.pivot_y_m, first.s_m), (0.0, 0.015, 0.03, Some(0.0125)));
        assert_eq!((second.time_s, second.s_m), (0.05, None));
    }

    #[test]
    fn a_recording_that_was_cut_off_reads_up_to_its_last_whole_line() {
        let metadata = [("rig".to_owned(), "exact".to_owned())];
        let mut text = crate::strokes::writer::strokes_csv_header(&metadata);
        let sample = |time_s| PivotSample { time_s, pivot_x_m: 0.1, pivot_y_m: 0.03, s_m: None };
        [1.0, 2.0].iter().for_each(|time_s| crate::strokes::writer::push_strokes_row(&mut text, &sample(*time_s)));
        let whole = parse_strokes("log", text.as_bytes()).expect("a log");
        assert_eq!((whole.log.samples, whole.rig), (vec![sample(1.0), sample(2.0)], Some(PivotRig::default())));
        assert!(whole.notes.is_empty());
        let cut = parse_strokes("log", &text.as_bytes()[..text.len() - 4]).expect("a log");
        assert_eq!((cut.log.samples, cut.notes.len()), (vec![sample(1.0)], 1));
    }

    #[test]
    fn faults_are_named_by_line_and_column() {
        let fault = |text: &str| parse_strokes("log", text.as_bytes()).expect_err("a fault");
        let error = fault("time_s,pivot_x_m,pivot_y_m,s_m\n0,0.1,0.03,0.1\n1,0.1,30,0.1\n");
        assert_eq!((error.line, error.column.as_deref()), (Some(3), Some("pivot_y_m")));
        let error = fault("time_s,pivot_x_m,pivot_y_m,s_m\n1,0.1,0.03,0.1\n1,0.1,0.03,0.1\n");
        assert_eq!((error.line, error.column.as_deref()), (Some(3), Some("time_s")));
        let error = fault("time_s,pivot_x_m,s_m\n1,0.1,0.03\n");
        assert!(error.to_string().contains("pivot_y_m"), "{error}");
        let error = fault("# swing_period_s: soon\ntime_s,pivot_x_m,pivot_y_m,s_m\n1,0.1,0.03,0.1\n");
        assert!(error.to_string().contains("is soon"), "{error}");
    }
}
