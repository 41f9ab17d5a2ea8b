//! Palms so fast that the object's own inertia counts: the forces on it while it moves, and where they carry it.

mod moment;

pub(crate) use moment::{Inertia, InertialMoment};
