//! The palm log from a CSV file.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use palpate::palms::PalmPair;
use palpate::reconstruct::Mistake;
use palpate::{Log, Sample};

use crate::csv::table::{Column, Quantity, Table, read_bytes};
use crate::csv::text;
use crate::csv::unit::{Dimension, Unit};
use crate::read_error::{ReadError, ReadProblem};
use crate::rig::conventions::Conventions;
use crate::rig::{RigFile, comment};

/// Fewest samples with a contact on both palms that a log must have: fewer cannot be solved for a shape.
pub const MIN_SAMPLES: usize = palpate::reconstruct::FEWEST_SAMPLES;

/// Palms closer to parallel than this, as |sin φ₂|, cannot be told from parallel ones.
const MIN_SIN_PHI2: f64 = 1e-3;
/// Longest length accepted, metres.
const MAX_LENGTH_M: f64 = 100.0;
/// A contact farther out than this is worth a note, metres.
const LONG_CONTACT_M: f64 = 10.0;
/// Contacts that are all closer than this are worth a note, metres.
const SHORT_CONTACT_M: f64 = 1e-3;
/// The unwrapped angle of palm 1 stays within this many radians.
const MAX_PHI1_RAD: f64 = 2.0 * TAU;

const NO_CONTACT: &str = "no contact was seen";
const NOT_STATED: &str = "it is not known";
const TIME: Quantity = Quantity::new("time", Dimension::Time);
const PHI1: Quantity = Quantity::new("phi1", Dimension::Angle);
const PHI2: Quantity = Quantity::new("phi2", Dimension::Angle);
const S1: Quantity = Quantity::or_empty("s1", Dimension::Length, NO_CONTACT);
const S2: Quantity = Quantity::or_empty("s2", Dimension::Length, NO_CONTACT);
const S1_SD: Quantity = Quantity::or_empty("s1_sd", Dimension::Length, NOT_STATED);
const S2_SD: Quantity = Quantity::or_empty("s2_sd", Dimension::Length, NOT_STATED);
const BASE1_X: Quantity = Quantity::new("base1_x", Dimension::Length);
const BASE1_Y: Quantity = Quantity::new("base1_y", Dimension::Length);
const BASE2_X: Quantity = Quantity::new("base2_x", Dimension::Length);
const BASE2_Y: Quantity = Quantity::new("base2_y", Dimension::Length);
const FORCE1: Quantity = Quantity::or_empty("force1", Dimension::Force, NOT_STATED);
const FORCE2: Quantity = Quantity::or_empty("force2", Dimension::Force, NOT_STATED);
const ALL: [Quantity; 13] =
    [TIME, PHI1, PHI2, S1, S2, S1_SD, S2_SD, BASE1_X, BASE1_Y, BASE2_X, BASE2_Y, FORCE1, FORCE2];
const HEADER: &str = "time_s,phi1_rad,phi2_rad,s1_m,s2_m";

/// A palm log as it came from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogFile {
    /// The samples, in SI units.
    pub log: Log,
    /// The `# key: value` lines, in the order of the file.
    pub metadata: Vec<(String, String)>,
    /// What the user may want to know about the file, a sentence each: columns left aside, values that look odd.
    pub notes: Vec<String>,
}

/// Reads a palm log.
///
/// Columns are found by name, in any order, upper or lower case, separated by commas (or all by semicolons or tabs); their units
/// are converted. Required: time, phi1, phi2, s1, s2. Optional: the standard deviations s1_sd and s2_sd, the base points
/// base1_x, base1_y, base2_x, base2_y, and force1, force2. Lengths end in `_m`, `_cm` or `_mm`, angles in `_rad` or `_deg`, times
/// in `_s` or `_ms`, forces in `_n`. An empty cell or NaN in s1 or s2 means that no contact was seen; in a standard deviation or
/// force, that it is not known.
///
/// # Errors
/// The file cannot be read or is no usable palm log; see [`ReadProblem`]. In particular time must increase from sample to sample,
/// the angle φ₂ between the palms must lie between 0 and π with |sin φ₂| ≥ 0.001, lengths must lie within 100 m, and
/// [`MIN_SAMPLES`] samples must have a contact on both palms.
pub fn read_log(path: &Path) -> Result<LogFile, ReadError> {
    parse_log(&path.to_string_lossy(), &read_bytes(path)?)
}

