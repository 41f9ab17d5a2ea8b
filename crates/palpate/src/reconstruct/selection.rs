//! Selection among several explanations of a log by their evidence, and the test of uniqueness (`docs/theory.md`, the search and
//! the certificate).

pub(super) mod stray_readings;

use super::search::initial_height::from_initial_heights;
use super::search::schedule::Found;
use crate::estimate::evidence::motion_prior::CERTAIN;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::balance_tolerance::{INEXACT_BALANCE, balance_is_missed};
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::noise::Noise;
use crate::estimate::motion::{moved, same_motion};
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::reconstruct::options::error::ReconstructError;
use crate::reconstruct::refine::calibrated::Solved;
use crate::reconstruct::refine::job::Job;
use crate::reconstruct::refine::resample::thinned_in_ranges;
use crate::reconstruct::result::reconstruction::{Pose, Reconstruction};
use crate::reconstruct::verdict::assemble::{Candidate, is_mostly_felt_again};
use crate::reconstruct::verdict::at_rest::AtRest;
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::shape::Symmetry;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::f64::consts::TAU;

/// Explanations that are waited for besides the first, where noisy contacts miss the balance: each costs a refinement.
const FURTHER_EXPLANATIONS: usize = 2;

/// χ² per degree of freedom up to which noise may be what is wrong with a result: errors that are correlated over several samples are three
/// times as large as they seem between neighbours.
const NOISIER: f64 = 10.0;

/// In ranking contradicted results, one unphysical jump outweighs any χ² per degree of freedom, which counts up to the largest.
const UNPHYSICAL_JUMP: f64 = 1e3;
const LARGEST_CHI2: f64 = 999.0;

/// Effort of the smoother for comparing the costs of arrangements on the thinned log.
const COMPARING: StoppingCriteria = StoppingCriteria { iterations: 20, tolerance: 1e-5 };

impl Candidate {
    /// Whether the search may end, when so many explanations without contradictions were found (this one among them). One
    /// suffices, unless noisy contacts miss the balance: then only a comparison of several shows whether one keeps it.
    pub fn is_enough(&self, explanations: usize) -> bool {
        if self.is_only_noisier() {
            return true;
        }
        let Reconstruction { sensor_sd_m, balance_sd_m, ref shape, .. } = self.result;
        let missed = balance_is_missed(sensor_sd_m, balance_sd_m, shape.mean_radius_m());
        explanations > if missed { FURTHER_EXPLANATIONS } else { 0 }
    }

    /// Whether the noise is all that is wrong: every pose is placed and at rest, and every jump is one that statics makes, which a wrong
    /// motion hardly does for a whole log. No other arrangement is searched for then.
    fn is_only_noisier(&self) -> bool {
        matches!(self.result.verdict.doubts[..], [Doubt::Misfit { .. }]) && self.result.chi2_per_dof <= NOISIER
    }

    /// Whether contacts or balance contradict it. Other forces, or readings that mean something else, would: a wrong arrangement of an object
    /// that looks alike in several poses need not.
    pub fn misses_readings(&self) -> bool {
        let Reconstruction { sensor_sd_m, balance_sd_m, verdict, .. } = &self.result;
        let is_of_readings = |doubt: &Doubt| matches!(doubt, Doubt::Misfit { .. } | Doubt::StrayReadings { .. });
        *balance_sd_m > INEXACT_BALANCE * sensor_sd_m || verdict.doubts.iter().any(is_of_readings)
    }

    /// Whether that is a few readings, by much.
    pub fn misses_few_readings(&self) -> bool {
        self.result.verdict.doubts.iter().any(|doubt| matches!(doubt, Doubt::StrayReadings { .. }))
    }

    /// Compares by the posterior where nothing contradicts either result; else prefers the one without contradictions; else
    /// compares by unphysical jumps, then by χ².
    pub fn is_likelier_than(&self, other: &Self) -> bool {
        match (self.result.verdict.is_explained(), other.result.verdict.is_explained()) {
            (true, true) => self.posterior.log_ratio(&other.posterior) > 0.0,
            (false, false) => self.contradiction() < other.contradiction(),
            (explained, _) => explained,
        }
    }

    /// Whether what it has besides balance explains the log and is no mere possibility.
    pub fn explains_forces(&self) -> bool {
        !self.result.verdict.doubts_friction()
    }

    /// Whether it is certified, and no pose of it is open.
    pub fn is_certified_throughout(&self) -> bool {
        self.result.is_certified() && !self.result.motion.iter().any(Pose::is_open)
    }

