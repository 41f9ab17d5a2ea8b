//! Thinning of a log: means over runs of neighbouring samples, each short enough that palms and contacts hardly move over it. The mean
//! over a longer one would be no pose at all: contacts are no linear function of the palms. Motions that pause or go in stairs have
//! their instants where they move.

use crate::estimate::measurements::{Instant, Measurements};
use crate::log::{Log, Sample};
use crate::palms::PalmPair;
use std::ops::Range;

/// By how much contacts and palms may move over a run, as a share of the size of the object: the square of it, over 24, is what the mean
/// of a curved path is off, well below the noise that the search allows for.
const EXTENT: f64 = 0.1;

/// By how much the contacts at the ends of a run may differ from those between, as a share of the size and in standard deviations of their noise: their mean
/// is off by a third of it. Contacts that run over a flat side or stay at a corner bend within a run.
const BEND: f64 = 0.003;
const BEND_SDS: f64 = 3.0;

/// Instants at most, over the number that is asked for: with more, runs are longer, or a part of the log is searched.
const MOST: f64 = 1.5;

/// By how much the extent of a run grows at a time where there would be more, and how often at most: of a log that is longer, a part is
/// searched.
const GROWTH: f64 = 1.5;
const GROWTHS: usize = 2;

/// Longest run, over what an even thinning would have: where nothing moves, instants are spared for where something does.
const LONGEST: f64 = 2.0;

/// The noise spreads the contacts of a run by this many standard deviations, about: the range of some ten to a hundred.
const NOISE_RANGE: f64 = 4.0;

/// How a log is thinned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thinning {
    /// Samples of a run at most.
    longest: usize,
    /// By how much contacts may move over a run, and palms at the distance of the size of the object, metres.
    extent_m: f64,
    /// Size of the object, metres.
    size_m: f64,
    /// Standard deviation of a contact position, metres.
    noise_m: f64,
}

impl Thinning {
    /// To about `count` instants in these ranges of samples.
    pub fn to(measurements: &Measurements, ranges: &[Range<usize>], noise_m: f64, count: usize) -> Self {
        let total: usize = ranges.iter().map(|range| range.len()).sum();
        let even = total as f64 / count.max(1) as f64;
        let size_m = measurements.size_m();
        let longest = if even > 1.0 { (LONGEST * even) as usize } else { 1 };
        let most = most_instants(count);
        let mut thinning = Self { longest, extent_m: EXTENT * size_m, size_m, noise_m };
        for _ in 0..GROWTHS {
            if ranges.iter().map(|range| thinning.runs(measurements, range).len()).sum::<usize>() > most {
                thinning.extent_m *= GROWTH;
            }
        }
        thinning
    }

    /// The same with runs of at most so many samples.
    pub fn at_most(self, longest: usize) -> Self {
        Self { longest: self.longest.min(longest).max(1), ..self }
    }

    /// Twice as fine.
    pub fn finer(self) -> Self {
        Self { longest: (self.longest / 2).max(1), extent_m: 0.5 * self.extent_m, ..self }
    }

    /// The runs of a range.
    pub fn runs(&self, measurements: &Measurements, range: &Range<usize>) -> Vec<Range<usize>> {
        let parts = range.len().div_ceil(self.longest);
        let edge = |part: usize| range.start + range.len() * part / parts;
        let mut runs = Vec::new();
        // The part that is looked at next is the last one.
        let mut open: Vec<Range<usize>> = (0..parts).rev().map(|part| edge(part)..edge(part + 1)).collect();
        while let Some(run) = open.pop() {
            let instants = &measurements.instants[run.clone()];
            let is_long = || self.moved_m(instants) > self.extent_m || bent_m(instants) > self.bend_m();
            if run.len() > 1 && is_long() {
                let middle = run.start + run.len() / 2;
                open.push(middle..run.end);
                open.push(run.start..middle);
            } else {
                runs.push(run);
            }
        }
        runs
    }

    /// By how much contacts may bend over a run, metres.
    fn bend_m(&self) -> f64 {
        (BEND * self.size_m).max(BEND_SDS * self.noise_m)
    }

    /// By how much contacts and palms move over some instants, metres.
    fn moved_m(&self, instants: &[Instant]) -> f64 {
        let range = |value: fn(&Instant) -> f64| {
            let seen = instants.iter().filter(|instant| instant.both_seen()).map(value);
            let (low, high) = seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            (high - low).max(0.0)
        };
        let contacts = range(|instant| instant.s1).max(range(|instant| instant.s2)) - NOISE_RANGE * self.noise_m;
        let palms = range(|instant| instant.phi1).max(range(|instant| instant.phi1 + instant.phi2));
        contacts.max(self.size_m * palms)
    }
}

