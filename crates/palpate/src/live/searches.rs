//! Searches over the samples so far, and fits of what they found, on a thread of their own: when they begin and when their result is taken over
//! depends on the number of samples alone, so that a replay gives the same estimates whatever the machine does meanwhile.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use crate::live::follower::Follower;
use crate::live::kept::Kept;
use crate::live::optimum::{Extent, FITTED_AT_MOST, Optimum, search};
use crate::log::Sample;
use crate::reconstruct::{ReconstructError, ReconstructOptions};

/// Samples before the first search.
const FIRST: u64 = 80;

/// Samples from the begin of a search to its end: this share of those before it, and at least, and at most, so many.
const SHARE: f64 = 0.08;
const LEAST: u64 = 20;
const MOST: u64 = 10_000;

/// Samples before the first search that goes all ways, and at least so many to its end.
const FIRST_WHOLE: u64 = 300;
const LEAST_OF_WHOLE: u64 = 100;

/// Growth of the samples from one search to the next where its answer is settled, and from one that goes all ways to the next such.
const SETTLED_GROWTH: u64 = 2;
const WHOLE_GROWTH: u64 = 2;

/// Work of a search that goes all ways for each sample until its end (`estimate/work.rs`): what a core does in a hundredth of a second, about.
const WORK_PER_SAMPLE: u64 = 20_000_000;

/// Samples from the begin of a fit to its end, and to the begin of the next: these shares of those before it, and to its end at least so many. A
/// fit takes ten microseconds for each sample.
const FIT_SHARE: f64 = 1.0 / 64.0;
const FIT_LEAST: u64 = 8;
const NEXT_FIT_SHARE: f64 = 1.0 / 16.0;

/// Samples that wait at most for the thread of the searches to take them in, while it has nothing else to do.
const WAITING: usize = 1024;

/// What a search found, or the follower with a shape that was fitted anew.
pub(super) enum Ended {
    Search(Result<Box<Optimum>, ReconstructError>),
    Fit(Option<Box<Follower>>),
}

/// What is under way, or over, and not yet taken over.
enum Running {
    /// And what it is where the thread failed for good: one that found nothing.
    Thread(JoinHandle<Ended>, Box<Ended>),
    Done(Box<Ended>),
}

/// The searches of one stream.
pub(super) struct Searches {
    options: ReconstructOptions,
    /// The samples so far, as the searches have them, and those that are not yet among them: copying all of them would take longer than a sample may.
    kept: Arc<Mutex<Kept>>,
    waiting: Vec<Sample>,
    next_at: u64,
    fit_at: u64,
    running: Option<(Running, u64)>,
    begun_at: u64,
    /// Where one may go all ways, and whether the last did.
    whole_at: u64,
    was_whole: bool,
    /// Whether the last search explained the samples.
    is_explained: bool,
}

impl Searches {
    pub fn new(options: ReconstructOptions) -> Self {
        Self {
            options,
            kept: Arc::new(Mutex::new(Kept::new())),
            waiting: Vec::new(),
            next_at: FIRST,
            fit_at: 0,
            running: None,
            begun_at: 0,
            whole_at: FIRST_WHOLE,
            was_whole: false,
            is_explained: false,
        }
    }

    /// Samples that the search which is running, or was the last, knows of.
    pub fn begun_at(&self) -> u64 {
        self.begun_at
    }

    /// Whether a search is to begin behind so many samples. Where the answer of the last one is settled, it needs no other for long.
    pub fn is_due(&self, samples: u64, is_settled: bool) -> bool {
        let next_at = if is_settled { SETTLED_GROWTH * self.begun_at } else { self.next_at };
        self.running.is_none() && samples >= next_at.max(self.next_at)
    }

    /// Whether what is certified is to be fitted anew behind so many samples.
    pub fn fit_is_due(&self, samples: u64) -> bool {
        self.running.is_none() && samples <= FITTED_AT_MOST as u64 && samples >= self.fit_at
    }

    /// Whether one of either is under way, or over and not yet taken over.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Takes a sample in.
    pub fn push(&mut self, sample: &Sample) {
        self.waiting.push(*sample);
        if self.waiting.len() >= WAITING && !self.is_running() {
            keep(&self.kept, std::mem::take(&mut self.waiting));
        }
    }

    /// Begins one over the samples so far: by the first way alone, which is soon done, unless that explained nothing and all ways were gone long ago, or never.
    pub fn begin(&mut self, samples: u64) {
        let is_whole = !self.is_explained && samples >= self.whole_at;
        let least = if is_whole { LEAST_OF_WHOLE } else { LEAST };
        let until = samples + ((SHARE * samples as f64) as u64).clamp(least, MOST);
        let extent = if is_whole {
            self.whole_at = WHOLE_GROWTH * samples;
            Extent::Whole { most_work: WORK_PER_SAMPLE * (until - samples) }
        } else {
            Extent::Brief
        };
        (self.next_at, self.begun_at, self.was_whole) = (until, samples, is_whole);
        let task = move |kept: &Kept, options: &_| Ended::Search(search(kept, options, extent).map(Box::new));
        self.run((samples, until), task, Ended::Search(Err(ReconstructError::NotSolvable)));
    }

