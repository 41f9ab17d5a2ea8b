//! The jump of an object from one resting pose to another ("a discrete change in orientation", section 6 of Moll & Erdmann 2001) as a
//! record, shared by simulation, estimate and files. Its physics, the fold at which a pose vanishes, is in
//! `mechanics/frictionless/fold.rs`; jumps in a motion that was found are in `estimate/jumps.rs`.

use super::gravity::STANDARD_GRAVITY_M_PER_S2;

/// A pose vanished and the object went downhill to another, at practically one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Jump {
    /// The last instant of the old pose, seconds; of a log, its first sample after the jump.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub time_s: f64,
    /// Orientation before, radians.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub psi_before_rad: f64,
    /// Orientation after, radians, unwrapped: the difference says which way the object turned.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub psi_after_rad: f64,
    /// Height of the centre of mass in the old pose over the palms as they are after the jump, metres.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub height_before_m: f64,
    /// Height of the centre of mass in the new pose over the same palms, metres.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub height_after_m: f64,
    /// Whether the object would make this jump: downhill all the way. A shape that was found from a log may contradict its own jumps.
    pub physical: bool,
}

impl Jump {
    /// How much lower the centre of mass is afterwards, metres.
    pub fn height_drop_m(&self) -> f64 {
        self.height_before_m - self.height_after_m
    }

    /// The potential energy that an object of `mass_kg` loses, joules.
    pub fn energy_lost_j(&self, mass_kg: f64) -> f64 {
        mass_kg * STANDARD_GRAVITY_M_PER_S2 * self.height_drop_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_energy_lost_is_weight_times_height() {
        let jump = Jump { height_before_m: 0.05, height_after_m: 0.04, ..Jump::default() };
        assert!((jump.height_drop_m() - 0.01).abs() < 1e-15);
        assert!((jump.energy_lost_j(0.1) - 0.00980665).abs() < 1e-15);
    }
}
