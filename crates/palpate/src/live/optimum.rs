//! The optimum that a search over the samples so far leaves to the filter: shape, noise, prior and calibration as the batch estimator finds them,
//! and the Gaussian of the shape given all samples that are kept (`docs/theory.md`, online).

use crate::estimate::evidence::fit::{ROUNDS, fit};
use crate::estimate::evidence::symmetry::turn_to_axis;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::rotate;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother};
use crate::estimate::solver::posterior::Posterior;
use crate::estimate::work::Work;
use crate::live::kept::Kept;
use crate::live::shape_belief::settled;
use crate::log::Log;
use crate::math::statistics::median;
use crate::reconstruct::refine::job::Job;
use crate::reconstruct::{ReconstructError, ReconstructOptions, Reconstruction, Reconstructor};
use crate::sensor::Calibration;

/// Samples that are searched at most; of more, every n-th is. The optimum that is found is then that of all.
const MOST_SEARCHED: usize = 3000;

/// Samples above which nothing is fitted anew but after a search: noise and shape hardly change any more, and all samples together take long.
pub(super) const FITTED_AT_MOST: usize = 10_000;

/// Standard deviation of the balance that a fit begins with at least, over that of the contacts: from a loose one, the evidence chooses between loose
/// and exact (`Job::fit_all`).
const LOOSE: f64 = 0.4;

/// Largest factor of the variances, so that one poor search does not blind the filter.
const MOST_INFLATION: f64 = 1e4;

/// What is known after a search.
#[derive(Clone)]
pub(super) struct Optimum {
    /// The answer of the batch estimator, without its motion and its rivals.
    pub found: Reconstruction,
    /// The shape, in the frame of the fit.
    pub belief: Posterior,
    pub noise: Noise,
    pub prior: Prior,
    /// ψ of the samples that are kept in the frame of the fit, radians, and the piece of the last.
    pub motion: Vec<f64>,
    pub piece: u32,
    /// Standard deviation of ψ of the last sample that was searched, radians.
    pub psi_sd_rad: f64,
    /// ψ of the first: angles of the object's own frame are larger by it, and ψ is less.
    pub turned: f64,
    /// What the samples were corrected by.
    pub calibration: Calibration,
    /// Standard deviation that weights of contacts are relative to, where it is stated, metres; and what the weights are multiplied by.
    pub stated_m: Option<f64>,
    pub weights: [f64; 2],
    /// Whether the balance counts: it does where the forces are those of an object at rest without friction.
    pub balance_counts: bool,
    /// What the variances of the filter are multiplied by: correlated errors, and constants of the rig that are open.
    pub inflation: f64,
}

/// How far a search over the samples so far goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// The first way alone, by which most logs of an object are explained.
    Brief,
    /// All ways, friction and inertia among them, and no further explanation is looked for after so much work (`estimate/work.rs`).
    Whole { most_work: u64 },
}

/// Searches the samples that are kept, and takes what is found to the optimum of all of them.
pub(super) fn search(kept: &Kept, options: &ReconstructOptions, extent: Extent) -> Result<Optimum, ReconstructError> {
    let log = kept.log();
    let every = log.samples.len().div_ceil(MOST_SEARCHED).max(1);
    let few = Log { samples: log.samples.iter().step_by(every).copied().collect() };
    let reconstructor = Reconstructor::from(options.clone());
    let found = match extent {
        Extent::Brief => reconstructor.run_briefly(&few),
        Extent::Whole { most_work } => reconstructor.run_within(&few, most_work),
    }?;
    Optimum::of_all(kept, options, found, every).ok_or(ReconstructError::NotSolvable)
}

impl Optimum {
    /// Whether it explains the samples that were searched, certified or not.
    pub fn is_explained(&self) -> bool {
        self.found.verdict.is_explained()
    }

    /// From what was found for every n-th sample.
    fn of_all(kept: &Kept, options: &ReconstructOptions, mut found: Reconstruction, every: usize) -> Option<Self> {
        let calibration = found.calibration.as_ref().map_or(options.rig.calibration, |of_rig| of_rig.calibration);
        let balance_counts = found.friction.is_none() && found.inertia.is_none();
        let job = job(kept.log(), options, calibration, balance_counts);
        let mut coefficients = found.shape.coefficients();
        let mut psi = motion_of_all(&job.measurements, &coefficients, &found, every);
        let symmetry = found.symmetry.symmetry;
        let turn = turn_to_axis(&coefficients, symmetry);
        rotate(&mut coefficients, turn);
        psi.iter_mut().for_each(|psi| *psi -= turn);
        let noise = Noise { sensor_m: found.sensor_sd_m, balance_m: found.balance_sd_m };
        let start = Estimate { coefficients, psi, cost: f64::INFINITY };
        let Fitted { belief, noise, prior, motion } =
            fit_all(&job, start, noise, Prior { symmetry, ..job.prior }, Balance::AsFound)?;
        let turned = *motion.first()?;
        let inflation = inflation(&found, &belief, turned, every);
        let (piece, psi_sd_rad) = found.motion.last().map(|pose| (pose.piece, pose.psi_sd_rad))?;
        found.motion.clear();
        found.others.clear();
        Some(Self {
            belief,
            noise,
            prior,
            motion,
            piece,
            psi_sd_rad,
            turned,
            calibration,
            stated_m: job.stated_m,
            weights: weights(&job),
            balance_counts,
            inflation,
            found,
        })
    }

