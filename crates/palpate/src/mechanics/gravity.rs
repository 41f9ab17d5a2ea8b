//! The acceleration of free fall.

/// Standard acceleration of free fall, metres per second squared.
pub const STANDARD_GRAVITY_M_PER_S2: f64 = 9.80665;
