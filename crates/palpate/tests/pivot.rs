//! The pivoting grasp from strokes to shape: exactness, noise, tilted and uncalibrated pads, ambiguity, and logs that no rig can make.

use palpate::pivot::{
    PadPose, PivotCalibration, PivotDoubt, PivotLog, PivotOptions, PivotReconstructError, PivotRig, PivotSample,
    PivotSimulateError, PivotSimulateOptions, PivotSimulation, PivotTolerances, Stroke, compare_strokes, observability,
    reconstruct_strokes, reconstruct_with_posterior, simulate_strokes,
};
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;

fn pebble() -> SupportFunction {
    SupportFunction::new(0.03, vec![[0.004, 0.003], [0.002, -0.0012], [0.0005, 0.0007], [-0.0003, 0.0002]])
}

fn strokes() -> Vec<Stroke> {
    let ways = [[0.5, 0.62, 0.58], [0.52, 0.4, 0.45], [0.48, 0.6, 0.55], [0.5, 0.38, 0.41], [0.51, 0.6, 0.57]];
    ways.map(|along_m| Stroke { along_m: along_m.to_vec(), press: 3.0 }).to_vec()
}

fn options(rig: PivotRig, noise: f64) -> PivotSimulateOptions {
    PivotSimulateOptions {
        rig,
        touchpad: Touchpad { length_m: 1.0, noise_sd_m: 1e-4 * noise, ..Touchpad::ideal() },
        arm_noise_sd_m: 2e-5 * noise,
        friction: 0.6,
        rate_hz: 30.0,
        ..PivotSimulateOptions::default()
    }
}

fn simulated(rig: PivotRig, noise: f64) -> PivotSimulation {
    simulate_strokes(&pebble(), &strokes(), &options(rig, noise)).expect("it runs")
}

#[test]
fn the_simulator_keeps_the_contact_exactly() {
    let rig = PivotRig::exact(PadPose { base_x_m: 0.01, base_y_m: -0.02, tilt_rad: 0.2 });
    let simulation = simulated(rig, 0.0);
    let mut felt = 0;
    for (sample, theta) in simulation.log.samples.iter().zip(&simulation.theta_rad) {
        let Some(theta) = theta else {
            assert_eq!(sample.s_m, None);
            continue;
        };
        let [along, above] = rig.pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m);
        let contact = pebble().at(*theta);
        assert!((above - contact.r).abs() < 1e-12);
        assert!((along - sample.s_m.expect("on the pad") - contact.d).abs() < 1e-12);
        felt += 1;
    }
    assert!(felt > 500, "{felt}");
    // Every stroke begins at rest, with the centre of mass under the pivot.
    let first = simulation.theta_rad.windows(2).filter(|pair| pair[0].is_none()).filter_map(|pair| pair[1]);
    let [x, y] = PivotSimulateOptions::default().center_of_mass_m;
    let rest = y.atan2(x) + 0.2;
    assert!(first.clone().count() >= 5 && first.clone().all(|theta| (theta - rest).abs() < 0.2));
}

#[test]
fn without_friction_a_stroke_feels_one_flank_only() {
    let smooth = PivotSimulateOptions { friction: 0.0, ..options(PivotRig::default(), 0.0) };
    let simulation = simulate_strokes(&pebble(), &strokes(), &smooth).expect("it runs");
    let felt: Vec<f64> = simulation.theta_rad.iter().flatten().copied().collect();
    let (low, high) = felt.iter().fold((f64::MAX, f64::MIN), |(low, high), theta| (low.min(*theta), high.max(*theta)));
    let rolled = simulated(PivotRig::default(), 0.0);
    let rolled = rolled.theta_rad.iter().flatten();
    let (from, to) = rolled.fold((f64::MAX, f64::MIN), |(low, high), theta| (low.min(*theta), high.max(*theta)));
    assert!(high - low < 0.5 * (to - from), "{} {}", high - low, to - from);
}

