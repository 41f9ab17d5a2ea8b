//! The palm log: what the robot knows, sample by sample. Plain data, shared by the simulator, the estimator, files and Python.

use crate::palms::PalmPair;

/// Palm angles and contact positions over time. Times do not decrease.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Log {
    /// One entry per sample.
    pub samples: Vec<Sample>,
}

impl Log {
    /// The palms of every sample.
    pub(crate) fn palms(&self) -> Vec<PalmPair> {
        self.samples.iter().map(|sample| sample.palms).collect()
    }

    /// Seconds from the sample before to this one.
    pub(crate) fn interval_s(&self, sample: usize) -> f64 {
        self.samples[sample].time_s - self.samples[sample - 1].time_s
    }
}

/// One sample of a palm log.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample {
    /// Time in seconds.
    pub time_s: f64,
    /// Palm angles and base points.
    pub palms: PalmPair,
    /// Distance from the base of palm 1 to the contact, metres; `None` where no contact was seen.
    pub s1_m: Option<f64>,
    /// Distance from the base of palm 2 to the contact, metres; `None` where no contact was seen.
    pub s2_m: Option<f64>,
    /// Stated standard deviation of `s1_m`, metres.
    pub s1_sd_m: Option<f64>,
    /// Stated standard deviation of `s2_m`, metres.
    pub s2_sd_m: Option<f64>,
    /// Normal force at contact 1, newtons.
    pub force1_n: Option<f64>,
    /// Normal force at contact 2, newtons.
    pub force2_n: Option<f64>,
}

impl Sample {
    /// Normal forces at contact 1 and contact 2, newtons; `None` where not measured.
    pub(crate) fn forces_n(&self) -> [Option<f64>; 2] {
        [self.force1_n, self.force2_n]
    }

    /// A sample with both contacts seen and nothing stated about noise or force.
    pub fn new(time_s: f64, palms: PalmPair, s1_m: f64, s2_m: f64) -> Self {
        Self {
            time_s,
            palms,
            s1_m: Some(s1_m),
            s2_m: Some(s2_m),
            s1_sd_m: None,
            s2_sd_m: None,
            force1_n: None,
            force2_n: None,
        }
    }
}
