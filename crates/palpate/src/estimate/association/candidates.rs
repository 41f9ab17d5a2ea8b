//! Where a sample may be: the orientations at which a known shape explains it.

use crate::estimate::measurements::Instant;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::noise::Spread;
use crate::estimate::model::table::SupportTable;
use std::f64::consts::TAU;

/// Trial orientations of one sample.
const TRIALS: usize = 240;

/// An orientation that a sample might have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    pub psi: f64,
    pub misfit: f64,
}

/// The orientation at which the shape explains both contacts of a sample best; among those that explain them to within
/// `usual` (squared metres), the best balanced and nearest to `nearest`.
pub(crate) fn best_orientation(instant: &Instant, coefficients: &[f64], nearest: f64, usual: f64) -> f64 {
    let contacts = |psi: f64| {
        let value = residuals(instant, coefficients, psi).value;
        (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2)
    };
    let rank = |(psi, square): &(f64, f64)| {
        let balance = residuals(instant, coefficients, *psi).value[2];
        // Balance and nearness decide only between orientations that explain the contacts equally well.
        let tie = (30.0 * balance / coefficients[0]).powi(2).min(1.0) + 0.1 * (1.0 - (psi - nearest).cos());
        square / usual + 10.0 * tie
    };
    minima(nearest, &contacts)
        .into_iter()
        .map(|minimum| (rank(&minimum), minimum.0))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(nearest, |(_, psi)| psi)
}

/// Orientations that one sample might have, each with its misfit, best first: minima of the misfit that are not out of the
/// question.
pub(crate) fn candidates(table: &SupportTable, instant: &Instant, spread: Spread, near: f64) -> Vec<(f64, f64)> {
    let mut found = minima(near, &|psi| spread.misfit(table, instant, psi));
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let least = found.first().map_or(0.0, |(_, misfit)| *misfit);
    found.retain(|(_, misfit)| *misfit < least + IMPLAUSIBLE);
    found.truncate(MOST_CANDIDATES);
    found
}

/// Orientations missed by this much more than the best (squared standard deviations) are not looked at.
const IMPLAUSIBLE: f64 = 400.0;

/// Orientations of one sample that are looked at.
const MOST_CANDIDATES: usize = 6;

/// All minima of a function of the orientation, with their values; looked for on a grid that begins at `start`.
pub(crate) fn minima(start: f64, function: &dyn Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let step = TAU / TRIALS as f64;
    let grid: Vec<f64> = (0..TRIALS).map(|trial| function(start + step * trial as f64)).collect();
    (0..TRIALS)
        .filter(|&trial| {
            grid[trial] <= grid[(trial + TRIALS - 1) % TRIALS] && grid[trial] <= grid[(trial + 1) % TRIALS]
        })
        .map(|trial| {
            let middle = start + step * trial as f64;
            let (mut low, mut high) = (middle - step, middle + step);
            // (2/3)^16 of a step: a thousandth of a degree.
            for _ in 0..16 {
                let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if function(left) < function(right) { high = right } else { low = left }
            }
            let psi = 0.5 * (low + high);
            (psi, function(psi))
        })
        .collect()
}

#[cfg(test)]
mod tests;
