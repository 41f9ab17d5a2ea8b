//! From a log to arrangements of its pieces, with no start given: seeds from the longest stretches that the search over the
//! height of the centre of mass explains alone, grown over the whole log until one arrangement explains all of it.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::reconstruct::search::beam::{BeamSearch, Budget, EXPLAINED, Tolerance, misfit};
use crate::reconstruct::search::seed::Seed;
use crate::reconstruct::search::segments::segments;
use crate::reconstruct::search::windows::{Window, spans, windows};
use std::ops::Range;

/// Samples that the search works on; a longer log is thinned to about this many.
const SAMPLES: usize = 250;

/// How much less the balance is trusted than the contacts, in turn (at first, and when arrangements are judged): both alike;
/// then as exact as statics has it, for near-circular objects differ in little else; where that explains nothing
/// (friction, fast palms), hardly at all.
const BALANCES: [[f64; 2]; 3] = [[1.0, 1.0], [1.0, 0.3], [15.0, 15.0]];

/// What a log that is not arranged at all would cost per instant.
const MISSING: f64 = 10.0;

/// Strain that a growth may come to, in turn: with more it waits until the others had their turn.
const MISFIT_LIMITS: [f64; 3] = [1.0, 2.0, f64::INFINITY];

/// Stretches that are searched for a seed.
const SPANS: usize = 16;

/// Seeds that are grown before the search gives up.
const SEEDS: usize = 6;

/// Arrangements found.
pub(crate) struct Found {
    /// The thinned instants that were arranged, in order of time.
    pub thin: Measurements,
    /// Index ranges (of the whole problem) of the stretches that were arranged.
    pub ranges: Vec<Range<usize>>,
    /// Best first, over the instants of `thin`.
    pub estimates: Vec<Estimate>,
}

/// Searches, and hands each arrangement of the log that it finds to `accept` until that says enough. Most promising
/// first as far as can be known; an arrangement that does not explain the log only if there is no other.
pub(crate) fn search(
    measurements: &Measurements,
    scatter_m: f64,
    prior: Prior,
    tell: &dyn Fn(f64),
    accept: &mut dyn FnMut(Found) -> bool,
) {
    let windows = windows(measurements, &segments(measurements, scatter_m), SAMPLES);
    let mut poor: Option<(f64, Found)> = None;
    let mut any = false;
    for (number, balance) in BALANCES.into_iter().enumerate() {
        let tolerance = Tolerance { scatter_m, size_m: prior.size_m, balance };
        let tell = |share: f64| tell((number as f64 + share) / BALANCES.len() as f64);
        let enough = arrange(measurements, &windows, tolerance, prior, &tell, &mut |cost, found| {
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
    measurements: &Measurements,
    windows: &[Window],
    tolerance: Tolerance,
    prior: Prior,
    tell: &dyn Fn(f64),
    consider: &mut dyn FnMut(f64, Found) -> bool,
) -> bool {
    let whole: usize = windows.iter().map(|window| window.range.len()).sum();
    let mut hand_over = |beam_search: BeamSearch| {
        let arranged = beam_search.in_order_of_time();
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
    let mut deferred: Vec<BeamSearch> = Vec::new();
    let (mut budget, mut grown) = (Budget::default(), 0);
    for (number, span) in spans(windows).into_iter().take(SPANS).enumerate() {
        tell(0.4 * number as f64 / SPANS as f64);
        let Some(seed) = Seed::with_few_harmonics(windows, span, tolerance, prior) else { continue };
        if seed.misfit < EXPLAINED && grown < SEEDS && !budget.is_spent() {
            let mut beam_search = seed.beam_search(measurements, windows, tolerance, prior);
            if beam_search.grow(&mut budget, MISFIT_LIMITS[0]) {
                grown += 1;
                if hand_over(beam_search) {
                    return true;
                }
            } else {
                deferred.push(beam_search);
            }
        }
        seeds.push(seed);
    }
    for most in MISFIT_LIMITS.into_iter().skip(1) {
        let mut still = Vec::new();
        deferred.sort_by(|a, b| a.normalized_misfit().total_cmp(&b.normalized_misfit()));
        for mut beam_search in std::mem::take(&mut deferred) {
            if grown >= SEEDS || budget.is_spent() {
                break;
            }
            if beam_search.grow(&mut budget, most) {
                grown += 1;
                if hand_over(beam_search) {
                    return true;
                }
            } else {
                still.push(beam_search);
            }
        }
        deferred = still;
    }
    let grown_to_the_end = |seed: &Seed, budget: &mut Budget| {
        let mut beam_search = seed.beam_search(measurements, windows, tolerance, prior);
        beam_search.grow(budget, f64::INFINITY);
        beam_search
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
