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

/// A sample is moved when that takes at least this much off its misfit.
const WORTH_MOVING: f64 = 9.0;

/// What it costs a few samples to leap from the poses around them and back.
const OUTING: f64 = 40.0;

/// Longest run of samples that may have leapt out and back by mistake.
const LONGEST_OUTING: usize = 3;

/// Whether the motion leaps shortly before and shortly after a sample; `steps` are the steps of ψ.
fn leaps_around(steps: &[f64], index: usize) -> bool {
    let leaps = |range: std::ops::Range<usize>| steps[range].iter().any(|step| *step > 0.1);
    leaps(index.saturating_sub(LONGEST_OUTING)..index.min(steps.len()))
        && leaps(index.min(steps.len())..(index + LONGEST_OUTING).min(steps.len()))
}

/// Places suspicious samples anew; returns how many moved.
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
    let steps: Vec<f64> =
        fit.estimate.psi.windows(2).map(|pair| 2.0 * (0.5 * (pair[1] - pair[0])).sin().abs()).collect();
    let mut moved = 0;
    for index in 0..problem.len() {
        let instant = &problem.instants[index];
        let here = fit.estimate.psi[index];
        let lonely = leaps_around(&steps, index);
        let odd = contacts(instant, here) > SUSPICIOUS * usual_contacts
            || balance(instant, here) > SUSPICIOUS * usual_balance;
        if !odd && !lonely {
            continue;
        }
        let at = |index: Option<usize>| index.and_then(|index| fit.estimate.psi.get(index)).copied().unwrap_or(here);
        let (before, after) = (at(index.checked_sub(1)), at(Some(index + 1)));
        let (long_before, long_after) =
            (at(index.checked_sub(LONGEST_OUTING + 1)), at(Some(index + LONGEST_OUTING + 1)));
        let near = |psi: f64, others: &[f64]| others.iter().any(|other| (0.5 * (psi - other)).sin().abs() < 0.15);
        let out_here = if lonely || !near(here, &[before, after]) { OUTING } else { 0.0 };
        let mut trials: Vec<f64> = vec![
            before,
            after,
            long_before,
            long_after,
            best_orientation(instant, &coefficients, before, usual_contacts),
        ];
        if palms[index].phi2_rad.sin() > 0.0 {
            trials.extend(EnergyLandscape::new(&shape, &palms[index]).stable_poses().iter().map(|rest| rest.psi_rad));
        }
        let best = trials
            .into_iter()
            .map(|trial| {
                let (value, psi) = settled(instant, trial, &misfit);
                let neighbours: &[f64] = if lonely { &[long_before, long_after] } else { &[before, after] };
                (if near(psi, neighbours) { value } else { value + OUTING }, psi)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((rank, psi)) = best
            && rank + WORTH_MOVING < misfit(instant, here) + out_here
        {
            fit.estimate.psi[index] = psi;
            moved += 1;
        }
    }
    moved
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
    let square = |psi: f64| contact_square(instant, coefficients, psi);
    let step = TAU / TRIALS as f64;
    let grid: Vec<f64> = (0..TRIALS).map(|trial| square(nearest + step * trial as f64)).collect();
    let mut best = (f64::INFINITY, nearest);
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
        let tie = (30.0 * balance / coefficients[0]).powi(2).min(1.0) + 0.1 * (1.0 - (psi - nearest).cos());
        let rank = square(psi) / usual + 10.0 * tie;
        if rank < best.0 {
            best = (rank, psi);
        }
    }
    best.1
}
