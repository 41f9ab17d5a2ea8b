//! Beam search from a seed over the whole log, through jumps (`docs/theory.md`, the search).
//!
//! A seed is a run of windows that the search over h0 explained alone. From there, windows are placed one by one, with the
//! posterior of the shape given the placed ones as the prior (a Gaussian: the information matrix of the smoother):
//!
//! * a window joined to a placed one is *followed*: height and orientation carry over, the closed forms give its motion;
//! * a window after a jump is *searched*: every (h0, ψ0) of a grid is tried, the two unknowns of a segment.
//!
//! After each window every hypothesis is smoothed over everything it has placed, and ranked by the evidence, so that errors of
//! linearisation do not discard the right one. A window that none can explain (a jump hidden inside) is deferred. A wrong seed
//! may grow far, but with a normalized misfit well above 1: more squared residuals than the noise of the contacts explains. The
//! schedule defers such seeds.

use crate::estimate::association::motion_grid::{HEIGHTS, first_distinct, likely_motions};
use crate::estimate::association::predictive::PredictiveShape;
use crate::estimate::evidence::laplace::laplace_evidence;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::residuals;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::same_motion;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother, StoppingCriteria};
use crate::estimate::solver::posterior::Posterior;
use crate::reconstruct::search::problem::Problem;
use crate::reconstruct::search::tolerance::Tolerance;
use crate::reconstruct::search::windows::Window;
use crate::sensor::Calibration;
use following::Followed;
use rayon::prelude::*;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::ops::Range;

mod following;

/// Distinct trials that are kept for a second round, on more instants.
const SEMIFINALISTS: usize = 60;

/// Distinct trials that are kept for smoothing over the whole window.
const FINALISTS: usize = 12;

/// Placements of one window that each hypothesis may propose: with the beam they bound the work of a window.
const BRANCHES: usize = 4;

/// Hypotheses kept, the width of the beam: each is smoothed after every window.
const BEAM: usize = 8;

/// Distinct proposals that are taken to the sharp noise, where they are ranked.
const CONTENDERS: usize = 2 * BEAM;

/// Hypotheses further than this behind the best (−2 ln of the ratio of evidences) are dropped, and placements of a window: windows placed
/// later do not make up for more.
const MOST_BEHIND: f64 = 150.0;

/// Times that deferred windows are cut in two and tried again: to an eighth of their length.
const SPLITS: usize = 3;

/// Effort of the smoother for target a window, and for a hypothesis at one noise: both are ranked, not yet final.
const PLACING: StoppingCriteria = StoppingCriteria { iterations: 8, tolerance: 1e-3 };
const RANKING: StoppingCriteria = StoppingCriteria { iterations: 12, tolerance: 1e-3 };

/// Mean of 1 − cos of the differences up to which two placements of a window are the same: that of 5 degrees.
const SAME_PLACEMENT: f64 = 4e-3;

/// The same for two trials: that of 2 degrees.
const SAME_TRIAL: f64 = 6e-4;

/// Work of growing seeds with few harmonics, and again with more, in searches of a window with 8 harmonics, and the number of unknowns of those.
const BUDGET: f64 = 900.0;
const BUDGET_UNKNOWNS: f64 = 17.0;

/// Power of the number of unknowns with which the seconds of a search grow: 1.4 from 17 to 37, 1.7 from 17 to 57.
const GROWTH: f64 = 1.5;

/// A single window may have this many times the normalized misfit of the whole, since its few instants scatter more; and at most
/// this many times [`EXPLAINED`].
const WINDOW: f64 = 3.0;
const WINDOW_EXPLAINED: f64 = 2.0;

/// Squared residuals per instant (at the noise of the search) that still count as explained.
pub(crate) const EXPLAINED: f64 = 3.0;

/// Squared residuals of one instant that still count as explained: three standard deviations of all together.
const INSTANT_EXPLAINED: f64 = 9.0;

/// One arrangement of the windows placed so far.
#[derive(Clone)]
pub(crate) struct Hypothesis {
    pub estimate: Estimate,
    /// −2 ln of the evidence up to a constant, over the windows placed so far.
    pub score: f64,
}

/// The result of growing a seed.
pub(crate) struct Arranged {
    /// Placed windows, in order of time.
    pub windows: Vec<Window>,
    /// Their thinned instants, in order of time.
    pub thin: Measurements,
    /// Arrangements, best first, over the instants of `thin`.
    pub hypotheses: Vec<Hypothesis>,
}

/// Work that may still be done, in searches of a window with 8 harmonics (not in seconds: the result must not depend on the
/// machine).
pub(crate) struct Budget {
    left: f64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { left: BUDGET }
    }
}

