//! What can be wrong with a plan: where, what, and what to do, in one message.

use std::fmt;

/// A plan that cannot be used. Shown as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanError {
    /// File name as given.
    pub file: String,
    /// Line in the file, from 1, where the problem has one.
    pub line: Option<usize>,
    /// Key in the file, such as `touchpads[0].noise_sd_m`, where the problem has one.
    pub key: Option<String>,
    /// What is wrong.
    pub problem: PlanProblem,
}

/// What is wrong with a plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PlanProblem {
    /// The file cannot be read.
    #[error("the plan cannot be read: {0}")]
    Unreadable(String),
    /// More than a plan can reasonably be.
    #[error("the file is larger than {0} KiB: that is not a plan")]
    TooLarge(u64),
    /// No TOML, or a key or value that a plan does not have.
    #[error("{0}")]
    Text(String),
    /// Nothing to simulate.
    #[error("there is no object; add one, such as objects.named = {{ name = \"egg\" }}")]
    NoObjects,
    /// Nothing to feel it with.
    #[error("there is no touchpad; add one, such as touchpads = [{{ noise_sd_m = 0.1e-3 }}]")]
    NoTouchpads,
    /// A pattern that is none.
    #[error("\"{pattern}\" is not a pattern for file names: {reason}")]
    Pattern {
        /// The pattern.
        pattern: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A pattern without a file.
    #[error("no log is named \"{0}\"; paths are relative to the folder of the plan")]
    NoMatch(String),
    /// A file whose name is no text.
    #[error("the name of the log {0} is not UTF-8; rename it")]
    Name(String),
    /// A rig that cannot be read.
    #[error("{0}")]
    Rig(String),
    /// An outline that cannot be read, or that is none.
    #[error("{0}")]
    Outline(String),
    /// A file of one touchpad with a list in it.
    #[error("there is a list of values where a touchpad has one; give one value for each key")]
    SeveralTouchpads,
    /// More jobs than one table should have.
    #[error("more than {0} jobs; split the plan into several")]
    TooManyJobs(u64),
}

impl std::error::Error for PlanError {}

impl fmt::Display for PlanError {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(formatter, ", line {line}")?;
        }
        if let Some(key) = &self.key {
            write!(formatter, ", {key}")?;
        }
        write!(formatter, ": {}", self.problem)
    }
}
