//! One rig, many logs of unknown objects: the product of what each adds to the prior of the constants.

use super::{Contribution, Drift, RigCalibration};
use crate::estimate::calibration::{CONSTANTS, Matrix, Vector, changed, constants, prior_sd};
use crate::log::Log;
use crate::reconstruct::{
    CalibrationEstimate, ConstantEstimate, Progress, ReconstructError, ReconstructOptions, Reconstruction,
    Reconstructor, Start,
};
use crate::sensor::{Calibration, CalibrationConstant, Rig, Tolerances};

/// Calibrates a rig by logs of objects that need not be known. The rig of `options` is what is known of it beforehand; the rest holds for the
/// reconstruction of every log. Reports progress from any thread.
///
/// # Errors
/// When the rig or a log is out of its range; a log that cannot be reconstructed is no error, it contributes nothing.
///
/// ```
/// use palpate::{calibrate::calibrate, reconstruct::ReconstructOptions, sensor::{Calibration, Rig}};
/// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
/// let mut truth = Calibration::default();
/// truth.zero_m = [3e-4, -2e-4];
/// # let mut logs = Vec::new();
/// # for (seed, shape) in [(1, NamedShape::Egg), (2, NamedShape::Stone)] {
/// #     let object = shape.shape(0.03)?;
/// #     let plan = plan_turn(&object, &PalmLimits::default(), 40.0)?;
/// #     let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, seed, ..SimulateOptions::default() };
/// #     logs.push(truth.distorted(&simulate(&object, &plan.motion.sample(5.0)?, &options)?.log));
/// # }
/// let found = calibrate(&logs, &ReconstructOptions::default().with_rig(Rig::uncalibrated()), &|_| ())?;
/// assert_eq!(found.used(), 2);
/// assert!((found.rig.calibration.zero_m[0] - 3e-4).abs() < 4.0 * found.rig.tolerances.zero_sd_m[0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn calibrate(
    logs: &[Log],
    options: &ReconstructOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<RigCalibration, ReconstructError> {
    let (rig, count) = (&options.rig, logs.len().max(1) as f64);
    let tell = |stage, place: usize, share: f64| progress(Progress { stage, fraction: (place as f64 + share) / count });
    let mut found = Vec::with_capacity(logs.len());
    for (place, log) in logs.iter().enumerate() {
        let of_log = |step: Progress| tell(step.stage, place, 0.8 * step.fraction);
        match Reconstructor::from(options.clone()).progress(&of_log).run(log) {
            Ok(reconstruction) => found.push(Ok(reconstruction)),
            Err(ReconstructError::BadSample { sample, what }) => {
                let what = format!("{what} (log {} of {})", place + 1, logs.len());
                return Err(ReconstructError::BadSample { sample, what });
            }
            Err(error @ ReconstructError::BadOption(_)) => return Err(error),
            Err(error) => found.push(Err(error.to_string())),
        }
    }
    let prior = Belief::prior(rig);
    let gains: Vec<Option<Belief>> = found.iter().map(|found| prior.gain(found.as_ref().ok()?)).collect();
    let joint = gains.iter().flatten().fold(prior.clone(), Belief::and);
    let rig_now = joint.rig(rig);
    let contribution = |place: usize| {
        let alone = gains[place].as_ref();
        let others =
            gains.iter().enumerate().filter(|(other, _)| *other != place).filter_map(|(_, gain)| gain.as_ref());
        let drift = alone.and_then(|alone| alone.drift(others));
        let reconstruction = match &found[place] {
            Ok(reconstruction) => reconstruction,
            Err(failure) => return Contribution::failed(failure.clone()),
        };
        let left = |calibration| residual_m(&logs[place], reconstruction, calibration);
        Contribution {
            is_used: alone.is_some(),
            verdict: reconstruction.verdict.clone(),
            failure: None,
            constants: reconstruction.calibration.as_ref().map_or_else(Vec::new, |of_log| of_log.constants.clone()),
            residual_before_m: left(rig.calibration),
            residual_after_m: left(rig_now.calibration),
            drift,
        }
    };
    let logs = (0..logs.len()).map(contribution).collect();
    progress(Progress { stage: "done", fraction: 1.0 });
    Ok(RigCalibration { rig: rig_now, constants: joint.constants(rig), logs })
}