    /// Of results with forces besides balance: certified, or else explaining them, or else without contradictions, and no pose open; of two with friction the one that
    /// leaves less of the felt boundary unknown where both explain the forces, since slip and forces are told apart no further, or else the likelier.
    pub fn explains_forces_better_than(&self, other: &Self) -> bool {
        let rank = |of: &Self| {
            let result = &of.result;
            (result.is_certified(), of.explains_forces(), result.verdict.is_explained(), of.is_certified_throughout())
        };
        let both_of_friction = self.result.friction.is_some() && other.result.friction.is_some();
        match rank(self).cmp(&rank(other)) {
            Ordering::Equal if !both_of_friction => false,
            Ordering::Equal if self.explains_forces() => self.unknown_m2() < other.unknown_m2(),
            Ordering::Equal => self.posterior.log_ratio(&other.posterior) > 0.0,
            unequal => unequal == Ordering::Greater,
        }
    }

    /// Mean variance of the felt boundary, square metres.
    fn unknown_m2(&self) -> f64 {
        let felt = || self.result.outline.iter().filter(|point| point.touches > 0);
        felt().map(|point| point.r_sd_m.powi(2)).sum::<f64>() / felt().count() as f64
    }

    /// How strongly the log contradicts a result.
    fn contradiction(&self) -> f64 {
        let unphysical = self.result.jumps.iter().filter(|jump| !jump.physical).count();
        UNPHYSICAL_JUMP * unphysical as f64 + self.result.chi2_per_dof.clamp(0.0, LARGEST_CHI2)
    }
}

impl Job<'_> {
    /// The result of a refined arrangement.
    pub fn assemble(&self, solved: Solved) -> Result<Candidate, ReconstructError> {
        self.assemble_if(solved, |_| true)?.ok_or(ReconstructError::NotSolvable)
    }

    /// The same; `None` where it is not wanted by its evidence: error bars take longer than that.
    fn assemble_if(
        &self,
        Solved { job, refined, .. }: Solved,
        is_wanted: impl Fn(&Evidence) -> bool,
    ) -> Result<Option<Candidate>, ReconstructError> {
        let job = job.as_ref().unwrap_or(self);
        let at_rest = AtRest::new(job, &refined);
        let first = at_rest.result()?;
        if !is_wanted(&first.posterior) {
            return Ok(None);
        }
        let hidden = is_certified_but_for_poses(&first.result).then(|| job.with_hidden_jumps(&refined)).flatten();
        let (refined, candidate) = match &hidden {
            // Samples that are set aside count where it is held against others.
            Some(hidden) => {
                let posterior = first.posterior;
                let at_rest = AtRest::new(job, hidden);
                (hidden, Candidate { posterior, ..at_rest.widened(at_rest.result()?) })
            }
            None => (&refined, at_rest.widened(first)),
        };
        Ok(Some(job.with_inertia(refined, &candidate).unwrap_or(candidate)))
    }

    /// Where the log does not check what it tells, the likelier of a result and of that to which the same arrangement leads with a balance that leaves
    /// the orientations no noise from the first fit on.
    fn or_sharper(&self, found: &Found, arrangement: usize, candidate: Candidate) -> Candidate {
        if !candidate.result.is_certified() || is_checked(&candidate.result) {
            return candidate;
        }
        let job = self.with_sharp_balance();
        let solved = job.solve(found, arrangement, &Explored::default()).ok().flatten();
        let is_likelier = |evidence: &Evidence| evidence.log_ratio(&candidate.posterior) > 0.0;
        solved.and_then(|solved| job.assemble_if(solved, is_likelier).ok().flatten()).unwrap_or(candidate)
    }

    /// The result of an arrangement, which is then explored; `None` where it leads to none, or to a motion that is known.
    fn explore(&self, found: &Found, arrangement: usize, explored: &mut Explored) -> Option<Candidate> {
        let solved = self.solve(found, arrangement, explored).ok()??;
        let candidate = self.or_sharper(found, arrangement, self.assemble(solved).ok()?);
        explored.add(&candidate);
        Some(candidate)
    }

    /// Refines the arrangements that explain the log about equally well. Only certified ones count; when there is just one, it is
    /// the answer, else none is certified as unique.
    pub fn judge(&self, found: &Found, explored: &mut Explored) -> Result<Candidate, ReconstructError> {
        let mut first = self.solve(found, 0, &Explored::default())?.ok_or(ReconstructError::NotSolvable)?;
        if let Some(job) = self.with_readings_in_motion(&first.refined) {
            return job.judge(found, explored);
        }
        let period = first.refined.fine.prior.symmetry.period_rad();
        let alternatives = alternatives(&found.thin, &found.estimates, &first.refined.coarse, period);
        let as_likely = std::mem::take(&mut first.as_likely);
        let mut results = vec![self.or_sharper(found, 0, self.assemble(first)?)];
        explored.add(&results[0]);
        for other in as_likely.into_iter().filter_map(|other| self.assemble(other).ok()) {
            explored.add(&other);
            results.push(other);
        }
        // A certified answer requires that all others are ruled out; one that is explained but not certified stays the answer
        // without them.
        let first = &results[0];
        let refined_at_most = if first.result.is_certified() {
            MOST_ALTERNATIVES
        } else if first.result.verdict.is_explained() {
            0
        } else {
            MOST_ALTERNATIVES / 2
        };
        for alternative in alternatives.into_iter().take(refined_at_most) {
            if explored.contains(found, alternative) {
                continue;
            }
            if !results[0].result.is_certified() && self.is_spent() {
                break;
            }
            results.extend(self.explore(found, alternative, explored));
        }
        let first = &results[0].result;
        if first.jumps.is_empty() && !is_checked(first) && (first.is_certified() || !explored.in_one_piece) {
            explored.in_one_piece = true;
            let starts = self.starts_in_one_piece(found);
            for start in 0..starts.estimates.len() {
                if explored.contains(&starts, start) {
                    continue;
                }
                results.extend(self.explore(&starts, start, explored));
            }
        }
        let mut certified: Vec<Candidate> = Vec::new();
        let mut rest = Vec::new();
        for candidate in results {
            if !candidate.result.is_certified() {
                rest.push(candidate);
            } else if !certified.iter().any(|other| same_result(&other.result, &candidate.result)) {
                certified.push(candidate);
            }
        }
        certified.sort_by(|a, b| a.result.chi2_per_dof.total_cmp(&b.result.chi2_per_dof));
        let mut answers = certified.into_iter();
        let Some(mut answer) = answers.next() else {
            let likelier = |a: Candidate, b: Candidate| if b.is_likelier_than(&a) { b } else { a };
            return rest.into_iter().reduce(likelier).ok_or(ReconstructError::NotSolvable);
        };
        let result = &mut answer.result;
        result.others = answers.map(|candidate| candidate.result).collect();
        result.alternatives = 1 + result.others.len();
        if result.alternatives > 1 {
            result.verdict = Verdict::new(vec![Doubt::Alternatives { objects: result.alternatives }]);
        }
        Ok(answer)
    }
}

