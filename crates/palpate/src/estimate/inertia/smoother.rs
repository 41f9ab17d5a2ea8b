//! The likeliest shape, motion and inertia by Levenberg and Marquardt, and the standard deviations of contacts and forces by variance components:
//! squares over their redundancy.
//!
//! While the forces are loose the motion follows the noise of the contacts, and a small radius of gyration makes little of it: so that the inertia
//! is held until the forces have come down, and freed then.

use super::problem::{BESIDES_SHAPE, Corrected, InertiaPrior, Linearised, Problem, Squares, Unknowns};
use crate::estimate::solver::arrow::{Arrow, Eliminated};
use crate::estimate::solver::levenberg_marquardt::{Effort, LeastSquares, minimise};
use crate::math::spline::SplineRow;
use crate::math::statistics::correlation_time;
use nalgebra::DVector;
use std::sync::Arc;

/// Standard deviations of a contact position and of the moment of the forces, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct InertialNoise {
    pub sensor_m: f64,
    pub forces_m: f64,
}

/// Standard deviations that may be estimated, metres. A motion that cannot follow the contacts would have them noisier than they are, and the
/// forces exact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// Least and largest of the contacts; the same where it is known.
    pub sensor_m: [f64; 2],
    /// Least of the forces.
    pub forces_m: f64,
}

/// An optimum.
pub(crate) struct Optimum<'a> {
    pub unknowns: Unknowns,
    pub corrected: Arc<Corrected<'a>>,
    pub noise: InertialNoise,
    /// Whether the standard deviations have settled.
    pub settled: bool,
    /// ln of the evidence, up to what all optima of a log have in common.
    pub log_evidence: f64,
    /// The normal equations there, of forces that share their errors: what error bars need.
    pub eliminated: Eliminated,
}

/// Rounds of the variance components, and the change of a logarithm at which they have settled.
const ROUNDS: usize = 12;
const SETTLED: f64 = 0.05;

/// Largest factors by which one round changes a standard deviation.
const LARGEST_FALL: f64 = 0.2;
const LARGEST_RISE: f64 = 5.0;

/// Of a round, whose standard deviations are not the last, and of the end.
const OF_A_ROUND: Effort = Effort { steps: 8, tolerance: 1e-3, follows_valleys: true };
const AT_THE_END: Effort = Effort { steps: 40, tolerance: 1e-6, follows_valleys: true };

/// Redundancy of residuals of one kind that is assumed at least.
const LEAST_REDUNDANCY: f64 = 3.0;

/// Where a search for the optimum is, with the readings as the calibration there means them.
pub(crate) struct Point<'a> {
    pub unknowns: Unknowns,
    pub corrected: Arc<Corrected<'a>>,
    pub squares: Squares,
}

/// A problem at some standard deviations.
struct AtNoise<'p, 'a> {
    problem: &'p Problem<'a>,
    noise: InertialNoise,
    inertia: InertiaPrior,
}

impl<'a> AtNoise<'_, 'a> {
    fn point(&self, unknowns: Unknowns, corrected: Arc<Corrected<'a>>) -> Point<'a> {
        let squares = self.problem.squares(&unknowns, &corrected);
        Point { unknowns, corrected, squares }
    }

    fn summed(&self, at: &Unknowns, linearised: &Linearised) -> Arrow {
        let mut arrow = linearised.contacts.clone();
        arrow.scale(1.0 / self.noise.sensor_m.powi(2));
        arrow.add(1.0 / self.noise.forces_m.powi(2), &linearised.forces);
        self.problem.add_prior(at, self.inertia, &mut arrow);
        arrow
    }
}

impl<'a> LeastSquares for AtNoise<'_, 'a> {
    type Point = Point<'a>;

    fn cost(&self, at: &Point) -> f64 {
        let InertialNoise { sensor_m, forces_m } = self.noise;
        0.5 * (at.squares.contacts / sensor_m.powi(2) + at.squares.forces / forces_m.powi(2))
            + self.problem.prior_cost(&at.unknowns, self.inertia)
    }

    fn arrow(&self, at: &Point) -> Arrow {
        self.summed(&at.unknowns, &self.problem.linearise(&at.unknowns, &at.corrected))
    }

    fn stepped(&self, from: &Point<'a>, dense: &DVector<f64>, band: &[f64]) -> Point<'a> {
        let unknowns = self.problem.stepped(&from.unknowns, dense, band);
        let moved = unknowns.calibration != from.unknowns.calibration;
        let corrected =
            if moved { Arc::new(self.problem.corrected(&unknowns.calibration)) } else { Arc::clone(&from.corrected) };
        self.point(unknowns, corrected)
    }

    fn is_spent(&self) -> bool {
        self.problem.work.is_spent()
    }
}

impl<'a> Problem<'a> {
    /// The optimum from some start with these standard deviations, and its cost. `None` where it is worth no more steps.
    pub fn minimise(
        &self,
        start: Unknowns,
        noise: InertialNoise,
        inertia: InertiaPrior,
        effort: Effort,
    ) -> Option<(Point<'a>, f64)> {
        let cost = AtNoise { problem: self, noise, inertia };
        let corrected = Arc::new(self.corrected(&start.calibration));
        minimise(&cost, cost.point(start, corrected), effort)
    }