/// What a log's motion and shape, fitted anew, leave in the contact positions for a calibration that is taken as exact.
fn residual_m(log: &Log, found: &Reconstruction, calibration: Calibration) -> Option<f64> {
    let psi_rad = found.motion.iter().map(|pose| pose.psi_rad).collect();
    let exact = Rig::new(calibration, Tolerances::NONE);
    let options = ReconstructOptions::default().with_rig(exact);
    let start = Start::Motion { shape: found.shape.clone(), psi_rad };
    Reconstructor::from(options).start(start).run(log).ok().map(|again| again.sensor_sd_m)
}

/// A Gaussian belief of the constants, in units of the prior standard deviations and from the stated values: its information matrix, and that
/// times its mean. Constants that are exact stay 0.
#[derive(Clone, Debug)]
struct Belief {
    information: Matrix,
    weighted_mean: Vector,
    stated: Vector,
    prior_sd: Vector,
}

impl Belief {
    fn prior(rig: &Rig) -> Self {
        let (stated, prior_sd) = (Vector::from(constants(&rig.calibration)), Vector::from(prior_sd(&rig.tolerances)));
        Self { information: Matrix::identity(), weighted_mean: Vector::zeros(), stated, prior_sd }
    }

    /// What the reconstruction of a log adds to this prior, if it is certified.
    fn gain(&self, found: &Reconstruction) -> Option<Self> {
        let CalibrationEstimate { constants, covariance, .. } =
            found.calibration.as_ref().filter(|_| found.is_certified())?;
        let unit = |c: usize| if self.prior_sd[c] > 0.0 { 1.0 / self.prior_sd[c] } else { 0.0 };
        // An exact constant keeps its unit of information.
        let exact = |i: usize, j: usize| if i == j && unit(i) == 0.0 { 1.0 } else { 0.0 };
        let covariance = Matrix::from_fn(|i, j| covariance[i][j] * unit(i) * unit(j) + exact(i, j));
        let posterior = covariance.try_inverse()?;
        let mean = Vector::from_fn(|c, _| (constants[c].value - self.stated[c]) * unit(c));
        let information = posterior - Matrix::identity();
        Some(Self { information, weighted_mean: posterior * mean, ..self.clone() })
    }

    fn and(self, other: &Self) -> Self {
        let information = self.information + other.information;
        Self { information, weighted_mean: self.weighted_mean + other.weighted_mean, ..self }
    }

    /// Mean and covariance.
    fn moments(&self) -> (Vector, Matrix) {
        let covariance = self.information.try_inverse().unwrap_or_else(Matrix::identity);
        (covariance * self.weighted_mean, covariance)
    }

    fn sd(&self, covariance: &Matrix) -> [f64; CONSTANTS] {
        std::array::from_fn(|c| covariance[(c, c)].max(0.0).sqrt() * self.prior_sd[c])
    }

    fn constants(&self, rig: &Rig) -> Vec<ConstantEstimate> {
        let (mean, covariance) = self.moments();
        let values = std::array::from_fn(|c| self.stated[c] + mean[c] * self.prior_sd[c]);
        ConstantEstimate::all(rig, values, self.sd(&covariance))
    }

    /// The rig with this belief of its constants. What both pads have in common stays as it was.
    fn rig(&self, before: &Rig) -> Rig {
        let (mean, covariance) = self.moments();
        let calibration = changed(&before.calibration, &before.tolerances, &mean.component_mul(&self.prior_sd));
        let [zero1, zero2, ratio, angle1, angle2, difference, clock] = self.sd(&covariance);
        let mut tolerances = before.tolerances;
        (tolerances.zero_sd_m, tolerances.angle_zero_sd_rad) = ([zero1, zero2], [angle1, angle2]);
        (tolerances.scale_ratio_sd, tolerances.surface_difference_sd_m) = (Some(ratio), Some(difference));
        tolerances.clock_offset_sd_s = clock;
        Rig::new(calibration, tolerances)
    }

