use super::*;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::sensor_memory::with_memory;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::palms::PalmMotion;
use crate::sensor::Touchpad;
use crate::shape::{SupportFunction, ellipse, rounded_polygon};
use crate::simulate::{SimulateOptions, simulate};

const SIZE_M: f64 = 0.03;
const NOISE_M: f64 = 3e-5;
const ORDER: usize = 12;

/// A general fit near the truth to a log of this object, in a frame turned at random.
fn fitted(shape: &SupportFunction, seed: u64) -> (Measurements, Fit) {
    fitted_with_memory(shape, seed, 1.0)
}

/// The same where errors of the sensors are correlated over so many samples.
fn fitted_with_memory(shape: &SupportFunction, seed: u64, memory: f64) -> (Measurements, Fit) {
    let shape = shape.rotated(0.7);
    let motion = PalmMotion::random(seed, 12.0, 1.0).and_then(|motion| motion.sample(40.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: if memory > 1.0 { 0.0 } else { NOISE_M }, ..Touchpad::ideal() };
    let run = simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible");
    let log = if memory > 1.0 { with_memory(run.log, NOISE_M, memory) } else { run.log };
    let measurements = Measurements::new(&log, None);
    let mut coefficients = shape.coefficients();
    crate::estimate::model::layout::coefficients_to_order(&mut coefficients, ORDER);
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let (noise, prior) = (Noise { sensor_m: NOISE_M, balance_m: 0.3 * NOISE_M }, Prior::new(SIZE_M, 0.5 * SIZE_M));
    let estimate = Smoother::new(&measurements, ORDER, noise, prior).strictly_convex().run(coefficients, psi, STOPPING);
    (measurements, Fit { estimate, order: ORDER, noise, prior, evidence: Evidence::NONE })
}

fn triangle() -> SupportFunction {
    rounded_polygon(3, 0.4, 0.5).expect("possible").scaled(SIZE_M)
}

fn model(models: &[SymmetricModel], order: u32, mirror: bool) -> &SymmetricModel {
    models.iter().find(|model| model.symmetry == Symmetry { order, mirror }).expect("one of the models")
}

/// The shape of a model, and that of the fit that it was made of in the same frame.
fn farthest_m(model: &SymmetricModel, fit: &Fit) -> f64 {
    let mut general = fit.estimate.coefficients.clone();
    rotate(&mut general, model.turn);
    let (there, here) =
        (SupportFunction::from_coefficients(&model.coefficients), SupportFunction::from_coefficients(&general));
    (0..360)
        .map(|i| f64::from(i).to_radians())
        .map(|at| (there.radius_m(at) - here.radius_m(at)).abs())
        .fold(0.0, f64::max)
}

#[test]
fn a_triangle_in_the_middle_of_its_mass_is_found_with_its_mirror() {
    let (measurements, fit) = fitted(&triangle(), 4);
    let models = symmetric_models(&measurements, &fit);
    assert_eq!(models[0].symmetry, Symmetry { order: 3, mirror: true });
    let best = &models[0];
    assert!(best.log_ratio > 20.0 && !best.is_contradicted(), "{}", best.log_ratio);
    assert!(best.determined > 5.0 && farthest_m(best, &fit) < 1e-4);
    // What it excludes is zero, and the axis of the mirror is that of the triangle.
    let shape = SupportFunction::from_coefficients(&best.coefficients);
    for (index, [a, b]) in shape.harmonics_m().iter().enumerate() {
        assert!(*b == 0.0 && ((index + 1) % 3 == 0 || *a == 0.0));
    }
    assert!(model(&models, 3, false).log_ratio > 10.0 && model(&models, 1, true).log_ratio > 10.0);
    assert!(model(&models, 2, false).is_contradicted() && model(&models, 4, true).is_contradicted());
}

#[test]
fn an_ellipse_is_the_same_after_half_a_turn_and_not_when_its_mass_is_off_the_middle() {
    let ellipse = ellipse(0.035, 0.026).expect("possible");
    let (measurements, fit) = fitted(&ellipse, 2);
    assert_eq!(symmetric_models(&measurements, &fit)[0].symmetry, Symmetry { order: 2, mirror: true });
    // Off along an axis: the mirror is left. Off anywhere: nothing is.
    let (measurements, fit) = fitted(&ellipse.translated(1e-3, 0.0), 2);
    let models = symmetric_models(&measurements, &fit);
    assert_eq!(models[0].symmetry, Symmetry { order: 1, mirror: true });
    assert!(!models[0].is_contradicted() && model(&models, 2, false).is_contradicted());
    let (measurements, fit) = fitted(&ellipse.translated(1e-3, 1e-3), 2);
    let models = symmetric_models(&measurements, &fit);
    assert!(models.iter().all(SymmetricModel::is_contradicted), "{}", models[0].missed);
}

#[test]
fn a_mark_of_half_a_percent_of_the_radius_is_told_from_symmetry() {
    // One flatter side: a dent of 0.15 mm, some 20 degrees wide.
    let dent = |theta: f64| -0.005 * SIZE_M * (-0.5 * (theta / 0.35).powi(2)).exp();
    let samples: Vec<(f64, f64)> = (0..720)
        .map(|i| std::f64::consts::TAU * f64::from(i) / 720.0)
        .map(|theta| {
            let from_mark = crate::math::angle::wrapped(theta - 1.3);
            (theta, triangle().radius_m(theta) + dent(from_mark))
        })
        .collect();
    let marked = SupportFunction::from_samples(&samples, 24).expect("possible");
    let (measurements, fit) = fitted(&marked, 4);
    let models = symmetric_models(&measurements, &fit);
    assert!(model(&models, 3, false).is_contradicted() && model(&models, 3, true).is_contradicted());
}

#[test]
fn a_symmetric_fit_is_contradicted_by_what_it_leaves_in_the_contacts() {
    for (offset_m, contradicted) in [(0.0, false), (5e-4, true)] {
        let (measurements, mut fit) = fitted(&triangle().translated(offset_m, 0.3 * offset_m), 4);
        fit.prior.symmetry = Symmetry { order: 3, mirror: false };
        let Estimate { coefficients, psi, .. } = fit.estimate.clone();
        fit.estimate = Smoother::new(&measurements, ORDER, fit.noise, fit.prior).strictly_convex().run(
            coefficients,
            psi,
            STOPPING,
        );
        let size = |k: usize| fit.estimate.coefficients[k].hypot(fit.estimate.coefficients[ORDER + k]);
        assert!([1, 2, 4, 5].into_iter().all(|k| size(k) < 1e-9) && size(3) > 1e-3);
        let against = against_general(&measurements, &fit).expect("determined").model;
        assert_eq!(against.is_contradicted(), contradicted, "{} of {}", against.missed, against.determined);
    }
}

#[test]
fn errors_with_a_memory_contradict_no_symmetry() {
    let symmetry = Symmetry { order: 3, mirror: false };
    for (offset_m, contradicted) in [(0.0, false), (5e-4, true)] {
        let (measurements, mut fit) = fitted_with_memory(&triangle().translated(offset_m, 0.3 * offset_m), 4, 9.0);
        let general = symmetric_models(&measurements, &fit);
        // As many of them as there are tell less.
        assert!(model(&general, 3, false).is_contradicted());
        fit.prior.symmetry = symmetry;
        let Estimate { coefficients, psi, .. } = fit.estimate.clone();
        let smoother = Smoother::new(&measurements, ORDER, fit.noise, fit.prior).strictly_convex();
        fit.estimate = smoother.run(coefficients, psi, STOPPING);
        let against = against_general(&measurements, &fit).expect("determined").model;
        assert_eq!(against.is_contradicted(), contradicted, "{} of {}", against.missed, against.determined);
    }
}

#[test]
fn contradiction_begins_three_standard_deviations_above_the_expectation() {
    let of = |missed: f64| SymmetricModel {
        symmetry: Symmetry { order: 2, mirror: false },
        coefficients: Vec::new(),
        turn: 0.0,
        log_ratio: 0.0,
        missed,
        determined: 8.0,
    };
    assert!(!of(20.9).is_contradicted() && of(21.1).is_contradicted());
}

#[test]
fn copies_differ_by_what_noise_makes_them_differ() {
    let symmetry = Symmetry { order: 3, mirror: false };
    let prior = Prior { symmetry, ..Prior::new(SIZE_M, 0.5 * SIZE_M) };
    const LOGS: u64 = 16;
    let mut ratio = 0.0;
    for seed in 4..4 + LOGS {
        let (measurements, fit) = fitted(&triangle(), seed);
        let shape = SupportFunction::from_coefficients(&fit.estimate.coefficients);
        let mut felt = vec![false; NODES];
        felt_nodes(&measurements, &fit.estimate.psi).for_each(|node| felt[node] = true);
        let r = |node: usize| shape.radius_m(TAU * node as f64 / NODES as f64);
        let pairs = (0..NODES).map(|node| (node, (node + NODES / 3) % NODES)).filter(|&(a, b)| felt[a] && felt[b]);
        let squares: Vec<f64> = pairs.map(|(a, b)| (r(a) - r(b)).powi(2)).collect();
        let symmetric = Fit { prior, ..fit };
        let expected_m = against_general(&measurements, &symmetric).expect("determined").deviation_sd_m;
        ratio += squares.iter().sum::<f64>() / squares.len() as f64 / expected_m.powi(2) / LOGS as f64;
    }
    assert!((0.5..1.5).contains(&ratio), "{ratio}");
}
