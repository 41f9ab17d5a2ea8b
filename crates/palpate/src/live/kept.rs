//! The samples that are kept of a stream of any length: all of them up to a limit, then every second, every fourth and so on.

use crate::log::{Log, Sample};

/// Samples that are kept at most: eleven minutes at 100 Hz, and ten megabytes.
const MOST_KEPT: usize = 65_536;

/// Keeps all samples of a stream up to a limit, and from then on evenly spread ones.
#[derive(Clone, Debug)]
pub(crate) struct Halving {
    every: u64,
    seen: u64,
}

impl Default for Halving {
    fn default() -> Self {
        Self { every: 1, seen: 0 }
    }
}

impl Halving {
    /// Takes a sample in, and keeps it or not; where there are `most` of them already, every second one goes.
    pub fn push<T>(&mut self, kept: &mut Vec<T>, most: usize, sample: T) {
        if self.seen.is_multiple_of(self.every) {
            if kept.len() == most {
                let mut index = 0_usize;
                kept.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.every *= 2;
            }
            if self.seen.is_multiple_of(self.every) {
                kept.push(sample);
            }
        }
        self.seen += 1;
    }

    /// One in so many is kept.
    pub fn every(&self) -> u64 {
        self.every
    }

    /// How many were seen.
    pub fn seen(&self) -> u64 {
        self.seen
    }
}

/// The samples of a palm log that are kept.
#[derive(Clone, Debug)]
pub(super) struct Kept {
    log: Log,
    halving: Halving,
}

impl Kept {
    pub fn new() -> Self {
        // A buffer that grows would be copied now and then, which takes longer than a sample may.
        Self { log: Log { samples: Vec::with_capacity(MOST_KEPT) }, halving: Halving::default() }
    }

    pub fn push(&mut self, sample: &Sample) {
        self.halving.push(&mut self.log.samples, MOST_KEPT, *sample);
    }

    /// What is kept.
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// One in so many is kept.
    pub fn every(&self) -> u64 {
        self.halving.every()
    }

    /// How many were seen.
    pub fn seen(&self) -> u64 {
        self.halving.seen()
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
            assert_eq!(kept.every(), 1, "all of them up to the limit");
            kept.push(&Sample::new(index as f64, PalmPair::hinged(1.0, 1.2), 0.03, 0.03));
        }
        for index in MOST_KEPT + 1..5 * MOST_KEPT {
            kept.push(&Sample::new(index as f64, PalmPair::hinged(1.0, 1.2), 0.03, 0.03));
            assert!(kept.log().samples.len() <= MOST_KEPT);
        }
        assert_eq!((kept.every(), kept.seen()), (8, 5 * MOST_KEPT as u64));
        let times: Vec<f64> = kept.log().samples.iter().map(|sample| sample.time_s).collect();
        assert!(times.iter().enumerate().all(|(index, time_s)| *time_s == 8.0 * index as f64));
        assert_eq!(times.len(), 5 * MOST_KEPT / 8);
    }
}
