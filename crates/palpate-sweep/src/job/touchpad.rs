//! The touchpads of a simulated job: those properties of [`Touchpad`] that a sweep varies, as plain data.

use palpate::sensor::Touchpad;
use serde::{Deserialize, Serialize};

/// How both pads err, the rest being [ideal](Touchpad::ideal).
///
/// A type of its own because a plan varies no more than this, and because the jobs, written out, are what a journal is known by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Touchpads {
    /// Standard deviation of Gaussian noise on the contact positions before rounding, metres.
    pub noise_sd_m: f64,
    /// Steps per inch that contact positions are rounded to; `None` for no rounding.
    pub counts_per_inch: Option<f64>,
    /// Standard deviation of Gaussian noise on both palm angles, radians.
    pub angle_noise_sd_rad: f64,
    /// Share of the readings of each pad that are missing.
    pub dropout: f64,
    /// Length of the palms, metres; `None` for endless ones.
    pub length_m: Option<f64>,
}

impl From<Touchpads> for Touchpad {
    fn from(pads: Touchpads) -> Self {
        let ideal = Self::ideal();
        Self {
            noise_sd_m: pads.noise_sd_m,
            counts_per_inch: pads.counts_per_inch,
            angle_noise_sd_rad: pads.angle_noise_sd_rad,
            dropout: pads.dropout,
            length_m: pads.length_m.unwrap_or(ideal.length_m),
            ..ideal
        }
    }
}
