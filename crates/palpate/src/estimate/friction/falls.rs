//! Jumps of an object on which friction acts, and whether it may have fallen so.
//!
//! Friction takes energy and gives none, and slow palms give none within a jump: on the way the centre of mass rises nowhere above where it was.
//! Where the object comes to rest depends on its inertia, since friction may hold it at any pose that it comes by.

use crate::estimate::jumps::{BARRIER_ALLOWANCE, DetectedJump};
use crate::mechanics::EnergyLandscape;
use crate::mechanics::passage::barrier_m;
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
    starts.iter().filter(|&&sample| sample > 0 && sample < psi.len()).map(fall).collect()
}
