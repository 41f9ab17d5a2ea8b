//! Refinement where constants of the rig are open (`docs/theory.md`, calibration): they are estimated with the arrangement that the search
//! found, tolerantly at first; the log corrected by them is refined like that of a rig without errors, and the constants again with it.

use super::job::{Job, Refined};
use super::resample::carry_over;
use crate::estimate::calibration::{CONSTANTS, CalibrationPosterior, prior_sd};
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::search::schedule::Found;
use crate::reconstruct::search::segments::segments;

/// What errors of the rig leave in the contact positions once a shape has adapted to them, as a share of the errors.
const LEFT: f64 = 0.25;

/// Rounds of the rough estimate: the noise that it allows falls from that of the search to that of the sensors.
const ROUNDS: usize = 8;
const SHARPER: f64 = 0.5;

/// Effort of the smoother in each of them.
const EFFORT: StoppingCriteria = StoppingCriteria { iterations: 15, tolerance: 1e-5 };

/// Refinements with better constants at most, and the change of any direction, in standard deviations, that is none.
const RECALIBRATIONS: usize = 4;
const SETTLED_SDS: f64 = 0.1;

/// An arrangement at its optimum, and the job with the calibration that was estimated with it; `None` = as the rig was stated.
pub(crate) struct Solved<'a> {
    pub job: Option<Job<'a>>,
    pub refined: Refined,
}

impl Solved<'_> {
    /// Another optimum with the same calibration.
    pub fn with(&self, refined: Refined) -> Self {
        Self { job: self.job.clone(), refined }
    }
}

impl<'a> Job<'a> {
    /// Whether constants of the rig are open.
    fn is_open(&self) -> bool {
        prior_sd(&self.options.rig.tolerances) != [0.0; CONSTANTS]
    }

    /// Standard deviation of a contact position for the search, which knows nothing of the rig's errors: metres.
    pub fn search_scatter_m(&self) -> f64 {
        if !self.is_open() {
            return self.scatter_m;
        }
        let [zero1, zero2, ratio, angle1, angle2, surface, _] = prior_sd(&self.options.rig.tolerances);
        let far_m = 2.0 * self.prior.size_m;
        let errors = [zero1, zero2, far_m * ratio, far_m * angle1, far_m * angle2, surface];
        errors.into_iter().fold(self.scatter_m, |sum, error| sum.hypot(LEFT * error))
    }

    /// Takes one arrangement of the search to the optimum over all samples, the open constants of the rig included.
    pub fn solve(&self, found: &Found, arrangement: usize) -> Result<Solved<'a>, ReconstructError> {
        if !self.is_open() {
            return Ok(Solved { job: None, refined: self.refine(found, arrangement)? });
        }
        let mut job = self.roughly_calibrated(found, arrangement)?;
        let mut refined = job.refine(found, arrangement)?;
        for _ in 0..RECALIBRATIONS {
            // The constants of a wrong arrangement say nothing.
            if !refined.settled {
                break;
            }
            let Some(posterior) = job.calibration_posterior(&refined) else { break };
            if posterior.distance_sds() < SETTLED_SDS {
                break;
            }
            let better = job.improved(&posterior);
            let estimate = refined.fine.estimate.clone();
            let ranges = segments(&better.measurements, better.scatter_m);
            let found = Found { thin: better.measurements.clone(), ranges, estimates: vec![estimate] };
            refined = better.refine(&found, 0)?;
            job = better;
        }
        Ok(Solved { job: Some(job), refined })
    }

    /// What the log says of the constants at an optimum; `None` where none is open.
    pub fn calibration_posterior(&self, refined: &Refined) -> Option<CalibrationPosterior> {
        CalibrationPosterior::new(&self.log, &refined.measurements, &refined.fine, &self.options.rig, &self.calibration)
    }

    /// The same job with the constants at their optimum.
    fn improved(&self, posterior: &CalibrationPosterior) -> Self {
        let calibration = posterior.improved(&self.calibration, &self.options.rig.tolerances);
        Self::calibrated(self.raw, self.options, calibration)
    }

    /// With the constants that an arrangement of the search suggests.
    fn roughly_calibrated(&self, found: &Found, arrangement: usize) -> Result<Self, ReconstructError> {
        let start = found.estimates.get(arrangement).ok_or(ReconstructError::NotSolvable)?;
        let order = Layout::of_coefficients(&start.coefficients).order;
        let psi = carry_over(&found.thin, &start.psi, &start.coefficients, &self.measurements, &found.ranges);
        let mut estimate = Estimate { psi, ..start.clone() };
        let mut job = Self::calibrated(self.raw, self.options, self.calibration);
        let mut noise_m = self.search_scatter_m();
        for _ in 0..ROUNDS {
            let mut arranged = job.measurements.clone();
            let is_arranged = |index: usize| found.ranges.iter().any(|range| range.contains(&index));
            let others = arranged.instants.iter_mut().enumerate().filter(|(index, _)| !is_arranged(*index));
            others.for_each(|(_, instant)| instant.set_aside());
            let noise = Noise { sensor_m: noise_m, balance_m: noise_m };
            estimate =
                Smoother::new(&arranged, order, noise, self.prior).run(estimate.coefficients, estimate.psi, EFFORT);
            let fit = Fit { estimate: estimate.clone(), order, noise, prior: self.prior, log_evidence: 0.0 };
            let rig = &self.options.rig;
            let posterior = CalibrationPosterior::new(&job.log, &arranged, &fit, rig, &job.calibration)
                .ok_or(ReconstructError::NotSolvable)?;
            job = job.improved(&posterior);
            noise_m = (SHARPER * noise_m).max(job.scatter_m);
        }
        Ok(job)
    }
}