#[test]
fn noise_free_strokes_give_the_shape_to_a_millionth_of_the_radius() {
    let simulation = simulated(PivotRig::default(), 0.0);
    let found = reconstruct_strokes(&simulation.log, &PivotOptions::default()).expect("it is solvable");
    let error = compare_strokes(&found, &simulation.truth).expect("they belong together");
    assert!(found.is_certified(), "{:?}", found.doubts);
    assert!(error.rms_r_m < 1e-6 * 0.03, "{error:?}");
    assert!(error.rms_psi_rad < 1e-4, "{error:?}");
}

#[test]
fn noisy_strokes_over_a_tilted_pad_give_the_shape_within_its_error_bars() {
    let rig = PivotRig::exact(PadPose { base_x_m: 0.01, base_y_m: -0.02, tilt_rad: 0.15 });
    let simulation = simulated(rig, 1.0);
    let found = reconstruct_strokes(&simulation.log, &PivotOptions::new(rig)).expect("it is solvable");
    assert!(found.is_certified(), "{:?}", found.doubts);
    let error = compare_strokes(&found, &simulation.truth).expect("they belong together");
    let along: Vec<f64> = simulation
        .log
        .samples
        .iter()
        .map(|sample| rig.pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m)[0])
        .collect();
    let bound_of = |shape: &SupportFunction| {
        let told = observability(shape, &simulation.theta_rad, &along, &rig, [1e-4, 2e-5]).expect("in range");
        told.bound.expect("it is determined").rms_r_sd_m()
    };
    let known = bound_of(&pebble());
    // The bound where it is not known that there are four harmonics only.
    let mut harmonics_m = pebble().harmonics_m().to_vec();
    harmonics_m.resize(found.shape.harmonics_m().len(), [0.0; 2]);
    let bound = bound_of(&SupportFunction::new(pebble().mean_radius_m(), harmonics_m));
    let of_seed = |seed: u64| {
        let options = PivotSimulateOptions { seed, ..options(rig, 1.0) };
        let simulation = simulate_strokes(&pebble(), &strokes(), &options).expect("it runs");
        let found = reconstruct_strokes(&simulation.log, &PivotOptions::new(rig)).expect("it is solvable");
        compare_strokes(&found, &simulation.truth).expect("they belong together").rms_r_m
    };
    let errors: Vec<f64> = (1..=8).map(of_seed).collect();
    let rms_m = (errors.iter().map(|error| error * error).sum::<f64>() / 8.0).sqrt();
    assert!(rms_m < 2.0 * known, "{errors:?} {known}");
    assert!(rms_m < 1.2 * bound, "{errors:?} {bound} {}", found.shape.harmonics_m().len());
    assert!((found.sensor_sd_m / 1.02e-4 - 1.0).abs() < 0.1 && (found.arm_sd_m / 2e-5 - 1.0).abs() < 0.15);
    // The resting angle has the direction of the centre of mass, seen in the frame of the object found.
    let center = found.center_of_mass.expect("strokes begin at rest");
    let [x, y] = PivotSimulateOptions::default().center_of_mass_m;
    let off = (center.direction_rad - y.atan2(x) - error.rotation_rad + 9.0 * std::f64::consts::PI)
        .rem_euclid(std::f64::consts::TAU)
        - std::f64::consts::PI;
    assert!(off.abs() < 4.0 * center.direction_sd_rad, "{off} {center:?}");
    assert_eq!(center.distance_m, None);
}

#[test]
fn constants_of_an_uncalibrated_rig_are_found_with_the_shape() {
    let errors = PivotCalibration { zero_m: 4e-4, scale: -0.008, tilt_rad: 0.006, height_m: 0.0 };
    let pad = PadPose::default();
    let rig = PivotRig { calibration: errors, ..PivotRig::exact(pad) };
    let simulation = simulated(rig, 1.0);
    let stated = PivotRig::uncalibrated(pad);
    let found = reconstruct_strokes(&simulation.log, &PivotOptions::new(stated)).expect("it is solvable");
    assert!(found.is_certified(), "{:?}", found.doubts);
    let (value, sd) = (found.calibration, found.calibration_sd);
    assert!((value.zero_m - errors.zero_m).abs() < 4.0 * sd.zero_sd_m && sd.zero_sd_m < 1e-4, "{value:?} {sd:?}");
    assert!((value.scale - errors.scale).abs() < 4.0 * sd.scale_sd && sd.scale_sd < 0.01, "{value:?} {sd:?}");
    assert!((value.tilt_rad - errors.tilt_rad).abs() < 4.0 * sd.tilt_sd_rad, "{value:?} {sd:?}");
    // The height of the pad is not told: its tolerance stays.
    assert_eq!(sd.height_sd_m, PivotTolerances::UNCALIBRATED.height_sd_m);
    // Taken as exact, the readings are refused: half of them are enough for that.
    let half = simulation.log.samples[..simulation.log.samples.len() / 2].to_vec();
    let log = PivotLog { samples: half, ..simulation.log };
    let taken = reconstruct_strokes(&log, &PivotOptions::default()).expect("it is solvable");
    assert!(!taken.is_certified());
}

