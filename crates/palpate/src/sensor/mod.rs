//! What a palm reports of its contacts.

mod touchpad;

pub use touchpad::{PadContact, PadReading, Touchpad};
