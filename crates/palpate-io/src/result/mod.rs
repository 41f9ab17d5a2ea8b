//! The result folder: shape.csv, motion.csv, summary.json, report.html and the alternatives, there as a whole or not at all.

pub(crate) mod doubts;
pub(crate) mod figures;
pub(crate) mod summary;

use std::fs;
use std::path::{Path, PathBuf};

use palpate::Reconstruction;
use palpate::mechanics::ContactMode;
use palpate::palms::GeneralizedContactSupport;
use palpate::reconstruct::{ContactDiagnostics, OutlinePoint, Pose};

use crate::csv::bytes::read_bytes;
use crate::csv::columns::{
    MODE_QUANTITIES, MOTION_HEADER, MOTION_QUANTITIES, SHAPE_HEADER, SHAPE_QUANTITIES, point_of, point_row, pose_of,
    pose_row,
};
use crate::csv::number::{number, push_row};
use crate::csv::table::{Column, Quantity, Table};
use crate::folder::{FolderKind, Numbered};
use crate::read_error::{ReadError, ReadProblem};
use crate::result::summary::Summary;
use crate::write_error::{WriteError, WriteProblem};

const SHAPE_FILE: &str = "shape.csv";
const MOTION_FILE: &str = "motion.csv";
const SUMMARY_FILE: &str = "summary.json";
const REPORT_FILE: &str = "report.html";
const DIAGNOSTICS_FILE: &str = "diagnostics.csv";
const ALTERNATIVES_FOLDER: &str = "alternatives";
const DIAGNOSTICS_HEADER: &str = "time_s,generalized_r1_m,generalized_d1_m,generalized_r2_m,generalized_d2_m,curvature_radius1_m,curvature_radius2_m,contact_vector_error_m";

const RESULT: FolderKind<'static> = FolderKind {
    kind: "result",
    files: &[SHAPE_FILE, MOTION_FILE, SUMMARY_FILE, REPORT_FILE, DIAGNOSTICS_FILE],
    numbered: Some(Numbered { name: ALTERNATIVES_FOLDER, files: &[SHAPE_FILE, MOTION_FILE, SUMMARY_FILE] }),
    folders: (&[], &[]),
    mark: SUMMARY_FILE,
    is_mark: |path| fs::read(path).is_ok_and(|bytes| serde_json::from_slice::<Summary>(&bytes).is_ok()),
};

/// Whether [`write_result`] could write to `dir`, asked before a long computation. Nothing is left behind.
///
/// # Errors
/// `dir` is a file, the current folder, or holds anything but an earlier result; or no folder can be made there.
pub fn check_result_target(dir: &Path) -> Result<(), WriteError> {
    RESULT.check(dir)
}

/// Writes a result folder: `shape.csv`, `motion.csv`, `summary.json`, `report.html`; and for each arrangement besides that fits
/// equally well a folder `alternatives/1`, `alternatives/2` ... with the first three (see [`alternative_dir_of`]).
///
/// The folder is written aside, in its parent, and renamed, so that a killed run leaves no half result under its name. An earlier
/// result is replaced; an empty folder is used; folders on the way are made; a link to a folder is followed. Numbers are written
/// with the fewest digits that read back the same; one that could not be computed is `NaN` or `inf` in CSV and `null` in JSON.
///
/// # Errors
/// As [`check_result_target`], or the disk is full. What was there before is then untouched.
pub fn write_result(
    dir: &Path,
    reconstruction: &Reconstruction,
    summary: &Summary,
    report_html: &str,
) -> Result<(), WriteError> {
    write_all(dir, reconstruction, summary, report_html, None)
}

/// [`write_result`] with a `diagnostics.csv` besides, a row per sample of the log. What is not known is an empty cell.
///
/// # Errors
/// As [`write_result`].
pub fn write_result_with_diagnostics(
    dir: &Path,
    reconstruction: &Reconstruction,
    summary: &Summary,
    report_html: &str,
    diagnostics: &[ContactDiagnostics],
) -> Result<(), WriteError> {
    write_all(dir, reconstruction, summary, report_html, Some(diagnostics_csv(diagnostics)))
}

fn write_all(
    dir: &Path,
    reconstruction: &Reconstruction,
    summary: &Summary,
    report_html: &str,
    diagnostics: Option<String>,
) -> Result<(), WriteError> {
    let mut files = files_of(Path::new(""), reconstruction, summary, dir)?.to_vec();
    for (index, other) in reconstruction.others.iter().enumerate() {
        let inside = alternative_dir_of(Path::new(""), index + 1);
        files.extend(files_of(&inside, other, &summary.of_alternative(other), dir)?);
    }
    let mut files: Vec<(PathBuf, &[u8])> = files.iter().map(|(path, text)| (path.clone(), text.as_bytes())).collect();
    files.push((REPORT_FILE.into(), report_html.as_bytes()));
    if let Some(diagnostics) = &diagnostics {
        files.push((DIAGNOSTICS_FILE.into(), diagnostics.as_bytes()));
    }
    RESULT.write(dir, &files)
}

/// Where the alternative of that number (from 1) is in the result folder `dir`. Its `shape.csv`, `motion.csv` and `summary.json`
/// are read as those of the result itself.
pub fn alternative_dir_of(dir: &Path, number: usize) -> PathBuf {
    alternatives_dir_of(dir).join(number.to_string())
}

/// Where the alternatives are in the result folder `dir`, if there are any.
pub fn alternatives_dir_of(dir: &Path) -> PathBuf {
    dir.join(ALTERNATIVES_FOLDER)
}

