//! Where the palms may go: the box of palm angles, cut by the opening, in which motions are planned.

use std::f64::consts::PI;

/// Where the palms may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PalmLimits {
    /// Smallest angle of palm 1 against the horizontal, radians, positive.
    pub smallest_phi1_rad: f64,
    /// Largest angle φ₁₂ of palm 2, radians, below π.
    pub largest_phi12_rad: f64,
    /// Smallest opening φ₂, radians.
    pub smallest_phi2_rad: f64,
    /// Largest opening φ₂, radians.
    pub largest_phi2_rad: f64,
    /// Length of the palms, metres; may be infinite.
    pub palm_length_m: f64,
}

impl Default for PalmLimits {
    /// Palms at least 4° above the horizontal, opening 25° to 160°, endless. Of random pebbles about half can be turned all
    /// the way around within these limits; of nearly all others at least 80 % of the boundary can be felt. With 8° and 40°
    /// to 140° it is one in ten, and half of the boundary.
    fn default() -> Self {
        Self {
            smallest_phi1_rad: 4f64.to_radians(),
            largest_phi12_rad: 176f64.to_radians(),
            smallest_phi2_rad: 25f64.to_radians(),
            largest_phi2_rad: 160f64.to_radians(),
            palm_length_m: f64::INFINITY,
        }
    }
}

impl PalmLimits {
    /// Whether the limits leave palms between which an object can rest.
    pub(super) fn are_in_order(&self) -> bool {
        let in_order = |low: f64, high: f64| low > 0.0 && low < high && high < PI;
        in_order(self.smallest_phi1_rad, self.largest_phi12_rad)
            && in_order(self.smallest_phi2_rad, self.largest_phi2_rad)
            && !self.palm_length_m.is_nan()
    }
}
