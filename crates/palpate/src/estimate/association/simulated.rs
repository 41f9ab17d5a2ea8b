//! What tests of the data association start from: simulated logs, and the optimum near the truth.

use crate::estimate::association::transitions::near;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::palms::PalmMotion;
use crate::plan::{PalmLimits, plan_turn};
use crate::sensor::Touchpad;
use crate::shape::{NamedShape, SupportFunction, rounded_polygon};
use crate::simulate::{SimulateOptions, simulate};
use std::f64::consts::TAU;

const SIZE_M: f64 = 0.03;
const NOISE: Noise = Noise { sensor_m: 1e-4, balance_m: 2e-5 };

/// A pebble turned around over some 200 samples with a little noise, and the optimum near the truth.
pub(super) fn turned_pebble() -> (Measurements, Fit) {
    let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a valid size");
    let plan = plan_turn(&pebble, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let options = SimulateOptions {
        start_psi_rad: plan.start_psi_rad,
        touchpad: Touchpad { noise_sd_m: NOISE.sensor_m, ..Touchpad::ideal() },
        ..SimulateOptions::default()
    };
    let run = simulate(&pebble, &plan.motion.sample(5.0).expect("possible"), &options).expect("possible");
    let measurements = Measurements::new(&run.log, None);
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let fit = fitted(&measurements, pebble.coefficients(), psi);
    (measurements, fit)
}

/// A rounded triangle in a random motion: its measurements, the optimum near the truth, and the first samples after its jumps.
pub(super) fn thrown_triangle(seed: u64) -> Option<(Measurements, Fit, Vec<usize>)> {
    thrown(&rounded_polygon(3, 0.4, 0.4).expect("possible").scaled(SIZE_M), seed)
}

/// The same of a square, whose sides are nearly flat.
pub(super) fn thrown_square(seed: u64) -> Option<(Measurements, Fit, Vec<usize>)> {
    thrown(&rounded_polygon(4, 0.15, 0.15).expect("possible").translated(0.1, 0.05).scaled(SIZE_M), seed)
}

/// The same of a rounded pentagon whose centre of mass is not in its middle, with the prior of a form that comes to itself.
pub(super) fn thrown_pentagon(seed: u64) -> Option<(Measurements, Fit, Vec<usize>)> {
    let form = rounded_polygon(5, 0.3, 0.3).expect("possible").scaled(SIZE_M);
    let (measurements, mut fit, starts) = thrown(&form.translated(0.1 * SIZE_M, 0.05 * SIZE_M), seed)?;
    fit.prior.form_order = 5;
    Some((measurements, fit, starts))
}

fn thrown(shape: &SupportFunction, seed: u64) -> Option<(Measurements, Fit, Vec<usize>)> {
    let motion = PalmMotion::random(seed, 20.0, 1.0).and_then(|motion| motion.sample(20.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: NOISE.sensor_m, ..Touchpad::ideal() };
    let run = simulate(shape, &motion, &SimulateOptions { touchpad, seed, ..SimulateOptions::default() }).ok()?;
    let measurements = Measurements::new(&run.log, None);
    let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let starts: Vec<usize> = (1..psi.len()).filter(|&sample| !near(psi[sample - 1], psi[sample], TAU)).collect();
    let fit = fitted(&measurements, shape.coefficients(), psi);
    Some((measurements, fit, starts))
}

/// The optimum near a shape and a motion.
pub(super) fn fitted(measurements: &Measurements, coefficients: Vec<f64>, psi: Vec<f64>) -> Fit {
    let (order, prior) = (coefficients.len() / 2, Prior::new(SIZE_M, 0.5 * SIZE_M));
    let stopping = StoppingCriteria { iterations: 30, tolerance: 1e-7 };
    let estimate: Estimate = Smoother::new(measurements, order, NOISE, prior).run(coefficients, psi, stopping);
    Fit { estimate, order, noise: NOISE, prior, evidence: Evidence::NONE }
}
