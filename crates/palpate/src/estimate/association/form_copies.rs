//! Pieces at copies of their poses: of an object whose form comes to itself by a rotation and whose centre of mass is not in its middle, contacts explain a
//! piece between two jumps at any of them, however long it is, and at a jump from one to the next they do not leap. The balance alone tells them apart
//! (`docs/theory.md`, the decoded motion): where it is loose, a piece may be at the wrong one. Each copy that present shape and noise do not exclude becomes an
//! alternative, which the evidence decides ([`super::alternatives`]).

use crate::estimate::association::alternatives::Alternative;
use crate::estimate::association::transitions::is_same_pose;
use crate::estimate::measurements::Measurements;
use crate::estimate::motion::{SHORT_SEGMENT, segments_between};
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother};
use std::f64::consts::TAU;
use std::ops::Range;

/// A copy is an alternative where it costs at most so much more than the present pose for each sample of the piece (squares, with the noise of the fit): the
/// shape is bent to the present one.
const COSTS_MORE: f64 = 1.0;

/// Newton steps that take each orientation to its optimum at a copy.
const POLISHING: usize = 6;

/// Alternatives at most, those first that cost least: each costs as much as a fit.
const MOST: usize = 4;

/// Such alternatives of the pieces between `starts`, for a form that comes to itself as often as the prior of the fit says.
pub(crate) fn at_copies(measurements: &Measurements, fit: &Fit, starts: &[usize]) -> Vec<Alternative> {
    let copies = fit.prior.form_order;
    if starts.is_empty() || copies < 2 {
        return Vec::new();
    }
    let Estimate { coefficients, psi, .. } = &fit.estimate;
    let mut found: Vec<(f64, Range<usize>, Vec<f64>)> = Vec::new();
    for piece in segments_between(starts, measurements.len()).filter(|piece| piece.len() >= SHORT_SEGMENT) {
        let alone = measurements.of(measurements.instants[piece.clone()].to_vec());
        let smoother = Smoother::new(&alone, fit.order, fit.noise, fit.prior);
        let turned = |turn: f64| {
            let mut there: Vec<f64> = psi[piece.clone()].iter().map(|psi| psi + turn).collect();
            (smoother.project_orientations(coefficients, &mut there, POLISHING), there)
        };
        let (here, _) = turned(0.0);
        for copy in 1..copies {
            let turn = TAU * f64::from(copy) / f64::from(copies);
            if is_same_pose(0.0, turn, fit.prior.symmetry.period_rad()) {
                continue;
            }
            let (cost, there) = turned(turn);
            let more = (cost - here) / piece.len() as f64;
            if more < COSTS_MORE {
                found.push((more, piece.clone(), there));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(MOST);
    let alternative = |(_, piece, there): (f64, Range<usize>, Vec<f64>)| {
        let mut psi = psi.clone();
        psi[piece.clone()].copy_from_slice(&there);
        Alternative { psi, samples: piece.collect(), motion_cost: None, is_predicted: false }
    };
    found.into_iter().map(alternative).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::association::simulated::thrown_pentagon;
    use crate::estimate::motion::same_motion;

    #[test]
    fn a_long_piece_at_the_wrong_copy_has_the_right_one_as_an_alternative() {
        let (mut tried, mut returned) = (0, 0);
        for (measurements, right, starts) in (0..40).filter_map(thrown_pentagon) {
            let Some(piece) = segments_between(&starts, measurements.len()).find(|piece| piece.len() > 60) else {
                continue;
            };
            for copy in 1..5 {
                let mut wrong = right.clone();
                let turn = TAU * f64::from(copy) / 5.0;
                wrong.estimate.psi[piece.clone()].iter_mut().for_each(|psi| *psi += turn);
                let alternatives = at_copies(&measurements, &wrong, &starts);
                assert!(alternatives.len() <= MOST);
                tried += 1;
                let is_right = |other: &Alternative| same_motion(&other.psi, &right.estimate.psi, TAU);
                returned += usize::from(alternatives.iter().any(is_right));
            }
            // The right one has none: the balance tells.
            assert!(at_copies(&measurements, &right, &starts).is_empty());
            // Nor has a form that never comes to itself, or a log of one piece.
            let mut general = right.clone();
            general.prior.form_order = 1;
            assert!(at_copies(&measurements, &general, &starts).is_empty());
            assert!(at_copies(&measurements, &right, &[]).is_empty());
        }
        assert!(tried > 8 && returned == tried, "{returned} of {tried}");
    }
}
