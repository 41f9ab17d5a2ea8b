//! Why a motion could not be planned.

use thiserror::Error;

use crate::palms::MotionError;

/// Why no motion was planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// Nothing but jumps, or no stable pose within the limits.
    #[error("no motion without a jump was found for this object within the limits of the palms")]
    NoMotion,
    /// The shape or a limit is out of range.
    #[error("{what} is out of range")]
    OutOfRange {
        /// Which.
        what: &'static str,
    },
    /// From the motion itself.
    #[error(transparent)]
    Motion(#[from] MotionError),
}
