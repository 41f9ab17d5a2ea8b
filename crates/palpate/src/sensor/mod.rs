//! What a palm reports of its contacts, and what a camera sees of palms and object.

mod touchpad;
mod vision;

pub use touchpad::{PadContact, PadReading, Touchpad};
pub use vision::VisionSystem;
