//! What a motion can tell of a shape: the inverse of the information that its contacts carry (Cramér-Rao).

use crate::estimate::model::evidence::Evidence;
use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::error::InformationError;
use crate::estimate::calibration::CalibrationPosterior;
use crate::estimate::coverage::{NODES, felt_nodes};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::{Layout, coefficients_to_order, rotated_covariance};
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::error_bars::{ErrorBars, OpenConstants};
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::log::Log;
use crate::sensor::Rig;
use crate::shape::SupportFunction;

/// What the samples of a log tell of a shape, as the covariance that they leave of its coefficients (a₀, a₁ … a_K, b₁ … b_K), metres.
///
/// A common rotation of shape and motion cannot be known and is no error: everything here is what is left after the best rotation over the
/// felt boundary.
///
/// ```
/// use palpate::information::Information;
/// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
/// # let egg = NamedShape::Egg.shape(0.03)?;
/// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
/// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
/// # let felt = simulate(&egg, &plan.motion.sample(10.0)?, &options)?;
/// # let psi_rad: Vec<f64> = felt.truth.motion.iter().map(|pose| pose.psi_rad).collect();
/// let all = Information::of(&felt.log, &egg, &psi_rad, 1e-4)?;
/// assert!(all.rms_r_sd_m() < 1e-5);
/// // Where the boundary was not felt often, r(θ) is known less well.
/// let worst = (0..360).map(|degree| all.r_sd_m(f64::from(degree).to_radians())).fold(0.0, f64::max);
/// assert!(worst > all.rms_r_sd_m());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Information {
    layout: Layout,
    covariance_m2: DMatrix<f64>,
    felt_rad: Vec<f64>,
}

/// The change of a shape that is known least.
#[derive(Clone, Debug, PartialEq)]
pub struct WeakestDirection {
    /// Standard deviation along it: the length of the vector of coefficients, metres.
    pub sd_m: f64,
    /// The change of the support function by one standard deviation, metres: r(θ) may as well be larger, or smaller, by this. It is no
    /// object of its own (its mean is about 0).
    pub change: SupportFunction,
}

impl Information {
    /// What the samples of `log` tell of `shape`, when the object is at the orientations `psi_rad` (radians, one for each sample), the
    /// contacts have the standard deviation `sensor_sd_m` (metres) and balance is exact. Of the log only the palms count, and which contacts
    /// were seen: planned motions can be judged before they are made. Harmonics of the shape that together amount to less than a hundredth
    /// of the noise do not count as unknowns.
    ///
    /// # Errors
    /// When `psi_rad` is not as long as the log, a number is not finite (or `sensor_sd_m` not positive), or the log does not determine
    /// the shape.
    pub fn of(log: &Log, shape: &SupportFunction, psi_rad: &[f64], sensor_sd_m: f64) -> Result<Self, InformationError> {
        Self::of_rig(log, shape, psi_rad, sensor_sd_m, &Rig::default())
    }

