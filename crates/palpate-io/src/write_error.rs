//! What can go wrong when something is written.

use std::io;
use std::path::Path;

use crate::csv::text;
use crate::read_error::io_message;

/// Something that cannot be written: where, why, and what to do. Shown as one paragraph.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{path}: {problem}")]
pub struct WriteError {
    /// The file or folder as given, control characters escaped.
    pub path: String,
    /// What is wrong, and what to do.
    pub problem: WriteProblem,
}

/// Why something cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteProblem {
    /// The operating system refused.
    #[error("cannot be written: {message}")]
    Io {
        /// Kind of the failure.
        kind: io::ErrorKind,
        /// What the operating system said.
        message: String,
    },
    /// A folder where a file is to be written.
    #[error("a folder of that name exists; choose another name for the file")]
    IsFolder,
    /// A file where a folder is to be written.
    #[error("a file of that name exists; choose another name for the folder")]
    IsFile,
    /// A folder that holds other things than what is to be replaced.
    #[error(
        "the folder holds {found}, which is not part of an earlier {kind} and would be lost; choose another folder, or a new one inside it"
    )]
    Foreign {
        /// What is to be written: "result" or "truth".
        kind: &'static str,
        /// The file that must not be lost.
        found: String,
    },
    /// The current folder, which cannot be replaced under the feet of the shell.
    #[error("this is the current folder; choose a folder of its own for the {kind}")]
    CurrentFolder {
        /// What is to be written: "result" or "truth".
        kind: &'static str,
    },
    /// A path that ends in no name.
    #[error("this is not a folder name; choose one such as out/")]
    NoName,
    /// Metadata that would not read back.
    #[error(
        "the metadata \"{key}: {value}\" cannot be written; a key begins with a letter and continues with letters, digits, spaces, _ - and ., and a value is one line"
    )]
    Metadata {
        /// The key.
        key: String,
        /// The value.
        value: String,
    },
}

impl WriteError {
    pub(crate) fn new(path: &Path, problem: WriteProblem) -> Self {
        Self { path: text::file_name(&path.to_string_lossy()), problem }
    }

    pub(crate) fn io(path: &Path, error: &io::Error) -> Self {
        Self::new(path, WriteProblem::Io { kind: error.kind(), message: io_message(error) })
    }
}
