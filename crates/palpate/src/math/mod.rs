//! Geometry that knows nothing of palms and objects: rigid motions of the plane, and the one that carries points onto points.

mod rigid_motion;

pub use rigid_motion::{RigidMotion, procrustes, procrustes_rotation_rad};
