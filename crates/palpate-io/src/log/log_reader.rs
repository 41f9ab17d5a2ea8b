//! The palm log from a CSV file.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use palpate::palms::PalmPair;
use palpate::reconstruct::Mistake;
use palpate::{Log, Sample};

use crate::csv::bytes::read_bytes;
use crate::csv::name::plain;
use crate::csv::table::{Column, Quantity, Table, header_has, metadata};
use crate::csv::text;
use crate::csv::unit::{Dimension, Unit};
use crate::log::plausible::{self, MAX_COORDINATE_M, MAX_REACH_M, unit_of};
use crate::read_error::{ReadError, ReadProblem};
use crate::rig::conventions::Conventions;
use crate::rig::{RigFile, comment};
use crate::strokes::reader::PIVOT_X;

/// Fewest samples with a contact on both palms that a log must have: fewer cannot be solved for a shape.
pub const MIN_SAMPLES: usize = palpate::reconstruct::FEWEST_SAMPLES;

/// Palms closer to parallel than this, as |sin φ₂|, cannot be told from parallel ones.
const MIN_SIN_PHI2: f64 = 1e-3;
/// The unwrapped angle of palm 1 stays within this many radians.
const MAX_PHI1_RAD: f64 = 2.0 * TAU;

/// Latest time of a sample from elsewhere, seconds: beyond, a hundredth of a second is lost in the rounding of the number.
const MAX_TIME_S: f64 = 1e13;

const NO_CONTACT: &str = "no contact was seen";
const NOT_STATED: &str = "it is not known";
pub(super) const TIME: Quantity = Quantity::new("time", Dimension::Time).also_named(&["timestamp", "time_stamp"]);
pub(super) const PHI1: Quantity = Quantity::new("phi1", Dimension::Angle);
pub(super) const PHI2: Quantity = Quantity::new("phi2", Dimension::Angle);
const S1: Quantity = Quantity::or_empty("s1", Dimension::Length, NO_CONTACT);
const S2: Quantity = Quantity::or_empty("s2", Dimension::Length, NO_CONTACT);
const S1_SD: Quantity = Quantity::or_empty("s1_sd", Dimension::Length, NOT_STATED);
const S2_SD: Quantity = Quantity::or_empty("s2_sd", Dimension::Length, NOT_STATED);
pub(super) const BASE1_X: Quantity = Quantity::new("base1_x", Dimension::Length);
pub(super) const BASE1_Y: Quantity = Quantity::new("base1_y", Dimension::Length);
pub(super) const BASE2_X: Quantity = Quantity::new("base2_x", Dimension::Length);
pub(super) const BASE2_Y: Quantity = Quantity::new("base2_y", Dimension::Length);
const FORCE1: Quantity = Quantity::or_empty("force1", Dimension::Force, NOT_STATED);
const FORCE2: Quantity = Quantity::or_empty("force2", Dimension::Force, NOT_STATED);
const ALL: [Quantity; 13] =
    [TIME, PHI1, PHI2, S1, S2, S1_SD, S2_SD, BASE1_X, BASE1_Y, BASE2_X, BASE2_Y, FORCE1, FORCE2];
pub(super) const HEADER: &str = "time_s,phi1_rad,phi2_rad,s1_m,s2_m";

/// A palm log as it came from a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogFile {
    /// The samples, in SI units.
    pub log: Log,
    /// The `# key: value` lines, in the order of the file.
    pub metadata: Vec<(String, String)>,
    /// What the user may want to know about the file, a sentence each: columns left aside, a last line that may be cut off.
    pub notes: Vec<String>,
}

