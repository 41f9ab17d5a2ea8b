//! What is believed of the motion before the readings are seen, in nats: within a segment the contact moves on without leaps, and strokes
//! that begin after the object was lifted begin at its resting angle.

use std::ops::Range;

use crate::math::angle::wrapped;
use crate::math::statistics::median;
use crate::pivot::calibration::Reading;

/// A leap within a segment costs so much: it is rare, and no reading contradicts one, as a shape may have a loop of the curve (r, d) that
/// was not felt.
pub(super) const LEAP_NATS: f64 = 25.0;

/// Where the pivot is lifted off the pad it costs so much: the object hangs lower and lower on its contact until it tips over or swings free, at one in a
/// hundred of these samples or more. As dear as elsewhere, the last sample of a stroke would rather miss its reading by several standard deviations.
const LIFTED_LEAP_NATS: f64 = 5.0;

/// A step from one sample of a segment to the next that is longer than this, radians, and differs from that of the closed form by as much,
/// is a leap …
pub(super) const LEAP_RAD: f64 = 0.15;

/// … and where the object tips over by more than this share of it, which the quadrature may be off by over one step.
const LEAP_SHARE: f64 = 0.5;

/// … if the angles of so many samples before and after it, their medians, differ by as much: single ones scatter.
const SCATTER_REACH: usize = 4;

/// Samples between two leaps that may be one mistake.
const LONGEST_BRIDGE: usize = 20;

/// A stroke that begins elsewhere than most costs so much: an object that is lifted swings to rest with its centre of mass under the pivot, and where one
/// does not the shape must tell it.
const OTHER_START_NATS: f64 = 30.0;

/// Strokes begin at the same angle when it differs by less than this, radians: a touch may move the contact by as much.
const SAME_START_RAD: f64 = 0.15;

/// Height or offset leap where they change by so many times what they change by at each of the samples nearby …
const TIPS_OVER_TIMES: f64 = 2.0;

/// … of which so many on either side count, but for the next …
const TIPS_OVER_REACH: usize = 5;

/// … and by at least so much of the object's size: height and offset.
const TIPS_OVER_SHARES: [f64; 2] = [0.01, 0.03];

/// The height of a pivot that is lifted grows from sample to sample by more than so many of its standard deviations.
const LIFTED_SDS: f64 = 6.0;

/// Whether height or offset leap up to each sample.
pub(super) fn tips_over(r_m: &[f64], d_m: &[f64], size_m: f64) -> Vec<bool> {
    let leaps = |values: &[f64], share: f64| -> Vec<bool> {
        let steps: Vec<f64> = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
        let leap = |step: usize| {
            let before = &steps[step.saturating_sub(TIPS_OVER_REACH + 1)..step.saturating_sub(1)];
            let after = steps.get(step + 2..(step + TIPS_OVER_REACH + 2).min(steps.len())).unwrap_or(&[]);
            let nearby = before.iter().chain(after).copied().fold(0.0, f64::max);
            steps[step] > (TIPS_OVER_TIMES * nearby).max(share * size_m)
        };
        (0..steps.len()).map(leap).collect()
    };
    let [r_share, d_share] = TIPS_OVER_SHARES;
    let either = leaps(r_m, r_share).into_iter().zip(leaps(d_m, d_share)).map(|(r, d)| r || d);
    std::iter::once(false).chain(either).take(r_m.len()).collect()
}

/// Whether the pivot is lifted off the pad up to each sample: away from it by more than the noise of its height, and more than along it. An object that
/// hangs lower and lower on its contact tips over to another one in the end, or swings free.
pub(super) fn lifted(readings: &[Reading], height_sd_m: f64) -> Vec<bool> {
    let is_lifted = |pair: &[Reading]| {
        let (up_m, along_m) = (pair[1].above_m - pair[0].above_m, pair[1].along_m - pair[0].along_m);
        up_m > LIFTED_SDS * height_sd_m && up_m > along_m.abs()
    };
    std::iter::once(false).chain(readings.windows(2).map(is_lifted)).take(readings.len()).collect()
}

/// What a leap costs where the pivot is lifted, or not.
pub(super) fn leap_nats(is_lifted: bool) -> f64 {
    if is_lifted { LIFTED_LEAP_NATS } else { LEAP_NATS }
}

