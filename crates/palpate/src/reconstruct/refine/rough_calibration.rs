//! What one arrangement of the search tells of the constants of the rig (`docs/theory.md`, calibration), before its motion is decoded: roughly, with the
//! few harmonics of the search, and then with the harmonics that the evidence asks for. The nearer they are to their optimum, the less of the
//! refinement with them has to be done again.

use super::calibrated::{ROUNDS, SETTLED_SDS};
use super::job::{Job, ORDER_SAMPLES};
use super::resample::carry_over;
use crate::estimate::calibration::CalibrationPosterior;
use crate::estimate::evidence::fit::fit;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::estimate::thinning::Thinning;
use crate::reconstruct::search::schedule::Found;
use crate::sensor::Calibration;
use std::ops::Range;

/// Factor by which the noise that is allowed falls from round to round: from that of the search to that of the sensors.
const SHARPER: f64 = 0.5;

/// Effort of the smoother in each of them.
const EFFORT: StoppingCriteria = StoppingCriteria { iterations: 15, tolerance: 1e-5 };

/// Change of the constants along any direction, in standard deviations, after which a refinement with them has little to change: well within what leaves
/// motion and number of harmonics.
const CLOSE_SDS: f64 = 0.5;

/// Updates of the noise in each round with all samples: the next round makes another.
const NOISE_UPDATES: usize = 1;

/// The constants that an arrangement suggests, with its shape and motion at the means of runs of samples.
pub(super) struct RoughCalibration {
    pub calibration: Calibration,
    /// How well they are known.
    pub posterior: CalibrationPosterior,
    means: Measurements,
    /// The same, corrected by these constants.
    corrected: Measurements,
    estimate: Estimate,
    /// The noise of a sample, as a multiple of that of the means.
    averaged: f64,
}

impl Job<'_> {
    /// With the harmonics that an arrangement of the search has; `None` where no constant is open, or it tells nothing.
    pub(super) fn roughly_calibrated(&self, found: &Found, arrangement: usize) -> Option<RoughCalibration> {
        if !self.is_open() {
            return None;
        }
        let start = found.estimates.get(arrangement)?;
        let order = Layout::of_coefficients(&start.coefficients).order;
        let thinning = Thinning::to(&self.measurements, &found.ranges, self.scatter_m, ORDER_SAMPLES);
        let runs: Vec<Range<usize>> =
            found.ranges.iter().flat_map(|range| thinning.runs(&self.measurements, range)).collect();
        let (means, raw) = self.measurements.means_with_samples(&runs, self.raw);
        let psi = carry_over(&found.thin, &start.psi, &start.coefficients, &means, &found.ranges);
        let mut estimate = Estimate { psi, ..start.clone() };
        let mut job = self.recalibrated(&raw, found.calibration);
        let samples: usize = found.ranges.iter().map(|range| range.len()).sum();
        let averaged = (samples as f64 / means.len().max(1) as f64).sqrt();
        let least_m = self.typical_m / averaged;
        let mut noise_m = found.tolerance_m;
        let mut last = None;
        for _ in 0..ROUNDS {
            let noise = Noise { sensor_m: noise_m, balance_m: noise_m };
            let smoother = Smoother::new(&job.measurements, order, noise, self.prior);
            estimate = smoother.run(estimate.coefficients, estimate.psi, EFFORT);
            let fit = Fit { estimate: estimate.clone(), order, noise, prior: self.prior, evidence: Evidence::NONE };
            let posterior = job.posterior_of(&job.measurements, &fit)?;
            let has_settled = noise_m <= least_m && posterior.distance_sds() < SETTLED_SDS;
            job = self.recalibrated(&raw, job.improved(&posterior).calibration);
            last = Some((job.calibration, posterior));
            if has_settled {
                break;
            }
            noise_m = (SHARPER * noise_m).max(least_m);
        }
        let (calibration, posterior) = last?;
        Some(RoughCalibration { calibration, posterior, means, corrected: job.measurements, estimate, averaged })
    }

    /// The same with the number of harmonics chosen by the evidence and over all samples that are arranged, as far as they can be fitted.
    pub(super) fn calibration_of(&self, found: &Found, arrangement: usize) -> Option<Calibration> {
        let rough = self.roughly_calibrated(found, arrangement)?;
        Some(self.closely_calibrated(found, &rough).unwrap_or(rough.calibration))
    }

    fn closely_calibrated(&self, found: &Found, rough: &RoughCalibration) -> Option<Calibration> {
        let Fit { mut estimate, order, mut noise, mut prior, .. } = self.with_order(rough)?;
        let each: Vec<Range<usize>> =
            found.ranges.iter().flat_map(|range| range.clone().map(|sample| sample..sample + 1)).collect();
        let (all, raw) = self.measurements.means_with_samples(&each, self.raw);
        estimate.psi = carry_over(&rough.means, &estimate.psi, &estimate.coefficients, &all, &found.ranges);
        noise = Noise { sensor_m: rough.averaged * noise.sensor_m, balance_m: rough.averaged * noise.balance_m };
        let mut job = self.recalibrated(&raw, rough.calibration);
        for _ in 0..ROUNDS {
            let components = self.variance_components_of_all();
            let fitted = fit(&job.measurements, order, estimate, noise, prior, components, NOISE_UPDATES)?.fit;
            let posterior = job.posterior_of(&job.measurements, &fitted)?;
            job = self.recalibrated(&raw, job.improved(&posterior).calibration);
            if posterior.distance_sds() < CLOSE_SDS {
                break;
            }
            (estimate, noise, prior) = (fitted.estimate, fitted.noise, fitted.prior);
        }
        Some(job.calibration)
    }

    /// The fit to the means of runs with the number of harmonics that the evidence asks for.
    fn with_order(&self, rough: &RoughCalibration) -> Option<Fit> {
        let noise_m = self.typical_m / rough.averaged;
        let noise = Noise { sensor_m: noise_m, balance_m: noise_m };
        self.with_best_order(&rough.corrected, rough.estimate.clone(), noise, self.prior).map(|fitted| fitted.fit)
    }
}
