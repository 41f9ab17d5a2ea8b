//! Samples that the search put at a wrong orientation: beside a jump, in the ringing after it, in a stretch that was put
//! off. Once the shape is known each can be placed alone, by what it felt and by where the object would rest.

use std::f64::consts::TAU;

use super::evidence::Fit;
use super::noise::median;
use super::problem::{Instant, Problem};
use super::residuals::residuals;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use crate::statics::EnergyLandscape;

/// Trial orientations of one sample.
const TRIALS: usize = 240;

/// A sample is looked at again when its contacts or its balance are missed by this many times the usual square.
const SUSPICIOUS: f64 = 25.0;

/// Samples around a suspicious one that are looked at as well.
const AROUND: usize = 4;

/// A stretch is changed when that takes at least this much off its cost.
const WORTH_CHANGING: f64 = 9.0;

/// What a leap from one sample to the next costs, in squared standard deviations. A leap must have its reasons.
const LEAP: f64 = 20.0;

/// Steps beyond this are leaps, radians.
const LONGEST_STEP: f64 = 0.15;

/// Orientations that one sample might have, each with its misfit.
type Choices = Vec<(f64, f64)>;

/// Places the samples of suspicious stretches anew; returns how many moved. Of all ways through the orientations that each
/// sample might have, the one of least misfit and fewest leaps is taken (Viterbi's algorithm).
pub(super) fn repair(problem: &Problem, palms: &[PalmPair], fit: &mut Fit, scatter_m: f64) -> usize {
    let coefficients = fit.estimate.coefficients.clone();
    let shape = SupportFunction::from_coefficients(&coefficients);
    let floor = (1e-5 * coefficients[0]).powi(2).max((0.3 * scatter_m).powi(2));
    // Half of the samples at least are placed well; their residuals tell the noise whatever the others do.
    let usual = |square: &dyn Fn(&Instant, f64) -> f64| {
        let both = problem.instants.iter().zip(&fit.estimate.psi).filter(|(instant, _)| instant.both_seen());
        median(&mut both.map(|(instant, psi)| square(instant, *psi)).collect::<Vec<f64>>()).max(floor)
    };
    let contacts = |instant: &Instant, psi: f64| contact_square(instant, &coefficients, psi);
    let balance = |instant: &Instant, psi: f64| residuals(instant, &coefficients, psi).value[2].powi(2);
    let (usual_contacts, usual_balance) = (usual(&contacts), usual(&balance));
    let misfit = |instant: &Instant, psi: f64| {
        // Contacts always hold; balance may be missed in bursts, so its misfit grows slowly only.
        contacts(instant, psi) / usual_contacts + 4.0 * (1.0 + balance(instant, psi) / (4.0 * usual_balance)).ln()
    };
    let psi = &fit.estimate.psi;
    let mut doubtful = vec![false; problem.len()];
    for index in 0..problem.len() {
        let instant = &problem.instants[index];
        let leaps = index > 0 && leap(psi[index - 1], psi[index]) > 0.0;
        if leaps
            || contacts(instant, psi[index]) > SUSPICIOUS * usual_contacts
            || balance(instant, psi[index]) > SUSPICIOUS * usual_balance
        {
            doubtful[index.saturating_sub(AROUND)..(index + AROUND + 1).min(problem.len())].fill(true);
        }
    }
    let mut moved = 0;
    let mut start = 0;
    while start < problem.len() {
        if !doubtful[start] {
            start += 1;
            continue;
        }
        let end = (start..problem.len()).find(|&index| !doubtful[index]).unwrap_or(problem.len());
        let before = start.checked_sub(1).map(|index| fit.estimate.psi[index]);
        let after = fit.estimate.psi.get(end).copied();
        let choices: Vec<Choices> = (start..end)
            .map(|index| {
                let instant = &problem.instants[index];
                let here = fit.estimate.psi[index];
                let nearest = before.or(after).unwrap_or(here);
                let mut trials = vec![best_orientation(instant, &coefficients, nearest, usual_contacts)];
                trials.extend(before);
                trials.extend(after);
                let beside = [index.checked_sub(1), Some(index + 1)].into_iter().flatten();
                trials.extend(beside.filter_map(|other| fit.estimate.psi.get(other).copied()));
                if palms[index].phi2_rad.sin() > 0.0 {
                    let rests = EnergyLandscape::new(&shape, &palms[index]).stable_poses();
                    trials.extend(rests.iter().map(|rest| rest.psi_rad));
                }
                let mut choices = vec![(here, misfit(instant, here))];
                for trial in trials {
                    let (value, psi) = settled(instant, trial, &misfit);
                    if choices.iter().all(|(other, _)| (0.5 * (psi - other)).sin().abs() > 2e-3) {
                        choices.push((psi, value));
                    }
                }
                choices
            })
            .collect();
        let way = cheapest_way(before, &choices, after);
        let cost = |way: &[usize]| {
            let psi: Vec<f64> = way.iter().zip(&choices).map(|(&choice, choices)| choices[choice].0).collect();
            let misfits: f64 = way.iter().zip(&choices).map(|(&choice, choices)| choices[choice].1).sum();
            let all: Vec<f64> = before.into_iter().chain(psi).chain(after).collect();
            misfits + all.windows(2).map(|pair| leap(pair[0], pair[1])).sum::<f64>()
        };
        if cost(&way) + WORTH_CHANGING < cost(&vec![0; choices.len()]) {
            for (offset, &choice) in way.iter().enumerate() {
                moved += usize::from(choice > 0);
                fit.estimate.psi[start + offset] = choices[offset][choice].0;
            }
        }
        start = end;
    }
    moved
}

