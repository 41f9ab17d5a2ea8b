//! A recording in CSV.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

use super::{LogFileWriter, SampleWriter};
use crate::rigs::RigSample;

/// Whole lines, written by one call each time.
pub(super) struct CsvWriter {
    file: File,
    /// Lines that are not written yet.
    lines: String,
    /// Bytes of the file that are whole lines.
    whole: u64,
}

impl CsvWriter {
    pub(super) fn create<S: RigSample>(path: &Path, metadata: &[(String, String)]) -> io::Result<Self> {
        let mut writer = Self { file: super::create(path)?, lines: S::csv_header(metadata), whole: 0 };
        writer.hand_over().inspect_err(|_| writer.undo())?;
        Ok(writer)
    }
}

impl<S: RigSample> SampleWriter<S> for CsvWriter {
    fn push(&mut self, sample: &S) -> io::Result<usize> {
        let before = self.lines.len();
        sample.push_csv_row(&mut self.lines);
        Ok(self.lines.len() - before)
    }
}

impl LogFileWriter for CsvWriter {
    fn hand_over(&mut self) -> io::Result<u64> {
        self.file.write_all(self.lines.as_bytes())?;
        self.whole += self.lines.len() as u64;
        self.lines.clear();
        Ok(self.whole)
    }

    fn bring_to_disk(&mut self) -> io::Result<()> {
        // A device or a pipe has no disk.
        if self.file.metadata()?.is_file() { self.file.sync_data() } else { Ok(()) }
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn undo(&mut self) {
        // The reader does without a last line that is not whole, if this fails too.
        let _ = self.file.set_len(self.whole);
    }
}
