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
use crate::reconstruct::result::reconstruction::Reconstruction;
use crate::reconstruct::selection::is_checked;
use crate::shape::SupportFunction;

/// Standard deviation of the felt boundary, as a share of the mean radius, up to which the curvature of the likelihood says what is known. The valleys of
/// what is known less bend: a nearly round object that hangs from its palms by its centre of mass, known to 1 to 2 % by the curvature, was known to 20 %
/// and less along its valley; of 200 results through jumps none was, and for some of those above half of this the mixture said twice the same.
const PRECISE: f64 = 5e-3;

fn is_precise(result: &Reconstruction) -> bool {
    let largest_m = result.findings.as_ref().map_or(f64::INFINITY, |findings| findings.largest_felt_r_sd_m);
    largest_m <= PRECISE * result.shape.mean_radius_m().abs()
}

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

    /// A certified result of it with the error bars of a mixture, where it is held convex, or the log does not check what it tells or tells it roughly.
    pub fn widened(&self, result: Candidate) -> Candidate {
        if !result.result.is_certified() {
            return result;
        }
        let Fit { estimate, .. } = &self.refined.fine;
        let held = is_held_convex(&estimate.coefficients);
        let richer = if held { self.job.with_more_harmonics(self.refined) } else { None };
        let richer = richer.map(|richer| OtherModel::new(1.0, None, [estimate, &richer], &self.job.palms()));
        let widened = if !is_checked(&result.result) || !is_precise(&result.result) {
            self.among_others(richer)
        } else {
            richer.and_then(|richer| self.mixed(vec![richer]))
        };
        widened.unwrap_or(result)
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

    /// The result with the error bars of a mixture with other models of the log, and one that is known already. `None` where they leave nothing to assemble.
    fn among_others(&self, also: Option<OtherModel>) -> Option<Candidate> {
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
        self.mixed(others.chain([known]).chain(also).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::reconstruct::ReconstructOptions;
    use crate::reconstruct::refine::calibrated::Solved;
    use crate::reconstruct::selection::Explored;
    use crate::reconstruct::start::arrangement_of;
    use crate::reconstruct::verdict::certificate::Findings;
    use crate::sensor::Touchpad;
    use crate::simulate::{SimulateOptions, simulate};

    /// The curvature's and the mixture's result of a nearly round object that hangs from its palms, from the truth.
    fn of_nearly_round() -> [Reconstruction; 2] {
        let harmonics = vec![[-3.3e-3, 0.0], [0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2], [1.6e-5, 0.0]];
        let shape = SupportFunction::new(0.02, harmonics);
        let motion = PalmMotion::random(6, 40.0, 0.7).and_then(|motion| motion.sample(10.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
        let options = SimulateOptions { touchpad, ..SimulateOptions::default() };
        let run = simulate(&shape, &motion, &options).expect("possible");
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let found = arrangement_of(&job, job.measurements.clone(), &shape, psi);
        let solved = job.solve(&found, 0, &Explored::default()).expect("solvable");
        let Solved { refined, .. } = solved.expect("an optimum");
        let at_rest = AtRest::new(&job, &refined);
        let by_curvature = at_rest.result().expect("determined");
        [by_curvature.result.clone(), at_rest.widened(by_curvature).result]
    }

    #[test]
    fn what_is_known_roughly_is_known_less_than_the_curvature_says() {
        let [by_curvature, widened] = of_nearly_round();
        assert!(by_curvature.is_certified() && is_checked(&by_curvature) && !is_precise(&by_curvature));
        assert!(!widened.is_certified(), "{}", widened.verdict);
        let known_to = |share: f64| {
            let findings = by_curvature.findings.clone().map(|findings| Findings {
                largest_felt_r_sd_m: share * by_curvature.shape.mean_radius_m(),
                ..findings
            });
            is_precise(&Reconstruction { findings, ..by_curvature.clone() })
        };
        assert!(known_to(0.999 * PRECISE) && !known_to(1.001 * PRECISE));
    }
}
