//! The simulator against an independent one, and its sensor, refusals and planned motions.

use std::f64::consts::PI;

use palpate::mechanics::{ContactMode, EnergyLandscape};
use palpate::palms::{Palm, PalmMotion, PalmMove, PalmPair};
use palpate::plan::{PalmFriction, PalmLimits, PlanError, plan_jump_free, plan_turn, plan_turn_with_friction};
use palpate::reconstruct::{CenterStrip, FrictionEstimate, center_strips};
use palpate::sensor::{PadContact, Touchpad};
use palpate::shape::{NamedShape, RandomShape, SupportFunction, random_shape};
use palpate::simulate::{SimulateError, SimulateOptions, coverage, simulate};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const ORACLE: &str = include_str!("data/zigzag_oracle.csv");

fn numbers(line: &str, separator: char) -> Vec<f64> {
    line.split(separator).map(|number| number.trim().parse().expect("a number")).collect()
}

#[test]
fn an_independent_simulator_agrees_through_three_jumps() {
    let line = ORACLE.lines().find_map(|line| line.strip_prefix("# shape_m: ")).expect("the shape");
    let coefficients = numbers(line, ' ');
    let shape =
        SupportFunction::new(coefficients[0], coefficients[1..].chunks(2).map(|pair| [pair[0], pair[1]]).collect());
    let rows: Vec<Vec<f64>> =
        ORACLE.lines().filter(|line| !line.starts_with(['#', 't'])).map(|line| numbers(line, ',')).collect();
    let motion: Vec<(f64, PalmPair)> = rows.iter().map(|row| (row[0], PalmPair::hinged(row[1], row[2]))).collect();
    let options = SimulateOptions { start_psi_rad: rows[0][5], ..SimulateOptions::default() };
    let simulation = simulate(&shape, &motion, &options).expect("possible");
    assert_eq!(simulation.jumps.len(), 3);
    for ((row, sample), pose) in rows.iter().zip(&simulation.log.samples).zip(&simulation.truth.motion) {
        let (s1, s2) = (sample.s1_m.expect("seen"), sample.s2_m.expect("seen"));
        // The oracle's angles are rounded to 1e-6 rad and its lengths to 1e-7 m; near a jump ψ is sensitive to both.
        assert!((s1 - row[3] * 1e-3).abs() < 4e-7 && (s2 - row[4] * 1e-3).abs() < 4e-7, "at {} s", row[0]);
        assert!((pose.psi_rad - row[5]).sin().abs() < 3e-5, "at {} s", row[0]);
    }
}

fn pebble(seed: u64) -> SupportFunction {
    random_shape(&RandomShape::default(), seed).expect("the default kind is valid")
}

fn random_run(seed: u64, options: &SimulateOptions) -> palpate::simulate::Simulation {
    let motion = PalmMotion::random(seed, 9.0, 1.0).and_then(|motion| motion.sample(100.0)).expect("possible");
    simulate(&pebble(seed), &motion, options).expect("possible")
}

#[test]
fn every_pose_is_in_balance_and_jumps_lose_energy() {
    let mut jumps = 0;
    for seed in 0..12 {
        let shape = pebble(seed);
        let options = SimulateOptions { mass_kg: 0.2, ..SimulateOptions::default() };
        let simulation = random_run(seed, &options);
        for (sample, pose) in simulation.log.samples.iter().zip(&simulation.truth.motion) {
            let landscape = EnergyLandscape::new(&shape, &sample.palms);
            assert!(landscape.balance_m(pose.psi_rad).abs() < 1e-13 * shape.mean_radius_m());
            assert!(landscape.balance_slope_m(pose.psi_rad) > 0.0);
            assert!((landscape.height_m(pose.psi_rad) - pose.com_y_m).abs() < 1e-14);
            // The three force lines meet over the centre of mass (section 3 of the paper).
            let (s1, s2) = (sample.s1_m.expect("seen"), sample.s2_m.expect("seen"));
            let (sin1, sin12) = (sample.palms.phi1_rad.sin(), sample.palms.phi12_rad().sin());
            assert!(((s1 * sin12 - s2 * sin1) / sample.palms.phi2_rad.sin() - pose.com_x_m).abs() < 1e-12);
        }
        for jump in &simulation.jumps {
            assert!(jump.physical && jump.height_drop_m() > 0.0);
            let after = simulation.truth.motion.iter().find(|pose| pose.time_s > jump.time_s);
            let risen = after.map_or(0.0, |pose| pose.com_y_m - jump.height_after_m);
            // Within a sample the palms lift by a few millimetres at most.
            assert!(risen.abs() < 3e-3, "heights are those of the poses: {risen}");
            jumps += 1;
        }
    }
    assert!(jumps > 5, "random motions jump: {jumps}");
}

