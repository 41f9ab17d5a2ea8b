//! The calibration constants of the rig as unknowns that all samples share (`docs/theory.md`, calibration): the normal equations of shape and
//! constants together, every orientation eliminated, at an optimum of shape and motion. The shape is eliminated in turn, which leaves the
//! information of the log on the constants.
//!
//! The common scale of the pads and the common offset of their surfaces are exact symmetries, so that of either only the difference is an
//! unknown; what the two have in common stays as it is stated.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::{by_palms, combine, contacts};
use crate::estimate::solver::error_bars::OpenConstants;
use crate::estimate::solver::gauss_newton::{Fit, Smoother};
use crate::estimate::solver::normal_equations::PSI_INFORMATION;
use crate::estimate::solver::shape_given_motion::rows;
use crate::log::Log;
use crate::palms::PalmPair;
use crate::sensor::calibration::palm_rates_rad_per_s;
use crate::sensor::rig::shares;
use crate::sensor::{Calibration, CalibrationConstant, Rig, Tolerances};
use crate::shape::{ContactSupport, SupportFunction};
use nalgebra::{DMatrix, SMatrix, SVector};

/// The constants that a log may tell, in this order: zeros of both pads, ratio of their scales, zeros of φ₁ and φ₂, difference of the
/// surface offsets, clock.
pub(crate) const CONSTANTS: usize = CalibrationConstant::ALL.len();

pub(crate) type Vector = SVector<f64, CONSTANTS>;
pub(crate) type Matrix = SMatrix<f64, CONSTANTS, CONSTANTS>;

/// A direction of the constants (in units of their priors) is changed where the log knows it better than so many times the prior: what it
/// hardly tells stays as it is stated.
const LEAST_GAIN: f64 = 1.0;

/// Prior standard deviations.
pub(crate) fn prior_sd(tolerances: &Tolerances) -> [f64; CONSTANTS] {
    let Tolerances { zero_sd_m, angle_zero_sd_rad, clock_offset_sd_s, .. } = *tolerances;
    [
        zero_sd_m[0],
        zero_sd_m[1],
        tolerances.scale_ratio_sd(),
        angle_zero_sd_rad[0],
        angle_zero_sd_rad[1],
        tolerances.surface_difference_sd_m(),
        clock_offset_sd_s,
    ]
}

/// The constants of a calibration.
pub(crate) fn constants(calibration: &Calibration) -> [f64; CONSTANTS] {
    let Calibration { zero_m, scale, angle_zero_rad, surface_m, clock_offset_s } = *calibration;
    let ratio = scale[0] - scale[1];
    [zero_m[0], zero_m[1], ratio, angle_zero_rad[0], angle_zero_rad[1], surface_m[0] - surface_m[1], clock_offset_s]
}

/// The constants of a calibration from where they are stated, in units of their priors; and these units.
pub(crate) fn constants_off(calibration: &Calibration, rig: &Rig) -> (Vector, Vector) {
    let sd = Vector::from(prior_sd(&rig.tolerances));
    let stated = Vector::from(constants(&rig.calibration));
    let off =
        (Vector::from(constants(calibration)) - stated).zip_map(&sd, |off, sd| if sd > 0.0 { off / sd } else { 0.0 });
    (off, sd)
}

/// A calibration after a change of its constants.
pub(crate) fn changed(calibration: &Calibration, tolerances: &Tolerances, step: &Vector) -> Calibration {
    let (of_scale, of_surface) = (shares(tolerances.scale_sd), shares(tolerances.surface_sd_m));
    let mut changed = *calibration;
    for k in 0..2 {
        changed.zero_m[k] += step[k];
        changed.scale[k] += of_scale[k] * step[2];
        changed.angle_zero_rad[k] += step[3 + k];
        changed.surface_m[k] += of_surface[k] * step[5];
    }
    changed.clock_offset_s += step[6];
    changed
}