    /// The constant that differs most from that of other logs: both with the prior, which says the same to either.
    fn drift<'a>(&self, others: impl Iterator<Item = &'a Self>) -> Option<Drift> {
        let mut others = others.peekable();
        others.peek()?;
        let prior = Self { information: Matrix::identity(), weighted_mean: Vector::zeros(), ..self.clone() };
        let (own_mean, own) = prior.clone().and(self).moments();
        let (mean, covariance) = others.fold(prior, Self::and).moments();
        let drift = |c: usize| {
            let difference = own_mean[c] - mean[c];
            let sd = (own[(c, c)] + covariance[(c, c)]).max(0.0).sqrt();
            let sds = if sd > 0.0 && self.prior_sd[c] > 0.0 { difference / sd } else { 0.0 };
            Drift {
                constant: CalibrationConstant::ALL[c].name.to_owned(),
                difference: difference * self.prior_sd[c],
                sds,
            }
        };
        (0..CONSTANTS).map(drift).max_by(|a, b| a.sds.abs().total_cmp(&b.sds.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    fn log(seed: u64, truth: &Calibration) -> Log {
        let shapes = [NamedShape::Egg, NamedShape::Pebble, NamedShape::Stone];
        let shape = shapes[seed as usize % 3].shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(seed + 50, 30.0, 0.8).and_then(|motion| motion.sample(20.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
        let options = SimulateOptions { touchpad, seed, ..SimulateOptions::default() };
        truth.distorted(&simulate(&shape, &motion, &options).expect("possible").log)
    }

    #[test]
    fn several_logs_tell_more_than_one_and_one_that_drifted_is_named() {
        let rig = Rig::uncalibrated();
        let truth = rig.drawn(4);
        let mut logs: Vec<Log> = (0..4).map(|seed| log(seed, &truth)).collect();
        let found = calibrate(&logs, &ReconstructOptions::default().with_rig(rig), &|_| ()).expect("calibrated");
        assert!(found.used() >= 3 && found.drift().is_none(), "{:?}", found.drift());
        let open = |constant: &&ConstantEstimate| constant.prior_sd > 0.0;
        for (constant, truth) in found.constants.iter().zip(constants(&truth)).filter(|(constant, _)| open(constant)) {
            let ConstantEstimate { ref name, value, sd, .. } = *constant;
            assert!((value - truth).abs() < 4.0 * sd, "{name}: {value} {truth} {sd}");
            let alone = found.logs.iter().flat_map(|log| &log.constants).filter(|of_log| of_log.name == *name);
            let least = alone.map(|of_log| of_log.sd).fold(f64::INFINITY, f64::min);
            assert!(sd < 0.9 * least, "{name}: {sd} {least}");
        }
        // Size and offset stay as uncertain as they were.
        assert_eq!((found.rig.size_sd(), found.rig.offset_sd_m()), (rig.size_sd(), rig.offset_sd_m()));
        let used = found.logs.iter().filter(|log| log.is_used);
        for log in used {
            let (before, after) = (log.residual_before_m.expect("fitted"), log.residual_after_m.expect("fitted"));
            assert!(before > 1.5 * after && after < 7e-5, "{before} {after}");
        }
        // A pad that was mounted anew.
        let mut moved = truth;
        moved.zero_m[1] += 4e-4;
        logs.push(log(4, &moved));
        let found = calibrate(&logs, &ReconstructOptions::default().with_rig(rig), &|_| ()).expect("calibrated");
        let (place, drift) = found.drift().expect("a drift");
        assert_eq!((place, drift.constant.as_str()), (4, "s2_zero_m"), "{drift:?}");
    }

    #[test]
    fn without_logs_the_rig_stays() {
        let rig = Rig::uncalibrated();
        let found = calibrate(&[], &ReconstructOptions::default().with_rig(rig), &|_| ()).expect("nothing to do");
        assert_eq!(found.rig.calibration, rig.calibration);
        assert!((found.rig.tolerances.zero_sd_m[0] / rig.tolerances.zero_sd_m[0] - 1.0).abs() < 1e-12);
    }
}
