use super::*;
use crate::estimate::association::predictive::MotionMisfit;
use crate::estimate::association::simulated::{fitted, thrown_triangle, turned_pebble};
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