/// Reads a palm log.
///
/// Columns are found by name, in any order, upper or lower case, separated by commas (or all by semicolons or tabs, then with decimal
/// commas or points); their units are converted. Required: time (or timestamp), phi1, phi2, s1, s2. Optional: the standard deviations s1_sd
/// and s2_sd, the base points base1_x, base1_y, base2_x, base2_y, and force1, force2. Lengths end in `_m`, `_cm`, `_mm` or `_um`, angles in
/// `_rad` or `_deg`, times in `_s`, `_ms`, `_us` or `_ns`, forces in `_n`; the unit may also stand in brackets, as in `phi1 (deg)`, or
/// in a row of units below the names. An empty
/// cell or NaN in s1 or s2 means that no contact was seen; in a standard deviation or force, that it is not known. A file that gzip
/// compressed is unpacked.
///
/// # Errors
/// The file cannot be read or is no usable palm log; see [`ReadProblem`]. In particular time must increase from sample to sample,
/// the angle φ₂ between the palms must lie between 0 and π with |sin φ₂| ≥ 0.001, [`MIN_SAMPLES`] samples must have a contact on both
/// palms, and sizes must be those of two palms: contacts within 2 m of the base and the farthest at least 1 mm from it, bases within 2 m
/// of each other, palms that open wider than π degrees, at most eleven days and ten thousand samples per second.
pub fn read_log(path: &Path) -> Result<LogFile, ReadError> {
    parse_log(&path.to_string_lossy(), &read_bytes(path)?)
}

/// The same for a log that a rig wrote by its own conventions: signs of the angles, direction of the pads, base points.
///
/// # Errors
/// As [`read_log`].
pub fn read_log_as(path: &Path, conventions: &Conventions) -> Result<LogFile, ReadError> {
    parse_log_as(&path.to_string_lossy(), &read_bytes(path)?, conventions)
}

/// The same for a log that may say by itself what rig wrote it, in a comment `# rig: …` above its header (as `palpate simulate` writes it, see
/// [`rig_comment`](crate::rig_comment)), with what it says.
///
/// # Errors
/// As [`read_log`]; also when the comment says nothing that can be understood.
pub fn read_log_with_rig(path: &Path) -> Result<(LogFile, Option<RigFile>), ReadError> {
    parse_log_with_rig(&path.to_string_lossy(), &read_bytes(path)?)
}

/// Reads a palm log from memory; `name` stands for the file in messages. Compressed bytes are for [`bytes_from`](crate::bytes_from).
///
/// # Errors
/// As [`read_log`].
pub fn parse_log(name: &str, bytes: &[u8]) -> Result<LogFile, ReadError> {
    parse_log_as(name, bytes, &Conventions::default())
}

/// The same as [`read_log_as`], from memory.
///
/// # Errors
/// As [`read_log`].
pub fn parse_log_as(name: &str, bytes: &[u8], conventions: &Conventions) -> Result<LogFile, ReadError> {
    let (whole, cut) = whole_lines(bytes);
    let mut file = by_conventions(name, Table::parse(name, whole, HEADER)?, conventions)?;
    file.notes.extend(cut);
    Ok(file)
}

/// The same as [`read_log_with_rig`], from memory.
///
/// # Errors
/// As [`read_log_with_rig`].
pub fn parse_log_with_rig(name: &str, bytes: &[u8]) -> Result<(LogFile, Option<RigFile>), ReadError> {
    let (whole, cut) = whole_lines(bytes);
    let table = Table::parse(name, whole, HEADER)?;
    let said = table.metadata.iter().find(|(key, _)| key == comment::KEY);
    let rig = said.map(|(_, value)| in_comment(name, value)).transpose()?;
    let conventions = rig.as_ref().map(|rig| rig.conventions).unwrap_or_default();
    let mut file = by_conventions(name, table, &conventions)?;
    file.notes.extend(cut);
    Ok((file, rig))
}

/// The rig that a comment line above the header of a log states (`# rig: …`), as [`read_log_with_rig`] reads it; `None` for any other line.
///
/// # Errors
/// The comment says nothing that can be understood.
pub fn rig_of_comment(name: &str, line: &str) -> Result<Option<RigFile>, ReadError> {
    let said = line.trim_start().strip_prefix('#').and_then(metadata).filter(|(key, _)| key == comment::KEY);
    said.map(|(_, value)| in_comment(name, &value)).transpose()
}

fn in_comment(name: &str, value: &str) -> Result<RigFile, ReadError> {
    comment::parse_rig_comment(name, value)
        .map_err(|error| ReadError::in_file(name, ReadProblem::RigComment { problem: error.problem.to_string() }))
}

/// The first line of a file that is written as the samples come, so that its last line may be cut off; see [`log_csv_header`](crate::log_csv_header).
pub const RECORDING: &str = "# recorded by: palpate record";

