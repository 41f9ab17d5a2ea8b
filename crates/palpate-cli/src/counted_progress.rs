//! Progress of a sweep: so many jobs of so many.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::terminal::{TICK, Terminal};

/// A bar for work of known amount.
pub struct CountedProgress(ProgressBar);

impl CountedProgress {
    /// Shows the number of finished jobs on a terminal.
    pub fn new(terminal: &Terminal) -> Self {
        let target = if terminal.is_watched() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(None, target);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos} of {len} jobs  {elapsed}, {eta} to go") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(TICK);
        Self(bar)
    }

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
