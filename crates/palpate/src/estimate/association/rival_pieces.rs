//! Rival motions of pieces: those of a few dozen samples between two jumps, or at an end of the log. On boundary that nothing else felt a fit
//! adapts the shape to whatever motion it was given, and so fits every sample. Here each such piece is searched anew, over heights and
//! orientations (the two unknowns of a piece; `docs/theory.md`, the search), against the predictive shape that all other samples leave at their
//! own optimum.
//! What explains it about as well becomes an alternative, which the evidence decides ([`super::alternatives`]).

use crate::estimate::association::alternatives::{Alternative, Ambiguity};
use crate::estimate::association::motion_grid::{HEIGHTS, first_distinct, likely_motions};
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::transitions::near;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::{SHORT_SEGMENT, common_rotation, short_segments};
use crate::estimate::solver::gauss_newton::Fit;
use rayon::prelude::*;
use std::ops::Range;

/// Longest piece that is searched: longer ones are not explained by a wrong motion.
const LONGEST: usize = 60;

/// Pieces that are searched at most, the shortest first: each costs as much as a few rounds of the smoother.
const MOST_PIECES: usize = 8;

/// Distinct trials of a piece that are kept after each round of the search.
const SEMIFINALISTS: usize = 40;
const FINALISTS: usize = 8;

/// Noise of the trials, as a share of the size: loose, so that the grid is fine enough for it.
const LOOSE: f64 = 0.01;

/// Rounds that take a trial to its optimum at the noise of the fit.
const POLISHING: usize = 4;

/// A motion that is less likely than the present one by more than this, by the predictive likelihood (−2 ln), is no rival: ten standard
/// deviations, for the likelihood is that of a linearised shape.
const NO_RIVAL: f64 = 100.0;

/// Rivals of a piece that are handed to the evidence.
const RIVALS: usize = 3;

/// A motion whose predictive likelihood is larger by this (−2 ln) is preferred: less is within what linearising the shape changes.
const PREFERRED: f64 = 10.0;

/// Other motions of short pieces.
pub(crate) struct Rivals {
    /// Each of them for itself.
    pub alternatives: Vec<Alternative>,
    /// Motions of all samples with one piece as the predictive shape of all others prefers it. A second error elsewhere can make the evidence
    /// reject it, so that it takes a fit of its own, decoding included, to compare them.
    pub preferred: Vec<Vec<f64>>,
}

/// Looks for other motions of each short piece. Their samples count as ambiguous until the evidence decides.
pub(crate) fn rival_motions(
    measurements: &Measurements,
    fit: &Fit,
    starts: &[usize],
    ambiguity: &mut Ambiguity,
) -> Rivals {
    let mut found = Rivals { alternatives: Vec::new(), preferred: Vec::new() };
    let short = short_segments(starts, measurements.len());
    let pieces = pieces(starts, measurements.len());
    let of_pieces: Vec<(Range<usize>, Vec<Rival>)> =
        pieces.into_par_iter().map(|piece| (piece.clone(), rivals(measurements, fit, piece, &short))).collect();
    for (piece, rivals) in of_pieces {
        let settled = ambiguity.settled(piece.clone());
        for rival in rivals {
            ambiguity.doubt(&settled);
            let mut psi = fit.estimate.psi.clone();
            psi[piece.clone()].copy_from_slice(&rival.psi);
            if rival.cost < -PREFERRED {
                found.preferred.push(psi.clone());
            }
            found.alternatives.push(Alternative {
                psi,
                samples: settled.clone(),
                motion_cost: None,
                is_predicted: false,
            });
        }
    }
    found
}

