//! Likely motions of a run of samples without a jump: its two unknowns, height and orientation, are tried on a grid (`docs/theory.md`, the
//! search) and ranked by how well a predictive shape explains them; all of them on a few instants, and the best distinct ones on more.

use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::closed_form::{RATE_SD, feasible_heights, integrate, relative_height};
use crate::estimate::friction::rolling::rolling_motion;
use crate::estimate::measurements::{Instant, Measurements};
use std::f64::consts::TAU;

/// Trial heights: with the orientations a grid as coarse as convergence at a loose noise allows.
pub(crate) const HEIGHTS: usize = 20;

/// Trial orientations: 7.5 degrees apart.
const ORIENTATIONS: usize = 48;

/// Instants on which the whole grid is tried: few, since there are 960 trials; and those of the second round.
const SPARSEST: usize = 5;
const SPARSE: usize = 12;

/// Motions of `run` with so many trial heights, the likeliest first: as many as the second of `most`, of as many as the first after the first round. `noise_m` is the
/// standard deviation of a contact position; where the object `may_roll`, it is tried whether it rolls on either palm; `is_same` says of the orientations at a few instants whether they are one motion.
pub(crate) fn likely_motions(
    run: &Measurements,
    heights: usize,
    (size_m, noise_m): (f64, f64),
    may_roll: bool,
    predictive: &PredictiveShape,
    most: [usize; 2],
    is_same: impl Fn(&[f64], &[f64]) -> bool,
) -> Vec<Vec<f64>> {
    let relative = relative_height(run);
    let Some((low, high)) = feasible_heights(run, &relative, size_m) else { return Vec::new() };
    let balanced = (0..heights).map(|height| {
        let h0 = low + (high - low) * (height as f64 + 0.5) / heights as f64;
        integrate(run, &relative, h0, noise_m, RATE_SD).psi
    });
    let rolling = may_roll.then(|| [0, 1].map(|palm| rolling_motion(run, palm)));
    let paths: Vec<Vec<f64>> = balanced.chain(rolling.into_iter().flatten()).collect();
    let mut trials: Vec<(usize, f64)> = (0..paths.len() * ORIENTATIONS)
        .map(|trial| (trial / ORIENTATIONS, TAU * (trial % ORIENTATIONS) as f64 / ORIENTATIONS as f64))
        .collect();
    for (instants, rounds, most) in [(SPARSEST, 1, most[0]), (SPARSE, 2, most[1])] {
        let every = run.len().div_ceil(instants);
        let few: Vec<Instant> = run.instants.iter().step_by(every).copied().collect();
        let mut tried: Vec<(f64, Vec<f64>, (usize, f64))> = trials
            .into_iter()
            .map(|(height, psi0)| {
                let mut psi: Vec<f64> = paths[height].iter().step_by(every).map(|psi| psi + psi0).collect();
                (predictive.misfit_of_motion(&few, &mut psi, rounds).misfit, psi, (height, psi0))
            })
            .filter(|(misfit, ..)| misfit.is_finite())
            .collect();
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Neighbours on the grid come to the same motion.
        let distinct = first_distinct(tried, most, |(_, psi, _)| psi.as_slice(), &is_same);
        trials = distinct.into_iter().map(|(.., trial)| trial).collect();
    }
    trials.into_iter().map(|(height, psi0)| paths[height].iter().map(|psi| psi + psi0).collect()).collect()
}

/// The first few that have different motions.
pub(crate) fn first_distinct<T>(
    all: Vec<T>,
    most: usize,
    psi: impl Fn(&T) -> &[f64],
    is_same: impl Fn(&[f64], &[f64]) -> bool,
) -> Vec<T> {
    let mut kept: Vec<T> = Vec::new();
    for one in all {
        if kept.len() == most {
            break;
        }
        if !kept.iter().any(|other| is_same(psi(other), psi(&one))) {
            kept.push(one);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_each_motion_are_kept_up_to_a_number() {
        let all = vec![(0, vec![0.0]), (1, vec![0.02]), (2, vec![0.06]), (3, vec![2.0]), (4, vec![4.0])];
        let kept = |most: usize, apart: f64| -> Vec<i32> {
            let distinct =
                first_distinct(all.clone(), most, |(_, psi)| psi.as_slice(), |a, b| (a[0] - b[0]).abs() < apart);
            distinct.into_iter().map(|(number, _)| number).collect()
        };
        assert_eq!(kept(9, 0.03), [0, 2, 3, 4]);
        assert_eq!(kept(9, 0.01), [0, 1, 2, 3, 4]);
        assert_eq!(kept(2, 0.03), [0, 2]);
        assert!(kept(0, 0.03).is_empty());
    }
}