/// Segments of a log, and which of them begin after the object was lifted.
#[derive(Clone, Debug)]
pub(super) struct MotionPrior {
    pub ranges: Vec<Range<usize>>,
    pub begins_at_rest: Vec<bool>,
    /// Contact angles by two closed forms, each up to a constant of its segment: through crossings of d = 0 by rolling, and by parabolas.
    pub relative_rad: [Vec<f64>; 2],
    /// Whether height or offset leap as well up to each sample: the object tips over.
    pub tips_over: Vec<bool>,
    /// Whether the pivot is lifted up to each sample.
    pub lifted: Vec<bool>,
}

impl MotionPrior {
    /// −ln of the prior of a motion, up to a constant.
    pub fn cost(&self, theta_rad: &[f64]) -> f64 {
        self.leaps(theta_rad).map(|index| self.leap_nats(index)).sum::<f64>()
            + OTHER_START_NATS * self.other_starts(theta_rad) as f64
    }

    /// What a leap up to a sample costs.
    pub fn leap_nats(&self, index: usize) -> f64 {
        leap_nats(self.lifted[index])
    }

    /// The samples at which the contact arrives by a leap that nothing explains: the object is not lifted.
    pub fn unexplained_leaps<'a>(&'a self, theta_rad: &'a [f64]) -> impl Iterator<Item = usize> + 'a {
        self.leaps(theta_rad).filter(|&index| !self.lifted[index])
    }

    /// The samples of segments at which the contact arrives by a leap.
    pub fn leaps<'a>(&'a self, theta_rad: &'a [f64]) -> impl Iterator<Item = usize> + 'a {
        let samples = self.ranges.iter().flat_map(|range| range.clone().skip(1));
        samples.filter(|&index| self.is_leap(theta_rad, index))
    }

    /// Whether the step that ends at a sample, of the same segment as the one before it, is a leap that the readings do not make.
    fn is_leap(&self, theta_rad: &[f64], index: usize) -> bool {
        self.is_break(theta_rad, index) && !self.tips_over[index] && self.stays(theta_rad, index)
    }

    /// Whether what lies beyond a step is elsewhere for longer than a sample or two: where readings hardly tell an angle it scatters.
    fn stays(&self, theta_rad: &[f64], index: usize) -> bool {
        let Some(range) = self.ranges.iter().find(|range| range.contains(&index)) else { return false };
        let off = |relative: &[f64]| {
            let side =
                |places: Range<usize>| median(&mut places.map(|at| theta_rad[at] - relative[at]).collect::<Vec<f64>>());
            let before = side(index.saturating_sub(SCATTER_REACH).max(range.start)..index);
            let after = side(index..(index + SCATTER_REACH).min(range.end));
            (after - before).abs()
        };
        self.relative_rad.iter().all(|relative| off(relative) > LEAP_RAD)
    }

    /// The same angles where what lies between two leaps soon after each other follows its neighbours at less cost than the two leaps. `cost` is that of
    /// a sample at an angle, and the angle next to it that costs least.
    pub fn bridged(&self, theta_rad: &[f64], cost: &dyn Fn(usize, f64) -> (f64, f64)) -> Option<Vec<f64>> {
        let mut bridged = theta_rad.to_vec();
        let mut any = false;
        for range in &self.ranges {
            let breaks: Vec<usize> =
                range.clone().skip(1).filter(|&at| self.is_break(theta_rad, at) && !self.tips_over[at]).collect();
            for pair in breaks.windows(2) {
                let (first, next) = (pair[0], pair[1]);
                if next - first > LONGEST_BRIDGE || bridged[first] != theta_rad[first] {
                    continue;
                }
                let (from, to) = (bridged[first - 1], bridged[next]);
                let line = |at: usize| from + (to - from) * (at + 1 - first) as f64 / (next + 1 - first) as f64;
                let there: Vec<(f64, f64)> = (first..next).map(|at| cost(at, line(at))).collect();
                let more: f64 = (first..next).zip(&there).map(|(at, there)| there.0 - cost(at, theta_rad[at]).0).sum();
                let is_near = |(at, there): (usize, &(f64, f64))| (there.1 - line(at)).abs() < LEAP_RAD;
                if more < 2.0 * LEAP_NATS && (first..next).zip(&there).all(is_near) {
                    (first..next).zip(there).for_each(|(at, there)| bridged[at] = there.1);
                    any = true;
                }
            }
        }
        any.then_some(bridged)
    }

    /// Whether the step that ends at a sample, of the same segment as the one before it, is none that the closed form makes.
    pub fn is_break(&self, theta_rad: &[f64], index: usize) -> bool {
        let step = |angles: &[f64]| angles[index] - angles[index - 1];
        if step(theta_rad).abs() <= LEAP_RAD {
            return false;
        }
        let differs = |expected: f64| (step(theta_rad) - expected).abs() > LEAP_RAD + LEAP_SHARE * expected.abs();
        self.relative_rad.iter().all(|relative| differs(step(relative)))
    }

