//! From a log to arrangements of its pieces, with no start given: seeds from the longest stretches that the search over the
//! height of the centre of mass explains alone, grown over the whole log until one arrangement explains all of it.

use std::ops::Range;

use rayon::prelude::*;

use super::grow::{Budget, EXPLAINED, Growth, Tolerance, misfit};
use super::pieces::pieces;
use super::place::best_orientation;
use super::problem::Problem;
use super::smooth::{Effort, Estimate, Prior, Smoother};
use super::start;
use super::windows::{Window, joined, spans, windows};
use crate::math::angle::wrapped;

/// Samples that the search works on; a longer log is thinned to about this many.
const SAMPLES: usize = 250;

/// How much less the balance is trusted than the contacts, in turn (at first, and when arrangements are judged): both alike;
/// then as exact as statics has it, for near-circular objects differ in little else; where that explains nothing
/// (friction, fast palms), hardly at all.
const BALANCES: [[f64; 2]; 3] = [[1.0, 1.0], [1.0, 0.3], [15.0, 15.0]];

/// What a log that is not arranged at all would cost per instant.
const MISSING: f64 = 10.0;

/// With a misfit above this few harmonics are not nearly right, and more are not tried.
const NEARLY: f64 = 1000.0;

/// Strain that a growth may come to, in turn: with more it waits until the others had their turn.
const STRAINS: [f64; 3] = [1.0, 2.0, f64::INFINITY];

/// Harmonics of the search, in turn.
const ORDERS: [usize; 4] = [8, 12, 18, 28];

/// Stretches that are searched for a seed.
const SPANS: usize = 16;

/// Seeds that are grown before the search gives up.
const SEEDS: usize = 6;

/// Candidates that each seed starts with.
const CANDIDATES: usize = 8;

/// Arrangements found.
pub(super) struct Found {
    /// The thinned instants that were arranged, in order of time.
    pub thin: Problem,
    /// Index ranges (of the whole problem) of the stretches that were arranged.
    pub ranges: Vec<Range<usize>>,
    /// Best first, over the instants of `thin`.
    pub estimates: Vec<Estimate>,
}

/// Searches, and hands each arrangement of the log that it finds to `accept` until that says enough. Most promising
/// first as far as can be known; an arrangement that does not explain the log only if there is no other.
pub(super) fn search(
    problem: &Problem,
    scatter_m: f64,
    prior: Prior,
    tell: &dyn Fn(f64),
    accept: &mut dyn FnMut(Found) -> bool,
) {
    let windows = windows(problem, &pieces(problem, scatter_m), SAMPLES);
    let mut poor: Option<(f64, Found)> = None;
    let mut any = false;
    for (number, balance) in BALANCES.into_iter().enumerate() {
        let tolerance = Tolerance { scatter_m, size_m: prior.size_m, balance };
        let tell = |share: f64| tell((number as f64 + share) / BALANCES.len() as f64);
        let enough = arrange(problem, &windows, tolerance, prior, &tell, &mut |cost, found| {
            if cost < EXPLAINED {
                any = true;
                return accept(found);
            }
            if poor.as_ref().is_none_or(|(champion, _)| cost < *champion) {
                poor = Some((cost, found));
            }
            false
        });
        if enough {
            return;
        }
        // Where arrangements that hold the balance were found, leaving the balance out makes none better.
        if any && number > 0 {
            return;
        }
    }
    if let Some((_, found)) = poor {
        accept(found);
    }
}