#[test]
fn the_rate_of_sampling_does_not_change_the_poses() {
    for seed in 20..26 {
        let motion = PalmMotion::random(seed, 9.0, 1.0).expect("possible");
        let fine = motion.sample(2000.0).expect("possible");
        let coarse: Vec<(f64, PalmPair)> = fine.iter().copied().step_by(20).collect();
        let options = SimulateOptions::default();
        let shape = pebble(seed);
        let (fine, coarse) = (
            simulate(&shape, &fine, &options).expect("possible"),
            simulate(&shape, &coarse, &options).expect("possible"),
        );
        assert_eq!(fine.jumps.len(), coarse.jumps.len());
        for (a, b) in fine.truth.motion.iter().step_by(20).zip(&coarse.truth.motion) {
            assert!((a.psi_rad - b.psi_rad).abs() < 1e-9);
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_log_and_the_noise_is_as_stated() {
    let touchpad =
        Touchpad { length_m: 1.0, noise_sd_m: 3e-4, dropout: 0.1, angle_noise_sd_rad: 1e-3, ..Touchpad::interlink() };
    let options =
        SimulateOptions { touchpad, seed: 5, with_forces: true, with_stated_noise: true, ..SimulateOptions::default() };
    let (noisy, again) = (random_run(3, &options), random_run(3, &options));
    assert_eq!(noisy, again);
    assert_ne!(noisy.log, random_run(3, &SimulateOptions { seed: 6, ..options.clone() }).log);
    let exact = random_run(3, &SimulateOptions::default());
    let pairs = || noisy.log.samples.iter().zip(&exact.log.samples);
    let errors: Vec<f64> = pairs()
        .flat_map(|(noisy, exact)| [(noisy.s1_m, exact.s1_m), (noisy.s2_m, exact.s2_m)])
        .filter_map(|(noisy, exact)| Some(noisy? - exact?))
        .collect();
    let rms = |errors: &[f64]| (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    let stated = noisy.log.samples[0].s1_sd_m.expect("stated");
    assert!((stated - (9e-8 + 1.27e-4f64.powi(2) / 12.0).sqrt()).abs() < 1e-12);
    assert!((rms(&errors) / stated - 1.0).abs() < 0.08, "{} {stated}", rms(&errors));
    let seen = errors.len() as f64 / (2.0 * exact.log.samples.len() as f64);
    assert!((seen - 0.9).abs() < 0.03, "{seen}");
    let turns: Vec<f64> = pairs().map(|(noisy, exact)| noisy.palms.phi1_rad - exact.palms.phi1_rad).collect();
    assert!((rms(&turns) / 1e-3 - 1.0).abs() < 0.1);
    for (noisy, exact) in pairs() {
        let Some(force) = noisy.force1_n else { continue };
        let true_force = 0.1 * 9.80665 * exact.palms.phi12_rad().sin() / exact.palms.phi2_rad.sin();
        assert!((force - true_force).abs() <= 0.5 * 10.0 / 127.0 + 1e-12);
    }
    assert!(exact.log.samples.iter().all(|sample| sample.force1_n.is_none() && sample.s1_sd_m.is_none()));
}

#[test]
fn a_pad_rounds_and_reports_the_centroid_of_its_contacts() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let pad = Touchpad { pressure_levels: Some(11), full_scale_n: 5.0, ..Touchpad::interlink() };
    let contact = |position_m: f64, force_n: f64| PadContact { position_m, force_n };
    let reading = pad.read(&[contact(0.010, 1.0), contact(0.030, 3.2)], &mut rng).expect("seen");
    assert!((reading.position_m - (0.010 + 0.096) / 4.2).abs() <= 0.5 * 0.000_127 + 1e-12);
    assert!(((reading.position_m / 0.000_127).round() * 0.000_127 - reading.position_m).abs() < 1e-15);
    assert!((reading.force_n - 4.0).abs() < 1e-12);
    assert_eq!(pad.read(&[], &mut rng), None);
    let full = pad.read(&[contact(0.02, 100.0)], &mut rng).expect("seen");
    assert!((full.force_n - 5.0).abs() < 1e-12);
}

#[test]
fn what_cannot_be_is_refused_with_its_time() {
    let egg = NamedShape::Egg.shape(0.03).expect("a valid size");
    let options = SimulateOptions::default();
    let hinged = |angles: &[(f64, f64)]| -> Vec<(f64, PalmPair)> {
        angles.iter().enumerate().map(|(i, &(phi1, phi2))| (i as f64, PalmPair::hinged(phi1, phi2))).collect()
    };
    assert_eq!(simulate(&egg, &[], &options), Err(SimulateError::NoMotion));
    let crossed = simulate(&egg, &hinged(&[(0.5, 1.0), (0.5, -0.1)]), &options);
    assert!(matches!(crossed, Err(SimulateError::Parallel { time_s: 1.0, .. })));
    let lying = simulate(&egg, &hinged(&[(0.5, 1.0), (-0.2, 1.0)]), &options);
    assert!(matches!(lying, Err(SimulateError::LeavesPalm { time_s: 1.0, palm: Palm::Two })));
    let lying = simulate(&egg, &hinged(&[(0.5, 1.0), (1.5, PI - 1.3)]), &options);
    assert!(matches!(lying, Err(SimulateError::LeavesPalm { time_s: 1.0, palm: Palm::One })));
    let infinite = simulate(&egg, &hinged(&[(0.5, 1.0), (f64::NAN, 1.0)]), &options);
    assert_eq!(infinite, Err(SimulateError::FaultyMotion { sample: 1 }));
    let endless = simulate(&egg, &hinged(&[(0.5, 1.0), (1e300, 1.0)]), &options);
    assert_eq!(endless, Err(SimulateError::FaultyMotion { sample: 1 }));
    let backwards = [(1.0, PalmPair::hinged(0.5, 1.0)), (0.0, PalmPair::hinged(0.5, 1.0))];
    assert_eq!(simulate(&egg, &backwards, &options), Err(SimulateError::FaultyMotion { sample: 1 }));
    // Squeezed, the object runs off a palm of 60 mm on the way.
    let short = SimulateOptions { touchpad: Touchpad { length_m: 0.06, ..Touchpad::ideal() }, ..options.clone() };
    let squeezed = simulate(&egg, &hinged(&[(0.7, 1.7), (1.2, 0.5)]), &short);
    let Err(SimulateError::RunsOff { time_s, position_m, .. }) = squeezed else { panic!("{squeezed:?}") };
    assert!((0.1..0.9).contains(&time_s) && position_m > 0.06 && position_m < 0.065);
    let dented = SupportFunction::new(0.03, vec![[0.0; 2], [0.012, 0.0]]);
    assert!(matches!(simulate(&dented, &hinged(&[(0.5, 1.0)]), &options), Err(SimulateError::NotConvex { .. })));
    for bad in [
        SimulateOptions { mass_kg: 0.0, ..options.clone() },
        SimulateOptions { start_psi_rad: f64::NAN, ..options.clone() },
        SimulateOptions { touchpad: Touchpad { dropout: 2.0, ..Touchpad::ideal() }, ..options.clone() },
        SimulateOptions { touchpad: Touchpad { noise_sd_m: -1.0, ..Touchpad::ideal() }, ..options.clone() },
    ] {
        assert!(matches!(simulate(&egg, &hinged(&[(0.5, 1.0)]), &bad), Err(SimulateError::OutOfRange { .. })));
    }
}

#[test]
fn palms_apart_balance_alike_and_are_read_from_their_own_bases() {
    // Moving both bases together moves the object; sliding a palm along itself changes its reading only.
    let shape = pebble(2);
    let motion = PalmMotion::random(2, 5.0, 0.5).expect("possible");
    let options = SimulateOptions::default();
    let run =
        |motion: &PalmMotion| simulate(&shape, &motion.sample(50.0).expect("possible"), &options).expect("possible");
    let (hinged, moved) = (run(&motion), run(&motion.clone().with_bases([0.1, 0.2], [0.1, 0.2])));
    let apart = run(&motion.with_bases([-0.02, 0.0], [0.02, 0.0]));
    for (i, (a, b)) in hinged.truth.motion.iter().zip(&moved.truth.motion).enumerate() {
        assert!((a.psi_rad - b.psi_rad).abs() < 1e-9 && (a.com_x_m + 0.1 - b.com_x_m).abs() < 1e-9);
        let (sample_a, sample_b) = (hinged.log.samples[i], moved.log.samples[i]);
        assert!((sample_a.s1_m.unwrap_or(0.0) - sample_b.s1_m.unwrap_or(1.0)).abs() < 1e-9);
        assert!((a.psi_rad - apart.truth.motion[i].psi_rad).abs() < 1e-9);
    }
}

#[test]
fn an_object_with_a_stable_way_around_is_turned_around() {
    let shape = NamedShape::Ellipse.shape(0.03).expect("a valid size");
    let planned = plan_turn(&shape, &PalmLimits::default(), 60.0).expect("a way");
    assert!(planned.full_turn && planned.coverage > 0.999, "{planned:?}");
    let path = planned.motion.sample(20.0).expect("possible");
    let options = SimulateOptions { start_psi_rad: planned.start_psi_rad, ..SimulateOptions::default() };
    let simulation = simulate(&shape, &path, &options).expect("possible");
    assert!(simulation.jumps.is_empty() && coverage(&simulation, &path) > 0.999);
    assert_eq!(plan_turn(&shape, &PalmLimits::default(), 60.0), Ok(planned));
}

#[test]
fn planned_motions_do_not_jump_and_feel_most_of_the_boundary() {
    for seed in 0..6 {
        let shape = pebble(seed);
        let planned = plan_jump_free(&shape, seed, 40.0).expect("a way");
        assert!(planned.coverage >= 0.6, "{seed}: {}", planned.coverage);
        let path = planned.motion.sample(25.0).expect("possible");
        let options = SimulateOptions { start_psi_rad: planned.start_psi_rad, ..SimulateOptions::default() };
        let simulation = simulate(&shape, &path, &options).expect("possible");
        assert!(simulation.jumps.is_empty(), "{seed}");
        assert!((coverage(&simulation, &path) - planned.coverage).abs() < 0.02);
    }
    let circle = NamedShape::Circle.shape(0.03).expect("a valid size");
    assert!(plan_turn(&circle, &PalmLimits::default(), 10.0).is_ok_and(|planned| !planned.full_turn));
    assert!(plan_turn(&circle, &PalmLimits { largest_phi2_rad: 4.0, ..PalmLimits::default() }, 10.0).is_err());
    assert!(plan_turn(&circle, &PalmLimits::default(), f64::NAN).is_err());
}

#[test]
fn a_schedule_runs_through_the_simulator() {
    let moves = [PalmMove::BackAndForth {
        times: 2,
        moves: vec![
            PalmMove::OpenAndRotate { open_rad: -0.5, rotate_rad: 0.3, duration_s: 3.0 },
            PalmMove::OpenOne { palm: Palm::Two, angle_rad: 0.4, duration_s: 2.0 },
        ],
    }];
    let motion = PalmMotion::schedule(PalmPair::hinged(0.6, 1.7), &moves).expect("possible");
    let shape = NamedShape::Pebble.shape(0.03).expect("a valid size");
    let simulation =
        simulate(&shape, &motion.sample(20.0).expect("possible"), &SimulateOptions::default()).expect("possible");
    assert_eq!(simulation.log.samples.len(), 401);
    assert_eq!(simulation.truth.motion.len(), 401);
}

#[test]
fn palms_with_friction_carry_an_object_round_whatever_the_friction_in_its_band() {
    let shape = "egg".parse::<NamedShape>().expect("a name").shape(0.03).expect("a shape");
    let friction = PalmFriction { coefficients: [0.1, 0.3], coefficient_sds: [0.005, 0.01] };
    let limits = PalmLimits::default();
    let planned = plan_turn_with_friction(&shape, &limits, 60.0, &friction).expect("a way");
    let palms = planned.motion.sample(20.0).expect("samples");
    for sds in [-2.0, -0.7, 0.0, 1.3, 2.0] {
        let options = SimulateOptions {
            friction: [0.1 + sds * 0.005, 0.3 + sds * 0.01],
            start_psi_rad: planned.start_psi_rad,
            ..SimulateOptions::default()
        };
        let run = simulate(&shape, &palms, &options).expect("it stays between the palms");
        let turned = run.truth.motion[run.truth.motion.len() - 1].psi_rad - run.truth.motion[0].psi_rad;
        assert!(run.jumps.is_empty(), "{sds}");
        assert_eq!(turned.abs() >= std::f64::consts::TAU - 1e-6, planned.full_turn, "{sds} {turned}");
    }
    // Where friction carries it round, palms without any would let it slide back.
    let slick = SimulateOptions { start_psi_rad: planned.start_psi_rad, ..SimulateOptions::default() };
    let run = simulate(&shape, &palms, &slick).expect("it stays between the palms");
    let turned = run.truth.motion[run.truth.motion.len() - 1].psi_rad - run.truth.motion[0].psi_rad;
    assert!(turned.abs() < 3.0, "{turned}");
    // Known to be none, it is the way of slick palms; what is no friction is named.
    assert_eq!(
        plan_turn_with_friction(&shape, &limits, 60.0, &PalmFriction::known([0.0; 2])),
        plan_turn(&shape, &limits, 60.0)
    );
    let refused = plan_turn_with_friction(&shape, &limits, 60.0, &PalmFriction::known([f64::NAN, 0.1]));
    assert_eq!(refused, Err(PlanError::OutOfRange { what: "a coefficient of friction" }));
    // Palms that hardly open, and grip: whatever they do, it is held.
    let narrow = PalmLimits { largest_phi2_rad: 0.6, ..limits };
    let held = plan_turn_with_friction(&shape, &narrow, 60.0, &PalmFriction::known([1.0; 2]));
    assert!(matches!(held, Err(PlanError::Sticks { .. })), "{held:?}");
}

#[test]
fn measured_forces_tell_the_weight_and_that_they_were_exchanged() {
    let shape = "egg".parse::<NamedShape>().expect("a name").shape(0.03).expect("a shape");
    let planned = plan_turn(&shape, &PalmLimits::default(), 30.0).expect("a way");
    let palms = planned.motion.sample(10.0).expect("samples");
    let options = SimulateOptions {
        with_forces: true,
        mass_kg: 0.05,
        start_psi_rad: planned.start_psi_rad,
        touchpad: Touchpad { noise_sd_m: 3e-5, ..Touchpad::ideal() },
        ..SimulateOptions::default()
    };
    let mut log = simulate(&shape, &palms, &options).expect("possible").log;
    let result = palpate::reconstruct(&log).expect("a result");
    let forces = palpate::reconstruct::measured_forces(&log, &result).expect("they were measured");
    assert!((forces.mass_kg() - 0.05).abs() < 1e-4 && forces.oddities().is_empty(), "{forces:?}");
    // In grams instead of newtons, of one sensor of another scale, and of the other palm.
    let with = |change: &dyn Fn(Option<f64>, Option<f64>) -> (Option<f64>, Option<f64>)| {
        let mut log = log.clone();
        for sample in &mut log.samples {
            (sample.force1_n, sample.force2_n) = change(sample.force1_n, sample.force2_n);
        }
        palpate::reconstruct::measured_forces(&log, &result).expect("they were measured").oddities().concat()
    };
    let grams = |force_n: Option<f64>| force_n.map(|force_n| force_n / 9.80665e-3);
    assert!(with(&|first, second| (grams(first), grams(second))).contains("are they in grams"));
    assert!(
        with(&|first, second| (first, second.map(|force_n| 1.2 * force_n))).contains("20 % more force than palm 1")
    );
    assert!(with(&|first, second| (second, first)).contains("exchange force1 and force2"));
    // What is exchanged is not used, and what is no force is refused.
    for sample in &mut log.samples {
        (sample.force1_n, sample.force2_n) = (sample.force2_n, sample.force1_n);
    }
    assert_eq!(palpate::reconstruct(&log).expect("a result").motion, result.motion);
    log.samples[7].force1_n = Some(-0.1);
    assert!(palpate::reconstruct(&log).expect_err("it pulls").to_string().contains("a palm only pushes"));
}

/// Both palms of one coefficient, the centre of mass where it was found.
fn palms_of(coefficient: f64) -> FrictionEstimate {
    FrictionEstimate {
        coefficients: [coefficient; 2],
        coefficient_sds: [0.0; 2],
        center_m: [0.0; 2],
        center_sd_m: [0.0; 2],
        misfit: 1.0,
        slides: 0,
        rolls: [0; 2],
    }
}

#[test]
fn every_sample_leaves_the_centre_of_mass_where_it_is() {
    let shape = "egg".parse::<NamedShape>().expect("a name").shape(0.03).expect("a shape");
    let planned = plan_turn(&shape, &PalmLimits::default(), 30.0).expect("a way");
    let palms = planned.motion.sample(10.0).expect("samples");
    let options = SimulateOptions { start_psi_rad: planned.start_psi_rad, ..SimulateOptions::default() };
    let log = simulate(&shape, &palms, &options).expect("possible").log;
    let mut result = palpate::reconstruct(&log).expect("a result");
    assert!(center_strips(&log, &result).iter().all(Option::is_none), "without friction it is a line, and no strip");
    let mut widths_m = Vec::new();
    for coefficient in [1e-6, 0.05, 0.1] {
        result.friction = Some(palms_of(coefficient));
        let strips: Vec<CenterStrip> = center_strips(&log, &result).into_iter().flatten().collect();
        assert_eq!(strips.len(), log.samples.len());
        // Found to a micrometre: what balances without friction balances with less than all of it.
        assert!(strips.iter().all(|strip| strip.low_m < 1e-6 && strip.high_m > -1e-6));
        widths_m.push(strips.iter().map(|strip| strip.high_m - strip.low_m).fold(0.0, f64::max));
    }
    assert!(widths_m[0] < 1e-6 && widths_m[1] > 1e-3 && widths_m[2] > 1.9 * widths_m[1], "{widths_m:?}");
    // Where it slides on both palms there is a line.
    result.motion[0].modes = Some([ContactMode::SlidePlus, ContactMode::SlideMinus]);
    let line = center_strips(&log, &result)[0].expect("it does not jam");
    assert_eq!(line.low_m, line.high_m);
    // Cones that meet: it may be anywhere.
    result.friction = Some(palms_of(5.0));
    assert!(center_strips(&log, &result)[1..].iter().all(Option::is_none));
}
