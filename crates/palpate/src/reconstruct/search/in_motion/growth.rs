//! A stretch of a log whose motion is known with inertia, and how it grows: the contacts drive the object on from its last state (or back from its first),
//! and shape, motion and inertia are brought to their optimum over all of it.

use super::Readings;
use super::seed::Seed;
use crate::estimate::inertia::contact_driven::{ContactPath, InMotion, Passed, carried, driven};
use crate::estimate::inertia::problem::{InertiaPrior, Problem, Unknowns};
use crate::estimate::inertia::smoother::{InertialNoise, Point};
use crate::estimate::model::layout::{Layout, coefficients_to_order};
use crate::estimate::solver::levenberg_marquardt::Effort;
use crate::log::Log;
use crate::math::spline::SplineBasis;
use crate::mechanics::inertial::Inertia;
use crate::reconstruct::search::seed::ORDERS;
use crate::sensor::{Calibration, Rig};
use crate::shape::SupportFunction;
use std::ops::Range;

/// By how much a stretch grows at first and at least, and at most where the contacts drive it, in units of the time of the object; and at most as a share of
/// its length where its shape carries it.
const FIRST_REACH: f64 = 4.0;
const LEAST_REACH: f64 = 0.7;
const MOST_DRIVEN: f64 = 12.0;
const SHARE: f64 = 0.5;

/// Failures after which a stretch grows no farther: those of a wrong seed creep on.
const MOST_FAILURES: usize = 12;

/// Factors by which that changes after a success and after a failure.
const FARTHER: f64 = 1.5;
const NEARER: f64 = 0.5;

/// Pieces of the spline in that unit, by how much shorter they are where those lead no farther, and steps of the way.
const PIECES: f64 = 1.3;
const FINER: f64 = 1.6;
const STEPS: f64 = 6.0;

/// Of a fit, from afar.
const EFFORT: Effort = Effort { steps: 12, tolerance: 1e-3, follows_valleys: false };

/// Standard deviations of ln k² about that of an even mass and of the damping: short stretches tell little of either.
const LN_GYRATION_SD: f64 = 0.2;
const DAMPING_SD_PER_S: f64 = 1.0;

/// A radius of gyration that is further from that of an even mass (a factor of 1.5) is that of a wrong motion.
const FURTHEST_SDS: f64 = 4.0;

/// Largest root mean square of the residuals of contacts and of forces of what is explained, as a multiple of the tolerance.
const EXPLAINED: f64 = 1.4;

/// The next fit is with so many times that of the last, and with forces of this share of the size at least: loose forces would have the radius of gyration
/// anywhere.
const LOOSER: f64 = 2.0;
const LEAST_FORCES: f64 = 1e-3;

/// Harmonics at most.
const MOST_ORDER: usize = 28;

/// A part of a log, from a sample to another, with all that is estimated of it.
#[derive(Clone)]
pub(super) struct Stretch<'a> {
    readings: &'a Readings<'a>,
    path: &'a ContactPath,
    range: Range<usize>,
    basis: SplineBasis,
    pub unknowns: Unknowns,
    /// Pieces of the spline in the unit of the time.
    pieces: f64,
}

impl<'a> Stretch<'a> {
    /// The window of a seed.
    pub fn new(readings: &'a Readings<'a>, path: &'a ContactPath, seed: Seed) -> Option<Self> {
        let (from_s, to_s) = (seed.way.first()?.0, seed.way.last()?.0);
        let Inertia { gyration_m2, damping_per_s } = seed.inertia;
        let unknowns = Unknowns {
            coefficients: seed.coefficients,
            ln_gyration_m2: gyration_m2.ln(),
            damping_per_s,
            calibration: Calibration::default(),
            spline: Vec::new(),
        };
        let samples = &readings.log.samples;
        let index = |time_s: f64| samples.partition_point(|sample| sample.time_s < time_s);
        let range = index(from_s)..index(to_s);
        let psi = |time_s: f64| interpolated(&seed.way, time_s);
        Self::fitted(readings, path, range, &psi, (unknowns, PIECES))
    }

    /// ψ at each of its samples.
    pub fn motion(&self) -> Vec<f64> {
        self.readings.log.samples[self.range.clone()].iter().map(|sample| self.psi_at(sample.time_s)[0]).collect()
    }

    fn psi_at(&self, time_s: f64) -> [f64; 3] {
        self.basis.at(time_s).of(&self.unknowns.spline)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.range.len()
    }

    /// The samples.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// Whether it is all of the log.
    pub fn is_whole(&self) -> bool {
        self.is_share(1.0)
    }

