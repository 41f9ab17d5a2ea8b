//! Planned strokes: where an arm is to drag a pivot, and how firmly, as a CSV file.

use std::path::Path;

use palpate::pivot::{PlannedStrokes, Stroke};

use crate::csv::bytes::read_bytes;
use crate::csv::metadata::push_metadata;
use crate::csv::number::{number, push_row};
use crate::csv::table::{Quantity, Table};
use crate::csv::unit::Dimension;
use crate::folder::write_whole;
use crate::read_error::{ReadError, ReadProblem};
use crate::strokes::reader::FURTHEST_M;
use crate::write_error::WriteError;

const STROKE: Quantity = Quantity::count("stroke");
const ALONG: Quantity = Quantity::new("along", Dimension::Length);
const PRESS: Quantity = Quantity::count("press");
const ALL: [Quantity; 3] = [STROKE, ALONG, PRESS];
const HEADER: &str = "stroke,along_m,press";
/// What is expected of a stroke; nobody reads it back.
const COVERAGE: &str = "coverage";

/// Reads strokes as [`write_planned_strokes`] writes them. Columns are found by name, in any order and unit, other columns are left aside.
///
/// # Errors
/// The file cannot be read or holds no strokes; places must be within 10 m, forces from 0 on and the same within a stroke.
pub fn read_planned_strokes(path: &Path) -> Result<Vec<Stroke>, ReadError> {
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    let table = Table::parse(&name, &bytes, HEADER)?;
    let [stroke, along, press] = table.require_all(ALL, &ALL)?;
    table.require_rows()?;
    table.require_one_decimal_mark(&[stroke, along, press])?;
    let mut strokes: Vec<Stroke> = Vec::new();
    for row in 0..table.rows() {
        let number = table.number(row, stroke)?;
        let along_m = table.within(row, along, table.number(row, along)?, FURTHEST_M)?;
        let weights = table.number(row, press)?;
        let is_next = number == (strokes.len() + 1) as f64;
        if !is_next && (strokes.is_empty() || number != strokes.len() as f64) {
            return Err(table.error(row, stroke, ReadProblem::StrokeNumber { text: table.shown(row, stroke) }));
        }
        if is_next {
            strokes.push(Stroke { along_m: Vec::new(), press: weights });
        }
        match strokes.last_mut() {
            Some(last) if weights >= 0.0 && weights == last.press => last.along_m.push(along_m),
            _ => return Err(table.error(row, press, ReadProblem::Press { text: table.shown(row, press) })),
        }
    }
    Ok(strokes)
}

/// Writes planned strokes: a row for each place along the pad that the foot of the pivot goes to, with `stroke` (from 1), `along_m`, `press` (weights of
/// the object) and `coverage` (the share of the boundary that is expected to be felt once that stroke is done), and lines `# key: value` above the
/// header. The file is written whole or not at all, in place of an earlier one.
///
/// # Errors
/// The file cannot be written.
pub fn write_planned_strokes(
    path: &Path,
    planned: &PlannedStrokes,
    metadata: &[(&str, String)],
) -> Result<(), WriteError> {
    let mut text = String::new();
    push_metadata(&mut text, metadata);
    text += &format!("{HEADER},{COVERAGE}\n");
    for (index, (stroke, coverage)) in planned.strokes.iter().zip(&planned.coverage).enumerate() {
        for along_m in &stroke.along_m {
            push_row(&mut text, [(index + 1) as f64, *along_m, stroke.press, *coverage].map(number));
        }
    }
    write_whole(path, text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plan.csv");
        let stroke = |along_m: &[f64], press: f64| Stroke { along_m: along_m.to_vec(), press };
        let strokes = vec![stroke(&[0.5, 0.2 / 3.0], 3.0), stroke(&[0.4, 0.6, 0.5], 2.5)];
        let planned = PlannedStrokes { strokes, coverage: vec![0.5, 0.875] };
        write_planned_strokes(&path, &planned, &[("made by", "a test".to_owned())]).expect("it can be written");
        assert_eq!(read_planned_strokes(&path).expect("it can be read"), planned.strokes);
    }

    #[test]
    fn faults_are_named_by_line_and_column() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("plan.csv");
        let fault = |rows: &str| {
            std::fs::write(&path, format!("stroke,along_mm,press\n{rows}\n")).expect("a file");
            let error = read_planned_strokes(&path).expect_err("a fault");
            (error.line.unwrap_or(0), error.column.unwrap_or_default())
        };
        assert_eq!(fault("2,500,3"), (2, "stroke".to_owned()));
        assert_eq!(fault("1,500,3\n3,500,3"), (3, "stroke".to_owned()));
        assert_eq!(fault("1,500,3\n1.5,500,3"), (3, "stroke".to_owned()));
        assert_eq!(fault("1,500,3\n2,500,3\n1,500,3"), (4, "stroke".to_owned()));
        assert_eq!(fault("1,50000,3"), (2, "along_mm".to_owned()));
        assert_eq!(fault("1,500,-3"), (2, "press".to_owned()));
        assert_eq!(fault("1,500,3\n1,510,4"), (3, "press".to_owned()));
        assert_eq!(fault("1,500,"), (2, "press".to_owned()));
    }
}
