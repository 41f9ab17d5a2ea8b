//! The truth folder beside a log: shape.csv and motion.csv.

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};

use palpate::Truth;
use palpate::truth::TruePose;

use crate::csv::bytes::read_bytes;
use crate::csv::number::{number, push_row};
use crate::csv::table::{Column, Quantity, Table};
use crate::csv::unit::{Dimension, Unit};
use crate::folder::FolderKind;
use crate::read_error::{ReadError, ReadProblem};
use crate::write_error::WriteError;

const SHAPE_FILE: &str = "shape.csv";
const MOTION_FILE: &str = "motion.csv";
const SHAPE_HEADER: &str = "theta_rad,r_m";
const MOTION_HEADER: &str = "time_s,psi_rad,com_x_m,com_y_m";

pub(crate) const THETA: Quantity = Quantity::new("theta", Dimension::Angle);
pub(crate) const R: Quantity = Quantity::new("r", Dimension::Length);
const TIME: Quantity = Quantity::new("time", Dimension::Time);
const PSI: Quantity = Quantity::new("psi", Dimension::Angle);
const COM_X: Quantity = Quantity::new("com_x", Dimension::Length);
const COM_Y: Quantity = Quantity::new("com_y", Dimension::Length);

/// Fewest directions that make a shape.
const MIN_DIRECTIONS: usize = 8;
/// A last row this close to 2π repeats the first one, radians.
const CLOSING_RAD: f64 = 1e-6;

const TRUTH: FolderKind<'static> = FolderKind {
    kind: "truth",
    files: TRUTH_FILES,
    numbered: None,
    folders: (&[], &[]),
    mark: SHAPE_FILE,
    is_mark: is_truth_shape,
};

/// A result folder has a shape.csv too, with more columns: it is told apart by the header.
fn is_truth_shape(path: &Path) -> bool {
    fs::read_to_string(path).is_ok_and(|text| text.lines().next().is_some_and(|line| line.trim_end() == SHAPE_HEADER))
}

/// Where the truth of a log is: `NAME.truth` beside `NAME.csv` or `NAME.csv.gz`.
pub fn truth_dir_of(log_path: &Path) -> PathBuf {
    let is_compressed = log_path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gz"));
    let unpacked = is_compressed.then(|| log_path.with_extension(""));
    let log_path = unpacked.as_deref().unwrap_or(log_path);
    let is_csv = log_path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    if is_csv {
        return log_path.with_extension("truth");
    }
    let mut name = log_path.as_os_str().to_os_string();
    name.push(".truth");
    PathBuf::from(name)
}

/// Reads a truth folder: `shape.csv` with theta and r (the support function about the centre of mass), `motion.csv` with time,
/// psi, com_x and com_y. Units are converted as in [`read_log`](crate::read_log); further columns are left aside. A last row of the
/// shape at θ = 2π that repeats the first is dropped.
///
/// # Errors
/// A file cannot be read, lacks a column or holds something else than finite numbers; θ does not increase within [0, 2π), r is
/// negative or there are fewer than 8 directions; time does not increase or there is no pose.
pub fn read_truth(dir: &Path) -> Result<Truth, ReadError> {
    let name = dir.to_string_lossy();
    let metadata = fs::metadata(dir).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => ReadError::in_file(&name, ReadProblem::MissingFolder),
        _ => ReadError::io(dir, &error),
    })?;
    if !metadata.is_dir() {
        return Err(ReadError::in_file(&name, ReadProblem::IsFile));
    }
    Ok(Truth { support: read_support(&dir.join(SHAPE_FILE))?, motion: read_motion(&dir.join(MOTION_FILE))? })
}

fn read_support(path: &Path) -> Result<Vec<(f64, f64)>, ReadError> {
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    support(&name, &Table::parse(&name, &bytes, SHAPE_HEADER)?, &[THETA, R])
}