/// The same for a log that a rig wrote by its own conventions: signs of the angles, direction of the pads, base points.
///
/// # Errors
/// As [`read_log`].
pub fn read_log_as(path: &Path, conventions: &Conventions) -> Result<LogFile, ReadError> {
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    by_conventions(&name, Table::parse(&name, &bytes, HEADER)?, conventions)
}

/// The same for a log that may say by itself what rig wrote it, in a comment `# rig: …` above its header (as `palpate simulate` writes it, see
/// [`rig_comment`](crate::rig_comment)), with what it says.
///
/// # Errors
/// As [`read_log`]; also when the comment says nothing that can be understood.
pub fn read_log_with_rig(path: &Path) -> Result<(LogFile, Option<RigFile>), ReadError> {
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    let table = Table::parse(&name, &bytes, HEADER)?;
    let said = table.metadata.iter().find(|(key, _)| key == comment::KEY);
    let rig = said
        .map(|(_, value)| comment::parse_rig_comment(&name, value))
        .transpose()
        .map_err(|error| ReadError::in_file(&name, ReadProblem::RigComment { problem: error.problem.to_string() }))?;
    let conventions = rig.as_ref().map(|rig| rig.conventions).unwrap_or_default();
    Ok((by_conventions(&name, table, &conventions)?, rig))
}

fn by_conventions(name: &str, table: Table, conventions: &Conventions) -> Result<LogFile, ReadError> {
    let columns = Columns { signs: conventions.angle_signs, ..Columns::find(&table)? };
    table.require_rows()?;
    let mut file = from_table(name, table, &columns)?;
    file.log = Conventions { angle_signs: [1.0; 2], ..*conventions }.apply(&file.log);
    Ok(file)
}

/// Reads a palm log from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_log`].
pub fn parse_log(name: &str, bytes: &[u8]) -> Result<LogFile, ReadError> {
    let table = Table::parse(name, bytes, HEADER)?;
    let columns = Columns::find(&table)?;
    table.require_rows()?;
    from_table(name, table, &columns)
}

/// A palm log from columns in memory, each a name and the text of its cells, by the same rules. Lines of an error are rows,
/// counted from 0; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_log`]; also when the columns differ in length.
pub fn log_from_columns(name: &str, columns: &[(String, Vec<String>)]) -> Result<LogFile, ReadError> {
    let table = Table::from_columns(name, columns)?;
    let found = Columns::find(&table).map_err(|error| ReadError { line: None, ..error })?;
    from_table(name, table, &found)
}

fn from_table(name: &str, table: Table, columns: &Columns) -> Result<LogFile, ReadError> {
    let mut samples: Vec<Sample> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let sample = columns.sample(&table, row, palm2_angle).map_err(|error| with_remedy(error, &table, columns))?;
        if let Some(before) = samples.last() {
            table.require_increase(row, columns.time, before.time_s, sample.time_s, "time")?;
        }
        samples.push(sample);
    }
    let both = samples.iter().filter(|sample| sample.s1_m.is_some() && sample.s2_m.is_some()).count();
    if both < MIN_SAMPLES {
        let problem = ReadProblem::TooFewSamples { both, samples: samples.len(), needed: MIN_SAMPLES };
        return Err(ReadError::in_file(name, problem));
    }
    let notes = notes(&table, columns, &samples);
    Ok(LogFile { log: Log { samples }, metadata: table.metadata, notes })
}

/// What a negative angle between the palms may be, where nothing tells.
const NEGATIVE_ANGLE: &str = "reverse its sign, and that of phi1 if this is counted clockwise too; or, if palm 2 stands under the names of palm 1, exchange s1 and s2, and write phi1 + phi2 for phi1 and -phi2 for phi2";

/// An error with what to do about it by the whole log: palms whose angle is negative throughout hold an object in one way only.
fn with_remedy(mut error: ReadError, table: &Table, columns: &Columns) -> ReadError {
    if let ReadProblem::NegativePalmAngle { remedy, .. } = &mut *error.problem {
        let any_angle = |table: &Table, row, column, sign| Ok(sign * table.number(row, column)?);
        let samples: Result<Vec<Sample>, ReadError> =
            (0..table.rows()).map(|row| columns.sample(table, row, any_angle)).collect();
        let mistakes = samples.map(|samples| Mistake::of_palms_that_hold_nothing(&Log { samples })).unwrap_or_default();
        let told: Vec<String> = mistakes.iter().map(|mistake| format!("{mistake}, so {}", mistake.remedy())).collect();
        if !told.is_empty() {
            *remedy = told.join("; or ");
        }
    }
    error
}

