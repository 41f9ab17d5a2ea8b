//! What is known of a rig before a log is read: its calibration constants and how well each is known.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

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
    /// Of scale 1 − scale 2, where that is known better than both scales: logs tell it, and never the scales. `None` = as they are.
    pub scale_ratio_sd: Option<f64>,
    /// The same of surface 1 − surface 2, metres.
    pub surface_difference_sd_m: Option<f64>,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            zero_sd_m: [0.5e-3; 2],
            scale_sd: [0.01; 2],
            angle_zero_sd_rad: [0.5_f64.to_radians(); 2],
            surface_sd_m: [0.5e-3; 2],
            clock_offset_sd_s: 0.0,
            scale_ratio_sd: None,
            surface_difference_sd_m: None,
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
        scale_ratio_sd: None,
        surface_difference_sd_m: None,
    };

    /// Standard deviation of scale 1 − scale 2.
    pub fn scale_ratio_sd(&self) -> f64 {
        difference_sd(self.scale_sd, self.scale_ratio_sd)
    }

    /// Standard deviation of surface 1 − surface 2, metres.
    pub fn surface_difference_sd_m(&self) -> f64 {
        difference_sd(self.surface_sd_m, self.surface_difference_sd_m)
    }
}

/// Of a difference, stated or not.
fn difference_sd([one, two]: [f64; 2], stated: Option<f64>) -> f64 {
    stated.unwrap_or(f64::INFINITY).min(one.hypot(two))
}

/// How a difference of two constants is shared: by their variances, so that what they have in common stays.
pub(crate) fn shares([one, two]: [f64; 2]) -> [f64; 2] {
    let sum = one * one + two * two;
    if sum > 0.0 { [one * one / sum, -two * two / sum] } else { [0.0; 2] }
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

    /// Constants that such a rig may have: the stated ones, with errors of these standard deviations.
    pub fn drawn(&self, seed: u64) -> Calibration {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut drawn = self.calibration;
        let mut error = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
        let of = &self.tolerances;
        for k in 0..2 {
            drawn.zero_m[k] += error(of.zero_sd_m[k]);
            drawn.angle_zero_rad[k] += error(of.angle_zero_sd_rad[k]);
        }
        let (of_scale, of_surface) = (shares(of.scale_sd), shares(of.surface_sd_m));
        let (scale, ratio) = (error(self.size_sd()), error(of.scale_ratio_sd()));
        let (surface_m, difference_m) = (error(self.offset_sd_m()), error(of.surface_difference_sd_m()));
        for k in 0..2 {
            drawn.scale[k] += scale + of_scale[k] * ratio;
            drawn.surface_m[k] += surface_m + of_surface[k] * difference_m;
        }
        drawn.clock_offset_s += error(of.clock_offset_sd_s);
        drawn
    }

    /// Such constants with the size that is stated: what both scales and both surface offsets have in common, which no log tells, put back.
    pub fn at_stated_size(&self, drawn: &Calibration) -> Calibration {
        let stated = &self.calibration;
        let (of_scale, of_surface) = (shares(self.tolerances.scale_sd), shares(self.tolerances.surface_sd_m));
        let difference = |of: fn(&Calibration) -> [f64; 2]| {
            let [[stated1, stated2], [drawn1, drawn2]] = [of(stated), of(drawn)];
            (drawn1 - stated1) - (drawn2 - stated2)
        };
        let (ratio, difference_m) = (difference(|of| of.scale), difference(|of| of.surface_m));
        Calibration {
            scale: [0, 1].map(|k| stated.scale[k] + of_scale[k] * ratio),
            surface_m: [0, 1].map(|k| stated.surface_m[k] + of_surface[k] * difference_m),
            ..*drawn
        }
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
    fn drawn_constants_scatter_as_the_tolerances_say() {
        let stated = Calibration { zero_m: [1e-3, 0.0], ..Calibration::default() };
        let tolerances = Tolerances { zero_sd_m: [2e-4, 0.0], ..Tolerances::default() };
        let rig = Rig::new(stated, tolerances);
        let drawn: Vec<Calibration> = (0..4000).map(|seed| rig.drawn(seed)).collect();
        let of = |value: fn(&Calibration) -> f64| {
            let values: Vec<f64> = drawn.iter().map(value).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt())
        };
        for ((mean, sd), expected) in [
            (of(|c| c.zero_m[0]), (1e-3, 2e-4)),
            (of(|c| c.scale[1]), (1.0, 0.01)),
            (of(|c| c.angle_zero_rad[0]), (0.0, 0.5_f64.to_radians())),
            (of(|c| c.surface_m[1]), (0.0, 0.5e-3)),
        ] {
            assert!(
                (mean - expected.0).abs() < 0.06 * expected.1 && (sd / expected.1 - 1.0).abs() < 0.04,
                "{mean} {sd}"
            );
        }
        assert!(drawn.iter().all(|c| c.zero_m[1] == 0.0 && c.clock_offset_s == 0.0));
        for drawn in &drawn[..10] {
            let told = rig.at_stated_size(drawn);
            let ratio = |c: &Calibration| c.scale[0] - c.scale[1];
            assert!((ratio(&told) - ratio(drawn)).abs() < 1e-15);
            assert!((told.scale[0] + told.scale[1] - 2.0).abs() < 1e-15 && told.surface_m[0] == -told.surface_m[1]);
            assert_eq!((told.zero_m, told.angle_zero_rad), (drawn.zero_m, drawn.angle_zero_rad));
        }
    }

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
