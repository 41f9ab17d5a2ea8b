//! The forces on the object: what they ask of its pose at each instant, and where they carry it.
//!
//! `force_model` says what the estimator asks of a model of the forces; a folder beside it is the physics of one. `frictionless`: slow palms
//! without friction, between which the object rests at a minimum of its potential energy. `coulomb`: slow palms with friction, between which
//! it rolls, slides and jumps. `inertial`: palms so fast that the object's own inertia counts.

pub(crate) mod coulomb;
pub(crate) mod force_model;
pub(crate) mod frictionless;
mod gravity;
pub(crate) mod inertial;
mod jump;
pub(crate) mod passage;

pub use coulomb::ContactMode;
pub use frictionless::{EnergyLandscape, RestPose, contact_forces_n, follow};
pub use gravity::STANDARD_GRAVITY_M_PER_S2;
pub use jump::Jump;

/// The model of the forces that the estimator is built with. The solver takes any model as a type parameter; what looks at one sample
/// at a time (residuals, transitions, jumps) takes this one.
pub(crate) type Forces = frictionless::Frictionless;
