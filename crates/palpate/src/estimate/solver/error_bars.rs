//! Error bars (`docs/theory.md`, error bars): the posterior covariance of shape, motion and centre of mass at the optimum.
//!
//! A common rotation of shape and motion is not observable and is no error: every standard deviation here is what is left
//! after the best rotation over the felt boundary (inner constraints, as in geodesy). It is taken out by the projection
//! P = 1 − ρ(ρᵀG)/(ρᵀGρ), where ρ are the coefficients of r' and G is the Gram matrix of the basis over the felt boundary.

use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::{by_palms, combine, contacts};
use crate::estimate::model::layout::Layout;
use crate::estimate::solver::gauss_newton::{Fit, Smoother};
use crate::estimate::solver::normal_equations::{Normal, PSI_INFORMATION};
use crate::estimate::solver::posterior::Posterior;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Standard deviations of shape and motion in the gauge described above.
pub(crate) struct ErrorBars {
    layout: Layout,
    covariance: DMatrix<f64>,
    normal: Normal,
    inflation: f64,
    constants: Option<OpenConstants>,
}

/// Constants of the rig that are unknown as well, at the optimum of shape and motion.
pub(crate) struct OpenConstants {
    /// Derivative of each orientation by the constants, the shape held: a column for each sample.
    pub psi_slopes: DMatrix<f64>,
    /// Of the likeliest constants by the shape.
    pub by_coefficients: DMatrix<f64>,
    /// Covariance of the constants given the shape.
    pub covariance: DMatrix<f64>,
    /// What not knowing them takes from the information on the shape.
    pub lost_information: DMatrix<f64>,
}

impl ErrorBars {
    /// At the optimum `fit`; `felt` are the normal angles of the felt boundary; `inflation` multiplies every variance (correlated
    /// errors of neighbouring samples). `constants` are those of the rig that are not known.
    pub fn new(
        measurements: &Measurements,
        fit: &Fit,
        felt: &[f64],
        inflation: f64,
        constants: Option<OpenConstants>,
    ) -> Option<Self> {
        let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior).strictly_convex();
        let normal = smoother.linearise(&fit.estimate.coefficients, &fit.estimate.psi);
        let mean = DVector::from_row_slice(&fit.estimate.coefficients);
        let mut information = normal.matrix.clone();
        if let Some(constants) = &constants {
            information -= &constants.lost_information;
        }
        let posterior = Posterior { layout: smoother.layout(), mean, information };
        let covariance = posterior.covariance_over(felt)?;
        Some(Self { layout: posterior.layout, covariance, normal, inflation, constants })
    }

    /// The Cholesky factor of the information on the coefficients, whatever the gauge.
    pub fn factor(&self) -> Option<Cholesky<f64, Dyn>> {
        self.normal.matrix.clone().cholesky()
    }

    /// What multiplies every variance.
    pub fn inflation(&self) -> f64 {
        self.inflation
    }

    /// The covariance of the coefficients in this gauge, not inflated.
    pub fn into_covariance(self) -> DMatrix<f64> {
        self.covariance
    }

    /// Variance of a linear function of the unknowns, given by its row.
    fn quadratic(&self, row: &DVector<f64>) -> f64 {
        (&self.covariance * row).dot(row).max(0.0)
    }

    /// Standard deviation of r(θ), metres.
    pub fn r_sd_m(&self, theta: f64) -> f64 {
        (self.inflation * self.quadratic(&self.layout.support_row(theta))).sqrt()
    }

    /// Standard deviations of ψ (radians) and of the centre of mass (metres) at one instant, with that of the palm angles,
    /// `angle_sd` (radians).
    pub fn pose_sd(&self, index: usize, instant: &Instant, fit: &Fit, angle_sd: f64) -> (f64, f64) {
        let coefficients = &fit.estimate.coefficients;
        let psi = fit.estimate.psi[index];
        let mut slope = self.normal.psi_slope(index);
        let mut own = 1.0 / (self.normal.psi_information(index) + PSI_INFORMATION);
        if let Some(OpenConstants { psi_slopes, by_coefficients, covariance, .. }) = &self.constants {
            let by_constants = psi_slopes.column(index);
            slope += by_coefficients.tr_mul(&by_constants);
            own += (covariance * by_constants).dot(&by_constants);
        }
        let (psi_variance, com_variance) =
            pose_variances(self.layout, &self.covariance, (slope, own), (instant, coefficients, psi));
        let (psi_by_angle, com_by_angle) = angle_sensitivity(instant, fit, psi);
        let angle_variance = angle_sd * angle_sd;
        (
            (self.inflation * psi_variance + angle_variance * psi_by_angle).sqrt(),
            (self.inflation * com_variance + angle_variance * 0.5 * com_by_angle).sqrt(),
        )
    }
}

