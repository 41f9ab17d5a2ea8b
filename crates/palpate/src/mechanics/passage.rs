//! Would the forces carry the object from one pose to another? The one place that says so: for each step of the decoding of the motion, and
//! for each jump that the certificate looks at.

use std::f64::consts::PI;

use crate::math::angle::wrapped;
use crate::mechanics::force_model::ForceModel;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;

/// Orientations closer than this are one pose, radians: errors of the shape move a pose by a few degrees where it is hardly stable.
pub(crate) const SAME_POSE_RAD: f64 = 0.06;

/// Orientations at which the height of the centre of mass is looked at for a barrier by half a turn: 3.75 degrees apart.
const BARRIER_STEPS: f64 = 48.0;

/// Whether two orientations are one pose, up to whole turns.
pub(crate) fn is_same_pose(a: f64, b: f64) -> bool {
    wrapped(a - b).abs() < SAME_POSE_RAD
}

/// How far the centre of mass would have to rise on the way from one orientation to another, metres; `height` is its height at an
/// orientation.
pub(crate) fn barrier_m(height: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    top_of_barrier(height, from, to).1
}

/// The highest orientation on that way, and how far the centre of mass would have to rise.
pub(crate) fn top_of_barrier(height: impl Fn(f64) -> f64, from: f64, to: f64) -> (f64, f64) {
    let steps = ((to - from).abs() / PI * BARRIER_STEPS).ceil().max(2.0);
    let start = height(from);
    (1..=steps as u32).fold((from, 0.0), |top, step| {
        let psi = from + (to - from) * f64::from(step) / steps;
        let rise = height(psi) - start;
        if rise > top.1 { (psi, rise) } else { top }
    })
}

/// Where the forces carry an object whose pose is `psi` while the palms move from one pair to the next, one after the other; and whether
/// it jumps on the way.
pub(crate) fn carried<F: ForceModel>(forces: &F, shape: &SupportFunction, palms: &[PalmPair], psi: f64) -> (f64, bool) {
    let mut jumped = false;
    let mut end = psi;
    for pair in palms.windows(2) {
        let (next, jumps) = forces.advance(shape, &pair[0], &pair[1], end);
        jumped |= !jumps.is_empty();
        end = next;
    }
    (end, jumped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::EnergyLandscape;
    use crate::mechanics::frictionless::Frictionless;
    use crate::shape::NamedShape;

    #[test]
    fn poses_are_one_up_to_the_limit_and_up_to_whole_turns() {
        assert!(is_same_pose(1.0, 1.0 + 0.99 * SAME_POSE_RAD + 2.0 * PI));
        assert!(!is_same_pose(1.0, 1.0 + 1.01 * SAME_POSE_RAD));
    }

    #[test]
    fn the_barrier_of_a_wave_is_its_crest_over_the_start() {
        let height = |psi: f64| -0.01 * psi.cos();
        // From the trough over the crest to the next trough, and on the slope down, where there is none.
        assert!((barrier_m(height, 0.0, 2.0 * PI) - 0.02).abs() < 1e-5);
        assert!((barrier_m(height, 0.0, -2.0 * PI) - 0.02).abs() < 1e-5);
        assert_eq!(barrier_m(height, 3.0, 0.5), 0.0);
        assert_eq!(barrier_m(height, 0.7, 0.7), 0.0);
    }

    #[test]
    fn a_resting_object_is_carried_along_and_jumps_where_its_pose_vanishes() {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let palms: Vec<PalmPair> = (0..200).map(|i| PalmPair::hinged(0.2 + 0.01 * f64::from(i), 1.0)).collect();
        let start = EnergyLandscape::new(&shape, &palms[0]).stable_poses()[0].psi_rad;
        let (end, jumped) = carried(&Frictionless, &shape, &palms[..100], start);
        let last = EnergyLandscape::new(&shape, &palms[99]);
        assert!(last.balance_m(end).abs() < 1e-12 && last.balance_slope_m(end) > 0.0);
        let (_, jumped_later) = carried(&Frictionless, &shape, &palms, start);
        assert!(jumped || jumped_later, "palms that turn by 115 degrees leave no pose as it is");
        assert_eq!(carried(&Frictionless, &shape, &palms[..1], 0.4), (0.4, false));
    }
}
