//! Decoding of the motion for a given shape: Viterbi decoding of a switching model (`docs/theory.md`, section on the decoded
//! motion). The states are the candidate poses of each sample, the emission costs their misfits, the transition costs those of
//! jumps ([`super::transitions`]); the best path explains the contacts with the fewest jumps that statics does not predict.
//!
//! Decoding corrects samples that the search put at a wrong pose (beside a jump, in the ringing after it, in a window that was
//! deferred), and finds ambiguous samples: those which a path of nearly the same cost has at another pose. Only poses that a jump
//! separates count; the uncertainty of a pose about its optimum is that of the error bars.

use crate::estimate::association::alternatives::Alternative;
use crate::estimate::association::candidates::{Choice, candidates, minima};
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::transitions::{Transition, is_same_pose, near, steps, turn};
use crate::estimate::association::viterbi::Trellis;
use crate::estimate::evidence::motion_prior::{CERTAIN, UNSTABLE_POSE};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::balance_tolerance::balance_limit_m;
use crate::estimate::model::noise::Spread;
use crate::estimate::model::table::SupportTable;
use crate::estimate::solver::gauss_newton::Fit;
use crate::math::statistics::{correlation_time, median};
use crate::shape::SupportFunction;
use rayon::prelude::*;

/// A contact that moves by less than this share of the mean radius, plus [`STILL_SDS`] standard deviations of a contact position, did not
/// jump. Larger values exclude true jumps, smaller ones admit flips of symmetric objects.
const STILL: f64 = 0.02;
const STILL_SDS: f64 = 6.0;

/// No contact is taken to be more exact than this share of the mean radius, so that an exact log does not make every cost
/// infinite.
const LEAST_CONTACT_SD: f64 = 1e-5;

/// A candidate at the pose of the fit replaces it when its misfit is lower by more than this (squared standard deviations).
const BETTER_CANDIDATE: f64 = 1.0;

/// The motion of a fit is changed when that lowers the cost by at least this (−2 ln of the odds): three standard deviations.
const WORTH_CHANGING: f64 = 9.0;

/// Standard deviation of an energy barrier that errors of the shape cause where there is none: as a share of that of a contact
/// position, and of the mean radius.
const BARRIER_SD: [f64; 2] = [0.03, 1e-4];

/// A pose counts as ambiguous below this many times the margin of a certain one: the shape was fitted to it, which makes the
/// margin too large.
const SAFETY: f64 = 2.0;

/// The most likely motion for a shape.
pub(crate) struct Decoded {
    /// One orientation for each sample.
    pub psi: Vec<f64>,
    /// Number of samples at another pose than that of the fit.
    pub relocated: usize,
    /// For each sample, how much more the best path costs that has it at another pose, −2 ln.
    pub margin: Vec<f64>,
    /// Squared standard deviations by which each sample is missed.
    pub misfit: Vec<f64>,
    /// For samples whose pose is not certain, the most likely motions that have them at another.
    pub alternatives: Vec<Alternative>,
}

impl Decoded {
    /// Whether the pose of a sample is ambiguous: another is not much less likely, or none explains the sample.
    pub fn is_ambiguous(&self, sample: usize) -> bool {
        self.margin[sample] < SAFETY * CERTAIN.deviance() || self.misfit[sample] > UNEXPLAINED
    }
}

/// Samples that were not fitted. They may lie on boundary that the others did not feel, so that they are associated by their
/// predictive likelihood.
#[derive(Clone, Copy)]
pub(crate) struct Aside<'a> {
    /// Their indices, increasing.
    pub samples: &'a [usize],
    /// The samples whose transitions are blind to statics, since it predicts a jump no better than the shape is known.
    pub blind: &'a (dyn Fn(usize) -> bool + Sync),
    /// The posterior of the shape given all other samples.
    pub predictive: &'a PredictiveShape,
}

