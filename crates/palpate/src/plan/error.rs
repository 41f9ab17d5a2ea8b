//! Why a motion could not be planned.

use thiserror::Error;

use crate::palms::MotionError;

/// Why no motion was planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// Nothing but jumps, or no stable pose within the limits.
    #[error("no motion without a jump was found for this object within the limits of the palms")]
    NoMotion,
    /// Friction holds the object wherever the palms go.
    #[error(
        "no motion of the palms was found that turns this object without a jump: with friction of {:.2} on palm 1 and {:.2} on palm 2 it sticks where it \
         should slide, or jams; let the palms open wider, or use slicker ones",
        coefficients[0], coefficients[1]
    )]
    Sticks {
        /// Coefficients of friction of palm 1 and palm 2.
        coefficients: [f64; 2],
    },
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
