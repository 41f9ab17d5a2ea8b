//! Searches over the samples so far, on a thread of their own: when they begin and when their result is taken over depends on the number of samples
//! alone, so that a replay gives the same estimates whatever the machine does meanwhile.

use std::thread::JoinHandle;

use crate::live::optimum::{Optimum, search};
use crate::log::Log;
use crate::reconstruct::{ReconstructError, ReconstructOptions};

/// Samples before the first search.
const FIRST: u64 = 100;

/// Samples from the begin of a search to its end: this share of those before it, and at least, and at most, so many.
const SHARE: f64 = 0.08;
const LEAST: u64 = 100;
const MOST: u64 = 10_000;

/// Work of a search for each sample until its end (`estimate/work.rs`): what a core does in a hundredth of a second, about.
const WORK_PER_SAMPLE: u64 = 20_000_000;

type Found = Result<Box<Optimum>, ReconstructError>;

/// A search that is under way, or over, and not yet taken over.
enum Running {
    Thread(JoinHandle<Found>),
    Done(Box<Found>),
}

/// The searches of one stream.
pub(super) struct Searches {
    options: ReconstructOptions,
    next_at: u64,
    running: Option<(Running, u64)>,
    begun_at: u64,
}

impl Searches {
    pub fn new(options: ReconstructOptions) -> Self {
        Self { options, next_at: FIRST, running: None, begun_at: 0 }
    }

    /// Samples that the search which is running, or was the last, knows of.
    pub fn begun_at(&self) -> u64 {
        self.begun_at
    }

    /// Whether a search is to begin behind so many samples.
    pub fn is_due(&self, samples: u64) -> bool {
        self.running.is_none() && samples >= self.next_at
    }

    /// Begins one.
    pub fn begin(&mut self, samples: u64, log: Log) {
        let until = samples + ((SHARE * samples as f64) as u64).clamp(LEAST, MOST);
        let most_work = WORK_PER_SAMPLE * (until - samples);
        let options = self.options.clone();
        let work = move || search(&log, &options, most_work).map(Box::new);
        let spawned = std::thread::Builder::new().name("search".to_owned()).spawn(work.clone());
        // Without a thread to be had it is done at once.
        let running = spawned.map_or_else(|_| Running::Done(Box::new(work())), Running::Thread);
        (self.running, self.next_at, self.begun_at) = (Some((running, until)), until, samples);
    }

    /// The result of a search that ends behind so many samples; waits for it where it is not there yet.
    pub fn ended(&mut self, samples: u64) -> Option<Found> {
        let (running, _) = self.running.take_if(|(_, until)| samples >= *until)?;
        Some(match running {
            Running::Done(found) => *found,
            // A search that failed for good is one that found nothing.
            Running::Thread(thread) => thread.join().unwrap_or(Err(ReconstructError::NotSolvable)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_follow_each_other_at_a_growing_distance() {
        let mut searches = Searches::new(ReconstructOptions::default());
        let mut begun = Vec::new();
        for samples in 0..40_000 {
            if searches.ended(samples).is_some() || searches.is_due(samples) {
                begun.push(samples);
                searches.begin(samples, Log::default());
            }
        }
        assert_eq!(begun[..3], [FIRST, FIRST + LEAST, FIRST + 2 * LEAST]);
        let shares = begun.windows(2).map(|pair| (pair[1] - pair[0]) as f64 / pair[0] as f64);
        assert!(shares.skip_while(|share| *share > SHARE).all(|share| share > 0.9 * SHARE));
        assert!(begun.len() < 60, "{}", begun.len());
    }
}
