//! Where the object rests: potential energy, balance, stability and jumps.

mod branch;
mod landscape;
mod weight;

pub use branch::{Jump, follow};
pub(crate) use branch::{Pursuit, followed};
pub use landscape::{EnergyLandscape, RestPose};
pub(crate) use weight::forces_between_n;
pub use weight::{STANDARD_GRAVITY_M_PER_S2, contact_forces_n};
