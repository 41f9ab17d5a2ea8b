//! What can be wrong with a rig file: where, what, and what to do, in one message.

use std::io;

use crate::csv::text;
use crate::read_error::io_message;

/// A rig file that cannot be used: its name, the place in it, and the problem. Shown as one paragraph.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {problem}", place(file, *line, key.as_deref()))]
pub struct RigError {
    /// File name as given, control characters escaped.
    pub file: String,
    /// Line in the file, from 1, where the problem has one.
    pub line: Option<usize>,
    /// Key with its table, such as `palm1.zero_m`, control characters escaped and cut after 40, where the problem has one.
    pub key: Option<String>,
    /// What is wrong, and what to do.
    pub problem: Box<RigProblem>,
}

/// What is wrong with a rig file. Values are shown as the file has them, with their unit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigProblem {
    /// No file of that name.
    #[error("no such file; check the path")]
    Missing,
    /// A folder where a file is expected.
    #[error("this is a folder; give the rig file in it")]
    IsFolder,
    /// The operating system refused.
    #[error("cannot be read: {message}")]
    Io {
        /// Kind of the failure.
        kind: io::ErrorKind,
        /// What the operating system said.
        message: String,
    },
    /// More than a rig file can reasonably be.
    #[error("the file is larger than {limit_kib} KiB, that is no rig file; check the path")]
    TooLarge {
        /// Largest file that is read, KiB.
        limit_kib: u64,
    },
    /// Text in another encoding, or no text.
    #[error("the file is not text in UTF-8; save it as TOML in UTF-8")]
    NotUtf8,
    /// No TOML.
    #[error("{message}; correct the line: it should be such as [palm1], or zero_mm = 0.3, or # a comment")]
    Toml {
        /// What the parser said.
        message: String,
    },
    /// A table that a rig file does not have.
    #[error("a rig file has no such table; did you mean [{nearest}]?")]
    UnknownTable {
        /// The nearest table that it has.
        nearest: &'static str,
    },
    /// A value where a table should be.
    #[error("this is a table; write [{table}] in a line and its keys below")]
    NotATable {
        /// Its name.
        table: &'static str,
    },
    /// A key that a rig file does not have.
    #[error("a rig file has no such key; did you mean {nearest}?")]
    UnknownKey {
        /// The nearest key that it has, with its table.
        nearest: String,
    },
    /// A key without a unit.
    #[error("the key has no unit; name it {names}")]
    NoUnit {
        /// The names that would do.
        names: String,
    },
    /// A key in a unit that is not understood.
    #[error("the unit \"{unit}\" is unknown; convert the value and name the key {names}")]
    UnknownUnit {
        /// The unit in the name.
        unit: String,
        /// The names that would do.
        names: String,
    },
    /// A quantity in two units.
    #[error("line {first_line} gives the same as {first}; remove one of the two")]
    Twice {
        /// The key that gives it first.
        first: String,
        /// Its line.
        first_line: usize,
    },
    /// Something else where a number belongs.
    #[error("{text} is not a number; write one such as 0.5, without quotes and without a unit")]
    NotANumber {
        /// The value.
        text: String,
    },
    /// Infinity, or not-a-number.
    #[error("{text} is not finite; write a number, or leave the key out if it is not known")]
    NotFinite {
        /// The value.
        text: String,
    },
    /// A constant larger than any rig has.
    #[error("{text} is beyond {limit}; {}", or_smaller(smaller.as_deref()))]
    Beyond {
        /// The value.
        text: String,
        /// The largest that is taken, with its unit.
        limit: &'static str,
        /// The name in the unit it was likely meant in, where it is in SI units.
        smaller: Option<String>,
    },
    /// A standard deviation below 0.
    #[error(
        "{text} is negative; a standard deviation is 0 (exact) or more: correct it, or leave the key out if it is not known"
    )]
    NegativeSd {
        /// The value.
        text: String,
    },
    /// A scale that no pad has.
    #[error(
        "{text} is not within 0.5 to 2; the scale is the reading over the position, 1 for a pad without error: correct it"
    )]
    Scale {
        /// The value.
        text: String,
    },
    /// Something that must be positive.
    #[error("{text} is not above 0; correct it, or leave the key out if it is not known")]
    NotPositive {
        /// The value.
        text: String,
    },
    /// A coefficient of friction below 0.
    #[error(
        "{text} is negative; a coefficient of friction is 0 or more: correct it, or leave the key out to have it estimated"
    )]
    NegativeFriction {
        /// The value.
        text: String,
    },
    /// A number of pressure levels that is none.
    #[error(
        "{text} is no number of pressure levels; write a whole number from 2 on, or leave the key out if it is not known"
    )]
    Levels {
        /// The value.
        text: String,
    },
    /// A sign that is none.
    #[error("{text} is no sign; write 1, or -1 if the encoder counts clockwise")]
    Sign {
        /// The value.
        text: String,
    },
    /// A direction that is none.
    #[error("{text} is no direction; write \"from_base\" or \"to_base\", with the quotes")]
    Direction {
        /// The value.
        text: String,
    },
    /// A pad that counts from the tip, of unknown length.
    #[error(
        "a pad that counts from the tip can only be turned round if its length is known; add {length}, or write \"from_base\""
    )]
    LengthNeeded {
        /// The missing key, with its table.
        length: String,
    },
    /// A standard deviation of nothing.
    #[error("there is no coefficient of friction that this could belong to; add {friction}, or remove this line")]
    FrictionNeeded {
        /// The missing key, with its table.
        friction: String,
    },
}

impl RigError {
    /// A problem with the file as a whole.
    pub(crate) fn in_file(file: &str, problem: RigProblem) -> Self {
        Self { file: text::file_name(file), line: None, key: None, problem: Box::new(problem) }
    }

    /// A problem in one line.
    pub(crate) fn in_line(file: &str, line: Option<usize>, problem: RigProblem) -> Self {
        Self { line, ..Self::in_file(file, problem) }
    }

    /// A problem with one key.
    pub(crate) fn at_key(file: &str, line: usize, key: &str, problem: RigProblem) -> Self {
        Self { key: Some(text::quoted(key)), ..Self::in_line(file, Some(line), problem) }
    }

    /// What the operating system said about opening or reading the file.
    pub(crate) fn io(file: &str, error: &io::Error) -> Self {
        let problem = match error.kind() {
            io::ErrorKind::NotFound => RigProblem::Missing,
            io::ErrorKind::IsADirectory => RigProblem::IsFolder,
            io::ErrorKind::InvalidData => RigProblem::NotUtf8,
            kind => RigProblem::Io { kind, message: io_message(error) },
        };
        Self::in_file(file, problem)
    }
}

fn place(file: &str, line: Option<usize>, key: Option<&str>) -> String {
    let line = line.map_or(String::new(), |line| format!(", line {line}"));
    let key = key.map_or(String::new(), |key| format!(", key {key}"));
    format!("{file}{line}{key}")
}

fn or_smaller(smaller: Option<&str>) -> String {
    smaller.map_or("correct it".to_string(), |name| format!("did you mean {name}?"))
}
