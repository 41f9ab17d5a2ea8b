//! What a user may set, what is told while working, and what can go wrong.

use super::method::Method;
use crate::reconstruct::verdict::limits::CertificateLimits;

/// Fewest samples with both contacts seen that are tried.
pub const FEWEST_SAMPLES: usize = 12;

/// Most harmonics that a user may ask for.
pub const MOST_HARMONICS: usize = 64;

/// Options of [`reconstruct`](super::reconstruct); the default leaves everything to the data.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
pub struct ReconstructOptions {
    /// Number of harmonics K of the support function; `None` = chosen by the evidence, or 12 by the methods that integrate.
    pub harmonics: Option<usize>,
    /// Standard deviation of the contact positions in metres; `None` = stated by the log, or estimated from it.
    pub sensor_sd_m: Option<f64>,
    /// How to reconstruct; maximum likelihood if not chosen.
    pub method: Method,
    /// What the certificate asks.
    pub limits: CertificateLimits,
}

/// How far the work has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done, in a few words.
    pub stage: &'static str,
    /// Share of the whole work that is done, 0 to 1, never decreasing.
    pub fraction: f64,
}