/// Where each quantity is.
struct Columns {
    time: Column,
    phi: [Column; 2],
    /// What the angles are multiplied by.
    signs: [f64; 2],
    s: [Column; 2],
    sd: [Option<Column>; 2],
    base1: [Option<Column>; 2],
    base2: [Option<Column>; 2],
    force: [Option<Column>; 2],
}

impl Columns {
    fn find(table: &Table) -> Result<Self, ReadError> {
        let required = |quantity| table.require(quantity, &ALL);
        let optional = |quantity| table.find(quantity, &ALL);
        Ok(Self {
            time: required(TIME)?,
            phi: [required(PHI1)?, required(PHI2)?],
            signs: [1.0; 2],
            s: [required(S1)?, required(S2)?],
            sd: [optional(S1_SD)?, optional(S2_SD)?],
            base1: [optional(BASE1_X)?, optional(BASE1_Y)?],
            base2: [optional(BASE2_X)?, optional(BASE2_Y)?],
            force: [optional(FORCE1)?, optional(FORCE2)?],
        })
    }

    fn used(&self) -> Vec<Column> {
        let required = [self.time, self.phi[0], self.phi[1], self.s[0], self.s[1]];
        let optional = [self.sd, self.base1, self.base2, self.force];
        required.into_iter().chain(optional.into_iter().flatten().flatten()).collect()
    }

    /// `palm2_angle` reads φ₂.
    fn sample(
        &self,
        table: &Table,
        row: usize,
        palm2_angle: fn(&Table, usize, Column, f64) -> Result<f64, ReadError>,
    ) -> Result<Sample, ReadError> {
        let coordinate = |column: Option<Column>| column.map_or(Ok(0.0), |column| base_coordinate(table, row, column));
        let force = |column: Option<Column>| column.map_or(Ok(None), |column| normal_force(table, row, column));
        let sd = |column: Option<Column>| column.map_or(Ok(None), |column| standard_deviation(table, row, column));
        Ok(Sample {
            time_s: table.number(row, self.time)?,
            palms: PalmPair {
                phi1_rad: palm1_angle(table, row, self.phi[0], self.signs[0])?,
                phi2_rad: palm2_angle(table, row, self.phi[1], self.signs[1])?,
                base1_m: [coordinate(self.base1[0])?, coordinate(self.base1[1])?],
                base2_m: [coordinate(self.base2[0])?, coordinate(self.base2[1])?],
            },
            s1_m: contact_position(table, row, self.s[0])?,
            s2_m: contact_position(table, row, self.s[1])?,
            s1_sd_m: sd(self.sd[0])?,
            s2_sd_m: sd(self.sd[1])?,
            force1_n: force(self.force[0])?,
            force2_n: force(self.force[1])?,
        })
    }
}

fn unit_of(column: Column) -> &'static str {
    column.unit.map_or("", Unit::suffix)
}

fn palm1_angle(table: &Table, row: usize, column: Column, sign: f64) -> Result<f64, ReadError> {
    let phi1 = sign * table.number(row, column)?;
    if phi1.abs() <= MAX_PHI1_RAD {
        return Ok(phi1);
    }
    let text = table.shown(row, column);
    Err(table.error(
        row,
        column,
        degrees_or(column, text, |text| ReadProblem::AngleOutOfRange {
            text,
            unit: unit_of(column),
            range: "the angle of palm 1 against the X axis must lie within two turns",
        }),
    ))
}

fn palm2_angle(table: &Table, row: usize, column: Column, sign: f64) -> Result<f64, ReadError> {
    let phi2 = sign * table.number(row, column)?;
    let is_parallel = phi2.sin().abs() < MIN_SIN_PHI2;
    if phi2 > 0.0 && phi2 < PI && !is_parallel {
        return Ok(phi2);
    }
    let text = table.shown(row, column);
    let unit = unit_of(column);
    let problem = if phi2.abs() > TAU {
        degrees_or(column, text, |text| out_of_range_between_palms(text, unit))
    } else if is_parallel {
        ReadProblem::ParallelPalms { text, unit }
    } else if phi2 < 0.0 {
        ReadProblem::NegativePalmAngle { text, unit, remedy: NEGATIVE_ANGLE.to_owned() }
    } else {
        out_of_range_between_palms(text, unit)
    };
    Err(table.error(row, column, problem))
}

