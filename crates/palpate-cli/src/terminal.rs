//! What the program says, where it says it, and the code it ends with.
//!
//! Results go to standard output; notes, progress and errors go to standard error. Nobody listening is not an error: a closed
//! pipe ends the talking, not the work.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use palpate::reconstruct::{Progress, ReconstructError};
use palpate_io::{ReadError, WriteError, WriteProblem};

/// Work shorter than this needs no progress bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Steps of the progress bar.
const STEPS: u64 = 1000;

/// How a command ended, when it did what it was asked to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All is well; a reconstruction is certified.
    Success,
    /// There is a result, but it is not certified.
    NotCertified,
}

/// Why a command could not do what it was asked to: one message for the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Failure {
    /// The input or the options are at fault.
    Input(String),
    /// Anything else is.
    Other(String),
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        match error.problem {
            WriteProblem::Io { .. } => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<ReconstructError> for Failure {
    fn from(error: ReconstructError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Where a command talks.
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    quiet: bool,
}

impl Terminal {
    /// A quiet terminal says nothing but errors.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Ends the program: the error, if there is one, in one line, and the exit code.
    pub fn end(ending: Result<Ending, Failure>) -> ExitCode {
        let (code, message) = match ending {
            Ok(Ending::Success) => (0, None),
            Ok(Ending::NotCertified) => (3, None),
            Err(Failure::Input(message)) => (2, Some(message)),
            Err(Failure::Other(message)) => (1, Some(message)),
        };
        if let Some(message) = message {
            // Nobody is left to tell if this fails.
            let _ = writeln!(io::stderr(), "error: {message}");
        }
        ExitCode::from(code)
    }

    /// A result, to standard output.
    pub fn say(&self, text: &str) -> Result<(), Failure> {
        if self.quiet { Ok(()) } else { print(text) }
    }

    /// Something that the user may want to know, to standard error.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            let _ = writeln!(io::stderr(), "note: {text}");
        }
    }

    /// Shows how far the work has come, if someone is watching.
    pub fn progress(&self) -> ProgressLine {
        ProgressLine { shown: !self.quiet && io::stderr().is_terminal(), started: Instant::now(), bar: OnceLock::new() }
    }
}

/// Prints to standard output, quiet or not.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Other(format!("standard output cannot be written: {error}")))
        }
        _ => Ok(()),
    }
}

/// A progress bar that appears when the work takes long and goes away with it.
pub struct ProgressLine {
    shown: bool,
    started: Instant,
    bar: OnceLock<ProgressBar>,
}

impl ProgressLine {
    /// Takes in how far the work has come.
    pub fn update(&self, progress: Progress) {
        if !self.shown || self.started.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_init(|| {
            let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::stderr())
                .with_elapsed(self.started.elapsed());
            match ProgressStyle::with_template("{bar:30} {percent:>3} %  {elapsed}  {msg}") {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        });
        bar.set_position((progress.fraction.clamp(0.0, 1.0) * STEPS as f64) as u64);
        bar.set_message(progress.stage);
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
