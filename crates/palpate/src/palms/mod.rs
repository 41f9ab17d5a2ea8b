//! What feels: two palms, their frames, their contact angles and their motions.

mod motion;
mod pair;

pub use motion::{MotionError, PalmMotion, PalmMove, SMALLEST_OPENING_RAD};
pub use pair::{Palm, PalmPair};