    /// Strokes that do not begin where most do.
    pub fn other_starts(&self, theta_rad: &[f64]) -> usize {
        let starts: Vec<f64> = self
            .ranges
            .iter()
            .zip(&self.begins_at_rest)
            .filter(|(range, rests)| **rests && !range.is_empty())
            .map(|(range, _)| theta_rad[range.start])
            .collect();
        let near = |start: f64| starts.iter().filter(|other| wrapped(start - **other).abs() < SAME_START_RAD).count();
        starts.len() - starts.iter().map(|start| near(*start)).max().unwrap_or(0)
    }

    /// The same angles with the leaps within segments taken out: the longest piece of each stays, and the steps are those of the
    /// closed form. `None` without a leap.
    pub fn without_leaps(&self, theta_rad: &[f64]) -> Option<Vec<f64>> {
        self.leaps(theta_rad).next()?;
        let mut restored = theta_rad.to_vec();
        for range in &self.ranges {
            let own = &theta_rad[range.clone()];
            let is_cut = |index: usize| self.is_leap(theta_rad, range.start + index);
            // How far the angles before each sample must be moved for it to follow.
            let mut moved = vec![0.0; own.len()];
            let mut by = 0.0;
            let mut pieces = vec![(0, 0.0)];
            for index in 1..own.len() {
                if is_cut(index) {
                    let step =
                        self.relative_rad[0][range.start + index] - self.relative_rad[0][range.start + index - 1];
                    by += step - (own[index] - own[index - 1]);
                    pieces.push((index, by));
                }
                moved[index] = by;
            }
            let length = |place: usize| pieces.get(place + 1).map_or(own.len(), |(next, _)| *next) - pieces[place].0;
            let anchor = (0..pieces.len()).max_by_key(|&place| length(place)).map_or(0.0, |place| pieces[place].1);
            for (index, moved) in moved.into_iter().enumerate() {
                restored[range.start + index] += moved - anchor;
            }
        }
        Some(restored)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn prior() -> MotionPrior {
        let relative_rad = vec![0.0, 0.1, 0.2, 0.3, 0.0, 0.1, 0.0, 0.1];
        MotionPrior {
            ranges: vec![0..4, 4..6, 6..8],
            begins_at_rest: vec![true; 3],
            relative_rad: [relative_rad.clone(), relative_rad],
            tips_over: vec![false; 8],
            lifted: vec![false; 8],
        }
    }

    #[test]
    fn leaps_and_other_starts_cost() {
        let least = LEAP_RAD + LEAP_SHARE * 0.1;
        let step = 0.1 + 0.99 * least;
        let calm = [0.0, step, 2.0 * step, 2.0 * step, 0.0, step, 0.99 * SAME_START_RAD, 0.2];
        assert_eq!(prior().cost(&calm), 0.0);
        let mut leapt = calm;
        leapt[2] += 0.02 * least;
        assert_eq!(prior().cost(&leapt), LEAP_NATS);
        // A step that the closed form makes and the motion does not is none.
        let mut calmer = calm;
        calmer[3] = calm[2] - 0.99 * LEAP_RAD;
        assert_eq!(prior().cost(&calmer), 0.0);
        let mut elsewhere = calm;
        elsewhere[6] = 1.01 * SAME_START_RAD;
        assert_eq!(prior().cost(&elsewhere), OTHER_START_NATS);
        let tipped = MotionPrior { tips_over: vec![true; 8], ..prior() };
        assert_eq!(tipped.cost(&leapt), 0.0);
        let held = MotionPrior { begins_at_rest: vec![true, true, false], ..prior() };
        assert_eq!(held.cost(&elsewhere), 0.0);
        // Where the object is lifted a leap is less rare, and no riddle.
        let lifted = MotionPrior { lifted: vec![true; 8], ..prior() };
        assert_eq!(lifted.cost(&leapt), LIFTED_LEAP_NATS);
        assert_eq!((prior().unexplained_leaps(&leapt).count(), lifted.unexplained_leaps(&leapt).count()), (1, 0));
    }

    /// A segment that rolls steadily, by both closed forms.
    fn steady(samples: usize) -> (MotionPrior, Vec<f64>) {
        let theta: Vec<f64> = (0..samples).map(|index| 0.02 * index as f64).collect();
        let prior = MotionPrior {
            ranges: std::iter::once(0..samples).collect(),
            begins_at_rest: vec![true],
            relative_rad: [theta.clone(), theta.clone()],
            tips_over: vec![false; samples],
            lifted: vec![false; samples],
        };
        (prior, theta)
    }

    #[test]
    fn single_angles_scatter_and_do_not_leap() {
        let off = |samples: usize| {
            let (prior, mut theta) = steady(40);
            theta[20..20 + samples].iter_mut().for_each(|theta| *theta += 0.5);
            prior.leaps(&theta).count()
        };
        // The median of the four on either side does not see one of them, and is one of them when all four are.
        assert_eq!((off(1), off(SCATTER_REACH / 2 - 1), off(SCATTER_REACH)), (0, 0, 2));
    }

    #[test]
    fn what_lies_between_two_leaps_follows_its_neighbours_where_that_costs_less_than_they_do() {
        let bridged = |samples: usize, nats: f64| {
            let (prior, straight) = steady(60);
            let mut theta = straight.clone();
            theta[20..20 + samples].iter_mut().for_each(|theta| *theta += 0.5);
            let on_line = |index: usize, angle: f64| (angle - straight[index]).abs() < 0.1;
            let cost = |index, angle| (if on_line(index, angle) { nats } else { 0.0 }, angle);
            let found = prior.bridged(&theta, &cost);
            found.map(|found| found.iter().zip(&straight).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max))
        };
        assert!(bridged(5, 0.99 * 2.0 * LEAP_NATS / 5.0).is_some_and(|off| off < 1e-12));
        assert_eq!(bridged(5, 1.01 * 2.0 * LEAP_NATS / 5.0), None);
        assert!(bridged(LONGEST_BRIDGE, 0.0).is_some() && bridged(LONGEST_BRIDGE + 1, 0.0).is_none());
    }

