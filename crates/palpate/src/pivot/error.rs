//! Why strokes cannot be simulated or planned, and why a log of them cannot be reconstructed.

use thiserror::Error;

/// Why a simulation was refused. Lengths are metres.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PivotSimulateError {
    /// The shape is not an object.
    #[error("the shape is not a convex object: its smallest radius of curvature is {smallest_m} m")]
    NotConvex {
        /// Smallest radius of curvature, metres, or NaN.
        smallest_m: f64,
    },
    /// The pivot is not inside the object.
    #[error(
        "the pivot is not inside the object: the support function about it is as small as {least_m} m; move the pivot inside"
    )]
    PivotOutside {
        /// Smallest support function, metres.
        least_m: f64,
    },
    /// There is nothing to do.
    #[error("there are no strokes; give at least one place along the pad")]
    NoStrokes,
    /// A number is out of range.
    #[error("{what}")]
    OutOfRange {
        /// What, with its range.
        what: &'static str,
    },
}

/// Why a log of strokes cannot be reconstructed at all.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum PivotReconstructError {
    /// Too few samples with a contact.
    #[error("the log has {seen} samples with a contact; at least {needed} are needed to solve for a shape")]
    TooFewSamples {
        /// Samples with a contact.
        seen: usize,
        /// Fewest that can be solved.
        needed: usize,
    },
    /// A value that no log can have.
    #[error("sample {sample} (counted from 1): {what}")]
    BadSample {
        /// Number of the sample, from 1.
        sample: usize,
        /// What is wrong with it.
        what: String,
    },
    /// The log says so little that no shape comes out.
    #[error(
        "the log does not determine any shape: height of the pivot and offset of the contact hardly change; drag the pivot further, so that the object turns"
    )]
    NotSolvable,
    /// An option or a number of the rig out of its range.
    #[error("{0}")]
    BadOption(String),
}
