use super::*;
use crate::mechanics::frictionless::followed;
use crate::palms::PalmMotion;
use crate::shape::NamedShape;
use crate::simulate::{SimulateOptions, Simulation, simulate};
use std::f64::consts::TAU;

fn jump(sample: usize, psi_before: f64, psi_after: f64, predicted: bool) -> DetectedJump {
    let (height_before_m, height_after_m) = (0.03, 0.03);
    DetectedJump { sample, psi_before, psi_after, height_before_m, height_after_m, physical: true, predicted }
}

#[test]
fn a_jump_that_is_undone_at_once_and_not_predicted_counts_as_reversed() {
    let there = jump(100, 1.0, 1.1, false);
    assert_eq!(jump_reversals(&[there, jump(103, 1.1, 1.01, false)]), 1);
    assert_eq!(jump_reversals(&[there, jump(103, 1.1, 1.2, false)]), 0, "onwards");
    assert_eq!(jump_reversals(&[there, jump(300, 1.1, 1.01, false)]), 0, "much later");
    let predicted = DetectedJump { predicted: true, ..there };
    assert_eq!(jump_reversals(&[predicted, jump(103, 1.1, 1.01, true)]), 0, "as statics has it");
}

#[test]
fn no_step_much_longer_than_a_jump_is_its_ringing() {
    let whole = jump(100, 1.0, 1.1, true);
    assert!(whole.rings_with(0.4));
    assert!(!whole.rings_with(1.2));
    assert!(!jump(100, 1.0, 1.1 + TAU, true).rings_with(3.2), "the pose before, a whole turn on");
}

/// An egg between palms that turn and open, with the jumps that its simulation makes.
fn jumping() -> (SupportFunction, Simulation, Vec<f64>) {
    let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
    let motion = PalmMotion::random(3, 20.0, 0.5).and_then(|motion| motion.sample(25.0)).expect("possible");
    let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    (shape, run, psi)
}

/// First sample after the one jump of that motion.
fn first_after(run: &Simulation) -> usize {
    let [jump] = &run.jumps[..] else { panic!("one jump: {:?}", run.jumps) };
    run.log.samples.iter().position(|sample| sample.time_s > jump.time_s).expect("samples after the jump")
}

#[test]
fn the_jump_of_a_simulated_motion_is_found_with_its_sample_and_its_poses() {
    let (shape, run, psi) = jumping();
    let at = first_after(&run);
    let [jump] = detect_jumps(&shape, &run.log, &psi)[..] else { panic!("one jump") };
    assert_eq!((jump.sample, jump.psi_before, jump.psi_after), (at, psi[at - 1], psi[at]));
    assert!(jump.physical && jump.predicted);
    let palms = run.log.samples[at].palms;
    let height = |psi: f64| {
        let (one, two) = palms.contact_angles(psi);
        palms.center_of_mass_m(shape.at(one), shape.at(two))[1]
    };
    assert!((jump.height_before_m - height(psi[at - 1])).abs() < 1e-12);
    assert!((jump.height_after_m - height(psi[at])).abs() < 1e-12);
    assert!(jump.height_after_m < jump.height_before_m);
}

#[test]
fn a_step_over_a_barrier_is_not_physical() {
    let (shape, run, mut psi) = jumping();
    let wrong = 150;
    assert!(
        !run.jumps.is_empty() && !outlying_steps(&psi).iter().any(|sample| sample.abs_diff(wrong) < 10),
        "no jump nearby"
    );
    psi[wrong..].iter_mut().for_each(|psi| *psi += 0.8);
    let found = detect_jumps(&shape, &run.log, &psi);
    let of_step = found.first().expect("the step is found");
    assert_eq!(of_step.sample, wrong);
    assert!(!of_step.physical && !of_step.predicted);
    assert_eq!((of_step.psi_before, of_step.psi_after), (psi[wrong - 1], psi[wrong]));
}

