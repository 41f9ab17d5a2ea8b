//! The result of an optimum with the forces in balance (`docs/theory.md`, error bars), and what other models of the log add to its error bars.

use super::assemble::{Candidate, assemble};
use super::left_out::is_held_convex;
use super::mixture::{Mixture, OtherModel};
use super::uncertainty::{OfBalance, Uncertainty};
use crate::estimate::calibration::CalibrationPosterior;
use crate::estimate::evidence::other_models::{OtherModels, other_models};
use crate::estimate::solver::gauss_newton::Fit;
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::refine::job::{Job, Refined};
use crate::reconstruct::selection::is_checked;
use crate::shape::SupportFunction;

/// An optimum with the forces in balance, and what the log says of the rig there.
pub(crate) struct AtRest<'a> {
    job: &'a Job<'a>,
    refined: &'a Refined,
    calibration: Option<CalibrationPosterior>,
}

impl<'a> AtRest<'a> {
    pub fn new(job: &'a Job<'a>, refined: &'a Refined) -> Self {
        Self { job, refined, calibration: job.calibration_posterior(refined) }
    }

    /// Its result by itself.
    pub fn result(&self) -> Result<Candidate, ReconstructError> {
        self.assembled(&self.uncertainty()).ok_or(ReconstructError::NotSolvable)
    }

    /// A certified result of it with the error bars of a mixture, where it is held convex or the log does not check what it tells.
    pub fn widened(&self, result: Candidate) -> Candidate {
        let Fit { estimate, .. } = &self.refined.fine;
        let mut candidate = result;
        if candidate.result.is_certified()
            && is_held_convex(&estimate.coefficients)
            && let Some(richer) = self.job.with_more_harmonics(self.refined)
        {
            let richer = OtherModel::new(1.0, None, [estimate, &richer], &self.job.palms());
            candidate = self.mixed(vec![richer]).unwrap_or(candidate);
        }
        if candidate.result.is_certified() && !is_checked(&candidate.result) {
            candidate = self.among_others().unwrap_or(candidate);
        }
        candidate
    }

    fn uncertainty(&self) -> OfBalance<'_> {
        let Self { job, refined, calibration } = self;
        let calibration = calibration.as_ref().map(|posterior| (posterior, job.calibration, job.options.rig));
        OfBalance { measurements: &refined.measurements, fit: refined.fine.clone(), calibration }
    }

    fn assembled(&self, uncertainty: &dyn Uncertainty) -> Option<Candidate> {
        let Self { job, refined, .. } = self;
        let found = (&refined.ambiguity_rad[..], refined.symmetry);
        let (fit, limits) = (refined.fine.clone(), &job.options.limits);
        assemble(&job.log, &refined.measurements, fit, found, job.expected(), uncertainty, limits)
    }

    fn mixed(&self, others: Vec<OtherModel>) -> Option<Candidate> {
        let shape = SupportFunction::from_coefficients(&self.refined.fine.estimate.coefficients);
        self.assembled(&Mixture { answer: &self.uncertainty(), shape, others })
    }

    /// The result with the error bars of a mixture with other models of the log. `None` where they leave nothing to assemble.
    fn among_others(&self) -> Option<Candidate> {
        let Refined { measurements, fine, .. } = self.refined;
        let palms = self.job.palms();
        let OtherModels { fits, linear } = other_models(measurements, fine)?;
        let models: Vec<(f64, OfBalance)> = fits
            .into_iter()
            .map(|(weight, fit)| (weight, OfBalance { measurements, fit, calibration: None }))
            .collect();
        let others = models
            .iter()
            .map(|(weight, of)| OtherModel::new(*weight, Some(of), [&fine.estimate, &of.fit.estimate], &palms));
        let known = OtherModel::new(-1.0, None, [&fine.estimate, &linear], &palms);
        self.mixed(others.chain([known]).collect())
    }
}
