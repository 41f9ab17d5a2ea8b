//! The prior on the motion, in nats: what an object at rest between slow palms does rarely, and how rarely.
//!
//! Without it more harmonics than the object has would be paid for by poses to choose from, each sample taking the one that suits
//! its noise. The same numbers rank arrangements and numbers of harmonics ([`neg_log_prior`]) and decode the motion
//! ([`crate::estimate::association`]).

use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::residuals;
use crate::estimate::motion::{outlying_steps, unwrap_to};
use crate::estimate::solver::gauss_newton::Estimate;

/// −ln of a probability.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(crate) struct Nats(pub f64);

impl Nats {
    /// −2 ln of the same, which adds to squared standard deviations.
    pub const fn deviance(self) -> f64 {
        2.0 * self.0
    }
}

/// A jump that statics predicts (the pose before vanishes, and the object goes downhill to the pose after): some seven of a
/// thousand samples have one, 150 to 1.
pub(crate) const PREDICTED_JUMP: Nats = Nats(5.0);

/// A jump that statics does not predict, and what more if it is by half a turn: an object does not turn there and back to come
/// from one pose to another.
pub(crate) const UNPREDICTED_JUMP: Nats = Nats(10.0);
pub(crate) const PER_HALF_TURN: Nats = Nats(20.0);

/// Such a jump where friction or pace spoil the balance, and no contact moved, or over a barrier that is certain. Excluded: otherwise a
/// symmetric object could flip at no cost wherever the balance does not hold for long.
pub(crate) const EXCLUDED: Nats = Nats(500.0);

/// A sample that rests at a pose that is no minimum of the potential energy.
pub(crate) const UNSTABLE_POSE: Nats = Nats(10.0);

/// A pose counts as certain when every way elsewhere costs this much more: 150 to 1.
pub(crate) const CERTAIN: Nats = Nats(5.0);

/// −ln of the prior probability of a motion: its jumps and its unstable poses. `balance_m` is the standard deviation of the
/// balance; poses that differ by a multiple of `period` are one.
pub(crate) fn neg_log_prior(measurements: &Measurements, estimate: &Estimate, balance_m: f64, period: f64) -> f64 {
    let mut psi = estimate.psi.clone();
    unwrap_to(&mut psi, period);
    let jumps = outlying_steps(&psi).len();
    let poses = measurements.instants.iter().zip(&estimate.psi);
    let unstable =
        poses.filter(|(instant, psi)| residuals(instant, &estimate.coefficients, **psi).is_unstable(balance_m)).count();
    PREDICTED_JUMP.0 * jumps as f64 + UNSTABLE_POSE.0 * unstable as f64
}