#[test]
fn segments_without_boundary_in_common_are_not_certified() {
    // Two short strokes that began at different angles, far from each other.
    let shape = pebble();
    let mut state = 1u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        2.0 * ((state >> 11) as f64 / (1u64 << 53) as f64) - 1.0
    };
    let mut sample = |index: usize, theta: f64| {
        let contact = shape.at(theta);
        let along = 0.3 + 0.03 * theta;
        let touched = index % 66 < 60;
        PivotSample {
            time_s: 0.05 * index as f64,
            pivot_x_m: along,
            pivot_y_m: if touched { contact.r + 3e-5 * noise() } else { 0.06 },
            s_m: touched.then_some(along - contact.d + 1.5e-4 * noise()),
        }
    };
    let theta = |index: usize| if index < 66 { 0.2 + 0.008 * index as f64 } else { 3.0 + 0.008 * (index - 66) as f64 };
    let samples = (0..132).map(|index| sample(index, theta(index))).collect();
    let log = PivotLog { samples, swing_period_s: None };
    let found = reconstruct_strokes(&log, &PivotOptions::default()).expect("it is solvable");
    assert!(!found.is_certified());
}

#[test]
fn the_posterior_holds_the_truth() {
    let simulation = simulated(PivotRig::default(), 1.0);
    let (found, posterior) =
        reconstruct_with_posterior(&simulation.log, &PivotOptions::default()).expect("it is solvable");
    assert_eq!(posterior.mean(), found.shape);
    // Draws scatter as the error bars say.
    let theta = found.outline[found.outline.iter().position(|point| point.touches > 0).expect("felt")].theta_rad;
    let point = found.outline.iter().find(|point| point.theta_rad == theta).expect("it is there");
    let squares: f64 = (0..200).map(|seed| (posterior.draw(seed).radius_m(theta) - point.r_m).powi(2)).sum();
    assert!(((squares / 200.0).sqrt() / point.r_sd_m - 1.0).abs() < 0.2);
}

#[test]
fn gaps_outliers_and_whole_strokes_off_the_pad_do_not_panic() {
    let simulation = simulated(PivotRig::default(), 1.0);
    let mut log = simulation.log;
    for index in (0..log.samples.len()).step_by(7) {
        log.samples[index].s_m = None;
    }
    let gaps = reconstruct_strokes(&log, &PivotOptions::default()).expect("it is solvable");
    assert_eq!(gaps.motion.len(), log.samples.len());
    for index in (3..log.samples.len()).step_by(50) {
        if let Some(s) = &mut log.samples[index].s_m {
            *s += 0.02;
        }
    }
    let off = reconstruct_strokes(&log, &PivotOptions::default());
    // What is certified in spite of them is right.
    if let Some(found) = off.ok().filter(|found| found.is_certified()) {
        let error = compare_strokes(&found, &simulation.truth).expect("they belong together");
        assert!(error.rms_r_m < 1e-4 && error.rms_psi_rad < 0.02, "{error:?}");
    }
}