/// A recording without a last line that was cut off, and a note that it was; any other file as it is.
pub(crate) fn whole_lines(bytes: &[u8]) -> (&[u8], Option<String>) {
    if !bytes.starts_with(RECORDING.as_bytes()) || bytes.ends_with(b"\n") {
        return (bytes, None);
    }
    let whole = bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |last| last + 1);
    (&bytes[..whole], Some("the recording ended in the middle of a line, which is left out".to_string()))
}

fn by_conventions(name: &str, table: Table, conventions: &Conventions) -> Result<LogFile, ReadError> {
    let columns = Columns { signs: conventions.angle_signs, ..Columns::find(&table)? };
    table.require_rows()?;
    let mut file = from_table(name, table, &columns)?;
    file.log = Conventions { angle_signs: [1.0; 2], ..*conventions }.apply(&file.log);
    Ok(file)
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

/// The name in seconds of a column of time that is named in another unit or in none: `time_s` for `time` and `Time (ms)`, `timestamp_s` for
/// `timestamp`; `None` for a column of anything else. For values that know their unit by themselves, such as dates.
pub fn name_in_seconds(name: &str) -> Option<String> {
    TIME.stem_in(&plain(name)).map(|stem| format!("{stem}_{}", Unit::Second.suffix()))
}

/// Whether the header of a file has the columns of two palms: it is a palm log, or a motion of palms, and no outline of an object.
pub fn is_palm_log(bytes: &[u8]) -> bool {
    header_has(bytes, PHI1)
}

fn from_table(name: &str, table: Table, columns: &Columns) -> Result<LogFile, ReadError> {
    table.require_one_decimal_mark(&columns.used())?;
    let mut samples: Vec<Sample> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let sample = columns.sample(&table, row).map_err(|error| with_remedy(error, &table, columns))?;
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
    plausible::check(&table, columns, &samples)?;
    let notes = notes(&table, columns);
    Ok(LogFile { log: Log { samples }, metadata: table.metadata, notes })
}

/// What a negative angle between the palms may be, where nothing tells.
const NEGATIVE_ANGLE: &str = "reverse its sign, and that of phi1 if this is counted clockwise too; or, if palm 2 stands under the names of palm 1, exchange s1 and s2, and write phi1 + phi2 for phi1 and -phi2 for phi2";

/// An error with what to do about it by the whole log: palms whose angle is negative throughout hold an object in one way only.
fn with_remedy(mut error: ReadError, table: &Table, columns: &Columns) -> ReadError {
    if let ReadProblem::NegativePalmAngle { remedy, .. } = &mut *error.problem {
        let any_angle = |table: &Table, row, column, sign| Ok(sign * table.number(row, column)?);
        let samples: Result<Vec<Sample>, ReadError> =
            (0..table.rows()).map(|row| columns.sample_with(table, row, any_angle)).collect();
        let mistakes = samples.map(|samples| Mistake::of_palms_that_hold_nothing(&Log { samples })).unwrap_or_default();
        let told: Vec<String> = mistakes.iter().map(|mistake| format!("{mistake}, so {}", mistake.remedy())).collect();
        if !told.is_empty() {
            *remedy = told.join("; or ");
        }
    }
    error
}

/// Where each quantity is.
pub(crate) struct Columns {
    pub(crate) time: Column,
    pub(crate) phi: [Column; 2],
    /// What the angles are multiplied by.
    pub(super) signs: [f64; 2],
    pub(crate) s: [Column; 2],
    sd: [Option<Column>; 2],
    base1: [Option<Column>; 2],
    base2: [Option<Column>; 2],
    force: [Option<Column>; 2],
}

/// What is wrong with the columns of a log of another rig.
fn of_strokes(table: &Table) -> Option<ReadError> {
    let pivot = table.find(PIVOT_X, &[PIVOT_X]).ok()??;
    Some(table.column_error(pivot, ReadProblem::Strokes))
}

impl Columns {
    pub(super) fn find(table: &Table) -> Result<Self, ReadError> {
        let [time, phi1, phi2, s1, s2] =
            table.require_all([TIME, PHI1, PHI2, S1, S2], &ALL).map_err(|error| of_strokes(table).unwrap_or(error))?;
        let optional = |quantity| table.find(quantity, &ALL);
        Ok(Self {
            time,
            phi: [phi1, phi2],
            signs: [1.0; 2],
            s: [s1, s2],
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

    /// The column of the coordinate that takes the bases of a sample farthest apart, where they have any.
    pub(crate) fn farthest_base(&self, sample: &Sample) -> Option<Column> {
        let bases = [(self.base1, sample.palms.base1_m), (self.base2, sample.palms.base2_m)];
        let coordinates = bases.into_iter().flat_map(|(columns, base_m)| columns.into_iter().zip(base_m));
        let given = coordinates.filter_map(|(column, coordinate_m)| Some((column?, coordinate_m.abs())));
        given.max_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(column, _)| column)
    }

    /// The sample of a row.
    pub(super) fn sample(&self, table: &Table, row: usize) -> Result<Sample, ReadError> {
        self.sample_with(table, row, palm2_angle)
    }

    /// `palm2_angle` reads φ₂.
    fn sample_with(
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

/// What a log would not take of a sample that comes from elsewhere, in a few words; `None` where all is well.
///
/// ```
/// use palpate::{Sample, palms::PalmPair};
/// assert_eq!(palpate_io::fault_of(&Sample::new(0.0, PalmPair::hinged(1.0, 1.2), 0.03, 0.03)), None);
/// assert_eq!(palpate_io::fault_of(&Sample::new(0.0, PalmPair::hinged(1.0, 1.2), 0.03, -0.03)), Some("a contact beyond its palm"));
/// ```
pub fn fault_of(sample: &Sample) -> Option<&'static str> {
    let Sample { time_s, palms, s1_m, s2_m, s1_sd_m, s2_sd_m, force1_n, force2_n } = *sample;
    let all = |values: [Option<f64>; 2], good: fn(f64) -> bool| values.into_iter().flatten().all(good);
    let bases = [palms.base1_m, palms.base2_m];
    let checks = [
        ("a time that is none", time_s.abs() <= MAX_TIME_S),
        ("an angle of palm 1 beyond two turns", palms.phi1_rad.abs() <= MAX_PHI1_RAD),
        ("palms that do not open between 0 and 180 degrees", palms.phi2_rad > 0.0 && palms.phi2_rad < PI),
        ("parallel palms", palms.phi2_rad.sin().abs() >= MIN_SIN_PHI2),
        ("a base point far away", bases.as_flattened().iter().all(|length_m| length_m.abs() <= MAX_COORDINATE_M)),
        ("a contact beyond its palm", all([s1_m, s2_m], |s_m| (0.0..=MAX_REACH_M).contains(&s_m))),
        ("a standard deviation that is none", all([s1_sd_m, s2_sd_m], |sd_m| sd_m > 0.0 && sd_m <= MAX_REACH_M)),
        ("a negative force", all([force1_n, force2_n], |force_n| force_n >= 0.0 && force_n.is_finite())),
    ];
    checks.into_iter().find_map(|(fault, good)| (!good).then_some(fault))
}

pub(super) fn palm1_angle(table: &Table, row: usize, column: Column, sign: f64) -> Result<f64, ReadError> {
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

pub(super) fn palm2_angle(table: &Table, row: usize, column: Column, sign: f64) -> Result<f64, ReadError> {
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
    table.within(row, column, s, MAX_REACH_M).map(Some)
}

pub(super) fn base_coordinate(table: &Table, row: usize, column: Column) -> Result<f64, ReadError> {
    let coordinate = table.number(row, column)?;
    table.within(row, column, coordinate, MAX_COORDINATE_M)
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
    table.within(row, column, sd, MAX_REACH_M).map(Some)
}

fn notes(table: &Table, columns: &Columns) -> Vec<String> {
    let mut notes = Vec::new();
    let ignored = table.names_beside(&columns.used());
    if !ignored.is_empty() {
        let shown = text::list(ignored.into_iter().map(|name| if name.is_empty() { "(no name)" } else { name }));
        notes.push(format!("columns ignored: {shown}"));
    }
    if table.unended {
        notes.push("the last line has no line break; if the file was cut off, its last value may be wrong".to_string());
    }
    notes
}
