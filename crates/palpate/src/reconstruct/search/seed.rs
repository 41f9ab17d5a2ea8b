//! Seeds: candidates over a run of windows from the search over h0, refined at decreasing noise, with which the beam search
//! begins (`docs/theory.md`, the search).

use super::initial_height::{from_initial_heights, from_rolling};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother, StoppingCriteria};
use crate::reconstruct::search::beam::{BeamSearch, EXPLAINED, misfit};
use crate::reconstruct::search::problem::{Calibrate, Problem};
use crate::reconstruct::search::schedule::{Found, covered_ranges};
use crate::reconstruct::search::tolerance::Tolerance;
use crate::reconstruct::search::windows::joined;
use rayon::prelude::*;
use std::ops::Range;

/// Numbers of harmonics of the search, in turn: few first, since many can explain a jump.
pub(crate) const ORDERS: [usize; 5] = [8, 12, 18, 28, 48];

/// Candidates of each seed at most: each is refined with every number of harmonics.
pub(crate) const CANDIDATES: usize = 8;

/// Misfit above which a seed with few harmonics is not nearly right, and more harmonics are not tried.
const NEARLY_RIGHT: f64 = 3000.0;

/// Number of harmonics with which a seed is begun anew: the motions that few prefer over nearly flat sides are too far from the right one.
const ANEW: usize = 18;

/// Candidates of a seed that are refined with more harmonics.
const REFINED: usize = 3;

/// Effort of the smoother for a candidate at one noise: candidates are ranked, not yet final.
const EFFORT: StoppingCriteria = StoppingCriteria { iterations: 15, tolerance: 1e-3 };

/// Candidates over a run of windows, best first, with their number of harmonics.
pub(crate) struct Seed {
    /// The windows.
    pub span: Range<usize>,
    pub candidates: Vec<Estimate>,
    pub order: usize,
    /// Squared residuals of the best per instant, at the noise of the search.
    pub misfit: f64,
}

impl Seed {
    /// Searches a run of windows for candidates.
    pub fn with_few_harmonics(problem: &Problem, span: Range<usize>) -> Option<Self> {
        let Problem { ref measurements, ref windows, tolerance, prior, .. } = *problem;
        let thin = joined(measurements, &windows[span.clone()]);
        let mut candidates = from_initial_heights(&thin, tolerance.loose(), prior, ORDERS[0]);
        candidates.truncate(CANDIDATES);
        if tolerance.is_of_contact_alone() {
            candidates.extend(from_rolling(&thin, tolerance.loose(), prior, ORDERS[0]));
        }
        let (misfit, candidates) = refined(&thin, &candidates, ORDERS[0], tolerance, prior)?;
        Some(Self { span, candidates, order: ORDERS[0], misfit })
    }

    /// A beam search that begins with this seed, its readings corrected by what the seed tells of the rig.
    pub fn beam_search<'a>(&self, problem: &Problem<'a>, calibrate: &Calibrate) -> BeamSearch<'a> {
        self.calibrated(problem, calibrate)
            .unwrap_or_else(|| BeamSearch::new(problem.clone(), (self.span.clone(), &self.candidates, self.order)))
    }

    /// The same; `None` where it tells nothing of the rig.
    pub fn calibrated<'a>(&self, problem: &Problem<'a>, calibrate: &Calibrate) -> Option<BeamSearch<'a>> {
        let problem = problem.corrected(calibrate(&self.found(problem))?);
        let thin = joined(&problem.measurements, &problem.windows[self.span.clone()]);
        let again = refined(&thin, &self.candidates, self.order, problem.tolerance, problem.prior);
        let candidates = again.map_or_else(|| self.candidates.clone(), |(_, candidates)| candidates);
        Some(BeamSearch::new(problem, (self.span.clone(), &candidates, self.order)))
    }

    /// The arrangement of its windows alone.
    pub fn found(&self, problem: &Problem) -> Found {
        let windows = &problem.windows[self.span.clone()];
        let (thin, ranges) = (joined(&problem.measurements, windows), covered_ranges(windows));
        let Problem { calibration, tolerance, .. } = *problem;
        Found { calibration, tolerance_m: tolerance.scatter_m, thin, ranges, estimates: self.candidates.clone() }
    }

    /// Tries more harmonics where few leave more than the noise (nearly flat sides, corners); whether that explained the run.
    pub fn add_harmonics(&mut self, problem: &Problem) -> bool {
        self.refine(problem, self.candidates.clone(), self.misfit, &ORDERS[1..]);
        self.is_explained_by_more()
    }

    /// Begins anew, where the candidates with few harmonics are to be left; whether that explained the run.
    pub fn begin_anew(&mut self, problem: &Problem) -> bool {
        let Problem { tolerance, prior, .. } = *problem;
        if !(EXPLAINED..NEARLY_RIGHT).contains(&self.misfit) {
            return false;
        }
        let thin = self.thin(problem);
        let mut candidates = from_initial_heights(&thin, tolerance.loose(), prior, ANEW);
        candidates.truncate(CANDIDATES);
        if let Some((misfit, candidates)) = refined(&thin, &candidates, ANEW, tolerance, prior) {
            let more: Vec<usize> = ORDERS.into_iter().filter(|order| *order > ANEW).collect();
            self.refine(problem, candidates, misfit, &more);
        }
        self.is_explained_by_more()
    }

    fn is_explained_by_more(&self) -> bool {
        self.order > ORDERS[0] && self.misfit < EXPLAINED
    }

    fn thin(&self, Problem { measurements, windows, .. }: &Problem) -> Measurements {
        joined(measurements, &windows[self.span.clone()])
    }

    /// Candidates, the best of which leaves such a misfit, with more and more harmonics; keeps what is better.
    fn refine(&mut self, problem: &Problem, mut candidates: Vec<Estimate>, mut last: f64, orders: &[usize]) {
        let Problem { ref windows, tolerance, prior, .. } = *problem;
        let thin = self.thin(problem);
        let samples = windows[self.span.clone()].iter().map(|window| window.range.len()).sum();
        let noise_misfit = tolerance.noise_misfit(thin.len(), samples);
        for &order in orders {
            // Only what is nearly right with few harmonics can be right with more.
            if !(noise_misfit..NEARLY_RIGHT).contains(&last) {
                break;
            }
            candidates.truncate(REFINED);
            let Some((misfit, better)) = refined(&thin, &candidates, order, tolerance, prior) else { break };
            if misfit < self.misfit {
                (self.misfit, self.order, self.candidates) = (misfit, order, better.clone());
            }
            (last, candidates) = (misfit, better);
        }
    }
}

/// Candidates refined at decreasing noise with a given number of harmonics, best first, and the misfit of the best.
fn refined(
    thin: &Measurements,
    candidates: &[Estimate],
    order: usize,
    tolerance: Tolerance,
    prior: Prior,
) -> Option<(f64, Vec<Estimate>)> {
    let sharp = tolerance.sharp();
    let mut refined: Vec<(f64, Estimate)> = candidates
        .par_iter()
        .map(|estimate| {
            let mut estimate = estimate.clone();
            for noise in [tolerance.loose(), sharp] {
                let smoother = Smoother::new(thin, order, noise, prior);
                estimate = smoother.run(estimate.coefficients, estimate.psi, EFFORT);
            }
            (misfit(thin, &estimate, sharp) / thin.len() as f64, estimate)
        })
        .filter(|(misfit, _)| misfit.is_finite())
        .collect();
    refined.sort_by(|a, b| a.0.total_cmp(&b.0));
    let least = refined.first()?.0;
    Some((least, refined.into_iter().map(|(_, estimate)| estimate).collect()))
}
