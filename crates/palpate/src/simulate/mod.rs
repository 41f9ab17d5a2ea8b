//! A known shape between two moving palms: what the touchpads would say, and what is true.

mod coverage;
mod error;
mod simulation;

pub use crate::mechanics::Jump;
pub use coverage::coverage;
pub use error::SimulateError;
pub use simulation::{ObjectInertia, SimulateOptions, Simulation, simulate, simulate_with};
