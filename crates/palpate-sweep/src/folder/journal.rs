//! The journal of a sweep: a line for each finished job, so that a sweep that was killed resumes where it was.
//!
//! The first line says which sweep it is. Every line begins with the digest of the rest of it; a line that was cut off by a kill, or
//! damaged, does not fit its digest, and its job is done again. The file is locked while a sweep is at work.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::digest::Digest;
use crate::job::Outcome;
use crate::sweep_error::SweepError;

/// Name of the journal in the folder of a sweep.
pub const JOURNAL_FILE: &str = "journal.jsonl";

/// An open journal, locked until it goes.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
}

/// Which sweep a journal belongs to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Header {
    /// Version of palpate.
    pub(crate) version: String,
    /// Number of jobs.
    pub(crate) jobs: u64,
    /// Digest of all of them.
    pub(crate) digest: String,
}

impl Journal {
    /// Opens the journal in the folder `dir`, or begins one, for the sweep of this header. Also returns what is finished, in the
    /// order in which it was.
    pub(crate) fn open(dir: &Path, header: &Header) -> Result<(Self, Vec<Outcome>), SweepError> {
        let path = dir.join(JOURNAL_FILE);
        let failed = |error: std::io::Error| SweepError::io(&path, &error);
        let mut file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(SweepError::Busy { dir: dir.display().to_string() }),
            Err(TryLockError::Error(error)) => return Err(failed(error)),
        }
        let mut content = Vec::new();
        file.read_to_end(&mut content).map_err(failed)?;
        // What comes after the last line break was cut off.
        let whole = content.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
        file.set_len(whole as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let mut journal = Self { path, file };
        let mut lines = content[..whole].split(|byte| *byte == b'\n');
        let Some(first) = lines.next().filter(|first| !first.is_empty()) else {
            if whole > 0 {
                return Err(SweepError::NoJournal { path: journal.path.display().to_string() });
            }
            journal.write(header)?;
            return Ok((journal, Vec::new()));
        };
        let found: Header =
            read(first).ok_or_else(|| SweepError::NoJournal { path: journal.path.display().to_string() })?;
        if found.version != header.version {
            return Err(SweepError::OtherVersion { dir: dir.display().to_string(), version: found.version });
        }
        if found != *header {
            return Err(SweepError::OtherPlan { dir: dir.display().to_string(), jobs: found.jobs });
        }
        Ok((journal, lines.filter_map(read).collect()))
    }

    /// Adds a finished job.
    pub(crate) fn add(&mut self, outcome: &Outcome) -> Result<(), SweepError> {
        self.write(outcome)
    }

    /// Whether the folder `dir` has a journal.
    pub(crate) fn is_in(dir: &Path) -> bool {
        dir.join(JOURNAL_FILE).exists()
    }

    fn write(&mut self, entry: &impl Serialize) -> Result<(), SweepError> {
        let json = serde_json::to_string(entry).map_err(|error| SweepError::Encode(error.to_string()))?;
        let line = format!("{} {json}\n", Digest::new().with(json.as_bytes()).hex());
        self.file.write_all(line.as_bytes()).map_err(|error| SweepError::io(&self.path, &error))
    }
}

/// An entry, if the line is whole.
fn read<'line, T: Deserialize<'line>>(line: &'line [u8]) -> Option<T> {
    let (digest, json) = (line.get(..16)?, line.get(17..)?);
    if Digest::new().with(json).hex().as_bytes() != digest {
        return None;
    }
    serde_json::from_slice(json).ok()
}