/// Variances of ψ and of the centre of mass (mean of both coordinates) at one instant, from the covariance of the shared unknowns, the derivative
/// of ψ by them and its variance when they are held.
pub(crate) fn pose_variances(
    layout: Layout,
    covariance: &DMatrix<f64>,
    (slope, own): (DVector<f64>, f64),
    (instant, coefficients, psi): (&Instant, &[f64], f64),
) -> (f64, f64) {
    let quadratic = |row: &DVector<f64>| (covariance * row).dot(row).max(0.0);
    let (theta1, theta2) = instant.contact_angles(psi);
    let (basis1, basis2) = (layout.support_row(theta1), layout.support_row(theta2));
    let at = contacts(instant, coefficients, psi);
    let center_by_psi = instant.palms.center(at.d);
    let mut variance = 0.0;
    for (axis, (weight1, weight2)) in
        [(instant.palms.cos12, instant.palms.cos1), (instant.palms.sin12, instant.palms.sin1)].into_iter().enumerate()
    {
        let by_psi = center_by_psi[axis];
        // The projection leaves ψ and shape turned together, so the centre of mass may use either gauge.
        let row = (&basis1 * weight1 + &basis2 * weight2) * instant.palms.inverse2 + &slope * by_psi;
        variance += quadratic(&row) + by_psi * by_psi * own;
    }
    (quadratic(&slope) + own, 0.5 * variance)
}

