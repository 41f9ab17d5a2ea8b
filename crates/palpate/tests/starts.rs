//! Reconstruction from what is known beforehand, and the options of a reconstructor.

mod reconstruct_support;

use std::sync::Mutex;

use palpate::compare::compare;
use palpate::palms::{PalmMotion, PalmPair};
use palpate::reconstruct::{Method, ReconstructError, ReconstructOptions, Reconstructor, Start};
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use reconstruct_support::{SIZE_M, noisy, turned};

fn stone() -> SupportFunction {
    NamedShape::Stone.shape(SIZE_M).expect("a positive size")
}

/// Through jumps.
fn run_with_jumps() -> Simulation {
    let motion = PalmMotion::random(4, 12.0, 1.0).and_then(|motion| motion.sample(30.0)).expect("possible");
    let options = SimulateOptions { touchpad: noisy(1e-4), ..SimulateOptions::default() };
    let run = simulate(&stone(), &motion, &options).expect("possible");
    assert!(!run.jumps.is_empty());
    run
}

#[test]
fn a_known_object_is_placed_through_jumps_and_refined() {
    let run = run_with_jumps();
    // Known to five percent, and with another front.
    for (scale, turn) in [(1.03, 2.0), (1.0, 0.0), (0.95, 1.0), (1.05, 3.0)] {
        let known = stone().scaled(scale).rotated(turn);
        let found = Reconstructor::new().start(Start::Shape(known)).run(&run.log).expect("solvable");
        assert!(found.is_certified(), "{scale} {turn}: {}", found.verdict);
        let error = compare(&found, &run.truth).expect("of the same log");
        assert!(error.rms_r_m < 5e-5, "{scale} {turn}: {error:?}");
        assert!(error.rms_psi_rad < 0.01, "{scale} {turn}: {error:?}");
    }
}

#[test]
fn a_known_motion_leads_to_the_answer_that_the_search_finds() {
    let run = turned(&stone(), 300, noisy(1e-4));
    let psi_rad = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let start = Start::Motion { shape: stone(), psi_rad };
    let given = Reconstructor::new().start(start).run(&run.log).expect("solvable");
    let searched = palpate::reconstruct(&run.log).expect("solvable");
    assert!((given.shape.perimeter_m() - searched.shape.perimeter_m()).abs() < 1e-5);
    assert!(given.is_certified() && searched.is_certified());
}

#[test]
fn the_methods_that_integrate_start_from_a_shape_as_well() {
    let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a positive size");
    let at = |t: f64| (t, PalmPair::hinged(1.05 + 0.15 * (0.3 * t).cos(), 1.3 - 0.1 * (0.25 * t).cos()));
    let motion: Vec<(f64, PalmPair)> = (0..270).map(|index| at(f64::from(index) / 27.0)).collect();
    let options = SimulateOptions { start_psi_rad: 4.0, ..SimulateOptions::default() };
    let run = simulate(&pebble, &motion, &options).expect("possible");
    let reconstructor = Reconstructor::new().method(Method::Ode).start(Start::Shape(pebble));
    let found = reconstructor.run(&run.log).expect("solvable");
    let error = compare(&found, &run.truth).expect("of the same log");
    assert!(error.rms_r_m < 0.01 * SIZE_M, "{error:?}");
    assert!(found.outline[0].r_sd_m.is_nan() && !found.is_certified());
}

#[test]
fn a_start_that_does_not_go_with_the_log_is_refused_by_both_numbers() {
    let run = turned(&stone(), 40, noisy(0.0));
    let with = |shape: SupportFunction, count: usize, psi: f64| {
        Reconstructor::new().start(Start::Motion { shape, psi_rad: vec![psi; count] }).run(&run.log)
    };
    let refused = with(stone(), 39, 0.0).expect_err("one too few");
    assert_eq!(refused, ReconstructError::StartOfOtherLength { orientations: 39, samples: 40 });
    assert!(refused.to_string().contains("39") && refused.to_string().contains("40"), "{refused}");
    assert!(matches!(with(stone(), 40, f64::NAN), Err(ReconstructError::BadOption(_))));
    let nothing = SupportFunction::new(f64::NAN, Vec::new());
    assert!(matches!(with(nothing.clone(), 40, 0.0), Err(ReconstructError::BadOption(_))));
    assert!(matches!(
        Reconstructor::new().start(Start::Shape(nothing)).run(&run.log),
        Err(ReconstructError::BadOption(_))
    ));
}

#[test]
fn options_held_as_data_do_what_the_builder_does_and_progress_goes_up_to_the_end() {
    let egg = NamedShape::Egg.shape(SIZE_M).expect("a positive size");
    let run = turned(&egg, 100, noisy(1e-4));
    let options = ReconstructOptions::default().with_harmonics(6).with_sensor_sd_m(Some(1e-4));
    let of_data = Reconstructor::from(options).run(&run.log).expect("solvable");
    let told = Mutex::new(Vec::new());
    let listen = |progress: palpate::reconstruct::Progress| told.lock().expect("no panic").push(progress.fraction);
    let built = Reconstructor::new().harmonics(6).sensor_sd_m(1e-4).progress(&listen);
    assert_eq!(built.run(&run.log).expect("solvable"), of_data);
    let told = told.into_inner().expect("no panic");
    assert!(told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
    let refused = Reconstructor::new().harmonics(1).run(&run.log);
    assert!(matches!(refused, Err(ReconstructError::BadOption(_))));
}
