//! From nothing, where friction rules: a stretch of the log, begun as if the object rolled on one palm all along, is taken to its optimum by contact
//! and then by mechanics, and grown. Rolling says where the object goes next without knowing its shape, and mechanics says when it slides.

use super::{EXPLAINED, PLAUSIBLE, SENSOR_FLOOR, Setting, Settled};
use crate::estimate::evidence::fit::{Fitted, fit};
use crate::estimate::friction::problem::{Problem, Unknowns};
use crate::estimate::friction::smoother::{FrictionNoise, Optimum};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::log::Log;
use crate::math::statistics::median;
use crate::reconstruct::refine::job::Job;
use crate::reconstruct::search::initial_height::from_rolling;
use rayon::prelude::*;
use std::ops::Range;

/// Samples that are looked at: so many tell each step apart, and more cost in proportion.
const MOST_SAMPLES: usize = 2000;

/// Samples of the stretch that growth begins with: of windows of 200 every one that its contacts explain was right, of those of 60 half.
const LENGTH: usize = 200;

/// Stretches that are tried, and how many of them are grown at most, so many at once: of these the best is kept, and further ones are grown where
/// that is not explained.
const STRETCHES: usize = 8;
const GROWN: usize = 4;
const GROWN_AT_ONCE: usize = 2;

/// Friction acts on a stretch with a coefficient of more than this (without any, stretches have up to 0.007, and with 0.02 at least 0.018), or where
/// the object rolls for this share of the samples. It acts on the log where it does on half of so many stretches that are explained best.
const ACTS: f64 = 0.012;
const ROLLS: f64 = 0.5;
const ASKED: usize = 4;

/// Samples that two stretches must have in common to be joined, and by how much their motions may differ there, radians.
const COMMON: usize = 20;
const SAME_RAD: f64 = 0.05;

/// Harmonics of the fits by contact, in turn, and of growth.
const ORDERS: [usize; 3] = [4, 8, 12];

/// Updates of the noise in each of them.
const FIT_ROUNDS: usize = 2;

/// A stretch is explained by contact where that leaves so many times the scatter of neighbouring samples at most.
const EXPLAINED_CONTACTS: f64 = 1.5;

/// Times that the contact modes of a stretch are found anew: at the start, and after each growth.
const FIRST_ROUNDS: usize = 4;
const FURTHER_ROUNDS: usize = 3;

/// Updates of the standard deviations in each of them.
const UPDATES: usize = 4;

/// Growth ends where the forces are missed by this share of the mean radius: no modes explain that.
const LOST: f64 = 1e-2;

/// A stretch grows by this share of its length at each end; by half of it where it then is worse, down to this least share.
const GROWTH: f64 = 0.25;
const LEAST_GROWTH: f64 = 0.05;
const SLOWER: f64 = 0.5;
const FASTER: f64 = 1.5;

/// It is worse where slip or forces are so many times what they were, and more than these shares of the mean radius.
const WORSE: f64 = 2.0;
const FINE: [f64; 2] = [2e-4, 4e-4];

/// What was grown over the whole log: the last fit by contact alone, and all else.
pub(super) struct Grown {
    pub fit: Fit,
    pub unknowns: Unknowns,
    pub noise: FrictionNoise,
}

/// A stretch with what is known there.
struct Stretch {
    range: Range<usize>,
    fit: Fit,
    settled: Settled,
}

impl Stretch {
    fn is_explained(&self) -> bool {
        let Optimum { noise, unknowns, .. } = &self.settled.optimum;
        let size_m = unknowns.coefficients[0];
        noise.slip_m < EXPLAINED[0] * size_m && noise.forces_m < EXPLAINED[1] * size_m
    }
}

/// The log as growth looks at it.
struct Strided<'a> {
    job: &'a Job<'a>,
    log: Log,
    measurements: Measurements,
    stride: usize,
}

