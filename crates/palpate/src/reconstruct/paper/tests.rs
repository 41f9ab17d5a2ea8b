//! The integrating methods against exact simulations: their orders, their agreement, their accuracy, jumps.

use super::piece::Piece;
use crate::compare::compare;
use crate::estimate::closed_form::Contact;
use crate::estimate::measurements::Measurements;
use crate::palms::{Palm, PalmMotion, PalmMove, PalmPair};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::options::method::Method;
use crate::reconstruct::reconstructor::Reconstructor;
use crate::reconstruct::result::reconstruction::Reconstruction;
use crate::reconstruct::start::Start;
use crate::sensor::Touchpad;
use crate::shape::{NamedShape, SupportFunction};
use crate::simulate::{SimulateOptions, Simulation, simulate};

const SIZE_M: f64 = 0.03;

fn shape() -> SupportFunction {
    NamedShape::Pebble.shape(SIZE_M).expect("a positive size")
}

/// A smooth motion without a jump, the force lines away from the centre of mass, at `steps` even steps.
fn run(steps: usize) -> Simulation {
    let palms: Vec<(f64, PalmPair)> = (0..=steps)
        .map(|index| {
            let time_s = 10.0 * index as f64 / steps as f64;
            (time_s, PalmPair::hinged(1.05 + 0.15 * (0.3 * time_s).cos(), 1.3 - 0.1 * (0.25 * time_s).cos()))
        })
        .collect();
    let options = SimulateOptions { start_psi_rad: 4.0, ..SimulateOptions::default() };
    let run = simulate(&shape(), &palms, &options).expect("possible");
    assert!(run.jumps.is_empty());
    run
}

/// The contacts by a method from the true initial values.
fn integrated(run: &Simulation, method: Method) -> Vec<Contact> {
    let measurements = Measurements::new(&run.log, None);
    let piece = Piece::new(&run.log, &measurements, 0..measurements.len(), method, 1e-9).expect("long enough");
    let (theta1, theta2) = run.log.samples[0].palms.contact_angles(run.truth.motion[0].psi_rad);
    piece.integrate((shape().at(theta1).r, shape().at(theta2).r)).expect("finite")
}

/// The largest errors of ψ (radians) and of r₁, r₂ (metres) over the run.
fn worst(run: &Simulation, contacts: &[Contact]) -> [f64; 2] {
    let first = run.truth.motion[0].psi_rad;
    let errors = run.log.samples.iter().zip(&run.truth.motion).zip(contacts).map(|((sample, pose), contact)| {
        let (theta1, theta2) = sample.palms.contact_angles(pose.psi_rad);
        let r = f64::max((contact.r1 - shape().at(theta1).r).abs(), (contact.r2 - shape().at(theta2).r).abs());
        [(contact.psi - (pose.psi_rad - first)).abs(), r]
    });
    errors.fold([0.0; 2], |most, error| [f64::max(most[0], error[0]), f64::max(most[1], error[1])])
}

#[test]
fn each_method_converges_to_the_truth_at_its_order() {
    let runs = [200, 400, 800].map(run);
    let true_psi: Vec<f64> = runs[0].truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let turned = true_psi.iter().fold(0.0, |most, psi| f64::max(most, (psi - true_psi[0]).abs()));
    assert!(turned > 0.5, "the object must turn enough: {turned}");
    for (method, order) in [(Method::Ode, 4.0), (Method::Quadrature, 2.0)] {
        let errors = [0, 1, 2].map(|index| worst(&runs[index], &integrated(&runs[index], method)));
        for pair in errors.windows(2) {
            for (coarse, fine) in pair[0].iter().zip(pair[1]) {
                let found = (coarse / fine).log2();
                assert!((found - order).abs() < 0.2, "{method}: {found} from {errors:?}");
            }
        }
    }
    // And so to each other.
    let apart = |run: &Simulation| {
        let (one, two) = (integrated(run, Method::Ode), integrated(run, Method::Quadrature));
        one.iter().zip(two).map(|(a, b)| (a.psi - b.psi).abs()).fold(0.0, f64::max)
    };
    let apart = [apart(&runs[0]), apart(&runs[2])];
    assert!(apart[1] < apart[0] / 10.0 && apart[1] < 1e-4, "{apart:?}");
}

