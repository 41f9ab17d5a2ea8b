//! One arrangement taken to the optimum over all samples.

pub(crate) mod job;
pub(crate) mod resample;
pub(crate) mod restarts;
