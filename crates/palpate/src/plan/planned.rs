//! A planned motion: a path over the surface of stable poses, timed, and tried in simulation before it is handed out.

use std::f64::consts::TAU;

use super::limits::PalmLimits;
use super::surface::Place;
use super::timing::{smoothed, subdivided, timed};
use crate::mechanics::EnergyLandscape;
use crate::palms::PalmMotion;
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;
use crate::simulate::{SimulateOptions, coverage, simulate};

/// Samples that a planned motion is checked with.
const CHECKS: f64 = 1500.0;

/// A motion without jumps, for the object it was planned for.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedMotion {
    /// The motion.
    pub motion: PalmMotion,
    /// Let the object go at this orientation (radians) before the motion starts.
    pub start_psi_rad: f64,
    /// Fraction of the boundary that is felt, 0 to 1.
    pub coverage: f64,
    /// Whether the object turns all the way around.
    pub full_turn: bool,
}

/// The path as a smooth motion that holds in simulation; smoothed as much as it bears.
pub(super) fn realised(
    shape: &SupportFunction,
    limits: &PalmLimits,
    path: &[Place],
    duration_s: f64,
) -> Option<PlannedMotion> {
    let (first, last) = (path.first()?, path.last()?);
    // At last along the straight edges that were proved to hold, only the corners cut a little.
    let rounded = [4, 3, 2, 1].into_iter().map(|width| smoothed(path, width));
    rounded.chain([smoothed(&subdivided(path), 1), subdivided(path)]).find_map(|path| {
        let motion = timed(&path, duration_s)?;
        let planned = checked(shape, motion, first.psi, limits.palm_length_m)?;
        // Without a jump, but not where it was to go: another path.
        let turned = planned.end_psi_rad - planned.motion.start_psi_rad;
        ((turned - (last.psi - first.psi)).abs() < 0.5).then_some(planned.motion)
    })
}

/// A motion that holds, and where the object is at its end.
pub(super) struct Checked {
    pub(super) motion: PlannedMotion,
    end_psi_rad: f64,
}

/// The motion with what it feels, if the object follows it without a jump.
pub(super) fn checked(
    shape: &SupportFunction,
    motion: PalmMotion,
    start_psi_rad: f64,
    palm_length_m: f64,
) -> Option<Checked> {
    let path = motion.sample(CHECKS / motion.duration_s()).ok()?;
    let start_psi_rad = EnergyLandscape::new(shape, &path.first()?.1).descend(start_psi_rad);
    let touchpad = Touchpad { length_m: palm_length_m, ..Touchpad::ideal() };
    let options = SimulateOptions { start_psi_rad, touchpad, ..SimulateOptions::default() };
    let simulation = simulate(shape, &path, &options).ok()?;
    let coverage = coverage(&simulation, &path);
    let end_psi_rad = simulation.truth.motion.last()?.psi_rad;
    let full_turn = (end_psi_rad - start_psi_rad).abs() >= TAU - 1e-6;
    let planned = PlannedMotion { motion, start_psi_rad, coverage, full_turn };
    simulation.jumps.is_empty().then_some(Checked { motion: planned, end_psi_rad })
}