/// Hands arrangements with their cost per instant to `consider` until that says enough (true), or nothing is left to try.
fn arrange(
    problem: &Problem,
    windows: &[Window],
    tolerance: Tolerance,
    prior: Prior,
    tell: &dyn Fn(f64),
    consider: &mut dyn FnMut(f64, Found) -> bool,
) -> bool {
    let whole: usize = windows.iter().map(|window| window.range.len()).sum();
    let mut hand_over = |growth: Growth| {
        let arranged = growth.in_order_of_time();
        let Some(top) = arranged.hypotheses.first() else { return false };
        // What is not arranged counts as not explained.
        let covered: usize = arranged.windows.iter().map(|window| window.range.len()).sum();
        let missing = 1.0 - covered as f64 / whole as f64;
        let cost =
            misfit(&arranged.thin, &top.estimate, tolerance.sharp()) / arranged.thin.len() as f64 + MISSING * missing;
        let ranges = stretches(&arranged.windows);
        let estimates = arranged.hypotheses.into_iter().map(|hypothesis| hypothesis.estimate).collect();
        consider(cost, Found { thin: arranged.thin, ranges, estimates })
    };
    // Few harmonics first, over every stretch: many explain a short stretch with a jump in it as well. And first those stretches
    // that are explained as well as their noise allows, for as long as they are: with a little more to explain, a few harmonics
    // may hide a jump too.
    let mut seeds: Vec<Seed> = Vec::new();
    let mut strained: Vec<Growth> = Vec::new();
    let (mut budget, mut grown) = (Budget::default(), 0);
    for (number, span) in spans(windows).into_iter().take(SPANS).enumerate() {
        tell(0.4 * number as f64 / SPANS as f64);
        let Some(seed) = Seed::with_few_harmonics(windows, span, tolerance, prior) else { continue };
        if seed.misfit < EXPLAINED && grown < SEEDS && !budget.is_spent() {
            let mut growth = seed.growth(problem, windows, tolerance, prior);
            if growth.grow(&mut budget, STRAINS[0]) {
                grown += 1;
                if hand_over(growth) {
                    return true;
                }
            } else {
                strained.push(growth);
            }
        }
        seeds.push(seed);
    }
    for most in STRAINS.into_iter().skip(1) {
        let mut still = Vec::new();
        strained.sort_by(|a, b| a.strain().total_cmp(&b.strain()));
        for mut growth in std::mem::take(&mut strained) {
            if grown >= SEEDS || budget.is_spent() {
                break;
            }
            if growth.grow(&mut budget, most) {
                grown += 1;
                if hand_over(growth) {
                    return true;
                }
            } else {
                still.push(growth);
            }
        }
        strained = still;
    }
    let grown_to_the_end = |seed: &Seed, budget: &mut Budget| {
        let mut growth = seed.growth(problem, windows, tolerance, prior);
        growth.grow(budget, f64::INFINITY);
        growth
    };
    let (mut budget, mut richer) = (Budget::default(), 0);
    for (number, seed) in seeds.iter_mut().enumerate() {
        tell(0.5 + 0.5 * number as f64 / SPANS as f64);
        if seed.misfit < EXPLAINED || !seed.add_harmonics(windows, tolerance, prior) {
            continue;
        }
        richer += 1;
        if hand_over(grown_to_the_end(seed, &mut budget)) {
            return true;
        }
        if richer == SEEDS || budget.is_spent() {
            return false;
        }
    }
    let best = seeds.iter().min_by(|a, b| a.misfit.total_cmp(&b.misfit));
    best.filter(|_| grown + richer == 0).is_some_and(|seed| hand_over(grown_to_the_end(seed, &mut budget)))
}

/// Candidates over a run of windows, best first, with the number of harmonics that they took.
struct Seed {
    span: Range<usize>,
    candidates: Vec<Estimate>,
    order: usize,
    /// Squared residuals of the best per instant, at the noise of the search.
    misfit: f64,
}

impl Seed {
    /// Searches a run of windows for candidates.
    fn with_few_harmonics(windows: &[Window], span: Range<usize>, tolerance: Tolerance, prior: Prior) -> Option<Self> {
        let thin = joined(&windows[span.clone()]);
        let mut candidates = start::from_heights(&thin, tolerance.loose(), prior, ORDERS[0]);
        candidates.truncate(CANDIDATES);
        let (misfit, candidates) = polished(&thin, &candidates, ORDERS[0], tolerance, prior)?;
        Some(Self { span, candidates, order: ORDERS[0], misfit })
    }

