//! The search for a start from nothing but the log (`docs/theory.md`, the search): segments between jumps, windows, seeds from
//! the closed forms, and a beam search over the whole log, scheduled by the normalized misfit; and for objects that swing, a search of its own
//! (`in_motion`).

pub(crate) mod beam;
pub(crate) mod in_motion;
pub(crate) mod initial_height;
pub(crate) mod problem;
pub(crate) mod schedule;
pub(crate) mod seed;
pub(crate) mod segments;
pub(crate) mod tolerance;
pub(crate) mod windows;
