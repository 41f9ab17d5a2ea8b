//! Refinement where constants of the rig are open (`docs/theory.md`, calibration): they are estimated with the arrangement that the search
//! found, tolerantly at first; the log corrected by them is refined like that of a rig without errors, and the constants again with it.

use super::job::{Job, Refined};
use super::rough_calibration::RoughCalibration;
use crate::estimate::calibration::{CONSTANTS, CalibrationPosterior, prior_sd};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise_from_log::scatter_with_memory_m;
use crate::estimate::solver::gauss_newton::Fit;
use crate::reconstruct::options::ReconstructOptions;
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::search::problem::Corrected;
use crate::reconstruct::search::schedule::{Found, Readings, TRUSTS};
use crate::reconstruct::search::segments::segments;
use crate::reconstruct::selection::Explored;
use crate::sensor::calibration::palm_rates_rad_per_s;

/// What errors of the rig leave in the contact positions once a shape has adapted to them, as a share of the errors. It depends on how they add
/// up: the search allows for one after the other until something explains the log.
pub(crate) const LEFT: [f64; TRUSTS] = [0.25, 0.5, 0.125];

/// Rounds in which constants and the rest take turns: most settle in two.
pub(super) const ROUNDS: usize = 8;

/// Refinements with better constants at most; each costs as much as that of a calibrated log.
const REFINEMENTS: usize = 4;

/// Change of the constants along any direction, in standard deviations, that leaves motion and number of harmonics; and one that is none.
const SAME_SDS: f64 = 1.0;
pub(super) const SETTLED_SDS: f64 = 0.1;

/// Trusts in the calibration of the rig that a search tries: where no constant is open, they are all the same.
pub(super) fn trusts(options: &ReconstructOptions) -> usize {
    if is_open(options) { TRUSTS } else { 1 }
}

fn is_open(options: &ReconstructOptions) -> bool {
    prior_sd(&options.rig.tolerances) != [0.0; CONSTANTS]
}

/// An arrangement at its optimum, and the job with the calibration that was estimated with it; `None` = as the rig was stated.
pub(crate) struct Solved<'a> {
    pub job: Option<Job<'a>>,
    pub refined: Refined,
    /// Others with a part of the log at another rotation that are about as likely.
    pub as_likely: Vec<Self>,
}

impl<'a> Job<'a> {
    /// Whether constants of the rig are open.
    pub(super) fn is_open(&self) -> bool {
        is_open(self.options)
    }

    /// Trusts in the calibration of the rig that a search tries.
    pub fn trusts(&self) -> usize {
        trusts(self.options)
    }

