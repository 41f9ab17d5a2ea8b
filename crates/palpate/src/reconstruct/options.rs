//! What a user may set, what is told while working, and what can go wrong.

/// Options of [`reconstruct`](super::reconstruct); the default leaves everything to the data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReconstructOptions {
    /// Number of harmonics K of the support function; `None` = chosen by the evidence, or 12 by the methods that integrate.
    pub harmonics: Option<usize>,
    /// Standard deviation of the contact positions in metres; `None` = stated by the log, or estimated from it.
    pub sensor_sd_m: Option<f64>,
    /// How to reconstruct; maximum likelihood if not chosen.
    pub method: Method,
}

/// A way from the log to shape and motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Maximum likelihood over all samples, with error bars and a certificate.
    #[default]
    Likelihood,
    /// Equations 19 to 21 of Moll & Erdmann (2001), integrated by a fourth-order Adams-Bashforth-Moulton method. Never certified.
    Ode,
    /// Closed forms for the same by quadrature (trapezoid rule, second order). Never certified.
    Quadrature,
}

impl std::fmt::Display for Method {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Likelihood => "likelihood",
            Self::Ode => "ode",
            Self::Quadrature => "quadrature",
        })
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

/// Why a log cannot be reconstructed at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReconstructError {
    /// Too few samples with both contacts seen.
    #[error("the log has {seen} samples with both contacts seen; at least {needed} are needed to solve for a shape")]
    TooFewSamples {
        /// Samples with both contacts.
        seen: usize,
        /// Fewest that can be solved.
        needed: usize,
    },
    /// A value that no palm log can have.
    #[error("sample {sample} (counted from 1): {what}")]
    BadSample {
        /// Number of the sample, from 1.
        sample: usize,
        /// What is wrong with it.
        what: String,
    },
    /// No height of the centre of mass is possible at all samples: the log contradicts itself.
    #[error("no object can rest between the palms as the log tells it; {advice}")]
    NoStart {
        /// What to look at.
        advice: String,
    },
    /// The log says so little, or numbers so extreme, that no shape comes out.
    #[error("the log does not determine any shape; move the palms further, so that the object rolls")]
    NotSolvable,
    /// An option out of its range.
    #[error("{0}")]
    BadOption(String),
}
