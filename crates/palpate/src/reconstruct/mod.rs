//! Log in, shape, motion and centre of mass out.
//!
//! [`reconstruct`](function@reconstruct) takes a log and leaves everything to it; a [`Reconstructor`] takes what is known besides: the
//! number of harmonics, the noise, another [method](Method), a [start](Start). Both run through these stages, each of which sees only
//! those before it and the kernel of the estimator (`estimate/`):
//!
//! 1. `search/`: segments between the jumps of the contacts, seeds from trial heights of the centre of mass, and a beam search that grows
//!    a seed over the whole log, through the jumps: arrangements of the log;
//! 2. `refine/`: one arrangement taken to the optimum over all samples: fit, number of harmonics, decoding of the motion, until nothing
//!    moves; then restarts along the weakest direction;
//! 3. `verdict/`: outline, motion, error bars and jumps of an optimum, and what it is worth;
//! 4. `selection`: which of several explanations is the answer, and whether it is the only one. Where it is not, the search goes on.
//!
//! `mistake/` names the mistake in how a log is written that no object explains, and `ordinary_rig` tries a log that no arrangement explains as one of a rig
//! that is not exact.
//!
//! `options/` is what may be set and `result/` what comes out.
//!
//! That is [`Method::Likelihood`]. [`smooth_from`] is its solver alone, with everything else given. `paper/` holds the methods that
//! integrate instead: the paper's own equations, and closed forms for the same by quadrature.

mod mistake;
mod options;
mod ordinary_rig;
mod paper;
mod reconstructor;
pub(crate) mod refine;
mod result;
mod search;
mod selection;
mod smooth_from;
mod start;
pub(crate) mod verdict;

pub(crate) use options::check::check_sample;

pub use crate::mechanics::Jump;
pub use mistake::Mistake;
pub use options::error::ReconstructError;
pub use options::limits::CertificateLimits;
pub use options::method::{Method, UnknownMethod};
pub use options::{FEWEST_SAMPLES, MOST_HARMONICS, Progress, ReconstructOptions};
pub use paper::given_start::{Integrated, PaperEquations};
pub use reconstructor::Reconstructor;
pub use result::calibration::{CalibrationEstimate, ConstantEstimate};
pub use result::diagnostics::{ContactDiagnostics, diagnostics};
pub use result::friction::{FrictionEstimate, friction};
pub use result::inertia::InertiaEstimate;
pub use result::measured_forces::{MeasuredForces, measured_forces};
pub use result::reconstruction::{FoundSymmetry, OutlinePoint, Pose, Reconstruction};
pub use result::strip::{CenterStrip, center_strips};
pub use smooth_from::{SmoothOptions, Smoothed, smooth_from};
pub use start::Start;
pub use verdict::certificate::Findings;
pub use verdict::doubt::{Cause, Doubt, Verdict};

pub use crate::estimate::solver::chord::Termination;

use crate::log::Log;

/// Reconstructs shape, motion and centre of mass from a palm log and nothing else, by maximum likelihood.
///
/// A [`Reconstructor`] does the same with more said of the problem, and tells how far it has come. The result does not depend on the
/// number of threads, and on one kind of processor the same log gives the same bits.
///
/// ```
/// use palpate::{Log, Sample, palms::PalmPair};
/// # use palpate::{plan::{PalmLimits, plan_turn}, shape::NamedShape, simulate::{SimulateOptions, simulate}};
/// # let egg = NamedShape::Egg.shape(0.03)?;
/// # let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
/// # let options = SimulateOptions { start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
/// # let felt = simulate(&egg, &plan.motion.sample(5.0)?, &options)?;
/// # let rows: Vec<[f64; 5]> = felt.log.samples.iter().map(|sample| {
/// #     [sample.time_s, sample.palms.phi1_rad, sample.palms.phi2_rad, sample.s1_m.unwrap(), sample.s2_m.unwrap()]
/// # }).collect();
/// // Time, both palm angles, both contacts: from a file, a robot, or an array.
/// let sample = |[t, phi1, phi2, s1, s2]: [f64; 5]| Sample::new(t, PalmPair::hinged(phi1, phi2), s1, s2);
/// let log = Log { samples: rows.into_iter().map(sample).collect() };
/// let found = palpate::reconstruct(&log)?;
/// assert!(found.is_certified(), "{}", found.verdict);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the log cannot be solved at all (see [`ReconstructError`]). A doubtful answer is not an error: it comes back as a
/// [`Reconstruction`] that is not certified, with the reasons in its [`verdict`](Reconstruction::verdict).
pub fn reconstruct(log: &Log) -> Result<Reconstruction, ReconstructError> {
    Reconstructor::new().run(log)
}