impl Job<'_> {
    /// The best starts of a motion without jumps, over all heights of the centre of mass.
    fn starts_in_one_piece(&self, found: &Found) -> Found {
        let whole = 0..self.measurements.len();
        let ranges = vec![whole];
        let thin = thinned_in_ranges(&self.measurements, &ranges, self.scatter_m, INSTANTS_OF_STARTS);
        let sd = self.scatter_m / self.averaged(&thin);
        let noise = Noise { sensor_m: sd, balance_m: sd };
        let mut estimates: Vec<Estimate> = Vec::new();
        for order in ORDERS_OF_STARTS {
            let before = estimates.len();
            for start in from_initial_heights(&thin, noise, self.prior, order) {
                let is_known = |other: &Estimate| same_motion(&other.psi, &start.psi, TAU);
                if estimates.len() < before + STARTS_OF_EACH_ORDER && !estimates[before..].iter().any(is_known) {
                    estimates.push(start);
                }
            }
        }
        Found { calibration: found.calibration, tolerance_m: found.tolerance_m, thin, ranges, estimates }
    }
}

/// Whether nothing is in doubt but where a few samples are.
fn is_certified_but_for_poses(result: &Reconstruction) -> bool {
    let is_of_poses = |doubt: &Doubt| matches!(doubt, Doubt::AmbiguousPoses { .. });
    result.verdict.doubts.iter().all(|doubt| is_of_poses(doubt) || doubt.concerns_center_of_mass_only())
}

/// Whether the log checks itself what it tells; else shape and motion are told by the balance and what is known of shapes beforehand. A contact that
/// goes to and fro over little boundary checks nothing.
pub(super) fn is_checked(result: &Reconstruction) -> bool {
    result.coverage >= LITTLE_FELT && is_mostly_felt_again(&result.outline)
}

/// Share of the boundary below which hardly any can have been felt on both palms, a third of a turn apart: of short logs that were explained wrongly
/// at most 0.25 was.
const LITTLE_FELT: f64 = 0.3;

/// Numbers of harmonics of starts in one piece, and how many of each, with different motions, are taken to an optimum: the right motion was the
/// first or second with the fewer harmonics.
const ORDERS_OF_STARTS: [usize; 2] = [4, 8];
const STARTS_OF_EACH_ORDER: usize = 3;

/// Instants that they are compared on.
const INSTANTS_OF_STARTS: usize = 100;

/// Motions that were taken to their optimum. An arrangement that is one of them leads there again.
#[derive(Default)]
pub(crate) struct Explored {
    /// Orientations of all samples, and the period of the object's symmetry.
    motions: Vec<(Vec<f64>, f64)>,
    /// What was found there.
    results: Vec<Candidate>,
    /// Whether those of starts in one piece are among them, or are only looked for where an answer is to be certified.
    in_one_piece: bool,
}

