//! The prior on the motion.

use crate::estimate::measurements::Problem;
use crate::estimate::model::contact::residuals;
use crate::estimate::motion::{standing_out, unwrap};
use crate::estimate::solver::gauss_newton::Estimate;

/// What is against a motion beforehand, in ln of the odds: leaps are rare, and poses that would not be at rest rarer. Without
/// this, more harmonics than the object has would be paid for by poses to choose from: each sample takes the one that suits
/// its noise.
pub(crate) fn wonder(problem: &Problem, estimate: &Estimate, balance_m: f64) -> f64 {
    let mut psi = estimate.psi.clone();
    unwrap(&mut psi);
    let leaps = standing_out(&psi).len();
    let restless = problem
        .instants
        .iter()
        .zip(&estimate.psi)
        .filter(|(instant, psi)| residuals(instant, &estimate.coefficients, **psi).is_restless(balance_m))
        .count();
    LEAP * leaps as f64 + RESTLESS * restless as f64
}

/// ln of the odds against a leap from one sample to the next: some five of a thousand samples have one.
pub(crate) const LEAP: f64 = 5.0;

/// ln of the odds against a pose that is no minimum of the potential energy.
pub(crate) const RESTLESS: f64 = 5.0;

/// A pose counts as certain when every way elsewhere costs this much more (−2 ln of the odds: 150 to 1).
pub(crate) const CERTAIN: f64 = 10.0;
