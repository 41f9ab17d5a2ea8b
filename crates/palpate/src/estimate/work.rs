//! Work done for one log, in multiplications of Gauss-Newton steps with every orientation eliminated, about; what else takes long, as many of them as take
//! that long. A search that leads nowhere ends by it and not by a clock: the result must not depend on the machine, its load or the number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Work of a step besides the matrix, for each sample and unknown: trigonometry, and orientations brought to their minima.
const BESIDES_MATRIX: u64 = 40;

/// Work of one orientation after another for a sample: the trials of the grid and the minima between them.
const OF_DECODING: u64 = 40_000;

/// Work of a passage from one pose to another: a fold that is met after a few landscapes.
const OF_PASSAGE: u64 = 50_000;

/// A step with orientations that depend each on the one before takes so many times as long as one as above with as many rows.
const BANDED: u64 = 3;

/// Work after which no further explanation of a log is looked for: that of a search, whose windows are as many however long the log is, and that of
/// refinements, for each sample. Of 67 logs under varied conditions that were certified all but two had begun on their answer by half of that, and the
/// last by nine tenths.
const OF_SEARCH: u64 = 18_000_000_000;
const OF_SAMPLE: u64 = 4_500_000;

/// A sum over all that is done with the measurements of a log, and with copies and parts of them.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    done: Arc<AtomicU64>,
    /// Up to what it goes on.
    most: u64,
    /// What the log is worth.
    of_log: u64,
    /// Whether that is a limit from outside, such as the time there is, which nothing that is found moves.
    is_limited: bool,
}

impl Work {
    /// None yet, for a log of so many samples that is searched with so many trusts in the calibration of the rig.
    pub fn for_log(samples: usize, trusts: usize) -> Self {
        let of_log = trusts as u64 * (OF_SEARCH + OF_SAMPLE * samples as u64);
        Self { done: Arc::default(), most: of_log, of_log, is_limited: false }
    }

    /// The same for a log that is worth no more than this.
    pub fn at_most(self, most: u64) -> Self {
        Self { most: self.most.min(most), of_log: self.of_log.min(most), is_limited: true, ..self }
    }

    /// The same for a log that is worth no more than such a share of it.
    pub fn at_most_share(self, share: f64) -> Self {
        let most = (self.of_log as f64 * share) as u64;
        self.at_most(most)
    }

    /// None yet, of what is worth such a share of what the log is.
    pub fn afresh(&self, share: f64) -> Self {
        Self { done: Arc::default(), most: (self.of_log as f64 * share) as u64, ..*self }
    }

    /// Counts a Gauss-Newton step: the matrix from every sample, and its factor.
    pub fn add_step(&self, samples: usize, unknowns: usize) {
        let (samples, unknowns) = (samples as u64, unknowns as u64);
        let work = samples * unknowns * (unknowns + BESIDES_MATRIX) + 2 * unknowns.pow(3);
        self.done.fetch_add(work, Ordering::Relaxed);
    }

    /// The same of a step whose samples are not eliminated one by one.
    pub fn add_banded_step(&self, rows: usize, unknowns: usize) {
        for _ in 0..BANDED {
            self.add_step(rows, unknowns);
        }
    }

    /// Counts candidates for the poses of so many samples.
    pub fn add_decoding(&self, samples: usize) {
        self.done.fetch_add(OF_DECODING * samples as u64, Ordering::Relaxed);
    }

    /// Counts so many passages from one pose to another.
    pub fn add_passages(&self, passages: usize) {
        self.done.fetch_add(OF_PASSAGE * passages as u64, Ordering::Relaxed);
    }

    /// Whether no more is worth doing for the log. Asked between steps that other threads have no part in, it says the same
    /// on every machine.
    pub fn is_spent(&self) -> bool {
        self.is_spent_by(1.0)
    }

    /// The same for a log that has become worth so many times as much by what was found, unless it is limited.
    pub fn is_spent_by(&self, times: f64) -> bool {
        self.done() as f64 > if self.is_limited { 1.0 } else { times } * self.most as f64
    }

    fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_count_together() {
        let work = Work::for_log(0, 1);
        let copy = work.clone();
        rayon::scope(|scope| (0..100).for_each(|_| scope.spawn(|_| copy.add_step(10, 2))));
        assert_eq!(work.done(), 100 * (10 * 2 * 42 + 16));
    }

    #[test]
    fn a_longer_log_is_worth_more() {
        let steps = (OF_SEARCH + OF_SAMPLE * 1200) / (1200 * 97 * 137 + 2 * 97u64.pow(3));
        let spent_on = |samples: usize| {
            let work = Work::for_log(samples, 1);
            (0..steps).for_each(|_| work.add_step(1200, 97));
            work
        };
        assert!(!spent_on(1200).is_spent() && spent_on(1100).is_spent() && !spent_on(1300).is_spent());
        let uncalibrated = Work::for_log(1100, 3);
        (0..2 * steps).for_each(|_| uncalibrated.add_step(1200, 97));
        assert!(!uncalibrated.is_spent());
        let limited = Work::for_log(1200, 1).at_most(1200 * 97 * 137);
        limited.add_step(1200, 97);
        assert!(limited.is_spent());
        let work = spent_on(1200);
        work.add_banded_step(1200, 97);
        assert!(work.is_spent());
        let afresh = work.afresh(0.25);
        assert!(!afresh.is_spent());
        // What is begun afresh within it is worth a share of the log as well.
        let once_more = afresh.afresh(0.25);
        (0..=steps / 4).for_each(|_| afresh.add_step(1200, 97));
        assert!(afresh.is_spent() && !once_more.is_spent());
        (0..=steps / 4).for_each(|_| once_more.add_step(1200, 97));
        assert!(once_more.is_spent());
    }

    #[test]
    fn what_was_found_makes_a_log_worth_more_but_gives_no_time() {
        let spent_by = |work: Work, times: f64| {
            while !work.is_spent() {
                work.add_passages(1);
            }
            work.is_spent_by(times)
        };
        assert!(!spent_by(Work::for_log(0, 1), 1.1));
        assert!(spent_by(Work::for_log(0, 1).at_most(1_000_000), 1.1));
    }

    #[test]
    fn what_is_no_step_counts_too() {
        let work = Work::for_log(0, 1);
        let most = OF_SEARCH / OF_PASSAGE;
        work.add_passages(most as usize);
        assert!(!work.is_spent());
        work.add_decoding(1);
        assert!(work.is_spent());
    }
}