    /// The optimum with the standard deviations that the residuals have.
    pub fn optimum(
        &mut self,
        start: Unknowns,
        start_noise: InertialNoise,
        inertia: InertiaPrior,
        bounds: Bounds,
        freedom: Option<f64>,
    ) -> Option<Optimum<'a>> {
        let (mut at, mut noise, mut settled) = (start, start_noise, false);
        for _ in 0..ROUNDS {
            if let Some(freedom) = freedom {
                let moments = self.moments(&at, &self.corrected(&at.calibration));
                self.reweigh(&moments, noise.forces_m, freedom);
            }
            let (Point { unknowns, corrected, squares }, _) = self.minimise(at, noise, inertia, OF_A_ROUND)?;
            at = unknowns;
            let linearised = self.linearise(&at, &corrected);
            let eliminated = AtNoise { problem: self, noise, inertia }.summed(&at, &linearised).eliminated(0.0)?;
            let updated = self.updated(noise, &squares, &linearised, &eliminated, &corrected, bounds);
            let change =
                (updated.sensor_m / noise.sensor_m).ln().abs().max((updated.forces_m / noise.forces_m).ln().abs());
            noise = updated;
            if change < SETTLED {
                settled = true;
                break;
            }
        }
        let (Point { unknowns, corrected, .. }, cost) = self.minimise(at, noise, inertia, AT_THE_END)?;
        let linearised = self.linearise(&unknowns, &corrected);
        let with = |noise: InertialNoise| {
            AtNoise { problem: self, noise, inertia }.summed(&unknowns, &linearised).eliminated(0.0)
        };
        let log_evidence = -cost
            - self.readings(&corrected) * noise.sensor_m.ln()
            - self.collocations() as f64 * noise.forces_m.ln()
            - 0.5 * with(noise)?.ln_determinant()
            - self.ln_prior_sds();
        let places_per_error = self.places_per_error(&unknowns, &corrected);
        let eliminated = with(InertialNoise { forces_m: places_per_error.sqrt() * noise.forces_m, ..noise })?;
        Some(Optimum { unknowns, corrected, noise, settled, log_evidence, eliminated })
    }

    /// Places that share an error of the forces: what the spline does not follow lasts as long as one of its pieces.
    fn places_per_error(&self, at: &Unknowns, corrected: &Corrected) -> f64 {
        correlation_time(&self.weighted_moments_m(at, corrected))
    }

    fn readings(&self, corrected: &Corrected) -> f64 {
        let weights = corrected.measurements.instants.iter().flat_map(|instant| [instant.weight1, instant.weight2]);
        weights.filter(|weight| *weight > 0.0).count() as f64
    }

    fn updated(
        &self,
        noise: InertialNoise,
        squares: &Squares,
        linearised: &Linearised,
        eliminated: &Eliminated,
        corrected: &Corrected,
        bounds: Bounds,
    ) -> InertialNoise {
        let (covariance, given) = (eliminated.covariance(), eliminated.given_dense());
        let estimate = |squares: f64, count: f64, arrow: &Arrow, sd_m: f64, floor_m: f64| {
            let used = given.determined_by(arrow, &covariance) / (sd_m * sd_m);
            let found = (squares / (count - used).max(LEAST_REDUNDANCY)).sqrt();
            found.clamp(LARGEST_FALL * sd_m, LARGEST_RISE * sd_m).max(floor_m)
        };
        let readings = self.readings(corrected);
        let [least_m, most_m] = bounds.sensor_m;
        let sensor_m = estimate(squares.contacts, readings, &linearised.contacts, noise.sensor_m, least_m).min(most_m);
        let places = self.collocations() as f64;
        let forces_m = estimate(squares.forces, places, &linearised.forces, noise.forces_m, bounds.forces_m);
        InertialNoise { sensor_m, forces_m }
    }

    /// Variance of the orientation of every sample at an optimum, rad².
    pub fn variance_of_motion(&self, optimum: &Optimum) -> Vec<f64> {
        let (covariance, given) = (optimum.eliminated.covariance(), optimum.eliminated.given_dense());
        let of_sample = |row: &SplineRow| {
            let slope = given.slope(row.of_value());
            given.variance(row.of_value()) + (&covariance * &slope).dot(&slope)
        };
        self.samples.iter().map(of_sample).collect()
    }

    /// How far an optimum is from other unknowns that all samples share: the mean square in standard deviations.
    pub fn moved(&self, optimum: &Optimum, from: &Unknowns) -> f64 {
        let (to, shape) = (&optimum.unknowns, from.coefficients.len());
        let mut step = DVector::zeros(self.dense());
        for (index, (to, from)) in to.coefficients.iter().zip(&from.coefficients).enumerate() {
            step[index] = to - from;
        }
        step[shape] = to.ln_gyration_m2 - from.ln_gyration_m2;
        step[shape + 1] = to.damping_per_s - from.damping_per_s;
        (optimum.eliminated.information() * &step).dot(&step) / step.len() as f64
    }

    /// Where the radius of gyration stands among the dense unknowns.
    pub fn gyration_index(&self) -> usize {
        self.dense() - BESIDES_SHAPE
    }
}
