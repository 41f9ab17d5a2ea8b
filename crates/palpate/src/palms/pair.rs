//! The palm pair and its frames, contact angles (eq. 1 of Moll & Erdmann 2001) and the place of an object on it.
//!
//! Palm 1 leaves its base point at the angle φ₁ against X; palm 2 at φ₁₂ = φ₁ + φ₂. Gravity acts along −Y. With both
//! base points in the origin this is the hinged pair of figure 1(a); apart, the two fingers of figure 1(b).

use super::{Contacts, PalmAngles, contact_angles};
use crate::shape::{ContactSupport, SupportFunction};

/// Angles and base points of the two palms at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PalmPair {
    /// Angle of palm 1 against the X axis, radians.
    pub phi1_rad: f64,
    /// Angle from palm 1 to palm 2, radians; 0 < φ₂ < π while an object can rest between them.
    pub phi2_rad: f64,
    /// Base point of palm 1 in the global frame, metres.
    pub base1_m: [f64; 2],
    /// Base point of palm 2 in the global frame, metres.
    pub base2_m: [f64; 2],
}

/// Which palm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palm {
    /// The palm at φ₁.
    One,
    /// The palm at φ₁ + φ₂.
    Two,
}

impl std::fmt::Display for Palm {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::One => "1",
            Self::Two => "2",
        })
    }
}

impl PalmPair {
    /// Two palms that share a hinge at the origin.
    pub fn hinged(phi1_rad: f64, phi2_rad: f64) -> Self {
        Self { phi1_rad, phi2_rad, base1_m: [0.0; 2], base2_m: [0.0; 2] }
    }

    /// The pair on the straight way (in angles and base points) from this one to `other`; `fraction` 0 to 1.
    pub fn towards(&self, other: &Self, fraction: f64) -> Self {
        let between = |a: f64, b: f64| a + (b - a) * fraction;
        let point = |a: [f64; 2], b: [f64; 2]| [between(a[0], b[0]), between(a[1], b[1])];
        Self {
            phi1_rad: between(self.phi1_rad, other.phi1_rad),
            phi2_rad: between(self.phi2_rad, other.phi2_rad),
            base1_m: point(self.base1_m, other.base1_m),
            base2_m: point(self.base2_m, other.base2_m),
        }
    }

    /// φ₁₂ = φ₁ + φ₂, the angle of palm 2 against the X axis.
    pub fn phi12_rad(&self) -> f64 {
        self.phi1_rad + self.phi2_rad
    }

    /// Normal of a palm, towards the object.
    pub fn normal(&self, palm: Palm) -> [f64; 2] {
        match palm {
            Palm::One => [-self.phi1_rad.sin(), self.phi1_rad.cos()],
            Palm::Two => [self.phi12_rad().sin(), -self.phi12_rad().cos()],
        }
    }

    /// Tangent of a palm; away from the base on palm 1, towards it on palm 2 (so that [t, n] is right-handed).
    pub fn tangent(&self, palm: Palm) -> [f64; 2] {
        match palm {
            Palm::One => [self.phi1_rad.cos(), self.phi1_rad.sin()],
            Palm::Two => [-self.phi12_rad().cos(), -self.phi12_rad().sin()],
        }
    }

    /// Contact angles (θ₁, θ₂) of an object at orientation `psi_rad`: θ₁ = φ₁ − ψ − π/2 (eq. 1), θ₂ = θ₁ + φ₂ − π.
    pub fn contact_angles(&self, psi_rad: f64) -> (f64, f64) {
        contact_angles(self.phi1_rad, self.phi2_rad, psi_rad)
    }

    /// How far each base point lies along its palm's normal, b_k · n̄_k, in metres (0 for a hinge at the origin).
    pub fn base_offsets_m(&self) -> (f64, f64) {
        let (n1, n2) = (self.normal(Palm::One), self.normal(Palm::Two));
        (dot(self.base1_m, n1), dot(self.base2_m, n2))
    }

    /// Centre of mass in the global frame when both palms touch: c · n̄_k = r_k + b_k · n̄_k.
    pub fn center_of_mass_m(&self, contact1: ContactSupport, contact2: ContactSupport) -> [f64; 2] {
        let (offset1, offset2) = self.base_offsets_m();
        self.angles().center([contact1.r + offset1, contact2.r + offset2])
    }

    /// Contact positions (s₁, s₂), metres from each base point along its palm, of an object at orientation `psi_rad`:
    /// s₁ = (c − b₁)·t̄₁ − d₁, s₂ = −(c − b₂)·t̄₂ + d₂.
    pub fn contact_positions_m(&self, shape: &SupportFunction, psi_rad: f64) -> (f64, f64) {
        let stance = self.stance(&self.angles(), shape, psi_rad);
        (stance.s1_m, stance.s2_m)
    }

    /// The palm angles, ready for computation.
    pub(crate) fn angles(&self) -> PalmAngles {
        PalmAngles::new(self.phi1_rad, self.phi2_rad)
    }

    /// How far each base point lies along its palm's tangent, b_k · t̄_k, in metres (0 for a hinge at the origin): seen from the base points,
    /// d_k is larger by as much.
    pub(crate) fn base_feet_m(&self) -> [f64; 2] {
        [dot(self.base1_m, self.tangent(Palm::One)), dot(self.base2_m, self.tangent(Palm::Two))]
    }

    /// How far each base point lies out on its palm from the point M where the lines of both palms meet, metres: a contact at s from the
    /// base point lies at s + shift from M.
    pub(crate) fn base_shifts_m(&self, angles: &PalmAngles) -> [f64; 2] {
        let (offset1, offset2) = self.base_offsets_m();
        let [meeting1, meeting2] = angles.positions([offset1, offset2], [0.0; 2]);
        let (t1, t2) = (self.tangent(Palm::One), self.tangent(Palm::Two));
        [dot(self.base1_m, t1) - meeting1, -dot(self.base2_m, t2) - meeting2]
    }

    /// Where an object at orientation `psi_rad` is and touches when both palms do; `angles` are those of this pair.
    pub(crate) fn stance(&self, angles: &PalmAngles, shape: &SupportFunction, psi_rad: f64) -> Stance {
        let (sin, cos) = (self.phi1_rad - psi_rad).sin_cos();
        let ([cos1, cos2], [sin1, sin2]) = angles.contact_directions(sin, cos);
        let at = Contacts::from([shape.towards(cos1, sin1), shape.towards(cos2, sin2)]);
        let ([x, y], [s1, s2]) = (angles.center(at.r), angles.positions(at.r, at.d));
        if self.base1_m == [0.0; 2] && self.base2_m == [0.0; 2] {
            return Stance { center_of_mass_m: [x, y], s1_m: s1, s2_m: s2 };
        }
        let (offset1, offset2) = self.base_offsets_m();
        let ([x0, y0], [shift1, shift2]) = (angles.center([offset1, offset2]), self.base_shifts_m(angles));
        Stance { center_of_mass_m: [x + x0, y + y0], s1_m: s1 - shift1, s2_m: s2 - shift2 }
    }
}

/// An object on both palms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stance {
    /// Centre of mass in the global frame, metres.
    pub center_of_mass_m: [f64; 2],
    /// Contact on palm 1, metres from its base point.
    pub s1_m: f64,
    /// Contact on palm 2, metres from its base point.
    pub s2_m: f64,
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