    /// Whether it is such a share of the log.
    pub fn is_share(&self, share: f64) -> bool {
        self.len() as f64 >= share * self.readings.log.samples.len() as f64
    }

    /// The same with more harmonics and shorter pieces, for corners and landings on them. `None` where there are enough.
    pub fn richer(&self) -> Option<Self> {
        let order = Layout::of_coefficients(&self.unknowns.coefficients).order;
        let more = ORDERS.into_iter().find(|more| *more > order && *more <= MOST_ORDER)?;
        let mut richer = self.clone();
        coefficients_to_order(&mut richer.unknowns.coefficients, more);
        richer.pieces *= FINER;
        Some(richer)
    }

    /// As long as its motion can be followed.
    pub fn longest(mut self) -> Self {
        let all = self.readings.log.samples.len();
        let mut reach = [FIRST_REACH; 2];
        let (mut end, mut failures) = (0, 0);
        while failures < MOST_FAILURES {
            let is_open =
                [self.range.start > 0 && reach[0] >= LEAST_REACH, self.range.end < all && reach[1] >= LEAST_REACH];
            if is_open == [false; 2] {
                break;
            }
            // Both ends in turn, as long as both are open.
            end = if is_open == [true; 2] { 1 - end } else { usize::from(is_open[1]) };
            if let Some(longer) = self.grown(end == 1, reach[end]) {
                self = longer;
                reach[end] = (FARTHER * reach[end]).min(self.most_reach());
            } else {
                reach[end] *= NEARER;
                failures += 1;
            }
        }
        self
    }

    /// How far it may grow at once: what the contacts drive errs soon, and the more a stretch has felt the farther its shape carries it.
    fn most_reach(&self) -> f64 {
        let samples = &self.readings.log.samples[self.range.clone()];
        let duration_s = samples[samples.len() - 1].time_s - samples[0].time_s;
        (SHARE * duration_s / self.readings.unit_s()).max(MOST_DRIVEN)
    }

    /// The same, so much longer at one of its ends.
    fn grown(&self, forward: bool, reach: f64) -> Option<Self> {
        let samples = &self.readings.log.samples;
        let unit_s = self.readings.unit_s();
        let edge = if forward { self.range.end - 1 } else { self.range.start };
        let from_s = samples[edge].time_s;
        let [psi_rad, psi_rate, _] = self.psi_at(from_s);
        let shape = SupportFunction::from_coefficients(&self.unknowns.coefficients);
        let pair = self.path.at(from_s).palms.pair;
        let (theta1, theta2) = pair.contact_angles(psi_rad);
        let state = InMotion { r_m: [theta1, theta2].map(|theta| shape.at(theta).r), psi_rad, psi_rate };
        let inertia =
            Inertia { gyration_m2: self.unknowns.ln_gyration_m2.exp(), damping_per_s: self.unknowns.damping_per_s };
        let step_s = if forward { unit_s / STEPS } else { -unit_s / STEPS };
        // At least to the next sample.
        let next =
            if forward { samples.get(edge + 1) } else { edge.checked_sub(1).and_then(|before| samples.get(before)) };
        let reach_s = (reach * unit_s).max((next?.time_s - from_s).abs());
        let steps = (reach_s * STEPS / unit_s).ceil() as usize + 1;
        let drives = self.path.along(from_s, step_s, steps);
        // What the contacts drive needs no shape, and errs where they were read too seldom; what a known shape does needs them nowhere.
        let driven = || self.along(&driven(&drives, step_s, state, inertia), from_s, step_s);
        let carried = || self.along(&carried(&shape, &drives, step_s, state, inertia), from_s, step_s);
        if reach > MOST_DRIVEN { carried() } else { driven().or_else(carried) }
    }

    /// The same along such a way from one of its ends.
    fn along(&self, way: &[Passed], from_s: f64, step_s: f64) -> Option<Self> {
        let samples = &self.readings.log.samples;
        let mut timed: Vec<(f64, f64)> = way
            .iter()
            .enumerate()
            .map(|(index, passed)| (from_s + step_s * index as f64, passed.state.psi_rad))
            .collect();
        let index = |time_s: f64| samples.partition_point(|sample| sample.time_s < time_s);
        let range = if step_s > 0.0 {
            self.range.start..index(timed.last()?.0).max(self.range.end)
        } else {
            timed.reverse();
            index(timed.first()?.0).min(self.range.start)..self.range.end
        };
        if range == self.range {
            return None;
        }
        let known = [samples[self.range.start].time_s, samples[self.range.end - 1].time_s];
        let psi = |time_s: f64| {
            if (known[0]..=known[1]).contains(&time_s) { self.psi_at(time_s)[0] } else { interpolated(&timed, time_s) }
        };
        Self::fitted(self.readings, self.path, range, &psi, (self.unknowns.clone(), self.pieces))
    }

