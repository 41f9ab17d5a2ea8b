//! What samples whose pose is open take from the certificate of a motion (`docs/theory.md`, the certificate). Those of a piece may be elsewhere with it, and
//! with them the boundary that only it felt. Of an object at rest a few single ones, beside jumps most often, are told by their own error bars.

use crate::estimate::motion::SHORT_SEGMENT;

/// Samples in runs too short for a piece, as a share of all, that are told by their own error bars alone: with more of them, a motion is not known.
const MOST_SINGLE: f64 = 0.01;

/// By how much the motion may be wrong if the samples were elsewhere that are not told by their error bars alone: root mean square over all, radians.
/// `ambiguity_rad` is how far away each may be, 0 where its pose is known.
pub(crate) fn open_motion_rad(ambiguity_rad: &[f64]) -> f64 {
    let runs = || ambiguity_rad.chunk_by(|a, b| (*a > 0.0) == (*b > 0.0)).filter(|run| run[0] > 0.0);
    let is_short = |run: &&[f64]| run.len() < SHORT_SEGMENT;
    let single: usize = runs().filter(is_short).map(<[f64]>::len).sum();
    let few = single as f64 <= MOST_SINGLE * ambiguity_rad.len() as f64;
    let squares = runs().filter(|run| !(few && is_short(run))).flatten().map(|rad| rad * rad).sum::<f64>();
    (squares / ambiguity_rad.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_single_samples_are_told_by_their_error_bars_and_a_piece_is_not() {
        let open = |runs: &[(usize, usize)]| {
            let mut ambiguity_rad = vec![0.0; 1000];
            runs.iter().for_each(|&(first, count)| ambiguity_rad[first..first + count].fill(2.0));
            open_motion_rad(&ambiguity_rad)
        };
        let of = |samples: usize| 2.0 * (samples as f64 / 1000.0).sqrt();
        let same = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(same(open(&[]), 0.0) && same(open_motion_rad(&[]), 0.0));
        assert!(same(open(&[(0, SHORT_SEGMENT - 1)]), 0.0) && same(open(&[(0, SHORT_SEGMENT)]), of(SHORT_SEGMENT)));
        // Ten of a thousand, and eleven.
        assert!(same(open(&[(100, 5), (200, 4), (999, 1)]), 0.0));
        assert!(same(open(&[(100, 5), (200, 4), (998, 2)]), of(11)));
        assert!(same(open(&[(100, 5), (200, 5), (300, 20)]), of(20)));
    }
}
