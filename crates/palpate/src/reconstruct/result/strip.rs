//! What each sample alone leaves to the centre of mass under friction: a strip across the object (`docs/theory.md`, friction; Moll & Erdmann
//! section 5 for the line that it is without friction).
//!
//! The lines of the two contact forces meet above or below the centre of mass. As the forces turn within their cones the point where they meet
//! moves, so that the centre of mass lies in a strip that is upright in the world and turns with the object in its own frame. Where the object slides on
//! both palms both directions are known and the strip is a line.

use crate::log::{Log, Sample};
use crate::mechanics::ContactMode;
use crate::mechanics::coulomb::{at_the_edges, moment, opening};
use crate::palms::Contacts;
use crate::reconstruct::result::reconstruction::{Pose, Reconstruction};

/// Where one sample leaves the centre of mass, to the right of where it was found, metres: along (cos ψ, −sin ψ) in the frame of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CenterStrip {
    /// The left edge.
    pub low_m: f64,
    /// The right edge; equal to the left one where both contacts slide.
    pub high_m: f64,
}

/// The strip of every sample, in the order of the log; `None` where the object jams between the palms, so that any place will do, and everywhere
/// without friction.
pub fn center_strips(log: &Log, result: &Reconstruction) -> Vec<Option<CenterStrip>> {
    let Some(friction) = result.friction else { return vec![None; result.motion.len()] };
    let corrected = result.calibration.as_ref().map(|of_rig| of_rig.calibration.corrected(log));
    let samples = &corrected.as_ref().unwrap_or(log).samples;
    let of = |(i, pose): (usize, &Pose)| strip(samples.get(i)?, pose, result, friction.coefficients);
    result.motion.iter().enumerate().map(of).collect()
}

fn strip(sample: &Sample, pose: &Pose, result: &Reconstruction, friction: [f64; 2]) -> Option<CenterStrip> {
    let angles = sample.palms.angles();
    let at = Contacts::from([result.shape.at(pose.theta1_rad), result.shape.at(pose.theta2_rad)]);
    // A contact that sticks, or of which nothing is known, bears a force anywhere within its cone.
    let [first, second] = pose.modes.unwrap_or([ContactMode::Stick; 2]).map(|mode| match mode {
        ContactMode::Stick => [-1.0, 1.0],
        slides => [slides.slip_sign(); 2],
    });
    let mut strip = CenterStrip { low_m: f64::INFINITY, high_m: f64::NEG_INFINITY };
    // Along one edge of the box of both ratios the place is a quotient of linear functions: its extremes are at the corners.
    for signs in first.into_iter().flat_map(|one| second.map(|other| [one, other])) {
        let tau = at_the_edges(friction, signs);
        let opening = opening(&angles, tau);
        if opening <= 0.0 {
            return None;
        }
        let right_m = moment(&angles, &at, tau) / opening;
        strip = CenterStrip { low_m: strip.low_m.min(right_m), high_m: strip.high_m.max(right_m) };
    }
    (strip.low_m.is_finite() && strip.high_m.is_finite()).then_some(strip)
}
