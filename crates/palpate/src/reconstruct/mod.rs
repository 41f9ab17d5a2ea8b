//! Log in, shape, motion and centre of mass out.
//!
//! [`reconstruct`] runs through these stages, a file each:
//!
//! 1. `noise`, `pieces`, `windows`: how noisy the log is, where the contacts leap, and what to look at;
//! 2. `start` (on the closed forms of `quadrature`): starts from nothing, over stretches that explain themselves;
//! 3. `grow`, `search`: from there over the whole log, through jumps, as several hypotheses;
//! 4. `task` (on `valley`): each of them taken to the optimum over all samples, by these three:
//! 5. `smooth` (on `residuals` and `problem`): maximum likelihood over all samples, every pose eliminated exactly;
//! 6. `evidence`: number of harmonics, noise and prior, by what the data say of them;
//! 7. `track` (on `place`, `tabulated` and `known`): the way of the shape through the log; samples put at a wrong pose are placed anew;
//! 8. `assemble` (on `posterior`, `felt`, `brief`): error bars, which boundary was felt, and what too few samples cannot tell;
//! 9. `jumps`, `certificate`, `judge`: is it right, and is it the only answer. When not, the search goes on.
//!
//! That is [`Method::Likelihood`]. `given` is the fifth stage alone, with everything else given. `integral` holds the methods that
//! integrate instead: `ode`, the paper's own (on rates from `smoothing`), and `quadrature`.

mod check;
mod diagnostics;
mod error;
mod method;
mod options;
mod paper;
mod reconstruction;
mod refine;
mod search;
mod selection;
mod smooth_from;
mod verdict;

pub use crate::mechanics::Jump;
pub use diagnostics::{ContactDiagnostics, diagnostics};
pub use error::ReconstructError;
pub use method::{Method, UnknownMethod};
pub use options::{FEWEST_SAMPLES, MOST_HARMONICS, Progress, ReconstructOptions};
pub use paper::given_start::{Integrated, PaperEquations};
pub use reconstruction::{OutlinePoint, Pose, Reconstruction};
pub use smooth_from::{SmoothOptions, Smoothed, smooth_from};
pub use verdict::doubt::{Doubt, Verdict};
pub use verdict::limits::CertificateLimits;

use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::log::Log;
use crate::shape::SupportFunction;

use check::{check_log, check_start};
use paper::initial_conditions as integral;
use refine::job::Task;
use search::schedule::{self, Found};
use search::segments::pieces;
use verdict::assemble::Judged;

/// Reconstructs shape, motion and centre of mass from a palm log and nothing else.
///
/// `progress` is called now and then from any thread. The result does not depend on the number of threads.
///
/// # Errors
/// When the log cannot be solved at all (see [`ReconstructError`]). A doubtful answer is not an error: it comes back as a
/// [`Reconstruction`] that is not certified.
pub fn reconstruct(
    log: &Log,
    options: &ReconstructOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Reconstruction, ReconstructError> {
    let tell = |stage, fraction| progress(Progress { stage, fraction });
    check_log(log, options)?;
    if options.method != Method::Likelihood {
        return integral::reconstruct(log, options, &|share| tell("integrating", share));
    }
    let task = Task::new(log, options);
    let mut best: Option<Judged> = None;
    let mut explanations = 0;
    let mut failure = None;
    schedule::search(
        &task.problem,
        task.scatter_m,
        task.prior,
        &|share| tell("searching for arrangements", 0.9 * share),
        &mut |found| {
            match task.judge(&found) {
                Ok(judged) => {
                    explanations += usize::from(judged.result.verdict.is_explained());
                    if best.as_ref().is_none_or(|other| judged.is_likelier_than(other)) {
                        best = Some(judged);
                    }
                }
                Err(error) => failure = Some(error),
            }
            best.as_ref().is_some_and(|judged| judged.is_enough(explanations))
        },
    );
    tell("done", 1.0);
    best.map(|judged| judged.result).ok_or_else(|| {
        failure.unwrap_or_else(|| ReconstructError::NoStart {
            advice: "check the units and signs of the palm angles and contact positions".to_owned(),
        })
    })
}

/// The same from a known start, one orientation per sample (radians) and a shape: nothing is searched for. For a log that
/// was solved before, or to see what the estimator could reach. Methods that integrate take their initial conditions from the start,
/// one for each piece between jumps, and nothing else.
///
/// # Errors
/// As [`reconstruct`]; also when `psi_rad` is not as long as the log.
pub fn reconstruct_from(
    log: &Log,
    shape: &SupportFunction,
    psi_rad: &[f64],
    options: &ReconstructOptions,
) -> Result<Reconstruction, ReconstructError> {
    check_log(log, options)?;
    check_start(log, psi_rad)?;
    if options.method != Method::Likelihood {
        return integral::reconstruct_from(log, shape, psi_rad, options);
    }
    let task = Task::new(log, options);
    let ranges = pieces(&task.problem, task.scatter_m);
    let mut coefficients = shape.coefficients();
    coefficients_to_order(&mut coefficients, START_ORDER);
    let estimate = Estimate { coefficients, psi: psi_rad.to_vec(), cost: 0.0 };
    let found = Found { thin: task.problem.clone(), ranges, estimates: vec![estimate] };
    let refined = task.refine(&found, 0)?;
    Ok(task.assemble(refined)?.result)
}

/// Harmonics that a given start is cut to before the number is chosen.
const START_ORDER: usize = 8;
