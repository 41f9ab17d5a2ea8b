//! A CSV file that is read as it grows.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;
use std::time::Duration;

use palpate::Sample;

use crate::error::SourceError;
use crate::losses::Losses;
use crate::rigs::RigSample;
use crate::source::text::CsvDecoder;
use crate::source::{Arrival, Overflow, Source};

/// Pause before a file that has not grown is looked at again.
const PAUSE: Duration = Duration::from_millis(20);
/// Bytes read at a time.
const READ_BYTES: usize = 64 * 1024;

/// A growing file. One that becomes shorter has begun anew.
pub(crate) struct Follow<S: RigSample = Sample> {
    name: String,
    file: File,
    decoder: CsvDecoder<S>,
    samples: VecDeque<S>,
    buffer: Vec<u8>,
}

impl<S: RigSample> Follow<S> {
    pub(crate) fn open(path: &Path, conventions: Option<S::Conventions>) -> Result<Self, SourceError> {
        let name = path.display().to_string();
        let failed = |error| SourceError::io(&name, "it cannot be opened", &error);
        let file = File::open(path).map_err(failed)?;
        if file.metadata().map_err(failed)?.is_dir() {
            return Err(SourceError::content(name, "this is a folder; give the file in it that grows"));
        }
        let decoder = CsvDecoder::new(&name, conventions);
        Ok(Self { name, file, decoder, samples: VecDeque::new(), buffer: vec![0; READ_BYTES] })
    }

    fn read(&mut self) -> std::io::Result<usize> {
        let position = self.file.stream_position()?;
        if self.file.metadata()?.len() < position {
            self.file.rewind()?;
            self.decoder.restart();
        }
        self.file.read(&mut self.buffer)
    }
}

impl<S: RigSample> Source<S> for Follow<S> {
    fn next(&mut self) -> Result<Arrival<S>, SourceError> {
        if self.samples.is_empty() {
            let count = self.read().map_err(|error| SourceError::io(&self.name, "it cannot be read", &error))?;
            if count == 0 {
                std::thread::sleep(PAUSE);
            }
            self.decoder.push(&self.buffer[..count], &mut self.samples)?;
        }
        Ok(self.samples.pop_front().map_or(Arrival::Nothing, Arrival::Sample))
    }

    fn losses(&self) -> Losses {
        self.decoder.losses()
    }

    fn first_fault(&self) -> Option<String> {
        self.decoder.first_fault()
    }

    fn rig(&self) -> Option<S::Rig> {
        self.decoder.rig()
    }

    fn overflow(&self) -> Overflow {
        Overflow::Waits
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    /// Times of the samples in the file so far.
    fn times(source: &mut Follow) -> Vec<f64> {
        let mut times = Vec::new();
        while let Arrival::Sample(sample) = source.next().expect("a file that can be read") {
            times.push(sample.time_s);
        }
        times
    }

    #[test]
    fn a_file_is_followed_as_it_grows_and_when_it_begins_anew() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("log.csv");
        let mut file = File::create(&path).expect("a file");
        let mut source = Follow::<Sample>::open(&path, None).expect("the file");
        let mut write = |text: &str| file.write_all(text.as_bytes()).expect("a line");
        assert!(times(&mut source).is_empty());
        write("time_s,phi1_deg,phi2_deg,s1_mm,s2_mm\n1,60,74,29,31\n2,60,");
        assert_eq!(times(&mut source), [1.0]);
        write("74,29,31\n3,60,74,29,31\n");
        assert_eq!(times(&mut source), [2.0, 3.0]);
        std::fs::write(&path, "time_ms,phi1_deg,phi2_deg,s1_mm,s2_mm\n4000,60,74,29,31\n").expect("another file");
        assert_eq!(times(&mut source), [4.0]);
        assert_eq!(source.losses(), Losses { gaps: 1, ..Losses::default() });
    }

    #[test]
    fn what_is_no_file_is_refused() {
        let dir = tempfile::tempdir().expect("a folder");
        for path in [dir.path(), &dir.path().join("missing.csv")] {
            assert!(Follow::<Sample>::open(path, None).is_err());
        }
    }
}