    fn growth<'a>(&self, problem: &'a Problem, windows: &[Window], tolerance: Tolerance, prior: Prior) -> Growth<'a> {
        Growth::new(problem, windows, (self.span.clone(), &self.candidates, self.order), tolerance, prior)
    }

    /// Tries more harmonics where a few explain nothing (nearly flat sides, corners); whether they explain the run.
    fn add_harmonics(&mut self, windows: &[Window], tolerance: Tolerance, prior: Prior) -> bool {
        let thin = joined(&windows[self.span.clone()]);
        let mut candidates = self.candidates.clone();
        let mut last = self.misfit;
        for &order in &ORDERS[1..] {
            // Only what is nearly right with few harmonics can be right with more.
            if !(EXPLAINED..NEARLY).contains(&last) {
                break;
            }
            candidates.truncate(3);
            let Some((misfit, better)) = polished(&thin, &candidates, order, tolerance, prior) else { break };
            if misfit < self.misfit {
                (self.misfit, self.order, self.candidates) = (misfit, order, better.clone());
            }
            (last, candidates) = (misfit, better);
        }
        self.misfit < EXPLAINED
    }
}

/// Candidates smoothed at less and less noise with a given number of harmonics, best first, and the misfit of the best.
fn polished(
    thin: &Problem,
    candidates: &[Estimate],
    order: usize,
    tolerance: Tolerance,
    prior: Prior,
) -> Option<(f64, Vec<Estimate>)> {
    let judged_at = tolerance.sharp();
    let mut polished: Vec<(f64, Estimate)> = candidates
        .par_iter()
        .map(|estimate| {
            let mut estimate = estimate.clone();
            for noise in [tolerance.loose(), judged_at] {
                let smoother = Smoother::new(thin, order, noise, prior);
                let effort = Effort { iterations: 15, tolerance: 1e-3 };
                estimate = smoother.run(estimate.coefficients, estimate.psi, effort);
            }
            (misfit(thin, &estimate, judged_at) / thin.len() as f64, estimate)
        })
        .filter(|(misfit, _)| misfit.is_finite())
        .collect();
    polished.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = polished.first()?.0;
    Some((least, polished.into_iter().map(|(_, estimate)| estimate).collect()))
}

/// The index ranges that placed windows cover; windows that are joined make one range.
fn stretches(placed: &[Window]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for Window { range, joined, .. } in placed {
        match ranges.last_mut() {
            Some(last) if *joined && last.end == range.start => last.end = range.end,
            _ => ranges.push(range.clone()),
        }
    }
    ranges
}

/// The instants of a problem thinned to about `count`, never over the edge of a range.
pub(super) fn thinned_in_ranges(problem: &Problem, ranges: &[Range<usize>], count: usize) -> Problem {
    let total: usize = ranges.iter().map(|range| range.len()).sum();
    let run = (total / count.max(1)).max(1);
    let mut instants = Vec::new();
    for range in ranges {
        let piece = Problem { instants: problem.instants[range.clone()].to_vec() };
        instants.extend(piece.thinned_by(run).instants);
    }
    Problem { instants }
}

/// Orientations at the instants of `to`, from those known at the instants `from` (in order of time): interpolated inside the
/// arranged ranges, searched for everywhere else.
pub(super) fn carry_over(
    from: &Problem,
    psi: &[f64],
    coefficients: &[f64],
    to: &Problem,
    ranges: &[Range<usize>],
) -> Vec<f64> {
    let places: Vec<f64> = from.instants.iter().map(|instant| instant.position).collect();
    let tolerance = (1e-3 * coefficients[0]).powi(2);
    let mut carried = Vec::with_capacity(to.len());
    for instant in &to.instants {
        let range = ranges.iter().find(|range| range.contains(&(instant.position.round() as usize)));
        let known = range.and_then(|range| {
            let low = places.partition_point(|place| *place < range.start as f64 - 0.5);
            let high = places.partition_point(|place| *place < range.end as f64 - 0.5);
            (high > low).then(|| between(&places[low..high], &psi[low..high], instant.position))
        });
        let nearest = carried.last().copied().unwrap_or_else(|| psi.first().copied().unwrap_or(0.0));
        carried.push(known.unwrap_or_else(|| best_orientation(instant, coefficients, nearest, tolerance)));
    }
    carried
}

/// Linear interpolation, level beyond the ends.
fn between(places: &[f64], psi: &[f64], place: f64) -> f64 {
    let after = places.partition_point(|other| *other < place);
    if after == 0 {
        psi[0]
    } else if after == places.len() {
        psi[after - 1]
    } else {
        let share = (place - places[after - 1]) / (places[after] - places[after - 1]);
        psi[after - 1] + share * wrapped(psi[after] - psi[after - 1])
    }
}
