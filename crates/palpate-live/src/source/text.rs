//! CSV lines from a program, on standard input.

use std::collections::VecDeque;
use std::io::{self, Read};

use palpate::Sample;

use crate::error::SourceError;
use crate::lines::{Line, Lines};
use crate::losses::Losses;
use crate::rigs::RigSample;
use crate::source::{Arrival, Overflow, Source};

/// Longest line, bytes: thirteen columns take 350.
pub(crate) const LONGEST_LINE: usize = 4096;
/// Bytes read at a time.
const READ_BYTES: usize = 64 * 1024;

/// A log line by line: comments, a header, samples.
#[derive(Clone, Debug)]
pub(crate) struct CsvDecoder<S: RigSample = Sample> {
    name: String,
    /// Those that were stated; else the file may state them.
    conventions: Option<S::Conventions>,
    rig: Option<S::Rig>,
    lines: Lines,
    line_number: usize,
    rows: Option<S::Rows>,
    losses: Losses,
    first_fault: Option<String>,
}

impl<S: RigSample> CsvDecoder<S> {
    pub(crate) fn new(name: &str, conventions: Option<S::Conventions>) -> Self {
        Self {
            name: name.to_owned(),
            conventions,
            rig: None,
            lines: Lines::new(LONGEST_LINE),
            line_number: 0,
            rows: None,
            losses: Losses::default(),
            first_fault: None,
        }
    }

    /// Takes bytes in and appends the samples in them. A line that is none is counted.
    ///
    /// # Errors
    /// The header cannot be used.
    pub(crate) fn push(&mut self, bytes: &[u8], samples: &mut VecDeque<S>) -> Result<(), SourceError> {
        let mut lines = std::mem::replace(&mut self.lines, Lines::new(0));
        let mut ended = Ok(());
        lines.push(bytes, |line| {
            if ended.is_ok() {
                ended = self.take(line, samples);
            }
        });
        self.lines = lines;
        ended
    }

    /// Takes in that nothing more comes: the last line may have no line break.
    pub(crate) fn finish(&mut self, samples: &mut VecDeque<S>) -> Result<(), SourceError> {
        let mut lines = std::mem::replace(&mut self.lines, Lines::new(0));
        let mut ended = Ok(());
        lines.finish(|line| ended = self.take(line, samples));
        ended?;
        if self.rows.is_none() {
            return Err(SourceError::content(&self.name, "there is no header line with the names of the columns"));
        }
        Ok(())
    }

    /// The file begins anew: there is another header.
    pub(crate) fn restart(&mut self) {
        self.lines.clear();
        self.line_number = 0;
        self.rows = None;
        self.losses.gaps += 1;
    }

    fn take(&mut self, line: Line, samples: &mut VecDeque<S>) -> Result<(), SourceError> {
        self.line_number += 1;
        let Line::Whole(bytes) = line else {
            self.losses.too_long += 1;
            let fault = || format!("{}, line {}: it is longer than {LONGEST_LINE} bytes", self.name, self.line_number);
            self.first_fault.get_or_insert_with(fault);
            return Ok(());
        };
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = String::from_utf8_lossy(bytes);
        let Some(rows) = &self.rows else {
            if text.trim_start().starts_with('#') {
                S::take_comment(&self.name, &text, self.conventions.is_some(), &mut self.rig)?;
            } else if !text.trim().is_empty() {
                let of_rig = self.rig.as_ref().map(S::conventions);
                let conventions = self.conventions.or(of_rig).unwrap_or_default();
                self.rows = Some(S::rows(&self.name, &text, self.line_number, conventions)?);
            }
            return Ok(());
        };
        match S::row(rows, &text, self.line_number) {
            Ok(sample) => samples.extend(sample),
            Err(error) => {
                self.losses.faulty += 1;
                self.first_fault.get_or_insert_with(|| error.to_string());
            }
        }
        Ok(())
    }

    pub(crate) fn losses(&self) -> Losses {
        self.losses
    }

    /// What the lines above the header say of the rig.
    pub(crate) fn rig(&self) -> Option<S::Rig> {
        self.rig
    }

    pub(crate) fn first_fault(&self) -> Option<String> {
        self.first_fault.clone()
    }
}

/// Lines from a pipe, to its end.
pub(crate) struct Text<R, S: RigSample = Sample> {
    input: R,
    decoder: CsvDecoder<S>,
    samples: VecDeque<S>,
    buffer: Vec<u8>,
    ended: bool,
}

impl<R: Read + Send, S: RigSample> Text<R, S> {
    pub(crate) fn new(name: &str, input: R, conventions: Option<S::Conventions>) -> Self {
        let decoder = CsvDecoder::new(name, conventions);
        Self { input, decoder, samples: VecDeque::new(), buffer: vec![0; READ_BYTES], ended: false }
    }
}

impl<R: Read + Send, S: RigSample> Source<S> for Text<R, S> {
    fn next(&mut self) -> Result<Arrival<S>, SourceError> {
        loop {
            if let Some(sample) = self.samples.pop_front() {
                return Ok(Arrival::Sample(sample));
            }
            if self.ended {
                return Ok(Arrival::End);
            }
            match self.input.read(&mut self.buffer) {
                Ok(0) => {
                    self.ended = true;
                    self.decoder.finish(&mut self.samples)?;
                }
                Ok(count) => {
                    self.decoder.push(&self.buffer[..count], &mut self.samples)?;
                    if self.samples.is_empty() {
                        return Ok(Arrival::Nothing);
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(SourceError::io(&self.decoder.name, "it cannot be read", &error)),
            }
        }
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

    fn read(text: &[u8]) -> (Result<Vec<f64>, SourceError>, Losses, Option<String>) {
        let mut source = Text::<_, Sample>::new("stdin", text, None);
        let mut times = Vec::new();
        let ended = loop {
            match source.next() {
                Ok(Arrival::Sample(sample)) => times.push(sample.time_s),
                Ok(Arrival::Nothing) => {}
                Ok(Arrival::End) => break Ok(times),
                Err(error) => break Err(error),
            }
        };
        (ended, source.losses(), source.first_fault())
    }

    #[test]
    fn lines_become_samples_and_faulty_ones_are_counted() {
        let long = "9".repeat(LONGEST_LINE + 1);
        let text = format!(
            "# robot: left\ntime_s,phi1_deg,phi2_deg,s1_mm,s2_mm\n1,60,74,29,\n2,60,74,x,31\n{long}\n\n3,60,74,29,31"
        );
        let (times, losses, fault) = read(text.as_bytes());
        assert_eq!(times, Ok(vec![1.0, 3.0]));
        assert_eq!(losses, Losses { faulty: 1, too_long: 1, ..Losses::default() });
        let fault = fault.expect("a fault");
        assert!(fault.starts_with("stdin, line 4, column s1_mm: "), "{fault}");
    }

    #[test]
    fn a_header_that_cannot_be_used_ends_it() {
        for text in ["1,2,3,4,5\n", "time_s,phi1_rad\n", "", "# only a comment\n", "\u{0}\n"] {
            assert!(read(text.as_bytes()).0.is_err(), "{text:?}");
        }
    }
}
