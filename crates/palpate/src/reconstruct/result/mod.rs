//! The result of a reconstruction as plain data, its pruning by touches, and what the readings themselves say of the contacts.

pub(crate) mod calibration;
pub(crate) mod diagnostics;
pub(crate) mod friction;
pub(crate) mod inertia;
pub(crate) mod measured_forces;
mod prune;
pub(crate) mod reconstruction;
pub(crate) mod strip;
