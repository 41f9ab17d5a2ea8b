//! The samples that are kept of a stream of any length: all of them up to a limit, then every second, every fourth and so on.

use crate::log::{Log, Sample};

/// Samples that are kept at most: eleven minutes at 100 Hz, and ten megabytes.
const MOST_KEPT: usize = 65_536;

/// Which of a stream are kept: every n-th from the first, where n is 1 until there are too many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Thinning {
    every: u64,
    seen: u64,
}

impl Thinning {
    /// Takes the next into those that are kept, where it is one.
    pub fn push<T>(&mut self, kept: &mut Vec<T>, next: T) {
        if self.seen.is_multiple_of(self.every) {
            if kept.len() == MOST_KEPT {
                let mut index = 0_usize;
                kept.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.every *= 2;
            }
            if self.seen.is_multiple_of(self.every) {
                kept.push(next);
            }
        }
        self.seen += 1;
    }

    /// One in so many is kept.
    pub fn every(self) -> u64 {
        self.every
    }

    /// How many were seen.
    pub fn seen(self) -> u64 {
        self.seen
    }
}

/// The samples that are kept.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    log: Log,
    thinning: Thinning,
}

impl Kept {
    pub fn new() -> Self {
        // A buffer that grows would be copied now and then, which takes longer than a sample may.
        Self { log: Log { samples: Vec::with_capacity(MOST_KEPT) }, thinning: Thinning { every: 1, seen: 0 } }
    }

    pub fn push(&mut self, sample: &Sample) {
        self.thinning.push(&mut self.log.samples, *sample);
    }

    /// What is kept.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// Which are.
    pub fn thinning(&self) -> Thinning {
        self.thinning
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;

    #[test]
    fn of_a_stream_of_any_length_evenly_spread_samples_are_kept() {
        let mut kept = Kept::new();
        for index in 0..MOST_KEPT + 1 {
            assert_eq!(kept.thinning().every(), 1, "all of them up to the limit");
            kept.push(&Sample::new(index as f64, PalmPair::hinged(1.0, 1.2), 0.03, 0.03));
        }
        for index in MOST_KEPT + 1..5 * MOST_KEPT {
            kept.push(&Sample::new(index as f64, PalmPair::hinged(1.0, 1.2), 0.03, 0.03));
            assert!(kept.log().samples.len() <= MOST_KEPT);
        }
        assert_eq!(kept.thinning(), Thinning { every: 8, seen: 5 * MOST_KEPT as u64 });
        let times: Vec<f64> = kept.log().samples.iter().map(|sample| sample.time_s).collect();
        assert!(times.iter().enumerate().all(|(index, time_s)| *time_s == 8.0 * index as f64));
        assert_eq!(times.len(), 5 * MOST_KEPT / 8);
    }
}
