//! Palm logs: from a file and into one, as a whole and line by line.

pub(crate) mod log_reader;
pub(crate) mod log_writer;
pub(crate) mod palm_course;
pub(crate) mod plausible;
pub(crate) mod row_reader;
