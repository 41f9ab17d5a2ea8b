//! What goes through JSON comes back the same, though JSON has neither NaN nor infinity.

use palpate::palms::{PalmMotion, PalmPair};
use palpate::reconstruct::{Method, ReconstructOptions, Reconstructor};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate::{Log, Reconstruction, Truth};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn through_json<T: Serialize + DeserializeOwned>(thing: &T) -> T {
    serde_json::from_str(&serde_json::to_string(thing).expect("it is written")).expect("it is read")
}

#[test]
fn logs_truths_shapes_and_results_come_back_the_same() {
    let shape = NamedShape::Stone.shape(0.03).expect("a stone");
    assert_eq!(through_json(&shape), shape);
    let motion: Vec<(f64, PalmPair)> =
        PalmMotion::random(2, 20.0, 1.0).and_then(|motion| motion.sample(10.0)).expect("a motion");
    let felt = simulate(&shape, &motion, &SimulateOptions::default()).expect("a simulation");
    assert_eq!(through_json::<Log>(&felt.log), felt.log);
    assert_eq!(through_json::<Truth>(&felt.truth), felt.truth);
    assert!(!felt.jumps.is_empty());
    assert_eq!(through_json(&felt.jumps), felt.jumps);

    // A method without error bars, so that there is NaN.
    let options = ReconstructOptions::default().with_method(Method::Ode);
    assert_eq!(through_json(&options), options);
    let found = Reconstructor::from(options).run(&felt.log).expect("a result");
    let mut back: Reconstruction = through_json(&found);
    assert!(back.motion.iter().all(|pose| pose.psi_sd_rad.is_nan() && pose.com_sd_m.is_nan()));
    assert!(back.outline.iter().all(|point| point.r_sd_m.is_nan()));
    let mut found = found;
    for result in [&mut back, &mut found] {
        result.motion.iter_mut().for_each(|pose| (pose.psi_sd_rad, pose.com_sd_m) = (0.0, 0.0));
        result.outline.iter_mut().for_each(|point| point.r_sd_m = 0.0);
    }
    assert_eq!(back, found);
}

#[test]
fn names_and_defaults_are_as_promised() {
    assert_eq!(serde_json::to_string(&Method::Likelihood).expect("it is written"), "\"likelihood\"");
    let options: ReconstructOptions = serde_json::from_str("{\"harmonics\": 8}").expect("it is read");
    assert_eq!(options, ReconstructOptions::default().with_harmonics(8));
    let pad = Touchpad::ideal();
    assert!(pad.length_m.is_infinite());
    assert_eq!(through_json(&pad), pad);
    let pad = Touchpad { length_m: 0.1, ..Touchpad::interlink() };
    assert_eq!(through_json(&pad), pad);
}
