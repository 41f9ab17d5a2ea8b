//! Refinement of one arrangement to the optimum over all samples (`docs/theory.md`, the search).

pub(crate) mod by_contact;
mod by_friction;
mod by_inertia;
pub(crate) mod calibrated;
pub(crate) mod hidden_jumps;
pub(crate) mod job;
pub(crate) mod resample;
pub(crate) mod restarts;
mod rough_calibration;
pub(crate) mod symmetric;
