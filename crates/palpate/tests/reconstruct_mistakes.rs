//! Mistakes in how a log is written are named: each on a log of one of several objects by an ordinary rig, and none on logs that have none.

use std::f64::consts::FRAC_PI_2;

use palpate::palms::{PalmMotion, PalmPair};
use palpate::plan::{PalmLimits, plan_turn};
use palpate::reconstruct::{Doubt, Mistake, Reconstructor};
use palpate::sensor::{Rig, Touchpad};
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate::{Log, Sample};

/// Samples per second: enough for 320 samples.
const RATE_HZ: f64 = 8.0;

/// Logs of an ordinary rig, 0.05 mm of noise on its pads.
fn logs() -> Vec<Log> {
    let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
    let log = |name: NamedShape, seed: u64, is_planned: bool| {
        let shape = name.shape(0.03).expect("a positive size");
        let (motion, start_psi_rad) = if is_planned {
            let planned = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("possible");
            (planned.motion, planned.start_psi_rad)
        } else {
            (PalmMotion::random(seed, 40.0, 1.0).expect("possible"), 0.0)
        };
        let options = SimulateOptions { touchpad, seed, start_psi_rad, ..SimulateOptions::default() };
        let samples = motion.sample(RATE_HZ).expect("possible");
        Rig::uncalibrated().drawn(seed).distorted(&simulate(&shape, &samples, &options).expect("possible").log)
    };
    vec![log(NamedShape::Pebble, 951, false), log(NamedShape::Egg, 952, true), log(NamedShape::Random(77), 954, true)]
}

fn with_angles(log: &Log, change: fn(f64, f64) -> (f64, f64)) -> Log {
    let changed = |sample: &Sample| {
        let (phi1_rad, phi2_rad) = change(sample.palms.phi1_rad, sample.palms.phi2_rad);
        Sample { palms: PalmPair { phi1_rad, phi2_rad, ..sample.palms }, ..*sample }
    };
    Log { samples: log.samples.iter().map(changed).collect() }
}

fn with_positions(log: &Log, change: fn(f64, f64) -> (f64, f64)) -> Log {
    let changed = |sample: &Sample| {
        let (s1, s2) = change(sample.s1_m.expect("a contact"), sample.s2_m.expect("a contact"));
        Sample { s1_m: Some(s1), s2_m: Some(s2), ..*sample }
    };
    Log { samples: log.samples.iter().map(changed).collect() }
}

fn named(log: &Log) -> Option<Mistake> {
    let found = Reconstructor::new().rig(Rig::uncalibrated()).run_or_name_mistake(log).expect("a result");
    match found.verdict.doubts.first() {
        Some(Doubt::Mistaken { mistake }) => {
            assert!(!found.is_certified());
            Some(*mistake)
        }
        _ => None,
    }
}

#[track_caller]
fn names(mistake: Mistake, number: usize, make: impl Fn(&Log) -> Log) {
    assert_eq!(named(&make(&logs()[number])), Some(mistake), "log {number}");
}

/// Whether two numbers, where both are there, differ by a zero of an ordinary rig at most.
fn near(found: Option<f64>, expected: Option<f64>) -> bool {
    match (found, expected) {
        (Some(found), Some(expected)) => (found - expected).abs() < 2.5e-3,
        (found, expected) => found == expected,
    }
}

#[test]
fn a_right_log_has_no_mistake() {
    for log in logs() {
        let found = Reconstructor::new().rig(Rig::uncalibrated()).run_or_name_mistake(&log).expect("a result");
        assert!(found.is_com_certified(), "{}", found.verdict);
    }
}

#[test]
fn swapped_pads() {
    names(Mistake::PadsSwapped, 0, |log| with_positions(log, |s1, s2| (s2, s1)));
}

#[test]
fn swapped_angles() {
    names(Mistake::AnglesSwapped, 1, |log| with_angles(log, |phi1, phi2| (phi2, phi1)));
}

#[test]
fn swapped_palms() {
    names(Mistake::PalmsSwapped, 2, |log| {
        with_positions(&with_angles(log, |phi1, phi2| (phi1 + phi2, -phi2)), |s1, s2| (s2, s1))
    });
}

#[test]
fn phi2_from_the_horizontal() {
    names(Mistake::Phi2FromHorizontal, 0, |log| with_angles(log, |phi1, phi2| (phi1, phi1 + phi2)));
}

#[test]
fn phi1_clockwise() {
    names(Mistake::Phi1Clockwise, 1, |log| with_angles(log, |phi1, phi2| (-phi1, phi2)));
}

#[test]
fn phi2_clockwise() {
    names(Mistake::Phi2Clockwise, 2, |log| with_angles(log, |phi1, phi2| (phi1, -phi2)));
}

#[test]
fn both_angles_clockwise() {
    names(Mistake::BothClockwise, 0, |log| with_angles(log, |phi1, phi2| (-phi1, -phi2)));
}

