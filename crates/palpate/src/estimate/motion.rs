//! Motions of the object, sample by sample: unwrapping, outlying steps, comparison up to a common rotation, short segments.

use crate::math::angle::{mean_direction, wrapped_to};
use crate::math::statistics::median;
use std::f64::consts::TAU;
use std::ops::Range;

/// Largest turn from one sample to the next without a jump, radians: far above what slow palms turn an object by within one
/// sample, and below the turn of most jumps.
pub(crate) const LONGEST_STEP: f64 = 0.15;

/// A turn by less than this between two samples never stands out, radians: noise alone turns a pose as far.
pub(crate) const SMALLEST_STEP: f64 = 0.02;

/// A step stands out when it turns the object this many times further than the median step around it.
const CONTRAST: f64 = 3.0;

/// Steps on each side that a step is compared with: the pace of the object is taken to be even over them.
const STEPS_AROUND: usize = 25;

/// Brings angles of neighbouring samples within half a turn of each other.
pub(crate) fn unwrap(psi: &mut [f64]) {
    unwrap_to(psi, TAU);
}

/// The same where poses that differ by a multiple of `period` are one: within half a period.
pub(crate) fn unwrap_to(psi: &mut [f64], period: f64) {
    for index in 1..psi.len() {
        let turns = ((psi[index] - psi[index - 1]) / period).round();
        psi[index] -= turns * period;
    }
}

/// Steps of ψ (index of the sample after) that stand out from those around them.
pub(crate) fn outlying_steps(psi: &[f64]) -> Vec<usize> {
    let steps: Vec<f64> = psi.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    (0..steps.len())
        .filter(|&index| steps[index] > SMALLEST_STEP)
        .filter(|&index| {
            let around = index.saturating_sub(STEPS_AROUND)..(index + STEPS_AROUND + 1).min(steps.len());
            let mut others: Vec<f64> = around.filter(|&other| other != index).map(|other| steps[other]).collect();
            steps[index] > CONTRAST * median(&mut others)
        })
        .map(|index| index + 1)
        .collect()
}

/// The rotation that brings the motion `b` closest to `a`, radians; poses that differ by a multiple of `period` are one.
pub(crate) fn common_rotation(a: &[f64], b: &[f64], period: f64) -> f64 {
    let times = TAU / period;
    mean_direction(a.iter().zip(b).map(|(a, b)| times * (a - b))) / times
}

/// Number of samples that two motions have at different poses, up to a common rotation and multiples of `period`.
pub(crate) fn moved(a: &[f64], b: &[f64], period: f64) -> usize {
    let turned = common_rotation(a, b, period);
    a.iter().zip(b).filter(|(a, b)| wrapped_to(*a - *b - turned, period).abs() > ELSEWHERE).count()
}

/// The angle from which on poses count as different, radians: 5.7 degrees, more than a fit moves a pose that keeps its minimum.
pub(crate) const ELSEWHERE: f64 = 0.1;

/// Mean of 1 − cos of the differences up to which two motions are the same: that of 3 degrees.
const SAME_MOTION: f64 = 1.4e-3;

/// Whether two motions over the same instants are the same, up to a common rotation and multiples of `period`.
pub(crate) fn same_motion(a: &[f64], b: &[f64], period: f64) -> bool {
    let turned = common_rotation(a, b, period);
    let apart = |(a, b): (&f64, &f64)| 1.0 - wrapped_to(a - b - turned, period).cos();
    let mean = a.iter().zip(b).map(apart).sum::<f64>() / a.len().max(1) as f64;
    mean < SAME_MOTION
}

/// Segments with fewer samples than this are short: their own contacts do not determine their pose, since a fit adapts the shape
/// to them.
pub(crate) const SHORT_SEGMENT: usize = 6;

/// Samples at each end of a log whose poses nothing before them, or behind them, confirms.
const END: usize = 60;

