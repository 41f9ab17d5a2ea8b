//! What a motion pays for its jumps (`docs/theory.md`, decoding of the motion), as a part of its prior: those that statics predicts, those
//! that it does not, and those that it forbids. The barrier on the way is a difference of heights of the centre of mass, linear in the
//! shape, so that its standard deviation is known; and what the balance is off by may lift the object, by itself times the angle up to the top. A barrier
//! that these may have made costs hardly more than any jump that is not predicted, one that is certain excludes the motion.

use crate::estimate::evidence::motion_prior::{EXCLUDED, PREDICTED_JUMP, UNPREDICTED_JUMP};
use crate::estimate::jumps::DetectedJump;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::contacts;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::Layout;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother};
use crate::mechanics::passage::top_of_barrier;
use nalgebra::{Cholesky, DVector, Dyn};

/// Least standard deviation of a barrier, as a share of the mean radius: what taking the palms to stand still between two samples changes. Of 40
/// random logs that were explained rightly, one jump of 190 had a barrier at all, of a seventh of its standard deviation; wrong ones had some of
/// 9 um known to 0.2 um.
const LEAST_SD: f64 = 3e-5;

/// Standard deviations up to which a barrier may be none.
const NO_BARRIER_SDS: f64 = 2.0;

/// The variance of a linear function of the coefficients of a shape, given by its row, as far as a log tells the shape.
pub(crate) type VarianceOf<'a> = &'a dyn Fn(&DVector<f64>) -> f64;

/// That variance by the Cholesky factor of the information which the samples would be if each had an error of its own.
pub(crate) fn variance_by(information: &Cholesky<f64, Dyn>, samples_per_error: f64) -> impl Fn(&DVector<f64>) -> f64 {
    move |row| samples_per_error * information.solve(row).dot(row)
}

/// −2 ln of the prior of the jumps of a motion; `balance_m` is the standard deviation of the balance.
pub(crate) fn deviance(
    measurements: &Measurements,
    estimate: &Estimate,
    balance_m: f64,
    variance_of: VarianceOf,
    jumps: &[DetectedJump],
) -> f64 {
    let of_jump = |jump: &DetectedJump| {
        if jump.predicted {
            return PREDICTED_JUMP.deviance();
        }
        let barrier = barrier_sds(measurements, estimate, balance_m, variance_of, jump).powi(2);
        (UNPREDICTED_JUMP.deviance() + barrier).min(EXCLUDED.deviance())
    };
    jumps.iter().map(of_jump).sum()
}

/// Whether the barrier on the way of a jump is none of the shape's errors: known well enough to forbid it.
pub(crate) fn is_over_barrier(
    measurements: &Measurements,
    estimate: &Estimate,
    balance_m: f64,
    variance_of: VarianceOf,
    jump: &DetectedJump,
) -> bool {
    barrier_sds(measurements, estimate, balance_m, variance_of, jump) > NO_BARRIER_SDS
}

/// Height of the barrier on the way of a jump in standard deviations.
fn barrier_sds(
    measurements: &Measurements,
    Estimate { coefficients, .. }: &Estimate,
    balance_m: f64,
    variance_of: VarianceOf,
    jump: &DetectedJump,
) -> f64 {
    let instant = &measurements.instants[jump.sample];
    let height = |psi: f64| instant.palms.center(contacts(instant, coefficients, psi).r)[1];
    let (top, barrier_m) = top_of_barrier(height, jump.psi_before, jump.psi_after);
    let row = height_row(instant, coefficients, top) - height_row(instant, coefficients, jump.psi_before);
    let lifted_m = balance_m * (top - jump.psi_before);
    let least_m = LEAST_SD * coefficients[0];
    barrier_m / (variance_of(&row) + lifted_m * lifted_m + least_m * least_m).sqrt()
}

/// −ln of the same beyond what the evidence of a fit has for every jump ([`super::motion_prior::neg_log_prior`]).
pub(crate) fn excess(
    measurements: &Measurements,
    estimate: &Estimate,
    balance_m: f64,
    variance_of: VarianceOf,
    jumps: &[DetectedJump],
) -> f64 {
    0.5 * deviance(measurements, estimate, balance_m, variance_of, jumps) - PREDICTED_JUMP.0 * jumps.len() as f64
}

/// The evidence of a fit with the prior of its jumps; impossible where the log does not determine the shape.
pub(crate) fn with_jumps(measurements: &Measurements, fit: &Fit, jumps: &[DetectedJump]) -> Evidence {
    let Fit { estimate, order, noise, prior, evidence } = fit;
    let smoother = Smoother::new(measurements, *order, *noise, *prior).strictly_convex();
    let factor = smoother.factor(&smoother.linearise(&estimate.coefficients, &estimate.psi));
    factor.map_or(Evidence::IMPOSSIBLE, |factor| {
        let variance_of = variance_by(&factor, evidence.samples_per_error);
        evidence.with(-excess(measurements, estimate, noise.balance_m, &variance_of, jumps))
    })
}