fn out_of_range_between_palms(text: String, unit: &'static str) -> ReadProblem {
    let range = "the angle from palm 1 to palm 2, counter-clockwise, must lie between 0 and pi (180 deg); if it is counted from the horizontal, subtract phi1";
    ReadProblem::AngleOutOfRange { text, unit, range }
}

/// A large angle in radians must be meant in degrees; in degrees it is `otherwise` wrong.
fn degrees_or(column: Column, text: String, otherwise: impl Fn(String) -> ReadProblem) -> ReadProblem {
    if column.unit == Some(Unit::Radian) {
        ReadProblem::LooksLikeDegrees { text, degrees: format!("{}_deg", column.quantity.stem) }
    } else {
        otherwise(text)
    }
}

fn contact_position(table: &Table, row: usize, column: Column) -> Result<Option<f64>, ReadError> {
    let Some(s) = table.value(row, column)? else { return Ok(None) };
    if s < 0.0 {
        let problem = ReadProblem::NegativeLength {
            text: table.shown(row, column),
            unit: unit_of(column),
            meaning: "it is the distance from the base of the palm to the contact: add how far from the base the pad begins, or leave the cell empty where no contact was seen",
        };
        return Err(table.error(row, column, problem));
    }
    within_reach(table, row, column, s).map(Some)
}

fn base_coordinate(table: &Table, row: usize, column: Column) -> Result<f64, ReadError> {
    let coordinate = table.number(row, column)?;
    within_reach(table, row, column, coordinate)
}

fn normal_force(table: &Table, row: usize, column: Column) -> Result<Option<f64>, ReadError> {
    let force_n = table.value(row, column)?;
    if force_n.is_some_and(|force_n| force_n < 0.0) {
        let problem = ReadProblem::NegativeForce { text: table.shown(row, column) };
        return Err(table.error(row, column, problem));
    }
    Ok(force_n)
}

fn standard_deviation(table: &Table, row: usize, column: Column) -> Result<Option<f64>, ReadError> {
    let Some(sd) = table.value(row, column)? else { return Ok(None) };
    if sd <= 0.0 {
        let problem = ReadProblem::NotAStandardDeviation { text: table.shown(row, column), unit: unit_of(column) };
        return Err(table.error(row, column, problem));
    }
    within_reach(table, row, column, sd).map(Some)
}

fn within_reach(table: &Table, row: usize, column: Column, length_m: f64) -> Result<f64, ReadError> {
    if length_m.abs() <= MAX_LENGTH_M {
        return Ok(length_m);
    }
    let problem = ReadProblem::TooLong {
        text: table.shown(row, column),
        unit: unit_of(column),
        limit_m: MAX_LENGTH_M,
        millimeters: if column.unit == Some(Unit::Meter) {
            format!("{}_mm", column.quantity.stem)
        } else {
            String::new()
        },
    };
    Err(table.error(row, column, problem))
}

fn notes(table: &Table, columns: &Columns, samples: &[Sample]) -> Vec<String> {
    let mut notes = Vec::new();
    let ignored = table.names_beside(&columns.used());
    if !ignored.is_empty() {
        let shown = text::list(ignored.into_iter().map(|name| if name.is_empty() { "(no name)" } else { name }));
        notes.push(format!("columns ignored: {shown}"));
    }
    let contacts = [
        samples.iter().filter_map(|s| s.s1_m).fold(0.0, f64::max),
        samples.iter().filter_map(|s| s.s2_m).fold(0.0, f64::max),
    ];
    for (farthest_m, column) in contacts.into_iter().zip(columns.s) {
        let name = text::quoted(table.name(column));
        if farthest_m > LONG_CONTACT_M {
            notes.push(format!(
                "{name}: a contact {farthest_m} m from the base of its palm; is the column in millimetres?"
            ));
        } else if farthest_m < SHORT_CONTACT_M {
            notes.push(format!(
                "{name}: no contact is more than {farthest_m} m from the base of its palm; is the unit right?"
            ));
        }
    }
    let widest_rad = samples.iter().map(|sample| sample.palms.phi2_rad).fold(0.0, f64::max);
    if columns.phi[1].unit == Some(Unit::Degree) && widest_rad.to_degrees() < PI {
        let name = text::quoted(table.name(columns.phi[1]));
        let widest = widest_rad.to_degrees();
        notes.push(format!("{name}: the palms never open wider than {widest:.3} degrees; is the column in radians?"));
    }
    if table.unended {
        notes.push("the last line has no line break; if the file was cut off, its last value may be wrong".to_string());
    }
    notes
}
