//! What tests of the data association start from: a pebble turned around, and the optimum near the truth.

use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Fit, Smoother, StoppingCriteria};
use crate::plan::{PalmLimits, plan_turn};
use crate::sensor::Touchpad;
use crate::shape::NamedShape;
use crate::simulate::{SimulateOptions, simulate};

const SIZE_M: f64 = 0.03;

/// A pebble turned around over some 200 samples with a little noise, and the optimum near the truth.
pub(super) fn turned_pebble() -> (Measurements, Fit) {
    let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a valid size");
    let plan = plan_turn(&pebble, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let options = SimulateOptions {
        start_psi_rad: plan.start_psi_rad,
        touchpad: Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() },
        ..SimulateOptions::default()
    };
    let run = simulate(&pebble, &plan.motion.sample(5.0).expect("possible"), &options).expect("possible");
    let measurements = Measurements::new(&run.log, None);
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let (noise, prior) = (Noise { sensor_m: 1e-4, balance_m: 2e-5 }, Prior::new(SIZE_M, 0.5 * SIZE_M));
    let order = pebble.harmonics_m().len();
    let stopping = StoppingCriteria { iterations: 20, tolerance: 1e-7 };
    let estimate = Smoother::new(&measurements, order, noise, prior).run(pebble.coefficients(), psi, stopping);
    (measurements, Fit { estimate, order, noise, prior, log_evidence: 0.0 })
}
