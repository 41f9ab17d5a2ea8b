//! From nothing, where friction rules: a stretch of the log, begun as if the object rolled on one palm all along, is taken to its optimum by contact
//! and then by mechanics, and grown. Rolling says where the object goes next without knowing its shape, and mechanics says when it slides.

use super::stretch::{SAME_RAD, Stretch, Told};
use super::{PLAUSIBLE, SENSOR_FLOOR, Setting, Settled};
use crate::estimate::evidence::fit::{Fitted, fit};
use crate::estimate::friction::problem::Unknowns;
use crate::estimate::friction::smoother::{FrictionNoise, Optimum};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::log::Log;
use crate::math::statistics::median;
use crate::reconstruct::refine::job::Job;
use crate::reconstruct::search::initial_height::{from_initial_heights, from_rolling};
use crate::reconstruct::search::segments::segments;
use rayon::prelude::*;
use std::ops::Range;

/// Samples that are looked at: so many tell each step apart, and more cost in proportion.
const MOST_SAMPLES: usize = 2000;

/// Samples of the stretch that growth begins with: of windows of 200 every one that its contacts explain was right, of those of 60 half.
const LENGTH: usize = 200;

/// Samples that a segment between two jumps has at least where a stretch is to begin within it, if any segment has.
const SHORTEST: usize = 100;

/// Stretches that are tried, and how many of them are grown at most, so many at once: of these the best is kept, and further ones are grown where
/// that is not explained.
const STRETCHES: usize = 8;
const GROWN: usize = 8;
const GROWN_AT_ONCE: usize = 2;

/// Friction may act on the log where, of so many stretches that are explained best, one tells of it, and no more of none.
const ASKED: usize = 4;

/// Where fewer stretches that are begun as if the object rolled are explained, others are begun as if it slid.
const FEW_EXPLAINED: usize = 2;

/// Share of the log that a stretch must cover to be continued over the rest, whatever comes of that.
const MOSTLY: f64 = 0.95;

/// Samples that two stretches must have in common to be joined, and the share of these that may be elsewhere: the ends of a stretch are known least.
const COMMON: usize = 20;
const APART: f64 = 0.1;

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
    /// Samples at which a jump has just ended.
    pub starts: Vec<usize>,
}

/// The log as growth looks at it.
pub(super) struct Strided<'a> {
    pub job: &'a Job<'a>,
    log: Log,
    measurements: Measurements,
    stride: usize,
}

/// An arrangement of the whole log.
pub(super) fn grown(job: &Job) -> Option<Grown> {
    let strided = Strided::new(job);
    let samples = strided.measurements.len();
    let windows = windows(&segments(&strided.measurements, job.scatter_m));
    let rolled = strided.begun(&windows, Begin::Rolling);
    if !friction_may_act(&rolled) {
        return None;
    }
    let enough = |parts: &[Stretch]| parts.iter().any(|part| part.range.len() == samples && part.is_explained());
    let mut tried = rolled;
    if tried.iter().filter(|stretch| stretch.is_explained()).count() < FEW_EXPLAINED {
        tried.extend(strided.begun(&windows, Begin::Sliding));
        tried.sort_by(|a, b| a.missed_m2().total_cmp(&b.missed_m2()));
    }
    tried.truncate(GROWN);
    let mut parts: Vec<Stretch> = Vec::new();
    while !tried.is_empty() && !enough(&parts) && !job.is_spent() {
        let some: Vec<Stretch> = tried.drain(..GROWN_AT_ONCE.min(tried.len())).collect();
        parts.par_extend(some.into_par_iter().map(|stretch| strided.grown(stretch, AtLast::Stop)));
    }
    if !enough(&parts) {
        let joined = strided.joined(&parts);
        parts.extend(joined);
    }
    // Where nothing is explained all over, the longest goes on through what makes it worse: it jumps there, perhaps.
    if !enough(&parts) && !job.is_spent() {
        parts.sort_by_key(|part| std::cmp::Reverse(part.range.len()));
        let longest: Vec<Stretch> = parts.drain(..GROWN_AT_ONCE.min(parts.len())).collect();
        parts.par_extend(longest.into_par_iter().map(|stretch| strided.grown(stretch, AtLast::GoOn)));
    }
    let whole = |stretch: &&Stretch| stretch.range.len() == samples;
    if let Some(best) = parts.iter().filter(whole).min_by(|a, b| a.missed_m2().total_cmp(&b.missed_m2())) {
        return Some(strided.of_all_samples(best, best.settled.optimum.unknowns.psi.clone(), best.starts()));
    }
    // Few samples at either end may be such that no stretch goes there.
    let longest = parts
        .iter()
        .max_by_key(|part| part.range.len())
        .filter(|part| part.range.len() as f64 > MOSTLY * samples as f64)?;
    let (psi, starts) = strided.followed(longest, &(0..samples), true);
    Some(strided.of_all_samples(longest, psi, starts))
}