    /// The optimum over some samples from such a motion; `None` where it does not explain them.
    fn fitted(
        readings: &'a Readings<'a>,
        path: &'a ContactPath,
        range: Range<usize>,
        psi: &dyn Fn(f64) -> f64,
        (start, density): (Unknowns, f64),
    ) -> Option<Self> {
        let log = Log { samples: readings.log.samples[range.clone()].to_vec() };
        let measurements = readings.measurements.of(readings.measurements.instants[range.clone()].to_vec());
        let (from_s, to_s) = (log.samples.first()?.time_s, log.samples.last()?.time_s);
        let pieces = (density * (to_s - from_s) / readings.unit_s()).ceil().max(2.0) as usize;
        let knots: Vec<f64> = (0..=pieces).map(|i| from_s + (to_s - from_s) * i as f64 / pieces as f64).collect();
        let rig = Rig::default();
        let order = Layout::of_coefficients(&start.coefficients).order;
        let problem = Problem::new((&log, &rig, path.palms.clone()), &measurements, (order, readings.prior), &knots);
        let times: Vec<f64> =
            (0..=4 * pieces).map(|i| from_s + (to_s - from_s) * i as f64 / (4 * pieces) as f64).collect();
        let known: Vec<f64> = times.iter().map(|time_s| psi(*time_s)).collect();
        let mut at = Unknowns { spline: problem.basis.approximating(&times, &known)?, ..start };
        let gyration_m = SupportFunction::from_coefficients(&at.coefficients).uniform_gyration_radius_m();
        let inertia = InertiaPrior {
            ln_gyration_m2: 2.0 * gyration_m.ln(),
            ln_gyration_sd: LN_GYRATION_SD,
            damping_sd_per_s: DAMPING_SD_PER_S,
        };
        let rms_m = |squares: f64, count: usize| (squares / count.max(1) as f64).sqrt();
        let tolerance_m = readings.tolerance_m();
        let within = |rms_m: f64, least_m: f64| (LOOSER * rms_m).clamp(least_m, tolerance_m);
        let mut noise = InertialNoise { sensor_m: tolerance_m, forces_m: tolerance_m };
        // Loose first, since strict forces lead nowhere from afar; then as exact as they turn out to be, since loose ones would have k anywhere.
        for _ in 0..2 {
            let (Point { unknowns: there, squares, .. }, _) = problem.minimise(at, noise, inertia, EFFORT)?;
            let contacts_m = rms_m(squares.contacts, measurements.seen());
            let forces_m = rms_m(squares.forces, problem.collocations());
            let is_explained = contacts_m.max(forces_m) <= EXPLAINED * tolerance_m;
            if !is_explained || !is_of_an_object(there.ln_gyration_m2 - inertia.ln_gyration_m2) {
                return None;
            }
            at = there;
            noise = InertialNoise {
                sensor_m: within(contacts_m, readings.scatter_m),
                forces_m: within(forces_m, LEAST_FORCES * readings.prior.size_m),
            };
        }
        Some(Self { readings, path, range, basis: problem.basis.clone(), unknowns: at, pieces: density })
    }
}

/// Whether an object may have a radius of gyration whose square differs by this factor (its logarithm) from that of an even mass.
fn is_of_an_object(ln_gyration_off: f64) -> bool {
    ln_gyration_off.abs() <= FURTHEST_SDS * LN_GYRATION_SD
}

/// Between values at increasing times.
fn interpolated(way: &[(f64, f64)], time_s: f64) -> f64 {
    let after = way.partition_point(|(time, _)| *time < time_s).clamp(1, way.len() - 1);
    let ((from_s, from), (to_s, to)) = (way[after - 1], way[after]);
    from + (to - from) * (time_s - from_s) / (to_s - from_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_half_as_far_out_or_twice_are_those_of_no_object() {
        for (factor, expected) in [(0.65, false), (0.69, true), (1.0, true), (1.47, true), (1.52, false)] {
            assert_eq!(is_of_an_object(2.0 * f64::ln(factor)), expected, "{factor}");
        }
    }

    #[test]
    fn a_way_is_followed_between_its_times_and_straight_on_beyond() {
        let way = [(1.0, 2.0), (2.0, 4.0), (4.0, 3.0)];
        for (time_s, expected) in [(1.0, 2.0), (1.5, 3.0), (3.0, 3.5), (4.0, 3.0), (0.0, 0.0), (5.0, 2.5)] {
            assert_eq!(interpolated(&way, time_s), expected);
        }
    }
}
