//! From a log to arrangements of its pieces, with no start given: seeds from the longest stretches that the search over the
//! height of the centre of mass explains alone, grown over the whole log until one arrangement explains all of it.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use super::grow::{EXPLAINED, Grown, grow, loose, misfit, sharp};
use super::pieces::pieces;
use super::problem::Problem;
use super::repair::best_orientation;
use super::smooth::{Effort, Estimate, Prior, Smoother};
use super::start;
use super::windows::{Window, joined, spans, windows};

/// Samples that the search works on; a longer log is thinned to about this many.
const SAMPLES: usize = 250;

/// Harmonics of the search, in turn: more where fewer explain nothing (nearly flat sides, corners).
const ORDERS: [usize; 3] = [8, 16, 28];

/// Stretches that are searched for a seed.
const SPANS: usize = 16;

/// Seeds that are grown before the best so far is taken.
const SEEDS: usize = 4;

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

/// Searches; `None` when no stretch is long enough or none can be at rest.
pub(super) fn search(problem: &Problem, scatter_m: f64, prior: Prior, tell: &dyn Fn(f64)) -> Option<Found> {
    let windows = windows(problem, &pieces(problem, scatter_m), SAMPLES);
    let mut best: Option<(f64, Grown)> = None;
    for (number, order) in ORDERS.into_iter().enumerate() {
        let tell = |share: f64| tell((number as f64 + share) / ORDERS.len() as f64);
        let next = arrange(&windows, order, scatter_m, prior, &tell);
        best = best.into_iter().chain(next).min_by(|a, b| a.0.total_cmp(&b.0));
        if best.as_ref().is_some_and(|(cost, _)| *cost < EXPLAINED) {
            break;
        }
    }
    let (_, arranged) = best?;
    let ranges = stretches(&windows, &arranged.windows);
    let estimates = arranged.hypotheses.into_iter().map(|hypothesis| hypothesis.estimate).collect();
    Some(Found { thin: arranged.thin, ranges, estimates })
}

/// The best arrangement with `order` harmonics, with its cost per instant.
fn arrange(
    windows: &[Window],
    order: usize,
    scatter_m: f64,
    prior: Prior,
    tell: &dyn Fn(f64),
) -> Option<(f64, Grown)> {
    let whole: usize = windows.iter().map(|window| window.thin.len()).sum();
    let judged_at = sharp(scatter_m, prior);
    let debug = std::env::var_os("DBG").is_some();
    let mut best: Option<(f64, Grown)> = None;
    let mut grown = 0;
    for (number, span) in spans(windows).into_iter().take(SPANS).enumerate() {
        tell(number as f64 / SPANS as f64);
        let thin = joined(&windows[span.clone()]);
        let mut seeds: Vec<Estimate> = start::from_heights(&thin, loose(0.01, scatter_m, prior), prior, order);
        seeds.truncate(CANDIDATES);
        let polish = |estimate: Estimate| {
            let smoother = Smoother::new(&thin, order + 2, judged_at, prior);
            smoother.run(estimate.coefficients, estimate.psi, Effort { iterations: 20, tolerance: 1e-3 })
        };
        let own = seeds
            .iter()
            .map(|estimate| misfit(&thin, &polish(estimate.clone()), judged_at) / thin.len() as f64)
            .fold(f64::INFINITY, f64::min);
        if debug {
            eprintln!("  K {order} span {span:?} of {} instants: own misfit {own:.2}, seeds {}", thin.len(), seeds.len());
        }
        let promising = own < EXPLAINED;
        if !promising && (number + 1 < SPANS || best.is_some()) {
            continue;
        }
        let arranged = grow(windows, span, seeds, order, scatter_m, prior);
        grown += 1;
        let Some(top) = arranged.hypotheses.first() else { continue };
        // What is not arranged counts as not explained.
        let missing = (whole - arranged.thin.len()) as f64;
        let cost = (misfit(&arranged.thin, &top.estimate, judged_at) + 10.0 * missing) / whole as f64;
        if debug {
            eprintln!("  grown to {} of {whole} instants, {} hypotheses, cost {cost:.2}", arranged.thin.len(), arranged.hypotheses.len());
        }
        if best.as_ref().is_none_or(|(champion, _)| cost < *champion) {
            best = Some((cost, arranged));
        }
        if best.as_ref().is_some_and(|(champion, _)| *champion < EXPLAINED) || grown == SEEDS {
            break;
        }
    }
    best
}

/// The index ranges that the placed windows cover; windows that are joined make one range.
fn stretches(windows: &[Window], placed: &[usize]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for &window in placed {
        let Window { range, joined, .. } = &windows[window];
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
        carried.push(known.unwrap_or_else(|| best_orientation(instant, coefficients, nearest, tolerance).1));
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
        let turn = (psi[after] - psi[after - 1] + PI).rem_euclid(TAU) - PI;
        psi[after - 1] + share * turn
    }
}
