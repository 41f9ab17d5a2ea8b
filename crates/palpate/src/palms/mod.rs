//! What feels: two palms, their frames, their contacts and their motions.

mod contact_support;
mod curvature;
mod motion;
mod pair;

pub use contact_support::GeneralizedContactSupport;
pub use curvature::{ContactRates, radii_of_curvature_m};
pub use motion::{MotionError, PalmMotion, PalmMove, SMALLEST_OPENING_RAD};
pub use pair::{Palm, PalmPair};
pub(crate) use pair::{Sines, Stance};
