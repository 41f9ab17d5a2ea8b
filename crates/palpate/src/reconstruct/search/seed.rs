//! Candidates over a run of windows, from nothing: what a search over the whole log begins with.

use super::initial_height::from_initial_heights;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother, StoppingCriteria};
use crate::reconstruct::search::beam::{BeamSearch, EXPLAINED, Tolerance, misfit};
use crate::reconstruct::search::windows::{Window, joined};
use rayon::prelude::*;
use std::ops::Range;

/// Harmonics of the search, in turn.
pub(crate) const ORDERS: [usize; 4] = [8, 12, 18, 28];

/// Candidates that each seed starts with.
pub(crate) const CANDIDATES: usize = 8;

/// With a misfit above this few harmonics are not nearly right, and more are not tried.
const NEARLY: f64 = 1000.0;

/// Candidates over a run of windows, best first, with the number of harmonics that they took.
pub(crate) struct Seed {
    pub span: Range<usize>,
    pub candidates: Vec<Estimate>,
    pub order: usize,
    /// Squared residuals of the best per instant, at the noise of the search.
    pub misfit: f64,
}

impl Seed {
    /// Searches a run of windows for candidates.
    pub fn with_few_harmonics(
        windows: &[Window],
        span: Range<usize>,
        tolerance: Tolerance,
        prior: Prior,
    ) -> Option<Self> {
        let thin = joined(&windows[span.clone()]);
        let mut candidates = from_initial_heights(&thin, tolerance.loose(), prior, ORDERS[0]);
        candidates.truncate(CANDIDATES);
        let (misfit, candidates) = polished(&thin, &candidates, ORDERS[0], tolerance, prior)?;
        Some(Self { span, candidates, order: ORDERS[0], misfit })
    }

    pub fn beam_search<'a>(
        &self,
        measurements: &'a Measurements,
        windows: &[Window],
        tolerance: Tolerance,
        prior: Prior,
    ) -> BeamSearch<'a> {
        BeamSearch::new(measurements, windows, (self.span.clone(), &self.candidates, self.order), tolerance, prior)
    }

    /// Tries more harmonics where a few explain nothing (nearly flat sides, corners); whether they explain the run.
    pub fn add_harmonics(&mut self, windows: &[Window], tolerance: Tolerance, prior: Prior) -> bool {
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
    thin: &Measurements,
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
                let effort = StoppingCriteria { iterations: 15, tolerance: 1e-3 };
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
