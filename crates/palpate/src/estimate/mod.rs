//! The kernel of the estimator: what it knows of measurements, noise and shape, its solver, the evidence, and which pose belongs to which
//! sample. It knows no search, no verdict and no file. Each folder sees only those before it:
//!
//! 1. [`measurements`], [`motion`], [`jumps`], [`coverage`], [`closed_form`]: a log made ready, motions of the object, where it jumps in
//!    one, boundary that was felt, and motion and size from a trial height of the centre of mass;
//! 2. [`model`]: residuals and their derivatives, noise, prior;
//! 3. [`solver`]: maximum likelihood over all samples, every orientation eliminated exactly, and the posterior that it leaves;
//! 4. [`evidence`]: number of harmonics, noise and prior by what the data say of them;
//! 5. [`association`]: which of its possible poses each sample has, and how sure that is.

pub(crate) mod association;
pub(crate) mod closed_form;
pub(crate) mod coverage;
pub(crate) mod evidence;
pub(crate) mod jumps;
pub(crate) mod measurements;
pub(crate) mod model;
pub(crate) mod motion;
pub(crate) mod solver;
