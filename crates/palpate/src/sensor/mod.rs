//! What a palm reports of its contacts, and what a camera sees of palms and object.

mod calibration;
mod touchpad;
mod vision;

pub use calibration::{Calibration, CalibrationRows};
pub use touchpad::{PadContact, PadReading, Touchpad};
pub use vision::VisionSystem;
