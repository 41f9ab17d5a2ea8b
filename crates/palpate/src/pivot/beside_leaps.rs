//! Samples next to a leap of the contact whose readings do not tell on which side of it they are: an object tips over at an instant between two samples, and
//! the one before, or behind, may lie on both parts of the curve (r, d). Such a sample has no pose.

use std::ops::Range;

use crate::pivot::verdict::RIVAL_NATS;

/// Longer steps from one sample to the next are leaps, radians; the other side of one is where the contact would go on to, this far off at most, ...
const LEAP_RAD: f64 = 0.15;

/// ... or so many of the step by which it came: an object that is about to tip over turns faster and faster.
const FASTER_TIMES: f64 = 2.0;

/// Samples on either side of a leap that are asked: an object tips over within one or two of them.
const MOST_OPEN: usize = 4;

/// Which samples of segments may as well be on the other side of a leap. `cost` is that of a sample at an angle, in nats, and the angle next to it that
/// costs least.
pub(super) fn are_open(
    ranges: &[Range<usize>],
    theta_rad: &[f64],
    cost: &dyn Fn(usize, f64) -> (f64, f64),
) -> Vec<bool> {
    let mut open = vec![false; theta_rad.len()];
    for range in ranges {
        let is_leap = |&next: &usize| (theta_rad[next] - theta_rad[next - 1]).abs() > LEAP_RAD;
        for next in range.clone().skip(1).filter(is_leap) {
            let (before, after): (Vec<usize>, Vec<usize>) =
                ((range.start..next).rev().collect(), (next..range.end).collect());
            for (from, to) in [(&before, &after), (&after, &before)] {
                taken_over(from, to, theta_rad, cost).into_iter().for_each(|sample| open[sample] = true);
            }
        }
    }
    open
}

/// The samples on one side of a leap, the next to it first, that may as well be on the other.
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
        let expected_rad = last_rad + step_rad;
        let (there, there_rad) = cost(sample, expected_rad);
        more += there - cost(sample, theta_rad[sample]).0;
        let is_itself = (there_rad - theta_rad[sample]).abs() < LEAP_RAD;
        let reach_rad = LEAP_RAD.max(FASTER_TIMES * step_rad.abs());
        if is_itself || (there_rad - expected_rad).abs() > reach_rad || more > RIVAL_NATS {
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
            let is_other = (angle_rad - theta_rad[sample]).abs() > 0.5;
            let nats = other_side_nats.iter().find(|(at, _)| *at == sample).map_or(100.0, |(_, nats)| *nats);
            (if is_other { nats } else { 0.0 }, angle_rad)
        };
        let open = are_open(std::slice::from_ref(&(0..20)), &theta_rad, &cost);
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
            are_open(std::slice::from_ref(&(0..4)), &theta_rad, &|_, angle| (0.0, angle)).contains(&true)
        };
        assert!(of(1.01 * LEAP_RAD) && !of(0.99 * LEAP_RAD));
        // Elsewhere than where the contact would go on to there is no other side.
        let off = |off_rad: f64, step_rad: f64| {
            let theta_rad = [-step_rad, 0.0, 1.0, 1.0];
            let cost = |at: usize, angle: f64| (0.0, if angle == theta_rad[at] { angle } else { angle + off_rad });
            are_open(std::slice::from_ref(&(0..4)), &theta_rad, &cost).contains(&true)
        };
        assert!(off(0.99 * LEAP_RAD, 0.0) && !off(1.01 * LEAP_RAD, 0.0));
        // Unless it came there fast, and goes on faster.
        assert!(off(0.99 * FASTER_TIMES * 0.1, 0.1) && !off(1.01 * FASTER_TIMES * 0.1, 0.1));
    }
}