    /// The same object and pieces with shape, noise and prior that are fitted to all samples of a log, from these coefficients and orientations in
    /// the frame of the fit. `None` where they do not determine a shape.
    pub fn refitted(
        self,
        log: &Log,
        options: &ReconstructOptions,
        coefficients: Vec<f64>,
        psi: Vec<f64>,
    ) -> Option<Self> {
        let job = job(log, options, self.calibration, self.balance_counts);
        let noise = Noise { balance_m: self.noise.balance_m.max(LOOSE * self.noise.sensor_m), ..self.noise };
        let coefficients = job.with_order_by_evidence(&coefficients, &psi, noise, self.prior)?;
        let start = Estimate { coefficients, psi, cost: f64::INFINITY };
        let Fitted { belief, noise, prior, motion } = fit_all(&job, start, noise, self.prior, Balance::ByEvidence)?;
        Some(Self { belief, noise, prior, turned: *motion.first()?, motion, ..self })
    }
}

/// The estimation problem of all samples of a log.
fn job<'a>(log: &'a Log, options: &'a ReconstructOptions, calibration: Calibration, balance_counts: bool) -> Job<'a> {
    let job = Job::calibrated(log, options, calibration, Work::for_log(log.samples.len(), 1), Vec::new());
    if balance_counts { job } else { job.without_balance() }
}

/// Whether the balance is loose or exact.
#[derive(Clone, Copy)]
enum Balance {
    /// As the search found it, which compared both.
    AsFound,
    /// As the evidence says.
    ByEvidence,
}

/// The Gaussian of a shape at its optimum, with noise, prior and motion.
struct Fitted {
    belief: Posterior,
    noise: Noise,
    prior: Prior,
    motion: Vec<f64>,
}

/// The optimum over all samples with its noise and prior, as the batch estimator finds it; where the forces do not count, the shape as it was
/// found, since the contacts do not tell where its centre of mass is.
fn fit_all(job: &Job, start: Estimate, noise: Noise, prior: Prior, balance: Balance) -> Option<Fitted> {
    let order = start.coefficients.len() / 2;
    let (fit, weighted) = if job.balance_counts {
        let fitted = match balance {
            Balance::ByEvidence => job.fit_all(order, start, noise, prior),
            Balance::AsFound => {
                fit(&job.measurements, order, start, noise, prior, job.variance_components_of_all(), ROUNDS)
            }
        }?;
        (fitted.fit, fitted.weighted)
    } else {
        let fit = Fit { estimate: start, order, noise, prior, evidence: Evidence::NONE };
        (fit, job.measurements.clone())
    };
    let Fit { estimate, order, noise, prior, .. } = fit;
    let belief = Smoother::new(&weighted, order, noise, prior).strictly_convex().belief(&estimate)?;
    Some(Fitted { belief, noise, prior, motion: estimate.psi })
}

/// The orientations of all samples from those of every n-th: between two of them, or at either where a jump lies between.
fn motion_of_all(measurements: &Measurements, coefficients: &[f64], found: &Reconstruction, every: usize) -> Vec<f64> {
    let noise = Noise { sensor_m: found.sensor_sd_m, balance_m: found.balance_sd_m };
    let instants = measurements.instants.iter().enumerate();
    let psi = instants.map(|(index, instant)| {
        let known = |place: usize| found.motion.get(place).or(found.motion.last()).map_or(0.0, |pose| pose.psi_rad);
        let (before, after) = (known(index / every), known(index / every + 1));
        if index.is_multiple_of(every) {
            return before;
        }
        let between = before + (after - before) * (index % every) as f64 / every as f64;
        let poses = [between, before, after].map(|psi| settled(instant, coefficients, noise, psi));
        poses.into_iter().min_by(|a, b| a.misfit.total_cmp(&b.misfit)).map_or(between, |pose| pose.psi)
    });
    psi.collect()
}

/// What the weight of a contact is multiplied by besides its stated standard deviation: that of noisy palm angles, at the median.
fn weights(job: &Job) -> [f64; 2] {
    let plain = Measurements::new(&job.log, job.stated_m);
    [0, 1].map(|palm| {
        let pairs = job.measurements.instants.iter().zip(&plain.instants).filter(|(weighed, _)| weighed.both_seen());
        let mut ratios: Vec<f64> = pairs
            .map(
                |(weighed, plain)| {
                    if palm == 0 { weighed.weight1 / plain.weight1 } else { weighed.weight2 / plain.weight2 }
                },
            )
            .collect();
        if ratios.is_empty() { 1.0 } else { median(&mut ratios) }
    })
}

/// Variances of the boundary as they were found over those of the belief, which knows of all samples.
fn inflation(found: &Reconstruction, belief: &Posterior, turned: f64, every: usize) -> f64 {
    let felt = || found.outline.iter().filter(|point| point.touches > 0 && point.r_sd_m.is_finite());
    let angles: Vec<f64> = felt().map(|point| point.theta_rad - turned).collect();
    let Some(covariance) = belief.covariance_over(&angles) else { return 1.0 };
    let own = angles.iter().map(|theta| {
        let row = belief.layout.support_row(*theta);
        (&covariance * &row).dot(&row)
    });
    let ratio = felt().map(|point| point.r_sd_m.powi(2)).sum::<f64>() / (every as f64 * own.sum::<f64>());
    if ratio.is_finite() { ratio.clamp(1.0, MOST_INFLATION) } else { 1.0 }
}
