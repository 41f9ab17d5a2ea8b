//! Reconstructs a log and holds the result against the truth.
//!
//! *Solved* means as good as the reference, a reconstruction of the same log that starts from the truth. The Cramér-Rao bound is
//! evaluated at the truth.

use std::f64::consts::FRAC_1_SQRT_2;
use std::time::Instant;

use palpate::compare::{TruthError, compare, true_support};
use palpate::information::Information;
use palpate::reconstruct::{
    ConstantEstimate, Method, OutlinePoint, Pose, ReconstructOptions, Reconstruction, Reconstructor, Start,
};
use palpate::sensor::{Calibration, Rig};
use palpate::shape::SupportFunction;
use palpate::{Log, Truth};
use serde::{Deserialize, Serialize};

use crate::job::row::{Claimed, HARMLESS_LENGTH, HARMLESS_RAD, Row, Status};

/// Standard deviations on either side of a value that hold 95 % of a Gaussian.
pub const BAND_95_SDS: f64 = 1.959_964;

/// What a plan may choose of the [`ReconstructOptions`].
///
/// A type of its own because the jobs, written out, are what a journal is known by: an option that comes to the estimator must not
/// part a sweep from the journal that it began.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReconstructChoice {
    /// Which way.
    pub method: Method,
    /// Number of harmonics.
    pub harmonics: Option<usize>,
    /// Standard deviation of the contact positions, metres.
    pub sensor_sd_m: Option<f64>,
}

impl From<&ReconstructChoice> for ReconstructOptions {
    fn from(choice: &ReconstructChoice) -> Self {
        let mut options = Self::default();
        (options.harmonics, options.sensor_sd_m, options.method) =
            (choice.harmonics, choice.sensor_sd_m, choice.method);
        options
    }
}

/// What to hold the result against, besides the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScoreChoice {
    /// Reconstruct once more, starting from the truth: needed for `solved` and `wrong`.
    pub reference: bool,
    /// Evaluate the Cramér-Rao bound, for simulations.
    pub bound: bool,
}

/// A log with what is known of it.
pub(crate) struct Known<'a> {
    pub(crate) log: &'a Log,
    pub(crate) truth: Option<&'a Truth>,
    /// The true shape, where it is known better than from the samples of the truth.
    pub(crate) shape: Option<&'a SupportFunction>,
    /// True standard deviation of the contact positions, metres.
    pub(crate) sensor_sd_m: Option<f64>,
    /// The constants of the rig that wrote the log, the common size as stated.
    pub(crate) calibration: Option<Calibration>,
}

/// What the row does not hold.
pub(crate) struct Scored {
    /// Seconds of the reconstruction alone.
    pub(crate) seconds: f64,
    pub(crate) found: Option<Reconstruction>,
}

/// Fills the row, except for the description of the job.
pub(crate) fn score(row: &mut Row, known: &Known, options: &ReconstructOptions, choice: ScoreChoice) -> Scored {
    row.samples = Some(known.log.samples.len() as u64);
    row.status = Status::NoResult;
    let clock = Instant::now();
    let found = Reconstructor::from(options.clone()).run(known.log);
    let seconds = clock.elapsed().as_secs_f64();
    if let Some(truth) = known.truth {
        against_truth(row, known, truth, options, choice);
    }
    match &found {
        Ok(found) => {
            tell(row, found, known.truth);
            if let (Some(estimate), Some(truth)) = (&found.calibration, &known.calibration) {
                tell_of_rig(row, &estimate.constants, truth);
            }
        }
        Err(error) => row.reason = error.to_string(),
    }
    Scored { seconds, found: found.ok() }
}

/// What needs no result: the reference and the bound.
fn against_truth(row: &mut Row, known: &Known, truth: &Truth, options: &ReconstructOptions, choice: ScoreChoice) {
    let sampled;
    let shape = match known.shape {
        Some(shape) => shape,
        None => match true_support(truth) {
            Ok(shape) => {
                sampled = shape;
                &sampled
            }
            Err(_) => return,
        },
    };
    row.mean_radius_m = finite(shape.mean_radius_m());
    let psi: Vec<f64> = truth.motion.iter().map(|pose| pose.psi_rad).collect();
    if choice.reference
        && let Ok(reference) = Reconstructor::from(options.clone())
            .start(Start::Motion { shape: shape.clone(), psi_rad: psi.clone() })
            .run(known.log)
        && let Ok(errors) = compare(&reference, truth)
    {
        row.reference_rms_r_m = finite(errors.rms_r_m);
        row.reference_rms_psi_rad = finite(errors.rms_psi_rad);
        row.reference_coverage = finite(reference.coverage);
    }
    if choice.bound
        && let Some(sensor_sd_m) = known.sensor_sd_m
    {
        let rig = Rig::new(known.calibration.unwrap_or_default(), options.rig.tolerances);
        let information = Information::of_rig(known.log, shape, &psi, sensor_sd_m, &rig);
        row.bound_r_m = information.ok().and_then(|information| finite(information.rms_r_sd_m()));
    }
}