#[test]
fn phi1_from_the_vertical() {
    names(Mistake::Phi1FromVertical, 1, |log| with_angles(log, |phi1, phi2| (phi1 - FRAC_PI_2, phi2)));
}

#[test]
fn phi1_from_the_vertical_clockwise() {
    names(Mistake::Phi1FromVerticalClockwise, 2, |log| with_angles(log, |phi1, phi2| (FRAC_PI_2 - phi1, phi2)));
}

/// What becomes of both positions.
type Rewrite = fn(f64, f64) -> (f64, f64);

#[test]
fn pads_read_from_the_far_end() {
    let cases: [(Rewrite, [Option<f64>; 2]); 3] = [
        (|s1, s2| (0.12 - s1, 0.12 - s2), [Some(0.12), Some(0.12)]),
        (|s1, s2| (0.11 - s1, s2), [Some(0.11), None]),
        (|s1, s2| (s1, 0.13 - s2), [None, Some(0.13)]),
    ];
    for (log, (make, expected)) in logs().iter().zip(cases) {
        let found = named(&with_positions(log, make));
        let Some(Mistake::ReadFromTip { length1_m, length2_m }) = found else { panic!("{found:?}") };
        assert!(near(length1_m, expected[0]) && near(length2_m, expected[1]), "{found:?}");
    }
}

#[test]
fn zeros_of_the_pads_many_millimetres_off() {
    let cases: [(Rewrite, [Option<f64>; 2]); 2] = [
        (|s1, s2| (s1 - 0.012, s2 - 0.012), [Some(-0.012), Some(-0.012)]),
        (|s1, s2| (s1 + 0.012, s2), [Some(0.012), None]),
    ];
    for (log, (make, expected)) in logs().iter().zip(cases) {
        let found = named(&with_positions(log, make));
        let Some(Mistake::ZeroOff { zero1_m, zero2_m }) = found else { panic!("{found:?}") };
        assert!(near(zero1_m, expected[0]) && near(zero2_m, expected[1]), "{found:?}");
    }
}

#[test]
fn other_units() {
    names(Mistake::RadiansAsDegrees, 0, |log| with_angles(log, |phi1, phi2| (phi1.to_radians(), phi2.to_radians())));
    names(Mistake::MetersAsMillimeters, 1, |log| with_positions(log, |s1, s2| (1e-3 * s1, 1e-3 * s2)));
    names(Mistake::MillimetersAsMeters, 2, |log| with_positions(log, |s1, s2| (1e3 * s1, 1e3 * s2)));
}

#[test]
fn zeros_for_no_contact() {
    names(Mistake::ZerosForNoContact { readings: 60 }, 2, |log| {
        let mut log = log.clone();
        for start in [50, 150, 250] {
            log.samples[start..start + 20].iter_mut().for_each(|sample| sample.s1_m = Some(0.0));
        }
        log
    });
}

#[test]
fn coarse_digits() {
    let log = &logs()[1];
    let rounded_to = |step_m: f64| {
        let rounded = |s: Option<f64>| s.map(|s| (s / step_m).round() * step_m);
        let sample = |sample: &Sample| Sample { s1_m: rounded(sample.s1_m), s2_m: rounded(sample.s2_m), ..*sample };
        Log { samples: log.samples.iter().map(sample).collect() }
    };
    // An object is found through whole millimetres all the same; its error bars know of them.
    let found = Reconstructor::new().rig(Rig::uncalibrated()).run_or_name_mistake(&rounded_to(1e-3)).expect("a result");
    assert!(found.is_certified(), "{}", found.verdict);
    let named = named(&rounded_to(5e-3));
    assert!(matches!(named, Some(Mistake::CoarsePositions { step_m }) if (step_m - 5e-3).abs() < 1e-9), "{named:?}");
}

#[test]
fn an_ordinary_rig_that_is_taken_as_exact() {
    let log = &logs()[0];
    let found = Reconstructor::new().run_or_name_mistake(log).expect("a result");
    assert_eq!(found.verdict.doubts, [Doubt::Mistaken { mistake: Mistake::RigNotExact }]);
}

#[test]
fn what_is_reconstructed_is_the_log_without_the_mistake() {
    let log = &logs()[1];
    let reconstructor = Reconstructor::new().rig(Rig::uncalibrated());
    let written = with_positions(log, |s1, s2| (s2, s1));
    let found = reconstructor.run_or_name_mistake(&written).expect("a result");
    assert_eq!(*reconstructor.log_as_read(&written, &found), *log);
    let right = reconstructor.run(log).expect("a result");
    for theta in (0..36).map(|step| f64::from(step).to_radians() * 10.0) {
        let apart_m = found.shape.at(theta).r - right.shape.at(theta).r;
        assert!(apart_m.abs() < 1e-6, "{apart_m}");
    }
    assert_eq!(found.motion.len(), log.samples.len());
    assert_eq!(*reconstructor.log_as_read(log, &right), *log);
    // `run` itself names nothing.
    assert!(right.is_certified() && found.verdict.doubts.len() == 1);
}
