//! Mistakes in how a log is written, recognised by undoing them: readings of an object are explained by one only if they are taken right.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use super::reconstructor::Reconstructor;
use super::verdict::doubt::{Doubt, Verdict};
use crate::log::{Log, Sample};
use crate::palms::PalmPair;

/// A common mistake in how a log is written. `Display` says what it is and what mends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Mistake {
    /// φ₁ is counted clockwise.
    Phi1Clockwise,
    /// φ₁ is counted from the vertical, counter-clockwise.
    Phi1FromVertical,
    /// φ₁ is counted from the vertical, clockwise.
    Phi1FromVerticalClockwise,
    /// φ₂ is counted from the horizontal, as φ₁ is.
    Phi2FromHorizontal,
    /// The positions of both palms are exchanged.
    PadsSwapped,
}

/// Samples of a log that are tried, about: enough to be certified, few enough to be quick.
const SAMPLES: usize = 400;

impl Mistake {
    /// All of them, the commonest first.
    pub const ALL: [Self; 5] = [
        Self::Phi1Clockwise,
        Self::PadsSwapped,
        Self::Phi2FromHorizontal,
        Self::Phi1FromVertical,
        Self::Phi1FromVerticalClockwise,
    ];

    /// The log without this mistake.
    pub fn undone(self, log: &Log) -> Log {
        let angles = |sample: &Sample, phi1_rad: f64, phi2_rad: f64| Sample {
            palms: PalmPair { phi1_rad, phi2_rad, ..sample.palms },
            ..*sample
        };
        let undone = |sample: &Sample| {
            let PalmPair { phi1_rad: phi1, phi2_rad: phi2, .. } = sample.palms;
            match self {
                Self::Phi1Clockwise => angles(sample, -phi1, phi2),
                Self::Phi1FromVertical => angles(sample, phi1 + FRAC_PI_2, phi2),
                Self::Phi1FromVerticalClockwise => angles(sample, FRAC_PI_2 - phi1, phi2),
                Self::Phi2FromHorizontal => angles(sample, phi1, phi2 - phi1),
                Self::PadsSwapped => Sample {
                    s1_m: sample.s2_m,
                    s2_m: sample.s1_m,
                    s1_sd_m: sample.s2_sd_m,
                    s2_sd_m: sample.s1_sd_m,
                    ..*sample
                },
            }
        };
        Log { samples: log.samples.iter().map(undone).collect() }
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Phi1Clockwise => "phi1 is counted clockwise: write `sign1 = -1` below `[angles]` into the rig file",
            Self::Phi1FromVertical => {
                "phi1 is counted from the vertical: write `phi1_zero_deg = -90` below `[angles]` into the rig file"
            }
            Self::Phi1FromVerticalClockwise => {
                "phi1 is counted from the vertical, clockwise: write `sign1 = -1` and `phi1_zero_deg = -90` below `[angles]` into the \
                 rig file"
            }
            Self::Phi2FromHorizontal => {
                "phi2 is counted from the horizontal, not from palm 1: write phi2 - phi1 into its column"
            }
            Self::PadsSwapped => "s1 and s2 are swapped: exchange their names in the header of the log",
        })
    }
}

impl Verdict {
    /// Whether a mistake in the log may be behind this.
    fn may_be_a_mistake(&self) -> bool {
        let is_suspicious = |doubt: &Doubt| {
            doubt.is_contradiction() || matches!(doubt, Doubt::UnlikelyRig { .. } | Doubt::Unbalanced { .. })
        };
        self.doubts.iter().any(is_suspicious)
    }
}

impl Reconstructor<'_> {
    /// What a log that was not explained, as `verdict` says (`None`: it could not be solved at all), may have been written by: the first
    /// mistake without which a part of its samples is certified with its centre of mass. `None` where nothing speaks for one.
    ///
    /// ```
    /// use palpate::reconstruct::{Mistake, Reconstructor};
    /// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
    /// # let egg = NamedShape::Egg.shape(0.03)?;
    /// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
    /// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    /// # let mut log = simulate(&egg, &plan.motion.sample(5.0)?, &options)?.log;
    /// for sample in &mut log.samples {
    ///     std::mem::swap(&mut sample.s1_m, &mut sample.s2_m);
    /// }
    /// assert_eq!(Reconstructor::new().recognise_mistake(&log, None), Some(Mistake::PadsSwapped));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn recognise_mistake(&self, log: &Log, verdict: Option<&Verdict>) -> Option<Mistake> {
        if self.integrates() || verdict.is_some_and(|verdict| !verdict.may_be_a_mistake()) {
            return None;
        }
        let every = log.samples.len().div_ceil(SAMPLES).max(1);
        let few = Log { samples: log.samples.iter().step_by(every).copied().collect() };
        let explains =
            |mistake: &Mistake| self.run_briefly(&mistake.undone(&few)).is_ok_and(|found| found.is_com_certified());
        Mistake::ALL.into_iter().find(explains)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmMotion;
    use crate::sensor::{Rig, Touchpad};
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    /// A log as somebody writes it who makes the mistake.
    fn made(mistake: Mistake, log: &Log) -> Log {
        let written = |sample: &Sample| {
            let (phi1, phi2) = (sample.palms.phi1_rad, sample.palms.phi2_rad);
            let (phi1_rad, phi2_rad) = match mistake {
                Mistake::Phi1Clockwise => (-phi1, phi2),
                Mistake::Phi1FromVertical => (phi1 - FRAC_PI_2, phi2),
                Mistake::Phi1FromVerticalClockwise => (FRAC_PI_2 - phi1, phi2),
                Mistake::Phi2FromHorizontal => (phi1, phi1 + phi2),
                Mistake::PadsSwapped => (phi1, phi2),
            };
            let palms = PalmPair { phi1_rad, phi2_rad, ..sample.palms };
            match mistake {
                Mistake::PadsSwapped => Sample { s1_m: sample.s2_m, s2_m: sample.s1_m, ..*sample },
                _ => Sample { palms, ..*sample },
            }
        };
        Log { samples: log.samples.iter().map(written).collect() }
    }

    #[test]
    fn every_mistake_is_recognised_and_none_where_there_is_none() {
        let rig = Rig::uncalibrated();
        let shape = NamedShape::Pebble.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(951, 40.0, 1.0).and_then(|motion| motion.sample(20.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
        let options = SimulateOptions { touchpad, seed: 1, ..SimulateOptions::default() };
        let log = rig.drawn(1).distorted(&simulate(&shape, &motion, &options).expect("possible").log);
        let reconstructor = Reconstructor::new().rig(rig);
        for mistake in Mistake::ALL {
            let wrong = made(mistake, &log);
            for (undone, right) in mistake.undone(&wrong).samples.iter().zip(&log.samples) {
                assert_eq!((undone.s1_m, undone.s2_m), (right.s1_m, right.s2_m), "{mistake:?}");
                let off = (undone.palms.phi1_rad - right.palms.phi1_rad).abs()
                    + (undone.palms.phi2_rad - right.palms.phi2_rad).abs();
                assert!(off < 1e-12, "{mistake:?}");
            }
            let contradiction = Verdict::new(vec![Doubt::NotConvex]);
            assert_eq!(reconstructor.recognise_mistake(&wrong, Some(&contradiction)), Some(mistake));
            // What is explained needs no explanation, and what integrates is never certified.
            let felt_little = Verdict::new(vec![Doubt::LittleFelt { coverage: 0.3 }]);
            assert_eq!(reconstructor.recognise_mistake(&wrong, Some(&felt_little)), None);
        }
        assert_eq!(reconstructor.recognise_mistake(&log, None), None);
    }
}