    /// Begins a fit of what this follower knows to the samples so far.
    pub fn begin_fit(&mut self, samples: u64, follower: Follower) {
        let until = samples + ((FIT_SHARE * samples as f64) as u64).max(FIT_LEAST);
        let task = move |kept: &Kept, options: &_| Ended::Fit(follower.refitted(kept, options).map(Box::new));
        self.run((samples, until), task, Ended::Fit(None));
    }

    fn run(
        &mut self,
        (samples, until): (u64, u64),
        task: impl FnOnce(&Kept, &ReconstructOptions) -> Ended + Clone + Send + 'static,
        failed: Ended,
    ) {
        self.fit_at = until.max(samples + (NEXT_FIT_SHARE * samples as f64) as u64);
        let (options, kept, waiting) =
            (self.options.clone(), Arc::clone(&self.kept), std::mem::take(&mut self.waiting));
        let work = move || {
            keep(&kept, waiting);
            let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            task(&kept, &options)
        };
        let spawned = std::thread::Builder::new().name("search".to_owned()).spawn(work.clone());
        // Without a thread to be had it is done at once.
        let running = match spawned {
            Ok(thread) => Running::Thread(thread, Box::new(failed)),
            Err(_) => Running::Done(Box::new(work())),
        };
        self.running = Some((running, until));
    }

    /// The result of what ends behind so many samples; waits for it where it is not there yet.
    pub fn ended(&mut self, samples: u64) -> Option<Ended> {
        let (running, _) = self.running.take_if(|(_, until)| samples >= *until)?;
        let ended = match running {
            Running::Done(ended) => *ended,
            Running::Thread(thread, failed) => thread.join().unwrap_or(*failed),
        };
        if let Ended::Search(found) = &ended {
            self.is_explained = found.as_ref().is_ok_and(|optimum| optimum.is_explained());
        }
        Some(ended)
    }

    /// Whether the last search went all ways.
    pub fn was_whole(&self) -> bool {
        self.was_whole
    }
}

fn keep(kept: &Mutex<Kept>, samples: Vec<Sample>) {
    // A search that failed for good left them as they were.
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    samples.iter().for_each(|sample| kept.push(sample));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples at which searches begin that explain nothing, and whether they go all ways.
    fn begun(most: u64, is_settled: impl Fn(u64) -> bool) -> Vec<(u64, bool)> {
        let mut searches = Searches::new(ReconstructOptions::default());
        let mut begun = Vec::new();
        for samples in 0..most {
            let _ = searches.ended(samples);
            if searches.is_due(samples, is_settled(samples)) {
                searches.begin(samples);
                begun.push((samples, searches.was_whole()));
            }
        }
        begun
    }

    #[test]
    fn searches_follow_each_other_at_a_growing_distance() {
        let begun = begun(40_000, |_| false);
        let at: Vec<u64> = begun.iter().map(|(samples, _)| *samples).collect();
        assert_eq!(at[..3], [FIRST, FIRST + LEAST, FIRST + 2 * LEAST]);
        assert!(at.windows(2).all(|pair| pair[1] - pair[0] >= LEAST));
        let late = at.windows(2).skip_while(|pair| pair[0] < 2000);
        assert!(late.into_iter().all(|pair| (0.07..=SHARE).contains(&((pair[1] - pair[0]) as f64 / pair[0] as f64))));
        assert!(begun.len() < 80, "{}", begun.len());
    }

    #[test]
    fn a_settled_answer_needs_no_other_before_the_samples_have_doubled() {
        let at: Vec<u64> = begun(40_000, |samples| samples >= 1000).into_iter().map(|(samples, _)| samples).collect();
        let late: Vec<u64> = at.iter().copied().filter(|samples| *samples >= 1000).collect();
        assert!(late.windows(2).all(|pair| pair[1] == SETTLED_GROWTH * pair[0]), "{late:?}");
        // One that was due a sample before the doubling is not begun; doubt begins it at once.
        let last = *late.last().expect("some");
        let doubted = begun(40_000, |samples| samples >= 1000 && samples < last - 100);
        assert!(doubted.iter().any(|(samples, _)| *samples == last - 100), "{doubted:?}");
    }

    #[test]
    fn all_ways_are_gone_each_time_the_samples_have_doubled_without_an_explanation() {
        let whole: Vec<u64> =
            begun(40_000, |_| false).into_iter().filter(|(_, whole)| *whole).map(|(samples, _)| samples).collect();
        assert!(whole.first().is_some_and(|first| (FIRST_WHOLE..FIRST_WHOLE + 2 * LEAST).contains(first)), "{whole:?}");
        assert!(whole.windows(2).all(|pair| (2.0..2.5).contains(&(pair[1] as f64 / pair[0] as f64))), "{whole:?}");
        let mut searches = Searches::new(ReconstructOptions::default());
        searches.is_explained = true;
        searches.begin(1000);
        assert!(!searches.was_whole());
    }
}
