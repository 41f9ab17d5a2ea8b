//! A symmetric object has copies of every pose, a period of its symmetry apart, and contacts cannot tell them from each other. What can is
//! statics: from sample to sample the object goes on in its pose, or jumps downhill to the next one. That is one motion of those that
//! explain the log alike, and the one that is reported.

use crate::estimate::association::transitions::{is_same_pose, near, turn};
use crate::mechanics::passage::{barrier_m, carried};
use crate::mechanics::{EnergyLandscape, Forces};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::{PI, TAU};

/// Barriers that differ by less than this share of the mean radius count as alike; the nearer copy is taken then.
const ALIKE: f64 = 1e-3;

/// The motion with each pose replaced by the copy of it that statics leads to from the one before.
pub(crate) fn carried_copies(shape: &SupportFunction, palms: &[PalmPair], psi: &[f64], period: f64) -> Vec<f64> {
    let Some(&first) = psi.first() else { return Vec::new() };
    let mut motion = Vec::with_capacity(psi.len());
    motion.push(first);
    let mut here = first;
    for (index, &next) in psi.iter().enumerate().skip(1) {
        here += if near(here, next, period) {
            turn(here, next, period)
        } else {
            jump(shape, &palms[index - 1..=index], here, next, period)
        };
        motion.push(here);
    }
    motion
}

/// The turn of a jump from `here` to a copy of `next`.
fn jump(shape: &SupportFunction, palms: &[PalmPair], here: f64, next: f64, period: f64) -> f64 {
    let (end, _) = carried(&Forces::default(), shape, palms, here);
    if is_same_pose(end, next, period) {
        return end + turn(end, next, period) - here;
    }
    // Errors of the shape keep the object where it was: over the lowest barrier, and to the nearest copy behind it.
    let landscape = EnergyLandscape::new(shape, &palms[palms.len() - 1]);
    let shortest = turn(here, next, period);
    let copies = (TAU / period).round() as i64;
    let mut turns: Vec<f64> =
        (-copies..=copies).map(|copy| shortest + copy as f64 * period).filter(|turn| turn.abs() <= PI).collect();
    turns.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let barrier = |turn: f64| barrier_m(|psi| landscape.height_m(psi), here, here + turn);
    let lowest = turns.iter().map(|&turn| barrier(turn)).fold(f64::INFINITY, f64::min);
    let allowed = lowest + ALIKE * shape.mean_radius_m();
    turns.into_iter().find(|&turn| barrier(turn) <= allowed).unwrap_or(shortest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::shape::rounded_polygon;
    use crate::simulate::{SimulateOptions, simulate};

    #[test]
    fn the_copies_of_a_simulated_motion_are_the_motion_itself() {
        let mut jumps = 0;
        for (corners, seed) in [(2, 1), (3, 2), (3, 5), (4, 3), (4, 7)] {
            let shape = rounded_polygon(corners, 0.3, 0.35).expect("possible").scaled(0.03);
            let motion = PalmMotion::random(seed, 20.0, 1.0).and_then(|motion| motion.sample(50.0)).expect("possible");
            let Ok(run) = simulate(&shape, &motion, &SimulateOptions::default()) else { continue };
            let palms = run.log.palms();
            let truth: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
            let period = TAU / f64::from(corners);
            // Every pose at some other of its copies.
            let anywhere: Vec<f64> =
                truth.iter().enumerate().map(|(index, psi)| psi + period * ((7 * index % 5) as f64 - 2.0)).collect();
            let motion = carried_copies(&shape, &palms, &anywhere, period);
            let offset = motion[0] - truth[0];
            for (found, real) in motion.iter().zip(&truth) {
                assert!(turn(found - offset, *real, TAU).abs() < 1e-6, "{corners} corners, seed {seed}");
            }
            jumps += run.jumps.len();
        }
        assert!(jumps > 3, "{jumps}");
    }
}
