//! Palms so fast that the object's own inertia counts: the forces on it while it moves, and where they carry it.

mod moment;
mod motion;
mod moving_palms;

pub(crate) use moment::{Inertia, InertialMoment, radii_of_curvature_in_motion_m};
pub(crate) use motion::{InertialPursuit, LostContact};
pub(crate) use moving_palms::MovingPalms;