/// By how much the contacts at the ends of some instants differ from those between, metres; 0 where there are none between.
fn bent_m(instants: &[Instant]) -> f64 {
    let seen: Vec<&Instant> = instants.iter().filter(|instant| instant.both_seen()).collect();
    let [first, between @ .., last] = seen.as_slice() else { return 0.0 };
    if between.is_empty() {
        return 0.0;
    }
    let bent = |value: fn(&Instant) -> f64| {
        let mean = between.iter().map(|instant| value(instant)).sum::<f64>() / between.len() as f64;
        (0.5 * (value(first) + value(last)) - mean).abs()
    };
    bent(|instant| instant.s1).max(bent(|instant| instant.s2))
}

/// Instants at most where `count` are asked for.
pub(crate) fn most_instants(count: usize) -> usize {
    (MOST * count as f64) as usize
}

impl Measurements {
    /// The mean of each run, over the instants that saw both contacts; none where there are none.
    pub fn means(&self, runs: &[Range<usize>]) -> Self {
        self.of(runs.iter().filter_map(|run| mean(&self.instants[run.clone()])).collect())
    }

    /// The same, with the mean of the samples behind each.
    pub fn means_with_samples(&self, runs: &[Range<usize>], log: &Log) -> (Self, Log) {
        let of_run = |run: &Range<usize>| {
            let seen = |index: &usize| self.instants[*index].both_seen();
            let samples: Vec<&Sample> = run.clone().filter(seen).map(|index| &log.samples[index]).collect();
            mean_sample(&samples)
        };
        (self.means(runs), Log { samples: runs.iter().filter_map(of_run).collect() })
    }
}

fn mean(instants: &[Instant]) -> Option<Instant> {
    let seen: Vec<&Instant> = instants.iter().filter(|instant| instant.both_seen()).collect();
    let middle = seen.get(seen.len() / 2)?;
    let mean = |value: fn(&Instant) -> f64| seen.iter().map(|i| value(i)).sum::<f64>() / seen.len() as f64;
    let (phi1, phi2) = (mean(|i| i.phi1), mean(|i| i.phi2));
    Some(Instant {
        position: mean(|i| i.position),
        s1: mean(|i| i.s1),
        s2: mean(|i| i.s2),
        weight1: 1.0,
        weight2: 1.0,
        balance_weight: 1.0,
        ..middle.turned(phi1 - middle.phi1, phi1 + phi2 - middle.phi1 - middle.phi2)
    })
}

