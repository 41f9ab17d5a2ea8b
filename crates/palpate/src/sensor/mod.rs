//! What a palm reports of its contacts, and what a camera sees of palms and object.

pub(crate) mod calibration;
mod calibration_constant;
mod contact_sensor;
pub(crate) mod rig;
mod touchpad;
mod vision;

pub use calibration::{Calibration, CalibrationRows};
pub use calibration_constant::CalibrationConstant;
pub use contact_sensor::{ContactReading, ContactSensor, PalmContact};
pub use rig::{Rig, Tolerances};
pub use touchpad::{PadContact, PadReading, Touchpad};
pub use vision::VisionSystem;
