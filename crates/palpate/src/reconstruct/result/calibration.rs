//! What a log told of the rig that wrote it: plain data.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::estimate::calibration::{CONSTANTS, constants, prior_sd};
use crate::sensor::{Calibration, CalibrationConstant, Rig, Tolerances};

/// The calibration constants that a log told, and what none can tell.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CalibrationEstimate {
    /// The constants that the readings were corrected by.
    pub calibration: Calibration,
    /// Each constant that a log may tell.
    pub constants: Vec<ConstantEstimate>,
    /// Covariance of the constants, row by row in their order, in products of their units.
    pub covariance: Vec<Vec<f64>>,
    /// Relative standard deviation of the size of the object, from the tolerance of what both pads' scales have in common. The standard
    /// deviations of r, ψ and the centre of mass are those for the stated scale and surface offset.
    pub size_sd: f64,
    /// Standard deviation of a parallel shift of the boundary, metres, from that of what both surface offsets have in common.
    pub offset_sd_m: f64,
}

/// One calibration constant.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ConstantEstimate {
    /// As in [`CalibrationConstant`]: `s1_zero_m`, `s2_zero_m`, `scale_ratio` (scale 1 − scale 2), `phi1_zero_rad`, `phi2_zero_rad`, `surface_difference_m`
    /// (1 − 2) or `clock_offset_s`; the unit is that of the name.
    pub name: String,
    /// What was found.
    pub value: f64,
    /// Its standard deviation; that of the prior where the log tells nothing.
    pub sd: f64,
    /// What the rig was stated to have.
    pub stated: f64,
    /// The standard deviation of that.
    pub prior_sd: f64,
}

impl CalibrationEstimate {
    /// A rig of these constants, known as well as before the log. Differences of the pads are shared by both alike.
    pub(crate) fn prior_rig(&self) -> Rig {
        let sd = |index: usize| self.constants.get(index).map_or(0.0, |constant| constant.prior_sd);
        let [zero1, zero2, ratio, phi1, phi2, difference, clock] = std::array::from_fn::<f64, CONSTANTS, _>(sd);
        let tolerances = Tolerances {
            zero_sd_m: [zero1, zero2],
            scale_sd: [ratio * FRAC_1_SQRT_2; 2],
            angle_zero_sd_rad: [phi1, phi2],
            surface_sd_m: [difference * FRAC_1_SQRT_2; 2],
            clock_offset_sd_s: clock,
            ..Tolerances::NONE
        };
        Rig::new(self.calibration, tolerances)
    }
}

impl ConstantEstimate {
    /// The values that the constants of a calibration have, in the order of [`CalibrationEstimate::constants`].
    pub fn values_of(calibration: &Calibration) -> [f64; CONSTANTS] {
        constants(calibration)
    }

    /// Every constant that a log may tell, of a rig that was stated so: what was found, with its standard deviations.
    pub(crate) fn all(rig: &Rig, values: [f64; CONSTANTS], sds: [f64; CONSTANTS]) -> Vec<Self> {
        let (stated, prior_sds) = (constants(&rig.calibration), prior_sd(&rig.tolerances));
        let constant = |(index, about): (usize, &CalibrationConstant)| Self {
            name: about.name.to_owned(),
            value: values[index],
            sd: sds[index],
            stated: stated[index],
            prior_sd: prior_sds[index],
        };
        CalibrationConstant::ALL.iter().enumerate().map(constant).collect()
    }
}
