//! Contact support functions from the readings: the two-point contact constraint (eq. 2 and 3 of Moll & Erdmann 2001) and the
//! generalised contact support functions (eq. 4 to 8), projections of the vector between the two contact points.

use super::{Palm, PalmPair};
use crate::shape::SupportFunction;

/// The generalised contact support functions relative to both contacts, metres (r̃ and d̃ in the paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeneralizedContactSupport {
    /// r̃₁ = (x₁ − x₂) · n₁
    pub r1: f64,
    /// d̃₁ = (x₁ − x₂) · t₁
    pub d1: f64,
    /// r̃₂ = (x₁ − x₂) · n₂
    pub r2: f64,
    /// d̃₂ = (x₁ − x₂) · t₂
    pub d2: f64,
}

impl GeneralizedContactSupport {
    /// Of a shape with its first contact at the normal angle `theta1_rad`, between palms that open by `phi2_rad`
    /// (eq. 4 to 7).
    pub fn of_shape(shape: &SupportFunction, theta1_rad: f64, phi2_rad: f64) -> Self {
        let theta2_rad = theta1_rad + phi2_rad - std::f64::consts::PI;
        let (x1, x2) = (shape.boundary_point(theta1_rad), shape.boundary_point(theta2_rad));
        let between = [x1.x_m - x2.x_m, x1.y_m - x2.y_m];
        let normal = |theta: f64| [theta.cos(), theta.sin()];
        let tangent = |theta: f64| [theta.sin(), -theta.cos()];
        Self {
            r1: dot(between, normal(theta1_rad)),
            d1: dot(between, tangent(theta1_rad)),
            r2: dot(between, normal(theta2_rad)),
            d2: dot(between, tangent(theta2_rad)),
        }
    }

    /// From contact positions in metres. For a hinge r̃₁ = s₂ sin φ₂, d̃₁ = s₂ cos φ₂ − s₁, r̃₂ = −s₁ sin φ₂ and
    /// d̃₂ = s₁ cos φ₂ − s₂ (eq. 8); with base points apart the vector between them is added.
    pub fn of_readings(palms: &PalmPair, s1_m: f64, s2_m: f64) -> Self {
        let (point1, point2) = palms.contact_points_m(s1_m, s2_m);
        let between = [point1[0] - point2[0], point1[1] - point2[1]];
        // The frames of object and palm are opposite: (n̄ t̄) = −R (n t).
        let along = |direction: [f64; 2]| -dot(between, direction);
        Self {
            r1: along(palms.normal(Palm::One)),
            d1: along(palms.tangent(Palm::One)),
            r2: along(palms.normal(Palm::Two)),
            d2: along(palms.tangent(Palm::Two)),
        }
    }
}

impl PalmPair {
    /// The contact points in the global frame, metres: b₁ + s₁ t̄₁ and b₂ − s₂ t̄₂.
    pub fn contact_points_m(&self, s1_m: f64, s2_m: f64) -> ([f64; 2], [f64; 2]) {
        let (t1, t2) = (self.tangent(Palm::One), self.tangent(Palm::Two));
        (
            [self.base1_m[0] + s1_m * t1[0], self.base1_m[1] + s1_m * t1[1]],
            [self.base2_m[0] - s2_m * t2[0], self.base2_m[1] - s2_m * t2[1]],
        )
    }

    /// d₁ and d₂ from r₁, r₂ and the contact positions, all metres, by the contact constraint (eq. 3). Hinged palms only:
    /// d₁ = (r₁ cos φ₂ + r₂) / sin φ₂ − s₁ and d₂ = −(r₂ cos φ₂ + r₁) / sin φ₂ + s₂.
    pub fn foot_offsets_m(&self, r1_m: f64, r2_m: f64, s1_m: f64, s2_m: f64) -> (f64, f64) {
        let [d1, d2] = self.angles().feet([r1_m, r2_m], [s1_m, s2_m]);
        (d1, d2)
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