/// An arrangement of the whole log.
pub(super) fn grown(job: &Job) -> Option<Grown> {
    let count = job.measurements.len();
    let stride = count.div_ceil(MOST_SAMPLES).max(1);
    let log = Log { samples: job.raw.samples.iter().step_by(stride).copied().collect() };
    let measurements = job.measurements.of(job.measurements.instants.iter().step_by(stride).copied().collect());
    let strided = Strided { job, log, measurements, stride };
    let samples = strided.measurements.len();
    let length = LENGTH.min(samples);
    let last = samples - length;
    let starts = (0..STRETCHES).map(|i| last * i / (STRETCHES - 1));
    let mut windows: Vec<Range<usize>> = starts.map(|start| start..start + length).collect();
    windows.dedup();
    let mut tried: Vec<Stretch> = windows.into_par_iter().flat_map_iter(|range| strided.begun(&range)).collect();
    // Where both slip and forces come down, mechanics holds.
    let missed = |stretch: &Stretch| stretch.settled.optimum.noise.forces_m * stretch.settled.optimum.noise.slip_m;
    tried.sort_by(|a, b| missed(a).total_cmp(&missed(b)));
    if !friction_acts(&tried) {
        return None;
    }
    tried.truncate(GROWN);
    let mut parts: Vec<Stretch> = Vec::new();
    let enough = |parts: &[Stretch]| parts.iter().any(|part| part.range.len() == samples && part.is_explained());
    while !tried.is_empty() && !enough(&parts) && !job.is_spent() {
        let some: Vec<Stretch> = tried.drain(..GROWN_AT_ONCE.min(tried.len())).collect();
        parts.par_extend(some.into_par_iter().map(|stretch| strided.grown(stretch, AtLast::Stop)));
    }
    let whole = |stretch: &Stretch| stretch.range.len() == samples;
    let joined = strided.joined(&parts);
    parts.extend(joined);
    // Where nothing is explained all over, the longest goes on through what makes it worse: it jumps there, perhaps.
    if !enough(&parts) && !job.is_spent() {
        parts.sort_by_key(|part| std::cmp::Reverse(part.range.len()));
        let longest: Vec<Stretch> = parts.drain(..GROWN_AT_ONCE.min(parts.len())).collect();
        parts.par_extend(longest.into_par_iter().map(|stretch| strided.grown(stretch, AtLast::GoOn)));
    }
    let best = parts.into_iter().filter(whole).min_by(|a, b| missed(a).total_cmp(&missed(b)))?;
    let Optimum { unknowns, noise, .. } = best.settled.optimum;
    Some(Grown { fit: best.fit, unknowns: strided.at_all_samples(unknowns), noise })
}

/// What growth does where even the least step makes a stretch worse.
#[derive(Clone, Copy, Debug, PartialEq)]
enum AtLast {
    Stop,
    GoOn,
}

/// Whether the stretches, the best first, tell of friction.
fn friction_acts(stretches: &[Stretch]) -> bool {
    let explained = stretches.iter().filter(|stretch| {
        let Optimum { noise, unknowns, .. } = &stretch.settled.optimum;
        let size_m = unknowns.coefficients[0];
        noise.slip_m < PLAUSIBLE[0] * size_m && noise.forces_m < PLAUSIBLE[1] * size_m
    });
    let told = explained.take(ASKED).map(|stretch| {
        let Settled { optimum, regimes, .. } = &stretch.settled;
        let rolls = regimes.iter().filter(|regime| regime.sticks().is_some()).count() as f64;
        acts(optimum.unknowns.friction, rolls / regimes.len() as f64)
    });
    let told: Vec<bool> = told.collect();
    2 * told.iter().filter(|acts| **acts).count() >= told.len().max(1)
}

/// Whether friction acts on a stretch with these coefficients, of which the object rolls for some share.
fn acts(friction: [f64; 2], rolls: f64) -> bool {
    friction[0].max(friction[1]) > ACTS || rolls > ROLLS
}

/// Whether a stretch that has grown is worse than it was, or has lost its way between.
fn is_worse(grown: &Settled, before: &Settled) -> bool {
    let (now, then, size_m) = (grown.optimum.noise, before.optimum.noise, grown.optimum.unknowns.coefficients[0]);
    let is_worse = |now: f64, then: f64, fine: f64| now > (WORSE * then).max(fine * size_m);
    !grown.starts.is_empty()
        || is_worse(now.slip_m, then.slip_m, FINE[0])
        || is_worse(now.forces_m, then.forces_m, FINE[1])
}

