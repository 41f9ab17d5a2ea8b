//! What all MCAP files have in common that are written as samples come: times, options, errors.

use std::io;
use std::time::{SystemTime, UNIX_EPOCH};

use mcap::{McapError, WriteOptions};

/// Times of messages: those of the samples, from the moment at which the file was begun.
pub(crate) struct Clock {
    /// Nanoseconds since 1970.
    begun_ns: u64,
    /// Time of the first sample, seconds.
    first_s: Option<f64>,
}

impl Clock {
    /// Of a file that is begun now.
    pub(crate) fn new() -> Self {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { begun_ns: u64::try_from(since_1970.as_nanos()).unwrap_or(0), first_s: None }
    }

    /// Seconds since the first sample.
    pub(crate) fn since_first_s(&mut self, time_s: f64) -> f64 {
        time_s - *self.first_s.get_or_insert(time_s)
    }

    /// Nanoseconds since 1970.
    pub(crate) fn ns(&mut self, time_s: f64) -> u64 {
        // Saturates.
        self.begun_ns.saturating_add((1e9 * self.since_first_s(time_s)) as u64)
    }
}

/// Chunks that anybody can read, and that need no end of the file.
pub(crate) fn options() -> WriteOptions {
    WriteOptions::new().compression(None).disable_seeking(true).library(concat!("palpate ", env!("CARGO_PKG_VERSION")))
}

pub(crate) fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}
