//! Refinement with inertia, for palms so fast that balance does not hold and for objects that swing after a jump (`docs/theory.md`, inertia).
//!
//! Where an optimum misses the balance, the motion becomes a spline and the forces are those of the object in motion. Knots are halved until neither
//! contacts nor forces gain by it. Samples whose pose is ambiguous at rest are left out until the forces have placed them.

use super::job::{Job, Refined};
use crate::estimate::calibration::{CONSTANTS, Matrix, constants, prior_sd};
use crate::estimate::inertia::arrow::SplineGivenDense;
use crate::estimate::inertia::problem::{BESIDES_SHAPE, InertiaPrior, Problem, Unknowns};
use crate::estimate::inertia::smoother::{Bounds, InertialNoise, Optimum};
use crate::estimate::jumps::DetectedJump;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::balance_tolerance::INEXACT_BALANCE;
use crate::estimate::model::contact::{Residuals, contacts, residuals};
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::error_bars::pose_variances;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::estimate::solver::posterior::Posterior;
use crate::math::spline::SplineBasis;
use crate::mechanics::STANDARD_GRAVITY_M_PER_S2;
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::reconstruct::verdict::assemble::{Candidate, Expected, assemble};
use crate::reconstruct::verdict::doubt::{Doubt, Verdict};
use crate::reconstruct::verdict::uncertainty::{FoundRig, PoseErrorBars, Uncertainty};
use crate::shape::SupportFunction;
use nalgebra::{DMatrix, DVector};
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

/// Times that samples are taken back or knots halved, at most.
const ROUNDS: usize = 16;

/// Inertia explains what balance misses where it leaves less than this share of it.
const EXPLAINED_SHARE: f64 = 0.3;

/// The contacts may be missed by so many times what the motion of each sample by itself leaves.
const CONTACTS_ALLOWANCE: f64 = 1.3;

/// A sample that was left out is taken back where the motion comes within this share of the mean radius of its contacts, and stays where it
/// then fits within so many standard deviations.
const TAKEN_BACK: f64 = 1e-2;
const STAYS_SDS: f64 = 5.0;

/// Share of the places at which a palm may have to pull: errors of the motion between samples.
const MOST_PULLING: f64 = 0.01;

/// Share of the places where Student's t may find the forces to be others: impacts, lost contact.
const MOST_UNEXPLAINED: f64 = 0.05;

/// Such a place is missed by so many standard deviations.
const UNEXPLAINED_SDS: f64 = 5.0;

/// A radius of gyration that no mass within the outline has is this many standard deviations beyond the rim.
const BEYOND_RIM_SDS: f64 = 3.0;

