//! From a seed to the whole log: a start from nothing that goes through jumps.
//!
//! A seed is a run of windows that the search over h0 explained alone. From there, windows are placed one by one against the
//! belief that the placed ones leave of the shape (a Gaussian: the information matrix of the smoother):
//!
//! * a window joined to a placed one is *followed*: height and orientation carry over, the closed forms give its motion;
//! * a window behind a jump is *searched*: every (h0, ψ0) of a grid is tried, the two unknowns of a piece.
//!
//! After each window every hypothesis is smoothed over everything it has placed, and ranked by the evidence, so that errors of
//! linearisation cannot kill the right one. A window that none can explain (a jump hidden inside) is put off. A seed that is wrong
//! goes on for long, but under strain: with more squared residuals than the noise of the contacts would make. The search lets
//! those wait that are.

use crate::estimate::evidence::laplace::log_evidence;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::{contacts, residuals};
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::same_motion;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother, StoppingCriteria};
use crate::estimate::solver::posterior::Posterior;
use crate::reconstruct::search::closed_form::{integrate, relative_height};
use crate::reconstruct::search::windows::{Window, heights};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Trial heights for a window that is searched.
const HEIGHTS: usize = 20;

/// Trial orientations for a window that is searched.
const ORIENTATIONS: usize = 48;

/// Instants of a window on which the whole grid is tried.
const SPARSEST: usize = 5;

/// Trials that are looked at on more instants, and on how many.
const SEMIFINALISTS: usize = 120;

const SPARSE: usize = 12;

/// Trials that are smoothed over the whole window.
const FINALISTS: usize = 24;

/// Placements of one window that each hypothesis may propose.
const BRANCHES: usize = 4;

/// Hypotheses kept.
const BEAM: usize = 8;

/// Hypotheses further than this from the best (−2 log evidence) are given up.
const HOPELESS: f64 = 150.0;

/// Times that windows which nothing explains are cut in two and tried again.
const SPLITS: usize = 3;

/// An arrangement is plain when its misfit is at most so many times what noise would make it (two squares for each instant), or this.
const NOISE_MISFIT: f64 = 2.0;

const LEAST_NOISE_MISFIT: f64 = 0.5;

/// A window of a few instants may have so many times the strain of the whole.
const WINDOW: f64 = 3.0;

/// Squared residuals per instant (at the noise of the search) that still count as explained.
pub(crate) const EXPLAINED: f64 = 3.0;

/// One way to arrange the windows placed so far.
#[derive(Clone)]
pub(crate) struct Hypothesis {
    pub estimate: Estimate,
    /// −2 log evidence but for constants, over the windows placed so far.
    pub score: f64,
}

/// What growing came to.
pub(crate) struct Arranged {
    /// Placed windows, in order of time.
    pub windows: Vec<Window>,
    /// Their thinned instants, in order of time.
    pub thin: Measurements,
    /// Arrangements, best first, over the instants of `thin`.
    pub hypotheses: Vec<Hypothesis>,
}

/// The noise that the search believes in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    /// Scatter of the contact positions, metres.
    pub scatter_m: f64,
    /// Size of the object, metres.
    pub size_m: f64,
    /// How many times less the balance is trusted than the contacts, at first and when arrangements are judged.
    pub balance: [f64; 2],
}

impl Tolerance {
    /// At a share of the size, never below the scatter.
    fn at(&self, share: f64, balance: f64) -> Noise {
        let sd = (share * self.size_m).max(self.scatter_m);
        Noise { sensor_m: sd, balance_m: balance * sd }
    }

    /// So loose that no start is trapped by the sharp valley of the exact problem.
    pub fn loose(&self) -> Noise {
        self.at(0.01, self.balance[0])
    }

    /// The noise at which arrangements are judged.
    pub fn sharp(&self) -> Noise {
        self.at(0.003, self.balance[1])
    }

    /// The largest misfit per instant that is laid to the noise of samples thinned to so many instants.
    pub fn noise_misfit(&self, instants: usize, samples: usize) -> f64 {
        let noise = self.scatter_m / self.sharp().sensor_m;
        (NOISE_MISFIT * 2.0 * noise * noise * instants as f64 / samples.max(1) as f64)
            .clamp(LEAST_NOISE_MISFIT, EXPLAINED)
    }
}

