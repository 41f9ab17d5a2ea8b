//! The kernel of the estimator: measurements, models of noise and shape, the solver, the evidence, and the association of poses
//! with samples. It depends on no search, verdict or file. Each folder depends only on those before it:
//!
//! 1. [`work`], [`measurements`], [`thinning`], [`motion`], [`jumps`], [`coverage`], [`closed_form`]: a log prepared, motions of the object and their jumps,
//!    boundary that was felt, and motion and size from a trial height of the centre of mass;
//! 2. [`model`]: residuals and their derivatives, noise, prior;
//! 3. [`solver`]: maximum likelihood over all samples, every orientation eliminated exactly, and the posterior at the optimum;
//! 4. [`calibration`]: the constants of the rig as unknowns that all samples share;
//! 5. [`friction`]: rolling, and centre of mass and friction from form and motion;
//! 6. [`inertia`]: shape, motion and inertia together, where palms are fast;
//! 7. [`evidence`]: number of harmonics, noise and scale of the prior by the evidence;
//! 8. [`association`]: which of its possible poses each sample has, and how ambiguous that is.

pub(crate) mod association;
pub(crate) mod calibration;
pub(crate) mod closed_form;
pub(crate) mod coverage;
pub(crate) mod evidence;
pub(crate) mod friction;
pub(crate) mod inertia;
pub(crate) mod jumps;
pub(crate) mod measurements;
pub(crate) mod model;
pub(crate) mod motion;
pub(crate) mod solver;
pub(crate) mod thinning;
pub(crate) mod work;
