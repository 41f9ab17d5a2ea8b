//! The way of a known shape through the log: of all orientations that each sample might have, those that explain the contacts
//! with the fewest jumps that statics does not foretell (Viterbi's algorithm, forward and backward).
//!
//! This mends samples that the search put at a wrong pose (beside a jump, in the ringing after it, in a stretch that was put
//! off), and it tells what cannot be known: a sample that a way of nearly the same cost puts elsewhere. Elsewhere is where the
//! object can only come by a leap; how uncertain a pose is about its place, the error bars say.

use crate::estimate::association::alternatives::Alternative;
use crate::estimate::association::candidates::{Choice, candidates, minima};
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::association::transitions::{Transition, near, steps, turn};
use crate::estimate::association::viterbi::Trellis;
use crate::estimate::evidence::motion_prior::{CERTAIN, UNSTABLE_POSE};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::force::balance_limit_m;
use crate::estimate::model::noise::Spread;
use crate::estimate::model::table::SupportTable;
use crate::estimate::solver::gauss_newton::Fit;
use crate::math::statistics::{correlation_time, median};
use crate::mechanics::passage::is_same_pose;
use crate::shape::SupportFunction;
use rayon::prelude::*;

/// A contact that moves by less than this share of the mean radius did not leap.
const STILL: f64 = 0.02;

/// A way is changed when that takes at least this much off its cost.
const WORTH_CHANGING: f64 = 9.0;

/// Standard deviation of a hill that errors of the shape feign where the object falls: as a share of that of a contact
/// position, and of the mean radius.
const BARRIER_SD: [f64; 2] = [0.03, 1e-4];

/// The most likely way through a log.
pub(crate) struct Decoded {
    /// One orientation for each sample.
    pub psi: Vec<f64>,
    /// Samples that it puts elsewhere than the fit did.
    pub moved: usize,
    /// For each sample, how much more a way costs (squared standard deviations) that puts it elsewhere.
    pub margin: Vec<f64>,
    /// Squared standard deviations by which each sample is missed.
    pub misfit: Vec<f64>,
    /// For samples that are not certain, the likeliest ways that put them elsewhere.
    pub alternatives: Vec<Alternative>,
}

impl Decoded {
    /// Whether the pose of a sample is open to doubt: another is not much less likely, or none explains it.
    pub fn doubts(&self, sample: usize) -> bool {
        self.margin[sample] < 2.0 * CERTAIN.deviance() || self.misfit[sample] > UNEXPLAINED
    }
}

/// Samples that were not fitted: they may lie on boundary that was not felt, wherever what the others tell of it lets them.
#[derive(Clone, Copy)]
pub(crate) struct Aside<'a> {
    /// In order.
    pub samples: &'a [usize],
    /// Those of which statics is not asked, since it foretells no better than the shape is known.
    pub doubtful: &'a (dyn Fn(usize) -> bool + Sync),
    /// The shape that the others leave.
    pub known: &'a PredictiveShape,
}

/// Tracks the fitted shape through the log. Contacts are never believed to be more exact than `floor_m`.
pub(crate) fn decode(measurements: &Measurements, fit: &Fit, floor_m: f64, aside: Option<Aside>) -> Decoded {
    let coefficients = &fit.estimate.coefficients;
    let (shape, table) = (SupportFunction::from_coefficients(coefficients), SupportTable::new(coefficients));
    let here = &fit.estimate.psi;
    let spread = spread(measurements, &table, here, floor_m.max(1e-5 * coefficients[0].abs()));
    let barrier_sd_m = BARRIER_SD[0] * spread.contact_m2.sqrt() + BARRIER_SD[1] * coefficients[0].abs();
    let contact_sd_m = spread.contact_m2.sqrt();
    let balance_m = spread.balance_m2.sqrt();
    let spoilt = balance_m > balance_limit_m(contact_sd_m, coefficients[0].abs());
    let still_m = if spoilt { STILL * coefficients[0].abs() + 6.0 * contact_sd_m } else { 0.0 };
    let anchor = anchor(here);
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
            for (psi, misfit) in candidates(&table, instant, spread, here[index]) {
                let misfit = misfit + instability_cost(psi);
                if !is_same_pose(psi, here[index]) {
                    choices.push(Choice { psi, misfit });
                } else if misfit + 1.0 < choices[0].misfit {
                    choices[0] = Choice { psi: here[index] + turn(here[index], psi), misfit };
                }
            }
            choices
        })
        .collect();
    if let Some(aside) = aside {
        reassociate(&mut choices, measurements, &table, balance_m, aside);
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
            };
            let blind = aside.is_some_and(|aside| (aside.doubtful)(index));
            steps(&ahead, &measurements.instants[index - 1], &choices[index - 1], &choices[index], blind)
        })
        .collect();
    let lattice = Trellis::new(&choices, &steps);
    let (way, cost) = lattice.best();
    let stay: f64 =
        choices.iter().map(|choices| choices[0].misfit).sum::<f64>() + steps.iter().map(|steps| steps[0]).sum::<f64>();
    let way = if cost + WORTH_CHANGING > stay { vec![0; choices.len()] } else { way };
    let along = |way: &[usize]| -> Vec<Choice> { way.iter().zip(&choices).map(|(&choice, all)| all[choice]).collect() };
    let chosen = along(&way);
    let psi: Vec<f64> = chosen.iter().map(|choice| choice.psi).collect();
    let elsewhere: Vec<(f64, usize)> = (0..psi.len()).map(|index| lattice.elsewhere(index, psi[index])).collect();
    let mut alternatives: Vec<(Vec<usize>, Vec<usize>)> = Vec::new();
    for (index, &(other, choice)) in
        elsewhere.iter().enumerate().filter(|(_, (other, _))| *other < cost + CERTAIN.deviance())
    {
        let alternative = lattice.through(index, choice);
        match alternatives.iter().position(|(known, _)| *known == alternative) {
            Some(known) => alternatives[known].1.push(index),
            None if other.is_finite() && alternatives.len() < MOST_ALTERNATIVES => {
                alternatives.push((alternative, vec![index]))
            }
            None => {}
        }
    }
    let prior_cost = |way: &[usize]| -> f64 {
        let poses = measurements.instants.iter().zip(along(way));
        let restless =
            poses.map(|(instant, choice)| instability_cost(&table, instant, choice.psi, balance_m)).sum::<f64>();
        restless + lattice.steps_along(way)
    };
    let of_way = prior_cost(&way);
    let alternatives = alternatives.into_iter().map(|(alternative, samples)| Alternative {
        psi: along(&alternative).iter().map(|choice| choice.psi).collect(),
        samples,
        motion_cost: prior_cost(&alternative) - of_way,
    });
    Decoded {
        alternatives: alternatives.collect(),
        psi,
        moved: way.iter().filter(|choice| **choice > 0).count(),
        margin: elsewhere.iter().map(|(other, _)| other - cost).collect(),
        misfit: chosen.iter().map(|choice| choice.misfit).collect(),
    }
}

