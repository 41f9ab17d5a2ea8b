//! What was measured, or simulated in its place: logs, sensors and the truth behind them.

pub(crate) mod log;
pub(crate) mod rig;
pub(crate) mod sensor;
pub(crate) mod simulate;
pub(crate) mod truth;
