//! Samples next to a leap of the contact whose readings do not tell on which side of it they are: an object tips over at an instant between two samples, and
//! the one before, or behind, may lie on both parts of the curve (r, d). Or samples at the end of a segment, that may be felt after a leap, or not. Such a
//! sample has no pose.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::math::angle::wrapped;
use crate::pivot::motion_prior::LEAP_RAD;
use crate::pivot::verdict::RIVAL_NATS;

/// Other places of a sample are looked for in steps of so much, radians.
const LOOK_RAD: f64 = 0.1;

/// Looks at most: a turn and a half.
const MOST_LOOKS: f64 = 100.0;

/// Samples on either side of a leap that are asked: an object tips over within one or two of them.
const MOST_OPEN: usize = 4;

/// A sample that may be elsewhere altogether is told where that costs so much more: less than any leap does, or each that ends a segment of a symmetric
/// object would be open.
const TOLD_NATS: f64 = 4.0;

/// Which samples of segments may as well be on the other side of a leap. `cost` is that of a sample at an angle, in nats, and the angle next to it that
/// costs least; `leap_nats` what a leap up to a sample costs.
pub(super) fn are_open(
    ranges: &[Range<usize>],
    theta_rad: &[f64],
    cost: &dyn Fn(usize, f64) -> (f64, f64),
    leap_nats: &dyn Fn(usize) -> f64,
) -> Vec<bool> {
    let mut open = vec![false; theta_rad.len()];
    for range in ranges {
        let mut asked: Vec<usize> = [range.start, range.end.saturating_sub(1)].to_vec();
        let is_leap = |&next: &usize| (theta_rad[next] - theta_rad[next - 1]).abs() > LEAP_RAD;
        for next in range.clone().skip(1).filter(is_leap) {
            asked.extend([next - 1, next]);
            let (before, after): (Vec<usize>, Vec<usize>) =
                ((range.start..next).rev().collect(), (next..range.end).collect());
            for (from, to) in [(&before, &after), (&after, &before)] {
                taken_over(from, to, theta_rad, cost).into_iter().for_each(|sample| open[sample] = true);
            }
        }
        for sample in asked.into_iter().filter(|sample| range.contains(sample)) {
            open[sample] |= may_be_elsewhere(sample, range, theta_rad, cost, leap_nats);
        }
    }
    open
}

/// Whether a sample of a segment may as well be anywhere else, with the leaps that it takes to be there.
fn may_be_elsewhere(
    sample: usize,
    range: &Range<usize>,
    theta_rad: &[f64],
    cost: &dyn Fn(usize, f64) -> (f64, f64),
    leap_nats: &dyn Fn(usize) -> f64,
) -> bool {
    let with_leaps = |(nats, angle_rad): (f64, f64)| {
        let leap = |other: usize, up_to: usize| {
            let is_leap = range.contains(&other) && wrapped(angle_rad - theta_rad[other]).abs() > LEAP_RAD;
            if is_leap { leap_nats(up_to) } else { 0.0 }
        };
        nats + leap(sample.wrapping_sub(1), sample) + leap(sample + 1, sample + 1)
    };
    let own_rad = theta_rad[sample];
    let own = with_leaps((cost(sample, own_rad).0, own_rad));
    let looks = (TAU / LOOK_RAD) as u32;
    let elsewhere = (1..looks).map(|look| cost(sample, own_rad + LOOK_RAD * f64::from(look)));
    elsewhere
        .filter(|(_, angle_rad)| wrapped(angle_rad - own_rad).abs() > LEAP_RAD)
        .any(|there| with_leaps(there) < own + TOLD_NATS)
}