/// What the result says of itself, and how far it is from the truth.
fn tell(row: &mut Row, found: &Reconstruction, truth: Option<&Truth>) {
    row.status = Status::Reconstructed;
    row.certified = found.is_certified();
    row.com_certified = found.is_com_certified();
    row.jumps_found = Some(found.jumps.len() as u64);
    row.coverage = finite(found.coverage);
    row.harmonics = Some(found.shape.harmonics_m().len() as u64);
    row.alternatives = Some(found.alternatives as u64);
    row.symmetry_order = Some(u64::from(found.symmetry.symmetry.order));
    row.symmetry_mirror = Some(found.symmetry.symmetry.mirror);
    row.chi2_per_dof = finite(found.chi2_per_dof);
    row.sensor_sd_m = finite(found.sensor_sd_m);
    row.reason = found.verdict.reason();
    let Some(truth) = truth else { return };
    match compare(found, truth) {
        Ok(errors) => {
            row.rms_r_m = finite(errors.rms_r_m);
            row.rms_form_m = finite(errors.rms_form_m);
            row.hausdorff_m = finite(errors.hausdorff_m);
            row.rms_psi_rad = finite(errors.rms_psi_rad);
            row.rms_com_m = finite(errors.rms_com_m);
            row.inside_band = inside_band(found, truth);
            row.solved = row.is_solved();
            row.wrong = row.is_beyond_chance().map(|beyond| row.certified && beyond);
            row.beyond_error_bars = Some(row.certified && is_beyond_error_bars(found, truth));
            // The error bar is that along one axis.
            row.com_error_sds = finite(FRAC_1_SQRT_2 * errors.rms_com_m / found.com_sd_m());
        }
        Err(error) if row.reason.is_empty() => row.reason = error.to_string(),
        Err(error) => row.reason = format!("{}; {error}", row.reason),
    }
}

/// How far the constants of the rig are from the true ones, those that were not known already.
fn tell_of_rig(row: &mut Row, constants: &[ConstantEstimate], truth: &Calibration) {
    let errors_sds = || {
        let open =
            constants.iter().zip(ConstantEstimate::values_of(truth)).filter(|(constant, _)| constant.prior_sd > 0.0);
        open.map(|(constant, truth)| ((constant.value - truth) / constant.sd).abs())
    };
    let open = errors_sds().count();
    if open > 0 {
        let inside = errors_sds().filter(|error| *error <= BAND_95_SDS).count();
        row.constants_inside_band = finite(inside as f64 / open as f64);
        row.worst_constant_sds = finite(errors_sds().fold(0.0, f64::max));
    }
}

/// What acted besides gravity.
pub(crate) struct TrueForces {
    pub(crate) friction: [f64; 2],
    pub(crate) gyration_radius_m: Option<f64>,
}

/// How far friction and inertia are from the true ones, where the result has them.
pub(crate) fn tell_of_forces(row: &mut Row, found: &Reconstruction, truth: &TrueForces) {
    if let Some(friction) = &found.friction {
        let errors_sds = [0, 1].map(|palm: usize| {
            ((friction.coefficients[palm] - truth.friction[palm]) / friction.coefficient_sds[palm]).abs()
        });
        let errors = [0, 1].map(|palm: usize| (friction.coefficients[palm] - truth.friction[palm]).abs());
        let inside = errors_sds.iter().filter(|error| **error <= BAND_95_SDS).count();
        row.friction_inside_band = finite(inside as f64 / errors_sds.len() as f64);
        row.worst_friction_sds = finite(errors_sds.into_iter().fold(0.0, f64::max));
        row.worst_friction_error = finite(errors.into_iter().fold(0.0, f64::max));
    }
    if let (Some(inertia), Some(truth_m)) = (&found.inertia, truth.gyration_radius_m) {
        row.gyration_error_sds = finite(((inertia.gyration_radius_m - truth_m) / inertia.gyration_radius_sd_m).abs());
    }
}