impl Strided<'_> {
    fn part(&self, range: &Range<usize>) -> (Log, Measurements) {
        let log = Log { samples: self.log.samples[range.clone()].to_vec() };
        (log, self.measurements.of(self.measurements.instants[range.clone()].to_vec()))
    }

    /// A stretch at its optimum, from rolling on either palm.
    fn begun(&self, range: &Range<usize>) -> Vec<Stretch> {
        let job = self.job;
        let (log, measurements) = self.part(range);
        let loose = Noise { sensor_m: job.readings().tolerances_m[0], balance_m: job.readings().tolerances_m[0] };
        let begun = |start: Estimate| {
            let fit = self.by_contact(&measurements, start, loose)?;
            if fit.noise.sensor_m > self.most_m() {
                return None;
            }
            let setting = Setting::new(job, &log, &measurements, &fit, &[]);
            let start = setting.contacts_suggest(&fit)?;
            let noise = setting.first_noise(&fit, start.0.weight_n);
            let settled = setting.settled(start, noise, (FIRST_ROUNDS, UPDATES))?;
            Some(Stretch { range: range.clone(), fit, settled })
        };
        from_rolling(&measurements, loose, job.prior, ORDERS[0]).into_iter().filter_map(begun).collect()
    }

    /// The optimum by contact alone, with more and more harmonics.
    fn by_contact(&self, measurements: &Measurements, start: Estimate, loose: Noise) -> Option<Fit> {
        let mut last: Option<Fit> = None;
        for order in ORDERS {
            let (estimate, noise, prior) = last
                .as_ref()
                .map_or((start.clone(), loose, self.job.prior), |fit| (fit.estimate.clone(), fit.noise, fit.prior));
            let components = self.job.variance_components();
            let Some(Fitted { fit, .. }) = fit(measurements, order, estimate, noise, prior, components, FIT_ROUNDS)
            else {
                break;
            };
            last = Some(fit);
        }
        last
    }

    /// A stretch grown over the whole log, or as far as it goes.
    fn grown(&self, mut stretch: Stretch, at_last: AtLast) -> Stretch {
        let samples = self.measurements.len();
        let mut growth = GROWTH;
        while stretch.range.len() < samples {
            let more = ((growth * stretch.range.len() as f64) as usize).max(1);
            let range = stretch.range.start.saturating_sub(more)..(stretch.range.end + more).min(samples);
            let psi = self.followed(&stretch, &range);
            let Some(settled) = self.settled_over(&range, psi, &stretch) else { break };
            let lost = self.is_lost(&settled);
            let worse = lost || is_worse(&settled, &stretch.settled);
            if worse && growth > LEAST_GROWTH {
                growth *= SLOWER;
                continue;
            }
            if lost || (worse && at_last == AtLast::Stop) {
                break;
            }
            growth = (FASTER * growth).min(GROWTH);
            stretch = Stretch { range, settled, fit: stretch.fit };
        }
        stretch
    }

    /// The optimum over a range with this motion, from what is known of a stretch of it.
    fn settled_over(&self, range: &Range<usize>, psi: Vec<f64>, from: &Stretch) -> Option<Settled> {
        let (log, measurements) = self.part(range);
        let setting = Setting::new(self.job, &log, &measurements, &from.fit, &[]);
        let unknowns = Unknowns { psi, ..from.settled.optimum.unknowns.clone() };
        let noise = from.settled.optimum.noise;
        let corrected = setting.problem().corrected(&unknowns.calibration);
        let covariance = from.settled.optimum.covariance_of_object();
        let regimes = setting.decoded(&corrected, &unknowns, covariance.as_ref(), noise, &[]).regimes;
        setting.settled((unknowns, regimes), noise, (FURTHER_ROUNDS, UPDATES))
    }

    /// The longest of several stretches with those that overlap it, grown further: one goes where another stopped. `None` where none does.
    fn joined(&self, parts: &[Stretch]) -> Option<Stretch> {
        let mut by_length: Vec<&Stretch> = parts.iter().filter(|part| part.is_explained()).collect();
        by_length.sort_by_key(|part| std::cmp::Reverse(part.range.len()));
        let (longest, others) = by_length.split_first()?;
        let mut joined: Option<Stretch> = None;
        for other in others {
            let longest = joined.as_ref().unwrap_or(longest);
            if let Some(both) = self.joined_with(longest, other) {
                joined = Some(self.grown(both, AtLast::Stop));
            }
        }
        joined
    }

    /// Two stretches as one, where they move alike on what they have in common.
    fn joined_with(&self, one: &Stretch, other: &Stretch) -> Option<Stretch> {
        let common = one.range.start.max(other.range.start)..one.range.end.min(other.range.end);
        let range = one.range.start.min(other.range.start)..one.range.end.max(other.range.end);
        if common.len() < COMMON || range == one.range {
            return None;
        }
        let at = |stretch: &Stretch, index: usize| stretch.settled.optimum.unknowns.psi[index - stretch.range.start];
        // Each has a frame of its own.
        let mut turned: Vec<f64> = common.map(|index| at(one, index) - at(other, index)).collect();
        let turn = median(&mut turned);
        if turned.iter().any(|other| (other - turn).abs() > SAME_RAD) {
            return None;
        }
        let joined = |index: usize| if one.range.contains(&index) { at(one, index) } else { at(other, index) + turn };
        let psi = range.clone().map(joined);
        let settled = self.settled_over(&range, psi.collect(), one)?;
        let fails = self.is_lost(&settled) || is_worse(&settled, &one.settled);
        (!fails).then(|| Stretch { range, settled, fit: one.fit.clone() })
    }

    /// By how much contacts may be missed where they are explained, metres.
    fn most_m(&self) -> f64 {
        EXPLAINED_CONTACTS * self.job.readings().tolerances_m[0].max(SENSOR_FLOOR * self.job.prior.size_m)
    }

    /// Whether no modes explain a stretch.
    fn is_lost(&self, settled: &Settled) -> bool {
        let Optimum { noise, unknowns, .. } = &settled.optimum;
        noise.sensor_m > self.most_m() || noise.forces_m > LOST * unknowns.coefficients[0]
    }

    /// ψ over a longer stretch: as it is within, and beyond both ends as mechanics continues it.
    fn followed(&self, stretch: &Stretch, range: &Range<usize>) -> Vec<f64> {
        let known = &stretch.settled.optimum.unknowns;
        let continued = |part: Range<usize>, backwards: bool, psi: f64| {
            let (mut log, mut measurements) = self.part(&part);
            let mut friction = known.friction;
            if backwards {
                log.samples.reverse();
                measurements.instants.reverse();
                // Forces that resist the motion would drive it backwards.
                friction = friction.map(|value| -value);
            }
            let setting = Setting::new(self.job, &log, &measurements, &stretch.fit, &[]);
            let problem = Problem::new(&log, &self.job.options.rig, &measurements, setting.order, setting.prior);
            let corrected = problem.corrected(&known.calibration);
            let at = Unknowns { psi: vec![psi; part.len()], friction, ..known.clone() };
            let noise = stretch.settled.optimum.noise;
            let covariance = stretch.settled.optimum.covariance_of_object();
            setting.decoded(&corrected, &at, covariance.as_ref(), noise, &[]).psi
        };
        let within = &stretch.range;
        let mut psi = continued(range.start..within.start + 1, true, known.psi[0]);
        psi.reverse();
        psi.pop();
        psi.extend(&known.psi);
        let last = known.psi[known.psi.len() - 1];
        psi.extend(continued(within.end - 1..range.end, false, last).into_iter().skip(1));
        psi
    }

    /// The same with ψ of all samples.
    fn at_all_samples(&self, unknowns: Unknowns) -> Unknowns {
        let known = &unknowns.psi;
        let psi = (0..self.job.measurements.len())
            .map(|index| {
                let (before, share) = (index / self.stride, (index % self.stride) as f64 / self.stride as f64);
                let after = (before + 1).min(known.len() - 1);
                known[before] + share * (known[after] - known[before])
            })
            .collect();
        Unknowns { psi, ..unknowns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_acts_beyond_its_least_coefficient_or_where_the_object_rolls() {
        assert!(!acts([0.0119, 0.001], 0.3) && acts([0.001, 0.0121], 0.0));
        assert!(!acts([0.001, 0.002], 0.49) && acts([0.001, 0.002], 0.51));
        assert!(!friction_acts(&[]));
    }
}