/// Decodes the motion of the fitted shape. Contacts are never taken to be more exact than `floor_m`.
pub(crate) fn decode(measurements: &Measurements, fit: &Fit, floor_m: f64, aside: Option<Aside>) -> Decoded {
    let coefficients = &fit.estimate.coefficients;
    let (shape, table) = (SupportFunction::from_coefficients(coefficients), SupportTable::new(coefficients));
    let here = &fit.estimate.psi;
    let spread = spread(measurements, &table, here, floor_m.max(LEAST_CONTACT_SD * coefficients[0].abs()));
    let barrier_sd_m = BARRIER_SD[0] * spread.contact_m2.sqrt() + BARRIER_SD[1] * coefficients[0].abs();
    let contact_sd_m = spread.contact_m2.sqrt();
    let balance_m = spread.balance_m2.sqrt();
    let still_m = STILL * coefficients[0].abs() + STILL_SDS * contact_sd_m;
    let inexact_balance = balance_m > balance_limit_m(contact_sd_m, coefficients[0].abs());
    let period = fit.prior.symmetry.period_rad();
    let anchor = anchor(here, period);
    measurements.work.add_decoding(measurements.len());
    let mut choices: Vec<Vec<Choice>> = (0..measurements.len())
        .into_par_iter()
        .map(|index| {
            let instant = &measurements.instants[index];
            let instability_cost = |psi: f64| instability_cost(&table, instant, psi, balance_m);
            let misfit = spread.misfit(&table, instant, here[index]) + instability_cost(here[index]);
            let mut choices = vec![Choice { psi: here[index], misfit }];
            if index == anchor {
                return choices;
            }
            for (psi, misfit) in candidates(&table, instant, spread, here[index], period) {
                let misfit = misfit + instability_cost(psi);
                if !is_same_pose(psi, here[index], period) {
                    choices.push(Choice { psi, misfit });
                } else if misfit + BETTER_CANDIDATE < choices[0].misfit {
                    choices[0] = Choice { psi: here[index] + turn(here[index], psi, period), misfit };
                }
            }
            choices
        })
        .collect();
    if let Some(aside) = aside {
        reassociate(&mut choices, measurements, &table, (balance_m, period), aside);
    }
    let steps: Vec<Vec<f64>> = (1..measurements.len())
        .into_par_iter()
        .map(|index| {
            let ahead = Transition {
                shape: &shape,
                table: &table,
                instant: &measurements.instants[index],
                barrier_sd_m,
                still_m,
                still_between_turning: inexact_balance,
                period,
                work: &measurements.work,
            };
            let blind = aside.is_some_and(|aside| (aside.blind)(index));
            steps(&ahead, &measurements.instants[index - 1], &choices[index - 1], &choices[index], blind)
        })
        .collect();
    let trellis = Trellis::new(&choices, &steps);
    let (path, cost) = trellis.best();
    let stay: f64 =
        choices.iter().map(|choices| choices[0].misfit).sum::<f64>() + steps.iter().map(|steps| steps[0]).sum::<f64>();
    let path = if cost + WORTH_CHANGING > stay { vec![0; choices.len()] } else { path };
    let along =
        |path: &[usize]| -> Vec<Choice> { path.iter().zip(&choices).map(|(&choice, all)| all[choice]).collect() };
    let chosen = along(&path);
    let psi: Vec<f64> = chosen.iter().map(|choice| choice.psi).collect();
    let elsewhere: Vec<(f64, usize)> =
        (0..psi.len()).map(|index| trellis.elsewhere(index, psi[index], period)).collect();
    let mut alternatives: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
    for (index, &(other, choice)) in
        elsewhere.iter().enumerate().filter(|(_, (other, _))| *other < cost + CERTAIN.deviance())
    {
        let alternative = trellis.through(index, choice);
        match alternatives.iter().position(|(other, _)| *other == alternative) {
            Some(present) => alternatives[present].1.push(index),
            None if other.is_finite() && alternatives.len() < MOST_ALTERNATIVES => {
                alternatives.push((alternative, vec![index]));
            }
            None => {}
        }
    }
    let prior_cost = |path: &[usize]| -> f64 {
        let poses = measurements.instants.iter().zip(along(path));
        let unstable =
            poses.map(|(instant, choice)| instability_cost(&table, instant, choice.psi, balance_m)).sum::<f64>();
        unstable + trellis.steps_along(path)
    };
    let of_decoded = prior_cost(&path);
    let alternatives = alternatives.into_iter().map(|(alternative, samples)| Alternative {
        psi: along(&alternative).iter().map(|choice| choice.psi).collect(),
        samples,
        motion_cost: Some(prior_cost(&alternative) - of_decoded),
        is_predicted: false,
    });
    Decoded {
        alternatives: alternatives.collect(),
        psi,
        relocated: path.iter().filter(|choice| **choice > 0).count(),
        margin: elsewhere.iter().map(|(other, _)| other - cost).collect(),
        misfit: chosen.iter().map(|choice| choice.misfit).collect(),
    }
}

