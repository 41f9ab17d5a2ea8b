use super::*;
use crate::estimate::association::simulated::turned_pebble;
use crate::estimate::motion::SHORT_SEGMENT;
use crate::math::angle::wrapped;
use std::ops::Range;

#[test]
fn a_segment_is_short_below_the_limit_and_not_at_it() {
    assert_eq!(short_segments(&[20, 20 + SHORT_SEGMENT], 40), Vec::<Range<usize>>::new());
    assert_eq!(short_segments(&[20, 20 + SHORT_SEGMENT - 1], 40), std::slice::from_ref(&(20..20 + SHORT_SEGMENT - 1)));
    // The first and the last segment as well.
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
fn a_log_without_a_jump_has_no_short_segments_however_short_it_is() {
    assert_eq!(short_segments(&[], SHORT_SEGMENT - 1), Vec::<Range<usize>>::new());
    assert_eq!(short_segments(&[], 0), Vec::<Range<usize>>::new());
}

#[test]
fn a_start_at_an_end_of_the_log_makes_an_empty_segment() {
    assert_eq!(short_segments(&[0], 40), std::slice::from_ref(&(0..0)));
    assert_eq!(short_segments(&[40], 40), std::slice::from_ref(&(40..40)));
}

fn unambiguous(measurements: &Measurements) -> Ambiguity {
    Ambiguity::new(vec![f64::INFINITY; measurements.len()])
}

/// A short segment over which the object hardly turns.
fn slow_segment(fit: &Fit) -> Range<usize> {
    let turned = |start: &usize| (fit.estimate.psi[start + SHORT_SEGMENT - 1] - fit.estimate.psi[*start]).abs();
    let start = (50..150).min_by(|a, b| turned(a).total_cmp(&turned(b))).expect("samples");
    start..start + SHORT_SEGMENT - 1
}

/// Samples that are ambiguous.
fn ambiguous(ambiguity: &Ambiguity) -> Vec<usize> {
    ambiguity
        .ambiguity_rad()
        .iter()
        .enumerate()
        .filter(|(_, ambiguity_rad)| **ambiguity_rad > 0.0)
        .map(|(sample, _)| sample)
        .collect()
}

#[test]
fn a_short_segment_at_its_true_pose_is_unambiguous() {
    let (measurements, fit) = turned_pebble();
    let mut ambiguity = unambiguous(&measurements);
    let alternatives = reassociated(&measurements, &fit, &[100, 100 + SHORT_SEGMENT - 1], &mut ambiguity);
    assert!(alternatives.is_empty());
    assert_eq!(ambiguous(&ambiguity), Vec::<usize>::new());
}

#[test]
fn a_short_segment_at_a_wrong_pose_is_ambiguous_and_the_true_pose_is_an_alternative() {
    let (measurements, mut fit) = turned_pebble();
    let (truth, segment) = (fit.estimate.psi.clone(), slow_segment(&fit));
    fit.estimate.psi[segment.clone()].iter_mut().for_each(|psi| *psi += 1.5);
    let mut ambiguity = unambiguous(&measurements);
    let alternatives = reassociated(&measurements, &fit, &[segment.start, segment.end], &mut ambiguity);
    assert_eq!(ambiguous(&ambiguity), segment.clone().collect::<Vec<_>>());
    let first = alternatives.first().expect("another pose");
    assert_eq!(first.samples, segment.clone().collect::<Vec<_>>());
    for (sample, (psi, truth)) in first.psi.iter().zip(&truth).enumerate() {
        let close = if segment.contains(&sample) { wrapped(psi - truth).abs() < 0.02 } else { psi == truth };
        assert!(close, "{psi} {truth} at {sample}");
    }
    // They are weighed with the jumps that they make.
    assert!(alternatives.iter().all(|alternative| alternative.motion_cost.is_none()));
}

#[test]
fn the_samples_of_a_short_segment_do_not_support_their_own_pose() {
    let (mut measurements, fit) = turned_pebble();
    let segment = slow_segment(&fit);
    // All other samples have no weight, so that there is no predictive shape.
    let others = (0..measurements.len()).filter(|sample| !segment.contains(sample));
    others.for_each(|sample| measurements.instants[sample].set_aside());
    let mut ambiguity = unambiguous(&measurements);
    reassociated(&measurements, &fit, &[segment.start, segment.end], &mut ambiguity);
    assert_eq!(ambiguous(&ambiguity), segment.collect::<Vec<_>>());
}

#[test]
fn a_long_segment_at_a_wrong_pose_is_not_tested() {
    let (measurements, mut fit) = turned_pebble();
    fit.estimate.psi[100..100 + SHORT_SEGMENT].iter_mut().for_each(|psi| *psi += 1.5);
    let mut ambiguity = unambiguous(&measurements);
    assert!(reassociated(&measurements, &fit, &[100, 100 + SHORT_SEGMENT], &mut ambiguity).is_empty());
    assert_eq!(ambiguous(&ambiguity), Vec::<usize>::new());
}

#[test]
fn with_too_many_samples_in_short_segments_all_are_ambiguous_and_none_has_an_alternative() {
    let (measurements, fit) = turned_pebble();
    let each = SHORT_SEGMENT - 1;
    assert_eq!(MOST_SAMPLES % each, 0, "short segments of the longest kind reach the limit exactly");
    // All segments are adjacent, the first at sample 100.
    let starts = |segments: usize| (0..=segments).map(|segment| 100 + each * segment).collect::<Vec<_>>();
    let mut ambiguity = unambiguous(&measurements);
    reassociated(&measurements, &fit, &starts(MOST_SAMPLES / each), &mut ambiguity);
    assert!(ambiguous(&ambiguity).len() < MOST_SAMPLES / 2, "{:?}", ambiguous(&ambiguity));
    let mut starts = starts(MOST_SAMPLES / each);
    let end = starts[starts.len() - 1];
    starts.push(end + 1);
    let mut ambiguity = unambiguous(&measurements);
    assert!(reassociated(&measurements, &fit, &starts, &mut ambiguity).is_empty());
    assert_eq!(ambiguous(&ambiguity), (100..100 + MOST_SAMPLES + 1).collect::<Vec<_>>());
}

#[test]
fn a_piece_is_open_where_every_sample_of_it_is_out_of_balance() {
    let (mut measurements, fit) = turned_pebble();
    let opened = |measurements: &Measurements, starts: &[usize]| {
        let mut ambiguity = unambiguous(measurements);
        open_out_of_balance(measurements, &fit, starts, &mut ambiguity);
        ambiguous(&ambiguity)
    };
    let piece = 0..SHORT_SEGMENT;
    for instant in &mut measurements.instants[piece.clone()] {
        instant.balance_weight = balance_weight(OUT_OF_BALANCE_SDS + 0.1);
    }
    assert_eq!(opened(&measurements, &[SHORT_SEGMENT, 40]), piece.collect::<Vec<_>>());
    // Not where it is shorter, or longer than they are, or one sample is in balance.
    assert!(opened(&measurements, &[SHORT_SEGMENT - 1, 40]).is_empty());
    assert!(opened(&measurements, &[SHORT_SEGMENT + 1, 40]).is_empty());
    measurements.instants[3].balance_weight = balance_weight(OUT_OF_BALANCE_SDS - 0.1);
    assert!(opened(&measurements, &[SHORT_SEGMENT, 40]).is_empty());
}

#[test]
fn a_sample_beside_a_jump_that_is_out_of_balance_is_open_where_its_contacts_do_not_tell_its_pose() {
    let (measurements, fit) = turned_pebble();
    let sample = 100;
    let opened = |start: usize, sds: f64, sensor_m: f64| {
        let (mut measurements, mut fit) = (measurements.clone(), fit.clone());
        measurements.instants[sample].balance_weight = balance_weight(sds);
        fit.noise.sensor_m = sensor_m;
        let mut ambiguity = unambiguous(&measurements);
        open_out_of_balance(&measurements, &fit, &[start], &mut ambiguity);
        assert!(ambiguity.ambiguity_rad()[sample] < std::f64::consts::PI);
        ambiguous(&ambiguity)
    };
    // A sensor of a tenth of the size reads a pebble the same way round or another.
    let [out, coarse_m] = [OUT_OF_BALANCE_SDS + 0.1, 3e-3];
    for start in [sample, sample + 1] {
        assert_eq!(opened(start, out, coarse_m), [sample]);
        assert!(opened(start, OUT_OF_BALANCE_SDS - 0.1, coarse_m).is_empty());
        assert!(opened(start, out, fit.noise.sensor_m).is_empty());
    }
    assert!(opened(sample - 1, out, coarse_m).is_empty() && opened(sample + 2, out, coarse_m).is_empty());
}
