//! Samples that the search put at a wrong orientation: beside a jump, in the ringing after it, in a stretch that was put
//! off. Once the shape is known each can be placed alone.

use std::f64::consts::TAU;

use super::evidence::Fit;
use super::noise::median;
use super::problem::{Instant, Problem};
use super::residuals::residuals;

/// Trial orientations of one sample.
const TRIALS: usize = 240;

/// A sample is looked at again when its squared residuals are this many times the usual ones.
const SUSPICIOUS: f64 = 25.0;

/// Places every suspicious sample anew; returns how many moved.
pub(super) fn repair(problem: &Problem, fit: &mut Fit, scatter_m: f64) -> usize {
    let coefficients = fit.estimate.coefficients.clone();
    let mut squares: Vec<f64> = problem
        .instants
        .iter()
        .zip(&fit.estimate.psi)
        .filter(|(instant, _)| instant.both_seen())
        .map(|(instant, psi)| contact_square(instant, &coefficients, *psi))
        .collect();
    // Half of the samples at least are placed well; their residuals tell the noise whatever the others do.
    let usual = median(&mut squares).max((0.3 * scatter_m).powi(2)).max((1e-6 * coefficients[0]).powi(2));
    let mut moved = 0;
    for index in 0..problem.len() {
        let instant = &problem.instants[index];
        let here = fit.estimate.psi[index];
        let before = contact_square(instant, &coefficients, here);
        if before < SUSPICIOUS * usual {
            continue;
        }
        let nearest = if index > 0 { fit.estimate.psi[index - 1] } else { here };
        let (square, psi) = best_orientation(instant, &coefficients, nearest, usual);
        if square < 0.25 * before {
            fit.estimate.psi[index] = psi;
            moved += 1;
        }
    }
    moved
}

fn contact_square(instant: &Instant, coefficients: &[f64], psi: f64) -> f64 {
    let value = residuals(instant, coefficients, psi).value;
    (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2)
}

/// The orientation at which the shape explains both contacts of a sample best; among equals, the one nearest to `nearest`.
pub(super) fn best_orientation(instant: &Instant, coefficients: &[f64], nearest: f64, usual: f64) -> (f64, f64) {
    let square = |psi: f64| contact_square(instant, coefficients, psi);
    let step = TAU / TRIALS as f64;
    let grid: Vec<f64> = (0..TRIALS).map(|trial| square(nearest + step * trial as f64)).collect();
    let mut best = (f64::INFINITY, f64::INFINITY, nearest);
    for trial in 0..TRIALS {
        if grid[trial] > grid[(trial + TRIALS - 1) % TRIALS] || grid[trial] > grid[(trial + 1) % TRIALS] {
            continue;
        }
        let middle = nearest + step * trial as f64;
        let (mut low, mut high) = (middle - step, middle + step);
        for _ in 0..30 {
            let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if square(left) < square(right) { high = right } else { low = left }
        }
        let psi = 0.5 * (low + high);
        let balance = residuals(instant, coefficients, psi).value[2];
        // Balance and nearness decide only between orientations that explain the contacts equally well.
        let tie = (balance / coefficients[0]).powi(2).min(1.0) + 0.1 * (1.0 - (psi - nearest).cos());
        let rank = square(psi) / usual + 10.0 * tie;
        if rank < best.0 {
            best = (rank, square(psi), psi);
        }
    }
    (best.1, best.2)
}
