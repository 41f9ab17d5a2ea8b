//! Where the log falls into pieces: places where a contact leaps further between two samples than the noise, its own pace
//! and the motion of the palms explain. Nothing of shape or orientation is needed. A cut too many costs a little work, a cut
//! too few spoils a piece, so the test is a keen one.

use std::ops::Range;

use super::noise::median;
use super::problem::Problem;

/// A contact that leaps by less than this many standard deviations of the noise is not believed to have leapt.
const NOISE_FACTOR: f64 = 8.0;

/// Leaps are at least this many times longer than the steps around them.
const PACE_FACTOR: f64 = 4.0;

/// Runs of neighbouring instants (index ranges) that saw both contacts, with no leap inside.
pub(super) fn pieces(problem: &Problem, scatter_m: f64) -> Vec<Range<usize>> {
    let seen: Vec<usize> = (0..problem.len()).filter(|&index| problem.instants[index].both_seen()).collect();
    let size_m = problem.size_m();
    let steps: Vec<[f64; 2]> = seen
        .windows(2)
        .map(|pair| {
            let (a, b) = (&problem.instants[pair[0]], &problem.instants[pair[1]]);
            [b.s1 - a.s1, b.s2 - a.s2]
        })
        .collect();
    let leaps = |index: usize| {
        let (a, b) = (&problem.instants[seen[index]], &problem.instants[seen[index + 1]]);
        let turn = (b.phi1 - a.phi1).abs() + (b.phi1 + b.phi2 - a.phi1 - a.phi2).abs();
        let around = index.saturating_sub(6)..(index + 7).min(steps.len());
        (0..2).any(|sensor| {
            let mut others: Vec<f64> =
                around.clone().filter(|&other| other != index).map(|other| steps[other][sensor]).collect();
            let usual = median(&mut others);
            others.iter_mut().for_each(|step| *step = step.abs());
            let pace = median(&mut others);
            (steps[index][sensor] - usual).abs() > NOISE_FACTOR * scatter_m + PACE_FACTOR * pace + 2.0 * size_m * turn
        })
    };
    let mut pieces = Vec::new();
    let mut start = 0;
    for index in 0..steps.len() {
        if leaps(index) {
            pieces.push(seen[start]..seen[index] + 1);
            start = index + 1;
        }
    }
    if let (Some(&first), Some(&last)) = (seen.get(start), seen.last()) {
        pieces.push(first..last + 1);
    }
    pieces
}