#[test]
fn logs_that_no_rig_can_make_are_refused_in_words() {
    let log = |values: &[(f64, f64, f64, f64)]| PivotLog {
        samples: values
            .iter()
            .map(|&(time_s, pivot_x_m, pivot_y_m, s)| PivotSample { time_s, pivot_x_m, pivot_y_m, s_m: Some(s) })
            .collect(),
        swing_period_s: None,
    };
    let options = PivotOptions::default();
    let few = reconstruct_strokes(&log(&[(0.0, 0.0, 0.03, 0.0)]), &options);
    assert!(matches!(few, Err(PivotReconstructError::TooFewSamples { seen: 1, .. })));
    let still: Vec<_> = (0..100).map(|i| (f64::from(i), 0.1, 0.03, 0.1)).collect();
    assert_eq!(reconstruct_strokes(&log(&still), &options), Err(PivotReconstructError::NotSolvable));
    let mut bad = still.clone();
    bad[40].2 = f64::NAN;
    assert!(matches!(
        reconstruct_strokes(&log(&bad), &options),
        Err(PivotReconstructError::BadSample { sample: 41, .. })
    ));
    bad[40] = (3.0, 0.1, 0.03, 0.1);
    assert!(matches!(
        reconstruct_strokes(&log(&bad), &options),
        Err(PivotReconstructError::BadSample { sample: 41, .. })
    ));
    let order = PivotOptions::default().harmonics(Some(1));
    assert!(matches!(reconstruct_strokes(&log(&still), &order), Err(PivotReconstructError::BadOption(_))));
    // Values of any size and order: an error or a result that is not certified.
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    for scale in [1e-3, 0.1, 1e6] {
        let wild: Vec<_> =
            (0..80).map(|i| (f64::from(i), scale * random(), scale * random(), scale * random())).collect();
        if let Ok(found) = reconstruct_strokes(&log(&wild), &options) {
            assert!(!found.is_certified());
        }
    }
}

#[test]
fn simulations_out_of_range_are_refused() {
    let run = |shape: &SupportFunction, strokes: &[Stroke], options: &PivotSimulateOptions| {
        simulate_strokes(shape, strokes, options).err()
    };
    let usual = PivotSimulateOptions::default();
    let hollow = SupportFunction::new(0.03, vec![[0.0, 0.0], [0.0, 0.0], [0.01, 0.0]]);
    assert!(matches!(run(&hollow, &strokes(), &usual), Some(PivotSimulateError::NotConvex { .. })));
    let outside = SupportFunction::new(0.03, vec![[0.04, 0.0]]);
    assert!(matches!(run(&outside, &strokes(), &usual), Some(PivotSimulateError::PivotOutside { .. })));
    assert_eq!(run(&pebble(), &[], &usual), Some(PivotSimulateError::NoStrokes));
    let fast = PivotSimulateOptions { rate_hz: f64::NAN, ..usual.clone() };
    assert!(matches!(run(&pebble(), &strokes(), &fast), Some(PivotSimulateError::OutOfRange { .. })));
    let far = [Stroke { along_m: vec![f64::INFINITY], press: 1.0 }];
    assert!(matches!(run(&pebble(), &far, &usual), Some(PivotSimulateError::OutOfRange { .. })));
}

#[test]
fn a_wrong_height_of_the_pad_is_a_parallel_body_and_the_tolerance_says_so() {
    let high = PivotRig {
        calibration: PivotCalibration { height_m: 1e-3, ..PivotCalibration::default() },
        ..PivotRig::default()
    };
    let simulation = simulated(high, 0.0);
    let found = reconstruct_strokes(&simulation.log, &PivotOptions::default()).expect("it is solvable");
    assert!(found.is_certified(), "{:?}", found.doubts);
    assert!((found.shape.mean_radius_m() - 0.031).abs() < 1e-7, "{}", found.shape.mean_radius_m());
}

#[test]
fn a_circle_about_its_pivot_is_never_certified() {
    // Whatever turns, height and offset stay: no angle is told.
    let circle = SupportFunction::new(0.03, vec![[2e-5, 0.0]]);
    let simulation = simulate_strokes(&circle, &strokes(), &options(PivotRig::default(), 1.0)).expect("it runs");
    match reconstruct_strokes(&simulation.log, &PivotOptions::default()) {
        Ok(found) => {
            // Either no angle is told, or the object hardly turned.
            let is_meant = |doubt: &PivotDoubt| {
                matches!(doubt, PivotDoubt::UncertainMotion { .. } | PivotDoubt::LittleFelt { .. })
            };
            assert!(found.doubts.iter().any(is_meant), "{:?}", found.doubts);
        }
        Err(error) => assert_eq!(error, PivotReconstructError::NotSolvable),
    }
}