fn mean_sample(seen: &[&Sample]) -> Option<Sample> {
    let middle = **seen.get(seen.len() / 2)?;
    let mean =
        |value: &dyn Fn(&Sample) -> f64| seen.iter().map(|sample| value(sample)).sum::<f64>() / seen.len() as f64;
    let phi1_rad = mean(&|sample| sample.palms.phi1_rad);
    let phi2_rad = mean(&|sample| sample.palms.phi2_rad);
    Some(Sample {
        time_s: mean(&|sample| sample.time_s),
        palms: PalmPair { phi1_rad, phi2_rad, ..middle.palms },
        s1_m: Some(mean(&|sample| sample.s1_m.unwrap_or_default())),
        s2_m: Some(mean(&|sample| sample.s2_m.unwrap_or_default())),
        ..middle
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::{PalmMotion, PalmPair};
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    /// A log in which the palms rest for nine tenths of the time, and move as fast as they do in the one tenth between.
    fn resting(samples: usize) -> Measurements {
        let motion = PalmMotion::random(3, 20.0, 1.0).and_then(|motion| motion.sample(50.0)).expect("possible");
        let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
        let moving = samples / 10;
        let from = (samples - moving) / 2;
        let palms: Vec<PalmPair> =
            (0..samples).map(|sample| motion[sample.clamp(from, from + moving) - from].1).collect();
        let motion: Vec<(f64, PalmPair)> =
            palms.into_iter().enumerate().map(|(k, palms)| (0.02 * k as f64, palms)).collect();
        Measurements::new(&simulate(&shape, &motion, &SimulateOptions::default()).expect("possible").log, None)
    }

    #[test]
    fn runs_cover_a_range_without_gaps() {
        let measurements = resting(1000);
        let thinning = Thinning::to(&measurements, std::slice::from_ref(&(0..1000)), 0.0, 100);
        for range in [0..1000, 17..430, 5..6] {
            let runs = thinning.runs(&measurements, &range);
            assert_eq!((runs[0].start, runs[runs.len() - 1].end), (range.start, range.end));
            assert!(runs.windows(2).all(|pair| pair[0].end == pair[1].start && !pair[0].is_empty()));
        }
        assert!(thinning.runs(&measurements, &(7..7)).is_empty());
    }

    #[test]
    fn instants_are_where_something_moves() {
        let measurements = resting(1000);
        let runs =
            Thinning::to(&measurements, std::slice::from_ref(&(0..1000)), 0.0, 100).runs(&measurements, &(0..1000));
        let moving = runs.iter().filter(|run| run.start >= 450 && run.end <= 550).count();
        assert!(moving > 20, "a tenth of the samples has {moving} of {} instants", runs.len());
        assert!(runs.len() <= 150);
        let size_m = measurements.size_m();
        for run in runs.iter().filter(|run| run.len() > 1) {
            let instants = &measurements.instants[run.clone()];
            let spread = |value: fn(&Instant) -> f64| {
                instants.iter().map(value).fold(f64::NEG_INFINITY, f64::max)
                    - instants.iter().map(value).fold(f64::INFINITY, f64::min)
            };
            assert!(spread(|i| i.s1) <= EXTENT * size_m && spread(|i| i.phi1) <= EXTENT);
        }
    }

    #[test]
    fn noise_does_not_count_as_motion() {
        let mut measurements = resting(1000);
        let noise_m = 0.1 * measurements.size_m();
        measurements
            .instants
            .iter_mut()
            .enumerate()
            .for_each(|(k, instant)| instant.s1 += noise_m * ((7 * k % 5) as f64 - 2.0));
        let size_m = measurements.size_m();
        let instants = |noise_m: f64| {
            let thinning = Thinning { longest: 20, extent_m: EXTENT * size_m, size_m, noise_m };
            thinning.runs(&measurements, &(0..400)).len()
        };
        assert_eq!((instants(noise_m), instants(0.0)), (20, 400));
    }

    #[test]
    fn contacts_bend_within_a_run_by_less_than_the_search_or_the_noise_hides() {
        let resting = resting(1000);
        let size_m = resting.size_m();
        let runs = |bend_m: f64, noise_m: f64| {
            let mut measurements = resting.clone();
            measurements.instants[1..15].iter_mut().for_each(|instant| instant.s1 += bend_m);
            let thinning = Thinning { longest: 16, extent_m: EXTENT * size_m, size_m, noise_m };
            thinning.runs(&measurements, &(0..16)).len()
        };
        assert!(runs(0.99 * BEND * size_m, 0.0) == 1 && runs(1.01 * BEND * size_m, 0.0) > 1);
        let noise_m = 0.01 * size_m;
        assert!(runs(0.99 * BEND_SDS * noise_m, noise_m) == 1 && runs(1.01 * BEND_SDS * noise_m, noise_m) > 1);
    }

    #[test]
    fn the_samples_behind_the_means_have_the_same_palms_and_contacts() {
        let motion = PalmMotion::random(3, 20.0, 1.0).and_then(|motion| motion.sample(50.0)).expect("possible");
        let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
        let mut log = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible").log;
        log.samples[4].s1_m = None;
        let measurements = Measurements::new(&log, None);
        let runs = [3..6, 4..5, 10..13];
        let (means, samples) = measurements.means_with_samples(&runs, &log);
        let again = Measurements::new(&samples, None);
        assert_eq!((means.len(), again.len()), (2, 2), "a run that saw nothing has no mean");
        for (mean, again) in means.instants.iter().zip(&again.instants) {
            assert!((mean.phi1 - again.phi1).abs() < 1e-12 && (mean.phi2 - again.phi2).abs() < 1e-12);
            assert!((mean.s1 - again.s1).abs() < 1e-12 && (mean.s2 - again.s2).abs() < 1e-12);
        }
        assert!((samples.samples[0].time_s - 0.5 * (log.samples[3].time_s + log.samples[5].time_s)).abs() < 1e-12);
    }

    #[test]
    fn the_mean_of_a_run_is_that_of_the_instants_that_saw_both_contacts() {
        let mut measurements = resting(1000);
        measurements.instants[4].weight1 = 0.0;
        measurements.instants[4].s1 = 1e3;
        let means = measurements.means(&[3..6, 4..5]);
        assert_eq!(means.len(), 1, "a run that saw nothing has no mean");
        let (a, b) = (&measurements.instants[3], &measurements.instants[5]);
        assert!((means.instants[0].s1 - 0.5 * (a.s1 + b.s1)).abs() < 1e-12);
        assert!((means.instants[0].phi1 - 0.5 * (a.phi1 + b.phi1)).abs() < 1e-12);
        assert!((means.instants[0].position - 4.0).abs() < 1e-12);
    }
}
