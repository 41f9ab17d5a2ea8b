//! What a user may set, and what is told while working.

pub(crate) mod check;
pub(crate) mod error;
pub(crate) mod limits;
pub(crate) mod method;

use crate::sensor::Rig;
use limits::CertificateLimits;
use method::Method;

/// Fewest samples with both contacts seen that are tried.
pub const FEWEST_SAMPLES: usize = 12;

/// Most harmonics that a user may ask for.
pub const MOST_HARMONICS: usize = 64;

/// The options of a [`Reconstructor`](crate::reconstruct::Reconstructor) as plain data, for a program that holds them in a file or
/// takes them from its user; the default leaves everything to the log.
///
/// ```
/// use palpate::reconstruct::{Method, ReconstructOptions, Reconstructor};
/// let options = ReconstructOptions::default().with_harmonics(8).with_method(Method::Ode);
/// let reconstructor = Reconstructor::from(options);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[non_exhaustive]
pub struct ReconstructOptions {
    /// Number of harmonics K of the support function; `None` = chosen by the evidence, or 12 by the methods that integrate.
    pub harmonics: Option<usize>,
    /// Standard deviation of the contact positions in metres; `None` = stated by the log, or estimated from it.
    pub sensor_sd_m: Option<f64>,
    /// How to reconstruct; maximum likelihood if not chosen.
    pub method: Method,
    /// What the certificate asks.
    pub limits: CertificateLimits,
    /// What is known of the rig; by default readings are taken as they are.
    pub rig: Rig,
}

impl ReconstructOptions {
    /// The same with another number of harmonics; `None` leaves it to the log.
    #[must_use]
    pub fn with_harmonics(self, harmonics: impl Into<Option<usize>>) -> Self {
        Self { harmonics: harmonics.into(), ..self }
    }

    /// The same with another standard deviation of the contact positions, metres; `None` leaves it to the log.
    #[must_use]
    pub fn with_sensor_sd_m(self, sensor_sd_m: impl Into<Option<f64>>) -> Self {
        Self { sensor_sd_m: sensor_sd_m.into(), ..self }
    }

    /// The same with another method.
    #[must_use]
    pub fn with_method(self, method: Method) -> Self {
        Self { method, ..self }
    }

    /// The same with another rig.
    #[must_use]
    pub fn with_rig(self, rig: Rig) -> Self {
        Self { rig, ..self }
    }

    /// The same with other limits of the certificate.
    #[must_use]
    pub fn with_limits(self, limits: CertificateLimits) -> Self {
        Self { limits, ..self }
    }
}

/// How far the work has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done, in a few words.
    pub stage: &'static str,
    /// Share of the whole work that is done, 0 to 1, never decreasing.
    pub fraction: f64,
}
