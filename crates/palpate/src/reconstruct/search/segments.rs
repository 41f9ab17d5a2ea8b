//! The log cut into segments at jumps (`docs/theory.md`, the search): places where a contact moves further between two samples
//! than the noise, its own pace and the motion of the palms explain. Neither shape nor orientation is needed. A false cut costs a
//! little work, a missed one spoils a segment, so the test is sensitive.

use crate::estimate::measurements::Measurements;
use crate::math::statistics::median;
use std::ops::Range;

/// A contact has jumped when its step differs from the median step around it by more than the sum of four terms. The noise: this
/// many standard deviations of a contact position.
const NOISE_FACTOR: f64 = 8.0;

/// The pace: this many times the median length of the steps around it.
const PACE_FACTOR: f64 = 4.0;

/// The palms: this many sizes of the object for each radian that they turn, added up. The contact of an object that keeps its
/// orientation moves by about as much.
const TURN_FACTOR: f64 = 2.0;

/// Neighbours: this many times what the slower of the two steps beside it differs by. The contact of an object that rolls fast speeds up
/// and slows down; one that jumps lies as still after the jump as ever.
const NEIGHBOUR_FACTOR: f64 = 4.0;

/// Steps on each side that a step is compared with: the pace is taken to be even over them.
const STEPS_AROUND: usize = 6;

/// Runs of neighbouring instants (index ranges) that saw both contacts, without a jump inside.
pub(crate) fn segments(measurements: &Measurements, scatter_m: f64) -> Vec<Range<usize>> {
    let seen: Vec<usize> = (0..measurements.len()).filter(|&index| measurements.instants[index].both_seen()).collect();
    let size_m = measurements.size_m();
    let steps: Vec<[f64; 2]> = seen
        .windows(2)
        .map(|pair| {
            let (a, b) = (&measurements.instants[pair[0]], &measurements.instants[pair[1]]);
            [b.s1 - a.s1, b.s2 - a.s2]
        })
        .collect();
    let jumps = |index: usize| {
        let turn = measurements.instants[seen[index]].palms_turn_to(&measurements.instants[seen[index + 1]]);
        let around = index.saturating_sub(STEPS_AROUND)..(index + STEPS_AROUND + 1).min(steps.len());
        (0..2).any(|sensor| {
            let mut others: Vec<f64> =
                around.clone().filter(|&other| other != index).map(|other| steps[other][sensor]).collect();
            let usual = median(&mut others);
            others.iter_mut().for_each(|step| *step = step.abs());
            let pace = median(&mut others);
            let off = |other: Option<&[f64; 2]>| other.map_or(0.0, |step| (step[sensor] - usual).abs());
            let beside = off(index.checked_sub(1).and_then(|before| steps.get(before))).min(off(steps.get(index + 1)));
            off(Some(&steps[index]))
                > NOISE_FACTOR * scatter_m
                    + PACE_FACTOR * pace
                    + TURN_FACTOR * size_m * turn
                    + NEIGHBOUR_FACTOR * beside
        })
    };
    let mut segments = Vec::new();
    let mut start = 0;
    for index in 0..steps.len() {
        if jumps(index) {
            segments.push(seen[start]..seen[index] + 1);
            start = index + 1;
        }
    }
    if let (Some(&first), Some(&last)) = (seen.get(start), seen.last()) {
        segments.push(first..last + 1);
    }
    segments
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::noise_from_log::{contact_scatter_m, steps_m};
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, Simulation, simulate};

    fn run(seed: u64, touchpad: Touchpad) -> Simulation {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(seed, 20.0, 1.0).and_then(|motion| motion.sample(100.0)).expect("possible");
        simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible")
    }

    #[test]
    fn a_log_is_cut_where_the_object_jumps_and_nowhere_else() {
        let mut jumps = 0;
        for seed in 0..8 {
            for noise_sd_m in [0.0, 5e-5] {
                let run = run(seed, Touchpad { noise_sd_m, ..Touchpad::ideal() });
                let measurements = Measurements::new(&run.log, None);
                let segments = segments(&measurements, contact_scatter_m(&measurements, steps_m(&run.log)));
                // The segments cover the log.
                assert_eq!(segments.iter().map(|segment| segment.len()).sum::<usize>(), measurements.len());
                assert!(segments.windows(2).all(|pair| pair[0].end == pair[1].start));
                let cuts: Vec<usize> = segments[1..].iter().map(|segment| segment.start).collect();
                let after = |time_s: f64| run.log.samples.partition_point(|sample| sample.time_s < time_s);
                for jump in &run.jumps {
                    let at = after(jump.time_s);
                    let step = |s: fn(&crate::Sample) -> Option<f64>| {
                        let value = |index: usize| s(&run.log.samples[index]).expect("seen");
                        (value(at) - value(at - 1)).abs()
                    };
                    // A jump that moves a contact by 4 mm or more is not overlooked.
                    if f64::max(step(|sample| sample.s1_m), step(|sample| sample.s2_m)) > 4e-3 {
                        jumps += 1;
                        assert!(cuts.contains(&at), "seed {seed}: the jump before sample {at}, cuts {cuts:?}");
                    }
                }
                assert!(cuts.len() <= run.jumps.len() + 2, "seed {seed}: {cuts:?} for {} jumps", run.jumps.len());
            }
        }
        assert!(jumps > 12, "{jumps}");
    }

    #[test]
    fn a_step_is_a_roll_where_both_steps_beside_it_come_near_it() {
        // A contact that rests, and moves by three steps in the middle; the slower of the outer ones decides.
        let pieces = |before_m: f64, after_m: f64| {
            let mut s_m = 0.03;
            let samples = (0..41).map(|index| {
                s_m += match index {
                    20 => before_m,
                    21 => 4e-3,
                    22 => after_m,
                    _ => 0.0,
                };
                crate::Sample::new(0.05 * f64::from(index), crate::palms::PalmPair::hinged(1.0, 1.2), s_m, 0.03)
            });
            let measurements = Measurements::new(&crate::Log { samples: samples.collect() }, None);
            segments(&measurements, 1e-9).len()
        };
        assert_eq!(pieces(1.1e-3, 1.1e-3), 3, "the outer steps are cut, the middle one is not");
        assert_eq!(pieces(0.9e-3, 1.1e-3), 4);
        assert_eq!(pieces(1.1e-3, 0.0), 3);
        assert_eq!(pieces(0.0, 0.0), 2);
    }

    #[test]
    fn segments_end_with_the_contacts() {
        let mut log = run(1, Touchpad::ideal()).log;
        log.samples[..5].iter_mut().for_each(|sample| sample.s1_m = None);
        let last = log.samples.len();
        log.samples[last - 7..].iter_mut().for_each(|sample| sample.s2_m = None);
        let measurements = Measurements::new(&log, None);
        let segments = segments(&measurements, 1e-6);
        assert_eq!((segments[0].start, segments[segments.len() - 1].end), (5, last - 7));
    }

    #[test]
    fn without_contacts_there_are_no_segments() {
        let mut log = run(1, Touchpad::ideal()).log;
        log.samples.iter_mut().for_each(|sample| sample.s1_m = None);
        assert!(segments(&Measurements::new(&log, None), 1e-6).is_empty());
        assert!(segments(&Measurements::new(&log, None).of(Vec::new()), 1e-6).is_empty());
    }
}