impl Budget {
    fn charge(&mut self, searches: usize, order: usize) {
        self.left -= searches as f64 * (Layout::of_shape(order).unknowns() as f64 / BUDGET_UNKNOWNS).powf(GROWTH);
    }

    /// Share of it that is spent, 0 to 1.
    pub fn share_spent(&self) -> f64 {
        (1.0 - self.left / BUDGET).clamp(0.0, 1.0)
    }

    pub fn is_spent(&self) -> bool {
        self.left <= 0.0
    }
}

/// A seed growing over the whole log.
pub(crate) struct BeamSearch<'a> {
    /// What the measurements were corrected by.
    pub calibration: Calibration,
    measurements: Cow<'a, Measurements>,
    windows: Vec<Window>,
    order: usize,
    pub tolerance: Tolerance,
    prior: Prior,
    /// Where the instants of each window begin in `thin`.
    offset: Vec<Option<usize>>,
    /// Windows that no hypothesis explained.
    deferred: Vec<bool>,
    /// Times that windows were cut in two so far.
    splits: usize,
    /// The limit given to [`BeamSearch::grow`].
    largest_misfit: f64,
    /// Instants of the placed windows, in order of placing.
    thin: Measurements,
    /// Hypotheses, best first.
    beam: Vec<Hypothesis>,
}

impl<'a> BeamSearch<'a> {
    /// From `seeds`, candidates with `order` harmonics over the windows `seed`.
    pub fn new(problem: Problem<'a>, (seed, seeds, order): (Range<usize>, &[Estimate], usize)) -> Self {
        let Problem { calibration, measurements, windows, tolerance, prior } = problem;
        let (count, thin) = (windows.len(), measurements.of(Vec::new()));
        let mut beam_search = Self {
            calibration,
            measurements,
            windows,
            order,
            tolerance,
            prior,
            offset: vec![None; count],
            deferred: vec![false; count],
            splits: 0,
            largest_misfit: 0.0,
            thin,
            beam: Vec::new(),
        };
        for window in seed {
            beam_search.admit(window);
        }
        beam_search.beam = beam_search.ranked(&beam_search.thin, seeds.to_vec());
        beam_search
    }

    /// Tries to place one more window; false when none is left.
    fn advance(&mut self, budget: &mut Budget) -> bool {
        loop {
            if let Some((window, neighbour)) = self.next() {
                self.place(window, neighbour, budget);
                return true;
            }
            if self.splits == SPLITS || !self.split() {
                return false;
            }
            self.splits += 1;
        }
    }

    /// Grows until nothing is left to place or the budget is spent (true), or the normalized misfit exceeds `largest_misfit`
    /// (false). Windows deferred at a lower limit are tried again.
    pub fn grow(&mut self, budget: &mut Budget, largest_misfit: f64) -> bool {
        if self.largest_misfit < largest_misfit {
            self.largest_misfit = largest_misfit;
            self.deferred.fill(false);
        }
        while self.normalized_misfit() <= largest_misfit {
            if !self.advance(budget) || budget.is_spent() || self.is_spent() {
                return true;
            }
        }
        false
    }

    /// Whether nothing more is worth doing for the log.
    pub fn is_spent(&self) -> bool {
        self.measurements.work.is_spent()
    }

    /// Squared residuals of the best hypothesis per placed instant, at the noise at which arrangements are judged, over the
    /// largest value that is attributed to noise.
    pub fn normalized_misfit(&self) -> f64 {
        let Some(best) = self.beam.first() else { return f64::INFINITY };
        let placed = self.windows.iter().zip(&self.offset).filter(|(_, offset)| offset.is_some());
        let samples: usize = placed.map(|(window, _)| window.range.len()).sum();
        let misfit = misfit(&self.thin, &best.estimate, self.tolerance.sharp()) / self.thin.len() as f64;
        misfit / self.tolerance.noise_misfit(self.thin.len(), samples)
    }

    /// Adds a window to those placed.
    fn admit(&mut self, window: usize) {
        self.offset[window] = Some(self.thin.len());
        self.thin.instants.extend(&self.windows[window].thin.instants);
    }

