//! A known shape between two moving palms: what the touchpads would say, and what is true.

mod coverage;
mod error;
mod quasistatic;

pub use crate::mechanics::Jump;
pub use coverage::coverage;
pub use error::SimulateError;
pub use quasistatic::{SimulateOptions, Simulation, simulate, simulate_with};
