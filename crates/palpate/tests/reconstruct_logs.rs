//! The example logs, palms apart, drop-outs and noisy palm angles, all from nothing; and the same numbers from any number
//! of threads.

mod reconstruct_support;

use std::path::PathBuf;

use palpate::palms::PalmPair;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::reconstruct::{Reconstruction, reconstruct};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate::truth::TruePose;
use palpate::{Log, Sample, Truth};
use reconstruct_support::{SIZE_M, errors, noisy, rms_psi_rad, solve, turned};

/// An empty cell is a contact that was not seen.
fn number(cell: &str) -> f64 {
    if cell.is_empty() { f64::NAN } else { cell.parse().expect("a number") }
}

fn rows(path: &str) -> Vec<Vec<f64>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/examples/logs");
    let text = std::fs::read_to_string(folder.join(path)).expect("an example");
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines.map(|line| line.split(',').map(number).collect()).collect()
}

/// A log (time_s, phi1_rad, phi2_rad, s1_mm, s2_mm) and its truth.
fn example(name: &str) -> (Log, Truth) {
    let sample = |row: &Vec<f64>| {
        let mut sample = Sample::new(row[0], PalmPair::hinged(row[1], row[2]), 1e-3 * row[3], 1e-3 * row[4]);
        sample.s1_m = sample.s1_m.filter(|s| s.is_finite());
        sample.s2_m = sample.s2_m.filter(|s| s.is_finite());
        sample
    };
    let pose = |row: &Vec<f64>| TruePose { time_s: row[0], psi_rad: row[1], com_x_m: row[2], com_y_m: row[3] };
    let log = Log { samples: rows(&format!("{name}.csv")).iter().map(sample).collect() };
    let truth = Truth {
        support: rows(&format!("{name}.truth/shape.csv")).iter().map(|row| (row[0], row[1])).collect(),
        motion: rows(&format!("{name}.truth/motion.csv")).iter().map(pose).collect(),
    };
    assert_eq!(log.samples.len(), truth.motion.len());
    (log, truth)
}

fn certified(log: &Log) -> Reconstruction {
    let found = solve(log).expect("an answer");
    assert!(found.is_certified(), "{}", found.verdict);
    found
}

/// Certified and within `r_m` and `psi_deg` of the truth (RMS).
fn assert_within(log: &Log, truth: &Truth, r_m: f64, psi_deg: f64) -> Reconstruction {
    let found = certified(log);
    let error = errors(&found, truth);
    assert!(error.rms_r_m <= r_m, "r: {} mm", 1e3 * error.rms_r_m);
    let psi_rad = rms_psi_rad(&found, truth, 1);
    assert!(psi_rad.to_degrees() <= psi_deg, "psi: {} deg", psi_rad.to_degrees());
    found
}

#[test]
fn the_egg_that_turns_once_around() {
    // From an independent simulator, with 0.1 mm of noise.
    let (log, truth) = example("egg_full_turn_oracle_n0.1mm");
    let found = assert_within(&log, &truth, 2e-5, 0.5);
    assert!(found.is_com_certified() && found.coverage > 0.99 && found.jumps.is_empty());
    assert!((found.sensor_sd_m / 1e-4 - 1.0).abs() < 0.1, "{}", found.sensor_sd_m);
}

#[test]
fn the_ellipse_from_a_physics_engine() {
    let (log, truth) = example("ellipse_full_turn_pymunk");
    assert_within(&log, &truth, 2e-3 * SIZE_M, 0.5);
}

#[test]
fn the_pebble_on_touchpads_in_a_physics_engine() {
    // 200 counts per inch and noisy palm angles.
    let (log, truth) = example("pebble_full_turn_mujoco_sensor");
    assert_within(&log, &truth, 2e-3 * SIZE_M, 1.5);
}

#[test]
fn the_stone_that_jumps() {
    let (log, truth) = example("stone_zigzag_oracle");
    let found = assert_within(&log, &truth, 2e-5, 0.5);
    // The jumps of the truth: steps of ψ that no palm explains.
    let steps = truth.motion.windows(2).filter(|pair| (pair[1].psi_rad - pair[0].psi_rad).abs() > 0.2);
    let true_times: Vec<f64> = steps.map(|pair| pair[1].time_s).collect();
    assert!(!true_times.is_empty());
    assert_eq!(found.jumps.len(), true_times.len(), "{true_times:?}");
    let sample_s = truth.motion[1].time_s - truth.motion[0].time_s;
    for (jump, time_s) in found.jumps.iter().zip(&true_times) {
        assert!((jump.time_s - time_s).abs() < 2.5 * sample_s, "{} for {time_s}", jump.time_s);
        assert!(jump.physical && jump.height_after_m < jump.height_before_m);
    }
    assert_eq!(found.motion.last().map(|pose| pose.piece), Some(true_times.len() as u32));
}

