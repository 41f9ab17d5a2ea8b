//! Refinement with inertia, for palms so fast that balance does not hold and for objects that swing after a jump (`docs/theory.md`, inertia).
//!
//! Where an optimum misses the balance, the motion becomes a spline and the forces are those of the object in motion. Knots are halved until neither
//! contacts nor forces gain by it. Samples whose pose is ambiguous at rest are left out until the forces have placed them.

mod plausible;
mod worth;

use self::plausible::least_share_left;
use self::worth::{OfInertia, is_believed};
use super::job::{Job, Refined};
use crate::estimate::evidence::order::{ORDERS, PATIENCE};
use crate::estimate::inertia::palm_path::PalmPath;
use crate::estimate::inertia::problem::{BESIDES_SHAPE, InertiaPrior, Problem, Unknowns};
use crate::estimate::inertia::smoother::{Bounds, InertialNoise, Optimum};
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::balance_tolerance::INEXACT_BALANCE;
use crate::estimate::model::contact::{Residuals, contacts, residuals};
use crate::estimate::model::layout::{Layout, coefficients_to_order};
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::prior::Prior;
use crate::mechanics::STANDARD_GRAVITY_M_PER_S2;
use crate::reconstruct::verdict::assemble::Candidate;
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::shape::{SupportFunction, Symmetry};
use std::f64::consts::TAU;

/// Least standard deviation of the forces that is believed, as a share of the mean radius: no palm is exact to less.
const FORCES_FLOOR: f64 = 1e-4;

/// Balance missed by less than so many times that floor, or than this share of the sensor noise, is left to statics.
const WORTH_A_TRY: f64 = 3.0;
const LOOSE_BALANCE: f64 = INEXACT_BALANCE;

/// Standard deviation of the forces that the first fit begins with, as a share of the mean radius.
const FIRST_FORCES: f64 = 1e-2;

/// Least standard deviation of a contact position, as a share of the mean radius: far below any sensor.
const SENSOR_FLOOR: f64 = 1e-6;

/// Knots in the fastest swing of the object, and times that they are halved at most.
const KNOTS_PER_SWING: f64 = 8.0;
const HALVINGS: usize = 4;

/// Halvings by which neither contacts nor forces gain, at most: what has not settled by then does not.
const IDLE_HALVINGS: usize = 2;

/// The swing is that of the stiffest poses but for this share of them.
const STIFFEST: f64 = 0.05;

/// Pieces of the spline at least.
const FEWEST_PIECES: usize = 8;

/// Pieces of the spline times the square of the number of unknowns that they share, at most: a step takes as long as that.
const MOST_WORK: f64 = 2e7;

/// Halving goes on while the forces, or the contacts, fall below these shares of what they were.
const FORCES_GAIN: f64 = 0.8;
const CONTACTS_GAIN: f64 = 0.9;

/// Forces within so many times their floor are explained.
const AT_FLOOR: f64 = 1.2;

/// Halving ends where it moves the shared unknowns by less than this, as the mean square of their standard deviations.
const SETTLED: f64 = 0.05;

/// Where the first fit leaves more than this share of what balance misses (root mean square), inertia is not what is the matter; and where balance
/// is good enough for the certificate, it is not worth the time.
const PROMISING_SHARE: f64 = 0.8;
const WORTHWHILE_SHARE: f64 = 0.2;

/// A fit with inertia is begun where the accelerations of the motion leave no more than this share of the squares that balance misses: of logs with
/// inertia, ringing ones too, they left 0.02 at most, of those with friction 0.17 and more but where that jumps a lot.
const MOST_LEFT: f64 = 0.1;

/// Times that samples are taken back or knots halved, at most.
const ROUNDS: usize = 16;

/// What the fits of one arrangement with inertia are worth, as a share of what a search is: with half of it some that more harmonics explain came to no end.
const WORTH: f64 = 0.2;

/// The contacts may be missed by so many times what the motion of each sample by itself leaves.
const CONTACTS_ALLOWANCE: f64 = 1.3;