    /// What the search begins with.
    pub fn readings(&self) -> Readings<'_> {
        let sd = prior_sd(&self.options.rig.tolerances);
        let noise_m = self.noise_with_memory_m();
        let tolerances_m = LEFT.map(|left| self.tolerance_m(noise_m, &sd, left));
        let Self { calibration, ref measurements, scatter_m, prior, .. } = *self;
        Readings {
            calibration,
            measurements,
            scatter_m,
            tolerances_m,
            prior,
            brief: false,
            goes_on: &|_| true,
            from_elsewhere: &|| None,
        }
    }

    /// Standard deviation of a contact position, metres, with the errors that neighbouring samples share.
    fn noise_with_memory_m(&self) -> f64 {
        self.scatter_m.max(self.typical_m).max(scatter_with_memory_m(&self.measurements).unwrap_or(0.0))
    }

    /// The same for a search that knows the constants of the rig to these standard deviations, of which a share is left.
    fn tolerance_m(&self, noise_m: f64, sd: &[f64; CONSTANTS], left: f64) -> f64 {
        let [zero1, zero2, ratio, angle1, angle2, surface, clock] = *sd;
        let far_m = 2.0 * self.prior.size_m;
        let late_m = if clock > 0.0 { far_m * self.palm_rate_rad_per_s() * clock } else { 0.0 };
        let errors = [zero1, zero2, far_m * ratio, far_m * angle1, far_m * angle2, surface, late_m];
        errors.into_iter().fold(noise_m, |sum, error| sum.hypot(left * error))
    }

    /// How fast the palms turn: root mean square over the log.
    fn palm_rate_rad_per_s(&self) -> f64 {
        let rates = palm_rates_rad_per_s(self.raw);
        let squares = rates.iter().map(|[rate1, rate2]| rate1 * rate1 + rate2 * rate2).sum::<f64>();
        (squares / rates.len().max(1) as f64).sqrt()
    }

    /// The readings as a part of the log corrects them, where such a share of what is not known is left in the contacts.
    pub fn corrected(&self, found: &Found, left: f64) -> Option<Corrected> {
        let RoughCalibration { calibration, posterior, .. } = self.roughly_calibrated(found, 0)?;
        let tolerance_m = self.tolerance_m(self.noise_with_memory_m(), &posterior.sd(1.0), left);
        let measurements = self.recalibrated(self.raw, calibration).measurements;
        Some(Corrected { calibration, measurements, tolerance_m })
    }

    /// Takes one arrangement of the search to the optimum over all samples, the open constants of the rig included. `None` where that leads to a
    /// motion that is known.
    pub fn solve(
        &self,
        found: &Found,
        arrangement: usize,
        explored: &Explored,
    ) -> Result<Option<Solved<'a>>, ReconstructError> {
        if !self.is_open() {
            let Some(mut refined) = self.refine(found, arrangement, explored)? else { return Ok(None) };
            let as_likely = std::mem::take(&mut refined.as_likely);
            let same_rig = |refined| Solved { job: None, refined, as_likely: Vec::new() };
            let as_likely = as_likely.into_iter().map(same_rig).collect();
            return Ok(Some(Solved { as_likely, ..same_rig(refined) }));
        }
        let calibration = self.calibration_of(found, arrangement).ok_or(ReconstructError::NotSolvable)?;
        let work = self.measurements.work.clone();
        let mut job = Self::calibrated(self.raw, self.options, calibration, work, self.kept.clone());
        let Some(mut refined) = job.refine(found, arrangement, explored)? else { return Ok(None) };
        for _ in 0..REFINEMENTS {
            let as_likely = std::mem::take(&mut refined.as_likely);
            let (solved, moved_sds) = job.with_constants(refined);
            if moved_sds < SAME_SDS {
                let of_others = |other| job.with_constants(other).0;
                return Ok(Some(Solved { as_likely: as_likely.into_iter().map(of_others).collect(), ..solved }));
            }
            // Other constants may have another motion and number of harmonics.
            job = solved.job.unwrap_or(job);
            let (calibration, thin) = (job.calibration, job.measurements.clone());
            let ranges = segments(&thin, job.scatter_m);
            let estimates = vec![solved.refined.fine.estimate];
            let found = Found { calibration, tolerance_m: job.scatter_m, thin, ranges, estimates };
            refined = job.refine(&found, 0, &Explored::default())?.ok_or(ReconstructError::NotSolvable)?;
        }
        Ok(Some(job.with_constants(refined).0))
    }

    /// The constants at their optimum, with the motion near that of an optimum of all else and its number of harmonics; and how far they were
    /// from it, in standard deviations.
    fn with_constants(&self, mut refined: Refined) -> (Solved<'a>, f64) {
        let (mut job, mut moved_sds) = (self.clone(), 0.0_f64);
        // The constants of a wrong arrangement say nothing.
        for round in 0..if refined.settled { ROUNDS } else { 0 } {
            let Some(posterior) = job.posterior_of(&refined.measurements, &refined.fine) else { break };
            let distance_sds = posterior.distance_sds();
            if round == 0 {
                moved_sds = distance_sds;
            }
            if distance_sds < SETTLED_SDS {
                break;
            }
            let better = job.improved(&posterior);
            let Some(again) = better.refitted(&refined) else { break };
            (job, refined) = (better, again);
        }
        (Solved { job: Some(job), refined, as_likely: Vec::new() }, moved_sds)
    }

    /// What the log says of the constants at an optimum; `None` where none is open.
    pub fn calibration_posterior(&self, refined: &Refined) -> Option<CalibrationPosterior> {
        let Refined { measurements, fine, .. } = refined;
        Some(self.posterior_of(measurements, fine)?.borne_out_by(measurements, fine))
    }

    pub(super) fn posterior_of(&self, measurements: &Measurements, fit: &Fit) -> Option<CalibrationPosterior> {
        CalibrationPosterior::new(&self.log, measurements, fit, &self.options.rig, &self.calibration)
    }

    /// The same job with the constants at their optimum.
    pub(super) fn improved(&self, posterior: &CalibrationPosterior) -> Self {
        let calibration = posterior.improved(&self.calibration, &self.options.rig.tolerances);
        self.recalibrated(self.raw, calibration)
    }
}
