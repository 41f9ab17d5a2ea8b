//! Palm logs: from a file and into one.

pub(crate) mod log_reader;
pub(crate) mod log_writer;
pub(crate) mod plausible;