/// Derivative of the height of the centre of mass at an orientation by the coefficients.
fn height_row(instant: &Instant, coefficients: &[f64], psi: f64) -> DVector<f64> {
    let layout = Layout::of_coefficients(coefficients);
    let (theta1, theta2) = instant.contact_angles(psi);
    let [of_first, of_second] = [[1.0, 0.0], [0.0, 1.0]].map(|r| instant.palms.center(r)[1]);
    layout.support_row(theta1) * of_first + layout.support_row(theta2) * of_second
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Log;
    use crate::log::Sample;
    use crate::mechanics::EnergyLandscape;
    use crate::palms::PalmPair;
    use crate::shape::{SupportFunction, ellipse};
    use nalgebra::DMatrix;

    type OfJumps<T> = fn(&Measurements, &Estimate, f64, VarianceOf, &[DetectedJump]) -> T;

    /// The prior of a jump of an ellipse over the barrier between its two poses, with an information of (1/`sd_m`)² on each coefficient; and
    /// that barrier, metres.
    fn with_jump<T>(sd_m: f64, predicted: bool, balance_m: f64, prior: OfJumps<T>) -> (T, f64) {
        let shape = ellipse(0.03, 0.024).expect("possible");
        let palms = PalmPair::hinged(0.6, 1.7);
        let landscape = EnergyLandscape::new(&shape, &palms);
        let [first, second] = [0, 1].map(|pose| landscape.stable_poses()[pose].psi_rad);
        let jump = DetectedJump {
            sample: 0,
            psi_before: first,
            psi_after: second,
            height_before_m: landscape.height_m(first),
            height_after_m: landscape.height_m(second),
            physical: predicted,
            predicted,
        };
        let (s1, s2) = palms.contact_positions_m(&shape, first);
        let measurements = Measurements::new(&Log { samples: vec![Sample::new(0.0, palms, s1, s2)] }, None);
        let coefficients = SupportFunction::coefficients(&shape);
        let unknowns = coefficients.len();
        let information = DMatrix::identity(unknowns, unknowns) / (sd_m * sd_m);
        let (_, barrier_m) = top_of_barrier(|psi| landscape.height_m(psi), first, second);
        let estimate = Estimate { coefficients, psi: vec![first], cost: 0.0 };
        let information = information.cholesky().expect("definite");
        let variance_of = variance_by(&information, 1.0);
        (prior(&measurements, &estimate, balance_m, &variance_of, &[jump]), barrier_m)
    }

    fn of_known_to(sd_m: f64, predicted: bool) -> (f64, f64) {
        with_jump(sd_m, predicted, 0.0, deviance)
    }

    #[test]
    fn a_certain_barrier_excludes_a_jump_and_an_uncertain_one_does_not() {
        let (certain, barrier_m) = of_known_to(1e-6, false);
        assert!(barrier_m > 100.0 * LEAST_SD * 0.027, "{barrier_m}");
        assert_eq!(certain, EXCLUDED.deviance());
        let unpredicted = UNPREDICTED_JUMP.deviance();
        // The standard deviation of the barrier itself is a few times that of a coefficient.
        let uncertain = of_known_to(barrier_m, false).0;
        assert!((unpredicted..unpredicted + 1.0).contains(&uncertain), "{uncertain}");
        let between = of_known_to(0.02 * barrier_m, false).0;
        assert!(between > 2.0 * unpredicted && between < 0.5 * certain, "{between}");
        assert_eq!(of_known_to(1e-6, true).0, PREDICTED_JUMP.deviance());
        // Beyond what any fit pays for a jump.
        assert_eq!(with_jump(1e-6, true, 0.0, excess).0, 0.0);
        let beyond = with_jump(0.02 * barrier_m, false, 0.0, excess).0;
        assert!((beyond - (0.5 * between - PREDICTED_JUMP.0)).abs() < 1e-9);
    }

    #[test]
    fn a_barrier_of_more_than_two_standard_deviations_is_none_of_the_errors_of_the_shape() {
        let sds = |sd_m: f64| with_jump(sd_m, false, 0.0, |a, b, c, d, jumps| barrier_sds(a, b, c, d, &jumps[0])).0;
        // The least standard deviation of a barrier is nothing beside these.
        let of_two_m = 1e-4 * sds(1e-4) / NO_BARRIER_SDS;
        let over =
            |sd_m: f64| with_jump(sd_m, false, 0.0, |a, b, c, d, jumps| is_over_barrier(a, b, c, d, &jumps[0])).0;
        assert!(
            over(0.99 * of_two_m) && !over(1.01 * of_two_m),
            "{} and {}",
            sds(0.99 * of_two_m),
            sds(1.01 * of_two_m)
        );
    }

    #[test]
    fn what_the_balance_is_off_by_lifts_the_object_over_a_barrier() {
        let (_, barrier_m) = of_known_to(1e-6, false);
        // The poses are half a turn apart, the top between them.
        let deviance = |share: f64| with_jump(1e-6, false, share * barrier_m, deviance).0;
        assert!(deviance(2.0) < UNPREDICTED_JUMP.deviance() + 1.0);
        assert_eq!(deviance(1e-3), EXCLUDED.deviance());
    }

    #[test]
    fn samples_that_share_their_errors_tell_a_shape_as_few_of_them_would() {
        let information = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 100.0])).cholesky().expect("definite");
        let variance =
            |samples_per_error: f64| variance_by(&information, samples_per_error)(&DVector::from_vec(vec![1.0, 10.0]));
        assert!((variance(1.0) - 1.25).abs() < 1e-12 && (variance(5.0) - 6.25).abs() < 1e-12);
    }
}
