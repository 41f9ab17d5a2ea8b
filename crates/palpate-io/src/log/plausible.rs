//! Sizes that a log of two palms can have. A value far beyond them is in another unit than its column says, and a result in the wrong unit
//! would be certified all the same: nothing else in a log knows how long a millimetre is.

use palpate::Sample;

use crate::csv::number::{number, six_digits};
use crate::csv::table::{Column, Table};
use crate::csv::unit::Unit;
use crate::log::log_reader::Columns;
use crate::read_error::{ReadError, ReadProblem};

/// Farthest that a contact lies from the base of its palm, and one base from the other, metres: longer than any arm with a touch sensor
/// on it, and less than a contact 2 mm from the base if millimetres are taken for metres, or 2 cm if centimetres are.
pub(crate) const MAX_REACH_M: f64 = 2.0;
/// The farthest contact of each palm lies at least so far from its base, metres: a few counts of a pad, and more than any contact within a
/// metre if metres are taken for millimetres.
pub(crate) const MIN_REACH_M: f64 = 1e-3;
/// Farthest that a base point lies from the origin of its frame, metres: within one laboratory.
pub(crate) const MAX_COORDINATE_M: f64 = 100.0;
/// The palms open at least so wide at some time, degrees: π, so that an angle between palms in radians is never taken for degrees. Palms that
/// stay closer touch an object of 10 mm at 36 cm from their hinge.
const MIN_OPENING_DEG: f64 = std::f64::consts::PI;
/// Longest log, seconds: eleven days, longer than anyone carries one object about, and what a second is in microseconds.
const MAX_DURATION_S: f64 = 1e6;
/// Most samples per second on average: pads and encoders are read at a few kilohertz at most, and 10 samples per second become as many if
/// seconds are taken for milliseconds.
const MAX_RATE_HZ: f64 = 1e4;

/// Refuses a log as a whole that no two palms can have written in the units of its columns.
pub(crate) fn check(table: &Table, columns: &Columns, samples: &[Sample]) -> Result<(), ReadError> {
    let reaches = [
        samples.iter().filter_map(|sample| sample.s1_m).fold(0.0, f64::max),
        samples.iter().filter_map(|sample| sample.s2_m).fold(0.0, f64::max),
    ];
    for (reach_m, column) in reaches.into_iter().zip(columns.s) {
        if reach_m < MIN_REACH_M {
            let problem = ReadProblem::TooShort {
                farthest: shown(column, reach_m),
                unit: unit_of(column),
                limit_mm: 1e3 * MIN_REACH_M,
                others: table.names_of_larger_units(column),
            };
            return Err(table.column_error(column, problem));
        }
    }
    let widest_deg = samples.iter().map(|sample| sample.palms.phi2_rad.to_degrees()).fold(0.0, f64::max);
    if widest_deg < MIN_OPENING_DEG {
        let column = columns.phi[1];
        let problem = ReadProblem::TooNarrow {
            widest: shown(column, widest_deg.to_radians()),
            unit: unit_of(column),
            radians: if column.unit == Some(Unit::Degree) {
                table.name_in(column, Unit::Radian)
            } else {
                String::new()
            },
        };
        return Err(table.column_error(column, problem));
    }
    for (row, sample) in samples.iter().enumerate() {
        let ([x1, y1], [x2, y2]) = (sample.palms.base1_m, sample.palms.base2_m);
        let apart_m = (x2 - x1).hypot(y2 - y1);
        if let Some(column) = columns.farthest_base(sample).filter(|_| apart_m > MAX_REACH_M) {
            let problem =
                ReadProblem::BasesApart { apart_m, limit_m: MAX_REACH_M, others: table.names_of_smaller_units(column) };
            return Err(table.error(row, column, problem));
        }
    }
    check_time(table, columns.time, samples)
}

/// Refuses a log that lasts too long, or whose samples follow each other too fast.
fn check_time(table: &Table, column: Column, samples: &[Sample]) -> Result<(), ReadError> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Ok(()) };
    let duration_s = last.time_s - first.time_s;
    if duration_s > MAX_DURATION_S {
        let problem = ReadProblem::TooLasting {
            duration: shown(column, duration_s),
            unit: unit_of(column),
            limit_s: MAX_DURATION_S,
            others: table.names_of_smaller_units(column),
        };
        return Err(table.column_error(column, problem));
    }
    let steps = samples.len() - 1;
    if steps as f64 > MAX_RATE_HZ * duration_s {
        let problem = ReadProblem::TooFast {
            step: shown(column, duration_s / steps as f64),
            unit: unit_of(column),
            limit_hz: MAX_RATE_HZ,
            others: table.names_of_larger_units(column),
        };
        return Err(table.column_error(column, problem));
    }
    Ok(())
}

/// A value in SI as its column has it, to six digits.
fn shown(column: Column, value: f64) -> String {
    let value = column.unit.map_or(value, |unit| value / unit.to_si(1.0));
    number(six_digits(value))
}

/// The unit of a column as messages show it.
pub(crate) fn unit_of(column: Column) -> &'static str {
    column.unit.map_or("", Unit::suffix)
}