/// Alternative motions of one decoding at most: each of them costs a fit.
const MOST_ALTERNATIVES: usize = 24;

/// Replaces the choices of the samples set aside by the poses at which the predictive shape explains them.
fn reassociate(
    choices: &mut [Vec<Choice>],
    measurements: &Measurements,
    table: &SupportTable,
    (balance_m, period): (f64, f64),
    Aside { samples, predictive, .. }: Aside,
) {
    let associated: Vec<Vec<Choice>> = samples
        .par_iter()
        .map(|&index| {
            let instant = &measurements.instants[index];
            let neg_log_predictive = |psi: f64| predictive.neg_log_predictive(instant, psi);
            let misfit = |psi: f64| neg_log_predictive(psi) + instability_cost(table, instant, psi, balance_m);
            let mut associated: Vec<Choice> =
                choices[index].iter().map(|choice| Choice { misfit: misfit(choice.psi), ..*choice }).collect();
            for (psi, _) in minima(choices[index][0].psi, period, &neg_log_predictive) {
                let misfit = misfit(psi);
                match associated.iter_mut().find(|choice| is_same_pose(choice.psi, psi, period)) {
                    Some(choice) if choice.misfit > misfit => {
                        *choice = Choice { psi: choice.psi + turn(choice.psi, psi, period), misfit };
                    }
                    Some(_) => {}
                    None => associated.push(Choice { psi, misfit }),
                }
            }
            associated
        })
        .collect();
    for (&index, associated) in samples.iter().zip(associated) {
        choices[index] = associated;
    }
}

/// Cost of a pose at rest that is no minimum of the potential energy: such a sample is not explained.
fn instability_cost(table: &SupportTable, instant: &Instant, psi: f64, balance_m: f64) -> f64 {
    if table.residuals(instant, psi).is_unstable(balance_m) { UNSTABLE_POSE.deviance() } else { 0.0 }
}

/// A sample missed by more squared standard deviations than this is not explained: four standard deviations.
const UNEXPLAINED: f64 = 16.0;

/// Medians of the χ² distribution with two degrees of freedom (both contacts) and with one (the balance).
const MEDIAN_CHI2_2: f64 = 1.386;
const MEDIAN_CHI2_1: f64 = 0.455;

/// Least variance of the balance, as a share of the squared floor of the contacts: a tenth of their standard deviation.
const LEAST_BALANCE_VARIANCE: f64 = 0.01;

/// The balance is clipped at so many standard deviations before its correlation time is estimated: bursts say nothing of how long
/// friction pulls one way.
const BURST_SDS: f64 = 3.0;

/// Robust variances of contacts and balance, by medians: at least half of the samples are taken to be at their poses.
fn spread(measurements: &Measurements, table: &SupportTable, psi: &[f64], floor_m: f64) -> Spread {
    let both_seen = || measurements.instants.iter().zip(psi).filter(|(instant, _)| instant.both_seen());
    let (mut contacts, balance): (Vec<f64>, Vec<f64>) = both_seen()
        .map(|(instant, psi)| {
            let [one, two, balance] = table.residuals(instant, *psi).value;
            ((instant.weight1 * one).powi(2) + (instant.weight2 * two).powi(2), balance)
        })
        .unzip();
    let contact_m2 = (median(&mut contacts) / MEDIAN_CHI2_2).max(floor_m * floor_m);
    let squares = median(&mut balance.iter().map(|balance| balance * balance).collect::<Vec<f64>>());
    let balance_m2 = (squares / MEDIAN_CHI2_1).max(LEAST_BALANCE_VARIANCE * floor_m * floor_m);
    let most = BURST_SDS * balance_m2.sqrt();
    let clipped: Vec<f64> = balance.iter().map(|balance| balance.clamp(-most, most)).collect();
    Spread { contact_m2, balance_m2, balance_memory: correlation_time(&clipped) }
}

/// The middle of the longest run of samples without a jump: its pose is held, which fixes the common rotation.
fn anchor(psi: &[f64], period: f64) -> usize {
    let mut edges = vec![0];
    edges.extend((1..psi.len()).filter(|&index| !near(psi[index - 1], psi[index], period)));
    edges.push(psi.len());
    let longest = edges.windows(2).max_by_key(|edge| edge[1] - edge[0]);
    longest.map_or(0, |edge| (edge[0] + edge[1]) / 2)
}

#[cfg(test)]
mod tests;
