//! Normal forces that carry the weight of a resting object: f₁ n̄₁ + f₂ n̄₂ = (0, m g), without friction, gives
//! f₁ = m g sin φ₁₂ / sin φ₂ and f₂ = m g sin φ₁ / sin φ₂.

use crate::mechanics::gravity::STANDARD_GRAVITY_M_PER_S2;
use crate::palms::{PalmAngles, PalmPair};

/// Normal forces (f₁, f₂) in newtons that carry an object of `mass_kg`.
///
/// A palm can only push: where a force comes out negative the object does not rest on both palms. The forces grow without
/// bound as the palms become parallel (φ₂ near 0 or π).
pub fn contact_forces_n(palms: &PalmPair, mass_kg: f64) -> (f64, f64) {
    forces_between_n(&palms.angles(), mass_kg)
}

/// The same, from the angles of the palms.
pub(crate) fn forces_between_n(angles: &PalmAngles, mass_kg: f64) -> (f64, f64) {
    let weight = mass_kg * STANDARD_GRAVITY_M_PER_S2 / angles.sin2;
    (weight * angles.sin12, weight * angles.sin1)
}
