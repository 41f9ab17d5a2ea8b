//! What is recovered from a log: options, results and their parts.

pub(crate) mod calibrate;
pub(crate) mod calibration;
pub(crate) mod doubt;
pub(crate) mod friction;
pub(crate) mod inertia;
pub(crate) mod information;
pub(crate) mod jump;
pub(crate) mod live;
pub(crate) mod reconstruct;
pub(crate) mod result;
pub(crate) mod rig_calibration;
pub(crate) mod symmetry;