/// How a stretch is begun.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Begin {
    /// As if the object rolled on either palm all along.
    Rolling,
    /// As if it slid without friction, from the best height of its centre of mass: with little friction that is nearer.
    Sliding,
}

/// What growth does where even the least step makes a stretch worse.
#[derive(Clone, Copy, Debug, PartialEq)]
enum AtLast {
    Stop,
    GoOn,
}

/// Where stretches begin: evenly over the log, each moved to the nearest segment that it lies within.
fn windows(segments: &[Range<usize>]) -> Vec<Range<usize>> {
    let Some(longest) = segments.iter().map(|segment| segment.len()).max() else { return Vec::new() };
    let least = longest.min(SHORTEST);
    let samples = segments.iter().map(|segment| segment.end).max().unwrap_or(0);
    let last = samples.saturating_sub(LENGTH);
    let mut windows: Vec<Range<usize>> = (0..STRETCHES)
        .filter_map(|number| {
            let start = last * number / (STRETCHES - 1);
            let moved = segments.iter().filter(|segment| segment.len() >= least).map(|segment| {
                let length = LENGTH.min(segment.len());
                let start = start.clamp(segment.start, segment.end - length);
                start..start + length
            });
            moved.min_by_key(|window| window.start.abs_diff(start))
        })
        .collect();
    windows.dedup();
    windows
}

/// Whether at least one of the stretches, the best first, tells of friction, and as many as of none.
fn friction_may_act(stretches: &[Stretch]) -> bool {
    let explained = stretches.iter().filter(|stretch| {
        let Optimum { noise, unknowns, .. } = &stretch.settled.optimum;
        let size_m = unknowns.coefficients[0];
        noise.slip_m < PLAUSIBLE[0] * size_m && noise.forces_m < PLAUSIBLE[1] * size_m
    });
    let told: Vec<Told> = explained.take(ASKED).map(Stretch::told).collect();
    let count = |of: Told| told.iter().filter(|told| **told == of).count();
    count(Told::Friction) >= count(Told::None).max(1)
}

/// Whether a stretch that has grown over so many jumps is worse than it was, or has lost its way between.
fn is_worse(grown: &Settled, before: &Settled, jumps: usize) -> bool {
    let (now, then, size_m) = (grown.optimum.noise, before.optimum.noise, grown.optimum.unknowns.coefficients[0]);
    let is_worse = |now: f64, then: f64, fine: f64| now > (WORSE * then).max(fine * size_m);
    grown.starts.len() > jumps
        || is_worse(now.slip_m, then.slip_m, FINE[0])
        || is_worse(now.forces_m, then.forces_m, FINE[1])
}

impl<'a> Strided<'a> {
    pub fn new(job: &'a Job<'a>) -> Self {
        let stride = job.measurements.len().div_ceil(MOST_SAMPLES).max(1);
        let log = Log { samples: job.raw.samples.iter().step_by(stride).copied().collect() };
        let measurements = job.measurements.of(job.measurements.instants.iter().step_by(stride).copied().collect());
        Self { job, log, measurements, stride }
    }
}

