//! Motions of the object, sample by sample: unwrapped, cut into segments at their jumps, held against each other up to a common rotation.

use crate::math::angle::mean_direction;
use crate::math::statistics::median;
use std::ops::Range;

/// A turn by less than this between two samples is never looked at, radians.
pub(crate) const SMALLEST_STEP: f64 = 0.02;

/// A step is looked at when it turns the object this many times further than the steps around it.
const CONTRAST: f64 = 3.0;

/// Brings angles of neighbouring samples within half a turn of each other.
pub(crate) fn unwrap(psi: &mut [f64]) {
    for index in 1..psi.len() {
        let turns = ((psi[index] - psi[index - 1]) / std::f64::consts::TAU).round();
        psi[index] -= turns * std::f64::consts::TAU;
    }
}

/// Steps of ψ (index of the sample after) that stand out from those around them.
pub(crate) fn outlying_steps(psi: &[f64]) -> Vec<usize> {
    let steps: Vec<f64> = psi.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    (0..steps.len())
        .filter(|&index| steps[index] > SMALLEST_STEP)
        .filter(|&index| {
            let around = index.saturating_sub(25)..(index + 26).min(steps.len());
            let mut others: Vec<f64> = around.filter(|&other| other != index).map(|other| steps[other]).collect();
            steps[index] > CONTRAST * median(&mut others)
        })
        .map(|index| index + 1)
        .collect()
}

/// The rotation that brings the motion `b` closest to `a`, radians.
pub(crate) fn common_rotation(a: &[f64], b: &[f64]) -> f64 {
    mean_direction(a.iter().zip(b).map(|(a, b)| a - b))
}

/// Samples that two motions put at different poses, but for a common rotation.
pub(crate) fn moved(a: &[f64], b: &[f64]) -> usize {
    let turned = common_rotation(a, b);
    a.iter().zip(b).filter(|(a, b)| (0.5 * (*a - *b - turned)).sin().abs() > ELSEWHERE).count()
}

/// Sine of half the angle between poses that count as different.
pub(crate) const ELSEWHERE: f64 = 0.05;

/// Whether two motions over the same instants are one, but for a common rotation.
pub(crate) fn same_motion(a: &[f64], b: &[f64]) -> bool {
    let turned = common_rotation(a, b);
    let apart = |(a, b): (&f64, &f64)| 1.0 - (a - b - turned).cos();
    let mean = a.iter().zip(b).map(apart).sum::<f64>() / a.len().max(1) as f64;
    // 1 − cos of 3 degrees.
    mean < 1.4e-3
}

/// Pieces with fewer samples than this are not placed by their own contacts alone.
pub(crate) const SHORT_SEGMENT: usize = 6;

/// The pieces, between the samples `starts` at which one begins besides the first, that are too short.
pub(crate) fn short_segments(starts: &[usize], samples: usize) -> Vec<Range<usize>> {
    if starts.is_empty() {
        return Vec::new();
    }
    let mut edges = vec![0];
    edges.extend(starts);
    edges.push(samples);
    edges
        .windows(2)
        .filter(|edge| edge[1] < edge[0] + SHORT_SEGMENT)
        .map(|edge| edge[0]..edge[1].max(edge[0]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leap_stands_out_and_a_steady_turn_does_not() {
        let mut psi: Vec<f64> = (0..100).map(|i| 0.05 * i as f64).collect();
        assert!(outlying_steps(&psi).is_empty());
        psi[40..].iter_mut().for_each(|psi| *psi += 0.8);
        assert_eq!(outlying_steps(&psi), [40]);
    }

    #[test]
    fn unwrapping_leaves_no_step_over_half_a_turn() {
        let mut psi = vec![3.0, -3.0, 3.1, 9.5];
        unwrap(&mut psi);
        assert!(psi.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= std::f64::consts::PI));
    }
}
