//! What an optimum with inertia is worth: whether it explains what balance does not, its error bars, and the result made of it.

use super::{CONTACTS_ALLOWANCE, FORCES_FLOOR};
use crate::estimate::inertia::problem::{BESIDES_SHAPE, Problem, Unknowns, off_prior_sds};
use crate::estimate::inertia::smoother::Optimum;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::sensor_memory::samples_per_error_by;
use crate::estimate::solver::gauss_newton::{Estimate, Fit};
use crate::reconstruct::refine::job::{Job, Refined};
use crate::reconstruct::result::friction::FrictionEstimate;
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::reconstruct::result::reconstruction::FoundSymmetry;
use crate::reconstruct::verdict::assemble::{Candidate, assemble};
use crate::reconstruct::verdict::joint_error_bars::JointErrorBars;
use crate::reconstruct::verdict::uncertainty::{FoundRig, PoseErrorBars, Uncertainty};
use crate::shape::SupportFunction;

/// Share of the places at which a palm may have to pull: errors of the motion between samples.
const MOST_PULLING: f64 = 0.01;

/// Share of the places where Student's t may find the forces to be others: impacts, lost contact.
const MOST_UNEXPLAINED: f64 = 0.05;

/// Such a place is missed by so many standard deviations.
const UNEXPLAINED_SDS: f64 = 5.0;

/// A radius of gyration that no mass within the outline has is this many standard deviations beyond the rim.
const BEYOND_RIM_SDS: f64 = 3.0;

/// Inertia that is further from what is believed of it is not what is the matter: a radius of gyration of 0.37 times that of an even mass, or a swing that is
/// damped out in 20 ms. Almost without mass, and overdamped, an object goes whatever way the contacts have it go.
const FURTHEST_SDS: f64 = 5.0;

/// Inertia that is what balance misses is told by it: of 28 logs of fast palms the radius of gyration had a standard deviation of 0.7 % of that of an
/// even mass at most, and where a motion went wherever a spline could go, 7 %.
const TOLD_SHARE: f64 = 0.03;

/// Where the contacts are missed over more samples in a row than errors of the sensors hang together, by so many times, a motion is wrong: it goes where
/// the forces let it, beside the contacts. Right ones hang together 1.2 times as long, five times where sensors remember what readings of neighbouring samples
/// do not show; one that was certified wrongly 14 times.
const MOST_MEMORY: f64 = 8.0;

/// Inertia explains what balance misses where it leaves less than this share of it.
pub(super) const EXPLAINED_SHARE: f64 = 0.3;

/// An optimum with inertia.
pub(super) struct OfInertia<'a> {
    pub job: &'a Job<'a>,
    pub problem: Problem<'a>,
    pub optimum: Optimum<'a>,
    /// By how much balance alone is missed, metres.
    pub static_balance_m: f64,
    /// Whether the forces were allowed to be others here and there.
    pub robust: bool,
}

