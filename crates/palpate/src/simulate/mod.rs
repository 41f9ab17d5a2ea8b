//! A known shape between two moving palms: what the touchpads would say, and what is true.

mod coverage;
mod error;
mod quasistatic;

pub use coverage::coverage;
pub use error::SimulateError;
pub use quasistatic::{SimulateOptions, Simulation, TimedJump, simulate};

// The former place of the planner, until the tests of `reconstruct` and the tasks of `xtask` name `crate::plan`.
#[doc(hidden)]
pub use crate::plan::{PalmLimits, PlanError, PlannedMotion, plan_jump_free, plan_turn};