/// Sensitivity of the pose of one sample to errors of the two palm angles, given the shape: sums of squares of the derivatives of
/// ψ and of the centre of mass (m²/rad²).
fn angle_sensitivity(instant: &Instant, fit: &Fit, psi: f64) -> (f64, f64) {
    let coefficients = &fit.estimate.coefficients;
    let weights = fit.noise.weights(instant);
    let at = contacts(instant, coefficients, psi);
    let here = combine(instant, at);
    let center_by_psi = instant.palms.center(at.d);
    let information: f64 = (0..3).map(|j| (weights[j] * here.by_psi[j]).powi(2)).sum();
    let (mut by_psi, mut by_center) = (0.0, 0.0);
    for (residuals_by_palm, center_by_palm) in by_palms(instant, &at).iter().zip(instant.palms.center_by_palms(&at)) {
        // ψ follows so that the squared residuals stay at their minimum.
        let pull: f64 = (0..3).map(|j| weights[j].powi(2) * here.by_psi[j] * residuals_by_palm[j]).sum();
        let step = -pull / (information + PSI_INFORMATION);
        by_psi += step.powi(2);
        by_center += (0..2).map(|axis| (center_by_palm[axis] + center_by_psi[axis] * step).powi(2)).sum::<f64>();
    }
    (by_psi, by_center)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::{residuals, support};
    use crate::estimate::model::evidence::Evidence;
    use crate::estimate::model::noise::Noise;
    use crate::estimate::model::prior::Prior;
    use crate::estimate::solver::gauss_newton::Estimate;
    use crate::palms::PalmMotion;
    use crate::shape::SupportFunction;
    use crate::simulate::{SimulateOptions, simulate};

    const SIZE_M: f64 = 0.03;
    const NOISE: Noise = Noise { sensor_m: 1e-4, balance_m: 1e-5 };

    /// A short log, its fit at the truth, and the normal angles that were felt.
    fn setting() -> (Measurements, Fit, Vec<f64>) {
        let shape = SupportFunction::new(SIZE_M, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let points = [(0.0, 0.5, 1.9), (3.0, 0.9, 1.2), (6.0, 0.4, 1.5), (9.0, 1.2, 1.4), (12.0, 0.8, 1.9)];
        let motion = PalmMotion::through(&points).and_then(|motion| motion.sample(10.0)).expect("possible");
        let options = SimulateOptions { start_psi_rad: 1.0, ..SimulateOptions::default() };
        let run = simulate(&shape, &motion, &options).expect("possible");
        let measurements = Measurements::new(&run.log, None);
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let felt =
            measurements.instants.iter().zip(&psi).map(|(instant, psi)| instant.contact_angles(*psi).0).collect();
        let h = shape.harmonics_m();
        let coefficients = vec![SIZE_M, h[0][0], h[1][0], h[2][0], h[0][1], h[1][1], h[2][1]];
        let fit = Fit {
            estimate: Estimate { coefficients, psi, cost: 0.0 },
            order: 3,
            noise: NOISE,
            prior: Prior::new(SIZE_M, SIZE_M),
            evidence: Evidence::NONE,
        };
        (measurements, fit, felt)
    }

    /// The component of a shape error that is a rotation over the felt boundary: ∫ r' δr.
    fn as_rotation(fit: &Fit, felt: &[f64]) -> DVector<f64> {
        let slope = |theta: f64| -support(&fit.estimate.coefficients, theta).d;
        felt.iter().fold(DVector::zeros(7), |sum, &theta| sum + slope(theta) * Layout::of_shape(3).support_row(theta))
    }

    #[test]
    fn a_common_rotation_has_no_variance() {
        let (measurements, fit, felt) = setting();
        let posterior = ErrorBars::new(&measurements, &fit, &felt, 1.0, None).expect("determined");
        let rotation = as_rotation(&fit, &felt);
        let smoother = Smoother::new(&measurements, 3, NOISE, fit.prior).strictly_convex();
        let normal = smoother.linearise(&fit.estimate.coefficients, &fit.estimate.psi);
        let raw = smoother.factor(&normal).expect("determined").inverse();
        // Before the projection most of the variance, after it none.
        let before = (&raw * &rotation).dot(&rotation);
        let after = posterior.quadratic(&rotation);
        assert!(after < 1e-9 * before, "{after} {before}");
        assert!((&posterior.covariance * &rotation).amax() < 1e-9 * (&raw * &rotation).amax());
    }

    #[test]
    fn standard_deviations_do_not_depend_on_the_orientation_of_the_frame() {
        let (measurements, fit, felt) = setting();
        let angle: f64 = 0.7;
        let mut turned = fit.clone();
        let (old, new) = (&fit.estimate.coefficients, &mut turned.estimate.coefficients);
        for k in 1..=3 {
            // r(θ) → r(θ − angle)
            let (sin, cos) = (angle * k as f64).sin_cos();
            (new[k], new[3 + k]) = (old[k] * cos - old[3 + k] * sin, old[k] * sin + old[3 + k] * cos);
        }
        turned.estimate.psi.iter_mut().for_each(|psi| *psi -= angle);
        let felt_turned: Vec<f64> = felt.iter().map(|theta| theta + angle).collect();
        let here = ErrorBars::new(&measurements, &fit, &felt, 1.0, None).expect("determined");
        let there = ErrorBars::new(&measurements, &turned, &felt_turned, 1.0, None).expect("determined");
        for &theta in &felt {
            assert!((here.r_sd_m(theta) / there.r_sd_m(theta + angle) - 1.0).abs() < 1e-4);
        }
        for (index, instant) in measurements.instants.iter().enumerate() {
            let (a, b) = (here.pose_sd(index, instant, &fit, 1e-4), there.pose_sd(index, instant, &turned, 1e-4));
            assert!((a.0 / b.0 - 1.0).abs() < 1e-4 && (a.1 / b.1 - 1.0).abs() < 1e-4, "{a:?} {b:?}");
        }
    }

    #[test]
    fn error_bars_grow_with_noise_and_with_correlation() {
        let (measurements, fit, felt) = setting();
        let sds = |factor: f64, inflation: f64| {
            let noise = Noise { sensor_m: factor * NOISE.sensor_m, balance_m: factor * NOISE.balance_m };
            let fit = Fit { noise, ..fit.clone() };
            let posterior = ErrorBars::new(&measurements, &fit, &felt, inflation, None).expect("determined");
            let (psi, com) = posterior.pose_sd(7, &measurements.instants[7], &fit, 0.0);
            [posterior.r_sd_m(1.0), psi, com]
        };
        let one = sds(1.0, 1.0);
        for ([twice, four], one) in [sds(2.0, 1.0), sds(1.0, 4.0)]
            .map(|sds| sds.map(|sd| sd))
            .iter()
            .zip([one; 2])
            .map(|(sds, one)| ([sds[0] / one[0], sds[1] / one[1]], sds[2] / one[2]))
        {
            assert!((twice - 2.0).abs() < 1e-2 && (four - 2.0).abs() < 1e-2 && (one - 2.0).abs() < 1e-2);
        }
    }

    #[test]
    fn the_sensitivity_to_palm_angles_is_that_of_a_refitted_pose() {
        let (measurements, fit, _) = setting();
        let (index, step) = (30, 1e-5);
        let instant = measurements.instants[index];
        let (by_psi, _) = angle_sensitivity(&instant, &fit, fit.estimate.psi[index]);
        let mut squares = 0.0;
        for turned in [instant.turned(step, 0.0), instant.turned(0.0, step)] {
            // The best ψ for the turned palms by golden sections of the exact cost.
            let cost = |psi: f64| {
                let (value, weights) =
                    (residuals(&turned, &fit.estimate.coefficients, psi).value, NOISE.weights(&turned));
                (0..3).map(|j| (weights[j] * value[j]).powi(2)).sum::<f64>()
            };
            let (mut low, mut high) = (fit.estimate.psi[index] - 1e-3, fit.estimate.psi[index] + 1e-3);
            for _ in 0..80 {
                let (left, right) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
                if cost(left) < cost(right) { high = right } else { low = left }
            }
            squares += ((0.5 * (low + high) - fit.estimate.psi[index]) / step).powi(2);
        }
        assert!((by_psi / squares - 1.0).abs() < 0.02, "{by_psi} {squares}");
    }
}
