//! Symmetry of an object, of its shape and of its centre of mass: it is its own image when turned by part of a circle, or in a
//! mirror. About the centre of mass r(θ) then has no harmonics but the multiples of the order, and, in the frame of its mirror,
//! no sines.

use std::f64::consts::TAU;
use std::fmt;

/// How an object is symmetric.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Symmetry {
    /// The object is its own image when turned by 2π/`order`; 1 where it is not.
    pub order: u32,
    /// It is its own mirror image.
    pub mirror: bool,
}

impl Symmetry {
    /// None at all.
    pub const NONE: Self = Self { order: 1, mirror: false };

    /// Whether there is any.
    pub fn is_any(self) -> bool {
        self != Self::NONE
    }

    /// Whether an object with this symmetry has the other one as well.
    pub fn includes(self, other: Self) -> bool {
        self.order.max(1).is_multiple_of(other.order.max(1)) && (self.mirror || !other.mirror)
    }

    /// The smallest turn that makes the object its own image, radians: 2π without symmetry of rotation.
    pub fn period_rad(self) -> f64 {
        TAU / f64::from(self.order.max(1))
    }

    /// Whether an object like this may have the k-th harmonic.
    pub fn allows_harmonic(self, k: usize) -> bool {
        k.is_multiple_of(self.order.max(1) as usize)
    }
}

impl Default for Symmetry {
    fn default() -> Self {
        Self::NONE
    }
}

impl fmt::Display for Symmetry {
    /// In words, as in "the object is …".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.order, self.mirror) {
            (0 | 1, false) => f.write_str("not symmetric"),
            (0 | 1, true) => f.write_str("its own mirror image"),
            (2, mirror) => write!(f, "the same after half a turn{}", and_in_a_mirror(mirror)),
            (order, mirror) => write!(f, "the same after 1/{order} of a turn{}", and_in_a_mirror(mirror)),
        }
    }
}

fn and_in_a_mirror(mirror: bool) -> &'static str {
    if mirror { " and in a mirror" } else { "" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{ellipse, rounded_polygon};

    #[test]
    fn harmonics_that_are_not_allowed_vanish_and_the_period_brings_the_shape_back() {
        for order in [2, 3, 4, 5, 6, 8] {
            let symmetry = Symmetry { order, mirror: true };
            let shape = rounded_polygon(order, 0.3, 0.3).expect("possible").rotated(0.4);
            for (index, [a, b]) in shape.harmonics_m().iter().enumerate() {
                assert!(symmetry.allows_harmonic(index + 1) || a.hypot(*b) < 1e-15);
            }
            for theta in [0.0, 1.1, 2.9] {
                assert!((shape.radius_m(theta) - shape.radius_m(theta + symmetry.period_rad())).abs() < 1e-14);
            }
        }
        let moved = ellipse(0.03, 0.02).expect("possible").translated(1e-3, 0.0);
        assert!(moved.harmonics_m()[0][0].abs() > 1e-4 && !Symmetry { order: 2, mirror: false }.allows_harmonic(1));
    }

    #[test]
    fn a_symmetry_includes_those_of_its_parts() {
        let of = |order, mirror| Symmetry { order, mirror };
        assert!(
            of(6, true).includes(of(3, false))
                && of(6, true).includes(of(2, true))
                && of(6, false).includes(of(6, false))
        );
        assert!(of(1, true).includes(Symmetry::NONE));
        assert!(
            !of(6, false).includes(of(2, true))
                && !of(3, true).includes(of(6, true))
                && !of(6, true).includes(of(4, true))
        );
    }

    #[test]
    fn it_reads_as_words() {
        let of = |order, mirror| Symmetry { order, mirror }.to_string();
        assert_eq!(of(1, false), "not symmetric");
        assert_eq!(of(1, true), "its own mirror image");
        assert_eq!(of(2, false), "the same after half a turn");
        assert_eq!(of(6, true), "the same after 1/6 of a turn and in a mirror");
    }
}
