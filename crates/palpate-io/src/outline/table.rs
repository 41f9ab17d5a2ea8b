//! Outlines from CSV tables: points in order, or a support function.

use palpate::shape::BoundaryPoint;

use crate::csv::number::six_digits;
use crate::csv::table::{Quantity, Table};
use crate::csv::unit::Dimension;
use crate::log::plausible::{MAX_COORDINATE_M, MAX_REACH_M, MIN_REACH_M};
use crate::outline::{Outline, OutlineFile, size_m};
use crate::read_error::{ReadError, ReadProblem};
use crate::truth::{R, THETA, support};

const X: Quantity = Quantity::new("x", Dimension::Length);
const Y: Quantity = Quantity::new("y", Dimension::Length);
const ALL: [Quantity; 4] = [THETA, R, X, Y];
const HEADER: &str = "x_m,y_m";

/// Fewest points that have an area between them.
const MIN_POINTS: usize = 3;

/// The outline in a table.
pub(super) fn parse(name: &str, bytes: &[u8]) -> Result<OutlineFile, ReadError> {
    let table = Table::parse(name, bytes, HEADER)?;
    // A result has both; its support function is about the centre of mass.
    if table.find(THETA, &ALL)?.is_some() && table.find(R, &ALL)?.is_some() {
        let samples = support(name, &table, &ALL)?;
        return Ok(OutlineFile { outline: Outline::Support(samples), notes: Vec::new() });
    }
    let [x, y] = table.require_all([X, Y], &ALL)?;
    table.require_rows()?;
    table.require_one_decimal_mark(&[x, y])?;
    let mut points = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let coordinate = |column| {
            let value_m = table.number(row, column)?;
            table.within(row, column, value_m, MAX_COORDINATE_M)
        };
        points.push(BoundaryPoint { x_m: coordinate(x)?, y_m: coordinate(y)? });
    }
    if points.len() < MIN_POINTS {
        return Err(ReadError::in_file(name, ReadProblem::TooFewPoints { points: points.len(), needed: MIN_POINTS }));
    }
    let across_m = size_m(&points);
    let others = match across_m {
        across_m if across_m > MAX_REACH_M => table.names_of_smaller_units(x),
        across_m if across_m < MIN_REACH_M => table.names_of_larger_units(x),
        _ => return Ok(OutlineFile { outline: Outline::Points(points), notes: Vec::new() }),
    };
    let problem =
        ReadProblem::OutlineSize { across_m: six_digits(across_m), least_m: MIN_REACH_M, most_m: MAX_REACH_M, others };
    Err(table.column_error(x, problem))
}
