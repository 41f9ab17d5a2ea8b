//! What can go wrong with the folder of a sweep, in one message.

use palpate_io::WriteError;

/// Why a sweep cannot be run in a folder, or not to its end. What was finished is kept.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// Another sweep was begun there.
    #[error(
        "{dir}: the folder holds another sweep of {jobs} jobs: the plan, or a log that it names, has changed since; choose another folder, or delete this one to start again"
    )]
    OtherPlan {
        /// The folder.
        dir: String,
        /// Jobs of the sweep in it.
        jobs: u64,
    },
    /// Another version of palpate was at work there; its results may differ.
    #[error(
        "{dir}: the sweep in this folder was started by palpate {version}; finish it with that version, or choose another folder"
    )]
    OtherVersion {
        /// The folder.
        dir: String,
        /// That version.
        version: String,
    },
    /// A journal whose first line is damaged.
    #[error(
        "{path}: this is not the journal of a sweep, or its first line is damaged; choose another folder, or delete the file to start again"
    )]
    NoJournal {
        /// The file.
        path: String,
    },
    /// A table that no sweep of ours made.
    #[error("{path}: a file of that name exists, but no sweep that it could be a result of; choose another folder")]
    Foreign {
        /// The file.
        path: String,
    },
    /// A second sweep in the same folder at the same time.
    #[error("{dir}: another palpate process is using this folder; wait for it, or choose another folder")]
    Busy {
        /// The folder.
        dir: String,
    },
    /// A log that is another one on the machine that is to reconstruct it.
    #[error(
        "{log}: a machine of the cluster does not see this log as it was when the sweep was planned; every machine must see the folder {base} with the same logs in it"
    )]
    OtherLog {
        /// Path of the log from the folder of the plan.
        log: String,
        /// The folder of the plan.
        base: String,
    },
    /// Tables were asked for too early.
    #[error("{dir}: {missing} jobs of the sweep in this folder are not finished; resume it first")]
    Unfinished {
        /// The folder.
        dir: String,
        /// So many are not.
        missing: u64,
    },
    /// The operating system refused.
    #[error("{path}: {message}")]
    Io {
        /// The file or folder.
        path: String,
        /// What the operating system said.
        message: String,
    },
    /// Threads could not be had.
    #[error("threads cannot be started: {0}")]
    Threads(String),
    /// A result could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The rows could not be put into a table or a journal.
    #[error("the results cannot be encoded: {0}")]
    Encode(String),
}

#[cfg(feature = "parquet")]
impl SweepError {
    pub(crate) fn io(path: &std::path::Path, error: &std::io::Error) -> Self {
        Self::Io { path: path.display().to_string(), message: error.to_string() }
    }
}