    /// The same where the constants of the rig are known no better than `rig` has them: the log tells them with the shape, which takes
    /// something from what it tells of the shape. `log` is as the rig reads it. The size, which no log tells, is taken as stated.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn of_rig(
        log: &Log,
        shape: &SupportFunction,
        psi_rad: &[f64],
        sensor_sd_m: f64,
        rig: &Rig,
    ) -> Result<Self, InformationError> {
        check(log, shape, psi_rad, sensor_sd_m)?;
        let log = &rig.calibration.corrected(log);
        let measurements = Measurements::new(log, None);
        let order = shape.visible_order(sensor_sd_m);
        let mut coefficients = shape.coefficients();
        coefficients_to_order(&mut coefficients, order);
        let size_m = shape.mean_radius_m();
        let fit = Fit {
            estimate: Estimate { coefficients, psi: psi_rad.to_vec(), cost: 0.0 },
            order,
            noise: Noise { sensor_m: sensor_sd_m, balance_m: 1e-3 * sensor_sd_m },
            // As good as none: the information is the data's own. (The size is the true one, for convexity is told from it.)
            prior: Prior::new(size_m, 1e6 * size_m),
            evidence: Evidence::NONE,
        };
        let felt_rad = felt_nodes(&measurements, psi_rad).map(|node| TAU * node as f64 / NODES as f64).collect();
        let constants = CalibrationPosterior::new(log, &measurements, &fit, rig, &rig.calibration);
        let constants = constants.map(|posterior| posterior.open_constants());
        Self::at(&measurements, &fit, felt_rad, 1.0, constants)
    }

    /// From its parts, as [`Self::covariance_m2`] (row by row) and [`Self::felt_rad`] give them: for those who kept them in a file.
    ///
    /// # Errors
    /// When the covariance is not that of an odd number of coefficients, or a number is not finite.
    pub fn from_parts(covariance_m2: Vec<f64>, felt_rad: Vec<f64>) -> Result<Self, InformationError> {
        let unknowns = covariance_m2.len().isqrt();
        let bad = |what: String| Err(InformationError::BadNumber { what });
        if unknowns * unknowns != covariance_m2.len() || unknowns.is_multiple_of(2) {
            return bad(format!("a covariance of {} numbers is not that of 2K + 1 coefficients", covariance_m2.len()));
        }
        if !covariance_m2.iter().chain(&felt_rad).all(|value| value.is_finite()) {
            return bad("a number of the covariance, or an angle, is not finite".to_owned());
        }
        let layout = Layout::of_shape(unknowns / 2);
        Ok(Self { layout, covariance_m2: DMatrix::from_vec(unknowns, unknowns, covariance_m2), felt_rad })
    }

    /// At an optimum, every variance multiplied by `inflation`, these constants of the rig unknown as well.
    pub(super) fn at(
        measurements: &Measurements,
        fit: &Fit,
        felt_rad: Vec<f64>,
        inflation: f64,
        constants: Option<OpenConstants>,
    ) -> Result<Self, InformationError> {
        let error_bars =
            ErrorBars::new(measurements, fit, &felt_rad, 1.0, constants).ok_or(InformationError::NotDetermined)?;
        let covariance_m2 = error_bars.into_covariance() * inflation;
        let information = Self { layout: Layout::of_shape(fit.order), covariance_m2, felt_rad };
        if information.rms_r_sd_m().is_finite() { Ok(information) } else { Err(InformationError::NotDetermined) }
    }

    /// In the frame of the shape turned by `angle`, r(θ) becoming r(θ − angle), where the boundary at `felt_rad` was felt.
    pub(super) fn turned(self, angle: f64, felt_rad: Vec<f64>) -> Self {
        Self { covariance_m2: rotated_covariance(&self.covariance_m2, angle), felt_rad, ..self }
    }

    /// Number of harmonics K that count as unknown.
    pub fn order(&self) -> usize {
        self.layout.order
    }

    /// The normal angles of the boundary that was felt, radians in [0, 2π), to half a degree.
    pub fn felt_rad(&self) -> &[f64] {
        &self.felt_rad
    }

    /// Standard deviation of r at the normal angle `theta_rad` (radians, any), metres.
    pub fn r_sd_m(&self, theta_rad: f64) -> f64 {
        let row = self.layout.support_row(theta_rad);
        (&self.covariance_m2 * &row).dot(&row).max(0.0).sqrt()
    }

    /// Root mean square over the felt boundary of the standard deviation of r, metres.
    pub fn rms_r_sd_m(&self) -> f64 {
        let squares = self.felt_rad.iter().map(|&theta| self.r_sd_m(theta).powi(2)).sum::<f64>();
        (squares / self.felt_rad.len() as f64).sqrt()
    }

    /// Standard deviation of where the centre of mass is in the object (of the first harmonic; root of the mean of both variances), metres.
    /// Where the log tells nothing of it, about the mean radius: it is believed to be in the object.
    pub fn center_of_mass_sd_m(&self) -> f64 {
        let variance = |index: usize| self.covariance_m2.get((index, index)).copied().unwrap_or(0.0);
        (0.5 * (variance(Layout::cosine(1)) + variance(self.layout.sine(1)))).max(0.0).sqrt()
    }

    /// The variance of each coefficient, square metres.
    pub(super) fn variances_m2(&self) -> Vec<f64> {
        self.covariance_m2.diagonal().iter().copied().collect()
    }

    /// The covariance of (a₀, a₁ … a_K, b₁ … b_K), square metres, row by row: M × M numbers with M = 2K + 1. It is singular, for a rotation
    /// is not in it.
    pub fn covariance_m2(&self) -> Vec<f64> {
        // Symmetric, so columns are rows.
        self.covariance_m2.as_slice().to_vec()
    }

    /// The change of the shape that is known least: the eigenvector of the covariance with the largest eigenvalue.
    pub fn weakest_direction(&self) -> WeakestDirection {
        let eigen = self.covariance_m2.clone().symmetric_eigen();
        let (mut sd_m, mut direction) = (0.0, vec![0.0; self.layout.unknowns()]);
        for (variance, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
            if variance.max(0.0).sqrt() > sd_m {
                sd_m = variance.sqrt();
                direction = vector.iter().copied().collect();
            }
        }
        // An eigenvector has two signs; the same one everywhere.
        let largest = direction.iter().copied().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        let scale = if largest < 0.0 { -sd_m } else { sd_m };
        direction.iter_mut().for_each(|value| *value *= scale);
        WeakestDirection { sd_m, change: SupportFunction::from_coefficients(&direction) }
    }
}

pub(super) fn check(
    log: &Log,
    shape: &SupportFunction,
    psi_rad: &[f64],
    sensor_sd_m: f64,
) -> Result<(), InformationError> {
    let (orientations, samples) = (psi_rad.len(), log.samples.len());
    let bad = |what: String| Err(InformationError::BadNumber { what });
    if orientations != samples {
        return Err(InformationError::LengthsDiffer { orientations, samples });
    }
    if !(sensor_sd_m > 0.0 && sensor_sd_m.is_finite()) {
        return bad(format!(
            "the standard deviation of the sensors must be a positive number of metres, not {sensor_sd_m}"
        ));
    }
    if shape.has_nonfinite() || shape.mean_radius_m() <= 0.0 {
        return bad(format!("the shape is no object (its mean radius is {} m)", shape.mean_radius_m()));
    }
    match psi_rad.iter().position(|psi| !psi.is_finite()) {
        Some(index) => bad(format!("the orientation at sample {} (counted from 1) is not a finite angle", index + 1)),
        None => Ok(()),
    }
}