/// The samples on one side of a leap, the next to it first, that may as well be on the other: where the contact would go on to, or anywhere on the way from
/// there, as an object may be felt while it tips over.
fn taken_over(
    other: &[usize],
    own: &[usize],
    theta_rad: &[f64],
    cost: &dyn Fn(usize, f64) -> (f64, f64),
) -> Vec<usize> {
    let Some(&nearest) = other.first() else { return Vec::new() };
    let mut last_rad = theta_rad[nearest];
    // The contact goes on as it came there, unless that was by a leap.
    let came_rad = other.get(1).map_or(0.0, |&second| last_rad - theta_rad[second]);
    let mut step_rad = if came_rad.abs() > LEAP_RAD { 0.0 } else { came_rad };
    let (mut taken, mut more) = (Vec::new(), 0.0);
    for &sample in own.iter().take(MOST_OPEN) {
        let (expected_rad, own_rad) = (last_rad + step_rad, theta_rad[sample]);
        let way_rad = own_rad - expected_rad;
        let looks = (way_rad.abs() / LOOK_RAD).ceil().clamp(1.0, MOST_LOOKS);
        let is_other = |(_, there_rad): &(f64, f64)| {
            let [low_rad, high_rad] = if way_rad > 0.0 { [expected_rad, own_rad] } else { [own_rad, expected_rad] };
            (low_rad - LEAP_RAD..high_rad + LEAP_RAD).contains(there_rad) && (there_rad - own_rad).abs() > LEAP_RAD
        };
        let found = (0..looks as usize).map(|look| cost(sample, expected_rad + way_rad * look as f64 / looks));
        let Some((there, there_rad)) = found.filter(is_other).min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        more += there - cost(sample, own_rad).0;
        if more > RIVAL_NATS {
            break;
        }
        taken.push(sample);
        (last_rad, step_rad) = (there_rad, there_rad - last_rad);
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A contact that rolls on, leaps by one radian after ten samples, and rolls on; what it costs to be on the other side for each of some samples.
    fn open(other_side_nats: &[(usize, f64)]) -> Vec<usize> {
        let theta_rad: Vec<f64> = (0..20).map(|at| 0.05 * at as f64 + if at < 10 { 0.0 } else { 1.0 }).collect();
        let cost = |sample: usize, angle_rad: f64| {
            let own_rad = theta_rad[sample];
            let nats = other_side_nats.iter().find(|(at, _)| *at == sample).map_or(100.0, |(_, nats)| *nats);
            let other_rad = if sample < 10 { own_rad + 1.0 } else { own_rad - 1.0 };
            if (angle_rad - own_rad).abs() < 0.5 { (0.0, own_rad) } else { (nats, other_rad) }
        };
        let open = are_open(std::slice::from_ref(&(0..20)), &theta_rad, &cost, &|_| 25.0);
        (0..20).filter(|&at| open[at]).collect()
    }

    #[test]
    fn a_sample_is_open_where_the_other_side_is_not_clearly_worse() {
        assert_eq!(open(&[(10, 0.99 * RIVAL_NATS)]), [10]);
        assert_eq!(open(&[(10, 1.01 * RIVAL_NATS)]), []);
        assert_eq!(open(&[(9, 0.0)]), [9]);
        // Together they are on the other side, or not at all.
        assert_eq!(open(&[(10, 0.6 * RIVAL_NATS), (11, 0.6 * RIVAL_NATS)]), [10]);
        assert_eq!(open(&[(11, 0.0)]), []);
    }

    #[test]
    fn few_samples_beside_a_leap_are_asked() {
        let all: Vec<(usize, f64)> = (10..20).map(|at| (at, 0.0)).collect();
        assert_eq!(open(&all), (10..10 + MOST_OPEN).collect::<Vec<usize>>());
    }

    #[test]
    fn steps_that_are_no_leaps_open_nothing() {
        let of = |step_rad: f64| {
            let theta_rad = [0.0, 0.0, step_rad, step_rad];
            are_open(std::slice::from_ref(&(0..4)), &theta_rad, &|_, angle| (0.0, angle), &|_| 25.0).contains(&true)
        };
        assert!(of(1.01 * LEAP_RAD) && !of(0.99 * LEAP_RAD));
        // Elsewhere than where the contact would go on to, or on the way from there, there is no other side.
        let only_at = |there_rad: f64| {
            let theta_rad = [0.0, 0.0, 1.0, 1.0];
            let cost = |at: usize, angle: f64| (0.0, if angle == theta_rad[at] { angle } else { there_rad });
            are_open(std::slice::from_ref(&(0..4)), &theta_rad, &cost, &|_| 25.0)[2]
        };
        assert!(only_at(-0.99 * LEAP_RAD) && only_at(0.5) && only_at(1.0 - 1.01 * LEAP_RAD));
        assert!(!only_at(-1.01 * LEAP_RAD) && !only_at(1.0 - 0.99 * LEAP_RAD) && !only_at(1.01 + LEAP_RAD));
    }

    #[test]
    fn the_end_of_a_segment_may_have_leapt() {
        // It fits half a radian on as well as where it is, or better by so much.
        let is_open = |better_nats: f64, leap_nats: f64| {
            let theta_rad = [0.0, 0.02, 0.04, 0.06];
            let cost = |at: usize, angle: f64| {
                let is_there = at == 3 && wrapped(angle - 0.56).abs() < 0.2;
                if is_there { (0.0, 0.56) } else { (if at == 3 { better_nats } else { 0.0 }, theta_rad[at]) }
            };
            are_open(std::slice::from_ref(&(0..4)), &theta_rad, &cost, &|_| leap_nats) == [false, false, false, true]
        };
        assert!(is_open(0.0, 0.99 * TOLD_NATS) && !is_open(0.0, 1.01 * TOLD_NATS));
        assert!(is_open(10.0, 0.99 * TOLD_NATS + 10.0) && !is_open(10.0, 1.01 * TOLD_NATS + 10.0));
    }
}
