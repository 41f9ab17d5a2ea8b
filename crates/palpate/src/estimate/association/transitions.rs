//! Transition costs of the switching model (`docs/theory.md`, section on the decoded motion): −2 ln of the probability that an
//! object at one pose at one sample is at another pose at the next. Jumps that statics predicts are cheap, all others expensive.

use crate::estimate::association::candidates::Choice;
use crate::estimate::evidence::motion_prior::{EXCLUDED, PER_HALF_TURN, PREDICTED_JUMP, UNPREDICTED_JUMP};
use crate::estimate::measurements::Instant;
use crate::estimate::model::table::SupportTable;
use crate::estimate::motion::LONGEST_STEP;
use crate::estimate::work::Work;
use crate::math::angle::wrapped_to;
use crate::mechanics::passage::{SAME_POSE_RAD, barrier_m, carried};
use crate::mechanics::{EnergyLandscape, Forces};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::{PI, TAU};

/// Palms that turn by less than this from one sample to the next are at rest, radians: above it, the contacts of an object that does not turn
/// move by as much as those that count as still.
pub(crate) const PALMS_AT_REST_RAD: f64 = 0.01;

/// The signed turn from one angle to another, radians, at most half a period: poses that differ by a multiple of `period` are one (2π
/// for an object without symmetry of rotation).
pub(crate) fn turn(from: f64, to: f64, period: f64) -> f64 {
    wrapped_to(to - from, period)
}

/// Whether a step from one to the other is possible without a jump.
pub(crate) fn near(a: f64, b: f64, period: f64) -> bool {
    turn(a, b, period).abs() < LONGEST_STEP
}

/// Whether two orientations are one pose.
pub(crate) fn is_same_pose(a: f64, b: f64, period: f64) -> bool {
    turn(a, b, period).abs() < SAME_POSE_RAD
}

/// The sample that a step leads to.
pub(crate) struct Transition<'a> {
    pub shape: &'a SupportFunction,
    pub table: &'a SupportTable,
    pub instant: &'a Instant,
    /// Standard deviation of an energy barrier that errors of the shape cause, metres.
    pub barrier_sd_m: f64,
    /// Contacts that move by less than this between palms at rest did not jump, metres.
    pub still_m: f64,
    /// Whether that holds between palms that turn as well: the balance does not tell more.
    pub still_between_turning: bool,
    /// Poses that differ by a multiple of this are one, radians.
    pub period: f64,
    /// Where passages are counted.
    pub work: &'a Work,
}

impl Transition<'_> {
    /// The orientation at which an object that was at `psi` comes to rest.
    pub fn rest(&self, before: &Instant, psi: f64) -> f64 {
        if self.instant.palms.sin2 <= 0.0 || before.palms.sin2 <= 0.0 {
            return psi;
        }
        let palms = [before, self.instant].map(|instant| PalmPair::hinged(instant.phi1, instant.phi2));
        if let Some(rest) = EnergyLandscape::new(self.shape, &palms[1]).continued(psi) {
            return rest;
        }
        self.work.add_passages(1);
        carried(&Forces::default(), self.shape, &palms, psi).0
    }

    /// Whether both contacts were seen and neither jumped. Where the palms turned, a jump may by chance end with the contacts where they
    /// were: a nearly symmetric object does so again and again.
    pub fn still_since(&self, before: &Instant) -> bool {
        let moved = (self.instant.s1 - before.s1).abs().max((self.instant.s2 - before.s2).abs());
        let comparable = self.still_between_turning || before.palms_turn_to(self.instant) < PALMS_AT_REST_RAD;
        before.both_seen() && self.instant.both_seen() && comparable && moved < self.still_m
    }

    /// Energy barrier on the way from one orientation to another, as a rise of the centre of mass in metres: on the shorter path, or
    /// on the lower one, where the object has copies of a pose on both sides.
    pub fn barrier_m(&self, from: f64, to: f64) -> f64 {
        let over = |turn: f64| barrier_m(|psi| self.table.height_m(self.instant, psi), from, from + turn);
        let shorter = turn(from, to, self.period);
        if self.period < TAU { over(shorter).min(over(shorter - self.period.copysign(shorter))) } else { over(shorter) }
    }
}

/// The cost of each step from one sample's choices (outer) to those of the next (inner). With `blind`, statics is not consulted:
/// every jump costs what a predicted one does, plus its turn.
pub(crate) fn steps(ahead: &Transition, before: &Instant, from: &[Choice], to: &[Choice], blind: bool) -> Vec<f64> {
    let mut costs = Vec::with_capacity(from.len() * to.len());
    let still = ahead.still_since(before);
    let period = ahead.period;
    for start in from {
        // The pose that statics predicts from here: computed only when a choice lies elsewhere.
        let mut predicted = None;
        for end in to {
            costs.push(if near(start.psi, end.psi, period) {
                0.0
            } else if blind {
                PREDICTED_JUMP.deviance() + per_turn(start.psi, end.psi, period)
            } else {
                let rest = *predicted.get_or_insert_with(|| ahead.rest(before, start.psi));
                if is_same_pose(rest, end.psi, period) {
                    PREDICTED_JUMP.deviance()
                } else {
                    let barrier = ahead.barrier_m(start.psi, end.psi) / ahead.barrier_sd_m;
                    let unpredicted = UNPREDICTED_JUMP.deviance() + per_turn(start.psi, end.psi, period);
                    (PREDICTED_JUMP.deviance() + barrier * barrier).min(if still {
                        EXCLUDED.deviance()
                    } else {
                        unpredicted
                    })
                }
            });
        }
    }
    costs
}

/// Additional cost of a jump, proportional to its turn.
fn per_turn(from: f64, to: f64, period: f64) -> f64 {
    PER_HALF_TURN.deviance() * turn(from, to, period).abs() / PI
}
