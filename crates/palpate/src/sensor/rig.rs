//! What is known of a rig before a log is read: its calibration constants and how well each is known.

use crate::sensor::Calibration;

/// Standard deviations of the calibration constants; 0 = exact. The default is what a rig is known to that nobody measured with care.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct Tolerances {
    /// Of [`Calibration::zero_m`], metres: 0.5 mm.
    pub zero_sd_m: [f64; 2],
    /// Of [`Calibration::scale`]: 0.01.
    pub scale_sd: [f64; 2],
    /// Of [`Calibration::angle_zero_rad`], radians: half a degree.
    pub angle_zero_sd_rad: [f64; 2],
    /// Of [`Calibration::surface_m`], metres: 0.5 mm.
    pub surface_sd_m: [f64; 2],
    /// Of [`Calibration::clock_offset_s`], seconds: 0.
    pub clock_offset_sd_s: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            zero_sd_m: [0.5e-3; 2],
            scale_sd: [0.01; 2],
            angle_zero_sd_rad: [0.5_f64.to_radians(); 2],
            surface_sd_m: [0.5e-3; 2],
            clock_offset_sd_s: 0.0,
        }
    }
}

impl Tolerances {
    /// Every constant is exact.
    pub const NONE: Self = Self {
        zero_sd_m: [0.0; 2],
        scale_sd: [0.0; 2],
        angle_zero_sd_rad: [0.0; 2],
        surface_sd_m: [0.0; 2],
        clock_offset_sd_s: 0.0,
    };
}

/// A rig: its calibration constants with their standard deviations. What a log tells of them is estimated with the shape.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct Rig {
    /// The constants, as far as they are known.
    pub calibration: Calibration,
    /// Their standard deviations.
    pub tolerances: Tolerances,
}

impl Default for Rig {
    /// Readings are taken as they are.
    fn default() -> Self {
        Self { calibration: Calibration::default(), tolerances: Tolerances::NONE }
    }
}

impl Rig {
    /// A rig with constants that are known to these standard deviations.
    pub fn new(calibration: Calibration, tolerances: Tolerances) -> Self {
        Self { calibration, tolerances }
    }

    /// A rig of which nothing is known but the default tolerances.
    pub fn uncalibrated() -> Self {
        Self::new(Calibration::default(), Tolerances::default())
    }

    /// Standard deviation of the size of every object, relative, that stays whatever a log tells: of what both pads' scales have in common.
    pub fn size_sd(&self) -> f64 {
        common_sd(self.tolerances.scale_sd)
    }

    /// Standard deviation of a parallel shift of every boundary, metres, that stays whatever a log tells: of what both surface offsets have in
    /// common.
    pub fn offset_sd_m(&self) -> f64 {
        common_sd(self.tolerances.surface_sd_m)
    }
}

/// Standard deviation of two constants whose difference becomes known exactly.
fn common_sd([one, two]: [f64; 2]) -> f64 {
    if one == 0.0 || two == 0.0 { 0.0 } else { one * two / one.hypot(two) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_is_as_certain_as_the_scales_have_in_common() {
        let rig = Rig::uncalibrated();
        assert!((rig.size_sd() - 0.01 / 2.0_f64.sqrt()).abs() < 1e-12);
        assert!((rig.offset_sd_m() - 0.5e-3 / 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((Rig::default().size_sd(), Rig::default().offset_sd_m()), (0.0, 0.0));
        // A pad whose scale is exact measures for the other.
        let tolerances = Tolerances { scale_sd: [0.0, 0.01], ..Tolerances::default() };
        assert_eq!(Rig::new(Calibration::default(), tolerances).size_sd(), 0.0);
    }
}
