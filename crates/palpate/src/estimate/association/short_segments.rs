//! Pieces of a few samples between two jumps. The shape gives way to them, so that they always seem well placed; whether they
//! are must be asked of the shape that all other samples leave, and then of the evidence ([`super::rivals`]).

use crate::estimate::association::alternatives::{Alternative, Ambiguity};
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::transitions::near;
use crate::estimate::evidence::motion_prior::CERTAIN;
use crate::estimate::measurements::Measurements;
use crate::estimate::motion::short_segments;
use crate::estimate::solver::gauss_newton::Fit;
use crate::math::angle::wrapped;
use rayon::prelude::*;

/// With more samples than this in brief pieces, none of them counts as placed.
const MOST: usize = 60;

/// Asks of each brief piece where else it might be, given what all samples outside brief pieces tell of the shape. Adds the doubts (−2 ln
/// of the odds against another orientation, for the sample of the piece that tells most), and returns the likeliest other ways.
pub(crate) fn reassociated(
    measurements: &Measurements,
    fit: &Fit,
    starts: &[usize],
    doubts: &mut Ambiguity,
) -> Vec<Alternative> {
    let brief = short_segments(starts, measurements.len());
    let samples: usize = brief.iter().map(|piece| piece.len()).sum();
    if samples == 0 {
        return Vec::new();
    }
    let mut others = measurements.clone();
    brief.iter().cloned().flatten().for_each(|index| others.instants[index].set_aside());
    let Some(known) = (samples <= MOST).then(|| PredictiveShape::from(&others, fit)).flatten() else {
        brief.into_iter().for_each(|piece| doubts.lower(piece, 0.0));
        return Vec::new();
    };
    let mut alternatives = Vec::new();
    for piece in brief {
        let here = &fit.estimate.psi;
        let samples = piece.clone().into_par_iter();
        let placed: Vec<(f64, Vec<f64>)> =
            samples.map(|index| known.elsewhere(&measurements.instants[index], here[index])).collect();
        let Some((of_piece, others)) = placed.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        if *of_piece >= CERTAIN.deviance() {
            continue;
        }
        doubts.lower(piece.clone(), *of_piece);
        for other in others {
            let mut psi = here.clone();
            for (index, (_, minima)) in piece.clone().zip(&placed) {
                let way = |psi: &f64| wrapped(psi - other).abs();
                let nearest = minima.iter().min_by(|a, b| way(a).total_cmp(&way(b)));
                psi[index] = nearest.copied().filter(|psi| near(*psi, *other)).unwrap_or(*other);
            }
            alternatives.push(Alternative { psi, samples: piece.clone().collect(), motion_cost: 0.0 });
        }
    }
    alternatives
}

#[cfg(test)]
mod tests;
