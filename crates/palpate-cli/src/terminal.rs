//! What the program says, where it says it, and the code it ends with.
//!
//! Results go to standard output; notes, progress and errors go to standard error. Nobody listening is not an error: a closed
//! pipe ends the talking, not the work.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use palpate::reconstruct::{Progress, ReconstructError};
use palpate_io::{ReadError, WriteError, WriteProblem};

/// Work shorter than this needs no sign of life.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two signs of life.
const TICK: Duration = Duration::from_millis(120);

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
        ProgressLine((!self.quiet && io::stderr().is_terminal()).then(Watched::new))
    }

    /// Shows how many of many jobs are finished, if someone is watching.
    pub fn counted_progress(&self) -> CountedProgress {
        let watched = !self.quiet && io::stderr().is_terminal();
        let target = if watched { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos} of {len} jobs  {elapsed}, {eta} to go") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        CountedProgress(bar)
    }
}

/// A bar for work of which it is known how much there is.
pub struct CountedProgress(ProgressBar);

impl CountedProgress {
    /// Takes in how many of how many are finished.
    pub fn update(&self, finished: u64, all: u64) {
        if self.0.length() != Some(all) {
            // What was finished before says nothing of how long the rest takes.
            self.0.set_length(all);
            self.0.set_position(finished);
            self.0.reset_eta();
        }
        self.0.set_position(finished);
    }
}

impl Drop for CountedProgress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
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

/// A line that appears when the work takes long, tells how far it has come, and goes away with it.
pub struct ProgressLine(Option<Watched>);

/// How much of the work there is cannot be known: a search ends as soon as it has found something. So there is no bar, which
/// would creep and then vanish, but a sign of life, the time, and the share of what may have to be tried.
struct Watched {
    bar: ProgressBar,
    /// Dropped when the work is done.
    working: Option<Sender<()>>,
    waiting: Option<JoinHandle<()>>,
}

impl Watched {
    fn new() -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed}  {wide_msg}") {
            bar.set_style(style);
        }
        let (working, end) = mpsc::channel::<()>();
        let waiting = std::thread::Builder::new().spawn({
            let bar = bar.clone();
            move || {
                if end.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    bar.set_draw_target(ProgressDrawTarget::stderr());
                    bar.enable_steady_tick(TICK);
                }
            }
        });
        // Without the thread the work goes on, unseen.
        Self { bar, working: Some(working), waiting: waiting.ok() }
    }
}

impl ProgressLine {
    /// Takes in how far the work has come.
    pub fn update(&self, progress: Progress) {
        // At the end the line goes away in a moment.
        if let Some(Watched { bar, .. }) = &self.0
            && progress.fraction < 1.0
        {
            let percent = (100.0 * progress.fraction.clamp(0.0, 1.0)).floor();
            bar.set_message(format!("{}, {percent} % of all that may have to be tried", progress.stage));
        }
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        drop(self.working.take());
        if let Some(waiting) = self.waiting.take() {
            // It does nothing that could panic; and if it did, the work is done all the same.
            let _ = waiting.join();
        }
        self.bar.finish_and_clear();
    }
}
