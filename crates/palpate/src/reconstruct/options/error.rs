//! Why a log cannot be reconstructed at all.

/// Why a log cannot be reconstructed at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    /// A start that is not of this log.
    #[error("the start has {orientations} orientations and the log {samples} samples: it needs one for each")]
    StartOfOtherLength {
        /// Orientations that were given.
        orientations: usize,
        /// Samples of the log.
        samples: usize,
    },
    /// An option out of its range.
    #[error("{0}")]
    BadOption(String),
}
