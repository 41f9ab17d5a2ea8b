//! What feels: two palms, their frames, their contacts and their motions.

mod contact_constraint;
mod curvature;
mod generalized_contact_support;
mod motion;
mod pair;

pub(crate) use contact_constraint::{ContactRow, Contacts, PalmAngles, contact_angles};
pub use curvature::{ContactRates, radii_of_curvature_m};
pub use generalized_contact_support::GeneralizedContactSupport;
pub use motion::{MotionError, PalmMotion, PalmMove, SMALLEST_OPENING_RAD};
pub(crate) use pair::Stance;
pub use pair::{Palm, PalmPair};