    #[test]
    fn a_pivot_that_goes_up_more_than_along_is_lifted() {
        let reading = |along_m: f64, above_m: f64| Reading { along_m, above_m, s_m: 0.0 };
        let is_lifted =
            |along_m: f64, above_m: f64| lifted(&[reading(0.1, 0.03), reading(0.1 + along_m, 0.03 + above_m)], 1e-5)[1];
        assert!(is_lifted(0.0, 1.01e-5 * LIFTED_SDS) && !is_lifted(0.0, 0.99e-5 * LIFTED_SDS));
        assert!(is_lifted(-9.9e-4, 1e-3) && !is_lifted(-1.01e-3, 1e-3) && !is_lifted(0.0, -1e-3));
        assert!(lifted(&[], 1e-5).is_empty());
    }

    #[test]
    fn an_object_that_tips_over_shows_it() {
        let rolling: Vec<f64> = (0..30).map(|index| 1e-4 * f64::from(index)).collect();
        let leapt = |by: f64| {
            let leap = |(index, r): (usize, &f64)| r + if index < 13 { 0.0 } else { by };
            rolling.iter().enumerate().map(leap).collect::<Vec<f64>>()
        };
        let found = |r: &[f64], size_m: f64| -> Vec<usize> {
            let tips = tips_over(r, &[0.0; 30], size_m);
            (0..30).filter(|&index| tips[index]).collect()
        };
        // Against what is nearby.
        assert!(found(&leapt((0.99 * TIPS_OVER_TIMES - 1.0) * 1e-4), 1e-3).is_empty());
        assert_eq!(found(&leapt((1.01 * TIPS_OVER_TIMES - 1.0) * 1e-4), 1e-3), [13]);
        // Against the size.
        assert!(found(&leapt(0.99 * TIPS_OVER_SHARES[0] * 0.1 - 1e-4), 0.1).is_empty());
        assert_eq!(found(&leapt(1.01 * TIPS_OVER_SHARES[0] * 0.1 - 1e-4), 0.1), [13]);
        assert!(tips_over(&[], &[], 1.0).is_empty());
    }

    #[test]
    fn leaps_are_taken_out_and_the_longest_piece_stays() {
        let theta = [5.0, 1.1, 1.2, 1.3, 2.0, 2.1, 2.0, 2.1];
        let restored = prior().without_leaps(&theta).expect("there is one");
        let expected = [1.0, 1.1, 1.2, 1.3, 2.0, 2.1, 2.0, 2.1];
        assert!(restored.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{restored:?}");
        assert_eq!(prior().without_leaps(&restored), None);
    }
}
