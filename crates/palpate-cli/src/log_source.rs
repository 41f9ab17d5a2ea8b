//! Logs as they are named on the command line: files, compressed or not, and `-` for standard input.

use std::io;
use std::path::{Path, PathBuf};

use palpate_io::{LogFile, ReadError, RigFile, StrokesFile};
#[cfg(feature = "live")]
use palpate_live::{read_mcap_log, read_mcap_strokes};

use crate::terminal::Failure;

/// What stands for standard input.
const STANDARD_INPUT: &str = "-";
/// How the names of MCAP files end.
const MCAP: &str = ".mcap";
/// What messages call it.
const STANDARD_INPUT_NAME: &str = "standard input";

/// A log that is named on the command line.
#[derive(Clone, Copy, Debug)]
pub struct LogSource<'a>(pub &'a Path);

impl LogSource<'_> {
    /// Whether it is standard input.
    pub fn is_standard_input(self) -> bool {
        self.0 == Path::new(STANDARD_INPUT)
    }

    /// What messages and reports call it: its path, or in words.
    fn told(self) -> String {
        if self.is_standard_input() { STANDARD_INPUT_NAME.to_owned() } else { self.0.to_string_lossy().into_owned() }
    }

    /// Its file name.
    pub fn file_name(self) -> String {
        match self.0.file_name() {
            Some(name) if !self.is_standard_input() => name.to_string_lossy().into_owned(),
            _ => self.told(),
        }
    }

    /// What a folder with its results is called: its file name without `.csv` and `.gz`, or without `.mcap`.
    pub fn stem(self) -> String {
        let name = self.file_name();
        let plain = without_end(&name, ".gz");
        without_end(without_end(plain, ".csv"), MCAP).to_owned()
    }

    /// Whether it is an MCAP file: by its name, or because a map of its topics is given.
    fn is_mcap(self, map: Option<&Path>) -> bool {
        map.is_some() || self.0.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(&MCAP[1..]))
    }

    /// Whether it is a file that holds a log of strokes of a pivoting grasp, and none of palms. What cannot be read is neither. `map` names the topics of
    /// an MCAP file.
    pub fn is_strokes(self, map: Option<&Path>) -> bool {
        if self.is_mcap(map) {
            return is_mcap_of_strokes(self.0, map);
        }
        !self.is_standard_input() && self.bytes().is_ok_and(|bytes| palpate_io::is_strokes_log(&bytes))
    }

    /// A log of strokes.
    pub fn read_strokes(self, map: Option<&Path>) -> Result<StrokesFile, Failure> {
        if self.is_mcap(map) { Ok(read_mcap_strokes(self.0, map)?) } else { Ok(palpate_io::read_strokes(self.0)?) }
    }

    /// Whether it is a palm log: standard input, a recording, or a file with the columns of one. What cannot be read is none.
    pub fn is_of_palms(self) -> bool {
        self.is_standard_input()
            || self.is_mcap(None)
            || self.0.is_file() && self.bytes().is_ok_and(|bytes| palpate_io::is_palm_log(&bytes))
    }

    /// The folder for its result where none is given: its name with `.palpate` in place of `.csv`.
    pub fn result_dir(self) -> PathBuf {
        self.0.with_file_name(format!("{}.palpate", self.stem()))
    }

    /// The log, and what is known of its rig: the file given, or that readings are exact, or what the log says of itself, or the default
    /// tolerances. `map` names the topics of an MCAP file.
    pub fn read(self, rig: Option<&Path>, calibrated: bool, map: Option<&Path>) -> Result<(LogFile, RigFile), Failure> {
        if self.is_mcap(map) {
            let exact = || calibrated.then(RigFile::exact);
            let given = rig.map(palpate_io::read_rig).transpose()?.or_else(exact);
            let conventions = given.as_ref().map(|rig| rig.conventions);
            let (file, said) = read_mcap_log(self.0, map, conventions)?;
            return Ok((file, given.or(said).unwrap_or_default()));
        }
        if let Some(path) = rig {
            let rig = palpate_io::read_rig(path)?;
            return Ok((palpate_io::parse_log_as(&self.told(), &self.bytes()?, &rig.conventions)?, rig));
        }
        if calibrated {
            return Ok((palpate_io::parse_log(&self.told(), &self.bytes()?)?, RigFile::exact()));
        }
        let (file, said) = palpate_io::parse_log_with_rig(&self.told(), &self.bytes()?)?;
        Ok((file, said.unwrap_or_default()))
    }

    fn bytes(self) -> Result<Vec<u8>, ReadError> {
        if self.is_standard_input() {
            palpate_io::bytes_from(STANDARD_INPUT_NAME, io::stdin().lock())
        } else {
            palpate_io::read_bytes(self.0)
        }
    }
}

#[cfg(feature = "live")]
fn is_mcap_of_strokes(path: &Path, map: Option<&Path>) -> bool {
    palpate_live::mcap_rig_kind(path, map) == palpate_live::RigKind::Pivot
}

#[cfg(not(feature = "live"))]
fn is_mcap_of_strokes(_: &Path, _: Option<&Path>) -> bool {
    false
}

#[cfg(not(feature = "live"))]
fn read_mcap_strokes(_: &Path, _: Option<&Path>) -> Result<StrokesFile, Failure> {
    Err(crate::absent::failure("MCAP files"))
}

#[cfg(not(feature = "live"))]
fn read_mcap_log(
    _: &Path,
    _: Option<&Path>,
    _: Option<palpate_io::Conventions>,
) -> Result<(LogFile, Option<RigFile>), Failure> {
    Err(crate::absent::failure("MCAP files"))
}

/// A name without this end, in upper or lower case, unless nothing else is left.
fn without_end<'a>(name: &'a str, end: &str) -> &'a str {
    match name.len().checked_sub(end.len()).and_then(|place| name.split_at_checked(place)) {
        Some((start, found)) if !start.is_empty() && found.eq_ignore_ascii_case(end) => start,
        _ => name,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_result_is_called_like_its_log() {
        let named = |path: &str| LogSource(Path::new(path)).result_dir().display().to_string();
        assert_eq!(named("day/a.csv"), "day/a.palpate");
        assert_eq!(named("day/a.CSV.gz"), "day/a.palpate");
        assert_eq!(named("a.txt"), "a.txt.palpate");
        assert_eq!(named("a.b.csv"), "a.b.palpate");
        assert_eq!(named(".csv"), ".csv.palpate");
        assert_eq!(LogSource(Path::new("-")).file_name(), "standard input");
    }
}