impl OfInertia<'_> {
    /// The result, where it explains what balance does not.
    pub fn candidate(&self, refined: &Refined, weights: &Measurements) -> Option<Candidate> {
        let Self { job, problem, optimum, .. } = self;
        let Optimum { unknowns, corrected, noise, .. } = optimum;
        let of_balance = refined.fine.noise;
        let floor_m = FORCES_FLOOR * unknowns.coefficients[0];
        let explained = noise.forces_m < EXPLAINED_SHARE * self.static_balance_m
            && noise.sensor_m < (CONTACTS_ALLOWANCE * of_balance.sensor_m).max(floor_m);
        if !optimum.settled || !explained || !self.is_possible() {
            return None;
        }
        // Where the forces may be others, they do not place a sample whose contacts do not.
        if self.robust && weights.seen() < refined.measurements.seen() {
            return None;
        }
        let psi = problem.motion(unknowns);
        let samples_per_error = samples_per_error_by(&corrected.measurements, &unknowns.coefficients, &psi);
        if is_contradicted_by_memory(noise.sensor_m, floor_m, samples_per_error / job.samples_per_error) {
            return None;
        }
        let estimate = self.estimate(samples_per_error.max(job.samples_per_error));
        if !is_of_an_object(&estimate, rim_m(&unknowns.coefficients)) {
            return None;
        }
        let fit = Fit {
            estimate: Estimate { coefficients: unknowns.coefficients.clone(), psi, cost: 0.0 },
            order: Layout::of_coefficients(&unknowns.coefficients).order,
            noise: Noise { sensor_m: noise.sensor_m, balance_m: noise.forces_m },
            prior: problem.prior,
            evidence: Evidence::of_samples(optimum.log_evidence),
        };
        // Where the contacts contradict the motion it may be another; where nothing was felt, the forces say what it was.
        let instants = weights.instants.iter().zip(&refined.measurements.instants);
        let contradicts =
            |(now, before): (&Instant, &Instant)| before.weight1 > now.weight1 || before.weight2 > now.weight2;
        let ambiguity_rad: Vec<f64> = instants
            .zip(&refined.ambiguity_rad)
            .map(|(instants, ambiguity_rad)| if contradicts(instants) { *ambiguity_rad } else { 0.0 })
            .collect();
        let expected = job.expected();
        let log = unknowns.calibration.corrected(job.raw);
        assemble(
            &log,
            &corrected.measurements,
            fit,
            (&ambiguity_rad, FoundSymmetry::default()),
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

    /// Every variance multiplied by the samples that share an error.
    fn estimate(&self, samples_per_error: f64) -> InertiaEstimate {
        let Unknowns { coefficients, ln_gyration_m2, damping_per_s, .. } = &self.optimum.unknowns;
        let covariance = samples_per_error * self.optimum.eliminated.covariance();
        let index = self.problem.gyration_index();
        let gyration_radius_m = (0.5 * ln_gyration_m2).exp();
        InertiaEstimate {
            gyration_radius_m,
            gyration_radius_sd_m: 0.5 * gyration_radius_m * covariance[(index, index)].sqrt(),
            uniform_gyration_radius_m: SupportFunction::from_coefficients(coefficients).uniform_gyration_radius_m(),
            damping_per_s: *damping_per_s,
            damping_sd_per_s: covariance[(index + 1, index + 1)].sqrt(),
            static_balance_sd_m: self.static_balance_m,
        }
    }
}

/// Whether the contacts miss a motion by more than a floor, metres, and over so many times as many samples in a row as errors of the sensors hang together.
fn is_contradicted_by_memory(missed_m: f64, floor_m: f64, memory: f64) -> bool {
    missed_m > floor_m && memory > MOST_MEMORY
}

/// Whether a mass within a rim at this distance of the centre of mass may have such an inertia.
fn is_of_an_object(estimate: &InertiaEstimate, rim_m: f64) -> bool {
    let InertiaEstimate { gyration_radius_m, gyration_radius_sd_m, uniform_gyration_radius_m, damping_per_s, .. } =
        *estimate;
    gyration_radius_sd_m < TOLD_SHARE * uniform_gyration_radius_m
        && gyration_radius_m - BEYOND_RIM_SDS * gyration_radius_sd_m < rim_m
        && is_believed(gyration_radius_m / uniform_gyration_radius_m, damping_per_s)
}

/// Whether an object may have a radius of gyration of so many times that of an even mass, and be damped so much.
pub(super) fn is_believed(gyration_share: f64, damping_per_s: f64) -> bool {
    off_prior_sds(gyration_share, damping_per_s) < FURTHEST_SDS
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

impl Uncertainty for OfInertia<'_> {
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
        let Unknowns { coefficients, spline, .. } = &self.optimum.unknowns;
        let rows = self.problem.samples.iter().map(|row| (row.of_value(), row.of(spline)[0])).collect();
        let bars = JointErrorBars::new(&self.optimum.eliminated, (coefficients, BESIDES_SHAPE), rows, felt, inflation);
        Some(Box::new(bars?))
    }

    fn of_rig(&self, inflation: f64) -> Option<FoundRig> {
        let covariance = self.optimum.eliminated.covariance();
        FoundRig::jointly(self.optimum.unknowns.calibration, &self.job.options.rig, &covariance, inflation)
    }

    fn inertia(&self, inflation: f64) -> Option<InertiaEstimate> {
        Some(self.estimate(inflation))
    }

    fn friction(&self) -> Option<FrictionEstimate> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_that_are_missed_for_longer_than_sensors_err_contradict_a_motion_but_not_below_the_floor() {
        let floor_m = 3e-6;
        assert!(is_contradicted_by_memory(1e-4, floor_m, 1.01 * MOST_MEMORY));
        assert!(!is_contradicted_by_memory(1e-4, floor_m, 0.99 * MOST_MEMORY));
        // What the steps of an engine leave hangs together over thirty samples.
        assert!(!is_contradicted_by_memory(0.99 * floor_m, floor_m, 30.0));
    }

    #[test]
    fn inertia_is_told_and_that_of_a_mass_within_the_rim_not_of_a_point_and_not_of_honey() {
        let with_sd = |gyration_radius_sd_m: f64, gyration_radius_m: f64, damping_per_s: f64| {
            let estimate = InertiaEstimate {
                gyration_radius_m,
                gyration_radius_sd_m,
                uniform_gyration_radius_m: 0.02,
                damping_per_s,
                damping_sd_per_s: 1.0,
                static_balance_sd_m: 1e-3,
            };
            is_of_an_object(&estimate, 0.03)
        };
        assert!(with_sd(5.9e-4, 0.02, 0.3) && !with_sd(6.1e-4, 0.02, 0.3));
        let is_possible = |gyration_radius_m, damping_per_s| with_sd(5e-4, gyration_radius_m, damping_per_s);
        assert!(is_possible(0.0314, 0.3) && !is_possible(0.0316, 0.3));
        // exp(-5 x 0.4 / 2) = 0.368.
        assert!(is_possible(0.369 * 0.02, 0.3) && !is_possible(0.367 * 0.02, 0.3));
        assert!(is_possible(0.02, 49.9) && !is_possible(0.02, 50.1) && !is_possible(0.02, -50.1));
    }
}