#[test]
fn two_fingers() {
    // Base points apart. The pose depends on the palm angles alone, so a motion planned for a hinge does.
    let egg = NamedShape::Egg.shape(SIZE_M).expect("a positive size");
    let plan = plan_turn(&egg, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let motion = plan.motion.with_bases([0.006, -0.002], [-0.007, 0.001]).sample(15.0).expect("possible");
    let options = SimulateOptions {
        touchpad: noisy(5e-5),
        seed: 3,
        start_psi_rad: plan.start_psi_rad,
        ..SimulateOptions::default()
    };
    let run = simulate(&egg, &motion, &options).expect("possible");
    let found = assert_within(&run.log, &run.truth, 2e-5, 0.5);
    assert!(found.is_com_certified());
    // The place of the centre of mass, in the global frame.
    assert!(errors(&found, &run.truth).rms_com_m < 1e-4);
}

#[test]
fn one_reading_in_ten_missing() {
    let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a positive size");
    let run = turned(&pebble, 800, Touchpad { dropout: 0.1, ..noisy(5e-5) });
    let missing = run.log.samples.iter().filter(|sample| sample.s1_m.is_none() && sample.s2_m.is_none()).count();
    assert!(missing > 0, "some samples without any contact");
    let found = assert_within(&run.log, &run.truth, 2e-5, 1.5);
    assert_eq!(found.motion.len(), 800);
    for (pose, sample) in found.motion.iter().zip(&run.log.samples) {
        assert_eq!(
            (pose.residual1_m.is_some(), pose.residual2_m.is_some()),
            (sample.s1_m.is_some(), sample.s2_m.is_some())
        );
    }
}

#[test]
fn noisy_palm_angles() {
    let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a positive size");
    let run = turned(&pebble, 1000, Touchpad { angle_noise_sd_rad: 1e-3, ..noisy(5e-5) });
    assert_within(&run.log, &run.truth, 2e-5, 1.5);
}

/// Every number of a result, bit by bit.
fn bits(found: &Reconstruction) -> Vec<u64> {
    let mut numbers = vec![found.chi2_per_dof, found.coverage, found.sensor_sd_m, found.balance_sd_m];
    numbers.push(found.shape.mean_radius_m());
    numbers.extend(found.shape.harmonics_m().iter().flatten());
    numbers
        .extend(found.outline.iter().flat_map(|p| [p.theta_rad, p.r_m, p.r_sd_m, p.x_m, p.y_m, p.curvature_radius_m]));
    for p in &found.motion {
        numbers.extend([p.psi_rad, p.psi_sd_rad, p.com_x_m, p.com_y_m, p.com_sd_m, p.theta1_rad, p.theta2_rad]);
        numbers.extend([p.residual1_m.unwrap_or(f64::NAN), p.residual2_m.unwrap_or(f64::NAN)]);
    }
    numbers.extend(found.jumps.iter().flat_map(|j| [j.time_s, j.psi_before_rad, j.psi_after_rad, j.height_after_m]));
    let mut bits: Vec<u64> = numbers.into_iter().map(f64::to_bits).collect();
    bits.extend([u64::from(found.is_certified()), found.alternatives as u64]);
    bits
}

#[test]
fn the_same_bits_from_any_number_of_threads_and_every_time() {
    // Through jumps, where the search has most to choose from.
    let stone = NamedShape::Stone.shape(SIZE_M).expect("a positive size");
    let motion = palpate::palms::PalmMotion::random(4, 12.0, 1.0).and_then(|motion| motion.sample(30.0));
    let options = SimulateOptions { touchpad: noisy(1e-4), ..SimulateOptions::default() };
    let run = simulate(&stone, &motion.expect("possible"), &options).expect("possible");
    assert!(!run.jumps.is_empty());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let solved = pool.install(|| reconstruct(&run.log));
        bits(&solved.expect("an answer"))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
    assert_eq!(one, with(2));
}
