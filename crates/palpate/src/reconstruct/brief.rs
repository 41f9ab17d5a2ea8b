//! Pieces of a few samples between two jumps. The shape gives way to them, so that they always seem well placed; whether they
//! are must be asked of the shape that all other samples leave.

use std::ops::Range;

use rayon::prelude::*;

use super::evidence::Fit;
use super::known::Known;
use super::problem::Problem;

/// Pieces with fewer samples than this are not placed by their own contacts alone.
const BRIEF: usize = 6;

/// With more samples than this in brief pieces, none of them counts as placed.
const MOST: usize = 60;

/// The pieces, between the samples `starts` at which one begins besides the first, that are too short.
pub(super) fn brief_pieces(starts: &[usize], samples: usize) -> Vec<Range<usize>> {
    if starts.is_empty() {
        return Vec::new();
    }
    let mut edges = vec![0];
    edges.extend(starts);
    edges.push(samples);
    edges.windows(2).filter(|edge| edge[1] < edge[0] + BRIEF).map(|edge| edge[0]..edge[1].max(edge[0])).collect()
}

/// For each sample of a brief piece, by how much another orientation is less likely for the sample of the piece that tells
/// most, given what all samples outside brief pieces tell of the shape (−2 ln of the odds); infinite for all other samples.
pub(super) fn placed_anew(problem: &Problem, fit: &Fit, brief: &[Range<usize>]) -> Vec<f64> {
    let mut margin = vec![f64::INFINITY; problem.len()];
    let samples: usize = brief.iter().map(|piece| piece.len()).sum();
    if samples == 0 {
        return margin;
    }
    if samples > MOST {
        brief.iter().for_each(|piece| margin[piece.clone()].fill(0.0));
        return margin;
    }
    let mut others = problem.clone();
    brief.iter().cloned().flatten().for_each(|index| others.instants[index].set_aside());
    let known = Known::from(&others, fit);
    for piece in brief {
        let of_piece = known.as_ref().map_or(0.0, |known| {
            let samples = piece.clone().into_par_iter();
            let margins = samples.map(|index| known.margin(&problem.instants[index], fit.estimate.psi[index]));
            margins.reduce(|| 0.0, f64::max)
        });
        margin[piece.clone()].fill(of_piece);
    }
    margin
}
