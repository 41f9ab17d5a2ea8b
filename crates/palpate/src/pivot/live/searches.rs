//! Searches over the samples so far, on a thread of their own: when one begins and when its result is taken over depends on the number of samples alone,
//! so that a replay gives the same estimates whatever the machine does meanwhile.

use std::thread::JoinHandle;

use crate::pivot::error::PivotReconstructError;
use crate::pivot::log::PivotLog;
use crate::pivot::posterior::PivotPosterior;
use crate::pivot::reconstruct::{PivotOptions, reconstruct_with_posterior};
use crate::pivot::result::PivotReconstruction;

/// Samples before the first search: twice as many contacts as can be solved.
const FIRST: u64 = 60;

/// Growth of the samples from the begin of one search to that of the next: all searches together take no longer than three times the last.
const GROWTH: f64 = 1.5;

/// Samples from the begin of a search to its end: this share of those before it, and at least so many.
const SHARE: f64 = 0.25;
const LEAST: u64 = 20;

/// What a search found.
pub(super) type Found = Result<Box<(PivotReconstruction, PivotPosterior)>, PivotReconstructError>;

/// What is under way, or over, and not yet taken over.
#[derive(Debug)]
enum Running {
    Thread(JoinHandle<Found>),
    Done(Found),
}

/// The searches of one stream.
#[derive(Debug)]
pub(super) struct Searches {
    next_at: u64,
    begun_at: u64,
    /// With the number of samples at which it ends.
    running: Option<(Running, u64)>,
}

impl Default for Searches {
    fn default() -> Self {
        Self { next_at: FIRST, begun_at: 0, running: None }
    }
}

impl Searches {
    /// Samples that the search which is running, or was the last, knows of.
    pub fn begun_at(&self) -> u64 {
        self.begun_at
    }

    /// Whether one is to begin behind so many samples.
    pub fn is_due(&self, samples: u64) -> bool {
        self.running.is_none() && samples >= self.next_at
    }

    /// Begins one over the samples so far.
    pub fn begin(&mut self, samples: u64, log: PivotLog, options: PivotOptions) {
        self.begun_at = samples;
        self.next_at = (GROWTH * samples as f64) as u64;
        let until = samples + ((SHARE * samples as f64) as u64).max(LEAST);
        let work = move || reconstruct_with_posterior(&log, &options).map(Box::new);
        let spawned = std::thread::Builder::new().name("search".to_owned()).spawn(work.clone());
        // Without a thread to be had it is done at once.
        let running = spawned.map_or_else(|_| Running::Done(work()), Running::Thread);
        self.running = Some((running, until));
    }

    /// The result of one that ends behind so many samples; waits for it where it is not there yet.
    pub fn ended(&mut self, samples: u64) -> Option<Found> {
        let (running, _) = self.running.take_if(|(_, until)| samples >= *until)?;
        Some(match running {
            Running::Done(found) => found,
            Running::Thread(thread) => thread.join().unwrap_or(Err(PivotReconstructError::NotSolvable)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_follow_each_other_at_a_growing_distance() {
        let mut searches = Searches::default();
        let (mut begun, mut ended) = (Vec::new(), Vec::new());
        for samples in 0..10_000 {
            if searches.ended(samples).is_some() {
                ended.push(samples);
            }
            if searches.is_due(samples) {
                searches.begin(samples, PivotLog::default(), PivotOptions::default());
                begun.push(samples);
            }
        }
        assert_eq!((&begun[..4], &ended[..3]), (&[60, 90, 135, 202][..], &[80, 112, 168][..]));
        assert!(begun.windows(2).all(|pair| (1.4..=GROWTH).contains(&(pair[1] as f64 / pair[0] as f64))), "{begun:?}");
        assert!(begun.len() < 15, "{begun:?}");
    }
}