    /// The window to place next, with the placed one that it is joined to, if any.
    fn next(&self) -> Option<(usize, Option<usize>)> {
        let open = |window: usize| self.offset[window].is_none() && !self.deferred[window];
        let count = self.windows.len();
        let after = (1..count).find(|&w| open(w) && self.windows[w].joined && self.offset[w - 1].is_some());
        if let Some(window) = after {
            return Some((window, Some(window - 1)));
        }
        let before = (1..count).rev().find(|&w| open(w - 1) && self.windows[w].joined && self.offset[w].is_some());
        if let Some(window) = before {
            return Some((window - 1, Some(window)));
        }
        let path_length = |w: &usize| self.windows[*w].path_length_m;
        (0..count).filter(|&w| open(w)).max_by(|a, b| path_length(a).total_cmp(&path_length(b))).map(|w| (w, None))
    }

    /// Cuts the deferred windows in two, in case a jump is hidden inside; false when there are none.
    fn split(&mut self) -> bool {
        let mut any = false;
        for window in (0..self.windows.len()).rev().filter(|&window| self.deferred[window]).collect::<Vec<_>>() {
            let halves = self.windows[window].halves(&self.measurements);
            any |= !halves.is_empty();
            self.offset.splice(window..=window, halves.iter().map(|_| None));
            self.deferred.splice(window..=window, halves.iter().map(|_| false));
            self.windows.splice(window..=window, halves);
        }
        any
    }

    /// Extends all hypotheses by a window, or defers it.
    fn place(&mut self, window: usize, neighbour: Option<usize>, budget: &mut Budget) {
        let (mut window, mut neighbour) = (window, neighbour);
        let mut followed = self.followed(window, neighbour);
        let of_best = followed.first().and_then(Option::as_ref).and_then(|best| best.reached);
        if let Some(cut) = neighbour.zip(of_best).and_then(|(other, reached)| self.cut(window, other, reached)) {
            (window, neighbour) = (cut.0, Some(cut.1));
            followed = self.followed(window, neighbour);
        }
        let target = &self.windows[window];
        let sharp = self.tolerance.sharp();
        let proposals: Vec<(bool, Vec<Estimate>)> = self
            .beam
            .par_iter()
            .zip(followed)
            .map(|(hypothesis, followed)| {
                let Some(Followed { belief, mut placements, explained, .. }) = followed else {
                    return (false, Vec::new());
                };
                if !explained {
                    placements.extend(self.search(target, &hypothesis.estimate, &belief));
                }
                let extended = placements
                    .into_iter()
                    .map(|placement| {
                        let mut estimate = hypothesis.estimate.clone();
                        estimate.coefficients = placement.coefficients;
                        estimate.psi.extend(placement.psi);
                        estimate
                    })
                    .collect();
                (!explained, extended)
            })
            .collect();
        budget.charge(proposals.iter().filter(|(searched, _)| *searched).count(), self.order);
        let proposals: Vec<Estimate> = proposals.into_iter().flat_map(|(_, extended)| extended).collect();
        let mut together = self.thin.clone();
        together.instants.extend(&target.thin.instants);
        let beam = self.ranked(&together, proposals);
        let explained = beam.first().is_some_and(|best| {
            let psi = best.estimate.psi[self.thin.len()..].to_vec();
            let estimate = Estimate { coefficients: best.estimate.coefficients.clone(), psi, cost: 0.0 };
            let noise_misfit = self.tolerance.noise_misfit(target.thin.len(), target.range.len());
            let most = (WINDOW * self.largest_misfit * noise_misfit).min(WINDOW_EXPLAINED * EXPLAINED);
            misfit(&target.thin, &estimate, sharp) < most * target.thin.len() as f64
        });
        if explained {
            self.beam = beam;
            self.admit(window);
        } else {
            self.deferred[window] = true;
        }
    }

    /// Placements of a window that is joined to no placed one, best first.
    fn search(&self, target: &Window, hypothesis: &Estimate, belief: &Posterior) -> Vec<Estimate> {
        let noise = self.tolerance.loose();
        let Some(covariance) = belief.covariance() else { return Vec::new() };
        let predictive = PredictiveShape::new(&hypothesis.coefficients, &covariance, noise);
        let scales = (self.prior.size_m, noise.sensor_m);
        let most = [SEMIFINALISTS, FINALISTS];
        let rolls = self.tolerance.is_of_contact_alone();
        let trials =
            likely_motions(&target.thin, HEIGHTS, scales, rolls, &predictive, most, differ_by_less_than(SAME_TRIAL));
        let whole = Smoother::with_belief(&target.thin, self.order, noise, self.prior, belief);
        let mut placements: Vec<Estimate> = trials
            .into_iter()
            .map(|psi| whole.run(hypothesis.coefficients.clone(), psi, PLACING))
            .filter(|estimate| estimate.cost.is_finite())
            .collect();
        placements.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let least = placements.first().map_or(0.0, |best| best.cost);
        placements.retain(|placement| placement.cost <= least + MOST_BEHIND);
        first_distinct(placements, BRANCHES, |placement| placement.psi.as_slice(), differ_by_less_than(SAME_PLACEMENT))
    }

