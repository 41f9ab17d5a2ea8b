//! Log in, shape, motion and centre of mass out.
//!
//! [`reconstruct`](function@reconstruct) takes a log and leaves everything to it; a [`Reconstructor`] takes what is known besides: the
//! number of harmonics, the noise, another [method](Method), a [start](Start). Both run through these stages, a file each:
//!
//! 1. `noise`, `pieces`, `windows`: how noisy the log is, where the contacts leap, and what to look at;
//! 2. `start` (on the closed forms of `quadrature`): starts from nothing, over stretches that explain themselves;
//! 3. `grow`, `search`: from there over the whole log, through jumps, as several hypotheses;
//! 4. `job` (on `valley`): each of them taken to the optimum over all samples, by these three:
//! 5. `smooth` (on `residuals` and `measurements`): maximum likelihood over all samples, every pose eliminated exactly;
//! 6. `evidence`: number of harmonics, noise and prior, by what the data say of them;
//! 7. `track` (on `place`, `tabulated` and `known`): the way of the shape through the log; samples put at a wrong pose are placed anew;
//! 8. `assemble` (on `posterior`, `felt`, `brief`): error bars, which boundary was felt, and what too few samples cannot tell;
//! 9. `jumps`, `certificate`, `judge`: is it right, and is it the only answer. When not, the search goes on.
//!
//! That is [`Method::Likelihood`]. [`smooth_from`] is the fifth stage alone, with everything else given. `paper` holds the methods that
//! integrate instead: the paper's own equations, and closed forms for the same by quadrature.

mod check;
mod diagnostics;
mod error;
mod method;
mod options;
mod paper;
mod reconstruction;
mod reconstructor;
mod refine;
mod search;
mod selection;
mod smooth_from;
mod start;
mod verdict;

pub use crate::mechanics::Jump;
pub use diagnostics::{ContactDiagnostics, diagnostics};
pub use error::ReconstructError;
pub use method::Method;
pub use options::{FEWEST_SAMPLES, MOST_HARMONICS, Progress, ReconstructOptions};
pub use paper::given_start::{Integrated, PaperEquations};
pub use reconstruction::{OutlinePoint, Pose, Reconstruction};
pub use reconstructor::Reconstructor;
pub use smooth_from::{SmoothOptions, Smoothed, smooth_from};
pub use start::Start;
pub use verdict::certificate::Findings;
pub use verdict::doubt::{Doubt, Verdict};
pub use verdict::limits::CertificateLimits;

pub use crate::estimate::solver::chord::Termination;

use crate::log::Log;

/// Reconstructs shape, motion and centre of mass from a palm log and nothing else, by maximum likelihood.
///
/// A [`Reconstructor`] does the same with more said of the problem, and tells how far it has come. The result does not depend on the
/// number of threads, and the same log gives the same bits.
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