/// Work that may still be done: searches of a window, counted in those with 8 harmonics. (Not seconds: the result must not
/// depend on the machine.)
pub(crate) struct Budget {
    left: f64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { left: 300.0 }
    }
}

impl Budget {
    fn charge(&mut self, searches: usize, order: usize) {
        self.left -= searches as f64 * (Layout::of_shape(order).unknowns() as f64 / 17.0).powi(2);
    }

    pub fn is_spent(&self) -> bool {
        self.left <= 0.0
    }
}

/// A seed on its way over the whole log.
pub(crate) struct BeamSearch<'a> {
    measurements: &'a Measurements,
    windows: Vec<Window>,
    order: usize,
    tolerance: Tolerance,
    prior: Prior,
    /// Where the instants of each window begin in `thin`.
    offset: Vec<Option<usize>>,
    put_off: Vec<bool>,
    /// How often windows were cut in two so far.
    splits: usize,
    /// See [`BeamSearch::grow`].
    largest_misfit: f64,
    thin: Measurements,
    beam: Vec<Hypothesis>,
}

impl<'a> BeamSearch<'a> {
    /// From `seeds`, candidates with `order` harmonics over the windows `seed`.
    pub fn new(
        measurements: &'a Measurements,
        windows: &[Window],
        (seed, seeds, order): (Range<usize>, &[Estimate], usize),
        tolerance: Tolerance,
        prior: Prior,
    ) -> Self {
        let mut beam_search = Self {
            measurements,
            windows: windows.to_vec(),
            order,
            tolerance,
            prior,
            offset: vec![None; windows.len()],
            put_off: vec![false; windows.len()],
            splits: 0,
            largest_misfit: 0.0,
            thin: Measurements { instants: Vec::new() },
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

    /// Goes on until nothing is left to place or the budget is spent (true), or for as long as the strain is at most this. What was
    /// put off before, when less was allowed, is tried again.
    pub fn grow(&mut self, budget: &mut Budget, largest_misfit: f64) -> bool {
        if self.largest_misfit < largest_misfit {
            self.largest_misfit = largest_misfit;
            self.put_off.fill(false);
        }
        while self.normalized_misfit() <= largest_misfit {
            if !self.advance(budget) || budget.is_spent() {
                return true;
            }
        }
        false
    }

    /// Squared residuals of the best hypothesis per instant placed, at the noise at which arrangements are judged, as a share of
    /// what noise alone would make them at the most.
    pub fn normalized_misfit(&self) -> f64 {
        let Some(best) = self.beam.first() else { return f64::INFINITY };
        let placed = self.windows.iter().zip(&self.offset).filter(|(_, offset)| offset.is_some());
        let samples: usize = placed.map(|(window, _)| window.range.len()).sum();
        let misfit = misfit(&self.thin, &best.estimate, self.tolerance.sharp()) / self.thin.len() as f64;
        misfit / self.tolerance.noise_misfit(self.thin.len(), samples)
    }

    fn admit(&mut self, window: usize) {
        self.offset[window] = Some(self.thin.len());
        self.thin.instants.extend(&self.windows[window].thin.instants);
    }

    /// The window to place next, with the placed one that it is joined to, if any.
    fn next(&self) -> Option<(usize, Option<usize>)> {
        let open = |window: usize| self.offset[window].is_none() && !self.put_off[window];
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

    /// Cuts the windows that were put off in two, so that what is hidden in them ends between them; false when there are none.
    fn split(&mut self) -> bool {
        let mut any = false;
        for window in (0..self.windows.len()).rev().filter(|&window| self.put_off[window]).collect::<Vec<_>>() {
            let halves = self.windows[window].halves(self.measurements);
            any |= !halves.is_empty();
            self.offset.splice(window..=window, halves.iter().map(|_| None));
            self.put_off.splice(window..=window, halves.iter().map(|_| false));
            self.windows.splice(window..=window, halves);
        }
        any
    }

    fn place(&mut self, window: usize, neighbour: Option<usize>, budget: &mut Budget) {
        let piece = &self.windows[window];
        let judged_at = self.tolerance.sharp();
        let proposals: Vec<(bool, Vec<Estimate>)> = self
            .beam
            .par_iter()
            .map(|hypothesis| {
                let Some(belief) = self.belief(&hypothesis.estimate) else { return (false, Vec::new()) };
                let followed = neighbour.and_then(|other| self.follow(window, other, &hypothesis.estimate, &belief));
                let explained = followed.as_ref().is_some_and(|estimate| {
                    misfit(&piece.thin, estimate, judged_at) < EXPLAINED * piece.thin.len() as f64
                });
                let mut placements: Vec<Estimate> = followed.into_iter().collect();
                if !explained {
                    placements.extend(self.search(piece, &hypothesis.estimate, &belief));
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
        together.instants.extend(&piece.thin.instants);
        let beam = self.ranked(&together, proposals);
        let explained = beam.first().is_some_and(|best| {
            let psi = best.estimate.psi[self.thin.len()..].to_vec();
            let estimate = Estimate { coefficients: best.estimate.coefficients.clone(), psi, cost: 0.0 };
            let noise_misfit = self.tolerance.noise_misfit(piece.thin.len(), piece.range.len());
            let most = (WINDOW * self.largest_misfit * noise_misfit).min(2.0 * EXPLAINED);
            misfit(&piece.thin, &estimate, judged_at) < most * piece.thin.len() as f64
        });
        if explained {
            self.beam = beam;
            self.admit(window);
        } else {
            self.put_off[window] = true;
        }
    }

    /// What the placed windows tell of the shape.
    fn belief(&self, known: &Estimate) -> Option<Posterior> {
        Smoother::new(&self.thin, self.order, self.tolerance.loose(), self.prior).belief(known)
    }

    /// Carries a hypothesis on from a placed window to the one before or after it.
    fn follow(&self, window: usize, neighbour: usize, known: &Estimate, belief: &Posterior) -> Option<Estimate> {
        const OVERLAP: usize = 6;
        let piece = &self.windows[window];
        let offset = self.offset[neighbour]?;
        let beside = &self.windows[neighbour].thin;
        let overlap = OVERLAP.min(beside.len());
        let forward = window > neighbour;
        let (run, anchor, keep) = if forward {
            let first = beside.len() - overlap;
            let mut run = beside.instants[first..].to_vec();
            run.extend(&piece.thin.instants);
            (
                Measurements { instants: run },
                (overlap - 1, offset + beside.len() - 1),
                overlap..overlap + piece.thin.len(),
            )
        } else {
            let mut run = piece.thin.instants.clone();
            run.extend(&beside.instants[..overlap]);
            (Measurements { instants: run }, (piece.thin.len(), offset), 0..piece.thin.len())
        };
        let (anchor, placed) = anchor;
        let relative = relative_height(&run);
        let at = &run.instants[anchor];
        let [_, height] = at.palms.center(contacts(at, &known.coefficients, known.psi[placed]).r);
        let h0 = height - relative[anchor];
        let noise = self.tolerance.loose();
        let smoother = Smoother::with_belief(&piece.thin, self.order, noise, self.prior, belief);
        [0.003, 0.01, 0.04]
            .into_iter()
            .map(|rate_sd| {
                let track = integrate(&run, &relative, h0, noise.sensor_m, rate_sd).psi;
                let turn = known.psi[placed] - track[anchor];
                let psi = track[keep.clone()].iter().map(|psi| psi + turn).collect();
                smoother.run(known.coefficients.clone(), psi, StoppingCriteria { iterations: 8, tolerance: 1e-3 })
            })
            .filter(|estimate| estimate.cost.is_finite())
            .min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// Ways to place a window that hangs on nothing, best first.
    fn search(&self, piece: &Window, known: &Estimate, belief: &Posterior) -> Vec<Estimate> {
        let noise = self.tolerance.loose();
        let Some((relative, (low, high))) = heights(&piece.thin, self.prior.size_m) else { return Vec::new() };
        let whole = Smoother::with_belief(&piece.thin, self.order, noise, self.prior, belief);
        let tracks: Vec<Vec<f64>> = (0..HEIGHTS)
            .map(|height| {
                let h0 = low + (high - low) * (height as f64 + 0.5) / HEIGHTS as f64;
                integrate(&piece.thin, &relative, h0, noise.sensor_m, 0.01).psi
            })
            .collect();
        let mut trials: Vec<(f64, usize, f64)> = (0..HEIGHTS * ORIENTATIONS)
            .map(|trial| (0.0, trial / ORIENTATIONS, TAU * (trial % ORIENTATIONS) as f64 / ORIENTATIONS as f64))
            .collect();
        for (instants, iterations, kept) in [(SPARSEST, 1, SEMIFINALISTS), (SPARSE, 2, FINALISTS)] {
            let every = piece.thin.len().div_ceil(instants);
            let few = Measurements { instants: piece.thin.instants.iter().step_by(every).copied().collect() };
            let sparse = Smoother::with_belief(&few, self.order, noise, self.prior, belief).without_convexity();
            for (cost, height, psi0) in &mut trials {
                let psi = tracks[*height].iter().step_by(every).map(|psi| psi + *psi0).collect();
                let effort = StoppingCriteria { iterations, tolerance: 1e-2 };
                *cost = sparse.run(known.coefficients.clone(), psi, effort).cost;
            }
            trials.retain(|(cost, _, _)| cost.is_finite());
            trials.sort_by(|a, b| a.0.total_cmp(&b.0));
            trials.truncate(kept);
        }
        let mut placements: Vec<Estimate> = trials
            .into_iter()
            .map(|(_, height, psi0)| {
                let psi = tracks[height].iter().map(|psi| psi + psi0).collect();
                whole.run(known.coefficients.clone(), psi, StoppingCriteria { iterations: 8, tolerance: 1e-3 })
            })
            .filter(|estimate| estimate.cost.is_finite())
            .collect();
        placements.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let mut kept: Vec<Estimate> = Vec::new();
        for placement in placements {
            let near = |other: &Estimate| {
                let apart = |(a, b): (&f64, &f64)| 1.0 - (a - b).cos();
                other.psi.iter().zip(&placement.psi).map(apart).sum::<f64>() < 4e-3 * placement.psi.len() as f64
            };
            if kept.len() < BRANCHES && !kept.iter().any(near) {
                kept.push(placement);
            }
        }
        kept
    }

    /// Smooths every proposal over everything placed, ranks them by evidence and keeps the best distinct ones.
    fn ranked(&self, placed: &Measurements, proposals: Vec<Estimate>) -> Vec<Hypothesis> {
        let mut polished: Vec<Hypothesis> = proposals
            .into_par_iter()
            .filter_map(|mut estimate| {
                for noise in [self.tolerance.loose(), self.tolerance.sharp()] {
                    let smoother = Smoother::new(placed, self.order, noise, self.prior);
                    let effort = StoppingCriteria { iterations: 12, tolerance: 1e-3 };
                    estimate = smoother.run(estimate.coefficients, estimate.psi, effort);
                }
                let smoother = Smoother::new(placed, self.order, self.tolerance.sharp(), self.prior);
                let normal = smoother.linearise(&estimate.coefficients, &estimate.psi);
                let factor = smoother.factor(&normal)?;
                let score = -2.0 * log_evidence(&smoother, &estimate, &normal, &factor);
                score.is_finite().then_some(Hypothesis { estimate, score })
            })
            .collect();
        polished.sort_by(|a, b| a.score.total_cmp(&b.score));
        let mut kept: Vec<Hypothesis> = Vec::new();
        for hypothesis in polished {
            let hopeless = kept.first().is_some_and(|best| hypothesis.score > best.score + HOPELESS);
            let known = || kept.iter().any(|other| same_motion(&other.estimate.psi, &hypothesis.estimate.psi));
            if kept.len() < BEAM && !hopeless && !known() {
                kept.push(hypothesis);
            }
        }
        kept
    }

    /// What was placed.
    pub fn in_order_of_time(self) -> Arranged {
        let mut by_time: Vec<usize> = (0..self.thin.len()).collect();
        let place = |index: &usize| self.thin.instants[*index].position;
        by_time.sort_by(|a, b| place(a).total_cmp(&place(b)));
        let thin = Measurements { instants: by_time.iter().map(|&index| self.thin.instants[index]).collect() };
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

/// Squared residuals of an estimate at a given noise, the shape's own terms left out.
pub(crate) fn misfit(measurements: &Measurements, estimate: &Estimate, noise: Noise) -> f64 {
    let sds = [noise.sensor_m, noise.sensor_m, noise.balance_m];
    let square = |(instant, psi): (&Instant, &f64)| {
        let value = residuals(instant, &estimate.coefficients, *psi).value;
        value.iter().zip(sds).map(|(value, sd)| (value / sd).powi(2)).sum::<f64>()
    };
    measurements.instants.iter().zip(&estimate.psi).map(square).sum()
}

#[cfg(test)]
mod tests;
