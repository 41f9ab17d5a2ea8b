//! Noise, prior and number of harmonics on simulated logs.

use crate::estimate::evidence::fit::{ROUNDS, evidence_at, fit};
use crate::estimate::evidence::motion_prior::{PREDICTED_JUMP, UNSTABLE_POSE, neg_log_prior};
use crate::estimate::evidence::order::choose_order;
use crate::estimate::evidence::variance_components::{
    LEAST_BALANCE_SHARE, VarianceComponents, updated_scale, with_balance_weights,
};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::palms::{PalmMotion, PalmPair};
use crate::plan::{PalmLimits, plan_turn};
use crate::sensor::Touchpad;
use crate::shape::{RandomShape, SupportFunction, random_shape, rounded_polygon};
use crate::simulate::{SimulateOptions, simulate};
use std::f64::consts::TAU;

const SIZE_M: f64 = 0.03;
const NOISE_M: f64 = 5e-5;

fn pebble() -> SupportFunction {
    random_shape(&RandomShape { mean_radius_m: SIZE_M, order: 6, ..RandomShape::default() }, 4).expect("a valid kind")
}

/// A log without a jump, and its true shape and motion as the start.
fn setting(shape: &SupportFunction, samples: usize, noise_sd_m: f64) -> (Measurements, Estimate) {
    let plan = plan_turn(shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let motion: Vec<(f64, PalmPair)> = plan.motion.sample(samples as f64 / 40.0).expect("possible");
    let options = SimulateOptions {
        start_psi_rad: plan.start_psi_rad,
        touchpad: Touchpad { noise_sd_m, ..Touchpad::ideal() },
        ..SimulateOptions::default()
    };
    let run = simulate(shape, &motion, &options).expect("possible");
    let mut coefficients = shape.coefficients();
    coefficients_to_order(&mut coefficients, 8);
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    (Measurements::new(&run.log, None), Estimate { coefficients, psi, cost: f64::INFINITY })
}

fn free() -> VarianceComponents {
    VarianceComponents { sensor: true, floor_m: 1e-6 * SIZE_M, least_balance_share: LEAST_BALANCE_SHARE }
}

const PRIOR: Prior = Prior::new(SIZE_M, 0.5 * SIZE_M);

/// So many samples of a random object with four harmonics under a random motion, every so many hundredths of a second, and their optimum from the truth.
pub(super) fn optimum(seed: u64, samples: usize, every: usize) -> (Measurements, Fit) {
    let shape = random_shape(&RandomShape { order: 4, ..RandomShape::default() }, seed).expect("a valid kind");
    let motion = PalmMotion::random(seed, 60.0, 1.0).and_then(|motion| motion.sample(100.0)).expect("possible");
    let motion: Vec<_> = motion.into_iter().take(samples * every).step_by(every).collect();
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let run =
        simulate(&shape, &motion, &SimulateOptions { touchpad, seed, ..SimulateOptions::default() }).expect("possible");
    let measurements = Measurements::new(&run.log, None);
    let mut coefficients = shape.coefficients();
    coefficients_to_order(&mut coefficients, 4);
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let noise = Noise { sensor_m: 1e-4, balance_m: 1e-4 };
    let start = Estimate { coefficients, psi, cost: f64::INFINITY };
    let prior = Prior::new(SIZE_M, 0.2 * SIZE_M);
    let fitted = fit(&measurements, 4, start, noise, prior, free(), ROUNDS).expect("an optimum");
    (fitted.weighted, fitted.fit)
}

/// Mean square by which samples turn against each other from one motion to another.
pub(super) fn turned(from: &Estimate, to: &Estimate) -> f64 {
    let apart: Vec<f64> = from.psi.iter().zip(&to.psi).map(|(from, to)| to - from).collect();
    let mean = apart.iter().sum::<f64>() / apart.len() as f64;
    apart.iter().map(|apart| (apart - mean).powi(2)).sum::<f64>() / apart.len() as f64
}

fn flat_sided() -> SupportFunction {
    let unit = rounded_polygon(3, 0.3, 0.22).expect("in range");
    let scaled = unit.harmonics_m().iter().map(|[a, b]| [a * SIZE_M, b * SIZE_M]).collect();
    SupportFunction::new(SIZE_M, scaled).translated(0.1 * SIZE_M, 0.0)
}

#[test]
fn the_evidence_chooses_the_harmonics_of_the_object_and_more_for_flat_sides() {
    let noise = Noise { sensor_m: NOISE_M, balance_m: NOISE_M };
    let (measurements, start) = setting(&pebble(), 400, NOISE_M);
    let smooth = choose_order(&measurements, start, noise, PRIOR, free(), 1.0).expect("solvable").fit.order;
    // Six, and one step more.
    assert!((6..=8).contains(&smooth), "{smooth}");
    let (measurements, start) = setting(&flat_sided(), 400, NOISE_M);
    let flat = choose_order(&measurements, start, noise, PRIOR, free(), 1.0).expect("solvable").fit.order;
    assert!(flat >= 12, "{flat}");
}

#[test]
fn the_scale_of_the_prior_is_that_of_coefficients_as_large_as_it_has_them() {
    for form_order in [1, 3] {
        let prior = Prior { form_order, ..PRIOR };
        let coefficients = prior.standard_deviations(12);
        let wide = |scale: f64| Prior { scale_m: scale * prior.scale_m, ..prior };
        // In one step, from whatever scale.
        for from in [0.25, 1.0, 3.0] {
            let found = updated_scale(&coefficients, &[0.0; 25], wide(from));
            assert!((found / prior.scale_m - 1.0).abs() < 1e-12, "{form_order} {from}: {found}");
        }
    }
}

#[test]
fn readings_that_are_repeated_ask_for_no_more_harmonics() {
    let noise = Noise { sensor_m: NOISE_M, balance_m: NOISE_M };
    let (once, Estimate { coefficients, psi, cost }) = setting(&pebble(), 100, NOISE_M);
    // Palms that go in stairs, and readings that are rounded: each error is there twenty times.
    let stairs = once.of(once.instants.iter().flat_map(|instant| [*instant; 20]).collect());
    let start =
        || Estimate { coefficients: coefficients.clone(), psi: psi.iter().flat_map(|psi| [*psi; 20]).collect(), cost };
    let order = |samples_per_error: f64| {
        choose_order(&stairs, start(), noise, PRIOR, free(), samples_per_error).expect("solvable").fit.order
    };
    let (known, unknown) = (order(20.0), order(1.0));
    assert!((6..=8).contains(&known) && unknown > 8, "{known} {unknown}");
}

#[test]
fn the_noise_of_the_sensors_is_estimated_to_a_tenth() {
    for noise_m in [2e-5, 1e-4, 4e-4] {
        let (measurements, start) = setting(&pebble(), 500, noise_m);
        // From a guess that is wrong by a factor of three.
        let noise = Noise { sensor_m: 3.0 * noise_m, balance_m: noise_m };
        let fit = fit(&measurements, 6, start, noise, PRIOR, free(), 8).expect("solvable").fit;
        assert!((fit.noise.sensor_m / noise_m - 1.0).abs() < 0.1, "{} for {noise_m}", fit.noise.sensor_m);
        // The simulated balance is exact; its estimate has a floor.
        assert!(fit.noise.balance_m < 0.2 * noise_m, "{} for {noise_m}", fit.noise.balance_m);
    }
}

#[test]
fn stated_noise_is_not_estimated() {
    let (measurements, start) = setting(&pebble(), 200, NOISE_M);
    let stated = Noise { sensor_m: 3e-4, balance_m: 3e-4 };
    let variance_components = VarianceComponents { sensor: false, ..free() };
    let fit = fit(&measurements, 6, start, stated, PRIOR, variance_components, ROUNDS).expect("solvable").fit;
    assert_eq!(fit.noise.sensor_m, 3e-4);
}

#[test]
fn the_motion_prior_counts_jumps_and_unstable_poses() {
    let (measurements, start) = setting(&pebble(), 200, NOISE_M);
    // A fast slide may look like a jump.
    let before = neg_log_prior(&measurements, &start, NOISE_M, TAU);
    assert!(before <= PREDICTED_JUMP.0, "{before}");
    let mut jumping = start.clone();
    jumping.psi[50] += 0.5;
    assert_eq!(neg_log_prior(&measurements, &jumping, NOISE_M, TAU) - before, 2.0 * PREDICTED_JUMP.0, "there and back");
    // With the centre of mass mirrored in the centre of the shape, the same poses are highest where they were lowest.
    let mut turned = start;
    turned.coefficients.iter_mut().skip(1).for_each(|a| *a = -*a);
    let unstable = neg_log_prior(&measurements, &turned, NOISE_M, TAU) / UNSTABLE_POSE.0;
    assert!(unstable > 150.0, "{unstable}");
}

#[test]
fn samples_out_of_balance_lose_their_weight_in_it() {
    let (measurements, start) = setting(&pebble(), 200, NOISE_M);
    let mut fitted = start.clone();
    fitted.psi[50] += 0.5;
    let measurements = with_balance_weights(measurements, &fitted, NOISE_M);
    assert!(measurements.instants[50].balance_weight < 0.1, "{}", measurements.instants[50].balance_weight);
    assert!(measurements.instants[20].balance_weight > 1.0, "{}", measurements.instants[20].balance_weight);
}

#[test]
fn orientations_do_not_take_up_noise_where_balance_is_exact() {
    // Two seconds over boundary that is felt once: a tenth of the noise of the sensors leaves each orientation enough to follow it (Neyman and Scott).
    let kind = RandomShape { mean_radius_m: SIZE_M, ..RandomShape::default() };
    let shape = random_shape(&kind, 5_974_043).expect("a valid kind");
    let motion = PalmMotion::random(5_974_043, 60.0, 1.0).and_then(|motion| motion.sample(100.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let options = SimulateOptions { touchpad, seed: 5_974_043, ..SimulateOptions::default() };
    let run = simulate(&shape, &motion[..200], &options).expect("possible");
    let measurements = Measurements::new(&run.log, None);
    let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let turn = |psi: &[f64]| psi[psi.len() - 1] - psi[0];
    let optimum = |balance_m: f64| {
        let noise = Noise { sensor_m: 1e-4, balance_m };
        let smoother = Smoother::new(&measurements, 4, noise, Prior::new(SIZE_M, 3e-3)).strictly_convex();
        let mut coefficients = shape.coefficients();
        coefficients_to_order(&mut coefficients, 4);
        let estimate = smoother.run(coefficients, psi.clone(), StoppingCriteria { iterations: 200, tolerance: 1e-8 });
        let (evidence, _) = evidence_at(&smoother, &estimate).expect("determined");
        ((turn(&estimate.psi) - turn(&psi)).abs(), evidence.log())
    };
    let (loose, tight) = (optimum(1e-5), optimum(LEAST_BALANCE_SHARE * 1e-4));
    assert!(tight.0 < 0.6 * loose.0 && tight.1 > loose.1 + 10.0, "{tight:?} {loose:?}");
}

#[test]
fn that_the_object_is_convex_is_no_measurement() {
    // A triangle whose sides bend inwards, between nodes of which there may be more or fewer.
    let (measurements, Estimate { mut coefficients, psi, .. }) = setting(&pebble(), 100, NOISE_M);
    coefficients[1..].fill(0.0);
    coefficients[3] = 0.13 * SIZE_M;
    let noise = Noise { sensor_m: NOISE_M, balance_m: NOISE_M };
    let at_nodes = |strictly: bool| {
        let smoother = Smoother::new(&measurements, 8, noise, PRIOR);
        let smoother = if strictly { smoother.strictly_convex() } else { smoother };
        let stopping = StoppingCriteria { iterations: 0, tolerance: 0.0 };
        let estimate = smoother.run(coefficients.clone(), psi.clone(), stopping);
        let pressed = smoother.convexity.violations(&coefficients).count();
        let (evidence, _) = evidence_at(&smoother, &estimate).expect("determined");
        (pressed, evidence.log() + 0.5 * smoother.shape_cost(&coefficients))
    };
    let [(few, loosely), (many, strictly)] = [false, true].map(at_nodes);
    assert!(few > 0 && many > few, "{few} {many}");
    // They cost what they miss, and nothing for their number.
    assert!((loosely - strictly).abs() < 1e-9 * loosely.abs(), "{loosely} {strictly}");
}
