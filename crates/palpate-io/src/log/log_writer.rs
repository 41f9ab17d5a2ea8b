//! The palm log to a CSV file.

use std::path::Path;

use palpate::{Log, Sample};

use crate::csv::metadata::push_metadata;
use crate::csv::number::{number, push_row};
use crate::csv::table;
use crate::folder::write_whole;
use crate::log::log_reader::RECORDING;
use crate::write_error::{WriteError, WriteProblem};

/// Writes a palm log: SI units, digits enough to read back the same numbers, and only the optional columns that have a value in
/// any sample. The metadata go above the header as `# key: value`. The file is written whole or not at all, in place of an earlier
/// one; folders on the way to it are made. Nothing is checked: a log that makes no sense is written as it is.
///
/// # Errors
/// The file cannot be written, or metadata would not read back: a key must begin with a letter and go on in letters, digits,
/// spaces, `_`, `-` and `.`, a value must stay on one line. Spaces around either are lost.
pub fn write_log(path: &Path, log: &Log, metadata: &[(String, String)]) -> Result<(), WriteError> {
    let mut text = String::new();
    for (key, value) in metadata {
        let (key, value) = (key.trim(), value.trim());
        let line = format!("{key}: {value}");
        let reads_back = table::metadata(&line).is_some_and(|read| read.0 == key && read.1 == value);
        if !reads_back || value.contains(['\n', '\r', '\0']) {
            let problem =
                WriteProblem::Metadata { key: crate::csv::text::quoted(key), value: crate::csv::text::quoted(value) };
            return Err(WriteError::new(path, problem));
        }
        text.push_str(&format!("# {line}\n"));
    }
    text += &log_csv(log);
    write_whole(path, text.as_bytes())
}

/// The text of a palm log as [`write_log`] writes it, without metadata.
pub fn log_csv(log: &Log) -> String {
    let mut text = String::new();
    let columns = columns(log);
    push_row(&mut text, columns.iter().map(|(name, _)| name.to_string()));
    for sample in &log.samples {
        push_row(&mut text, columns.iter().map(|(_, value)| value(sample).map(number).unwrap_or_default()));
    }
    text
}

/// The head of a palm log that is written sample by sample: its metadata and a header with all columns, since it is not known yet which will have
/// values. A file that begins so may be cut off anywhere below it; its readers leave out a last line that is not whole.
pub fn log_csv_header(metadata: &[(String, String)]) -> String {
    let mut text = format!("{RECORDING}\n");
    push_metadata(&mut text, metadata);
    push_row(&mut text, ALL.iter().map(|(name, _)| name.to_string()));
    text
}

/// The line of a sample below [`log_csv_header`], appended.
pub fn push_log_row(text: &mut String, sample: &Sample) {
    push_row(text, ALL.iter().map(|(_, value)| value(sample).map(number).unwrap_or_default()));
}

/// A column name and its value in a sample.
type NamedValue = (&'static str, fn(&Sample) -> Option<f64>);

/// All columns: required ones, base points, and what may be stated.
const ALL: [NamedValue; 13] = [
    ("time_s", |sample| Some(sample.time_s)),
    ("phi1_rad", |sample| Some(sample.palms.phi1_rad)),
    ("phi2_rad", |sample| Some(sample.palms.phi2_rad)),
    ("s1_m", |sample| sample.s1_m),
    ("s2_m", |sample| sample.s2_m),
    ("base1_x_m", |sample| Some(sample.palms.base1_m[0])),
    ("base1_y_m", |sample| Some(sample.palms.base1_m[1])),
    ("base2_x_m", |sample| Some(sample.palms.base2_m[0])),
    ("base2_y_m", |sample| Some(sample.palms.base2_m[1])),
    ("s1_sd_m", |sample| sample.s1_sd_m),
    ("s2_sd_m", |sample| sample.s2_sd_m),
    ("force1_n", |sample| sample.force1_n),
    ("force2_n", |sample| sample.force2_n),
];

fn columns(log: &Log) -> Vec<NamedValue> {
    let (required, rest) = ALL.split_at(5);
    let (bases, stated) = rest.split_at(4);
    let mut columns = required.to_vec();
    let is_apart = |sample: &Sample| sample.palms.base1_m != [0.0; 2] || sample.palms.base2_m != [0.0; 2];
    if log.samples.iter().any(is_apart) {
        columns.extend(bases);
    }
    columns.extend(stated.iter().filter(|(_, value)| log.samples.iter().any(|sample| value(sample).is_some())));
    columns
}