/// Palms that squeeze and rotate, nearly flat at first, and carry the object most of the way round, as in figure 6 of the paper;
/// over places where the force lines meet in the centre of mass.
fn most_of_a_turn(samples: usize) -> Simulation {
    let squeeze = |open: f64, rotate: f64| PalmMove::OpenAndRotate {
        open_rad: open.to_radians(),
        rotate_rad: rotate.to_radians(),
        duration_s: (0.5 * open.abs() + rotate.abs()) / 40.0,
    };
    let open = |angle: f64| PalmMove::OpenOne {
        palm: Palm::Two,
        angle_rad: angle.to_radians(),
        duration_s: angle.abs() / 40.0,
    };
    let moves = [
        squeeze(-70.0, 20.0),
        squeeze(-10.0, -30.0),
        squeeze(-15.0, -35.0),
        open(75.0),
        squeeze(-50.0, -25.0),
        open(60.0),
        squeeze(-80.0, 0.0),
        squeeze(-20.0, -15.0),
    ];
    let start = PalmPair::hinged(14f64.to_radians(), 152f64.to_radians());
    let motion = PalmMotion::schedule(start, &moves).expect("possible");
    let step_s = motion.duration_s() / (samples - 1) as f64;
    let palms: Vec<(f64, PalmPair)> =
        (0..samples).map(|index| step_s * index as f64).map(|time_s| (time_s, motion.at(time_s))).collect();
    let options = SimulateOptions { start_psi_rad: 5.262_694, ..SimulateOptions::default() };
    let run = simulate(&shape(), &palms, &options).expect("possible");
    assert!(run.jumps.is_empty());
    run
}

fn reconstructor(method: Method) -> Reconstructor<'static> {
    Reconstructor::new().method(method)
}

/// From the true shape and motion.
fn from_truth(run: &Simulation, method: Method) -> Reconstruction {
    let psi_rad = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    reconstructor(method).start(Start::Motion { shape: shape(), psi_rad }).run(&run.log).expect("solvable")
}

#[test]
fn from_true_initial_values_270_exact_samples_give_the_radius_to_a_thousandth() {
    for run in [run(269), most_of_a_turn(270)] {
        for method in [Method::Ode, Method::Quadrature] {
            let found = from_truth(&run, method);
            let errors = compare(&found, &run.truth).expect("comparable");
            let limit = if method == Method::Ode { 1e-3 } else { 2e-3 };
            assert!(errors.rms_r_m < limit * SIZE_M, "{method}: {errors:?}");
            assert!(!found.is_certified() && found.verdict.doubts[0].next_step().contains("likelihood"));
        }
    }
}

#[test]
fn initial_conditions_are_found_and_pieces_between_jumps_are_arranged() {
    let mut jumps = 0;
    for seed in [8, 10] {
        let motion = PalmMotion::random(seed, 20.0, 0.8).and_then(|motion| motion.sample(40.0)).expect("possible");
        let run = simulate(&shape(), &motion, &SimulateOptions::default()).expect("possible");
        jumps += run.jumps.len();
        for method in [Method::Ode, Method::Quadrature] {
            let found = reconstructor(method).run(&run.log).expect("solvable");
            let errors = compare(&found, &run.truth).expect("comparable");
            assert!(errors.rms_r_m < 3e-3 * SIZE_M, "seed {seed}, {method}: {errors:?}");
            assert!(errors.rms_psi_rad < 0.02, "seed {seed}, {method}: {errors:?}");
            assert!(found.jumps.len() >= run.jumps.len(), "{:?}", found.jumps);
        }
    }
    assert!(jumps > 2, "{jumps}");
}

