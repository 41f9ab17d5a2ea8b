//! Pieces of a motion that lie on boundary of their own together. An object that goes to and fro between two poses comes back to each again and again:
//! its pieces share boundary with those at the same pose and with no others, and nothing but the smoothness of the shape tells how the two lie to
//! each other. They turn against the rest together or not at all ([`super::relative_rotation`]).

use crate::estimate::association::part::Part;
use crate::estimate::coverage::{NODES, touches};
use crate::estimate::measurements::Measurements;
use crate::estimate::motion::segments_between;
use std::f64::consts::TAU;
use std::ops::Range;

/// Two pieces that both felt this much of the boundary, on both palms together, tell how they lie to each other, radians: radius and contact offset
/// agree over all of it at one rotation only.
const SHARED_RAD: f64 = 0.2;

/// Groups of the pieces between `jumps` that share boundary with each other and with no other piece, where others lie between them. None where all
/// pieces are one group. Poses that differ by a multiple of `period` are one.
pub(crate) fn groups(measurements: &Measurements, psi: &[f64], jumps: &[usize], period: f64) -> Vec<Part> {
    let (pieces, felt) = pieces(measurements, psi, jumps, period);
    let mut group: Vec<usize> = (0..pieces.len()).collect();
    for one in 0..pieces.len() {
        for other in 0..one {
            if group[one] != group[other] && share(&felt[one], &felt[other]) {
                let (kept, joined) = (group[other], group[one]);
                group.iter_mut().filter(|of| **of == joined).for_each(|of| *of = kept);
            }
        }
    }
    let members = |of: usize| pieces.iter().zip(&group).filter(move |(_, group)| **group == of).map(|(piece, _)| piece);
    (0..pieces.len()).map(|of| Part::of(members(of))).filter(|group| group.ranges().len() > 1).collect()
}

/// Pieces between `jumps` that share boundary with no other.
pub(crate) fn alone(measurements: &Measurements, psi: &[f64], jumps: &[usize]) -> Vec<Range<usize>> {
    let (pieces, felt) = pieces(measurements, psi, jumps, TAU);
    let is_alone = |one: usize| (0..felt.len()).all(|other| one == other || !share(&felt[one], &felt[other]));
    pieces.iter().enumerate().filter(|(one, _)| is_alone(*one)).map(|(_, piece)| piece.clone()).collect()
}

/// The pieces between jumps, and what each felt.
fn pieces(
    measurements: &Measurements,
    psi: &[f64],
    jumps: &[usize],
    period: f64,
) -> (Vec<Range<usize>>, Vec<Vec<bool>>) {
    let of = |piece: Range<usize>| (piece.clone(), felt(measurements, psi, piece, period));
    segments_between(jumps, psi.len()).map(of).unzip()
}

/// Which of the nodes of the boundary a piece felt; those that a period apart are one.
fn felt(measurements: &Measurements, psi: &[f64], piece: Range<usize>, period: f64) -> Vec<bool> {
    let angles = piece.map(|index| measurements.instants[index].contact_angles(psi[index]));
    let (first, second) = angles.unzip();
    let counts = touches(&[first, second]);
    let of_period = ((NODES as f64 * period / TAU).round() as usize).clamp(1, NODES);
    let mut felt = vec![false; of_period];
    counts.iter().enumerate().filter(|(_, count)| **count > 0).for_each(|(node, _)| felt[node % of_period] = true);
    felt
}

fn share(a: &[bool], b: &[bool]) -> bool {
    let common = a.iter().zip(b).filter(|(a, b)| **a && **b).count();
    common as f64 * TAU / NODES as f64 >= SHARED_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::{Log, Sample};
    use crate::palms::PalmPair;

    fn groups(measurements: &Measurements, psi: &[f64], jumps: &[usize], period: f64) -> Vec<Vec<Range<usize>>> {
        super::groups(measurements, psi, jumps, period).iter().map(|part| part.ranges().to_vec()).collect()
    }

    /// Contacts of an object that turns by 0.3 between palms at rest, piece by piece from these orientations on.
    fn turning_from(starts: &[f64]) -> (Measurements, Vec<f64>, Vec<usize>) {
        const LENGTH: usize = 31;
        let psi: Vec<f64> =
            starts.iter().flat_map(|start| (0..LENGTH).map(move |index| start + 0.01 * index as f64)).collect();
        let samples = (0..psi.len()).map(|index| Sample {
            time_s: index as f64,
            palms: PalmPair::hinged(0.8, 1.5),
            s1_m: Some(0.03),
            s2_m: Some(0.03),
            s1_sd_m: None,
            s2_sd_m: None,
            force1_n: None,
            force2_n: None,
        });
        let log = Log { samples: samples.collect() };
        (Measurements::new(&log, None), psi, (1..starts.len()).map(|piece| piece * LENGTH).collect())
    }

    #[test]
    fn pieces_at_two_poses_in_turn_are_two_groups() {
        let (measurements, psi, jumps) = turning_from(&[0.0, 2.5, 0.05, 2.55, 5.0]);
        assert_eq!(groups(&measurements, &psi, &jumps, TAU), [vec![0..31, 62..93], vec![31..62, 93..124]]);
        // Half a turn of a symmetric object is no other pose.
        let (measurements, psi, jumps) = turning_from(&[0.0, 0.9, 0.5 * TAU, 0.5 * TAU + 0.9]);
        assert_eq!(groups(&measurements, &psi, &jumps, TAU), Vec::<Vec<_>>::new());
        assert_eq!(groups(&measurements, &psi, &jumps, 0.5 * TAU), [vec![0..31, 62..93], vec![31..62, 93..124]]);
    }

    #[test]
    fn a_piece_that_shares_with_none_is_alone() {
        let (measurements, psi, jumps) = turning_from(&[0.0, 2.5, 0.05, 5.0]);
        assert_eq!(alone(&measurements, &psi, &jumps), [31..62, 93..124]);
    }

    #[test]
    fn pieces_share_boundary_from_some_degrees_on() {
        // On each palm half of it.
        let apart = |common: f64| {
            let (measurements, psi, jumps) = turning_from(&[0.0, 3.0, 0.3 - 0.5 * common]);
            groups(&measurements, &psi, &jumps, TAU).is_empty()
        };
        assert!(apart(SHARED_RAD - 0.05) && !apart(SHARED_RAD + 0.05));
    }

    #[test]
    fn what_hangs_together_is_one_group() {
        let (measurements, psi, jumps) = turning_from(&[0.0, 0.05, 0.1]);
        assert!(groups(&measurements, &psi, &jumps, TAU).is_empty());
        assert!(groups(&measurements, &psi, &[], TAU).is_empty());
        // Through a third piece.
        let (measurements, psi, jumps) = turning_from(&[0.0, 3.0, 0.1, 0.18, 3.0]);
        assert_eq!(groups(&measurements, &psi, &jumps, TAU), [vec![0..31, 62..124], vec![31..62, 124..155]]);
        assert!(alone(&measurements, &psi, &jumps).is_empty());
        // What has none of the others between is a part without being a group.
        let (measurements, psi, jumps) = turning_from(&[0.0, 3.0, 3.1]);
        assert!(groups(&measurements, &psi, &jumps, TAU).is_empty());
    }
}
