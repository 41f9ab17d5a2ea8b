//! The second rig, a pivoting grasp: its logs, simulated ones, what is reconstructed of them, and the strokes to come.

pub(crate) mod live;
pub(crate) mod log;
pub(crate) mod plan;
pub(crate) mod reconstruct;
pub(crate) mod result;
pub(crate) mod simulate;
