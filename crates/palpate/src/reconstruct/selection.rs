//! Which of several explanations of a log is the answer, and whether it is the only one.

use super::search::schedule::Found;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::force::balance_is_missed;
use crate::estimate::motion::same_motion;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::reconstruct::error::ReconstructError;
use crate::reconstruct::reconstruction::Reconstruction;
use crate::reconstruct::refine::job::{Job, Refined};
use crate::reconstruct::verdict::assemble::{Candidate, Expected, assemble};
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use rayon::prelude::*;

/// Explanations that are looked at besides the first, where the balance is missed.
const SECOND_THOUGHTS: usize = 2;

impl Candidate {
    /// Whether others are not worth a look, when so many that nothing speaks against were found (this one among them). Where
    /// nothing speaks against an answer, another would tell no more; but noise hides much, and then only the balance tells.
    pub fn is_enough(&self, explanations: usize) -> bool {
        let Reconstruction { sensor_sd_m, balance_sd_m, ref shape, .. } = self.result;
        let missed = balance_is_missed(sensor_sd_m, balance_sd_m, shape.mean_radius_m());
        explanations > if missed { SECOND_THOUGHTS } else { 0 }
    }

    /// Of results that nothing speaks against, the one with more evidence; of others, by jumps that cannot be, then by what
    /// the fit leaves.
    pub fn is_likelier_than(&self, other: &Self) -> bool {
        match (self.result.verdict.is_explained(), other.result.verdict.is_explained()) {
            (true, true) => self.log_evidence > other.log_evidence,
            (false, false) => self.doubt() < other.doubt(),
            (explained, _) => explained,
        }
    }

    fn doubt(&self) -> f64 {
        let impossible = self.result.jumps.iter().filter(|jump| !jump.physical).count();
        1e3 * impossible as f64 + self.result.chi2_per_dof.clamp(0.0, 999.0)
    }
}

impl Job<'_> {
    /// The result of an arrangement that was taken to its optimum.
    pub fn assemble(&self, refined: Refined) -> Result<Candidate, ReconstructError> {
        let expected = Expected { stated_m: self.stated_m, scatter_m: self.scatter_m };
        assemble(self.log, &refined.measurements, refined.fine, &refined.ambiguity_rad, expected, &self.options.limits)
            .ok_or(ReconstructError::NotSolvable)
    }

    /// Takes the arrangements that explain the log about equally well to their ends. Only those count that an object at
    /// rest could go through; when just one does, it is the answer.
    pub fn judge(&self, found: &Found) -> Result<Candidate, ReconstructError> {
        let first = self.refine(found, 0)?;
        let alternatives = alternatives(&found.thin, &found.estimates, &first.coarse);
        let mut results = vec![self.assemble(first)?];
        // An answer wants all of them ruled out; where nothing speaks against one that is not certified, they change nothing.
        let first = &results[0];
        let worth = if first.result.is_certified() {
            MOST_ALTERNATIVES
        } else if first.result.verdict.is_explained() {
            0
        } else {
            MOST_ALTERNATIVES / 2
        };
        for alternative in alternatives.into_iter().take(worth) {
            results.extend(self.refine(found, alternative).and_then(|refined| self.assemble(refined)));
        }
        let mut possible: Vec<Candidate> = Vec::new();
        let mut rest = Vec::new();
        for candidate in results {
            if !candidate.result.is_certified() {
                rest.push(candidate);
            } else if !possible.iter().any(|other| same_result(&other.result, &candidate.result)) {
                possible.push(candidate);
            }
        }
        possible.sort_by(|a, b| a.result.chi2_per_dof.total_cmp(&b.result.chi2_per_dof));
        let mut answers = possible.into_iter();
        let Some(mut answer) = answers.next() else {
            let likelier = |a: Candidate, b: Candidate| if b.is_likelier_than(&a) { b } else { a };
            return rest.into_iter().reduce(likelier).ok_or(ReconstructError::NotSolvable);
        };
        let result = &mut answer.result;
        result.others = answers.map(|candidate| candidate.result).collect();
        result.alternatives = 1 + result.others.len();
        if result.alternatives > 1 {
            result.verdict = Verdict::new(vec![Doubt::Alternatives { objects: result.alternatives }]);
        }
        Ok(answer)
    }
}

/// Whether two results are one, but for a common rotation and what noise makes of it.
fn same_result(a: &Reconstruction, b: &Reconstruction) -> bool {
    let psi = |result: &Reconstruction| -> Vec<f64> { result.motion.iter().map(|pose| pose.psi_rad).collect() };
    same_motion(&psi(a), &psi(b))
}

/// The arrangements but the first that explain the thinned log about as well as the chosen one, or better.
fn alternatives(thin: &Measurements, candidates: &[Estimate], chosen: &Fit) -> Vec<usize> {
    let smoother = Smoother::new(thin, chosen.order, chosen.noise, chosen.prior);
    let effort = StoppingCriteria { iterations: 20, tolerance: 1e-5 };
    let polished: Vec<Estimate> = candidates
        .par_iter()
        .map(|estimate| smoother.run(estimate.coefficients.clone(), estimate.psi.clone(), effort))
        .collect();
    let best = polished.iter().map(|estimate| estimate.cost).fold(f64::INFINITY, f64::min);
    (1..polished.len())
        .filter(|&index| polished[index].cost < best + NEAR_EQUAL)
        .filter(|&index| !polished[..index].iter().any(|other| same_motion(&other.psi, &polished[index].psi)))
        .take(MOST_ALTERNATIVES)
        .collect()
}

/// Rivals that are followed to the end, at the most.
const MOST_ALTERNATIVES: usize = 4;

/// Two arrangements whose sums of squares differ by less than this explain the log equally well.
const NEAR_EQUAL: f64 = 40.0;

#[cfg(test)]
mod tests;