#[test]
fn an_early_step_is_physical_only_over_a_barrier_within_the_allowance() {
    let (shape, run, psi) = jumping();
    let (at, palms) = (first_after(&run), run.log.palms());
    let mut verdicts = Vec::new();
    for early in 1..8 {
        // The object is on its later branch of poses a few samples before the earlier one ends.
        let mut early_psi = psi.clone();
        for sample in (at - early..at).rev() {
            early_psi[sample] = followed(&shape, &palms[sample + 1], &palms[sample], early_psi[sample + 1]).0;
        }
        let sample = at - early;
        let landscape = EnergyLandscape::new(&shape, &palms[sample]);
        let (before, after) = (early_psi[sample - 1], early_psi[sample]);
        let heights = (0..=1000).map(|step| landscape.height_m(before + (after - before) * f64::from(step) / 1000.0));
        let barrier_m = heights.fold(f64::NEG_INFINITY, f64::max) - landscape.height_m(before);
        let Passage { jump, jumped, physical } = passage(&shape, &palms, (sample - 1, before), (sample, after));
        assert!(jumped && !jump.predicted && jump.physical == physical);
        assert_eq!(physical, barrier_m < BARRIER_ALLOWANCE * shape.mean_radius_m(), "{early} early, {barrier_m}");
        verdicts.push(physical);
    }
    assert!(verdicts.contains(&true) && verdicts.contains(&false), "{verdicts:?}");
}

/// The motion of an object that rings after its jump with these amplitudes, in alternating directions.
fn ringing(psi: &[f64], at: usize, amplitudes: &[f64]) -> Vec<f64> {
    let mut rings = psi.to_vec();
    for (number, (psi, amplitude)) in rings[at..].iter_mut().zip(amplitudes).enumerate() {
        *psi += if number % 2 == 0 { *amplitude } else { -amplitude };
    }
    rings
}

#[test]
fn a_jump_with_ringing_after_it_is_one_jump_from_the_rest_before_to_the_rest_after() {
    let (shape, run, psi) = jumping();
    let at = first_after(&run);
    let rings = ringing(&psi, at, &[0.3, 0.27, 0.24, 0.21, 0.18, 0.15, 0.12, 0.1]);
    let [jump] = detect_jumps(&shape, &run.log, &rings)[..] else { panic!("one jump") };
    assert!(jump.physical && jump.predicted);
    assert_eq!(jump.sample, at, "the longest step of the ringing");
    assert!(jump.psi_before < psi[at - 1] + 1e-9 && jump.psi_after != rings[at]);
    assert!((jump.psi_after - psi[at]).abs() < 0.1, "at rest again: {} {}", jump.psi_after, psi[at]);
}

#[test]
fn a_step_much_longer_than_the_jump_is_not_explained_as_its_ringing() {
    let (shape, run, psi) = jumping();
    let at = first_after(&run);
    let found = detect_jumps(&shape, &run.log, &ringing(&psi, at, &[1.5, 0.4, 0.3, 0.2, 0.1]));
    let first = found.first().expect("a jump");
    assert!((first.sample, first.physical) == (at, false), "{found:?}");
}

#[test]
fn no_step_longer_than_a_slide_is_part_of_it() {
    let slide = Passage { jump: jump(100, 1.0, 1.1, true), jumped: false, physical: true };
    assert!(slide.contains(0.1 + 0.9 * LONGEST_STEP) && !slide.contains(0.1 + 1.1 * LONGEST_STEP));
    let turned_over = std::f64::consts::TAU * 2.0 + 1.1;
    let unwrapped = Passage { jump: jump(100, 1.0, turned_over, true), ..slide };
    assert!(!unwrapped.contains(0.1 + 1.1 * LONGEST_STEP), "whole turns of an unwrapped motion are no slide");
    let ringing = Passage { jumped: true, ..slide };
    assert!(ringing.contains(0.1 + 1.1 * LONGEST_STEP), "about a jump it may swing");
}

