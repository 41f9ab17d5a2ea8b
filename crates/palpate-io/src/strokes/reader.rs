//! The log of a pivoting grasp from a CSV file.

use std::path::Path;

use palpate::pivot::{PivotLog, PivotSample};

use crate::csv::bytes::read_bytes;
use crate::csv::table::{Column, Quantity, Table, header_has};
use crate::csv::unit::Dimension;
use crate::read_error::{ReadError, ReadProblem};

const TIME: Quantity = Quantity::new("time", Dimension::Time).also_named(&["timestamp", "time_stamp"]);
pub(crate) const PIVOT_X: Quantity = Quantity::new("pivot_x", Dimension::Length);
const PIVOT_Y: Quantity = Quantity::new("pivot_y", Dimension::Length);
const S: Quantity = Quantity::or_empty("s", Dimension::Length, "no contact was seen");
const ALL: [Quantity; 4] = [TIME, PIVOT_X, PIVOT_Y, S];
pub(super) const HEADER: &str = "time_s,pivot_x_m,pivot_y_m,s_m";

/// Metadata of a log of strokes: the period of small swings of the lifted object, seconds.
pub(super) const SWING_PERIOD: &str = "swing_period_s";

/// Arms and pads reach no further, metres: beyond, lengths are in another unit than their name says.
pub(super) const FURTHEST_M: f64 = 10.0;

/// A log of strokes as it came from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrokesFile {
    /// The samples, in SI units.
    pub log: PivotLog,
    /// The `# key: value` lines, in the order of the file.
    pub metadata: Vec<(String, String)>,
}

/// Whether the header of a file has the columns of a pivot: it is a log of strokes and no palm log.
pub fn is_strokes_log(bytes: &[u8]) -> bool {
    header_has(bytes, PIVOT_X)
}

/// Reads a log of strokes of a pivoting grasp (Moll & Erdmann 2001, figure 9).
///
/// Columns are found by name, in any order and with other units if the names say so, as in [`read_log`](crate::read_log). Required: time,
/// pivot_x and pivot_y (where the arm holds the object), s (where the pad feels it, along the pad from its base). An empty cell in s means that no
/// contact was seen. A comment `# swing_period_s: 0.41` gives the period of small swings of the lifted object.
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
    let swing_period_s = swing_period_s(name, &table)?;
    Ok(StrokesFile { log: PivotLog { samples, swing_period_s }, metadata: table.metadata })
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

/// The period of small swings that the comments of a file state.
pub(super) fn swing_period_s(name: &str, table: &Table) -> Result<Option<f64>, ReadError> {
    let stated = table.metadata.iter().find(|(key, _)| key == SWING_PERIOD).map(|(_, value)| {
        let period_s = value.parse::<f64>().ok().filter(|period_s| *period_s > 0.0 && period_s.is_finite());
        period_s
            .ok_or_else(|| ReadError::in_file(name, ReadProblem::SwingPeriod { text: crate::csv::text::quoted(value) }))
    });
    stated.transpose()
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
