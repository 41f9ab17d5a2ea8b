//! The jump of an object from one resting pose to another ("a discrete change in orientation", section 6 of Moll & Erdmann 2001).

use crate::palms::PalmPair;

/// A pose vanished and the object went downhill to another, at practically one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When, as a fraction (0 to 1) of the movement that was followed.
    pub fraction: f64,
    /// Palms at that instant.
    pub palms: PalmPair,
    /// Orientation before, radians.
    pub psi_before_rad: f64,
    /// Orientation after, radians, unwrapped: the difference says which way the object turned.
    pub psi_after_rad: f64,
    /// Height of the centre of mass before, metres.
    pub height_before_m: f64,
    /// Height of the centre of mass after, metres; always lower.
    pub height_after_m: f64,
}
