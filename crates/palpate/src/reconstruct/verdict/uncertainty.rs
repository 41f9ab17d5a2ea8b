//! What an optimum leaves open: error bars of boundary and poses, and of the constants of the rig.

use crate::estimate::calibration::{CONSTANTS, CalibrationPosterior, Matrix, constants, prior_sd};
use crate::estimate::evidence::jump_prior::{excess, is_over_barrier, variance_by};
use crate::estimate::jumps::{DetectedJump, detect_jumps};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::noise_from_log::angle_sd_at_optimum_rad;
use crate::estimate::solver::error_bars::ErrorBars;
use crate::estimate::solver::gauss_newton::Fit;
use crate::log::Log;
use crate::mechanics::ContactMode;
use crate::reconstruct::result::calibration::{CalibrationEstimate, ConstantEstimate};
use crate::reconstruct::result::friction::FrictionEstimate;
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::sensor::{Calibration, CalibrationConstant, Rig};
use crate::shape::SupportFunction;
use nalgebra::DMatrix;

/// What an optimum leaves open. Angles are in the frame of the optimum.
pub(crate) trait Uncertainty {
    /// After the best rotation over the boundary at the normal angles `felt`; `inflation` multiplies every variance (correlated errors of
    /// neighbouring samples). `None` where the log does not determine the shape.
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>>;

    /// What the log told of the rig; `None` where every constant of it is exact.
    fn of_rig(&self, inflation: f64) -> Option<FoundRig>;

    /// What it told of the inertia of the object; `None` where the forces are in balance.
    fn inertia(&self, inflation: f64) -> Option<InertiaEstimate>;

    /// What it told of friction; `None` where there is none.
    fn friction(&self) -> Option<FrictionEstimate>;

    /// The contact modes of a sample; `None` where friction does not say.
    fn modes(&self, _index: usize) -> Option<[ContactMode; 2]> {
        None
    }

    /// The jumps of an object with this shape and motion, and whether the forces allow them.
    fn jumps(&self, shape: &SupportFunction, log: &Log, psi: &[f64]) -> Vec<DetectedJump> {
        detect_jumps(shape, log, psi)
    }
}

/// Error bars of boundary and poses.
pub(crate) trait PoseErrorBars {
    /// Standard deviation of r(θ), metres.
    fn r_sd_m(&self, theta: f64) -> f64;

    /// The same of the form alone, wherever the centre of mass may be in it.
    fn form_sd_m(&self, theta: f64) -> f64 {
        self.r_sd_m(theta)
    }

    /// Standard deviations of ψ (radians) and of the centre of mass (metres) at one sample.
    fn pose_sd(&self, index: usize, instant: &Instant) -> (f64, f64);

    /// Half of what the jumps add to the cost: −ln of their prior. `None` where the log does not determine the shape.
    fn deviance_of(&self, jumps: &[DetectedJump]) -> Option<f64>;

    /// Whether the barrier on the way of a jump may be an error of the shape: without one the forces do not forbid it.
    fn may_be_without_barrier(&self, _jump: &DetectedJump) -> bool {
        false
    }
}

/// What a log told of the rig.
pub(crate) struct FoundRig {
    pub estimate: CalibrationEstimate,
    /// The constant that is furthest from what was stated, and how far, in standard deviations of the statement.
    pub furthest: (String, f64),
    /// By how much the constants would still move, in standard deviations.
    pub unsettled_sds: f64,
    /// ln of the evidence that they add.
    pub log_evidence: f64,
}

impl FoundRig {
    /// Constants `found` of a rig that was stated as `rig`, with their covariance.
    pub fn estimate(found: Calibration, rig: &Rig, covariance: &Matrix) -> CalibrationEstimate {
        let sds = std::array::from_fn(|c| covariance[(c, c)].max(0.0).sqrt());
        CalibrationEstimate {
            calibration: found,
            constants: ConstantEstimate::all(rig, constants(&found), sds),
            covariance: covariance.row_iter().map(|row| row.iter().copied().collect()).collect(),
            size_sd: rig.size_sd(),
            offset_sd_m: rig.offset_sd_m(),
        }
    }
}