impl Job<'_> {
    /// The same arrangement with inertia, where that explains by how much `refined` misses the balance.
    pub fn with_inertia(&self, refined: &Refined, of_balance: &Candidate) -> Option<Candidate> {
        let Noise { sensor_m, balance_m } = refined.fine.noise;
        let floor_m = FORCES_FLOOR * refined.fine.estimate.coefficients[0];
        let is_missed = balance_m > (WORTH_A_TRY * floor_m).max(LOOSE_BALANCE * sensor_m);
        let may_move = is_missed && rests_on_balance(&of_balance.result.verdict);
        may_move
            .then(|| self.explained_by_inertia(refined, refined.fine.estimate.coefficients.clone(), balance_m))
            .flatten()
    }

    /// The same of an arrangement that misses the balance by `static_balance_m`, from these coefficients.
    pub fn explained_by_inertia(
        &self,
        refined: &Refined,
        coefficients: Vec<f64>,
        static_balance_m: f64,
    ) -> Option<Candidate> {
        let fine = &refined.fine;
        if refined.symmetry.symmetry.is_any() {
            return None;
        }
        let (measurements, radius_m) = (&refined.measurements, fine.estimate.coefficients[0]);
        let floor_m = FORCES_FLOOR * radius_m;
        let psi = self.motion(fine);
        let swing_rad_per_s = self.fastest_swing(&coefficients, &psi)?;
        let placed = placed(measurements, &refined.ambiguity_rad);
        let gyration_m = SupportFunction::from_coefficients(&coefficients).uniform_gyration_radius_m();
        let prior = |held: bool| InertiaPrior { ln_gyration_m2: 2.0 * gyration_m.ln(), held };
        let most_m = (CONTACTS_ALLOWANCE * fine.noise.sensor_m).max(floor_m);
        let sensor_m = self.stated_m.map_or([SENSOR_FLOOR * radius_m, most_m], |stated_m| [stated_m; 2]);
        let shape_prior = Prior { origin_sd_m: self.prior.size_m, ..fine.prior };
        let bounds = Bounds { sensor_m, forces_m: floor_m };
        let problem = |weights: &Measurements, pieces: usize| {
            Problem::new(self.raw, &self.options.rig, weights, (fine.order, shape_prior), &self.knots(pieces))
        };

        let unknowns = coefficients.len() + BESIDES_SHAPE;
        let can_be_done = |pieces: usize| pieces as f64 * (unknowns * unknowns) as f64 <= MOST_WORK;
        let pieces = Some(self.pieces(swing_rad_per_s)?).filter(|pieces| can_be_done(*pieces))?;
        let mut first = problem(&placed, pieces)?;
        let is_placed = |index: &usize| placed.instants[*index].both_seen();
        let known: Vec<usize> = (0..psi.len()).filter(is_placed).collect();
        let times_s: Vec<f64> = known.iter().map(|&index| self.raw.samples[index].time_s).collect();
        let known_rad: Vec<f64> = known.iter().map(|&index| psi[index]).collect();
        let start = Unknowns {
            coefficients,
            ln_gyration_m2: prior(true).ln_gyration_m2,
            damping_per_s: 0.0,
            calibration: self.calibration,
            spline: first.basis.approximating(&times_s, &known_rad)?,
        };
        let noise = InertialNoise {
            sensor_m: fine.noise.sensor_m.clamp(sensor_m[0], sensor_m[1]),
            forces_m: FIRST_FORCES * radius_m,
        };
        let held = first.optimum(start, noise, prior(true), bounds, None)?;
        let mut best = first.optimum(held.unknowns, held.noise, prior(false), bounds, None)?;
        let (mut pieces, mut last, mut tried, mut halvings) = (pieces, first, placed.clone(), 0);
        for _ in 0..ROUNDS {
            let near = last.variance_of_motion(&best, prior(false))?;
            let within = self.within(TAKEN_BACK * radius_m, Some(&near), refined, &placed, (&best, &last.basis));
            if within.seen() > tried.seen() {
                last = problem(&within, pieces)?;
                best = last.optimum(best.unknowns, best.noise, prior(false), bounds, None)?;
                tried = within;
                continue;
            }
            if halvings == HALVINGS || !can_be_done(2 * pieces) {
                break;
            }
            let mut finer = problem(&tried, 2 * pieces)?;
            let spline = finer.basis.resampled(&last.basis, &best.unknowns.spline)?;
            let start = Unknowns { spline, ..best.unknowns.clone() };
            let there = finer.optimum(start, best.noise, prior(false), bounds, None)?;
            let gains = there.noise.forces_m < FORCES_GAIN * best.noise.forces_m
                || there.noise.sensor_m < CONTACTS_GAIN * best.noise.sensor_m;
            let moved = finer.moved(&there, &best.unknowns, prior(false))?;
            if !gains && moved > SETTLED && best.noise.forces_m > AT_FLOOR * floor_m {
                break;
            }
            (best, last, pieces, halvings) = (there, finer, 2 * pieces, halvings + 1);
            if !gains && moved <= SETTLED {
                break;
            }
        }
        let freedom = (best.noise.forces_m > AT_FLOOR * floor_m).then_some(STUDENT);
        if freedom.is_some() {
            best = last.optimum(best.unknowns, best.noise, prior(false), bounds, freedom)?;
        }
        let stays = self.within(STAYS_SDS * best.noise.sensor_m, None, refined, &placed, (&best, &last.basis));
        if stays.seen() < tried.seen() {
            last = problem(&stays, pieces)?;
            best = last.optimum(best.unknowns, best.noise, prior(false), bounds, freedom)?;
            tried = stays;
        }
        let uncertainty = OfInertia {
            job: self,
            problem: last,
            optimum: best,
            prior: prior(false),
            static_balance_m,
            robust: freedom.is_some(),
        };
        uncertainty.candidate(refined, &tried)
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
    fn fastest_swing(&self, coefficients: &[f64], psi: &[f64]) -> Option<f64> {
        let gyration_m = SupportFunction::from_coefficients(coefficients).uniform_gyration_radius_m();
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

    /// The samples `placed`, and of the others the contacts that an optimum misses by no more than `off_m`, or by what the variances of its motion
    /// let them be missed by.
    fn within(
        &self,
        off_m: f64,
        variances: Option<&[f64]>,
        refined: &Refined,
        placed: &Measurements,
        (found, basis): (&Optimum, &SplineBasis),
    ) -> Measurements {
        let mut within = placed.clone();
        // Readings that were taken for gross outliers may be those of a fast motion.
        let as_read = Measurements::new(&self.log, self.stated_m);
        let samples = found.corrected.measurements.instants.iter().zip(&self.raw.samples);
        for (index, (corrected, sample)) in samples.enumerate() {
            let instant = &mut within.instants[index];
            if instant.both_seen() {
                continue;
            }
            let (before, read) = (&refined.measurements.instants[index], &as_read.instants[index]);
            let psi = basis.at(sample.time_s).of(&found.unknowns.spline)[0];
            let Residuals { value, by_psi } = residuals(corrected, &found.unknowns.coefficients, psi);
            let psi_variance = variances.map_or(0.0, |variances| variances[index]);
            let weight = |before: f64, read: f64, palm: usize| {
                let weight = if before > 0.0 { before } else { read };
                let allowed_m = off_m.max(STAYS_SDS * by_psi[palm].abs() * psi_variance.sqrt());
                if (weight * value[palm]).abs() <= allowed_m { weight } else { 0.0 }
            };
            instant.weight1 = weight(before.weight1, read.weight1, 0);
            instant.weight2 = weight(before.weight2, read.weight2, 1);
        }
        within
    }
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

/// An optimum with inertia.
struct OfInertia<'a> {
    job: &'a Job<'a>,
    problem: Problem<'a>,
    optimum: Optimum<'a>,
    prior: InertiaPrior,
    /// By how much balance alone is missed, metres.
    static_balance_m: f64,
    /// Whether the forces were allowed to be others here and there.
    robust: bool,
}

impl OfInertia<'_> {
    /// The result, where it explains what balance does not.
    fn candidate(&self, refined: &Refined, weights: &Measurements) -> Option<Candidate> {
        let Self { job, problem, optimum, .. } = self;
        let Optimum { unknowns, corrected, noise, .. } = optimum;
        let of_balance = refined.fine.noise;
        let explained = noise.forces_m < EXPLAINED_SHARE * self.static_balance_m
            && noise.sensor_m < (CONTACTS_ALLOWANCE * of_balance.sensor_m).max(FORCES_FLOOR * unknowns.coefficients[0]);
        if !optimum.settled || !explained || !self.is_possible() {
            return None;
        }
        let inertia = self.inertia()?;
        // Where the forces may be others, they do not place a sample whose contacts do not.
        if self.robust && weights.seen() < refined.measurements.seen() {
            return None;
        }
        let is_within =
            inertia.gyration_radius_m - BEYOND_RIM_SDS * inertia.gyration_radius_sd_m < rim_m(&unknowns.coefficients);
        if !is_within {
            return None;
        }
        let psi = problem.motion(unknowns);
        let fit = Fit {
            estimate: Estimate { coefficients: unknowns.coefficients.clone(), psi, cost: 0.0 },
            order: refined.fine.order,
            noise: Noise { sensor_m: noise.sensor_m, balance_m: noise.forces_m },
            prior: refined.fine.prior,
            log_evidence: optimum.log_evidence,
        };
        // Where the contacts contradict the motion it may be another; where nothing was felt, the forces say what it was.
        let instants = weights.instants.iter().zip(&refined.measurements.instants);
        let contradicts =
            |(now, before): (&Instant, &Instant)| before.weight1 > now.weight1 || before.weight2 > now.weight2;
        let ambiguity_rad: Vec<f64> = instants
            .zip(&refined.ambiguity_rad)
            .map(|(instants, ambiguity_rad)| if contradicts(instants) { *ambiguity_rad } else { 0.0 })
            .collect();
        let expected = Expected { stated_m: job.stated_m, scatter_m: job.scatter_m, outliers: job.outliers };
        let log = unknowns.calibration.corrected(job.raw);
        assemble(
            &log,
            &corrected.measurements,
            fit,
            (&ambiguity_rad, FoundSymmetry { ..refined.symmetry }),
            expected,
            self,
            &job.options.limits,
        )
    }

    /// Whether the palms push nearly everywhere, and the forces are what they should be.
    fn is_possible(&self) -> bool {
        let moments = self.problem.moments(&self.optimum.unknowns, &self.optimum.corrected);
        let limit_m = UNEXPLAINED_SDS * self.optimum.noise.forces_m;
        let unexplained = moments.iter().filter(|moment| moment.value_m.abs() > limit_m).count();
        let pulls = moments.iter().filter(|moment| moment.normal_forces.iter().any(|force| *force < 0.0)).count();
        let share = |count: usize| count as f64 / moments.len().max(1) as f64;
        share(unexplained) <= MOST_UNEXPLAINED && share(pulls) <= MOST_PULLING
    }
}

