//! A board on a serial port that speaks the line protocol.

use std::collections::VecDeque;
use std::io::{self, Read};
use std::time::{Duration, Instant};

use palpate::Sample;
use serialport::SerialPort;

use crate::error::SourceError;
use crate::line_protocol::decoder::Decoder;
use crate::losses::Losses;
use crate::rigs::RigSample;
use crate::source::{Arrival, Overflow, Source};

/// Longest wait for a byte before the caller hears of it.
const PATIENCE: Duration = Duration::from_millis(100);
/// Pause before a port that is gone is tried again.
const PAUSE: Duration = Duration::from_millis(100);
/// Bytes read at a time.
const READ_BYTES: usize = 4096;

/// A serial port. One that is gone is opened again when it is back.
pub(crate) struct Serial<S: RigSample = Sample> {
    path: String,
    baud: u32,
    port: Option<Box<dyn SerialPort>>,
    opened: Instant,
    decoder: Decoder<S>,
    decoded: Vec<S>,
    samples: VecDeque<S>,
}

impl<S: RigSample> Serial<S> {
    pub(crate) fn open(path: &str, baud: u32, conventions: S::Conventions) -> Result<Self, SourceError> {
        let port = open(path, baud).map_err(|error| SourceError::io(path, "the port cannot be opened", &error))?;
        Ok(Self {
            path: path.to_owned(),
            baud,
            port: Some(port),
            opened: Instant::now(),
            decoder: Decoder::new(conventions),
            decoded: Vec::new(),
            samples: VecDeque::new(),
        })
    }

    /// Reads once; nothing where nothing came in time.
    fn read(&mut self, buffer: &mut [u8]) -> usize {
        let Some(port) = &mut self.port else {
            std::thread::sleep(PAUSE);
            self.port = open(&self.path, self.baud).ok();
            return 0;
        };
        match port.read(buffer) {
            Ok(count) if count > 0 => count,
            Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::Interrupted) => 0,
            // A port at its end has been unplugged.
            Ok(_) | Err(_) => {
                self.port = None;
                self.decoder.interrupted();
                0
            }
        }
    }
}

fn open(path: &str, baud: u32) -> io::Result<Box<dyn SerialPort>> {
    Ok(serialport::new(path, baud).timeout(PATIENCE).open()?)
}

impl<S: RigSample> Source<S> for Serial<S> {
    fn next(&mut self) -> Result<Arrival<S>, SourceError> {
        if self.samples.is_empty() {
            let mut buffer = [0; READ_BYTES];
            let count = self.read(&mut buffer);
            let host_s = self.opened.elapsed().as_secs_f64();
            self.decoder.push(&buffer[..count], host_s, &mut self.decoded);
            self.samples.extend(self.decoded.drain(..));
        }
        Ok(self.samples.pop_front().map_or(Arrival::Nothing, Arrival::Sample))
    }

    fn losses(&self) -> Losses {
        self.decoder.losses()
    }

    fn overflow(&self) -> Overflow {
        Overflow::DropsOldest
    }
}