#[test]
fn a_sample_that_is_elsewhere_during_a_slide_is_a_jump_that_statics_does_not_make() {
    let (shape, run, psi) = jumping();
    let jump = first_after(&run);
    let slide = |at: usize| (psi[at + 1] - psi[at - 1]).abs();
    let apart_from_jump = (1..psi.len() - 1).filter(|at| at.abs_diff(jump) > LONGEST_RINGING);
    let away = apart_from_jump.min_by(|a, b| slide(*a).total_cmp(&slide(*b))).expect("samples far from the jump");
    let mut there_and_back = psi.clone();
    there_and_back[away] += 0.3;
    let found = detect_jumps(&shape, &run.log, &there_and_back);
    assert!(found.iter().any(|jump| jump.sample == away && !jump.physical), "{found:?}");
}

#[test]
fn samples_that_are_half_a_turn_away_are_no_ringing_of_a_step_before_them() {
    let (shape, run, psi) = jumping();
    let at = first_after(&run);
    // A step that only the rest before and the rest after it explain, and a few samples later an excursion there and back, or once round.
    for back in [-3.1, 3.1] {
        let mut away = ringing(&psi, at, &[0.45, 0.4, 0.35, 0.3, 0.25, 0.2]);
        let (there, again) = (at + 8, at + 10);
        away[there..].iter_mut().for_each(|psi| *psi += 3.1);
        away[again..].iter_mut().for_each(|psi| *psi += back);
        let found = detect_jumps(&shape, &run.log, &away);
        assert!(found.iter().any(|jump| jump.sample == there && !jump.physical), "{back}: {found:?}");
    }
}

#[test]
fn an_object_swings_back_no_faster_than_its_fall_drives_it() {
    let (shape, run, _) = jumping();
    let fallen =
        DetectedJump { height_before_m: 0.012, height_after_m: 0.0, ..jump(first_after(&run), 0.0, 1.5, true) };
    let fastest = fallen.fastest_swing_rad_per_s(&shape);
    let k_m = LEAST_GYRATION * shape.uniform_gyration_radius_m();
    assert!((0.5 * (k_m * fastest).powi(2) / (STANDARD_GRAVITY_M_PER_S2 * 0.012) - 1.0).abs() < 1e-12);
    let furthest = |interval_s: f64| LONGEST_STEP + fastest * interval_s;
    for interval_s in [0.003, 0.03] {
        let back = |share: f64| [(1.5, interval_s), (-share * furthest(interval_s), interval_s), (0.1, interval_s)];
        assert!(fallen.swings_by(back(0.99), fastest) && !fallen.swings_by(back(1.01), fastest));
    }
    // Uphill there is nothing that drives it; and towards its end it goes at once.
    let risen = DetectedJump { height_after_m: 0.013, ..fallen };
    assert_eq!(risen.fastest_swing_rad_per_s(&shape), 0.0);
    assert!(risen.swings_by([(1.5, 0.001), (-0.9 * LONGEST_STEP, 0.03)], 0.0));
}

#[test]
fn jumps_are_in_the_order_of_their_samples_however_the_object_rings() {
    let hexagon = crate::shape::rounded_polygon(6, 0.3, 0.35).expect("possible").scaled(0.03).translated(0.004, 0.002);
    let motion = PalmMotion::random(6, 20.0, 1.0).and_then(|motion| motion.sample(25.0)).expect("possible");
    let run = simulate(&hexagon, &motion, &SimulateOptions::default()).expect("possible");
    let still: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let starts: Vec<usize> = detect_jumps(&hexagon, &run.log, &still).iter().map(|jump| jump.sample).collect();
    assert!(starts.len() > 3, "{starts:?}");
    for swing in [0.05, 0.1, 0.2, 0.4, 0.8] {
        for decay in [0.8, 0.9, 0.97] {
            let mut psi = still.clone();
            for &start in &starts {
                // From the second sample after the jump on, so that the jump itself is as statics has it.
                for (index, psi) in psi.iter_mut().enumerate().skip(start + 1).take(50) {
                    *psi += swing * f64::powi(-decay, (index - start) as i32);
                }
            }
            let jumps = detect_jumps(&hexagon, &run.log, &psi);
            let ordered = jumps.windows(2).all(|pair| pair[0].sample < pair[1].sample);
            let samples: Vec<usize> = jumps.iter().map(|jump| jump.sample).collect();
            assert!(ordered, "swing {swing}, decay {decay}: {samples:?}");
        }
    }
}
