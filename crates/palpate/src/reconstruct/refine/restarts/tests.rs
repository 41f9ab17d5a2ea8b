use super::*;
use crate::estimate::model::contact::residuals;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::plan::{PalmLimits, plan_turn};
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;
use crate::simulate::{SimulateOptions, simulate};
use nalgebra::DVector;

const SIZE_M: f64 = 0.03;

/// The optimum of a log of a nearly round object with a little noise, or of its first samples.
fn optimum(samples: usize) -> (Measurements, Fit) {
    let shape = SupportFunction::new(SIZE_M, vec![[1e-3, -5e-4], [4e-4, 2e-4], [-2e-4, 1e-4]]);
    let plan = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let options = SimulateOptions {
        start_psi_rad: plan.start_psi_rad,
        touchpad: Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() },
        ..SimulateOptions::default()
    };
    let motion = plan.motion.sample(20.0).expect("possible");
    let mut run = simulate(&shape, &motion, &options).expect("possible");
    run.log.samples.truncate(samples);
    let psi = run.truth.motion.iter().take(samples).map(|pose| pose.psi_rad).collect();
    let measurements = Measurements::new(&run.log, None);
    let noise = Noise { sensor_m: 1e-4, balance_m: 2e-5 };
    let prior = Prior::new(SIZE_M, 0.5 * SIZE_M);
    let estimate = Estimate { coefficients: shape.coefficients(), psi, cost: 0.0 };
    (measurements, Fit { estimate, order: 3, noise, prior, evidence: Evidence::NONE })
}

#[test]
fn an_informative_log_has_no_restarts_and_a_short_one_has() {
    let (measurements, fit) = optimum(800);
    assert!(along_weakest_direction(&measurements, &fit).is_none());
    let (measurements, fit) = optimum(120);
    let [one, other] = along_weakest_direction(&measurements, &fit).expect("a valley");
    let centre = |estimate: &Estimate| (estimate.coefficients[1], estimate.coefficients[4]);
    let ((x, y), (x1, y1), (x2, y2)) = (centre(&fit.estimate), centre(&one), centre(&other));
    // The first harmonic moves by the same amount to both sides.
    assert!((x1 - x).hypot(y1 - y) > 4e-5, "{x1} {x} {y1} {y}");
    assert!((x1 + x2 - 2.0 * x).abs() < 1e-12 && (y1 + y2 - 2.0 * y).abs() < 1e-12);
}

/// The eigenvector of the smallest eigenvalue by inverse iteration, and the standard deviation along it.
fn weakest_direction(measurements: &Measurements, fit: &Fit) -> (DVector<f64>, f64) {
    let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior);
    let information = smoother.posterior(&fit.estimate).expect("finite").information;
    let factor = information.clone().cholesky().expect("positive definite");
    let mut direction = DVector::from_fn(information.nrows(), |index, _| 1.0 + index as f64);
    for _ in 0..2000 {
        direction = factor.solve(&direction).normalize();
    }
    let least = (&information * &direction).dot(&direction);
    (direction, 1.0 / least.sqrt())
}

fn steps_of(fit: &Fit, restarts: &[Estimate; 2]) -> [DVector<f64>; 2] {
    let here = DVector::from_vec(fit.estimate.coefficients.clone());
    [0, 1].map(|restart| DVector::from_vec(restarts[restart].coefficients.clone()) - &here)
}

#[test]
fn both_restarts_lie_along_the_weakest_direction_of_the_shape() {
    let (measurements, fit) = optimum(120);
    let restarts = along_weakest_direction(&measurements, &fit).expect("a valley");
    let (direction, sd_m) = weakest_direction(&measurements, &fit);
    let [down, up] = steps_of(&fit, &restarts);
    let along = up.dot(&direction);
    assert!((along.abs() / (RESTART_SDS * sd_m) - 1.0).abs() < 1e-6, "{along} {sd_m}");
    assert!((&up - &direction * along).norm() < 1e-6 * along.abs(), "nothing across");
    assert!((down + up).norm() < 1e-12, "as far on the other side");
    assert!(restarts.iter().all(|restart| restart.cost.is_infinite()), "not an optimum yet");
}

#[test]
fn every_orientation_follows_the_shape_to_first_order() {
    let (measurements, fit) = optimum(120);
    let restarts = along_weakest_direction(&measurements, &fit).expect("a valley");
    let mut largest: f64 = 0.0;
    for (restart, step) in restarts.iter().zip(steps_of(&fit, &restarts)) {
        for (index, instant) in measurements.instants.iter().enumerate() {
            let psi = fit.estimate.psi[index];
            let of = |coefficients: &[f64]| residuals(instant, coefficients, psi);
            let (here, there) = (of(&fit.estimate.coefficients), of(&restart.coefficients));
            let weights = fit.noise.weights(instant);
            // The turn that compensates the step of the shape best in the three residuals, which are linear in the shape.
            let pairs = (0..3).map(|j| (weights[j] * here.by_psi[j], weights[j] * (there.value[j] - here.value[j])));
            let (along, square) =
                pairs.fold((0.0, 0.0), |(a, s), (by_psi, by_shape)| (a + by_psi * by_shape, s + by_psi * by_psi));
            let turn = (-along / (square + 1.0)).clamp(-0.3, 0.3);
            assert!((restart.psi[index] - psi - turn).abs() < 1e-9, "{} {turn} at {index}", restart.psi[index] - psi);
            largest = largest.max(turn.abs());
        }
        assert!(step.norm() > 0.0);
    }
    assert!(largest > 1e-4, "{largest}");
}

#[test]
fn restarts_are_made_from_a_least_length_of_the_valley_on() {
    let (measurements, fit) = optimum(120);
    let (_, sd_m) = weakest_direction(&measurements, &fit);
    for (excess, counts) in [(1.01, true), (0.99, false)] {
        // With all standard deviations scaled, that of the shape is as well.
        let factor = excess * LEAST_LENGTH * fit.estimate.coefficients[0] / sd_m;
        let mut scaled = fit.clone();
        scaled.noise = Noise { sensor_m: factor * fit.noise.sensor_m, balance_m: factor * fit.noise.balance_m };
        scaled.prior = Prior::new(factor * fit.prior.size_m, factor * fit.prior.scale_m);
        assert_eq!(along_weakest_direction(&measurements, &scaled).is_some(), counts, "{excess}");
    }
}