    /// Smooths every proposal over everything placed, ranks them by evidence and keeps the best distinct ones.
    fn ranked(&self, placed: &Measurements, proposals: Vec<Estimate>) -> Vec<Hypothesis> {
        let smoother = |noise: Noise| Smoother::new(placed, self.order, noise, self.prior);
        let (loose, sharp) = (smoother(self.tolerance.loose()), smoother(self.tolerance.sharp()));
        let mut proposals: Vec<Estimate> = proposals
            .into_par_iter()
            .map(|estimate| loose.run_chord(estimate.coefficients, estimate.psi, RANKING))
            .filter(|estimate| estimate.cost.is_finite())
            .collect();
        proposals.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        // Hypotheses that were different may have become the same, and with it their proposals.
        let proposals =
            first_distinct(proposals, CONTENDERS, |estimate| estimate.psi.as_slice(), differ_by_less_than(SAME_TRIAL));
        let mut ranked: Vec<Hypothesis> = proposals
            .into_par_iter()
            .filter_map(|estimate| {
                let estimate = sharp.run(estimate.coefficients, estimate.psi, RANKING);
                // Of few windows, a wrong hypothesis is the one that presses hard on the nodes that hold the shape convex: here they count as measured.
                let normal = sharp.linearise(&estimate.coefficients, &estimate.psi);
                let score = -2.0 * laplace_evidence(&sharp, &estimate, &normal)?.log();
                score.is_finite().then_some(Hypothesis { estimate, score })
            })
            .collect();
        ranked.sort_by(|a, b| a.score.total_cmp(&b.score));
        let mut kept: Vec<Hypothesis> = Vec::new();
        for hypothesis in ranked {
            let far_behind = kept.first().is_some_and(|best| hypothesis.score > best.score + MOST_BEHIND);
            let duplicate = || kept.iter().any(|other| same_motion(&other.estimate.psi, &hypothesis.estimate.psi, TAU));
            if kept.len() < BEAM && !far_behind && !duplicate() {
                kept.push(hypothesis);
            }
        }
        kept
    }

    /// The placed windows and the hypotheses, in order of time.
    pub fn in_order_of_time(self) -> Arranged {
        let mut by_time: Vec<usize> = (0..self.thin.len()).collect();
        let place = |index: &usize| self.thin.instants[*index].position;
        by_time.sort_by(|a, b| place(a).total_cmp(&place(b)));
        let thin = self.thin.of(by_time.iter().map(|&index| self.thin.instants[index]).collect());
        let hypotheses = self
            .beam
            .into_iter()
            .map(|mut hypothesis| {
                hypothesis.estimate.psi = by_time.iter().map(|&index| hypothesis.estimate.psi[index]).collect();
                hypothesis
            })
            .collect();
        let mut windows = self.windows;
        let mut placed = self.offset.iter().map(Option::is_some);
        windows.retain(|_| placed.next() == Some(true));
        Arranged { windows, thin, hypotheses }
    }
}

/// Whether two motions differ in 1 − cos by less than `same` on average.
fn differ_by_less_than(same: f64) -> impl Fn(&[f64], &[f64]) -> bool {
    move |a, b| a.iter().zip(b).map(|(a, b)| 1.0 - (a - b).cos()).sum::<f64>() < same * b.len() as f64
}

/// Squared residuals of an estimate at a given noise, without the terms in the shape alone.
pub(crate) fn misfit(measurements: &Measurements, estimate: &Estimate, noise: Noise) -> f64 {
    squares(measurements, estimate, noise).sum()
}

/// Instants that an estimate explains.
pub(crate) fn explained(measurements: &Measurements, estimate: &Estimate, noise: Noise) -> usize {
    squares(measurements, estimate, noise).filter(|square| *square < INSTANT_EXPLAINED).count()
}

/// Squared residuals of each instant.
fn squares<'a>(measurements: &'a Measurements, estimate: &'a Estimate, noise: Noise) -> impl Iterator<Item = f64> + 'a {
    let sds = [noise.sensor_m, noise.sensor_m, noise.balance_m];
    let square = move |(instant, psi): (&Instant, &f64)| {
        let value = residuals(instant, &estimate.coefficients, *psi).value;
        value.iter().zip(sds).map(|(value, sd)| (value / sd).powi(2)).sum::<f64>()
    };
    measurements.instants.iter().zip(&estimate.psi).map(square)
}

#[cfg(test)]
mod tests;
