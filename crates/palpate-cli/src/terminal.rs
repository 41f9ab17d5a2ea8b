//! Output, progress, errors and exit codes of the program.
//!
//! Results go to standard output; notes, progress and errors go to standard error. A closed pipe is not an error: it ends the output, not
//! the work.

use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use palpate::reconstruct::{Progress, ReconstructError};
use palpate_io::{ReadError, RigError, WriteError, WriteProblem};

/// No progress is shown for work shorter than this.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time between two updates of the progress.
pub const TICK: Duration = Duration::from_millis(120);

/// How a command ended, from good to bad: of several logs the worst counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ending {
    /// All is well; a reconstruction is certified.
    Success,
    /// There is a result, but it is not certified.
    NotCertified,
    /// The input or the options are at fault, and the user was told.
    BadInput,
    /// Anything else is, and the user was told.
    Failed,
}

/// Why a command failed: one message for the user.
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

impl From<RigError> for Failure {
    fn from(error: RigError) -> Self {
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

/// Where a command prints.
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
        let code = match ending.unwrap_or_else(|failure| Self::tell(&failure)) {
            Ending::Success => 0,
            Ending::Failed => 1,
            Ending::BadInput => 2,
            Ending::NotCertified => 3,
        };
        ExitCode::from(code)
    }

    /// Tells of a failure in one line, quiet or not.
    pub fn tell(failure: &Failure) -> Ending {
        let (ending, message) = match failure {
            Failure::Input(message) => (Ending::BadInput, message),
            Failure::Other(message) => (Ending::Failed, message),
        };
        // A failure here cannot be reported.
        let _ = writeln!(io::stderr(), "error: {message}");
        ending
    }

    /// A result, to standard output.
    pub fn say(&self, text: &str) -> Result<(), Failure> {
        if self.quiet { Ok(()) } else { print(text) }
    }

    /// A note, to standard error.
    pub fn note(&self, text: &str) {
        if !self.quiet {
            let _ = writeln!(io::stderr(), "note: {text}");
        }
    }

    /// Shows the progress on a terminal.
    pub fn progress(&self) -> ProgressLine {
        ProgressLine(self.is_watched().then(Watched::new))
    }

    /// Whether someone sees the progress.
    pub fn is_watched(&self) -> bool {
        !self.quiet && io::stderr().is_terminal()
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

/// A line that shows the progress of long work, and vanishes at its end.
pub struct ProgressLine(Option<Watched>);

/// The amount of work is unknown, since a search ends as soon as it has found an answer. So there is no bar but a spinner, the time, and
/// the share of the budget that is spent.
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
    /// Says what is being done, where nobody knows how far it has come.
    pub fn say(&self, stage: &'static str) {
        if let Some(Watched { bar, .. }) = &self.0 {
            bar.set_message(stage);
        }
    }

    /// Takes in how far the work has come.
    pub fn update(&self, progress: Progress) {
        // At the end the line goes away in a moment.
        if let Some(Watched { bar, .. }) = &self.0
            && progress.fraction < 1.0
        {
            let percent = (100.0 * progress.fraction.clamp(0.0, 1.0)).floor();
            bar.set_message(format!("{}, {percent} % of the budget", progress.stage));
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