/// Rivals that are looked up at the most.
const MOST_ALTERNATIVES: usize = 24;

/// Lets samples be wherever a shape that is known to within a Gaussian explains them.
fn reassociate(
    choices: &mut [Vec<Choice>],
    measurements: &Measurements,
    table: &SupportTable,
    balance_m: f64,
    Aside { samples, known, .. }: Aside,
) {
    let placed: Vec<Vec<Choice>> = samples
        .par_iter()
        .map(|&index| {
            let instant = &measurements.instants[index];
            let neg_log_predictive = |psi: f64| known.neg_log_predictive(instant, psi);
            let misfit = |psi: f64| neg_log_predictive(psi) + instability_cost(table, instant, psi, balance_m);
            let mut placed: Vec<Choice> =
                choices[index].iter().map(|choice| Choice { misfit: misfit(choice.psi), ..*choice }).collect();
            for (psi, _) in minima(choices[index][0].psi, &neg_log_predictive) {
                let misfit = misfit(psi);
                match placed.iter_mut().find(|choice| is_same_pose(choice.psi, psi)) {
                    Some(choice) if choice.misfit > misfit => {
                        *choice = Choice { psi: choice.psi + turn(choice.psi, psi), misfit };
                    }
                    Some(_) => {}
                    None => placed.push(Choice { psi, misfit }),
                }
            }
            placed
        })
        .collect();
    for (&index, placed) in samples.iter().zip(placed) {
        choices[index] = placed;
    }
}

/// What it costs to be at a pose that is no minimum of the potential energy: such a sample is not explained.
fn instability_cost(table: &SupportTable, instant: &Instant, psi: f64, balance_m: f64) -> f64 {
    if table.residuals(instant, psi).is_unstable(balance_m) { UNSTABLE_POSE.deviance() } else { 0.0 }
}

/// A sample missed by this many squared standard deviations is not explained.
const UNEXPLAINED: f64 = 16.0;

/// How far off contacts and balance usually are. Half of the samples at least are placed well; they tell it whatever the
/// others do.
fn spread(measurements: &Measurements, table: &SupportTable, psi: &[f64], floor_m: f64) -> Spread {
    let both_seen = || measurements.instants.iter().zip(psi).filter(|(instant, _)| instant.both_seen());
    let (mut contacts, balance): (Vec<f64>, Vec<f64>) = both_seen()
        .map(|(instant, psi)| {
            let [one, two, balance] = table.residuals(instant, *psi).value;
            ((instant.weight1 * one).powi(2) + (instant.weight2 * two).powi(2), balance)
        })
        .unzip();
    // The median of χ² with two degrees of freedom is 1.386, with one 0.455.
    let contact_m2 = (median(&mut contacts) / 1.386).max(floor_m * floor_m);
    let squares = median(&mut balance.iter().map(|balance| balance * balance).collect::<Vec<f64>>());
    let balance_m2 = (squares / 0.455).max(0.01 * floor_m * floor_m);
    // Bursts say nothing of how long friction pulls one way.
    let most = 3.0 * balance_m2.sqrt();
    let clipped: Vec<f64> = balance.iter().map(|balance| balance.clamp(-most, most)).collect();
    Spread { contact_m2, balance_m2, balance_memory: correlation_time(&clipped) }
}

/// The middle of the longest run of samples without a leap: what all else is placed against.
fn anchor(psi: &[f64]) -> usize {
    let mut edges = vec![0];
    edges.extend((1..psi.len()).filter(|&index| !near(psi[index - 1], psi[index])));
    edges.push(psi.len());
    let longest = edges.windows(2).max_by_key(|edge| edge[1] - edge[0]);
    longest.map_or(0, |edge| (edge[0] + edge[1]) / 2)
}

#[cfg(test)]
mod tests;