/// The samples (θ in radians, r in metres) of a support function in a table that may hold `all` these quantities.
pub(crate) fn support(name: &str, table: &Table, all: &[Quantity]) -> Result<Vec<(f64, f64)>, ReadError> {
    let [theta_column, r_column] = table.require_all([THETA, R], all)?;
    table.require_rows()?;
    let mut support: Vec<(f64, f64)> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let theta = table.number(row, theta_column)?;
        let r = table.number(row, r_column)?;
        if row > 0 && row + 1 == table.rows() && (theta - TAU).abs() < CLOSING_RAD {
            break;
        }
        if !(0.0..TAU).contains(&theta) {
            return Err(table.error(row, theta_column, outside_circle(table, row, theta_column, theta)));
        }
        if let Some(&(before, _)) = support.last() {
            table.require_increase(row, theta_column, before, theta, "theta")?;
        }
        if r < 0.0 {
            let problem = ReadProblem::NegativeLength {
                text: table.shown(row, r_column),
                unit: r_column.unit.map_or("", Unit::suffix),
                meaning: "the support function about the centre of mass cannot be negative; use a point inside the object",
            };
            return Err(table.error(row, r_column, problem));
        }
        support.push((theta, r));
    }
    require(name, support.len(), MIN_DIRECTIONS)?;
    Ok(support)
}

fn outside_circle(table: &Table, row: usize, column: Column, theta: f64) -> ReadProblem {
    let text = table.shown(row, column);
    if column.unit == Some(Unit::Radian) && theta > TAU {
        return ReadProblem::LooksLikeDegrees { text, degrees: "theta_deg".to_string() };
    }
    let range = "a direction must lie between 0 and 2 pi (360 deg), the end left out";
    ReadProblem::AngleOutOfRange { text, unit: column.unit.map_or("", Unit::suffix), range }
}

fn read_motion(path: &Path) -> Result<Vec<TruePose>, ReadError> {
    const ALL: [Quantity; 4] = [TIME, PSI, COM_X, COM_Y];
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    let table = Table::parse(&name, &bytes, MOTION_HEADER)?;
    let [time, psi, com_x, com_y] = ALL.map(|quantity| table.require(quantity, &ALL));
    let (time, psi, com_x, com_y) = (time?, psi?, com_x?, com_y?);
    table.require_rows()?;
    let mut motion: Vec<TruePose> = Vec::with_capacity(table.rows());
    for row in 0..table.rows() {
        let pose = TruePose {
            time_s: table.number(row, time)?,
            psi_rad: table.number(row, psi)?,
            com_x_m: table.number(row, com_x)?,
            com_y_m: table.number(row, com_y)?,
        };
        if let Some(before) = motion.last() {
            table.require_increase(row, time, before.time_s, pose.time_s, "time")?;
        }
        motion.push(pose);
    }
    Ok(motion)
}

fn require(name: &str, rows: usize, needed: usize) -> Result<(), ReadError> {
    if rows >= needed { Ok(()) } else { Err(ReadError::in_file(name, ReadProblem::TooFewRows { rows, needed })) }
}

/// Names of the files of a truth folder.
pub(crate) const TRUTH_FILES: &[&str] = &[SHAPE_FILE, MOTION_FILE];

/// What the files of a truth folder hold, in the order of their names.
pub(crate) fn truth_csv(truth: &Truth) -> [String; 2] {
    let mut shape = format!("{SHAPE_HEADER}\n");
    for &(theta, r) in &truth.support {
        push_row(&mut shape, [theta, r].map(number));
    }
    let mut motion = format!("{MOTION_HEADER}\n");
    for pose in &truth.motion {
        push_row(&mut motion, [pose.time_s, pose.psi_rad, pose.com_x_m, pose.com_y_m].map(number));
    }
    [shape, motion]
}

/// Writes a truth folder, whole or not at all, in place of an earlier truth folder; folders on the way to it are made.
///
/// # Errors
/// The folder cannot be written, or holds anything but an earlier truth.
pub fn write_truth(dir: &Path, truth: &Truth) -> Result<(), WriteError> {
    let [shape, motion] = truth_csv(truth);
    TRUTH.write(dir, &[(SHAPE_FILE.into(), shape.as_bytes()), (MOTION_FILE.into(), motion.as_bytes())])
}
