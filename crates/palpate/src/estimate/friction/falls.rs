//! Jumps of an object on which friction acts, and whether it may have fallen so.
//!
//! Friction takes energy and gives none, and slow palms give none within a jump: on the way the centre of mass rises nowhere above where it was.
//! Where the object comes to rest depends on its inertia, since friction may hold it at any pose that it comes by.

use crate::estimate::jumps::{BARRIER_ALLOWANCE, DetectedJump};
use crate::estimate::motion::LONGEST_STEP;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::passage::{barrier_m, is_same_pose};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::TAU;

/// The jumps that end at the samples `starts`, of an object with this support function about its centre of mass.
pub(crate) fn falls(shape: &SupportFunction, palms: &[PalmPair], psi: &[f64], starts: &[usize]) -> Vec<DetectedJump> {
    let allowance_m = BARRIER_ALLOWANCE * shape.mean_radius_m();
    let fall = |&sample: &usize| {
        let landscape = EnergyLandscape::new(shape, &palms[sample]);
        let height = |psi: f64| landscape.height_m(psi);
        let (before, after) = (psi[sample - 1], psi[sample]);
        // Orientations are known up to whole turns.
        let other_way = after - (TAU).copysign(after - before);
        let physical = [after, other_way].into_iter().any(|to| barrier_m(height, before, to) <= allowance_m);
        DetectedJump {
            sample,
            psi_before: before,
            psi_after: after,
            height_before_m: height(before),
            height_after_m: height(after),
            physical,
            predicted: false,
        }
    };
    // A pose that was lost and found again where it was is no jump, and a step that no palms make is one.
    let jumps = |sample: &usize| {
        let started = starts.contains(sample) && !is_same_pose(psi[*sample - 1], psi[*sample]);
        started || (psi[*sample] - psi[*sample - 1]).abs() > LONGEST_STEP
    };
    (1..psi.len()).filter(jumps).map(|sample| fall(&sample)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::NamedShape;

    /// A stone between palms at rest, and where it rests stably.
    fn resting() -> (SupportFunction, Vec<PalmPair>, Vec<f64>) {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let palms = PalmPair::hinged(0.8, 1.3);
        let stable = EnergyLandscape::new(&shape, &palms).stable_poses().iter().map(|pose| pose.psi_rad).collect();
        (shape, vec![palms; 2], stable)
    }

    #[test]
    fn an_object_falls_to_lower_poses_and_to_none_behind_a_crest() {
        let (shape, palms, stable) = resting();
        let bottom = stable[0];
        let fall = |from: f64, to: f64| falls(&shape, &palms, &[from, to], &[1]);
        // Down, perhaps not all the way.
        for share in [0.5, 1.0] {
            assert!(fall(bottom + 0.3, bottom + 0.3 * (1.0 - share))[0].physical, "{share}");
        }
        assert!(!fall(bottom, bottom + 0.3)[0].physical);
        // Both ways round lead over the highest pose of all.
        let landscape = EnergyLandscape::new(&shape, &palms[0]);
        let opposite = (0..63)
            .map(|i| 0.1 * f64::from(i))
            .max_by(|a, b| landscape.height_m(*a).total_cmp(&landscape.height_m(*b)));
        assert!(!fall(bottom, opposite.expect("poses"))[0].physical);
    }

    #[test]
    fn what_is_found_again_where_it_was_has_not_jumped() {
        let (shape, palms, stable) = resting();
        assert!(falls(&shape, &palms, &[stable[0], stable[0] + 0.05], &[1]).is_empty());
        assert_eq!(falls(&shape, &palms, &[stable[0] + 0.1, stable[0]], &[1])[0].sample, 1);
        // Whether it was thought to jump or not.
        let turned = |turn: f64| falls(&shape, &palms, &[stable[0] + turn, stable[0]], &[]).len();
        assert_eq!((turned(0.99 * LONGEST_STEP), turned(1.01 * LONGEST_STEP)), (0, 1));
    }
}
