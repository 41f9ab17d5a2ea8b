//! Sweeps: thousands of palm logs, simulated or recorded, reconstructed one by one and scored against the truth.
//!
//! A [`Plan`](plan::Plan) is a small TOML file that says what to try. It unfolds into a [`Sweep`]: a list of [`Job`]s, each of
//! them plain data, addressed by its place in the list; the same again whenever it is run on one kind of processor and one platform. A job gives an [`Outcome`]: one [`Row`]
//! of the table, and the seconds it took, which are kept apart because they differ from run to run.
//!
//! ```
//! use palpate_sweep::{Sweep, parse_plan};
//!
//! let plan = parse_plan("egg.toml", r#"
//!     kind = "simulate"
//!     trials = 3
//!     samples = 200
//!     motions = "random"
//!     touchpads = [{ noise_sd_m = [0.1e-3, 0.3e-3] }]
//!     objects.named = { name = "egg", mean_radius_m = 0.03 }
//! "#)?;
//! let sweep = Sweep::new(&plan, ".".as_ref())?;
//! assert_eq!(sweep.jobs.len(), 6);
//!
//! let row = sweep.outcome(4).expect("one of six").row;
//! assert_eq!((row.object.as_str(), row.seed, row.noise_sd_m), ("egg", Some(2), Some(0.3e-3)));
//! # Ok::<(), palpate_sweep::PlanError>(())
//! ```
//!
//! [`Sweep::run`] does all jobs on the threads of this machine; [`Sweep::run_in`] does so in a folder: what is finished is kept in a
//! [journal], so that a sweep that was killed resumes where it was. The table has its rows in the order of the jobs, so
//! that its bytes depend neither on the number of threads nor on how often the sweep was interrupted. Whoever has other machines
//! to do the jobs opens a folder by [`Sweep::open`] and hands the [`SweepFolder`] what comes back. Folders come with the feature
//! `parquet`, which is on unless it is switched off; without it a sweep builds in a fraction of the time and runs in memory.
#![forbid(unsafe_code)]

pub mod columns;
mod digest;
#[cfg(feature = "parquet")]
mod folder;
mod job;
pub mod plan;
mod sweep;
mod sweep_error;
mod threads;

#[cfg(feature = "parquet")]
pub use folder::{SweepFolder, journal, table};
pub use job::forces::{ActingForces, DrawnForces, ForcesJob};
pub use job::log_job::LogJob;
pub use job::object::{Object, ShapeName};
pub use job::row::{Row, Status};
pub use job::score::{BAND_95_SDS, ReconstructChoice, ScoreChoice};
pub use job::simulate_job::{MotionKind, NoLog, SimulateJob, Simulated};
pub use job::touchpad::Touchpads;
pub use job::varied::{Conditions, MotionConditions, MotionShape, NoiseShape, SensorConditions, VariedJob};
pub use job::{Job, Outcome, Source};
pub use plan::plan_error::{PlanError, PlanProblem};
pub use plan::{parse_plan, read_plan, read_touchpad};
pub use sweep::{Done, Sweep};
pub use sweep_error::SweepError;