/// Whether an error of what is certified is beyond its error bars. Those of poses that are open must not hide the others.
fn is_beyond_error_bars(found: &Reconstruction, truth: &Truth) -> bool {
    let is_told: Vec<bool> = found.motion.iter().map(|pose| !pose.is_open()).collect();
    let (mut told, mut truth) = (found.clone(), truth.clone());
    let (mut of_found, mut of_truth) = (is_told.iter().copied(), is_told.iter().copied());
    told.motion.retain(|_| of_found.next() == Some(true));
    truth.motion.retain(|_| of_truth.next() == Some(true));
    compare(&told, &truth).is_ok_and(|errors| claims(&told, &errors).into_iter().any(Claimed::is_beyond))
}

/// The errors of what is certified, each with the error bar that the result gives it.
fn claims(found: &Reconstruction, errors: &TruthError) -> Vec<Claimed> {
    let of = |error: f64, sd: f64, harmless: f64| Claimed { error, sd, harmless };
    let length = HARMLESS_LENGTH * found.shape.mean_radius_m();
    let felt = found.outline.iter().filter(|point| point.touches > 0);
    let r_sd = mean_square(&mut felt.map(|point| point.r_sd_m)).sqrt();
    let psi_sd = mean_square(&mut found.motion.iter().map(|pose| pose.psi_sd_rad)).sqrt();
    let com_sd = found.com_sd_m();
    let mut claims = vec![of(errors.rms_r_m, r_sd, length), of(errors.rms_psi_rad, psi_sd, HARMLESS_RAD)];
    if found.is_com_certified() {
        claims.push(of(errors.rms_com_m, com_sd, length));
    } else {
        // r is about the centre of mass: without its certificate, the form alone is claimed.
        claims[0].error = errors.rms_form_m;
    }
    claims
}

fn mean_square(values: &mut dyn Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value * value, count + 1));
    sum / count.max(1) as f64
}

/// Share of the felt outline whose true r lies inside the 95 % band, after the best rotation; `None` without bands.
fn inside_band(found: &Reconstruction, truth: &Truth) -> Option<f64> {
    let shape = true_support(truth).ok()?;
    let felt: Vec<&OutlinePoint> = found.outline.iter().filter(|point| point.touches > 0).collect();
    if felt.is_empty() || felt.iter().all(|point| point.r_sd_m.is_nan()) {
        return None;
    }
    let (mut sin, mut cos) = (0.0, 0.0);
    for (Pose { psi_rad, .. }, real) in found.motion.iter().zip(&truth.motion) {
        sin += (real.psi_rad - psi_rad).sin();
        cos += (real.psi_rad - psi_rad).cos();
    }
    let mut turn = sin.atan2(cos);
    // Gauss-Newton for the rotation that the bands leave out: unweighted least squares over the felt outline.
    for _ in 0..20 {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for point in &felt {
            let at = shape.at(point.theta_rad - turn);
            // ∂r(θ − turn)/∂turn = −r' = d.
            slope += (at.r - point.r_m) * at.d;
            curvature += at.d * at.d;
        }
        if curvature > 0.0 {
            turn -= slope / curvature;
        }
    }
    let inside = felt
        .iter()
        .filter(|point| (shape.at(point.theta_rad - turn).r - point.r_m).abs() <= BAND_95_SDS * point.r_sd_m);
    finite(inside.count() as f64 / felt.len() as f64)
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::plan::{PalmLimits, plan_turn};
    use palpate::shape::NamedShape;
    use palpate::simulate::{SimulateOptions, simulate};

    #[test]
    fn an_open_pose_hides_no_error_of_the_others() {
        let egg = NamedShape::Egg.shape(0.03).expect("a valid size");
        let plan = plan_turn(&egg, &PalmLimits::default(), 40.0).expect("possible");
        let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
        let run = simulate(&egg, &plan.motion.sample(5.0).expect("possible"), &options).expect("possible");
        let found = palpate::reconstruct::reconstruct(&run.log).expect("an answer");
        assert!(found.is_certified(), "{}", found.verdict);
        let is_beyond = |turned_rad: f64, open_rad: f64| {
            let mut found = found.clone();
            let (first, rest) = found.motion.split_first_mut().expect("poses");
            (first.psi_rad, first.psi_sd_rad) = (first.psi_rad + open_rad, open_rad);
            rest.iter_mut().step_by(2).for_each(|pose| pose.psi_rad += turned_rad);
            is_beyond_error_bars(&found, &run.truth)
        };
        assert!(!is_beyond(0.0, 2.0) && is_beyond(5.0 * HARMLESS_RAD, 2.0));
        // One that is not open counts.
        assert!(is_beyond(5.0 * HARMLESS_RAD, 0.0) && !is_beyond(0.0, 0.0));
    }
}
