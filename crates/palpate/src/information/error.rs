//! Why there is no information on a shape.

/// Why there is no information on a shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InformationError {
    /// Not one orientation for each sample.
    #[error("{orientations} orientations were given for {samples} samples of the log")]
    LengthsDiffer {
        /// Orientations that were given.
        orientations: usize,
        /// Samples of the log.
        samples: usize,
    },
    /// A number that is not finite, or not positive where it must be.
    #[error("{what}")]
    BadNumber {
        /// Which, with its value.
        what: String,
    },
    /// The log does not determine the shape: too few samples, or all of them alike.
    #[error("the log does not determine the shape; move the palms further, so that the object rolls")]
    NotDetermined,
}