/// The cost of the step from one orientation to the next.
fn leap(from: f64, to: f64) -> f64 {
    if 2.0 * (0.5 * (to - from)).sin().abs() > LONGEST_STEP { LEAP } else { 0.0 }
}

/// The choice at each sample that makes the least cost in all.
fn cheapest_way(before: Option<f64>, choices: &[Choices], after: Option<f64>) -> Vec<usize> {
    let mut costs: Vec<f64> = Vec::new();
    let mut origins: Vec<Vec<usize>> = Vec::new();
    for (step, here) in choices.iter().enumerate() {
        let mut next = Vec::with_capacity(here.len());
        let mut origin = Vec::with_capacity(here.len());
        for &(psi, misfit) in here {
            let (from, cost) = match step {
                0 => (0, before.map_or(0.0, |before| leap(before, psi))),
                _ => costs
                    .iter()
                    .zip(&choices[step - 1])
                    .map(|(cost, (other, _))| cost + leap(*other, psi))
                    .enumerate()
                    .min_by(|a, b| a.1.total_cmp(&b.1))
                    .unwrap_or((0, f64::INFINITY)),
            };
            origin.push(from);
            next.push(cost + misfit);
        }
        costs = next;
        origins.push(origin);
    }
    let ends = costs.iter().zip(choices.last().into_iter().flatten());
    let mut choice = ends
        .map(|(cost, (psi, _))| cost + after.map_or(0.0, |after| leap(*psi, after)))
        .enumerate()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(0, |(choice, _)| choice);
    let mut way = vec![0; choices.len()];
    for step in (0..choices.len()).rev() {
        way[step] = choice;
        choice = origins[step][choice];
    }
    way
}

/// The bottom of the misfit next to a trial orientation, by shrinking steps.
fn settled(instant: &Instant, trial: f64, misfit: &dyn Fn(&Instant, f64) -> f64) -> (f64, f64) {
    let (mut psi, mut value, mut step) = (trial, misfit(instant, trial), 0.01);
    while step > 1e-5 {
        let (left, right) = (misfit(instant, psi - step), misfit(instant, psi + step));
        if left < value && left <= right {
            (psi, value) = (psi - step, left);
        } else if right < value {
            (psi, value) = (psi + step, right);
        } else {
            step *= 0.4;
        }
        if (psi - trial).abs() > 0.2 {
            break;
        }
    }
    (value, psi)
}

