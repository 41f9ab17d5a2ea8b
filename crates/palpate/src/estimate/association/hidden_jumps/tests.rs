use super::*;
use crate::estimate::association::predictive::MotionMisfit;
use crate::estimate::association::simulated::{fitted, thrown_triangle, turned_pebble};
use crate::estimate::motion::LONGEST_STEP;
use crate::palms::PalmMotion;
use crate::shape::NamedShape;
use crate::simulate::{SimulateOptions, simulate};
use std::f64::consts::TAU;

#[test]
fn the_others_are_all_without_the_window() {
    let (measurements, fit) = turned_pebble();
    let of_others = OfOthers::new(&measurements, &fit);
    for window in [0..9, 90..118] {
        let mut others = measurements.clone();
        others.instants[window.clone()].iter_mut().for_each(|instant| instant.set_aside());
        let fitted = fit.at_optimum_of(&others);
        let alone = measurements.of(measurements.instants[window.clone()].to_vec());
        let present = &fit.estimate.psi[window];
        let cost = |predictive: &PredictiveShape, turned: f64| {
            let mut psi: Vec<f64> = present.iter().map(|psi| psi + turned).collect();
            let MotionMisfit { misfit, log_determinant } = predictive.misfit_of_motion(&alone.instants, &mut psi, 4);
            misfit + log_determinant
        };
        let predicted = of_others.without(&alone, present).expect("determined");
        let repeated = PredictiveShape::from(&others, &fitted).expect("determined");
        let (found, expected) = (cost(&predicted.sharp, 0.02), cost(&repeated, 0.02));
        assert!((found - expected).abs() < 0.02 * expected.abs() + 0.5, "{found} for {expected}");
    }
}

#[test]
fn from_a_motion_behind_a_hidden_jump_the_search_finds_the_true_one() {
    let (mut hidden, mut returned) = (0, 0);
    for seed in 0..6 {
        let Some((measurements, right, starts)) = thrown_triangle(seed) else { continue };
        let truth = &right.estimate.psi;
        for wrong in motions_with_hidden_jumps(&measurements, &right, &starts) {
            let there = fitted(&measurements, right.estimate.coefficients.clone(), wrong.psi.clone());
            let (first, last) = (wrong.samples[0], wrong.samples[wrong.samples.len() - 1]);
            let edge = if first == 0 || starts.contains(&first) { first } else { last };
            // One that the fit brings back is none.
            let is_away = |sample: &usize| !near(there.estimate.psi[*sample], truth[*sample], TAU);
            if wrong.samples.iter().all(is_away) && there.estimate.cost > right.estimate.cost {
                hidden += 1;
                let back = motions_with_hidden_jumps(&measurements, &there, &starts);
                returned += usize::from(back.iter().any(|motion| near(motion.psi[edge], truth[edge], TAU)));
            }
        }
    }
    // 33 of 35 in twelve such logs.
    assert!(hidden >= 10 && returned * 5 >= hidden * 4, "{returned} of {hidden}");
}

#[test]
fn windows_lie_at_both_ends_of_every_segment() {
    let found = windows(&[20], 100);
    let edges: Vec<usize> = found.iter().map(|(edge, _)| *edge).collect();
    assert_eq!(edges, [0, 19, 20, 99]);
    assert_eq!(found[0].1, [0..6, 0..7, 0..9, 0..12, 0..16]);
    assert_eq!(found[1].1, [14..20, 13..20, 11..20, 8..20, 4..20]);
    assert_eq!(found[3].1.last(), Some(&(62..100)));
    // No window is a whole segment: that would be another jump, and not one more.
    assert!(windows(&[6], 13)[0].1.is_empty() && windows(&[7], 13)[0].1.len() == 1);
}

#[test]
fn a_motion_is_carried_on_to_the_jump_that_ends_it_and_no_further() {
    let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
    let motion = PalmMotion::random(2, 30.0, 1.0).and_then(|motion| motion.sample(20.0)).expect("possible");
    let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
    let measurements = Measurements::new(&run.log, None);
    let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let jump = truth.windows(2).position(|step| (step[1] - step[0]).abs() > 0.2).expect("a jump") + 1;
    let carried_to =
        |end: usize, segment_end: usize| carried_on(&measurements, &shape, &truth[..end], end..segment_end);
    let found = carried_to(6, truth.len()).expect("a jump ends it");
    assert_eq!(found.len(), jump);
    assert!(found.iter().zip(&truth).all(|(found, truth)| (found - truth).abs() < 1e-6));
    // Where it ends with the window, or the segment does before, there is nothing to carry on.
    assert!(carried_to(jump, truth.len()).is_none() && carried_to(6, jump).is_none());
}

#[test]
fn a_short_segment_from_which_no_jump_leads_on_goes_with_what_is_behind_it() {
    let step = LONGEST_STEP;
    let psi = |jump: f64| [vec![0.0; 5], vec![jump; 20]].concat();
    assert_eq!(segment_before(&[5], 5, &psi(0.99 * step), TAU), 0);
    assert_eq!(segment_before(&[5], 5, &psi(1.01 * step), TAU), 5);
    // One that is a window itself does not.
    assert_eq!(segment_before(&[6], 6, &[0.0; 20], TAU), 6);
    assert_eq!((segment_before(&[], 0, &[0.0; 20], TAU), segment_before(&[3, 8], 8, &[0.0; 20], TAU)), (0, 3));
}
