use std::f64::consts::TAU;

use super::*;
use crate::reconstruct::{OutlinePoint, Pose};
use crate::shape::{NamedShape, RandomShape, random_shape};
use crate::truth::TruePose;

const SIZE_M: f64 = 0.03;

fn truth_of(shape: &SupportFunction, psi: &[f64]) -> Truth {
    let support = (0..720).map(|i| TAU * f64::from(i) / 720.0).map(|theta| (theta, shape.at(theta).r)).collect();
    let motion = psi
        .iter()
        .enumerate()
        .map(|(i, &psi_rad)| TruePose { time_s: i as f64, psi_rad, com_x_m: 0.01 * i as f64, com_y_m: 0.05 })
        .collect();
    Truth { support, motion }
}

/// A perfect reconstruction of `shape` as seen in its own frame.
fn found(shape: &SupportFunction, psi: &[f64], felt: impl Fn(f64) -> bool) -> Reconstruction {
    let outline = (0..720).map(|i| TAU * f64::from(i) / 720.0).map(|theta| {
        let (contact, point) = (shape.at(theta), shape.boundary_point(theta));
        OutlinePoint {
            theta_rad: theta,
            r_m: contact.r,
            r_sd_m: 0.0,
            x_m: point.x_m,
            y_m: point.y_m,
            curvature_radius_m: contact.v,
            touches: u32::from(felt(theta)),
        }
    });
    let motion = psi.iter().enumerate().map(|(i, &psi_rad)| Pose {
        com_x_m: 0.01 * i as f64,
        com_y_m: 0.05,
        ..Pose::of_test(i as f64, psi_rad)
    });
    Reconstruction {
        shape: shape.clone(),
        outline: outline.collect(),
        motion: motion.collect(),
        verdict: crate::reconstruct::Verdict::default(),
        findings: None,
        chi2_per_dof: 1.0,
        jumps: Vec::new(),
        coverage: 1.0,
        symmetry: crate::reconstruct::FoundSymmetry::default(),
        alternatives: 1,
        others: Vec::new(),
        sensor_sd_m: 0.0,
        balance_sd_m: 0.0,
        calibration: None,
        friction: None,
        inertia: None,
    }
}

fn pebble(seed: u64) -> SupportFunction {
    random_shape(&RandomShape { mean_radius_m: SIZE_M, ..RandomShape::default() }, seed).expect("a valid kind")
}

#[test]
fn a_turned_copy_has_no_error() {
    let psi: Vec<f64> = (0..50).map(|i| 0.3 + 0.2 * f64::from(i)).collect();
    for (seed, turn) in [(1, 0.3), (2, -2.0), (3, 3.1)] {
        let truth = truth_of(&pebble(seed), &psi);
        let own: Vec<f64> = psi.iter().map(|psi| psi - turn).collect();
        // θ = φ₁ − ψ − π/2: a frame turned by −turn sees every normal at θ + turn.
        let error = compare(&found(&pebble(seed).rotated(turn), &own, |_| true), &truth).expect("comparable");
        // A least-squares rotation found by its value is good to the root of the rounding.
        assert!(error.rms_r_m < 1e-9 * SIZE_M && error.rms_form_m < 1e-9 * SIZE_M, "{error:?}");
        assert!(error.hausdorff_m < 1e-5 * SIZE_M && error.rms_psi_rad < 1e-12 && error.rms_com_m == 0.0, "{error:?}");
    }
}

