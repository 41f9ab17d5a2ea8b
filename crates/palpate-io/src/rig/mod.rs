//! Rig files: what is known of a rig before a log is read, in TOML.

pub(crate) mod comment;
pub(crate) mod conventions;
mod key;
pub(crate) mod parse;
pub(crate) mod rig_error;
mod table;
pub(crate) mod to_toml;

use palpate::sensor::Rig;

use crate::rig::conventions::Conventions;

/// What a rig file says. The default is what an empty file says: the default tolerances, and the conventions of a palm log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigFile {
    /// Calibration constants and their standard deviations, in SI units. They hold after [`Conventions::apply`].
    pub rig: Rig,
    /// How the log is written where it is not as palpate has it.
    pub conventions: Conventions,
    /// The pads of palm 1 and palm 2.
    pub pads: [Pad; 2],
    /// Standard deviation of one reading of an angle, radians; 0 = exact, `None` = not known.
    pub angle_reading_sd_rad: Option<f64>,
}

/// What is known of a pad; `None` = not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pad {
    /// Standard deviation of one reading of a position, metres; 0 = exact.
    pub reading_sd_m: Option<f64>,
    /// Position steps per inch.
    pub counts_per_inch: Option<f64>,
    /// Pressure levels, at least 2.
    pub levels: Option<u32>,
    /// Coefficient of friction between pad and object.
    pub friction: Option<f64>,
    /// Standard deviation of the coefficient of friction; 0 = exact.
    pub friction_sd: Option<f64>,
}

impl RigFile {
    /// Of a rig without errors, in the conventions of a palm log: readings are taken as they are.
    pub fn exact() -> Self {
        Self { rig: Rig::default(), ..Self::default() }
    }

    /// Standard deviation of the positions, metres, of the pad that reads less well; `None` where none is stated.
    pub fn reading_sd_m(&self) -> Option<f64> {
        self.pads.iter().filter_map(|pad| pad.reading_sd_m).filter(|sd_m| *sd_m > 0.0).reduce(f64::max)
    }
}

impl Default for RigFile {
    fn default() -> Self {
        Self {
            rig: Rig::uncalibrated(),
            conventions: Conventions::default(),
            pads: [Pad::default(); 2],
            angle_reading_sd_rad: None,
        }
    }
}

/// A rig file to begin with: every key with its unit, its meaning and how to measure it. It says what an empty file says.
pub fn rig_template() -> &'static str {
    include_str!("template.toml")
}

#[cfg(test)]
mod tests;
