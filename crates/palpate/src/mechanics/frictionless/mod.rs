//! Slow palms without friction (section 3 of Moll & Erdmann 2001): force/torque balance ([`balance`]), the potential energy and its
//! minima ([`landscape`]), how a resting pose moves with the palms and where it jumps to ([`fold`]), and the normal forces ([`weight`]).

mod balance;
mod fold;
mod landscape;
mod weight;

pub(crate) use balance::Frictionless;
pub use fold::follow;
pub(crate) use fold::{Pursuit, followed};
pub use landscape::{EnergyLandscape, RestPose};
pub use weight::contact_forces_n;
pub(crate) use weight::forces_between_n;
