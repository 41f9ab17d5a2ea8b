//! Other rotations of a part of the log against the rest: of what lies behind a jump, between two, or at one of several poses that share no boundary
//! ([`super::shared_boundary`]). Where the parts share little of the boundary, contacts say little of the rotation between them: at a loose noise some shape explains a whole range of rotations, and a sharp
//! fit has an optimum of its own at many of them (`docs/theory.md`, the search).
//!
//! Here the rotation is profiled: at each, the shape has its optimum in closed form ([`ShapeGivenMotion`]); rotations that some shape explains
//! at the loose noise are taken to their sharp optimum, and the evidence compares them.

use crate::estimate::association::motion_grid::first_distinct;
use crate::estimate::association::part::Part;
use crate::estimate::association::shared_boundary::groups;
use crate::estimate::association::transitions::{is_same_pose, near};
use crate::estimate::evidence::laplace::laplace_evidence;
use crate::estimate::evidence::motion_prior::CERTAIN;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::{end_steps, same_motion};
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::estimate::solver::shape_given_motion::ShapeGivenMotion;
use crate::math::angle::wrapped_to;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Trial rotations: half a degree apart, from which contacts on a side that is nearly flat, with a radius of curvature ten times the size, are a few
/// loose standard deviations off. From 5 degrees they are so far off that the right rotation looks like all others.
const TURNS: usize = 720;

/// Noise of the trials, as a share of the size: loose, so that their grid is fine enough for it.
pub(crate) const LOOSE: f64 = 0.01;

/// A trial is a rival when it costs at most this much more for each instant than the present rotation.
const RIVAL_COST: f64 = 0.5;

/// Instants that the fit misses by more squared standard deviations than this at the loose noise say nothing of rotations: they are means
/// across a jump. Where more than a share of them are, the motion is wrong in other ways.
const EXPLAINED: f64 = 9.0;
const LEAST_EXPLAINED: f64 = 0.9;

/// Jumps above which the motion is lost.
const MOST_JUMPS: usize = 24;

/// Trials of one part that are taken to their optimum at most.
const MOST_POLISHED: usize = 24;

/// Trials that the loose noise leads to within this of each other, in every sample, lead to one optimum: radians.
const CLOSE_RAD: f64 = 0.03;

/// The same motion counts as another where its log evidence is larger by this, in nats: less is within what the effort of the smoother leaves.
const LIKELIER: f64 = 1.0;

/// Effort of the smoother for a trial at one noise.
const POLISHING: StoppingCriteria = StoppingCriteria { iterations: 15, tolerance: 1e-4 };

/// Optima with one part of the motion of a fit turned against the rest, the likeliest first: those that are not much less likely than the
/// fit, where so many samples share an error.
pub(crate) fn rival_rotations(measurements: &Measurements, fit: &Fit, samples_per_error: f64) -> Vec<Estimate> {
    let &Fit { order, noise, prior, .. } = fit;
    let period = prior.symmetry.period_rad();
    let sharp = Smoother::new(measurements, order, noise, prior);
    let weighed = |estimate: Estimate| {
        let normal = sharp.linearise_without_convexity(&estimate.coefficients, &estimate.psi);
        let evidence = laplace_evidence(&sharp, &estimate, &normal)?.log();
        evidence.is_finite().then_some((evidence, estimate))
    };
    let present = sharp.run(fit.estimate.coefficients.clone(), fit.estimate.psi.clone(), POLISHING);
    let Some((evidence, present)) = weighed(present) else { return Vec::new() };
    let sd_m = (LOOSE * prior.size_m).max(noise.sensor_m);
    let loose = Noise { sensor_m: sd_m, balance_m: sd_m };
    let is_same = |a: &[f64], b: &[f64]| same_motion(a, b, period);
    let is_close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| wrapped_to(a - b, period).abs() < CLOSE_RAD);
    let polished: Vec<Estimate> = trials(measurements, &present, loose, prior)
        .into_par_iter()
        .map(|Trial { part, omega, coefficients, .. }| {
            let psi = part.turned(&present.psi, omega);
            Smoother::new(measurements, order, loose, prior).run(coefficients, psi, POLISHING)
        })
        .filter(|polished| !is_close(&polished.psi, &present.psi))
        .collect();
    // Neighbouring trials often lead to one optimum.
    let mut rivals: Vec<(f64, Estimate)> =
        first_distinct(polished, usize::MAX, |polished| polished.psi.as_slice(), is_close)
            .into_par_iter()
            .filter_map(|polished| weighed(sharp.run(polished.coefficients, polished.psi, POLISHING)))
            .filter(|(of_rival, _)| (of_rival - evidence) / samples_per_error > -CERTAIN.0)
            .collect();
    rivals.sort_by(|a, b| b.0.total_cmp(&a.0));
    // A few degrees of a part are the same motion still, but where they are likelier.
    rivals.retain(|(of_rival, rival)| {
        (of_rival - evidence) / samples_per_error > LIKELIER || !is_same(&rival.psi, &present.psi)
    });
    first_distinct(rivals, usize::MAX, |(_, rival)| rival.psi.as_slice(), is_same)
        .into_iter()
        .map(|(_, rival)| rival)
        .collect()
}

