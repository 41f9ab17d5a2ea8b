//! Calibration of a rig from any number of logs (`docs/theory.md`, calibration): every log has an object and a motion of its own, all share
//! the constants of the rig.
//!
//! Each log is reconstructed with the constants open, which leaves a Gaussian posterior of them; what the logs add to the prior is
//! multiplied. A log that is not certified contributes nothing. Discs of a known radius also tell what no log of an unknown object does, see
//! [`calibrate_with_disc`].

mod disc;
mod joint;

pub use disc::{DiscError, calibrate_with_disc};
pub use joint::calibrate;

use crate::reconstruct::{ConstantEstimate, Verdict};
use crate::sensor::Rig;

/// What logs told of the rig that wrote them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RigCalibration {
    /// The rig as it is known now.
    pub rig: Rig,
    /// Each constant that logs may tell, from all logs together.
    pub constants: Vec<ConstantEstimate>,
    /// What each log contributed, in the order given.
    pub logs: Vec<Contribution>,
}

impl RigCalibration {
    /// The logs that contributed.
    pub fn used(&self) -> usize {
        self.logs.iter().filter(|log| log.is_used).count()
    }

    /// The log that is furthest from all others (its place, from 0) by more than [`DRIFT_SDS`], if there is one.
    pub fn drift(&self) -> Option<(usize, &Drift)> {
        let drifts =
            self.logs.iter().enumerate().filter_map(|(place, log)| log.drift.as_ref().map(|drift| (place, drift)));
        drifts.filter(|(_, drift)| drift.sds.abs() > DRIFT_SDS).max_by(|a, b| a.1.sds.abs().total_cmp(&b.1.sds.abs()))
    }
}

/// A log whose constant differs from that of the others by more standard deviations than this is at odds with them: of ten logs with seven
/// constants each, one in eighty is so by chance.
pub const DRIFT_SDS: f64 = 4.0;

/// What one log contributed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contribution {
    /// Whether it counts: its reconstruction is certified.
    pub is_used: bool,
    /// What is doubtful about its reconstruction.
    pub verdict: Verdict,
    /// Why it could not be reconstructed at all.
    pub failure: Option<String>,
    /// The constants from this log alone; empty where it could not be reconstructed.
    pub constants: Vec<ConstantEstimate>,
    /// What its reconstruction leaves in the contact positions with the constants as stated, metres; `None` where that failed.
    pub residual_before_m: Option<f64>,
    /// The same with the constants of all logs together.
    pub residual_after_m: Option<f64>,
    /// The constant that differs most from that of all other logs.
    pub drift: Option<Drift>,
}

impl Contribution {
    /// Of a log that could not be reconstructed.
    fn failed(failure: String) -> Self {
        Self {
            is_used: false,
            verdict: Verdict::default(),
            failure: Some(failure),
            constants: Vec::new(),
            residual_before_m: None,
            residual_after_m: None,
            drift: None,
        }
    }
}

/// A constant of one log against that of the others.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drift {
    /// Its name, as in [`ConstantEstimate::name`].
    pub constant: String,
    /// The difference, in its unit.
    pub difference: f64,
    /// The same in standard deviations.
    pub sds: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::Rig;

    #[test]
    fn a_log_drifts_beyond_four_standard_deviations() {
        let of_log = |sds| {
            let drift = Drift { constant: "s1_zero_m".to_owned(), difference: 1e-4, sds };
            Contribution { drift: Some(drift), ..Contribution::failed(String::new()) }
        };
        let drifted = |sds: &[f64]| {
            let logs = sds.iter().map(|sds| of_log(*sds)).collect();
            RigCalibration { rig: Rig::default(), constants: Vec::new(), logs }.drift().map(|(place, _)| place)
        };
        assert_eq!(drifted(&[1.0, -3.99]), None);
        assert_eq!(drifted(&[1.0, -4.01]), Some(1));
        assert_eq!(drifted(&[5.0, -6.0, f64::NAN]), Some(1));
    }
}