impl Strided<'_> {
    /// A part of it.
    pub fn part(&self, range: &Range<usize>) -> (Log, Measurements) {
        let log = Log { samples: self.log.samples[range.clone()].to_vec() };
        (log, self.measurements.of(self.measurements.instants[range.clone()].to_vec()))
    }

    /// Stretches at their optima, those first in which mechanics holds. Several starts may lead to the same.
    fn begun(&self, windows: &[Range<usize>], begin: Begin) -> Vec<Stretch> {
        let mut begun: Vec<Stretch> =
            windows.to_vec().into_par_iter().flat_map_iter(|range| self.begun_at(&range, begin)).collect();
        begun.sort_by(|a, b| a.missed_m2().total_cmp(&b.missed_m2()));
        let mut distinct: Vec<Stretch> = Vec::new();
        for stretch in begun {
            if !distinct.iter().any(|other| other.is_same(&stretch)) {
                distinct.push(stretch);
            }
        }
        distinct
    }

    /// A stretch at its optima.
    fn begun_at(&self, range: &Range<usize>, begin: Begin) -> Vec<Stretch> {
        let job = self.job;
        let (log, measurements) = self.part(range);
        let tolerance_m = job.readings().tolerances_m[0];
        let loose = Noise { sensor_m: tolerance_m, balance_m: tolerance_m };
        let begun = |start: Estimate| {
            let fit = self.by_contact(&measurements, start, loose)?;
            if fit.noise.sensor_m > self.most_m() {
                return None;
            }
            let setting = Setting::new(job, &log, &measurements, &fit, &[]);
            let start = setting.contacts_suggest(&fit)?;
            let noise = setting.first_noise(&fit, start.0.weight_n);
            let settled = setting.settled(start, noise, (FIRST_ROUNDS, UPDATES))?;
            // What jumps where no contact does explains anything.
            settled.starts.is_empty().then(|| Stretch { range: range.clone(), fit, settled })
        };
        let starts = match begin {
            Begin::Rolling => from_rolling(&measurements, loose, job.prior, ORDERS[0]),
            Begin::Sliding => {
                let mut by_height = from_initial_heights(&measurements, loose, job.prior, ORDERS[0]);
                by_height.truncate(1);
                by_height
            }
        };
        starts.into_iter().filter_map(begun).collect()
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

    /// A stretch grown over the whole log, or as far as it goes: over jumps where it does not go on without.
    fn grown(&self, mut stretch: Stretch, at_last: AtLast) -> Stretch {
        let samples = self.measurements.len();
        let (mut growth, mut over_jumps) = (GROWTH, false);
        while stretch.range.len() < samples {
            let more = ((growth * stretch.range.len() as f64) as usize).max(1);
            let range = stretch.range.start.saturating_sub(more)..(stretch.range.end + more).min(samples);
            let (psi, starts) = self.followed(&stretch, &range, over_jumps);
            let Some(settled) = self.settled_over(&range, (psi, &starts), &stretch) else { break };
            let lost = self.is_lost(&settled);
            let worse = lost || is_worse(&settled, &stretch.settled, starts.len());
            if worse && growth > LEAST_GROWTH {
                growth *= SLOWER;
                continue;
            }
            if worse && !over_jumps {
                (growth, over_jumps) = (GROWTH, true);
                continue;
            }
            if lost || (worse && at_last == AtLast::Stop) {
                break;
            }
            (growth, over_jumps) = ((FASTER * growth).min(GROWTH), false);
            stretch = Stretch { range, settled, fit: stretch.fit };
        }
        stretch
    }

    /// The optimum over a range with this motion and the samples at which jumps have just ended, from what is known of a stretch of it.
    fn settled_over(
        &self,
        range: &Range<usize>,
        (psi, starts): (Vec<f64>, &[usize]),
        from: &Stretch,
    ) -> Option<Settled> {
        let (log, measurements) = self.part(range);
        let starts: Vec<usize> = starts.iter().map(|start| start - range.start).collect();
        let setting = Setting::new(self.job, &log, &measurements, &from.fit, &starts);
        let unknowns = Unknowns { psi, ..from.settled.optimum.unknowns.clone() };
        let noise = from.settled.optimum.noise;
        let corrected = setting.problem().corrected(&unknowns.calibration);
        let covariance = from.settled.optimum.covariance_of_object();
        let regimes = setting.decoded(&corrected, &unknowns, covariance.as_ref(), noise, &starts).regimes;
        setting.settled((unknowns, regimes), noise, (FURTHER_ROUNDS, UPDATES))
    }

    /// The longest of several stretches that others overlap, with those, grown further: one goes where another stopped. `None` where none does.
    fn joined(&self, parts: &[Stretch]) -> Option<Stretch> {
        let mut by_length: Vec<&Stretch> = parts.iter().filter(|part| part.is_explained()).collect();
        by_length.sort_by_key(|part| std::cmp::Reverse(part.range.len()));
        let mut joined: Option<Stretch> = None;
        for (number, one) in by_length.iter().enumerate() {
            for other in &by_length[number + 1..] {
                if let Some(both) = self.joined_with(joined.as_ref().unwrap_or(one), other) {
                    joined = Some(self.grown(both, AtLast::Stop));
                }
            }
            if joined.is_some() {
                break;
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
        let apart = turned.iter().filter(|other| (*other - turn).abs() > SAME_RAD).count();
        if apart as f64 > APART * turned.len() as f64 {
            return None;
        }
        let joined = |index: usize| if one.range.contains(&index) { at(one, index) } else { at(other, index) + turn };
        let psi = range.clone().map(joined).collect();
        let mut starts = one.starts();
        starts.extend(other.starts().iter().filter(|start| !one.range.contains(start)));
        starts.sort_unstable();
        let settled = self.settled_over(&range, (psi, &starts), one)?;
        let fails = self.is_lost(&settled) || is_worse(&settled, &one.settled, starts.len());
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

    /// What is known of a stretch, with ψ of all samples from that of every n-th.
    fn of_all_samples(&self, of: &Stretch, known: Vec<f64>, starts: Vec<usize>) -> Grown {
        let psi = (0..self.job.measurements.len())
            .map(|index| {
                let (before, share) = (index / self.stride, (index % self.stride) as f64 / self.stride as f64);
                let after = (before + 1).min(known.len() - 1);
                known[before] + share * (known[after] - known[before])
            })
            .collect();
        let Optimum { unknowns, noise, .. } = &of.settled.optimum;
        let starts = starts.into_iter().map(|start| self.stride * start).collect();
        Grown { fit: of.fit.clone(), unknowns: Unknowns { psi, ..unknowns.clone() }, noise: *noise, starts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_stretch_friction_does_not_act() {
        assert!(!friction_may_act(&[]));
    }

    #[test]
    fn stretches_begin_between_jumps_and_in_no_short_segment() {
        // The whole log is one segment.
        let even = windows(std::slice::from_ref(&(0..900)));
        assert_eq!(even.len(), STRETCHES);
        assert_eq!((even[0].clone(), even[STRETCHES - 1].clone()), (0..LENGTH, 900 - LENGTH..900));
        let around = |short: usize| windows(&[0..300, 300..300 + short, 300 + short..900]);
        let has_short = |short: usize| around(short).contains(&(300..300 + short));
        assert!(has_short(SHORTEST) && !has_short(SHORTEST - 1));
        assert!(around(SHORTEST - 1).iter().all(|window| window.end <= 300 || window.start >= 300 + SHORTEST - 1));
        // Where all are short the longest are taken.
        assert_eq!(windows(&[0..40, 40..90, 90..130]), vec![40..90]);
        assert!(windows(&[]).is_empty());
    }
}