/// A part of the log turned by `omega` against the rest.
pub(crate) struct Trial {
    /// Its least sum of squares at the loose noise, orientations given.
    pub cost: f64,
    pub part: Part,
    pub omega: f64,
    /// The shape of that cost.
    pub coefficients: Vec<f64>,
}

/// The rotations of each part that some shape explains about as well as the present one.
fn trials(measurements: &Measurements, present: &Estimate, loose: Noise, prior: Prior) -> Vec<Trial> {
    let period = prior.symmetry.period_rad();
    let psi = &present.psi;
    let mut jumps: Vec<usize> = (1..psi.len()).filter(|&index| !near(psi[index - 1], psi[index], period)).collect();
    // A part at another rotation may join the rest by a small step, where the shape has adapted to it.
    jumps.extend(end_steps(psi, period).into_iter().flatten());
    jumps.sort_unstable();
    jumps.dedup();
    let explained: Vec<usize> =
        (0..psi.len()).filter(|&index| is_explained(measurements, present, index, loose)).collect();
    if jumps.len() > MOST_JUMPS || (explained.len() as f64) < LEAST_EXPLAINED * psi.len() as f64 {
        return Vec::new();
    }
    let order = Layout::of_coefficients(&present.coefficients).order;
    let given = |samples: &[usize]| ShapeGivenMotion::of_samples(measurements, psi, samples, order, loose);
    turned_parts(parts(measurements, psi, &jumps, period), &explained, psi.len(), (prior, order), &given)
}

/// The parts of a motion that may lie otherwise against the rest: behind each of the jumps, between two, and pieces at one pose together.
pub(crate) fn parts(measurements: &Measurements, psi: &[f64], jumps: &[usize], period: f64) -> Vec<Part> {
    let behind = jumps.iter().map(|&jump| Part::from(jump..psi.len()));
    let between = jumps.windows(2).map(|jump| Part::from(jump[0]..jump[1]));
    let parts = behind.chain(between).chain(groups(measurements, psi, jumps, period));
    parts.filter(Part::can_turn).collect()
}

/// The rotations of such parts of `count` samples, of which those `explained` are asked; their equations are `given`.
pub(crate) fn turned_parts(
    parts: Vec<Part>,
    explained: &[usize],
    count: usize,
    (prior, order): (Prior, usize),
    given: &(dyn Fn(&[usize]) -> ShapeGivenMotion + Sync),
) -> Vec<Trial> {
    let of_part = |part: Part| {
        let (inside, outside): (Vec<usize>, Vec<usize>) = explained.iter().partition(|index| part.contains(**index));
        let (inside, mut rest) = (given(&inside), ShapeGivenMotion::of_prior(prior, order));
        rest += &given(&outside);
        let turned = |omega: f64| {
            let mut sum = inside.turned(omega);
            sum += &rest;
            sum.minimum().map(|(cost, coefficients)| Trial { cost, part: part.clone(), omega, coefficients })
        };
        let of_turn = |turn: usize| turned(TAU * turn as f64 / TURNS as f64);
        let costs: Vec<f64> =
            (0..TURNS).into_par_iter().map(|turn| of_turn(turn).map_or(f64::INFINITY, |trial| trial.cost)).collect();
        let most = costs[0] + RIVAL_COST * count as f64;
        let cost = |turn: usize| costs[turn % TURNS];
        let is_least = |&turn: &usize| cost(turn) <= cost(turn + TURNS - 1) && cost(turn) <= cost(turn + 1);
        let least = (0..TURNS).filter(|&turn| costs[0].is_finite() && cost(turn) < most).filter(is_least);
        let mut trials: Vec<Trial> = least.filter_map(of_turn).collect();
        trials.retain(|trial| !is_same_pose(0.0, trial.omega, prior.symmetry.period_rad()));
        trials.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        trials.truncate(MOST_POLISHED);
        trials
    };
    parts.into_par_iter().flat_map_iter(of_part).collect()
}

