//! What can go wrong with a source or a recording: one sentence that names it, the problem and the remedy.

use std::io;
use std::path::Path;

use palpate_io::ReadError;

/// A source that cannot be opened or read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// An address that says no source.
    #[error("{address}: {problem}")]
    Address {
        /// As it was given.
        address: String,
        /// What is wrong with it, and what to write.
        problem: String,
    },
    /// A log whose header cannot be used, or a file of another kind.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The operating system refused.
    #[error("{source_name}: {action}: {message}{}", remedy(*kind))]
    Io {
        /// File or device.
        source_name: String,
        /// What was tried.
        action: &'static str,
        /// Kind of the failure.
        kind: io::ErrorKind,
        /// What the operating system said.
        message: String,
    },
    /// A file of settings (topics, plan) that cannot be used.
    #[error("{file}: {problem}")]
    Settings {
        /// The file.
        file: String,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// A device or file that does not hold what is needed.
    #[error("{source_name}: {problem}")]
    Content {
        /// File or device.
        source_name: String,
        /// What is wrong with it, and what to do.
        problem: String,
    },
}

impl SourceError {
    pub(crate) fn io(source_name: impl Into<String>, action: &'static str, error: &io::Error) -> Self {
        Self::Io { source_name: source_name.into(), action, kind: error.kind(), message: error.to_string() }
    }

    pub(crate) fn content(source_name: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Content { source_name: source_name.into(), problem: problem.into() }
    }

    pub(crate) fn settings(file: &Path, problem: impl Into<String>) -> Self {
        Self::Settings { file: file.display().to_string(), problem: problem.into() }
    }
}

/// What helps against a failure that has a usual cause.
fn remedy(kind: io::ErrorKind) -> &'static str {
    match kind {
        io::ErrorKind::NotFound => "; check the name, and that the device is plugged in",
        io::ErrorKind::PermissionDenied => {
            "; add yourself to the group that owns it (dialout or input, on most systems)"
        }
        _ => "",
    }
}

/// A recording that cannot be begun or continued.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// There is something in that place.
    #[error(
        "{file}: there is such a file already, and a recording does not replace one; give another name or remove it"
    )]
    Exists {
        /// The file.
        file: String,
    },
    /// Neither `.csv` nor `.mcap`.
    #[error("{file}: the name says no format; end it in .csv or .mcap")]
    Format {
        /// The file.
        file: String,
    },
    /// The operating system refused.
    #[error("{file}: {action}: {message}")]
    Io {
        /// The file.
        file: String,
        /// What was tried.
        action: &'static str,
        /// Kind of the failure.
        kind: io::ErrorKind,
        /// What the operating system said.
        message: String,
    },
}

impl RecordError {
    pub(crate) fn io(file: &Path, action: &'static str, error: &io::Error) -> Self {
        Self::Io { file: file.display().to_string(), action, kind: error.kind(), message: error.to_string() }
    }
}
