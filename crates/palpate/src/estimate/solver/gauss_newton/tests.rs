//! The smoother against dense normal equations that are put together from the public forward model by finite differences.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact_lanes::turned_frames;
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Smoother, StoppingCriteria};
use crate::estimate::solver::normal_equations::SHARE;
use crate::log::Log;
use crate::math::lanes::{LANES, Lanes};
use crate::palms::{PalmMotion, PalmPair};
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;
use crate::simulate::{SimulateOptions, Simulation, simulate};
use nalgebra::{DMatrix, DVector};

use super::*;

const SIZE_M: f64 = 0.03;

const ORDER: usize = 3;

const UNKNOWNS: usize = 2 * ORDER + 1;

const NOISE: Noise = Noise { sensor_m: 1e-4, balance_m: 5e-5 };

/// Too wide to matter.
const NO_PRIOR: Prior = Prior::new(SIZE_M, 1e6);

const TO_THE_END: StoppingCriteria = StoppingCriteria { iterations: 200, tolerance: 1e-13 };

fn shape() -> SupportFunction {
    SupportFunction::new(SIZE_M, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
}

/// `count` samples without a jump.
fn run(count: usize, noise_sd_m: f64) -> Simulation {
    let points = [(0.0, 0.5, 1.9), (3.0, 0.9, 1.2), (6.0, 0.4, 1.5), (9.0, 1.2, 1.4), (12.0, 0.8, 1.9)];
    let motion = PalmMotion::through(&points)
        .and_then(|motion| motion.sample((count - 1) as f64 / 12.0))
        .expect("a possible motion");
    let options = SimulateOptions {
        touchpad: Touchpad { noise_sd_m, ..Touchpad::ideal() },
        seed: 5,
        start_psi_rad: 1.0,
        ..SimulateOptions::default()
    };
    let run = simulate(&shape(), &motion, &options).expect("possible");
    assert!(run.jumps.is_empty() && run.log.samples.len() == count);
    run
}

fn true_psi(run: &Simulation) -> Vec<f64> {
    run.truth.motion.iter().map(|pose| pose.psi_rad).collect()
}

/// All weighted residuals at x = (a0, a1 … aK, b1 … bK, ψ1 … ψN) as the head of `gauss_newton.rs` defines them, from the
/// forward model that the simulator uses: contacts and balance, then the prior, then convexity at 6K + 12 nodes.
fn dense_residuals(log: &Log, prior: Prior, x: &DVector<f64>) -> DVector<f64> {
    let a = x.rows(0, UNKNOWNS);
    let harmonics = (1..=ORDER).map(|k| [a[k], a[ORDER + k]]).collect();
    let shape = SupportFunction::new(a[0], harmonics);
    let mut all = Vec::new();
    for (index, sample) in log.samples.iter().enumerate() {
        let palms: &PalmPair = &sample.palms;
        let psi = x[UNKNOWNS + index];
        let (s1, s2) = palms.contact_positions_m(&shape, psi);
        let (theta1, theta2) = palms.contact_angles(psi);
        let g = shape.at(theta1).d * palms.phi12_rad().sin() + shape.at(theta2).d * palms.phi1_rad.sin();
        all.push(sample.s1_m.map_or(0.0, |measured| (s1 - measured) / NOISE.sensor_m));
        all.push(sample.s2_m.map_or(0.0, |measured| (s2 - measured) / NOISE.sensor_m));
        all.push(g / NOISE.balance_m);
    }
    let harmonic_sd = |k: usize| if k == 1 { prior.size_m } else { prior.scale_m / (k * k) as f64 };
    all.push(a[0] / (10.0 * prior.size_m));
    all.extend((1..=ORDER).flat_map(|k| [a[k] / harmonic_sd(k), a[ORDER + k] / harmonic_sd(k)]));
    let nodes = 6 * ORDER + 12;
    all.extend((0..nodes).map(|node| {
        let theta = std::f64::consts::TAU * node as f64 / nodes as f64;
        f64::max(0.0, 8e-3 * prior.size_m - shape.at(theta).v) / (5e-4 * prior.size_m)
    }));
    DVector::from_vec(all)
}

/// Central differences.
fn dense_jacobian(log: &Log, prior: Prior, x: &DVector<f64>) -> DMatrix<f64> {
    let columns: Vec<DVector<f64>> = (0..x.len())
        .map(|column| {
            let step = if column < UNKNOWNS { 1e-6 } else { 1e-5 };
            let (mut plus, mut minus) = (x.clone(), x.clone());
            plus[column] += step;
            minus[column] -= step;
            (dense_residuals(log, prior, &plus) - dense_residuals(log, prior, &minus)) / (2.0 * step)
        })
        .collect();
    DMatrix::from_columns(&columns)
}

fn joined(coefficients: &[f64], psi: &[f64]) -> DVector<f64> {
    DVector::from_iterator(coefficients.len() + psi.len(), coefficients.iter().chain(psi).copied())
}

#[test]
fn the_truth_of_an_exact_log_is_a_minimum_of_cost_zero() {
    let run = run(40, 0.0);
    let measurements = Measurements::new(&run.log, None);
    let smoother = Smoother::new(&measurements, ORDER, NOISE, NO_PRIOR);
    let (a, psi) = (shape().coefficients(), true_psi(&run));
    let normal = smoother.linearise(&a, &psi);
    let mut projected = psi.clone();
    let cost = smoother.project_orientations(&a, &mut projected, 2);
    // What is left is the prior of the mean radius (1/100) and of the first harmonic.
    let prior = 0.01 + (2e-3f64.powi(2) + 1e-3f64.powi(2)) / SIZE_M.powi(2);
    assert!((cost - prior).abs() < 1e-9, "{cost} {prior}");
    assert!(projected.iter().zip(&psi).all(|(a, b)| (a - b).abs() < 1e-9));
    let mut gradient = normal.gradient.clone();
    gradient[0] -= a[0] / (10.0 * SIZE_M).powi(2);
    gradient[1] -= a[1] / SIZE_M.powi(2);
    gradient[ORDER + 1] -= a[ORDER + 1] / SIZE_M.powi(2);
    // One micrometre in a coefficient moves the gradient by `matrix` · 1e-6; the gradient at the truth is less by far.
    let scale = normal.matrix.diagonal().min() * 1e-6;
    assert!(gradient.amax() < 1e-4 * scale, "{gradient} {scale}");
}

#[test]
fn a_disturbed_start_comes_back_to_the_truth() {
    let run = run(60, 0.0);
    let measurements = Measurements::new(&run.log, None);
    let smoother = Smoother::new(&measurements, ORDER, NOISE, NO_PRIOR);
    let disturbed: Vec<f64> =
        shape().coefficients().iter().enumerate().map(|(i, a)| a + 4e-4 * (1.7 * i as f64).sin()).collect();
    let psi: Vec<f64> = true_psi(&run).iter().enumerate().map(|(i, psi)| psi + 0.05 * (i as f64).cos()).collect();
    let found = smoother.run(disturbed, psi, TO_THE_END);
    assert!(found.cost < 0.02, "{}", found.cost);
    let turned = found.psi[0] - true_psi(&run)[0];
    for (found, truth) in found.psi.iter().zip(true_psi(&run)) {
        assert!((found - truth - turned).abs() < 1e-5, "{}", found - truth - turned);
    }
    // ψ larger by `turned` is the object frame turned back: r(θ) found = r(θ + turned) true.
    let found = SupportFunction::from_coefficients(&found.coefficients);
    for theta in 0..6 {
        let (found, truth) = (found.at(f64::from(theta)).r, shape().at(f64::from(theta) + turned).r);
        // Each ψ converges to a thousandth of its standard deviation, and so the shape to a hundredth of the noise.
        assert!((found - truth).abs() < 0.01 * NOISE.sensor_m, "{found} {truth}");
    }
}

#[test]
fn elimination_of_psi_is_the_schur_complement_of_the_whole() {
    let mut run = run(12, 1e-4);
    // Each kind of sample: both contacts, one missing, none.
    run.log.samples[3].s1_m = None;
    run.log.samples[5].s2_m = None;
    (run.log.samples[8].s1_m, run.log.samples[8].s2_m) = (None, None);
    let measurements = Measurements::new(&run.log, None);
    // Somewhere, not at a minimum; once convex and once with nodes that are not.
    let psi: Vec<f64> = true_psi(&run).iter().enumerate().map(|(i, psi)| psi + 0.02 * (i as f64).cos()).collect();
    for (third, convex) in [(7e-4, true), (6e-3, false)] {
        let mut a = shape().coefficients();
        a[2 * ORDER] = third;
        let prior = Prior::new(SIZE_M, 0.01);
        let normal = Smoother::new(&measurements, ORDER, NOISE, prior).linearise(&a, &psi);

        let x = joined(&a, &psi);
        let residuals = dense_residuals(&run.log, prior, &x);
        let violated = residuals.rows(residuals.len() - 30, 30).iter().filter(|value| **value > 0.0).count();
        assert_eq!(violated == 0, convex, "{violated} nodes");
        let jacobian = dense_jacobian(&run.log, prior, &x);
        let mut whole = jacobian.transpose() * &jacobian;
        let gradient = jacobian.transpose() * &residuals;
        // The prior information on the step of each ψ: one radian.
        (UNKNOWNS..x.len()).for_each(|i| whole[(i, i)] += 1.0);
        let count = psi.len();
        let shape_block = whole.view((0, 0), (UNKNOWNS, UNKNOWNS));
        let coupling = whole.view((0, UNKNOWNS), (UNKNOWNS, count));
        let inverse = whole.view((UNKNOWNS, UNKNOWNS), (count, count)).into_owned().try_inverse().expect("diagonal");
        let reduced = shape_block - coupling * &inverse * coupling.transpose();
        let right = gradient.rows(0, UNKNOWNS) - coupling * &inverse * gradient.rows(UNKNOWNS, count);

        let scale = reduced.amax();
        assert!((&normal.matrix - &reduced).amax() < 1e-6 * scale, "{} {reduced}", normal.matrix);
        assert!((&normal.gradient - &right).amax() < 1e-6 * right.amax(), "{} {right}", normal.gradient);
        let slope = -&inverse * coupling.transpose();
        let offset = -&inverse * gradient.rows(UNKNOWNS, count);
        for i in 0..count {
            for (mine, theirs) in normal.psi_slope(i).iter().zip(slope.row(i).iter()) {
                assert!((mine - theirs).abs() < 1e-6 * slope.amax(), "sample {i}: {mine} {theirs}");
            }
            assert!((normal.psi_offset[i] - offset[i]).abs() < 1e-6 * offset.amax(), "sample {i}");
            let information = whole[(UNKNOWNS + i, UNKNOWNS + i)] - 1.0;
            assert!((normal.psi_information(i) - information).abs() <= 1e-6 * information, "sample {i}");
        }
    }
}

/// Levenberg-Marquardt on all unknowns at once.
fn dense_optimum(log: &Log, prior: Prior, mut x: DVector<f64>) -> (DVector<f64>, f64) {
    let mut cost = dense_residuals(log, prior, &x).norm_squared();
    let mut damping = 1e-6;
    for _ in 0..100 {
        let jacobian = dense_jacobian(log, prior, &x);
        let gradient = jacobian.transpose() * dense_residuals(log, prior, &x);
        let mut matrix = jacobian.transpose() * &jacobian;
        (0..x.len()).for_each(|i| matrix[(i, i)] *= 1.0 + damping);
        let step = matrix.cholesky().expect("positive definite").solve(&gradient);
        let next = &x - step;
        let lower = dense_residuals(log, prior, &next).norm_squared();
        if lower < cost {
            let fall = cost - lower;
            (x, cost, damping) = (next, lower, damping * 0.2);
            if fall < 1e-11 * cost {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    (x, cost)
}

#[test]
fn the_optimum_is_that_of_a_dense_solver() {
    let run = run(40, 1e-4);
    let measurements = Measurements::new(&run.log, None);
    let prior = Prior::new(SIZE_M, 0.01);
    let start = vec![SIZE_M, 1e-3, 1e-3, 0.0, 0.0, 0.0, 0.0];
    let found = Smoother::new(&measurements, ORDER, NOISE, prior).run(start.clone(), true_psi(&run), TO_THE_END);
    let (x, cost) = dense_optimum(&run.log, prior, joined(&start, &true_psi(&run)));
    assert!((found.cost / cost - 1.0).abs() < 1e-7, "{} {cost}", found.cost);
    // Gaussian noise in 2 · 40 readings: the cost is about their number.
    assert!((40.0..120.0).contains(&cost), "{cost}");
    // The object frame may turn; all else agrees to a thousandth of the standard deviations.
    assert!((found.coefficients[0] - x[0]).abs() < 1e-8);
    for k in 1..=ORDER {
        let size = |a: f64, b: f64| a.hypot(b);
        let mine = size(found.coefficients[k], found.coefficients[ORDER + k]);
        assert!((mine - size(x[k], x[ORDER + k])).abs() < 2e-8, "harmonic {k}");
    }
    let turned = found.psi[0] - x[UNKNOWNS];
    for (i, psi) in found.psi.iter().enumerate() {
        assert!((psi - x[UNKNOWNS + i] - turned).abs() < 2e-6, "sample {i}: {}", psi - x[UNKNOWNS + i] - turned);
    }
}

#[test]
fn chord_steps_lead_to_the_same_optimum() {
    let run = run(200, 1e-4);
    let measurements = Measurements::new(&run.log, None);
    let prior = Prior::new(SIZE_M, 0.01);
    let smoother = Smoother::new(&measurements, ORDER, NOISE, prior);
    let start: Vec<f64> = shape().coefficients().iter().map(|a| 1.02 * a).collect();
    let near = smoother.run_chord(start, true_psi(&run), StoppingCriteria { iterations: 50, tolerance: 1e-9 });
    let best = smoother.run(shape().coefficients(), true_psi(&run), TO_THE_END);
    assert!((near.cost / best.cost - 1.0).abs() < 1e-8, "{} {}", near.cost, best.cost);
}

#[test]
fn the_gradient_alone_is_that_of_the_normal_equations() {
    let run = run(30, 1e-4);
    let measurements = Measurements::new(&run.log, None);
    let prior = Prior::new(SIZE_M, 0.01);
    let smoother = Smoother::new(&measurements, ORDER, NOISE, prior);
    // Somewhere, not at a minimum; once convex and once with nodes that are not.
    for third in [7e-4, 6e-3] {
        let mut a = shape().coefficients();
        a[2 * ORDER] = third;
        let mut psi: Vec<f64> =
            true_psi(&run).iter().enumerate().map(|(i, psi)| psi + 0.02 * (i as f64).cos()).collect();
        let projected = smoother.project_orientations(&a, &mut psi, 1);
        let crate::estimate::solver::chord::Slope { cost, gradient, .. } =
            smoother.project_with_gradient(&a, &mut psi, 0);
        let normal = smoother.linearise(&a, &psi);
        assert!((cost / projected - 1.0).abs() < 1e-12);
        assert!(
            (&gradient - &normal.gradient).amax() < 1e-9 * normal.gradient.amax(),
            "{gradient} {}",
            normal.gradient
        );
    }
}

#[test]
fn a_long_log_gives_bit_identical_results_on_any_number_of_threads() {
    let count = 2 * SHARE + 100;
    let run = run(count, 1e-4);
    let measurements = Measurements::new(&run.log, None);
    let prior = Prior::new(SIZE_M, 0.01);
    let (a, psi) = (shape().coefficients(), true_psi(&run));
    let smoother = Smoother::new(&measurements, ORDER, NOISE, prior);
    let work = || {
        let (normal, mut projected) = (smoother.linearise(&a, &psi), psi.clone());
        let slope = smoother.project_with_gradient(&a, &mut projected, 2);
        let cost = smoother.project_orientations(&a, &mut psi.clone(), 2);
        let turned = normal.turned(&psi, &slope.psi_offset, &slope.gradient);
        (normal.matrix, normal.gradient, normal.psi_offset, slope.gradient, slope.cost, cost, projected, turned)
    };
    let on =
        |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(work);
    let whole = on(1);
    assert_eq!(whole, on(3));
    assert!((whole.4 / whole.5 - 1.0).abs() < 1e-12);

    let mut matrix = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
    let mut of_psi = Vec::new();
    for range in [0..1000, 1000..count] {
        let part = measurements.of(measurements.instants[range.clone()].to_vec());
        let normal = Smoother::new(&part, ORDER, NOISE, NO_PRIOR).linearise(&a, &psi[range]);
        matrix += normal.matrix;
        of_psi.extend(normal.psi_offset);
    }
    assert!((&matrix - &whole.0).amax() < 1e-6 * matrix.amax());
    assert_eq!(of_psi, whole.2);
}

#[test]
fn a_posterior_as_prior_replaces_the_samples_it_came_from() {
    // Half of the samples as a Gaussian of the shape, together with the other half: the normal equations of all.
    let run = run(40, 1e-4);
    let half =
        |range: std::ops::Range<usize>| Measurements::new(&Log { samples: run.log.samples[range].to_vec() }, None);
    let (first, second, whole) = (half(0..20), half(20..40), half(0..40));
    let (a, psi) = (shape().coefficients(), true_psi(&run));
    let prior = Prior::new(SIZE_M, 0.01);
    let of_first = Smoother::new(&first, ORDER, NOISE, prior).linearise(&a, &psi[..20]);
    // The minimum of the quadratic that the first half leaves.
    let step = of_first.matrix.clone().cholesky().expect("positive definite").solve(&of_first.gradient);
    let belief = Posterior {
        layout: Layout::of_shape(ORDER),
        information: of_first.matrix.clone(),
        mean: DVector::from_row_slice(&a) - step,
    };
    let joint = Smoother::with_belief(&second, ORDER, NOISE, prior, &belief).linearise(&a, &psi[20..]);
    let all = Smoother::new(&whole, ORDER, NOISE, prior).linearise(&a, &psi);
    assert!((&joint.matrix - &all.matrix).amax() < 1e-10 * all.matrix.amax());
    assert!((&joint.gradient - &all.gradient).amax() < 1e-6 * all.gradient.amax());
}

#[test]
fn coefficients_are_padded_to_more_harmonics_and_cut_to_fewer() {
    let mut a = vec![1.0, 2.0, 3.0, 4.0, 5.0];
    coefficients_to_order(&mut a, 3);
    assert_eq!(a, [1.0, 2.0, 3.0, 0.0, 4.0, 5.0, 0.0]);
    coefficients_to_order(&mut a, 1);
    assert_eq!(a, [1.0, 2.0, 4.0]);
}

#[test]
fn the_frame_is_orthonormal_and_ends_along_its_vector() {
    for p in [[1.0, -2.0, 0.5], [0.0, 0.0, 3.0], [0.0, 0.0, -1e-9], [5.0, 0.0, 0.0], [0.0; 3]] {
        let frame = turned_frames(&p.map(|p| Lanes([p; LANES]))).map(|vector| vector.map(|lanes| lanes[LANES - 1]));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for i in 0..3 {
            for j in 0..3 {
                assert!((dot(frame[i], frame[j]) - f64::from(i == j)).abs() < 1e-14);
            }
        }
        assert!(dot(frame[0], p).abs() < 1e-14 && dot(frame[1], p).abs() < 1e-14 && dot(frame[2], p) >= 0.0);
    }
}