/// What a log says of the constants at an optimum of shape and motion.
pub(crate) struct CalibrationPosterior {
    /// Derivatives of the cost: by shape and constant, and by both constants, orientations eliminated.
    by_shape: DMatrix<f64>,
    own: Matrix,
    /// dψᵢ = slopeᵢ · dc, the shape held.
    psi_slopes: Vec<[f64; CONSTANTS]>,
    /// Derivatives of the weighted residuals of each sample by the constants, its orientation eliminated.
    by_constants: Vec<[[f64; CONSTANTS]; 3]>,
    /// How the shape follows the constants: −dx/dc.
    shape_slopes: DMatrix<f64>,
    /// Information of the log alone, shape eliminated, in units of the prior standard deviations.
    information: Matrix,
    /// The same, as far as the residuals bear it out.
    borne_out: Matrix,
    /// The gradient of the log's cost likewise.
    gradient: Vector,
    prior_sd: Vector,
    /// How far the constants are from their priors, in the same units.
    off: Vector,
}

impl CalibrationPosterior {
    /// At an optimum `fit` to `measurements`, those of `log`, which a rig with this calibration has been corrected by. `None` where nothing
    /// about the rig is open, or the log does not determine a shape.
    pub fn new(
        log: &Log,
        measurements: &Measurements,
        fit: &Fit,
        rig: &Rig,
        calibration: &Calibration,
    ) -> Option<Self> {
        let prior_sd = Vector::from(prior_sd(&rig.tolerances));
        if prior_sd.amax() == 0.0 {
            return None;
        }
        let coefficients = &fit.estimate.coefficients;
        let shape = SupportFunction::from_coefficients(coefficients);
        let rates = palm_rates_rad_per_s(log);
        let mut by_shape = DMatrix::zeros(coefficients.len(), CONSTANTS);
        let (mut own, mut gradient) = (Matrix::zeros(), Vector::zeros());
        let mut psi_slopes = Vec::with_capacity(measurements.len());
        let mut projected_by_constants = Vec::with_capacity(measurements.len());
        for (index, (instant, &psi)) in measurements.instants.iter().zip(&fit.estimate.psi).enumerate() {
            let sample = &log.samples[index];
            let at = contacts(instant, coefficients, psi);
            let residuals = combine(instant, at);
            let weights = fit.noise.weights(instant);
            let positions = [sample.s1_m, sample.s2_m].map(Option::unwrap_or_default);
            let rows_of = Rows { calibration, tolerances: &rig.tolerances, palms: &sample.palms, positions };
            let forces = by_palms(instant, &at).map(|of_palm| of_palm[2]);
            let by_constants = rows_of.by_constants(&shape, psi, forces, rates[index]);
            let by_constants: [[f64; CONSTANTS]; 3] =
                std::array::from_fn(|j| by_constants[j].map(|by| by * weights[j]));
            let value: [f64; 3] = std::array::from_fn(|j| residuals.value[j] * weights[j]);
            let by_psi: [f64; 3] = std::array::from_fn(|j| residuals.by_psi[j] * weights[j]);
            let information = by_psi.iter().map(|by| by * by).sum::<f64>() + PSI_INFORMATION;
            let slopes: [f64; CONSTANTS] =
                std::array::from_fn(|c| -(0..3).map(|j| by_psi[j] * by_constants[j][c]).sum::<f64>() / information);
            // With ψ eliminated: J'(1 − j jᵀ/(jᵀj + p)) J.
            let of_shape = rows(instant, psi, fit.order);
            let projected: [[f64; CONSTANTS]; 3] =
                std::array::from_fn(|j| std::array::from_fn(|c| by_constants[j][c] + by_psi[j] * slopes[c]));
            for c in 0..CONSTANTS {
                let projected: [f64; 3] = std::array::from_fn(|j| projected[j][c]);
                gradient[c] += (0..3).map(|j| projected[j] * value[j]).sum::<f64>();
                for other in 0..CONSTANTS {
                    own[(c, other)] += (0..3).map(|j| projected[j] * by_constants[j][other]).sum::<f64>();
                }
                for (j, row) in of_shape.column_iter().enumerate() {
                    by_shape.column_mut(c).axpy(projected[j] * weights[j], &row, 1.0);
                }
            }
            psi_slopes.push(slopes);
            projected_by_constants.push(projected);
        }
        let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior).strictly_convex();
        let normal = smoother.linearise(coefficients, &fit.estimate.psi);
        let solved = smoother.factor(&normal)?.solve(&by_shape);
        let schur: DMatrix<f64> = by_shape.transpose() * &solved;
        let reduced = gradient - Vector::from_iterator((solved.transpose() * &normal.gradient).iter().copied());
        let information = Matrix::from_fn(|i, j| (own[(i, j)] - schur[(i, j)]) * prior_sd[i] * prior_sd[j]);
        let stated = Vector::from(constants(&rig.calibration));
        let off = (Vector::from(constants(calibration)) - stated)
            .zip_map(&prior_sd, |off, sd| if sd > 0.0 { off / sd } else { 0.0 });
        let gradient = reduced.component_mul(&prior_sd);
        Some(Self {
            by_shape,
            own,
            psi_slopes,
            by_constants: projected_by_constants,
            shape_slopes: solved,
            information,
            borne_out: information,
            gradient,
            prior_sd,
            off,
        })
    }

    /// The same with no more information along any direction than the scatter of the residuals bears out: errors of the readings that are not
    /// those of the model (palm angles that are noisy move both contacts and the balance of a sample at once) make the gradient scatter more
    /// than its information says.
    pub fn borne_out_by(mut self, measurements: &Measurements, fit: &Fit) -> Self {
        let mut scatter = Matrix::zeros();
        let instants = measurements.instants.iter().zip(&fit.estimate.psi);
        for ((instant, &psi), by_constants) in instants.zip(&self.by_constants) {
            let value = combine(instant, contacts(instant, &fit.estimate.coefficients, psi)).value;
            let weights = fit.noise.weights(instant);
            let mut gradient = Vector::zeros();
            for (j, row) in rows(instant, psi, fit.order).column_iter().enumerate() {
                let of_shape = self.shape_slopes.tr_mul(&row);
                for c in 0..CONSTANTS {
                    gradient[c] += (by_constants[j][c] - weights[j] * of_shape[c]) * weights[j] * value[j];
                }
            }
            let gradient = gradient.component_mul(&self.prior_sd);
            scatter += gradient * gradient.transpose();
        }
        let eigen = self.information.symmetric_eigen();
        let roots = eigen.eigenvalues.map(|gain| gain.max(0.0).sqrt());
        let inverse = roots.map(|root| if root > 0.0 { 1.0 / root } else { 0.0 });
        let unit = eigen.eigenvectors * Matrix::from_diagonal(&inverse);
        let excess = (unit.transpose() * scatter * unit).symmetric_eigen();
        let kept = excess.eigenvalues.map(|excess| 1.0 / excess.max(1.0));
        let back = eigen.eigenvectors * Matrix::from_diagonal(&roots) * excess.eigenvectors;
        self.borne_out = back * Matrix::from_diagonal(&kept) * back.transpose();
        self
    }

    /// The change of the constants to their optimum along the directions that the log tells, in units of the priors.
    fn step(&self) -> Vector {
        let eigen = self.information.symmetric_eigen();
        let pull = eigen.eigenvectors.transpose() * (self.gradient + self.off);
        let along = Vector::from_fn(|k, _| {
            let gain = eigen.eigenvalues[k];
            if gain > LEAST_GAIN { -pull[k] / (gain + 1.0) } else { 0.0 }
        });
        eigen.eigenvectors * along
    }

    /// The calibration at the optimum.
    pub fn improved(&self, calibration: &Calibration, tolerances: &Tolerances) -> Calibration {
        changed(calibration, tolerances, &self.step().component_mul(&self.prior_sd))
    }

    /// The largest change to the optimum of any direction, in standard deviations of the posterior.
    pub fn distance_sds(&self) -> f64 {
        let eigen = self.information.symmetric_eigen();
        let along = eigen.eigenvectors.transpose() * self.step();
        along
            .iter()
            .zip(&eigen.eigenvalues)
            .map(|(step, gain)| step.abs() * (gain.max(0.0) + 1.0).sqrt())
            .fold(0.0, f64::max)
    }

    /// Posterior standard deviations of the constants; `inflation` multiplies the variance of the readings (correlated errors of neighbouring
    /// samples).
    pub fn sd(&self, inflation: f64) -> [f64; CONSTANTS] {
        let covariance = self.covariance(inflation);
        std::array::from_fn(|c| covariance[(c, c)].max(0.0).sqrt())
    }

    /// Their covariance.
    pub fn covariance(&self, inflation: f64) -> Matrix {
        let with_prior = self.borne_out / inflation + Matrix::identity();
        let covariance = with_prior.try_inverse().unwrap_or_else(Matrix::identity);
        Matrix::from_fn(|i, j| covariance[(i, j)] * self.prior_sd[i] * self.prior_sd[j])
    }

    /// The constant that is furthest from what the rig was stated to have, and how far, in standard deviations of the statement.
    pub fn furthest(&self) -> (String, f64) {
        let far = CalibrationConstant::ALL.iter().zip(&self.off).max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        far.map_or((String::new(), 0.0), |(constant, off)| (constant.name.to_owned(), off.abs()))
    }

    /// Covariance of the constants given the shape.
    fn covariance_given_shape(&self) -> DMatrix<f64> {
        let own = Matrix::from_fn(|i, j| self.own[(i, j)] * self.prior_sd[i] * self.prior_sd[j]);
        let with_prior = own + (self.borne_out - self.information) + Matrix::identity();
        let inverse = with_prior.try_inverse().unwrap_or_else(Matrix::identity);
        let covariance = |i: usize, j: usize| inverse[(i, j)] * self.prior_sd[i] * self.prior_sd[j];
        DMatrix::from_fn(CONSTANTS, CONSTANTS, covariance)
    }

    /// What error bars need of them: the likeliest constants follow the shape by −(C + P)⁻¹ Bᵀ, which takes B (C + P)⁻¹ Bᵀ from the information
    /// on it.
    pub fn open_constants(&self) -> OpenConstants {
        let covariance = self.covariance_given_shape();
        let by_coefficients = -(&covariance * self.by_shape.transpose());
        let slopes = self.psi_slopes.iter().flatten().copied();
        OpenConstants {
            psi_slopes: DMatrix::from_iterator(CONSTANTS, self.psi_slopes.len(), slopes),
            lost_information: -(&self.by_shape * &by_coefficients),
            by_coefficients,
            covariance,
        }
    }

    /// ln of the evidence that the constants add: their prior at the optimum, and the volume of the posterior against it.
    pub fn log_evidence(&self) -> f64 {
        let determinant = (self.information + Matrix::identity()).determinant().max(1.0);
        -0.5 * self.off.norm_squared() - 0.5 * determinant.ln()
    }
}

