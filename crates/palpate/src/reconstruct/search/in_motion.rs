//! The search for the motion of an object with inertia (`docs/theory.md`, inertia): seeds from the differential equation that the contacts drive, each grown
//! over the log from both its ends. A motion with inertia has no jumps, so that one way is all there is.

mod growth;
mod seed;

use self::growth::Stretch;
use self::seed::{Seed, Window};
use crate::estimate::inertia::contact_driven::ContactPath;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::log::Log;
use crate::mechanics::STANDARD_GRAVITY_M_PER_S2;
use crate::reconstruct::search::schedule::Found;
use crate::sensor::Calibration;

/// Windows that are searched for a seed: those with the longest ways of the contacts.
const WINDOWS: usize = 8;

/// Share of the log over which the motion must be known: the forces place the rest.
const MOSTLY: f64 = 0.75;

/// Samples that are further apart than this, in units of the time of the object, tell no swing: a swing lasts about six of them.
const LONGEST_INTERVAL: f64 = 1.5;

/// Harmonics of seeds and of what grows from them.
const ORDER: usize = 8;

/// Standard deviation of a contact position and of the moment of the forces, as a share of the size: what few harmonics and a way through noise leave.
const TOLERANCE: f64 = 0.01;

/// What is searched.
pub(crate) struct Readings<'a> {
    /// As a rig without errors reads it, and what that was corrected by.
    pub log: &'a Log,
    pub calibration: Calibration,
    pub measurements: &'a Measurements,
    /// Standard deviation of a contact position from one sample to the next, metres.
    pub scatter_m: f64,
    pub prior: Prior,
}

impl Readings<'_> {
    /// The time in which an object of that size falls by half of it: that of all its motions.
    fn unit_s(&self) -> f64 {
        (self.prior.size_m / STANDARD_GRAVITY_M_PER_S2).sqrt()
    }

    /// Whether samples follow each other so fast that they tell how an object of that size swings.
    fn tells_swings(&self) -> bool {
        let [Some(first), Some(last)] = [self.log.samples.first(), self.log.samples.last()] else { return false };
        let interval_s = (last.time_s - first.time_s) / self.log.samples.len() as f64;
        self.tolerance_m().is_finite() && interval_s <= LONGEST_INTERVAL * self.unit_s()
    }

    fn tolerance_m(&self) -> f64 {
        self.scatter_m.hypot(TOLERANCE * self.prior.size_m)
    }
}

/// The motion over all of the log or most of it, where inertia explains that.
pub(crate) fn search_in_motion(readings: &Readings) -> Option<Found> {
    if !readings.tells_swings() {
        return None;
    }
    let path = ContactPath::new(readings.log, readings.measurements)?;
    let seeds =
        Window::liveliest(readings, WINDOWS).into_iter().filter_map(|window| Seed::new(readings, &path, &window));
    let mut stretches: Vec<Stretch> = Vec::new();
    for seed in seeds {
        let Some(stretch) = Stretch::new(readings, &path, seed).map(Stretch::longest) else { continue };
        let is_whole = stretch.is_whole();
        stretches.push(stretch);
        if is_whole {
            break;
        }
    }
    let mut grown = stretches.into_iter().max_by_key(Stretch::len)?;
    while !grown.is_whole() {
        let Some(richer) = grown.richer() else { break };
        grown = richer.longest();
    }
    if !grown.is_share(MOSTLY) {
        return None;
    }
    let psi = grown.motion();
    let range = grown.range();
    Some(Found {
        calibration: readings.calibration,
        tolerance_m: readings.tolerance_m(),
        thin: readings.measurements.of(readings.measurements.instants[range.clone()].to_vec()),
        ranges: vec![range],
        estimates: vec![Estimate { coefficients: grown.unknowns.coefficients, psi, cost: f64::INFINITY }],
    })
}

#[cfg(test)]
mod tests;