#[test]
fn two_fingers_integrate_as_well_as_two_palms() {
    let motion = PalmMotion::through(&[(0.0, 1.2, 1.2), (8.0, 0.9, 1.4), (16.0, 1.2, 1.0)])
        .map(|motion| motion.with_bases([0.006, 0.0], [-0.006, 0.002]))
        .and_then(|motion| motion.sample(40.0))
        .expect("possible");
    let options_of_run = SimulateOptions { start_psi_rad: 4.0, ..SimulateOptions::default() };
    let run = simulate(&shape(), &motion, &options_of_run).expect("possible");
    assert!(run.jumps.is_empty());
    for method in [Method::Ode, Method::Quadrature] {
        let found = from_truth(&run, method);
        let errors = compare(&found, &run.truth).expect("comparable");
        assert!(errors.rms_r_m < 1e-3 * SIZE_M && errors.rms_com_m < 1e-3 * SIZE_M, "{method}: {errors:?}");
    }
}

#[test]
fn noisy_logs_are_reconstructed_and_a_log_without_a_piece_is_refused() {
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let motion = PalmMotion::random(8, 20.0, 0.8).and_then(|motion| motion.sample(40.0)).expect("possible");
    let mut run =
        simulate(&shape(), &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible");
    for method in [Method::Ode, Method::Quadrature] {
        let found = reconstructor(method).run(&run.log).expect("solvable");
        let errors = compare(&found, &run.truth).expect("comparable");
        assert!(errors.rms_r_m < 0.05 * SIZE_M, "{method}: {errors:?}");
    }
    // The same time everywhere: nothing to integrate over.
    run.log.samples.iter_mut().for_each(|sample| sample.time_s = 0.0);
    for method in [Method::Ode, Method::Quadrature] {
        let refused = reconstructor(method).run(&run.log);
        assert_eq!(refused, Err(ReconstructError::NotSolvable));
    }
}

/// Squeezes and rotations of an object without noise, `palpate simulate --motion zigzag --noise-mm 0`.
fn zigzag(shape: NamedShape, rate_hz: f64) -> (SupportFunction, Simulation) {
    let shape = shape.shape(SIZE_M).expect("a positive size");
    let palms = PalmMotion::squeeze_and_rotate(100.0, 2).and_then(|motion| motion.sample(rate_hz)).expect("possible");
    let run = simulate(&shape, &palms, &SimulateOptions::default()).expect("possible");
    assert!(run.jumps.is_empty());
    (shape, run)
}

#[test]
fn an_object_whose_normals_meet_near_its_centre_of_mass_is_found_and_integrated() {
    // The denominator of ψ' is below a fiftieth of the size for most of the log, and crosses zero two dozen times.
    let (shape, run) = zigzag(NamedShape::Egg, 100.0);
    let psi_rad: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    for method in [Method::Ode, Method::Quadrature] {
        let start = Start::Motion { shape: shape.clone(), psi_rad: psi_rad.clone() };
        for reconstructor in [reconstructor(method).start(start), reconstructor(method)] {
            let errors = compare(&reconstructor.run(&run.log).expect("solvable"), &run.truth).expect("comparable");
            assert!(errors.rms_r_m < 1e-5 * SIZE_M && errors.rms_psi_rad < 1e-3, "{method}: {errors:?}");
        }
    }
}

#[test]
fn the_true_height_is_among_those_of_the_crossings() {
    let (_, run) = zigzag(NamedShape::Egg, 100.0);
    let measurements = Measurements::new(&run.log, None);
    let piece = Piece::new(&run.log, &measurements, 0..measurements.len(), Method::Quadrature, 1e-9).expect("long");
    let off = |height: &&f64| (*height - run.truth.motion[0].com_y_m).abs() < 1e-4 * SIZE_M;
    let found = piece.crossing_heights.iter().filter(off).count();
    assert!(found >= 8, "{found} of {}", piece.crossing_heights.len());
}

#[test]
fn a_fast_roll_at_few_samples_is_no_jump() {
    let (_, run) = zigzag(NamedShape::Pebble, 20.0);
    for method in [Method::Ode, Method::Quadrature] {
        let found = reconstructor(method).run(&run.log).expect("solvable");
        let errors = compare(&found, &run.truth).expect("comparable");
        assert!(found.jumps.is_empty(), "{method}: {:?}", found.jumps);
        assert!(errors.rms_r_m < 3e-3 * SIZE_M && errors.rms_psi_rad < 0.02, "{method}: {errors:?}");
    }
}
