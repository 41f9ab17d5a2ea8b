//! The rig from a TOML file.

use std::borrow::Cow;
use std::fs::File;
use std::io::{self, Read};
use std::ops::Range;
use std::path::Path;

use palpate::sensor::{Calibration, Rig, Tolerances};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::rig::conventions::{Conventions, Direction, PalmConventions};
use crate::rig::key::{
    ANGLE_READING_SD, ANGLE_ZERO, ANGLE_ZERO_SD, BASE, CLOCK, CLOCK_SD, COUNTS_PER_INCH, DIFFERENCE_SD, DIRECTION,
    FRICTION, FRICTION_SD, LENGTH, LEVELS, RATIO_SD, READING_SD, SCALE, SCALE_SD, SIGN, SURFACE, SURFACE_SD, TABLES,
    ZERO, ZERO_SD, nearest_key, nearest_table,
};
use crate::rig::rig_error::{RigError, RigProblem};
use crate::rig::table::{Entry, Limit, Table};
use crate::rig::{Pad, RigFile};

/// Largest rig file that is read, KiB.
const LIMIT_KIB: u64 = 1024;

/// Largest error of a position, and largest surface offset.
const OFFSET: Limit = Limit(0.1, "0.1 m");
/// Longest pad.
const PAD: Limit = Limit(10.0, "10 m");
/// Farthest base point, as in a log.
const REACH: Limit = Limit(100.0, "100 m");
/// Largest error of an angle.
const TURN: Limit = Limit(0.5, "0.5 rad (28.6 deg)");
/// Largest offset of the clock.
const LATE: Limit = Limit(1.0, "1 s");

