//! Logs of rigs that nobody calibrated: the constants come out with the shape, and error bars hold.

use palpate::compare::compare;
use palpate::palms::PalmMotion;
use palpate::reconstruct::{Doubt, ReconstructError, Reconstructor, Start};
use palpate::sensor::{Calibration, Rig, Tolerances, Touchpad};
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, Simulation, simulate};

/// What a pebble or a stone gives to a rig without errors.
fn felt(shape: NamedShape, seed: u64) -> Simulation {
    let shape = shape.shape(0.03).expect("a valid size");
    let motion = PalmMotion::random(seed, 40.0, 1.0).and_then(|motion| motion.sample(20.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
    simulate(&shape, &motion, &SimulateOptions { touchpad, seed, ..SimulateOptions::default() }).expect("possible")
}

/// About one standard deviation of the default tolerances off in everything; what both pads have in common is right.
fn off() -> Calibration {
    let mut calibration = Calibration::default();
    calibration.zero_m = [5e-4, -4e-4];
    calibration.scale = [1.004, 0.996];
    calibration.angle_zero_rad = [-6e-3, 8e-3];
    calibration.surface_m = [2e-4, -2e-4];
    calibration
}

fn truth(calibration: &Calibration) -> [f64; 7] {
    let Calibration { zero_m, scale, angle_zero_rad, surface_m, .. } = *calibration;
    let (ratio, difference) = (scale[0] - scale[1], surface_m[0] - surface_m[1]);
    [zero_m[0], zero_m[1], ratio, angle_zero_rad[0], angle_zero_rad[1], difference, 0.0]
}

#[test]
fn a_rig_is_calibrated_by_what_it_holds() {
    for (shape, seed) in [(NamedShape::Egg, 50), (NamedShape::Pebble, 51)] {
        let run = felt(shape, seed);
        let log = off().distorted(&run.log);
        let found = Reconstructor::new().rig(Rig::uncalibrated()).run(&log).expect("solvable");
        assert!(found.is_com_certified(), "{}", found.verdict);
        let errors = compare(&found, &run.truth).expect("comparable");
        let bar_m = found.outline.iter().map(|point| point.r_sd_m).fold(0.0, f64::max);
        assert!(errors.rms_r_m < 3.0 * bar_m && bar_m < 5e-5, "{} {bar_m}", errors.rms_r_m);
        let of_rig = found.calibration.expect("constants were open");
        for (constant, truth) in of_rig.constants.iter().zip(truth(&off())) {
            assert!((constant.value - truth).abs() <= 4.0 * constant.sd, "{constant:?} {truth}");
            assert!(constant.prior_sd == 0.0 || constant.sd < 0.2 * constant.prior_sd, "{constant:?}");
        }
        assert!((of_rig.size_sd - 0.00707).abs() < 1e-5 && (of_rig.offset_sd_m - 3.54e-4).abs() < 1e-6);
        // Readings taken as they are give a wrong object, or none, whatever the start.
        let psi_rad = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let start = Start::Motion { shape: shape.shape(0.03).expect("a valid size"), psi_rad };
        let wrong = Reconstructor::new().start(start).run(&log).expect("solvable");
        let errors = compare(&wrong, &run.truth).expect("comparable");
        assert!(!wrong.is_certified() || errors.rms_r_m > 10.0 * bar_m);
        assert_eq!(wrong.calibration, None);
    }
}

#[test]
fn stated_constants_are_taken_out_of_the_readings() {
    let run = felt(NamedShape::Pebble, 51);
    let log = off().distorted(&run.log);
    let found = Reconstructor::new().rig(Rig::new(off(), Tolerances::NONE)).run(&log).expect("solvable");
    assert!(found.is_com_certified(), "{}", found.verdict);
    assert!(compare(&found, &run.truth).expect("comparable").rms_r_m < 1e-5);
}

#[test]
fn a_constant_far_from_its_statement_is_a_doubt() {
    let run = felt(NamedShape::Pebble, 51);
    let mut tolerances = Tolerances::default();
    tolerances.zero_sd_m = [1e-4; 2];
    let log = off().distorted(&run.log);
    let found = Reconstructor::new().rig(Rig::new(Calibration::default(), tolerances)).run(&log).expect("solvable");
    let doubts = &found.verdict.doubts;
    let is_zero = |doubt: &Doubt| matches!(doubt, Doubt::UnlikelyRig { constant, .. } if constant.ends_with("zero_m"));
    assert!(doubts.iter().any(is_zero), "{doubts:?}");
}

#[test]
fn impossible_rigs_are_refused() {
    let run = felt(NamedShape::Pebble, 51);
    let mut calibration = Calibration::default();
    calibration.scale = [0.0, 1.0];
    let mut tolerances = Tolerances::default();
    tolerances.angle_zero_sd_rad = [-1.0, 0.1];
    let mut parallel = Calibration::default();
    parallel.angle_zero_rad = [0.0, run.log.samples[0].palms.phi2_rad];
    for rig in [Rig::new(calibration, Tolerances::NONE), Rig::new(Calibration::default(), tolerances)] {
        let refused = Reconstructor::new().rig(rig).run(&run.log);
        assert!(matches!(refused, Err(ReconstructError::BadOption(_))), "{refused:?}");
    }
    let refused = Reconstructor::new().rig(Rig::new(parallel, Tolerances::NONE)).run(&run.log);
    assert!(matches!(refused, Err(ReconstructError::BadSample { sample: 1, .. })), "{refused:?}");
}
