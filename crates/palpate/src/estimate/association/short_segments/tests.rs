use super::*;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::SHORT_SEGMENT;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother, StoppingCriteria};
use crate::plan::{PalmLimits, plan_turn};
use crate::sensor::Touchpad;
use crate::shape::NamedShape;
use crate::simulate::{SimulateOptions, simulate};
use std::ops::Range;

const SIZE_M: f64 = 0.03;

#[test]
fn a_piece_is_brief_below_the_limit_and_not_at_it() {
    assert_eq!(short_segments(&[20, 20 + SHORT_SEGMENT], 40), Vec::<Range<usize>>::new());
    assert_eq!(short_segments(&[20, 20 + SHORT_SEGMENT - 1], 40), std::slice::from_ref(&(20..20 + SHORT_SEGMENT - 1)));
    // The first and the last piece as well.
    assert_eq!(
        short_segments(&[SHORT_SEGMENT - 1, 40 - SHORT_SEGMENT], 40),
        std::slice::from_ref(&(0..SHORT_SEGMENT - 1))
    );
    assert_eq!(
        short_segments(&[SHORT_SEGMENT, 40 - SHORT_SEGMENT + 1], 40),
        std::slice::from_ref(&(40 - SHORT_SEGMENT + 1..40))
    );
}

#[test]
fn a_log_without_a_jump_has_no_brief_pieces_however_short_it_is() {
    assert_eq!(short_segments(&[], SHORT_SEGMENT - 1), Vec::<Range<usize>>::new());
    assert_eq!(short_segments(&[], 0), Vec::<Range<usize>>::new());
}

#[test]
fn a_start_at_an_end_of_the_log_makes_an_empty_piece() {
    assert_eq!(short_segments(&[0], 40), std::slice::from_ref(&(0..0)));
    assert_eq!(short_segments(&[40], 40), std::slice::from_ref(&(40..40)));
}

/// A pebble turned around over some 200 samples with a little noise, and the optimum near the truth.
fn setting() -> (Measurements, Fit) {
    let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a valid size");
    let plan = plan_turn(&pebble, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let options = SimulateOptions {
        start_psi_rad: plan.start_psi_rad,
        touchpad: Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() },
        ..SimulateOptions::default()
    };
    let run = simulate(&pebble, &plan.motion.sample(5.0).expect("possible"), &options).expect("possible");
    let measurements = Measurements::new(&run.log, None);
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let (noise, prior) = (Noise { sensor_m: 1e-4, balance_m: 2e-5 }, Prior { size_m: SIZE_M, scale_m: 0.5 * SIZE_M });
    let order = pebble.harmonics_m().len();
    let effort = StoppingCriteria { iterations: 20, tolerance: 1e-7 };
    let Estimate { coefficients, psi, cost } =
        Smoother::new(&measurements, order, noise, prior).run(pebble.coefficients(), psi, effort);
    (measurements, Fit { estimate: Estimate { coefficients, psi, cost }, order, noise, prior, log_evidence: 0.0 })
}

fn no_doubts(measurements: &Measurements) -> Ambiguity {
    Ambiguity::new(vec![f64::INFINITY; measurements.len()])
}

/// A brief piece over which the object hardly turns.
fn calm_piece(fit: &Fit) -> Range<usize> {
    let turned = |start: &usize| (fit.estimate.psi[start + SHORT_SEGMENT - 1] - fit.estimate.psi[*start]).abs();
    let start = (50..150).min_by(|a, b| turned(a).total_cmp(&turned(b))).expect("samples");
    start..start + SHORT_SEGMENT - 1
}

/// Samples that are doubted.
fn doubted(doubts: &Ambiguity) -> Vec<usize> {
    doubts
        .ambiguity_rad()
        .iter()
        .enumerate()
        .filter(|(_, ambiguity_rad)| **ambiguity_rad > 0.0)
        .map(|(sample, _)| sample)
        .collect()
}

#[test]
fn a_brief_piece_that_is_placed_well_is_not_doubted() {
    let (measurements, fit) = setting();
    let mut doubts = no_doubts(&measurements);
    let alternatives = reassociated(&measurements, &fit, &[100, 100 + SHORT_SEGMENT - 1], &mut doubts);
    assert!(alternatives.is_empty());
    assert_eq!(doubted(&doubts), Vec::<usize>::new());
}

#[test]
fn a_brief_piece_at_a_wrong_pose_is_doubted_and_the_true_pose_is_a_rival() {
    let (measurements, mut fit) = setting();
    let (truth, piece) = (fit.estimate.psi.clone(), calm_piece(&fit));
    fit.estimate.psi[piece.clone()].iter_mut().for_each(|psi| *psi += 1.5);
    let mut doubts = no_doubts(&measurements);
    let alternatives = reassociated(&measurements, &fit, &[piece.start, piece.end], &mut doubts);
    assert_eq!(doubted(&doubts), piece.clone().collect::<Vec<_>>());
    let first = alternatives.first().expect("another pose");
    assert_eq!(first.samples, piece.clone().collect::<Vec<_>>());
    for (sample, (psi, truth)) in first.psi.iter().zip(&truth).enumerate() {
        let close = if piece.contains(&sample) { wrapped(psi - truth).abs() < 0.02 } else { psi == truth };
        assert!(close, "{psi} {truth} at {sample}");
    }
    assert!(alternatives.iter().all(|alternative| alternative.motion_cost == 0.0));
}

#[test]
fn the_samples_of_a_brief_piece_do_not_vouch_for_their_own_pose() {
    let (mut measurements, fit) = setting();
    let piece = calm_piece(&fit);
    // All other samples say nothing, so that nothing is known of the shape.
    let others = (0..measurements.len()).filter(|sample| !piece.contains(sample));
    others.for_each(|sample| measurements.instants[sample].set_aside());
    let mut doubts = no_doubts(&measurements);
    reassociated(&measurements, &fit, &[piece.start, piece.end], &mut doubts);
    assert_eq!(doubted(&doubts), piece.collect::<Vec<_>>());
}

#[test]
fn a_long_piece_at_a_wrong_pose_is_not_asked_about() {
    let (measurements, mut fit) = setting();
    fit.estimate.psi[100..100 + SHORT_SEGMENT].iter_mut().for_each(|psi| *psi += 1.5);
    let mut doubts = no_doubts(&measurements);
    assert!(reassociated(&measurements, &fit, &[100, 100 + SHORT_SEGMENT], &mut doubts).is_empty());
    assert_eq!(doubted(&doubts), Vec::<usize>::new());
}

#[test]
fn with_too_many_samples_in_brief_pieces_all_of_them_are_doubted_and_none_has_a_rival() {
    let (measurements, fit) = setting();
    let each = SHORT_SEGMENT - 1;
    assert_eq!(MOST % each, 0, "brief pieces of the longest kind come to the limit");
    // All pieces lie side by side, the first at 100.
    let starts = |pieces: usize| (0..=pieces).map(|piece| 100 + each * piece).collect::<Vec<_>>();
    let mut doubts = no_doubts(&measurements);
    reassociated(&measurements, &fit, &starts(MOST / each), &mut doubts);
    assert!(doubted(&doubts).len() < MOST / 2, "{:?}", doubted(&doubts));
    let mut starts = starts(MOST / each);
    let end = starts[starts.len() - 1];
    starts.push(end + 1);
    let mut doubts = no_doubts(&measurements);
    assert!(reassociated(&measurements, &fit, &starts, &mut doubts).is_empty());
    assert_eq!(doubted(&doubts), (100..100 + MOST + 1).collect::<Vec<_>>());
}
