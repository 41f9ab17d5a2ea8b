//! The rig of the pivoting grasp (Moll & Erdmann 2001, figure 9) as data: one pad, and an arm that holds the object at a pivot P.

use crate::pivot::calibration::{PivotCalibration, PivotTolerances};

/// Where the pad lies. Its outward normal points to the object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PadPose {
    /// Base point, from which contacts are counted, X in the global frame, metres.
    pub base_x_m: f64,
    /// Base point, Y, metres.
    pub base_y_m: f64,
    /// Angle of the pad against the horizontal, radians, between −π/2 and π/2.
    pub tilt_rad: f64,
}

impl PadPose {
    /// Distance of a point along the pad from its base, and height over the pad, metres.
    pub fn along_and_above(&self, x_m: f64, y_m: f64) -> [f64; 2] {
        let (sin, cos) = self.tilt_rad.sin_cos();
        let (x, y) = (x_m - self.base_x_m, y_m - self.base_y_m);
        [x * cos + y * sin, y * cos - x * sin]
    }

    /// The point, X and Y in the global frame, so far along the pad and so high above it; metres.
    pub fn point(&self, along_m: f64, above_m: f64) -> [f64; 2] {
        let (sin, cos) = self.tilt_rad.sin_cos();
        [self.base_x_m + along_m * cos - above_m * sin, self.base_y_m + along_m * sin + above_m * cos]
    }

    /// Orientation ψ of the object whose contact has the body angle `theta_rad`: the outward normal points into the pad.
    pub fn psi_rad(&self, theta_rad: f64) -> f64 {
        self.tilt_rad - std::f64::consts::FRAC_PI_2 - theta_rad
    }
}

/// What is known of the rig before a log is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct PivotRig {
    /// Where the pad lies.
    pub pad: PadPose,
    /// Constant errors of pad and arm, as far as they are known.
    pub calibration: PivotCalibration,
    /// How well each of these is known.
    pub tolerances: PivotTolerances,
    /// Standard deviation of a contact position, metres, if known.
    pub reading_sd_m: Option<f64>,
    /// Standard deviation of each coordinate of the pivot, metres, if known.
    pub arm_sd_m: Option<f64>,
}

impl PivotRig {
    /// A rig without constant errors whose pad lies so.
    pub fn exact(pad: PadPose) -> Self {
        Self { pad, ..Self::default() }
    }

    /// A rig that nobody calibrated whose pad lies so: the default tolerances.
    pub fn uncalibrated(pad: PadPose) -> Self {
        Self { tolerances: PivotTolerances::UNCALIBRATED, ..Self::exact(pad) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_over_a_tilted_pad_is_found_again() {
        let pad = PadPose { base_x_m: 0.02, base_y_m: -0.01, tilt_rad: 0.3 };
        let [x, y] = pad.point(0.15, 0.04);
        let [along, above] = pad.along_and_above(x, y);
        assert!((along - 0.15).abs() < 1e-15 && (above - 0.04).abs() < 1e-15);
    }
}
