//! The log of a pivoting grasp: where the arm held the pivot and where the pad felt the contact, sample by sample. Plain data.

/// Pivot and contact over time. Times do not decrease.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PivotLog {
    /// One entry per sample.
    pub samples: Vec<PivotSample>,
    /// Period of small swings of the lifted object about the pivot, seconds, where somebody measured it.
    pub swing_period_s: Option<f64>,
}

/// One sample of such a log.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PivotSample {
    /// Time in seconds.
    pub time_s: f64,
    /// Pivot, X in the global frame, metres.
    pub pivot_x_m: f64,
    /// Pivot, Y in the global frame, metres; gravity acts along −Y.
    pub pivot_y_m: f64,
    /// Contact on the pad, metres along it from its base point; `None` where no contact was seen.
    pub s_m: Option<f64>,
}