/// An arrangement is a motion that is known when at most this share of its instants is elsewhere: refinement decodes these anew.
const ELSEWHERE_SHARE: f64 = 0.01;

/// Motions that are taken to their optimum, for each trust in the calibration of the rig, before the search ends without an answer: of 232 logs of the accuracy studies that had
/// one, all but one had it among the first six.
const MOST_EXPLORED: usize = 10;

impl Explored {
    /// None yet, in a search that soon begins anew with more samples: starts in one piece, which take most of the time of a short log, are left to those
    /// that they may keep from being certified wrongly.
    pub fn briefly() -> Self {
        Self { in_one_piece: true, ..Self::default() }
    }

    /// Whether so many led to nothing that another one hardly will.
    pub fn is_enough(&self, trusts: usize) -> bool {
        self.motions.len() >= MOST_EXPLORED * trusts
    }

    /// The answer with what else explains the log about as well or better, whatever speaks against that: it is then a doubt.
    pub fn against_others(self, mut answer: Candidate) -> Reconstruction {
        let is_rival = |other: &Candidate| {
            answer.posterior.log_ratio(&other.posterior) < CERTAIN.0 && !same_result(&answer.result, &other.result)
        };
        let rivals: Vec<Candidate> = self.results.into_iter().filter(is_rival).collect();
        let result = &mut answer.result;
        for rival in rivals {
            if result.is_certified() || !result.others.is_empty() {
                result.others.push(rival.result);
                result.alternatives = 1 + result.others.len();
                result.verdict = Verdict::new(vec![Doubt::Alternatives { objects: result.alternatives }]);
            }
        }
        answer.result
    }

    fn add(&mut self, candidate: &Candidate) {
        self.results.push(candidate.clone());
        let result = &candidate.result;
        let psi = result.motion.iter().map(|pose| pose.psi_rad).collect();
        // The symmetry of an object that the log contradicts says nothing.
        let symmetry = if result.verdict.is_explained() { result.symmetry.symmetry } else { Symmetry::NONE };
        self.motions.push((psi, symmetry.period_rad()));
    }

    /// Whether an arrangement of the search is the part of such a motion that it covers.
    pub fn contains(&self, found: &Found, arrangement: usize) -> bool {
        found.estimates.get(arrangement).is_some_and(|estimate| self.contains_motion(&found.thin, &estimate.psi))
    }

    /// The same of a motion at some instants of the log.
    pub fn contains_motion(&self, thin: &Measurements, motion: &[f64]) -> bool {
        self.motions.iter().any(|(psi, period)| {
            let place = |position: f64| (position.round() as usize).min(psi.len() - 1);
            let there: Vec<f64> = thin.instants.iter().map(|instant| psi[place(instant.position)]).collect();
            moved(&there, motion, *period) as f64 <= ELSEWHERE_SHARE * there.len() as f64
        })
    }
}

/// Whether two results have the same motion, up to a common rotation and the noise.
fn same_result(a: &Reconstruction, b: &Reconstruction) -> bool {
    let psi = |result: &Reconstruction| -> Vec<f64> { result.motion.iter().map(|pose| pose.psi_rad).collect() };
    same_motion(&psi(a), &psi(b), a.symmetry.symmetry.period_rad())
}

/// The arrangements but the first that explain the thinned log about as well as the chosen one, or better. Poses that differ by
/// a multiple of `period` are one.
fn alternatives(thin: &Measurements, candidates: &[Estimate], chosen: &Fit, period: f64) -> Vec<usize> {
    let smoother = Smoother::new(thin, chosen.order, chosen.noise, chosen.prior);
    let smoothed: Vec<Estimate> = candidates
        .par_iter()
        .map(|estimate| smoother.run(estimate.coefficients.clone(), estimate.psi.clone(), COMPARING))
        .collect();
    let best = smoothed.iter().map(|estimate| estimate.cost).fold(f64::INFINITY, f64::min);
    (1..smoothed.len())
        .filter(|&index| smoothed[index].cost < best + NEAR_EQUAL)
        .filter(|&index| !smoothed[..index].iter().any(|other| same_motion(&other.psi, &smoothed[index].psi, period)))
        .take(MOST_ALTERNATIVES)
        .collect()
}

/// Alternative arrangements that are refined at most; half as many where the first is contradicted.
const MOST_ALTERNATIVES: usize = 4;

/// Two arrangements whose sums of squares on the thinned log differ by less than this may explain the log equally well: a
/// generous limit, since refinement decides.
const NEAR_EQUAL: f64 = 40.0;

#[cfg(test)]
mod tests;
