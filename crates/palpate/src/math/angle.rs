//! Angles up to whole turns, in radians.

use std::f64::consts::{PI, TAU};

/// The same angle in [−π, π).
pub(crate) fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// The same angle up to multiples of `period`, in [−period/2, period/2).
pub(crate) fn wrapped_to(angle: f64, period: f64) -> f64 {
    (angle + 0.5 * period).rem_euclid(period) - 0.5 * period
}

/// The direction in which most angles point: that of the sum of their unit vectors; 0 for none.
pub(crate) fn mean_direction(angles: impl IntoIterator<Item = f64>) -> f64 {
    let (sin, cos) = angles.into_iter().fold((0.0, 0.0), |(s, c), angle| (s + angle.sin(), c + angle.cos()));
    f64::atan2(sin, cos)
}