/// The largest distance of the boundary from the centre of mass.
fn rim_m(coefficients: &[f64]) -> f64 {
    let shape = SupportFunction::from_coefficients(coefficients);
    let distance_m = |degree: u32| {
        let point = shape.boundary_point(f64::from(degree).to_radians());
        point.x_m.hypot(point.y_m)
    };
    (0..360).map(distance_m).fold(0.0, f64::max)
}

struct InertiaErrorBars<'a> {
    of: &'a OfInertia<'a>,
    layout: Layout,
    covariance: DMatrix<f64>,
    spline: SplineGivenDense,
    inflation: f64,
}

impl Uncertainty for OfInertia<'_> {
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
        let eliminated = self.problem.eliminated(&self.optimum, self.prior)?;
        let layout = Layout { order: self.optimum.unknowns.coefficients.len() / 2, shared: BESIDES_SHAPE };
        let mut mean = DVector::zeros(layout.unknowns());
        let coefficients = &self.optimum.unknowns.coefficients;
        mean.rows_mut(0, coefficients.len()).copy_from_slice(coefficients);
        let information = eliminated.information().clone();
        let covariance = Posterior { layout, mean, information }.covariance_over(felt)?;
        Some(Box::new(InertiaErrorBars { of: self, layout, covariance, spline: eliminated.given_dense(), inflation }))
    }

    fn of_rig(&self, inflation: f64) -> Option<FoundRig> {
        let rig = &self.job.options.rig;
        let sd = prior_sd(&rig.tolerances);
        if sd == [0.0; CONSTANTS] {
            return None;
        }
        let eliminated = self.problem.eliminated(&self.optimum, self.prior)?;
        let all = eliminated.information().clone().cholesky()?.inverse();
        let first = all.nrows() - CONSTANTS;
        // No correlation of errors takes away what was known before.
        let within = |variance: f64, i: usize, j: usize| if i == j { variance.min(1.0) } else { variance };
        let covariance = Matrix::from_fn(|i, j| within(inflation * all[(first + i, first + j)], i, j) * sd[i] * sd[j]);
        let found = self.optimum.unknowns.calibration;
        let off = constants(&found).into_iter().zip(constants(&rig.calibration)).zip(sd);
        let off = off.map(|((found, stated), sd)| if sd > 0.0 { (found - stated).abs() / sd } else { 0.0 });
        let names = crate::sensor::CalibrationConstant::ALL.iter().map(|constant| constant.name.to_owned());
        let furthest = names.zip(off).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(FoundRig {
            estimate: FoundRig::estimate(found, rig, &covariance),
            furthest,
            unsettled_sds: 0.0,
            log_evidence: 0.0,
        })
    }

    fn inertia(&self) -> Option<InertiaEstimate> {
        let Unknowns { coefficients, ln_gyration_m2, damping_per_s, .. } = &self.optimum.unknowns;
        let eliminated = self.problem.eliminated(&self.optimum, self.prior)?;
        let covariance = eliminated.information().clone().cholesky()?.inverse();
        let index = self.problem.gyration_index();
        let gyration_radius_m = (0.5 * ln_gyration_m2).exp();
        Some(InertiaEstimate {
            gyration_radius_m,
            gyration_radius_sd_m: 0.5 * gyration_radius_m * covariance[(index, index)].sqrt(),
            uniform_gyration_radius_m: SupportFunction::from_coefficients(coefficients).uniform_gyration_radius_m(),
            damping_per_s: *damping_per_s,
            damping_sd_per_s: covariance[(index + 1, index + 1)].sqrt(),
            static_balance_sd_m: self.static_balance_m,
        })
    }
}

impl PoseErrorBars for InertiaErrorBars<'_> {
    fn r_sd_m(&self, theta: f64) -> f64 {
        let row = self.layout.support_row(theta);
        (self.inflation * (&self.covariance * &row).dot(&row).max(0.0)).sqrt()
    }

    fn pose_sd(&self, index: usize, instant: &Instant) -> (f64, f64) {
        let row = &self.of.problem.samples[index];
        let unknowns = &self.of.optimum.unknowns;
        let psi = row.of(&unknowns.spline)[0];
        let given = (self.spline.slope(row), self.spline.variance(row));
        let at = (instant, &unknowns.coefficients[..], psi);
        let (of_psi, of_center) = pose_variances(self.layout, &self.covariance, given, at);
        ((self.inflation * of_psi).sqrt(), (self.inflation * of_center).sqrt())
    }

    fn deviance_of(&self, _: &[DetectedJump]) -> Option<f64> {
        // The forces say where the object goes.
        Some(0.0)
    }
}