impl FoundRig {
    /// Of constants that were estimated together with all else, the last of the unknowns with this covariance, in units of their priors; `None`
    /// where every constant is exact.
    pub fn jointly(found: Calibration, rig: &Rig, all: &DMatrix<f64>, inflation: f64) -> Option<Self> {
        let sd = prior_sd(&rig.tolerances);
        if sd == [0.0; CONSTANTS] {
            return None;
        }
        let first = all.nrows() - CONSTANTS;
        // No correlation of errors takes away what was known before.
        let within = |variance: f64, i: usize, j: usize| if i == j { variance.min(1.0) } else { variance };
        let covariance = Matrix::from_fn(|i, j| within(inflation * all[(first + i, first + j)], i, j) * sd[i] * sd[j]);
        let off = constants(&found).into_iter().zip(constants(&rig.calibration)).zip(sd);
        let off = off.map(|((found, stated), sd)| if sd > 0.0 { (found - stated).abs() / sd } else { 0.0 });
        let names = CalibrationConstant::ALL.iter().map(|constant| constant.name.to_owned());
        let furthest = names.zip(off).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Self {
            estimate: Self::estimate(found, rig, &covariance),
            furthest,
            unsettled_sds: 0.0,
            log_evidence: 0.0,
        })
    }
}

/// The same of an optimum with the forces in balance.
pub(crate) struct OfBalance<'a> {
    pub measurements: &'a Measurements,
    pub fit: Fit,
    /// What the log says of the rig, and the calibration found with what was stated.
    pub calibration: Option<(&'a CalibrationPosterior, Calibration, Rig)>,
}

struct BalanceErrorBars<'a> {
    bars: ErrorBars,
    of: &'a OfBalance<'a>,
    angle_sd: f64,
}

impl Uncertainty for OfBalance<'_> {
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
        let open = self.calibration.map(|(posterior, ..)| posterior.open_constants());
        let bars = ErrorBars::new(self.measurements, &self.fit, felt, inflation, open)?;
        let Fit { estimate, noise, .. } = &self.fit;
        let angle_sd = angle_sd_at_optimum_rad(self.measurements, &estimate.coefficients, &estimate.psi, *noise);
        Some(Box::new(BalanceErrorBars { bars, of: self, angle_sd }))
    }

    fn of_rig(&self, inflation: f64) -> Option<FoundRig> {
        let (posterior, found, rig) = self.calibration?;
        Some(FoundRig {
            estimate: FoundRig::estimate(found, &rig, &posterior.covariance(inflation)),
            furthest: posterior.furthest(),
            unsettled_sds: posterior.distance_sds(),
            log_evidence: posterior.log_evidence(),
        })
    }

    fn inertia(&self, _: f64) -> Option<InertiaEstimate> {
        None
    }

    fn friction(&self) -> Option<FrictionEstimate> {
        None
    }
}

impl PoseErrorBars for BalanceErrorBars<'_> {
    fn r_sd_m(&self, theta: f64) -> f64 {
        self.bars.r_sd_m(theta)
    }

    fn pose_sd(&self, index: usize, instant: &Instant) -> (f64, f64) {
        self.bars.pose_sd(index, instant, &self.of.fit, self.angle_sd)
    }

    fn deviance_of(&self, jumps: &[DetectedJump]) -> Option<f64> {
        let Fit { estimate, noise, .. } = &self.of.fit;
        let factor = self.bars.factor()?;
        let variance_of = variance_by(&factor, self.bars.inflation());
        Some(excess(self.of.measurements, estimate, noise.balance_m, &variance_of, jumps))
    }

    fn may_be_without_barrier(&self, jump: &DetectedJump) -> bool {
        let Fit { estimate, noise, .. } = &self.of.fit;
        self.bars.factor().is_some_and(|factor| {
            let variance_of = variance_by(&factor, self.bars.inflation());
            !is_over_barrier(self.of.measurements, estimate, noise.balance_m, &variance_of, jump)
        })
    }
}
