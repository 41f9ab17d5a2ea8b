//! Which parts of the boundary were felt, and how often.

use crate::estimate::measurements::Measurements;
use crate::estimate::motion::{outlying_steps, short_segments, unwrap};
use std::f64::consts::TAU;

/// Number of equally spaced normal angles at which the boundary is reported.
pub(crate) const NODES: usize = 720;

/// Reversals of a contact by less than this do not begin a new pass, radians (noise moves a resting contact to and fro).
const HYSTERESIS: f64 = 0.02;

/// More turns than this in one pass are counted as this many.
const MOST_TURNS: i64 = 1000;

/// For each of [`NODES`] normal angles, how many separate passes of a contact went over it. `tracks` are the contact
/// angles of one contact over one piece of the motion each, unwrapped.
pub(crate) fn touches(tracks: &[Vec<f64>]) -> Vec<u32> {
    let mut counts = vec![0; NODES];
    for track in tracks {
        for (low, high) in passes(track) {
            let step = TAU / NODES as f64;
            // A pass reaches half a node further than its ends.
            let first = ((low / step) - 0.5).ceil() as i64;
            let last = ((high / step) + 0.5).floor() as i64;
            for node in first..=last.min(first + MOST_TURNS * NODES as i64) {
                counts[node.rem_euclid(NODES as i64) as usize] += 1;
            }
        }
    }
    counts
}

/// The monotone stretches of a track, as (lowest, highest) angle.
fn passes(track: &[f64]) -> Vec<(f64, f64)> {
    let Some(&first) = track.first() else { return Vec::new() };
    let mut passes = Vec::new();
    let (mut low, mut high) = (first, first);
    let mut direction = 0.0;
    let mut turning = first;
    for &theta in track {
        if direction == 0.0 {
            low = low.min(theta);
            high = high.max(theta);
            if high - low > HYSTERESIS {
                direction = if theta == high { 1.0 } else { -1.0 };
                turning = if direction > 0.0 { low } else { high };
            }
        } else if direction > 0.0 {
            high = high.max(theta);
            if theta < high - HYSTERESIS {
                passes.push((turning, high));
                (direction, turning, low) = (-1.0, high, theta);
            }
        } else {
            low = low.min(theta);
            if theta > low + HYSTERESIS {
                passes.push((low, turning));
                (direction, turning, high) = (1.0, low, theta);
            }
        }
    }
    passes.push(match direction {
        d if d > 0.0 => (turning, high),
        d if d < 0.0 => (low, turning),
        _ => (low, high),
    });
    passes
}

/// The contact angles of each contact over each piece, where it was seen. Pieces too short to be placed with certainty
/// feel nothing, and a long step of ψ feels nothing in between.
pub(crate) fn tracks(measurements: &Measurements, angles: &[(f64, f64)], starts: &[usize]) -> Vec<Vec<f64>> {
    let brief = short_segments(starts, angles.len());
    let mut tracks = Vec::new();
    for contact in [1, 2] {
        let mut track: Vec<f64> = Vec::new();
        for (index, instant) in measurements.instants.iter().enumerate() {
            let (theta, weight) =
                if contact == 1 { (angles[index].0, instant.weight1) } else { (angles[index].1, instant.weight2) };
            let broken = track.last().is_some_and(|last| (theta - last).abs() > LONGEST_SLIDE);
            if broken || starts.contains(&index) {
                tracks.push(std::mem::take(&mut track));
            }
            if weight > 0.0 && !brief.iter().any(|piece| piece.contains(&index)) {
                track.push(theta);
            }
        }
        tracks.push(track);
    }
    tracks
}

/// The outline nodes that a motion feels.
pub(crate) fn felt_nodes(measurements: &Measurements, psi: &[f64]) -> impl Iterator<Item = usize> + use<> {
    let mut unwrapped = psi.to_vec();
    unwrap(&mut unwrapped);
    let starts = outlying_steps(&unwrapped);
    let angles: Vec<(f64, f64)> =
        measurements.instants.iter().zip(&unwrapped).map(|(instant, psi)| instant.contact_angles(*psi)).collect();
    let counts = touches(&tracks(measurements, &angles, &starts));
    (0..NODES).filter(move |&node| counts[node] > 0)
}

/// A contact that moves further than this between two samples did not feel what lies between, radians.
pub(crate) const LONGEST_SLIDE: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_to_and_fro_counts_twice_and_jitter_does_not_count() {
        let mut track: Vec<f64> = (0..=100).map(|i| i as f64 * 0.01 + 0.004 * ((i % 2) as f64)).collect();
        let back: Vec<f64> = track.iter().rev().copied().collect();
        assert_eq!(touches(&[track.clone()])[57], 1);
        track.extend(back);
        let counts = touches(&[track]);
        assert_eq!(counts[57], 2);
        assert_eq!(counts[300], 0);
    }

    #[test]
    fn each_turn_is_a_pass() {
        let track: Vec<f64> = (0..2000).map(|i| i as f64 * 0.01).collect();
        let counts = touches(&[track]);
        assert!(counts.iter().all(|&count| count == 3 || count == 4));
        // Each end reaches half a node further.
        let expected = 19.99 / TAU * NODES as f64 + 1.0;
        assert!((f64::from(counts.iter().sum::<u32>()) - expected).abs() <= 1.0);
    }
}
