//! Stretches of a log within which the contact moved without a break: between two strokes the object was lifted, and a leap to another
//! contact leaves a step in height or offset, longer than those around it.

use std::ops::Range;

use crate::math::statistics::median;

/// A step of height or offset that is this many times longer than most of the log's is a leap.
const LEAP_TIMES: f64 = 8.0;

/// Shortest leap, as a share of the object's size: shorter ones are motions that the closed form follows.
const SHORTEST_LEAP: f64 = 0.04;

/// It is longer than those of so many samples on either side as well, by so many times: a pivot that is lifted moves fast, sample by sample.
const NEARBY: usize = 3;
const NEARBY_TIMES: f64 = 2.0;

/// Samples without a contact, in a row, that are a lift: the pad may miss fewer.
pub(super) const LIFTED_SAMPLES: usize = 3;

/// Fewest samples of a segment that is used by itself.
pub(super) const FEWEST: usize = 8;

/// Where segments are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cuts {
    /// At long steps that stand out among those nearby: leaps.
    AtLeaps,
    /// At all long steps: an object that turns fast may tip over among them, unseen.
    AtLongSteps,
}

/// Segments of the samples with a contact. `samples` are their numbers in the log, `r_m` and `d_m` height and offset.
pub(super) fn segments(samples: &[usize], [r_m, d_m]: [&[f64]; 2], size_m: f64, at: Cuts) -> Vec<Range<usize>> {
    let steps = |values: &[f64]| -> Vec<f64> { values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect() };
    let (r_steps, d_steps) = (steps(r_m), steps(d_m));
    let limit = |steps: &[f64]| (LEAP_TIMES * median(&mut steps.to_vec())).max(SHORTEST_LEAP * size_m);
    let (r_limit, d_limit) = (limit(&r_steps), limit(&d_steps));
    let nearby = if at == Cuts::AtLeaps { NEARBY } else { 0 };
    let mut cuts = vec![0];
    for index in 1..samples.len() {
        let lifted = samples[index] > samples[index - 1] + LIFTED_SAMPLES;
        if lifted || is_leap(&r_steps, index - 1, r_limit, nearby) || is_leap(&d_steps, index - 1, d_limit, nearby) {
            cuts.push(index);
        }
    }
    cuts.push(samples.len());
    cuts.windows(2).map(|pair| pair[0]..pair[1]).filter(|range| range.len() >= FEWEST).collect()
}

/// Whether a step is a leap: longer than `limit`, and than those of so many samples on either side.
fn is_leap(steps: &[f64], step: usize, limit: f64, nearby: usize) -> bool {
    let before = &steps[step.saturating_sub(nearby)..step];
    let after = &steps[step + 1..(step + 1 + nearby).min(steps.len())];
    let nearby = before.iter().chain(after).copied().fold(0.0, f64::max);
    steps[step] > limit.max(NEARBY_TIMES * nearby)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rolling(count: usize) -> (Vec<f64>, Vec<f64>) {
        let r = |i: usize| 0.03 + 0.002 * (0.03 * i as f64).sin();
        ((0..count).map(r).collect(), (0..count).map(|i| -0.002 * (0.03 * i as f64).cos()).collect())
    }

    #[test]
    fn a_lift_and_a_leap_end_a_segment_and_a_short_step_does_not() {
        let (r, d) = rolling(90);
        let mut samples: Vec<usize> = (0..90).collect();
        assert_eq!(segments(&samples, [&r, &d], 0.03, Cuts::AtLeaps), vec![0..90]);
        samples[40..].iter_mut().for_each(|sample| *sample += LIFTED_SAMPLES - 1);
        assert_eq!(segments(&samples, [&r, &d], 0.03, Cuts::AtLeaps), vec![0..90]);
        samples[40..].iter_mut().for_each(|sample| *sample += 1);
        assert_eq!(segments(&samples, [&r, &d], 0.03, Cuts::AtLeaps), vec![0..40, 40..90]);
        let mut leapt = r.clone();
        leapt[60..].iter_mut().for_each(|r| *r -= 1.1 * SHORTEST_LEAP * 0.03);
        assert_eq!(segments(&samples, [&leapt, &d], 0.03, Cuts::AtLeaps), vec![0..40, 40..60, 60..90]);
        let mut stepped = r.clone();
        stepped[60..].iter_mut().for_each(|r| *r -= 0.9 * SHORTEST_LEAP * 0.03);
        assert_eq!(segments(&samples, [&stepped, &d], 0.03, Cuts::AtLeaps), vec![0..40, 40..90]);
    }

    #[test]
    fn fast_motion_is_one_segment_and_a_leap_within_it_is_none() {
        let (r, d) = rolling(60);
        let samples: Vec<usize> = (0..60).collect();
        let step_m = 2.0 * SHORTEST_LEAP * 0.03;
        let fast = |leap: f64| -> Vec<f64> {
            let times = |index: usize| if index == 52 { leap } else { 1.0 };
            let up_m = |index: usize| (46..=index).map(|index| step_m * times(index)).sum::<f64>();
            r.iter().enumerate().map(|(index, r)| r + up_m(index)).collect()
        };
        let lifted = |leap: f64| segments(&samples, [&fast(leap), &d], 0.03, Cuts::AtLeaps);
        assert_eq!(lifted(1.0), vec![0..60]);
        assert_eq!(lifted(0.95 * NEARBY_TIMES), vec![0..60]);
        assert_eq!(lifted(1.05 * NEARBY_TIMES), vec![0..52, 52..60]);
        assert_eq!(segments(&samples, [&fast(1.0), &d], 0.03, Cuts::AtLongSteps), vec![0..46]);
        // Only the nearest steps count.
        let far = |fast: usize| {
            let up_m = |index: usize| if (fast..fast + 2).contains(&index) { step_m } else { 0.0 };
            let r: Vec<f64> = r
                .iter()
                .enumerate()
                .map(|(index, r)| r + up_m(index) + if index < 30 { 0.0 } else { 1.1 * step_m })
                .collect();
            segments(&samples, [&r, &d], 0.03, Cuts::AtLeaps).iter().any(|range| range.start == 30)
        };
        assert!(!far(30 + NEARBY - 1) && far(30 + NEARBY + 2));
    }

    #[test]
    fn what_is_too_short_is_left_out() {
        let (r, d) = rolling(30);
        let mut samples: Vec<usize> = (0..30).collect();
        samples[FEWEST - 1..].iter_mut().for_each(|sample| *sample += LIFTED_SAMPLES);
        assert_eq!(segments(&samples, [&r, &d], 0.03, Cuts::AtLeaps), vec![FEWEST - 1..30]);
    }
}