#[test]
fn a_known_error_of_form_is_measured() {
    let psi = [0.0, 0.1, 0.2];
    let shape = NamedShape::Egg.shape(SIZE_M).expect("a valid size");
    // A fifth harmonic of amplitude e has an RMS of e/√2, no rotation or translation takes it out (the egg has none).
    let bump = 1e-5;
    let mut harmonics = shape.harmonics_m().to_vec();
    harmonics.resize(5, [0.0; 2]);
    harmonics[4][1] += bump;
    let changed = SupportFunction::new(shape.mean_radius_m(), harmonics);
    let error = compare(&found(&changed, &psi, |_| true), &truth_of(&shape, &psi)).expect("comparable");
    assert!((error.rms_r_m / (bump / 2f64.sqrt()) - 1.0).abs() < 1e-3, "{error:?}");
    assert!((error.rms_form_m / (bump / 2f64.sqrt()) - 1.0).abs() < 1e-3, "{error:?}");
    // Along the normal the outlines are up to `bump` apart.
    assert!((error.hausdorff_m / bump - 1.0).abs() < 0.05, "{error:?}");
}

#[test]
fn a_misplaced_centre_of_mass_is_not_an_error_of_form() {
    let psi = [0.0, 0.4, 0.9];
    let shape = pebble(5);
    let (x, y) = (3e-4, -4e-4);
    let error = compare(&found(&shape.translated(x, y), &psi, |_| true), &truth_of(&shape, &psi)).expect("comparable");
    assert!(error.rms_form_m < 1e-8 * SIZE_M, "{error:?}");
    assert!(error.rms_r_m > 0.5 * x.hypot(y) / 2f64.sqrt() && error.rms_r_m <= x.hypot(y) / 2f64.sqrt(), "{error:?}");
}

#[test]
fn only_felt_points_count() {
    let psi = [0.0, 0.4, 0.9];
    let shape = pebble(6);
    let mut result = found(&shape, &psi, |theta| theta < 4.0);
    for point in &mut result.outline {
        if point.touches == 0 {
            point.r_m += 0.01;
        }
    }
    let error = compare(&result, &truth_of(&shape, &psi)).expect("comparable");
    assert!(error.rms_r_m < 1e-9 * SIZE_M, "{error:?}");
}

#[test]
fn errors_of_motion_are_measured_and_whole_turns_are_not() {
    let psi: Vec<f64> = (0..100).map(|i| 0.05 * f64::from(i)).collect();
    let shape = pebble(7);
    let mut result = found(&shape, &psi, |_| true);
    for (i, pose) in result.motion.iter_mut().enumerate() {
        pose.psi_rad += if i % 2 == 0 { 0.01 } else { -0.01 + TAU };
        pose.com_x_m += 3e-4;
        pose.com_y_m -= 4e-4;
    }
    let error = compare(&result, &truth_of(&shape, &psi)).expect("comparable");
    assert!((error.rms_psi_rad - 0.01).abs() < 1e-9 && (error.rms_com_m - 5e-4).abs() < 1e-12, "{error:?}");
}

#[test]
fn an_ellipse_half_a_turn_off_has_no_error_of_form() {
    // The centred ellipse looks the same after half a turn: the rotation near that of the motion is as good as any.
    let psi = [0.0, 0.1, 0.2];
    let shape = crate::shape::ellipse(0.035, 0.025).expect("valid axes");
    let turned: Vec<f64> = psi.iter().map(|psi| psi + 3.0).collect();
    let error = compare(&found(&shape, &turned, |_| true), &truth_of(&shape, &psi)).expect("comparable");
    assert!(error.rms_r_m < 1e-9 * SIZE_M && error.rms_psi_rad < 1e-12, "{error:?}");
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let shape = pebble(8);
    let result = found(&shape, &[0.0, 0.1], |_| true);
    let other = compare(&result, &truth_of(&shape, &[0.0]));
    assert_eq!(other, Err(CompareError::OtherLog { truth: 1, reconstruction: 2 }));
    let unfelt = found(&shape, &[0.0], |_| false);
    assert_eq!(compare(&unfelt, &truth_of(&shape, &[0.0])), Err(CompareError::Nothing));
    let empty = Truth { support: Vec::new(), ..truth_of(&shape, &[0.0, 0.1]) };
    assert!(matches!(compare(&result, &empty), Err(CompareError::TrueShape(_))));
}