fn contact_square(instant: &Instant, coefficients: &[f64], psi: f64) -> f64 {
    let value = residuals(instant, coefficients, psi).value;
    (instant.weight1 * value[0]).powi(2) + (instant.weight2 * value[1]).powi(2)
}

/// The orientation at which the shape explains both contacts of a sample best; among those that explain them to within
/// `usual` (squared metres), the best balanced and nearest to `nearest`.
pub(super) fn best_orientation(instant: &Instant, coefficients: &[f64], nearest: f64, usual: f64) -> f64 {
    let rank = |(psi, square): &(f64, f64)| {
        let balance = residuals(instant, coefficients, *psi).value[2];
        // Balance and nearness decide only between orientations that explain the contacts equally well.
        let tie = (30.0 * balance / coefficients[0]).powi(2).min(1.0) + 0.1 * (1.0 - (psi - nearest).cos());
        square / usual + 10.0 * tie
    };
    minima(nearest, &|psi| contact_square(instant, coefficients, psi))
        .into_iter()
        .map(|minimum| (rank(&minimum), minimum.0))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(nearest, |(_, psi)| psi)
}

/// Orientations more than a few degrees from `psi` that explain a sample about as well, the shape being known. `squares`
/// are the variances of the contacts and of the balance.
pub(super) fn rivals(instant: &Instant, coefficients: &[f64], psi: f64, squares: [f64; 2]) -> Vec<f64> {
    const RIVAL: f64 = 25.0;
    let misfit = |psi: f64| {
        let balance = residuals(instant, coefficients, psi).value[2];
        contact_square(instant, coefficients, psi) / squares[0]
            + 4.0 * (1.0 + balance * balance / (4.0 * squares[1])).ln()
    };
    let here = misfit(psi);
    minima(psi, &misfit)
        .into_iter()
        .filter(|(other, value)| (0.5 * (other - psi)).sin().abs() > 0.05 && *value < here + RIVAL)
        .map(|(other, _)| other)
        .collect()
}

/// All minima of a function of the orientation, with their values; looked for on a grid that begins at `start`.
fn minima(start: f64, function: &dyn Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let step = TAU / TRIALS as f64;
    let grid: Vec<f64> = (0..TRIALS).map(|trial| function(start + step * trial as f64)).collect();
    (0..TRIALS)
        .filter(|&trial| {
            grid[trial] <= grid[(trial + TRIALS - 1) % TRIALS] && grid[trial] <= grid[(trial + 1) % TRIALS]
        })
        .map(|trial| {
            let middle = start + step * trial as f64;
            let (mut low, mut high) = (middle - step, middle + step);
            for _ in 0..30 {
                let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if function(left) < function(right) { high = right } else { low = left }
            }
            let psi = 0.5 * (low + high);
            (psi, function(psi))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_way_leaps_once_where_each_sample_alone_would_leap_often() {
        // Two poses explain each sample about equally well; the noise prefers now one, now the other.
        let choices: Vec<Choices> = (0..8)
            .map(|i| vec![(0.0, if i % 2 == 0 { 3.0 } else { 1.0 }), (1.0, if i % 2 == 0 { 1.0 } else { 3.0 })])
            .collect();
        assert_eq!(cheapest_way(Some(0.0), &choices, Some(0.0)), [0; 8]);
        let way = cheapest_way(Some(0.0), &choices, Some(1.0));
        assert_eq!(
            way.windows(2).filter(|pair| pair[0] != pair[1]).count()
                + usize::from(way[0] == 1)
                + usize::from(way[7] == 0),
            1
        );
    }
}