/// Reads a rig file.
///
/// The tables are `[palm1]`, `[palm2]`, `[pads]`, `[angles]` and `[clock]`; see [`rig_template`](crate::rig_template) for the keys. Lengths end in
/// `_m`, `_cm`, `_mm` or `_um`, angles in `_rad` or `_deg`, times in `_s`, `_ms`, `_us` or `_ns`. A missing constant is 0 (a scale 1), a missing standard
/// deviation the default of [`Tolerances`]; a standard deviation of 0 means exact.
///
/// # Errors
/// The file cannot be read or is no usable rig file; see [`RigProblem`].
pub fn read_rig(path: &Path) -> Result<RigFile, RigError> {
    let file = path.to_string_lossy();
    let failed = |error: io::Error| RigError::io(&file, &error);
    let mut source = File::open(path).map_err(failed)?;
    if source.metadata().map_err(failed)?.is_dir() {
        return Err(RigError::in_file(&file, RigProblem::IsFolder));
    }
    let limit = 1024 * LIMIT_KIB;
    let mut bytes = Vec::new();
    (&mut source).take(limit + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > limit {
        return Err(RigError::in_file(&file, RigProblem::TooLarge { limit_kib: LIMIT_KIB }));
    }
    let text = String::from_utf8(bytes).map_err(|_| RigError::in_file(&file, RigProblem::NotUtf8))?;
    parse_rig(&file, &text)
}

/// Reads a rig file from memory; `file` is what messages call it.
///
/// # Errors
/// As [`read_rig`].
///
/// ```
/// let file = palpate_io::parse_rig("rig.toml", "[palm1]\nzero_mm = 0.3\nzero_sd_um = 20\n")?;
/// assert_eq!(file.rig.calibration.zero_m, [0.3e-3, 0.0]);
/// assert_eq!(file.rig.tolerances.zero_sd_m, [20e-6, 0.5e-3]);
///
/// let error = palpate_io::parse_rig("rig.toml", "[palm1]\nzero_m = 0.3\n").unwrap_err();
/// assert_eq!(error.to_string(), "rig.toml, line 2, key palm1.zero_m: 0.3 m is beyond 0.1 m; did you mean zero_mm?");
/// # Ok::<(), palpate_io::RigError>(())
/// ```
pub fn parse_rig(file: &str, text: &str) -> Result<RigFile, RigError> {
    let document = DeTable::parse(text).map_err(|error| {
        let line = error.span().map(|span| 1 + line_breaks(text, 0..span.start));
        let message = error.message().lines().collect::<Vec<_>>().join(", ");
        RigError::in_line(file, line, RigProblem::Toml { message })
    })?;
    let [palm1, palm2, pads_together, angles, clock] = tables(file, text, document.get_ref())?;

    let (mut calibration, mut tolerances) = (Calibration::default(), Tolerances::default());
    let (mut conventions, mut pads) = (Conventions::default(), [Pad::default(); 2]);
    for (k, palm) in [palm1, palm2].iter().enumerate() {
        set(&mut calibration.zero_m[k], palm.within(ZERO, OFFSET)?);
        set(&mut tolerances.zero_sd_m[k], palm.sd(ZERO_SD)?);
        set(&mut calibration.scale[k], palm.scale(SCALE)?);
        set(&mut tolerances.scale_sd[k], palm.sd(SCALE_SD)?);
        set(&mut calibration.surface_m[k], palm.within(SURFACE, OFFSET)?);
        set(&mut tolerances.surface_sd_m[k], palm.sd(SURFACE_SD)?);
        conventions.palms[k] = palm_conventions(palm)?;
        pads[k] = pad(palm)?;
    }
    tolerances.scale_ratio_sd = pads_together.sd(RATIO_SD)?;
    tolerances.surface_difference_sd_m = pads_together.sd(DIFFERENCE_SD)?;
    for k in 0..2 {
        set(&mut calibration.angle_zero_rad[k], angles.within(ANGLE_ZERO[k], TURN)?);
        set(&mut tolerances.angle_zero_sd_rad[k], angles.sd(ANGLE_ZERO_SD[k])?);
        set(&mut conventions.angle_signs[k], angles.sign(SIGN[k])?);
    }
    set(&mut calibration.clock_offset_s, clock.within(CLOCK, LATE)?);
    set(&mut tolerances.clock_offset_sd_s, clock.sd(CLOCK_SD)?);
    let angle_reading_sd_rad = angles.sd(ANGLE_READING_SD)?;
    Ok(RigFile { rig: Rig::new(calibration, tolerances), conventions, pads, angle_reading_sd_rad })
}

fn set(target: &mut f64, value: Option<f64>) {
    *target = value.unwrap_or(*target);
}

fn palm_conventions(palm: &Table) -> Result<PalmConventions, RigError> {
    palm.positive(LENGTH)?;
    let length_m = palm.within(LENGTH, PAD)?;
    let from_tip = palm.counts_from_tip(DIRECTION, LENGTH)?;
    let direction = match length_m {
        Some(length_m) if from_tip => Direction::ToBase { length_m },
        _ => Direction::FromBase { length_m },
    };
    Ok(PalmConventions { direction, base_m: [palm.within(BASE[0], REACH)?, palm.within(BASE[1], REACH)?] })
}

fn pad(palm: &Table) -> Result<Pad, RigError> {
    let [friction, friction_sd] = palm.friction(FRICTION, FRICTION_SD)?;
    Ok(Pad {
        reading_sd_m: palm.sd(READING_SD)?,
        counts_per_inch: palm.positive(COUNTS_PER_INCH)?,
        levels: palm.levels(LEVELS)?,
        friction,
        friction_sd,
    })
}

/// The tables of a rig file, as [`TABLES`] has them; those that the file does not have are empty.
fn tables<'a>(file: &'a str, text: &'a str, document: &'a DeTable<'a>) -> Result<[Table<'a>; 5], RigError> {
    for Entry { name, line, value, .. } in entries(text, document) {
        let known = TABLES.into_iter().map(|(table, _)| table).find(|table| *table == name);
        let problem = match (known, value) {
            (Some(_), DeValue::Table(_)) => continue,
            (Some(table), _) => RigProblem::NotATable { table },
            (None, DeValue::Table(_)) => RigProblem::UnknownTable { nearest: nearest_table(name) },
            (None, _) => RigProblem::UnknownKey { nearest: nearest_key("", name) },
        };
        return Err(RigError::at_key(file, line, name, problem));
    }
    let table = |index: usize| {
        let (name, keys) = TABLES[index];
        let found = document.get(name).and_then(|value| value.get_ref().as_table());
        Table::new(file, name, keys, found.map(|found| entries(text, found)).unwrap_or_default())
    };
    Ok([table(0)?, table(1)?, table(2)?, table(3)?, table(4)?])
}

/// What a table of the text holds, in the order of the text.
fn entries<'a>(text: &'a str, table: &'a DeTable<'a>) -> Vec<Entry<'a>> {
    let mut found: Vec<_> = table.iter().collect();
    found.sort_by_key(|(name, _)| name.span().start);
    // Counted from one name to the next: a file may hold many.
    let (mut line, mut counted) = (1, 0);
    let entry = |(name, value): (&'a Spanned<Cow<'a, str>>, &'a Spanned<DeValue<'a>>)| {
        let start = name.span().start;
        line += line_breaks(text, counted..start);
        counted = start;
        Entry { name: name.get_ref(), line, value: value.get_ref(), source: text.get(value.span()).unwrap_or_default() }
    };
    found.into_iter().map(entry).collect()
}

fn line_breaks(text: &str, bytes: Range<usize>) -> usize {
    text.as_bytes().get(bytes).unwrap_or_default().iter().filter(|byte| **byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use palpate::sensor::CalibrationConstant;

    use super::*;

    #[test]
    fn the_keys_that_doubts_name_are_those_of_a_rig_file() {
        for CalibrationConstant { name, tolerance, .. } in CalibrationConstant::ALL {
            let (key, section) = tolerance.split_once(" of ").expect("a key of a section");
            let file = |key: &str| parse_rig("rig.toml", &format!("{section}\n{key} = 0.003\n"));
            assert!(file(key).is_ok(), "{name}: {:?}", file(key));
            assert!(file(&key.replace("sd", "tolerance")).is_err(), "{name}: any key is taken");
        }
    }
}