/// The three files of one arrangement, to lie in the folder `inside` of the result folder `dir`.
fn files_of(
    inside: &Path,
    reconstruction: &Reconstruction,
    summary: &Summary,
    dir: &Path,
) -> Result<[(PathBuf, String); 3], WriteError> {
    let summary_path = inside.join(SUMMARY_FILE);
    let json = summary.to_json().map_err(|error| {
        let message = error.to_string();
        WriteError::new(&dir.join(&summary_path), WriteProblem::Io { kind: std::io::ErrorKind::InvalidData, message })
    })?;
    Ok([
        (inside.join(SHAPE_FILE), shape_csv(&reconstruction.outline)),
        (inside.join(MOTION_FILE), motion_csv(&reconstruction.motion)),
        (summary_path, json),
    ])
}

fn shape_csv(outline: &[OutlinePoint]) -> String {
    let mut text = format!("{SHAPE_HEADER}\n");
    outline.iter().for_each(|point| push_row(&mut text, point_row(point).map(number)));
    text
}

fn motion_csv(motion: &[Pose]) -> String {
    let mut text = format!("{MOTION_HEADER}\n");
    for pose in motion {
        let modes = [0, 1].map(|palm: usize| pose.modes.map(|modes| modes[palm].name().to_owned()).unwrap_or_default());
        push_row(&mut text, pose_row(pose).map(number).into_iter().chain(modes));
    }
    text
}

fn diagnostics_csv(diagnostics: &[ContactDiagnostics]) -> String {
    let mut text = format!("{DIAGNOSTICS_HEADER}\n");
    for sample in diagnostics {
        let support = |value: fn(&GeneralizedContactSupport) -> f64| sample.support.as_ref().map(value);
        let numbers = [
            Some(sample.time_s),
            support(|support| support.r1),
            support(|support| support.d1),
            support(|support| support.r2),
            support(|support| support.d2),
            sample.curvature_radius1_m,
            sample.curvature_radius2_m,
            sample.contact_vector_error_m,
        ];
        push_row(&mut text, numbers.into_iter().map(|value| value.map(number).unwrap_or_default()));
    }
    text
}

/// The boundary from the `shape.csv` of the result folder `dir`.
///
/// # Errors
/// The file cannot be read, lacks a column or holds text where a number belongs.
pub fn read_shape_csv(dir: &Path) -> Result<Vec<OutlinePoint>, ReadError> {
    let rows = read_rows(&dir.join(SHAPE_FILE), &SHAPE_QUANTITIES, SHAPE_HEADER)?;
    Ok(rows.into_iter().map(point_of).collect())
}

/// The poses from the `motion.csv` of the result folder `dir`. The residuals are not in that file; they read back as `None`.
///
/// # Errors
/// The file cannot be read, lacks a column or holds text where a number belongs.
pub fn read_motion_csv(dir: &Path) -> Result<Vec<Pose>, ReadError> {
    let path = dir.join(MOTION_FILE);
    let (name, bytes) = (path.to_string_lossy(), read_bytes(&path)?);
    let table = Table::parse(&name, &bytes, MOTION_HEADER)?;
    let rows = rows(&table, &MOTION_QUANTITIES)?;
    let [first, second] = MODE_QUANTITIES.map(|quantity| table.find(quantity, &MODE_QUANTITIES));
    let columns = first?.zip(second?);
    let read = |(row, numbers): (usize, [f64; 9])| {
        let modes = match columns {
            Some((first, second)) => mode(&table, row, first)?.zip(mode(&table, row, second)?),
            None => None,
        };
        Ok(Pose { modes: modes.map(Into::into), ..pose_of(numbers) })
    };
    rows.into_iter().enumerate().map(read).collect()
}

/// The `summary.json` of the result folder `dir`.
///
/// # Errors
/// The file cannot be read or is no summary.
pub fn read_summary(dir: &Path) -> Result<Summary, ReadError> {
    let path = dir.join(SUMMARY_FILE);
    serde_json::from_slice(&read_bytes(&path)?).map_err(|error| {
        let message = error.to_string();
        ReadError::in_file(&path.to_string_lossy(), ReadProblem::Json { message })
    })
}

/// The columns `quantities` of every row.
fn read_rows<const N: usize>(
    path: &Path,
    quantities: &[Quantity; N],
    header: &'static str,
) -> Result<Vec<[f64; N]>, ReadError> {
    let (name, bytes) = (path.to_string_lossy(), read_bytes(path)?);
    rows(&Table::parse(&name, &bytes, header)?, quantities)
}

/// A contact mode; `None` where the cell is empty.
fn mode(table: &Table, row: usize, column: Column) -> Result<Option<ContactMode>, ReadError> {
    let text = table.cell(row, column);
    if text.is_empty() {
        return Ok(None);
    }
    let unknown = || table.error(row, column, ReadProblem::NoContactMode { text: table.shown(row, column) });
    ContactMode::named(text).map(Some).ok_or_else(unknown)
}

fn rows<const N: usize>(table: &Table, quantities: &[Quantity; N]) -> Result<Vec<[f64; N]>, ReadError> {
    let columns =
        quantities.iter().map(|&quantity| table.require(quantity, quantities)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = vec![[0.0; N]; table.rows()];
    for (row, values) in rows.iter_mut().enumerate() {
        for (value, &column) in values.iter_mut().zip(&columns) {
            *value = table.any_number(row, column)?;
        }
    }
    Ok(rows)
}
