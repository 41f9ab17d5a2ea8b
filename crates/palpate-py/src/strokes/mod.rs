//! The second rig, a pivoting grasp: its logs, simulated ones, and what is reconstructed of them.

pub(crate) mod log;
pub(crate) mod reconstruct;
pub(crate) mod result;
pub(crate) mod simulate;
