//! How much of the boundary the palms felt.

use std::f64::consts::TAU;

use super::Simulation;
use crate::palms::PalmPair;

/// Steps that the circle of normal angles is divided into.
const BINS: usize = 720;

/// Fraction (0 to 1) of the boundary, in normal angle, that either palm went over in a simulation of `motion`, to 0.5°.
///
/// Jumps feel nothing: the way from one sample to the next counts only without a jump between them.
pub fn coverage(simulation: &Simulation, motion: &[(f64, PalmPair)]) -> f64 {
    let mut felt = vec![false; BINS];
    let mut mark = |from: f64, to: f64| {
        let bin = |theta: f64| (theta / TAU * BINS as f64).floor();
        let (low, high) = (bin(from.min(to)), bin(from.max(to)));
        let count = ((high - low) as usize).min(BINS);
        for step in 0..=count {
            felt[((low + step as f64).rem_euclid(BINS as f64) as usize).min(BINS - 1)] = true;
        }
    };
    let mut before: Option<(f64, (f64, f64))> = None;
    for ((time_s, palms), pose) in motion.iter().zip(&simulation.truth.motion) {
        let angles = palms.contact_angles(pose.psi_rad);
        let (from_s, from) = before.unwrap_or((*time_s, angles));
        if simulation.jumps.iter().any(|jump| jump.time_s >= from_s && jump.time_s <= *time_s) {
            mark(angles.0, angles.0);
            mark(angles.1, angles.1);
        } else {
            mark(from.0, angles.0);
            mark(from.1, angles.1);
        }
        before = Some((*time_s, angles));
    }
    felt.iter().filter(|felt| **felt).count() as f64 / BINS as f64
}