/// A sample that was left out is taken back where the motion comes within this share of the mean radius of its contacts, and stays where it
/// then fits within so many standard deviations.
const TAKEN_BACK: f64 = 1e-2;
const STAYS_SDS: f64 = 5.0;

impl Job<'_> {
    /// The same arrangement with inertia, where that explains by how much `refined` misses the balance.
    pub fn with_inertia(&self, refined: &Refined, of_balance: &Candidate) -> Option<Candidate> {
        let Noise { sensor_m, balance_m } = refined.fine.noise;
        let floor_m = FORCES_FLOOR * refined.fine.estimate.coefficients[0];
        let is_missed = balance_m > (WORTH_A_TRY * floor_m).max(LOOSE_BALANCE * sensor_m);
        let may_move = is_missed && rests_on_balance(&of_balance.result.verdict);
        let share = if of_balance.result.is_com_certified() { WORTHWHILE_SHARE } else { PROMISING_SHARE };
        let coefficients = || refined.fine.estimate.coefficients.clone();
        may_move.then(|| self.worth(WORTH).fitted_with_inertia(refined, coefficients(), balance_m, share)).flatten()
    }

    /// The same of an arrangement that misses the balance by `static_balance_m`, from these coefficients.
    pub fn explained_by_inertia(
        &self,
        refined: &Refined,
        coefficients: Vec<f64>,
        static_balance_m: f64,
    ) -> Option<Candidate> {
        self.worth(WORTH).fitted_with_inertia(refined, coefficients, static_balance_m, PROMISING_SHARE)
    }

    /// The same of one that a search for a motion with inertia led to, for all that the log is worth.
    pub fn explained_in_motion_by(&self, refined: &Refined, static_balance_m: f64) -> Option<Candidate> {
        let coefficients = refined.fine.estimate.coefficients.clone();
        self.worth(1.0).fitted_with_inertia(refined, coefficients, static_balance_m, PROMISING_SHARE)
    }

    /// The same where the first fit leaves no more than a share of what balance misses.
    fn fitted_with_inertia(
        &self,
        refined: &Refined,
        coefficients: Vec<f64>,
        static_balance_m: f64,
        promising_share: f64,
    ) -> Option<Candidate> {
        let (fine, radius_m) = (&refined.fine, coefficients[0]);
        let floor_m = FORCES_FLOOR * radius_m;
        let most_m = (CONTACTS_ALLOWANCE * fine.noise.sensor_m).max(floor_m);
        let fitting = Fitting {
            job: self,
            refined,
            path: PalmPath::new(self.raw)?,
            placed: Measurements {
                work: self.measurements.work.clone(),
                ..placed(&refined.measurements, &refined.ambiguity_rad)
            },
            // What of it looks symmetric may be so at rest alone.
            prior: Prior { origin_sd_m: self.prior.size_m, symmetry: Symmetry::NONE, ..fine.prior },
            gyration_m: SupportFunction::from_coefficients(&coefficients).uniform_gyration_radius_m(),
            bounds: Bounds {
                sensor_m: self.stated_m.map_or([SENSOR_FLOOR * radius_m, most_m], |stated_m| [stated_m; 2]),
                forces_m: floor_m,
            },
        };
        if fitting.least_share_left(&coefficients) > MOST_LEFT {
            return None;
        }
        let missed_m = balance_missed_m(&fitting.placed, &coefficients, &fine.estimate.psi);
        let is_promising = |stage: &Stage| {
            let Optimum { noise, unknowns, .. } = &stage.optimum;
            let gyration_share = (0.5 * unknowns.ln_gyration_m2).exp() / fitting.gyration_m;
            noise.forces_m < promising_share * missed_m && is_believed(gyration_share, unknowns.damping_per_s)
        };
        let first = Some(fitting.first(coefficients)?).filter(is_promising)?;
        let grown = fitting.with_order_by_evidence(fitting.grown(first)?)?;
        let robust = grown.optimum.noise.forces_m > AT_FLOOR * floor_m;
        let Stage { problem, weights, optimum, .. } = fitting.last(grown, robust.then_some(STUDENT))?;
        OfInertia { job: self, problem, optimum, static_balance_m, robust }.candidate(refined, &weights)
    }

    /// So many equal pieces over the log.
    fn knots(&self, pieces: usize) -> Vec<f64> {
        let samples = &self.raw.samples;
        let (from, to) = (samples[0].time_s, samples[samples.len() - 1].time_s);
        (0..=pieces).map(|i| from + (to - from) * i as f64 / pieces as f64).collect()
    }

    /// Pieces of the spline for such a swing.
    fn pieces(&self, swing_rad_per_s: f64) -> Option<usize> {
        let samples = &self.raw.samples;
        let duration_s = samples.last()?.time_s - samples.first()?.time_s;
        let pieces = (duration_s * swing_rad_per_s * KNOTS_PER_SWING / TAU).ceil();
        Some((pieces as usize).max(FEWEST_PIECES))
    }

    /// The angular frequency of a small swing at the stiffest poses: ω² = g h''/(k² + |dc/dψ|²) with h'' = g'/sin φ₂.
    fn fastest_swing(&self, coefficients: &[f64], psi: &[f64], gyration_m: f64) -> Option<f64> {
        let square = |(instant, psi): (&Instant, &f64)| {
            let at = contacts(instant, coefficients, *psi);
            let stiffness_m = residuals(instant, coefficients, *psi).by_psi[2] * instant.palms.inverse2;
            let [x, y] = instant.palms.center(at.d);
            STANDARD_GRAVITY_M_PER_S2 * stiffness_m / (gyration_m * gyration_m + x * x + y * y)
        };
        let mut squares: Vec<f64> = self.measurements.instants.iter().zip(psi).map(square).collect();
        let last = squares.len().checked_sub(1)?;
        let index = ((1.0 - STIFFEST) * last as f64) as usize;
        let (_, square, _) = squares.select_nth_unstable_by(index, f64::total_cmp);
        (*square > 0.0).then(|| square.sqrt())
    }
}