/// Whether an instant is explained at this noise.
fn is_explained(measurements: &Measurements, estimate: &Estimate, index: usize, noise: Noise) -> bool {
    let instant = &measurements.instants[index];
    let value = residuals(instant, &estimate.coefficients, estimate.psi[index]).value;
    let squares = value.iter().zip(noise.weights(instant)).map(|(value, weight)| (value * weight).powi(2));
    squares.sum::<f64>() < EXPLAINED
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::association::simulated::{fitted, thrown_square, thrown_triangle, turned_pebble};

    /// Logs with a jump in their middle: measurements, the optimum near the truth, and the first sample after the jump.
    fn with_a_jump() -> impl Iterator<Item = (Measurements, Fit, usize)> {
        (0..70).filter_map(|seed| {
            let (measurements, fit, starts) = thrown_triangle(seed)?;
            let middle = 40..measurements.len() - 40;
            let psi = &fit.estimate.psi;
            let is_jump = |&start: &usize| middle.contains(&start) && !near(psi[start - 1], psi[start], TAU);
            let start = starts.into_iter().find(is_jump)?;
            Some((measurements, fit, start))
        })
    }

    fn turned_from(fit: &Fit, start: usize, omega: f64) -> Estimate {
        let psi = Part::from(start..fit.estimate.psi.len()).turned(&fit.estimate.psi, omega);
        Estimate { psi, ..fit.estimate.clone() }
    }

    #[test]
    fn from_a_wrong_rotation_the_true_one_is_found() {
        let (mut wrong_ones, mut returned) = (0, 0);
        for (measurements, right, start) in with_a_jump() {
            let is_right = |psi: &[f64]| same_motion(psi, &right.estimate.psi, TAU);
            for omega in [1.0, 2.5, 4.0] {
                let Estimate { coefficients, psi, .. } = turned_from(&right, start, omega);
                let wrong = fitted(&measurements, coefficients, psi);
                // A log that determines the rotation contradicts a wrong one.
                if is_right(&wrong.estimate.psi) || wrong.estimate.cost > 2.0 * right.estimate.cost {
                    continue;
                }
                wrong_ones += 1;
                let rivals = rival_rotations(&measurements, &wrong, 1.0);
                returned += usize::from(rivals.iter().any(|rival| is_right(&rival.psi)));
            }
        }
        assert!(wrong_ones > 10 && returned * 3 >= wrong_ones * 2, "{returned} of {wrong_ones}");
    }

    #[test]
    fn only_rotations_that_some_shape_explains_are_tried() {
        let mut any = 0;
        for (measurements, fit, start) in with_a_jump().take(6) {
            let sd_m = LOOSE * fit.prior.size_m;
            let loose = Noise { sensor_m: sd_m, balance_m: sd_m };
            let explained: Vec<usize> = (0..measurements.len())
                .filter(|&index| is_explained(&measurements, &fit.estimate, index, loose))
                .collect();
            let cost_at = |omega: f64| {
                let psi = turned_from(&fit, start, omega).psi;
                let mut sum = ShapeGivenMotion::of_prior(fit.prior, fit.order);
                sum += &ShapeGivenMotion::of_samples(&measurements, &psi, &explained, fit.order, loose);
                sum.minimum().expect("determined").0
            };
            let trials = trials(&measurements, &fit.estimate, loose, fit.prior);
            let part = Part::from(start..measurements.len());
            let of_jump: Vec<&Trial> = trials.iter().filter(|trial| trial.part == part).collect();
            let most = cost_at(0.0) + RIVAL_COST * measurements.len() as f64;
            let costs: Vec<f64> = (0..TURNS).map(|turn| cost_at(TAU * turn as f64 / TURNS as f64)).collect();
            let is_least = |turn: &usize| {
                [TURNS - 1, 1].into_iter().all(|beside| costs[*turn] <= costs[(turn + beside) % TURNS] + 1e-6)
            };
            let is_elsewhere = |turn: &usize| !is_same_pose(0.0, TAU * *turn as f64 / TURNS as f64, TAU);
            let open: Vec<usize> = (0..TURNS).filter(|turn| costs[*turn] < most).filter(is_elsewhere).collect();
            assert!((1..TURNS / 2).contains(&open.len()), "{}", open.len());
            let rivals = open.into_iter().filter(is_least).count();
            assert_eq!(of_jump.len(), rivals.min(MOST_POLISHED), "of {} explained", explained.len());
            any += rivals;
            for trial in of_jump {
                assert!((trial.cost - cost_at(trial.omega)).abs() < 1e-6 * trial.cost, "{}", trial.omega);
            }
        }
        assert!(any > 0, "no rotation was tried");
    }

    #[test]
    fn a_rotation_that_a_nearly_flat_side_tells_is_tried() {
        let (mut tried, mut logs) = (0, 0);
        for seed in 0..40 {
            let Some((measurements, right, starts)) = thrown_square(seed) else { continue };
            let middle = 30..measurements.len() - 30;
            let Some(start) = starts.into_iter().find(|start| middle.contains(start)) else { continue };
            let sd_m = LOOSE * right.prior.size_m;
            let loose = Noise { sensor_m: sd_m, balance_m: sd_m };
            // With a shape that has adapted to a part at a wrong rotation.
            let Estimate { psi, .. } = turned_from(&right, start, 1.0);
            let all: Vec<usize> = (0..psi.len()).collect();
            let mut given = ShapeGivenMotion::of_prior(right.prior, right.order);
            given += &ShapeGivenMotion::of_samples(&measurements, &psi, &all, right.order, loose);
            let (cost, coefficients) = given.minimum().expect("determined");
            let wrong = Estimate { coefficients, psi, cost };
            let is_adapted = all.iter().filter(|index| is_explained(&measurements, &wrong, **index, loose)).count();
            if (is_adapted as f64) < LEAST_EXPLAINED * all.len() as f64 {
                continue;
            }
            logs += 1;
            let part = Part::from(start..measurements.len());
            let is_right =
                |trial: &Trial| trial.part == part && wrapped_to(trial.omega + 1.0, TAU).abs() < TAU / TURNS as f64;
            tried += usize::from(trials(&measurements, &wrong, loose, right.prior).iter().any(is_right));
        }
        assert!(tried == logs && logs > 1, "{tried} of {logs}");
    }

    #[test]
    fn errors_that_samples_share_leave_more_rotations_open() {
        let found = |samples_per_error: f64| -> usize {
            with_a_jump()
                .take(20)
                .map(|(measurements, fit, _)| rival_rotations(&measurements, &fit, samples_per_error).len())
                .sum()
        };
        let (own, shared) = (found(1.0), found(20.0));
        assert!(shared > own, "{shared} and {own}");
    }

    #[test]
    fn a_log_without_jumps_and_one_that_is_lost_have_no_rivals() {
        let (measurements, fit) = turned_pebble();
        assert!(rival_rotations(&measurements, &fit, 1.0).is_empty());
        let (measurements, fit, _) = with_a_jump().next().expect("a log");
        let mut lost = fit.clone();
        lost.estimate.psi.iter_mut().enumerate().for_each(|(index, psi)| *psi += f64::from(index as u32 / 7 % 2));
        let loose = Noise { sensor_m: 0.05 * fit.prior.size_m, balance_m: 0.05 * fit.prior.size_m };
        assert!(trials(&measurements, &lost.estimate, loose, fit.prior).is_empty());
    }
}