/// The steps that stand out most in the first and in the last run of steps that stand out (index of the sample after).
pub(crate) fn end_steps(psi: &[f64], period: f64) -> [Option<usize>; 2] {
    let mut unwrapped = psi.to_vec();
    unwrap_to(&mut unwrapped, period);
    let turn = |step: usize| (unwrapped[step] - unwrapped[step - 1]).abs();
    let steps = outlying_steps(&unwrapped);
    let mut runs = steps.chunk_by(|step, next| step + 1 == *next);
    let longest = |run: &[usize]| run.iter().copied().max_by(|a, b| turn(*a).total_cmp(&turn(*b)));
    [runs.clone().next(), runs.next_back()].map(|run| run.and_then(longest))
}

/// Samples at which a piece begins that may be at another pose: after each jump, and after the step that stands out most in the first and in the last
/// run of such steps, where these are at the ends of the log. Such a step may be a jump: beside boundary that nothing else felt, a fit can join
/// what is beyond it by a shape of its own.
pub(crate) fn piece_starts(jumps: &[usize], psi: &[f64], period: f64) -> Vec<usize> {
    let [first, last] = end_steps(psi, period);
    let first = first.filter(|step| *step < END);
    let last = last.filter(|step| *step + END > psi.len());
    let mut starts: Vec<usize> = jumps.iter().copied().chain(first).chain(last).collect();
    starts.sort_unstable();
    starts.dedup();
    starts
}

/// The segments between `starts`, the samples at which a segment other than the first begins.
pub(crate) fn segments_between(starts: &[usize], samples: usize) -> impl Iterator<Item = Range<usize>> {
    let ends = starts.iter().copied().chain([samples]);
    std::iter::once(0).chain(starts.iter().copied()).zip(ends).map(|(start, end)| start..end.max(start))
}

/// The short ones of them; none where there is but one.
pub(crate) fn short_segments(starts: &[usize], samples: usize) -> Vec<Range<usize>> {
    if starts.is_empty() {
        return Vec::new();
    }
    segments_between(starts, samples).filter(|segment| segment.len() < SHORT_SEGMENT).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_stands_out_and_a_steady_turn_does_not() {
        let mut psi: Vec<f64> = (0..100).map(|i| 0.05 * i as f64).collect();
        assert!(outlying_steps(&psi).is_empty());
        psi[40..].iter_mut().for_each(|psi| *psi += 0.8);
        assert_eq!(outlying_steps(&psi), [40]);
    }

    #[test]
    fn a_step_at_an_end_of_a_log_begins_a_piece_and_one_in_its_middle_does_not() {
        let mut psi: Vec<f64> = (0..300).map(|i| 0.01 * i as f64).collect();
        for step in [11, 150, 290] {
            psi[step..].iter_mut().for_each(|psi| *psi += 0.1);
        }
        assert_eq!(piece_starts(&[200, 290], &psi, TAU), [11, 200, 290]);
        psi[100..].iter_mut().for_each(|psi| *psi += TAU);
        assert_eq!(piece_starts(&[], &psi, TAU), [11, 290]);
        assert_eq!(piece_starts(&[], &psi[..80], TAU), [11]);
        assert_eq!(piece_starts(&[70], &psi[12..], TAU), [70, 278]);
        // Of neighbouring steps that stand out, the longest.
        psi[10..].iter_mut().for_each(|psi| *psi += 0.05);
        psi[12..].iter_mut().for_each(|psi| *psi -= 0.07);
        assert_eq!(outlying_steps(&psi[..80]), [10, 11, 12]);
        assert_eq!(piece_starts(&[], &psi[..80], TAU), [11]);
    }

    #[test]
    fn unwrapping_leaves_no_step_over_half_a_turn() {
        let mut psi = vec![3.0, -3.0, 3.1, 9.5];
        unwrap(&mut psi);
        assert!(psi.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= std::f64::consts::PI));
    }
}