/// What the rows of one sample are made from: its corrected palms and positions.
pub(crate) struct Rows<'a> {
    pub calibration: &'a Calibration,
    pub tolerances: &'a Tolerances,
    pub palms: &'a PalmPair,
    pub positions: [f64; 2],
}

impl Rows<'_> {
    /// Derivatives of s1, s2 and the balance by the constants: `forces` are those of the balance by both palms, `rate` that of φ₁ and φ₂.
    pub fn by_constants(
        &self,
        shape: &SupportFunction,
        psi: f64,
        forces: [f64; 2],
        rate: [f64; 2],
    ) -> [[f64; CONSTANTS]; 3] {
        let (theta1, theta2) = self.palms.contact_angles(psi);
        let at: [ContactSupport; 2] = [shape.at(theta1), shape.at(theta2)];
        let shift = self.calibration.surface_shift_m(self.palms);
        let positions = [0, 1].map(|k| self.positions[k] + shift[k]);
        let by = self.calibration.rows(self.palms, at, positions);
        let (of_scale, of_surface) = (shares(self.tolerances.scale_sd), shares(self.tolerances.surface_sd_m));
        // A zero of φ₁ turns both palms back, one of φ₂ the second.
        let by_zeros = [-forces[0] - forces[1], -forces[1]];
        let of_contact = |k: usize| {
            let ratio = of_scale[0] * by.by_scale_m[0][k] + of_scale[1] * by.by_scale_m[1][k];
            let difference = of_surface[0] * by.by_surface[0][k] + of_surface[1] * by.by_surface[1][k];
            let [by_phi1, by_phi2] = [by.by_angle_zero_m[0][k], by.by_angle_zero_m[1][k]];
            let clock = rate[0] * by_phi1 + rate[1] * by_phi2;
            [by.by_zero[0][k], by.by_zero[1][k], ratio, by_phi1, by_phi2, difference, clock]
        };
        let clock = rate[0] * by_zeros[0] + rate[1] * by_zeros[1];
        [of_contact(0), of_contact(1), [0.0, 0.0, 0.0, by_zeros[0], by_zeros[1], 0.0, clock]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::evidence::Evidence;
    use crate::estimate::model::noise::Noise;
    use crate::estimate::model::prior::Prior;
    use crate::estimate::solver::gauss_newton::{Estimate, StoppingCriteria};
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::simulate::{SimulateOptions, simulate};

    const SIZE_M: f64 = 0.03;
    const NOISE: Noise = Noise { sensor_m: 5e-5, balance_m: 1e-5 };

    /// What is tried: base points apart, all constants open.
    fn rig() -> Rig {
        let tolerances = Tolerances { clock_offset_sd_s: 0.02, ..Tolerances::default() };
        Rig::new(Calibration::default(), tolerances)
    }

    /// A log, the shape and the motion behind it.
    fn felt() -> (Log, SupportFunction, Vec<f64>) {
        let shape = SupportFunction::new(SIZE_M, vec![[1e-3, -5e-4], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let motion = PalmMotion::random(7, 20.0, 0.7).and_then(|motion| motion.sample(10.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: NOISE.sensor_m, ..Touchpad::ideal() };
        let run =
            simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible");
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        (run.log, shape, psi)
    }

    /// The optimum of shape and motion for readings that are corrected by these constants.
    fn fitted(read: &Log, calibration: &Calibration, shape: &SupportFunction, psi: &[f64]) -> (Log, Measurements, Fit) {
        let log = calibration.corrected(read);
        let measurements = Measurements::new(&log, None);
        let prior = Prior::new(SIZE_M, 0.5 * SIZE_M);
        let stopping = StoppingCriteria { iterations: 60, tolerance: 1e-14 };
        let estimate: Estimate = Smoother::new(&measurements, 3, NOISE, prior).strictly_convex().run(
            shape.coefficients(),
            psi.to_vec(),
            stopping,
        );
        (log, measurements, Fit { estimate, order: 3, noise: NOISE, prior, evidence: Evidence::NONE })
    }

    #[test]
    fn gradient_and_information_are_those_of_the_profile_of_the_cost() {
        let (read, shape, psi) = felt();
        let rig = rig();
        let here = Calibration { zero_m: [2e-4, -1e-4], angle_zero_rad: [1e-3, -2e-3], ..Calibration::default() };
        let (log, measurements, fit) = fitted(&read, &here, &shape, &psi);
        let posterior = CalibrationPosterior::new(&log, &measurements, &fit, &rig, &here).expect("determined");
        for index in 0..CONSTANTS {
            // Steps are in units of the prior.
            let cost = |step: f64| {
                let mut moved = Vector::zeros();
                moved[index] = step * posterior.prior_sd[index];
                let there = changed(&here, &rig.tolerances, &moved);
                fitted(&read, &there, &shape, &psi).2.estimate.cost
            };
            // Palms between samples are interpolated, with rates that change at the samples.
            let step = if CalibrationConstant::ALL[index].name == "clock_offset_s" { 2e-4 } else { 5e-3 };
            let (slope, of_slope) = ((cost(step) - cost(-step)) / (4.0 * step), posterior.gradient[index]);
            assert!(
                (slope / of_slope - 1.0).abs() < 1e-4,
                "{}: {slope} {of_slope}",
                CalibrationConstant::ALL[index].name
            );
            // Gauss-Newton leaves out what residuals times second derivatives add.
            let step = 5e-3;
            let curvature = (cost(step) + cost(-step) - 2.0 * fit.estimate.cost) / (2.0 * step * step);
            let of_curvature = posterior.information[(index, index)];
            assert!(
                (curvature / of_curvature - 1.0).abs() < 0.15,
                "{}: {curvature} {of_curvature}",
                CalibrationConstant::ALL[index].name
            );
        }
    }

    #[test]
    fn constants_come_out_within_their_error_bars() {
        let (log, shape, psi) = felt();
        let truth = Calibration {
            zero_m: [4e-4, -3e-4],
            scale: [1.004, 0.996],
            angle_zero_rad: [4e-3, -6e-3],
            surface_m: [2e-4, -2e-4],
            clock_offset_s: 0.01,
        };
        let (read, rig) = (truth.distorted(&log), rig());
        let mut found = Calibration::default();
        let mut last = None;
        for _ in 0..6 {
            let (log, measurements, fit) = fitted(&read, &found, &shape, &psi);
            let posterior = CalibrationPosterior::new(&log, &measurements, &fit, &rig, &found).expect("determined");
            found = posterior.improved(&found, &rig.tolerances);
            last = Some(posterior);
        }
        let last = last.expect("six rounds");
        assert!(last.distance_sds() < 0.01);
        let off = constants(&found).into_iter().zip(constants(&truth)).zip(last.sd(1.0));
        for (CalibrationConstant { name, .. }, ((found, truth), sd)) in CalibrationConstant::ALL.iter().zip(off) {
            assert!((found - truth).abs() < 4.0 * sd, "{name}: {found} {truth} {sd}");
        }
        // The log told every one of them, and the readings are worth less where their errors are alike.
        let (sd, prior_sd) = (last.sd(1.0), prior_sd(&rig.tolerances));
        assert!(sd.iter().zip(prior_sd).all(|(sd, prior)| *sd < 0.5 * prior), "{sd:?}");
        assert!(last.sd(9.0).iter().zip(sd).all(|(inflated, sd)| *inflated > 2.0 * sd));
        assert!(last.log_evidence() < 0.0);
    }

    #[test]
    fn what_the_log_hardly_tells_stays_as_it_is_stated() {
        let (read, shape, psi) = felt();
        let off = Calibration { zero_m: [4e-4; 2], ..Calibration::default() };
        let step_with = |sd_m: f64| {
            let tolerances = Tolerances { zero_sd_m: [sd_m, 0.0], ..Tolerances::NONE };
            let rig = Rig::new(Calibration::default(), tolerances);
            let (log, measurements, fit) = fitted(&read, &off, &shape, &psi);
            let posterior = CalibrationPosterior::new(&log, &measurements, &fit, &rig, &off).expect("determined");
            let gain = posterior.information[(0, 0)];
            (gain, posterior.improved(&off, &tolerances) != off)
        };
        let (gain, _) = step_with(1e-6);
        let limit_m = 1e-6 / gain.sqrt();
        assert!(step_with(1.01 * limit_m).1 && !step_with(0.99 * limit_m).1);
        let exact = Rig::new(Calibration::default(), Tolerances::NONE);
        let (log, measurements, fit) = fitted(&read, &off, &shape, &psi);
        assert!(CalibrationPosterior::new(&log, &measurements, &fit, &exact, &off).is_none());
    }

    #[test]
    fn the_common_scale_and_surface_offset_stay() {
        let tolerances = Tolerances { scale_sd: [0.01, 0.02], surface_sd_m: [1e-3, 0.0], ..Tolerances::default() };
        let mut step = Vector::zeros();
        (step[2], step[5]) = (0.005, 2e-4);
        let found = changed(&Calibration::default(), &tolerances, &step);
        assert!((constants(&found)[2] - 0.005).abs() < 1e-15 && (constants(&found)[5] - 2e-4).abs() < 1e-18);
        // Weighted by what is known of each.
        assert!(((found.scale[0] - 1.0) / 1e-4 + (found.scale[1] - 1.0) / 4e-4).abs() < 1e-9);
        assert_eq!(found.surface_m[1], 0.0);
    }

    #[test]
    fn unknown_constants_take_information_from_the_shape() {
        let (read, shape, psi) = felt();
        let (log, measurements, fit) = fitted(&read, &Calibration::default(), &shape, &psi);
        let rig = rig();
        let posterior =
            CalibrationPosterior::new(&log, &measurements, &fit, &rig, &rig.calibration).expect("determined");
        let lost = posterior.open_constants().lost_information;
        assert!((&lost - lost.transpose()).amax() < 1e-9 * lost.amax());
        let smoother = Smoother::new(&measurements, fit.order, fit.noise, fit.prior).strictly_convex();
        let known = smoother.linearise(&fit.estimate.coefficients, &fit.estimate.psi).matrix;
        let left = (&known - &lost).cholesky().expect("still positive").inverse();
        let before = known.cholesky().expect("positive").inverse();
        // The mean radius is the less certain for it.
        assert!(left[(0, 0)] > 2.0 * before[(0, 0)], "{} {}", left[(0, 0)], before[(0, 0)]);
    }
}
