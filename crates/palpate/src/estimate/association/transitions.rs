//! What it costs the object to go from a pose at one sample to a pose at the next.

use crate::estimate::association::candidates::Choice;
use crate::estimate::measurements::Instant;
use crate::estimate::model::table::Tabulated;
use crate::math::angle::wrapped;
use crate::mechanics::EnergyLandscape;
use crate::mechanics::frictionless::followed;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::PI;

/// Steps beyond this from one sample to the next need a reason, radians.
pub(crate) const LONGEST_STEP: f64 = 0.15;

/// What a fall costs that statics foretells (the pose before vanishes, and the object goes downhill to the pose after), in
/// squared standard deviations as everything here: −2 ln of how rarely one sample in a log has it, some five of a thousand.
pub(crate) const FALL: f64 = 10.0;

pub(crate) const HALF_TURN: f64 = 40.0;

/// What a leap costs that statics does not foretell, and what more if it is by half a turn: an object does not turn to and fro
/// to come from one pose to another.
pub(crate) const LEAP: f64 = 20.0;

/// What such a leap costs where friction or pace spoil the balance, and no contact leapt. It cannot be: an object that looks
/// the same after half a turn would else turn wherever the balance is spoilt for long.
pub(crate) const MIRACLE: f64 = 1000.0;

/// Orientations closer than this are one, radians.
pub(crate) const SAME: f64 = 0.06;

/// The way from one angle to another, radians, at most half a turn.
pub(crate) fn turn(from: f64, to: f64) -> f64 {
    wrapped(to - from)
}

/// Whether a step from one to the other needs no reason.
pub(crate) fn near(a: f64, b: f64) -> bool {
    turn(a, b).abs() < LONGEST_STEP
}

pub(crate) fn same(a: f64, b: f64) -> bool {
    turn(a, b).abs() < SAME
}

/// The sample that a step leads to.
pub(crate) struct Ahead<'a> {
    pub shape: &'a SupportFunction,
    pub table: &'a Tabulated,
    pub instant: &'a Instant,
    pub hill_sd_m: f64,
    /// Contacts that move by less did not leap, metres; 0 where that is not asked.
    pub still_m: f64,
}

impl Ahead<'_> {
    /// Where an object that was at `psi` comes to rest.
    pub fn rest(&self, before: &Instant, psi: f64) -> f64 {
        if self.instant.palms.sin2 <= 0.0 || before.palms.sin2 <= 0.0 {
            return psi;
        }
        let [from, to] = [before, self.instant].map(|instant| PalmPair::hinged(instant.phi1, instant.phi2));
        if let Some(rest) = EnergyLandscape::new(self.shape, &to).continued(psi) {
            return rest;
        }
        followed(self.shape, &from, &to, psi).0
    }

    /// Whether both contacts were seen and neither leapt.
    pub fn still_since(&self, before: &Instant) -> bool {
        let moved = (self.instant.s1 - before.s1).abs().max((self.instant.s2 - before.s2).abs());
        before.both_seen() && self.instant.both_seen() && moved < self.still_m
    }

    /// How far the centre of mass would have to rise on the way from one orientation to another, metres.
    pub fn hill_m(&self, from: f64, to: f64) -> f64 {
        const STEPS: usize = 32;
        let way = turn(from, to);
        let height = |psi: f64| self.table.height_m(self.instant, psi);
        let highest = (1..=STEPS).map(|step| height(from + way * step as f64 / STEPS as f64)).fold(0.0, f64::max);
        (highest - height(from)).max(0.0)
    }
}

/// The cost of each step from one sample's choices (outer) to those of the next (inner). `blind` asks nothing of statics.
pub(crate) fn steps(ahead: &Ahead, before: &Instant, from: &[Choice], to: &[Choice], blind: bool) -> Vec<f64> {
    let mut costs = Vec::with_capacity(from.len() * to.len());
    let still = ahead.still_since(before);
    for start in from {
        // Where the object would go from here: looked up only when a choice lies elsewhere.
        let mut foretold = None;
        for end in to {
            costs.push(if near(start.psi, end.psi) {
                0.0
            } else if blind {
                FALL + HALF_TURN * turn(start.psi, end.psi).abs() / PI
            } else {
                let rest = *foretold.get_or_insert_with(|| ahead.rest(before, start.psi));
                if same(rest, end.psi) {
                    FALL
                } else {
                    let hill = ahead.hill_m(start.psi, end.psi) / ahead.hill_sd_m;
                    let unforeseen = LEAP + HALF_TURN * turn(start.psi, end.psi).abs() / PI;
                    (FALL + hill * hill).min(if still { MIRACLE } else { unforeseen })
                }
            });
        }
    }
    costs
}
