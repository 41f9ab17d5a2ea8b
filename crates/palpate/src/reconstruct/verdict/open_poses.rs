//! What samples whose pose is open take from the certificate of a motion (`docs/theory.md`, the certificate). Those of a piece may be elsewhere with it, and
//! with them the boundary that only it felt. Of an object at rest a few single ones, beside jumps most often, are told by their own error bars.

use crate::estimate::motion::SHORT_SEGMENT;
use std::ops::Range;

/// Samples that are told by their own error bars alone, as a share of all: with more of them, a motion is not known.
const MOST_TOLD_ALONE: f64 = 0.01;

/// Runs of samples that may be elsewhere, `ambiguity_rad` away each; 0 is where a pose is known.
fn open_runs(ambiguity_rad: &[f64]) -> impl Iterator<Item = Range<usize>> {
    let mut end = 0;
    let runs = ambiguity_rad.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)).map(move |run| {
        end += run.len();
        (run[0] > 0.0, end - run.len()..end)
    });
    runs.filter_map(|(is_open, run)| is_open.then_some(run))
}

/// Whether so many samples are few enough to be told by their own error bars alone.
fn are_few(open: usize, samples: usize) -> bool {
    open as f64 <= MOST_TOLD_ALONE * samples as f64
}

/// The samples of pieces that may be elsewhere, where they and single ones are few: set aside, they tell nothing of the shape, and all else is as certain as
/// without them. None where there are more.
pub(crate) fn open_pieces(ambiguity_rad: &[f64]) -> Vec<Range<usize>> {
    let open: usize = open_runs(ambiguity_rad).map(|run| run.len()).sum();
    let pieces = open_runs(ambiguity_rad).filter(|run| run.len() >= SHORT_SEGMENT);
    if are_few(open, ambiguity_rad.len()) { pieces.collect() } else { Vec::new() }
}

/// By how much the motion may be wrong if the samples were elsewhere that are not told by their error bars alone: root mean square over all, radians.
/// `ambiguity_rad` is how far away each may be, 0 where its pose is known; `is_aside` says of which the shape knows nothing.
pub(crate) fn open_motion_rad(ambiguity_rad: &[f64], is_aside: impl Fn(usize) -> bool) -> f64 {
    let is_alone = |run: &Range<usize>| run.len() < SHORT_SEGMENT || run.clone().all(&is_aside);
    let alone: usize = open_runs(ambiguity_rad).filter(is_alone).map(|run| run.len()).sum();
    let few = are_few(alone, ambiguity_rad.len());
    let others = open_runs(ambiguity_rad).filter(|run| !(few && is_alone(run)));
    let squares = others.flatten().map(|sample| ambiguity_rad[sample].powi(2)).sum::<f64>();
    (squares / ambiguity_rad.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many samples in runs, of a thousand, each 2 radians off.
    fn with_open(runs: &[(usize, usize)]) -> Vec<f64> {
        let mut ambiguity_rad = vec![0.0; 1000];
        runs.iter().for_each(|&(first, count)| ambiguity_rad[first..first + count].fill(2.0));
        ambiguity_rad
    }

    #[test]
    fn a_few_single_samples_are_told_by_their_error_bars_and_a_piece_is_not() {
        let open = |runs: &[(usize, usize)]| open_motion_rad(&with_open(runs), |_| false);
        let of = |samples: usize| 2.0 * (samples as f64 / 1000.0).sqrt();
        let same = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(same(open(&[]), 0.0) && same(open_motion_rad(&[], |_| false), 0.0));
        assert!(same(open(&[(0, SHORT_SEGMENT - 1)]), 0.0) && same(open(&[(0, SHORT_SEGMENT)]), of(SHORT_SEGMENT)));
        // Ten of a thousand, and eleven.
        assert!(same(open(&[(100, 5), (200, 4), (999, 1)]), 0.0));
        assert!(same(open(&[(100, 5), (200, 4), (998, 2)]), of(11)));
        assert!(same(open(&[(100, 5), (200, 5), (300, 20)]), of(20)));
    }

    #[test]
    fn a_few_samples_of_a_piece_that_is_set_aside_are_told_by_their_error_bars() {
        let open = |runs: &[(usize, usize)], aside: Range<usize>| {
            open_motion_rad(&with_open(runs), |sample| aside.contains(&sample))
        };
        assert_eq!(open(&[(300, 10)], 300..310), 0.0);
        assert!(open(&[(300, 10)], 300..309) > 0.1 && open(&[(300, 11)], 300..311) > 0.1);
        assert_eq!(open_pieces(&with_open(&[(100, 3), (300, 7)])), std::slice::from_ref(&(300..307)));
        assert!(open_pieces(&with_open(&[(100, 4), (300, 7)])).is_empty());
        assert!(open_pieces(&with_open(&[(300, SHORT_SEGMENT - 1)])).is_empty());
    }
}
