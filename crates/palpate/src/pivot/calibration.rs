//! Constant errors of pad and arm, and what they do to height and offset of the pivot, with derivatives:
//!
//! reading = (1 + scale) · position + zero, and the pad lies higher, and is tilted more, than stated.
//!
//! An offset of the pivot in the gripper along the pad is the same error as `zero`, one across it the same as `height`.

use crate::pivot::rig::PadPose;

/// Constant errors. The default is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PivotCalibration {
    /// Added by the pad to every position, metres; takes an offset of the pivot along the pad with it.
    pub zero_m: f64,
    /// Relative error of the pad's scale.
    pub scale: f64,
    /// Tilt of the pad beyond what is stated, radians, about its base point.
    pub tilt_rad: f64,
    /// Height of the pad above what is stated, metres; takes an offset of the pivot across the pad with it. No log tells it: a parallel
    /// body, r + constant, has the same log.
    pub height_m: f64,
}

/// Standard deviations of the constants; 0 = exact, the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PivotTolerances {
    /// Of [`PivotCalibration::zero_m`], metres.
    pub zero_sd_m: f64,
    /// Of [`PivotCalibration::scale`].
    pub scale_sd: f64,
    /// Of [`PivotCalibration::tilt_rad`], radians.
    pub tilt_sd_rad: f64,
    /// Of [`PivotCalibration::height_m`], metres.
    pub height_sd_m: f64,
}

impl PivotTolerances {
    /// Those of a rig that nobody measured with care: half a millimetre, 1 %, half a degree.
    pub const UNCALIBRATED: Self = Self {
        zero_sd_m: 0.5e-3,
        scale_sd: 0.01,
        tilt_sd_rad: 0.5 * std::f64::consts::PI / 180.0,
        height_sd_m: 0.5e-3,
    };

    /// Of the constants that a log may tell: zero, scale and tilt.
    pub(super) fn told(&self) -> [f64; TOLD] {
        [self.zero_sd_m, self.scale_sd, self.tilt_sd_rad]
    }
}

/// Constants that a log may tell.
pub(super) const TOLD: usize = 3;

impl PivotCalibration {
    /// The constants that a log may tell: zero, scale and tilt.
    pub(super) fn told(&self) -> [f64; TOLD] {
        [self.zero_m, self.scale, self.tilt_rad]
    }

    /// What readings say where the rig errs so.
    pub(super) fn measured(self, readings: &[Reading]) -> impl Iterator<Item = Measured> {
        let turn = self.tilt_rad.sin_cos();
        readings.iter().map(move |reading| reading.turned(&self, turn))
    }

    /// With others in place of these.
    pub(super) fn with_told(self, [zero_m, scale, tilt_rad]: [f64; TOLD]) -> Self {
        Self { zero_m, scale, tilt_rad, ..self }
    }
}

/// What a sample with a contact measured: where the pivot stood in the stated frame of the pad, and what the pad read; metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    pub along_m: f64,
    pub above_m: f64,
    pub s_m: f64,
}

/// Height r of the pivot over the pad and offset d of the contact from the foot of the pivot, metres, with their derivatives by the
/// constants that a log may tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    pub r_m: f64,
    pub d_m: f64,
    pub r_by: [f64; TOLD],
    pub d_by: [f64; TOLD],
}

impl Reading {
    /// As the arm and the pad gave it.
    pub fn new(pad: &PadPose, pivot_x_m: f64, pivot_y_m: f64, s_m: f64) -> Self {
        let [along_m, above_m] = pad.along_and_above(pivot_x_m, pivot_y_m);
        Self { along_m, above_m, s_m }
    }

    /// What it says where the rig errs so.
    pub fn measured(&self, errors: &PivotCalibration) -> Measured {
        self.turned(errors, errors.tilt_rad.sin_cos())
    }

    /// The same from sine and cosine of the tilt.
    fn turned(&self, errors: &PivotCalibration, (sin, cos): (f64, f64)) -> Measured {
        let (along, above) = (self.along_m * cos + self.above_m * sin, self.above_m * cos - self.along_m * sin);
        let position = (self.s_m - errors.zero_m) / (1.0 + errors.scale);
        let stretch = 1.0 / (1.0 + errors.scale);
        Measured {
            r_m: above - errors.height_m,
            d_m: along - position,
            r_by: [0.0, 0.0, -along],
            d_by: [stretch, position * stretch, above],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_by_the_constants_are_those_of_finite_differences() {
        let reading = Reading { along_m: 0.11, above_m: 0.03, s_m: 0.105 };
        let at = PivotCalibration { zero_m: 4e-4, scale: 0.02, tilt_rad: 0.01, height_m: 3e-4 };
        let exact = reading.measured(&at);
        for constant in 0..TOLD {
            let moved = |by: f64| {
                let mut told = at.told();
                told[constant] += by;
                reading.measured(&at.with_told(told))
            };
            let (up, down) = (moved(1e-6), moved(-1e-6));
            let difference = |up: f64, down: f64| (up - down) / 2e-6;
            assert!((difference(up.r_m, down.r_m) - exact.r_by[constant]).abs() < 1e-8);
            assert!((difference(up.d_m, down.d_m) - exact.d_by[constant]).abs() < 1e-8);
        }
    }

    #[test]
    fn errors_of_the_rig_are_taken_out_again() {
        let errors = PivotCalibration { zero_m: -4e-4, scale: 0.013, tilt_rad: 0.008, height_m: 2e-4 };
        let (along, r, d) = (0.14, 0.032, -0.006);
        // The true pad: higher, and turned about the base point.
        let (sin, cos) = errors.tilt_rad.sin_cos();
        let above = r + errors.height_m;
        let reading = Reading {
            along_m: along * cos - above * sin,
            above_m: along * sin + above * cos,
            s_m: (1.0 + errors.scale) * (along - d) + errors.zero_m,
        };
        let found = reading.measured(&errors);
        assert!((found.r_m - r).abs() < 1e-15 && (found.d_m - d).abs() < 1e-15);
    }
}