/// The pieces that are searched, the shortest first: segments between two jumps, alone, and with a short one beside them, which may be a part of
/// them.
fn pieces(starts: &[usize], samples: usize) -> Vec<Range<usize>> {
    let mut edges = vec![0];
    edges.extend(starts);
    edges.push(samples);
    let has_short = |edges: &&[usize]| edges.windows(2).any(|edge| edge[1] < edge[0] + SHORT_SEGMENT);
    let from_to = |edges: &[usize]| edges[0]..edges[edges.len() - 1];
    let joined = edges.windows(3).filter(has_short).map(from_to);
    let mut pieces: Vec<Range<usize>> = edges.windows(2).map(from_to).chain(joined).collect();
    pieces.retain(|piece| (SHORT_SEGMENT..=LONGEST).contains(&piece.len()) && piece.len() < samples);
    pieces.sort_by_key(ExactSizeIterator::len);
    pieces.truncate(MOST_PIECES);
    pieces
}

/// Another motion of a piece, and what it costs more than the present one by the predictive likelihood, −2 ln.
pub(super) struct Rival {
    pub psi: Vec<f64>,
    pub cost: f64,
}

/// The likeliest other motions of one piece. Nothing tells the poses of `short` segments, so that they tell nothing of the shape.
fn rivals(measurements: &Measurements, fit: &Fit, piece: Range<usize>, short: &[Range<usize>]) -> Vec<Rival> {
    let period = fit.prior.symmetry.period_rad();
    let alone = measurements.of(measurements.instants[piece.clone()].to_vec());
    let present = &fit.estimate.psi[piece.clone()];
    let mut others = measurements.clone();
    for aside in short.iter().cloned().chain([piece]) {
        others.instants[aside].iter_mut().for_each(Instant::set_aside);
    }
    // The shape of the fit is bent towards the present motion of the piece.
    let others_alone = &fit.at_optimum_of(&others);
    let sd_m = loose_m(fit.prior, others_alone.noise);
    let loose = Fit { noise: Noise { sensor_m: sd_m, balance_m: sd_m }, ..others_alone.clone() };
    let turned = common_rotation(&fit.estimate.psi, &others_alone.estimate.psi, period);
    let Some((loose, sharp)) = PredictiveShape::from(&others, &loose).zip(PredictiveShape::from(&others, others_alone))
    else {
        return Vec::new();
    };
    let mut rivals = likeliest_motions(&alone, present, HEIGHTS, fit.prior, &Predicted { loose, sharp });
    rivals.iter_mut().flat_map(|rival| &mut rival.psi).for_each(|psi| *psi += turned);
    rivals
}

/// The noise of the trials, metres.
pub(super) fn loose_m(prior: Prior, noise: Noise) -> f64 {
    (LOOSE * prior.size_m).max(noise.sensor_m)
}

/// What all other samples tell of the shape: at the noise of the trials, and at that of the fit.
pub(super) struct Predicted {
    pub loose: PredictiveShape,
    pub sharp: PredictiveShape,
}

/// The likeliest other motions of a few samples than the `present` one, of so many trial heights.
pub(super) fn likeliest_motions(
    alone: &Measurements,
    present: &[f64],
    heights: usize,
    prior: Prior,
    by_others: &Predicted,
) -> Vec<Rival> {
    let Predicted { loose, sharp } = by_others;
    let period = prior.symmetry.period_rad();
    let sd_m = loose.noise().sensor_m;
    let is_same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| near(*a, *b, period));
    let trials =
        likely_motions(alone, heights, (prior.size_m, sd_m), false, loose, [SEMIFINALISTS, FINALISTS], is_same);
    let weighed = |mut psi: Vec<f64>| {
        let _ = loose.misfit_of_motion(&alone.instants, &mut psi, POLISHING);
        let fitted = sharp.misfit_of_motion(&alone.instants, &mut psi, POLISHING);
        Rival { cost: fitted.misfit + fitted.log_determinant, psi }
    };
    let here = weighed(present.to_vec()).cost;
    let against_here = |rival: Rival| Rival { cost: rival.cost - here, ..rival };
    let mut rivals: Vec<Rival> = trials.into_iter().map(weighed).map(against_here).collect();
    rivals.retain(|rival| rival.cost < NO_RIVAL && !is_same(&rival.psi, present));
    rivals.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    first_distinct(rivals, RIVALS, |rival| rival.psi.as_slice(), is_same)
}

#[cfg(test)]
mod tests;
