//! Candidates for the data association: the orientations at which a given shape explains one sample, as local minima of its
//! misfit.

use crate::estimate::measurements::Instant;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::noise::Spread;
use crate::estimate::model::table::SupportTable;
use std::f64::consts::TAU;

/// Trial orientations of one sample: 1.5 degrees apart, while minima of 48 harmonics are 7.5 degrees apart. A multiple of every order
/// of symmetry.
const TRIALS: usize = 240;

/// A candidate pose of one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choice {
    /// Orientation, radians.
    pub psi: f64,
    /// Squared standard deviations by which contacts and balance are missed there.
    pub misfit: f64,
}

/// Weight of the tie-breakers of [`best_orientation`] in usual squares of the contacts: they decide only between orientations that
/// explain the contacts about equally well.
const TIE: f64 = 10.0;

/// The first tie-breaker is the balance as a share of the mean radius, times this, squared and not above one.
const BALANCE_SLOPE: f64 = 30.0;

/// The second is one less the cosine of the distance from the nearest pose, times this: it counts less than the balance.
const DISTANCE_SHARE: f64 = 0.1;

/// The orientation at which the shape explains both contacts of a sample best; among those that explain them to within
/// `usual` (squared metres), the best balanced and nearest to `nearest`.
pub(crate) fn best_orientation(instant: &Instant, coefficients: &[f64], nearest: f64, usual: f64) -> f64 {
    let contacts = |psi: f64| {
        let value = residuals(instant, coefficients, psi).value;
        (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2)
    };
    let rank = |(psi, square): &(f64, f64)| {
        let balance = residuals(instant, coefficients, *psi).value[2];
        let tie = (BALANCE_SLOPE * balance / coefficients[0]).powi(2).min(1.0)
            + DISTANCE_SHARE * (1.0 - (psi - nearest).cos());
        square / usual + TIE * tie
    };
    minima(nearest, TAU, &contacts)
        .into_iter()
        .map(|minimum| (rank(&minimum), minimum.0))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(nearest, |(_, psi)| psi)
}

/// Candidate orientations of one sample, each with its misfit, best first: minima of the misfit that are not implausible.
pub(crate) fn candidates(
    table: &SupportTable,
    instant: &Instant,
    spread: Spread,
    near: f64,
    period: f64,
) -> Vec<(f64, f64)> {
    let mut found = minima(near, period, &|psi| spread.misfit(table, instant, psi));
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let least = found.first().map_or(0.0, |(_, misfit)| *misfit);
    found.retain(|(_, misfit)| *misfit < least + IMPLAUSIBLE);
    found.truncate(MOST_CANDIDATES);
    found
}

/// Excess of the misfit over the best candidate's (squared standard deviations) beyond which a candidate is dropped: 20 standard
/// deviations, more than any jump costs.
const IMPLAUSIBLE: f64 = 400.0;

/// Candidates of one sample at most: the cost of the decoding grows with the square of their number.
const MOST_CANDIDATES: usize = 6;

/// Steps of the ternary search that refines a minimum: (2/3)^16 of a step of the grid is some thousandths of a degree.
const REFINEMENTS: usize = 16;

/// All minima of a function of the orientation within one `period` (2π, or a part of it by which the function repeats), with their
/// values, located on a grid that begins at `start`.
pub(crate) fn minima(start: f64, period: f64, function: &dyn Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let step = TAU / TRIALS as f64;
    let trials = (period / step).round() as usize;
    let grid: Vec<f64> = (0..trials).map(|trial| function(start + step * trial as f64)).collect();
    (0..trials)
        .filter(|&trial| {
            grid[trial] <= grid[(trial + trials - 1) % trials] && grid[trial] <= grid[(trial + 1) % trials]
        })
        .map(|trial| {
            let middle = start + step * trial as f64;
            let (mut low, mut high) = (middle - step, middle + step);
            for _ in 0..REFINEMENTS {
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