/// A fit with inertia from one arrangement.
struct Fitting<'a> {
    job: &'a Job<'a>,
    refined: &'a Refined,
    path: PalmPath,
    /// The measurements without those of samples that may be elsewhere.
    placed: Measurements,
    prior: Prior,
    /// Radius of gyration of an even mass, metres.
    gyration_m: f64,
    bounds: Bounds,
}

/// How far it has come.
struct Stage<'a> {
    problem: Problem<'a>,
    /// Pieces of its spline.
    pieces: usize,
    /// The samples that count.
    weights: Measurements,
    optimum: Optimum<'a>,
}

impl Stage<'_> {
    /// Number of harmonics.
    fn order(&self) -> usize {
        Layout::of_coefficients(&self.optimum.unknowns.coefficients).order
    }
}

impl<'a> Fitting<'a> {
    fn inertia(&self) -> InertiaPrior {
        InertiaPrior::free(2.0 * self.gyration_m.ln())
    }

    fn problem(&self, weights: &Measurements, pieces: usize, order: usize) -> Problem<'a> {
        let job = self.job;
        let readings = (job.raw, &job.options.rig, self.path.clone());
        Problem::new(readings, weights, (order, self.prior), &job.knots(pieces))
    }

    /// The least share of the squares of that which inertia leaves.
    fn least_share_left(&self, coefficients: &[f64]) -> f64 {
        let times_s: Vec<f64> = self.job.raw.samples.iter().map(|sample| sample.time_s).collect();
        let psi = self.job.motion(&self.refined.fine);
        least_share_left(&self.placed, &times_s, coefficients, &psi, self.gyration_m)
    }

    /// Whether so many pieces cost no more than is allowed.
    fn can_be_done(pieces: usize, order: usize) -> bool {
        let unknowns = 2 * order + 1 + BESIDES_SHAPE;
        pieces as f64 * (unknowns * unknowns) as f64 <= MOST_WORK
    }

    /// The optimum on the samples whose pose is certain, with the longest pieces; the inertia held first.
    fn first(&self, coefficients: Vec<f64>) -> Option<Stage<'a>> {
        let Self { job, placed, .. } = self;
        let psi = job.motion(&self.refined.fine);
        let pieces = job.pieces(job.fastest_swing(&coefficients, &psi, self.gyration_m)?)?;
        let order = Layout::of_coefficients(&coefficients).order;
        if !Self::can_be_done(pieces, order) {
            return None;
        }
        let mut problem = self.problem(placed, pieces, order);
        let is_placed = |index: &usize| placed.instants[*index].both_seen();
        let (times_s, known_rad): (Vec<f64>, Vec<f64>) =
            (0..psi.len()).filter(is_placed).map(|index| (job.raw.samples[index].time_s, psi[index])).unzip();
        let [least_m, most_m] = self.bounds.sensor_m;
        let noise = InertialNoise {
            sensor_m: self.refined.fine.noise.sensor_m.clamp(least_m, most_m),
            forces_m: FIRST_FORCES * coefficients[0],
        };
        let held = InertiaPrior::held(2.0 * self.gyration_m.ln());
        let start = Unknowns {
            coefficients,
            ln_gyration_m2: held.ln_gyration_m2,
            damping_per_s: 0.0,
            calibration: job.calibration,
            spline: problem.basis.approximating(&times_s, &known_rad)?,
        };
        let first = problem.optimum(start, noise, held, self.bounds, None)?;
        let optimum = problem.optimum(first.unknowns, first.noise, self.inertia(), self.bounds, None)?;
        Some(Stage { problem, pieces, weights: placed.clone(), optimum })
    }

    /// The same with the other samples taken back as far as the motion comes near them, and pieces so short that shorter ones change nothing.
    fn grown(&self, mut stage: Stage<'a>) -> Option<Stage<'a>> {
        let (mut halvings, mut idle, free) = (0, 0, self.inertia());
        // The stage before halvings that gain nothing and settle nothing: pieces that are still too long for the motion do not either.
        let mut before: Option<Stage<'a>> = None;
        for _ in 0..ROUNDS {
            let variances = stage.problem.variance_of_motion(&stage.optimum);
            let weights = self.within(TAKEN_BACK * stage.optimum.unknowns.coefficients[0], Some(&variances), &stage);
            if weights.seen() > stage.weights.seen() {
                stage = self.with(weights, stage, None)?;
                continue;
            }
            if halvings == HALVINGS || idle == IDLE_HALVINGS || !Self::can_be_done(2 * stage.pieces, stage.order()) {
                break;
            }
            let mut finer = self.problem(&stage.weights, 2 * stage.pieces, stage.order());
            let Optimum { unknowns, noise, .. } = &stage.optimum;
            let spline = finer.basis.resampled(&stage.problem.basis, &unknowns.spline)?;
            let start = Unknowns { spline, ..unknowns.clone() };
            // Pieces so short that not every one of them is determined.
            let Some(there) = finer.optimum(start, *noise, free, self.bounds, None) else { break };
            let reached = before.as_ref().unwrap_or(&stage).optimum.noise;
            let gains = there.noise.forces_m < FORCES_GAIN * reached.forces_m
                || there.noise.sensor_m < CONTACTS_GAIN * reached.sensor_m;
            let has_settled = finer.moved(&there, unknowns) <= SETTLED;
            halvings += 1;
            idle += usize::from(!gains);
            let shorter =
                Stage { problem: finer, pieces: 2 * stage.pieces, weights: stage.weights.clone(), optimum: there };
            let coarser = std::mem::replace(&mut stage, shorter);
            if gains || has_settled || reached.forces_m <= AT_FLOOR * self.bounds.forces_m {
                before = None;
            } else {
                before.get_or_insert(coarser);
            }
            if !gains && has_settled {
                break;
            }
        }
        (!stage.problem.work.is_spent()).then(|| before.unwrap_or(stage))
    }

    /// The same with the number of harmonics that the evidence asks for, where that is larger: contacts alone, of a motion that is free, ask for fewer. What
    /// more harmonics explain may need shorter pieces, which then are.
    fn with_order_by_evidence(&self, stage: Stage<'a>) -> Option<Stage<'a>> {
        if self.job.options.harmonics.is_some() {
            return Some(stage);
        }
        let order = stage.order();
        let mut best = stage;
        let mut from = best.optimum.unknowns.clone();
        let mut worse = 0;
        for more in ORDERS.into_iter().filter(|more| *more > order) {
            if !Self::can_be_done(best.pieces, more) {
                break;
            }
            coefficients_to_order(&mut from.coefficients, more);
            let mut problem = self.problem(&best.weights, best.pieces, more);
            let noise = best.optimum.noise;
            let Some(there) = problem.optimum(from, noise, self.inertia(), self.bounds, None) else { break };
            from = there.unknowns.clone();
            if there.log_evidence > best.optimum.log_evidence {
                best = Stage { problem, optimum: there, ..best };
                worse = 0;
            } else {
                worse += 1;
                if worse == PATIENCE {
                    break;
                }
            }
        }
        if best.order() > order { self.grown(best) } else { Some(best) }
    }

    /// The same with forces that may be others here and there under Student's t, and without samples that do not fit.
    fn last(&self, mut stage: Stage<'a>, freedom: Option<f64>) -> Option<Stage<'a>> {
        if freedom.is_some() {
            stage = self.with(stage.weights.clone(), stage, freedom)?;
        }
        let stays = self.within(STAYS_SDS * stage.optimum.noise.sensor_m, None, &stage);
        if stays.seen() < stage.weights.seen() { self.with(stays, stage, freedom) } else { Some(stage) }
    }

    /// A stage with other samples.
    fn with(&self, weights: Measurements, from: Stage<'a>, freedom: Option<f64>) -> Option<Stage<'a>> {
        let mut problem = self.problem(&weights, from.pieces, from.order());
        let Optimum { unknowns, noise, .. } = from.optimum;
        let optimum = problem.optimum(unknowns, noise, self.inertia(), self.bounds, freedom)?;
        Some(Stage { problem, pieces: from.pieces, weights, optimum })
    }

    /// The samples `placed`, and of the others the contacts that an optimum misses by no more than `off_m`, or by what the variances of its motion
    /// let them be missed by.
    fn within(&self, off_m: f64, variances: Option<&[f64]>, stage: &Stage) -> Measurements {
        let Self { job, refined, .. } = self;
        let Stage { problem, optimum, .. } = stage;
        let mut within = self.placed.clone();
        // Readings that were taken for gross outliers may be those of a fast motion.
        let as_read = Measurements::new(&job.log, job.stated_m);
        for (index, corrected) in optimum.corrected.measurements.instants.iter().enumerate() {
            let instant = &mut within.instants[index];
            if instant.both_seen() {
                continue;
            }
            let counts = [instant.weight1 > 0.0, instant.weight2 > 0.0];
            let (before, read) = (&refined.measurements.instants[index], &as_read.instants[index]);
            let psi = problem.samples[index].of(&optimum.unknowns.spline)[0];
            let Residuals { value, by_psi } = residuals(corrected, &optimum.unknowns.coefficients, psi);
            let psi_variance = variances.map_or(0.0, |variances| variances[index]);
            let weight = |before: f64, read: f64, palm: usize| {
                let weight = if before > 0.0 { before } else { read };
                let allowed_m = off_m.max(STAYS_SDS * by_psi[palm].abs() * psi_variance.sqrt());
                if counts[palm] || (weight * value[palm]).abs() <= allowed_m { weight } else { 0.0 }
            };
            instant.weight1 = weight(before.weight1, read.weight1, 0);
            instant.weight2 = weight(before.weight2, read.weight2, 1);
        }
        within
    }
}

/// By how much balance alone is missed with these coefficients and this motion, swings and all: root mean square, metres.
pub(super) fn balance_missed_m(measurements: &Measurements, coefficients: &[f64], psi: &[f64]) -> f64 {
    let square = |(instant, psi): (&Instant, &f64)| residuals(instant, coefficients, *psi).value[2].powi(2);
    let squares: f64 = measurements.instants.iter().zip(psi).map(square).sum();
    (squares / psi.len().max(1) as f64).sqrt()
}

/// Whether all doubts may come from an object that is not at rest.
fn rests_on_balance(verdict: &Verdict) -> bool {
    let contradicts = |doubt: &Doubt| matches!(doubt, Doubt::NegativeRadius | Doubt::NotConvex | Doubt::Misfit { .. });
    !verdict.doubts.iter().any(contradicts)
}

/// The measurements without those of samples that may be elsewhere.
fn placed(measurements: &Measurements, ambiguity_rad: &[f64]) -> Measurements {
    let mut placed = measurements.clone();
    let ambiguous = placed.instants.iter_mut().zip(ambiguity_rad).filter(|(_, ambiguity_rad)| **ambiguity_rad > 0.0);
    ambiguous.for_each(|(instant, _)| instant.set_aside());
    placed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::evidence::Evidence;
    use crate::estimate::model::sensor_memory::with_memory;
    use crate::estimate::solver::gauss_newton::{Estimate, Fit};
    use crate::palms::PalmMotion;
    use crate::reconstruct::ReconstructOptions;
    use crate::reconstruct::result::reconstruction::FoundSymmetry;
    use crate::sensor::Touchpad;
    use crate::simulate::{ObjectInertia, SimulateOptions, Simulation, simulate};

    /// An object of three harmonics between fast palms.
    fn swinging() -> (SupportFunction, Simulation) {
        let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
        let motion = PalmMotion::random(3, 8.0, 0.5).and_then(|motion| motion.sample(40.0)).expect("possible");
        let touchpad = Touchpad { noise_sd_m: 5e-5, ..Touchpad::ideal() };
        let inertia = Some(ObjectInertia { gyration_radius_m: None, damping_per_s: 0.3 });
        let run = simulate(&shape, &motion, &SimulateOptions { touchpad, inertia, ..SimulateOptions::default() });
        (shape, run.expect("possible"))
    }

    /// What contact alone leads to: the true motion, the form about an origin that is off.
    fn by_contact(job: &Job, shape: &SupportFunction, run: &Simulation) -> Refined {
        let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let coefficients = shape.translated(1e-3, -5e-4).coefficients();
        let estimate = Estimate { coefficients, psi, cost: 0.0 };
        let noise = Noise { sensor_m: 5e-5, balance_m: 1e-3 };
        let fit = Fit { estimate, order: 3, noise, prior: job.prior, evidence: Evidence::NONE };
        Refined {
            coarse: fit.clone(),
            fine: fit,
            measurements: job.measurements.clone(),
            ambiguity_rad: vec![0.0; job.measurements.len()],
            symmetry: FoundSymmetry::default(),
            settled: true,
            posterior: Evidence::NONE,
            rivals: Vec::new(),
            as_likely: Vec::new(),
        }
    }

    #[test]
    fn the_centre_of_mass_comes_out_and_left_out_samples_are_taken_back() {
        let (shape, run) = swinging();
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let mut refined = by_contact(&job, &shape, &run);
        // A tenth of a second that may be elsewhere, and is taken to be.
        for index in 100..106 {
            refined.ambiguity_rad[index] = 1.0;
            refined.fine.estimate.psi[index] += 1.0;
        }
        let start = refined.fine.estimate.coefficients.clone();
        let found = job.explained_by_inertia(&refined, start.clone(), 1e-3).expect("inertia explains it").result;
        assert!(found.is_com_certified(), "{}", found.verdict);
        let off_m = |theta: f64| found.shape.at(theta - run.truth.motion[0].psi_rad).r - shape.at(theta).r;
        let turned = |theta: f64| found.shape.at(theta).r - shape.at(theta - run.truth.motion[0].psi_rad).r;
        let largest = |of: &dyn Fn(f64) -> f64| (0..60).map(|i| of(0.1 * f64::from(i)).abs()).fold(0.0, f64::max);
        assert!(largest(&off_m).min(largest(&turned)) < 1e-4, "{} {}", largest(&off_m), largest(&turned));
        for (pose, truth) in found.motion.iter().zip(&run.truth.motion) {
            let turn = pose.psi_rad - truth.psi_rad + run.truth.motion[0].psi_rad;
            assert!(turn.abs() < 0.02, "{turn} at {} s", pose.time_s);
        }
        // Where balance misses little more than what is left, inertia explains nothing.
        let left_m = found.balance_sd_m;
        assert!(job.explained_by_inertia(&refined, start.clone(), 0.99 * left_m / worth::EXPLAINED_SHARE).is_none());
        assert!(job.explained_by_inertia(&refined, start, 1.01 * left_m / worth::EXPLAINED_SHARE).is_some());
    }

    #[test]
    fn samples_that_share_an_error_tell_inertia_once() {
        let (shape, run) = swinging();
        let options = ReconstructOptions::default();
        let gyration_sd_m = |memory: f64| {
            let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
            let mut exact = run.log.clone();
            for (sample, psi) in exact.samples.iter_mut().zip(&psi) {
                let (s1_m, s2_m) = sample.palms.contact_positions_m(&shape, *psi);
                (sample.s1_m, sample.s2_m) = (Some(s1_m), Some(s2_m));
            }
            let log = with_memory(exact, 5e-5, memory);
            let job = Job::new(&log, &options);
            let refined = by_contact(&job, &shape, &run);
            let start = refined.fine.estimate.coefficients.clone();
            let found = job.explained_by_inertia(&refined, start, 1e-3).expect("inertia explains it").result;
            found.inertia.expect("inertia").gyration_radius_sd_m
        };
        let ratio = gyration_sd_m(5.0) / gyration_sd_m(1.0);
        assert!((1.5..3.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn forces_tell_harmonics_that_contacts_of_a_free_motion_do_not_ask_for() {
        let (_, run) = swinging();
        let harmonics = |of: Option<usize>, order: usize| {
            let options = ReconstructOptions { harmonics: of, ..ReconstructOptions::default() };
            let job = Job::new(&run.log, &options);
            let shape = SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
            let mut refined = by_contact(&job, &shape, &run);
            coefficients_to_order(&mut refined.fine.estimate.coefficients, order);
            refined.fine.order = order;
            let start = refined.fine.estimate.coefficients.clone();
            let found = job.explained_by_inertia(&refined, start, 1e-3);
            found.map(|found| found.result.shape.harmonics_m().len())
        };
        // Of its three harmonics the last is left to the forces.
        assert!(harmonics(None, 2).is_some_and(|found| found >= 3), "{:?}", harmonics(None, 2));
        assert_eq!(harmonics(Some(3), 3), Some(3));
    }

    #[test]
    fn balance_that_is_missed_a_little_is_left_to_statics() {
        let (shape, run) = swinging();
        let options = ReconstructOptions::default();
        let job = Job::new(&run.log, &options);
        let refined = by_contact(&job, &shape, &run);
        let result = job.explained_by_inertia(&refined, refined.fine.estimate.coefficients.clone(), 1e-3);
        let candidate = result.expect("inertia explains it");
        let with = |sensor_m: f64, balance_m: f64| {
            let mut refined = by_contact(&job, &shape, &run);
            refined.fine.noise = Noise { sensor_m, balance_m };
            job.with_inertia(&refined, &candidate).is_some()
        };
        assert!(with(5e-5, 1.01 * LOOSE_BALANCE * 5e-5) && !with(5e-5, 0.99 * LOOSE_BALANCE * 5e-5));
    }

    #[test]
    fn only_a_contradiction_by_the_contacts_rules_inertia_out() {
        let unphysical = Doubt::UnphysicalJumps { time_s: 1.0, turn_rad: 0.2, jumps: 1 };
        assert!(rests_on_balance(&Verdict::new(vec![unphysical.clone()])));
        assert!(!rests_on_balance(&Verdict::new(vec![unphysical, Doubt::NotConvex])));
    }
}
