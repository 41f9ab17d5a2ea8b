//! The likeliest shape, motion, friction and calibration with some contact modes, and the standard deviations of contacts, slip and forces by
//! variance components: squares over their redundancy.

use super::problem::{Corrected, Linearised, Problem, Residuals, Squares, Unknowns};
use crate::estimate::model::layout::Layout;
use crate::estimate::solver::arrow::{Arrow, Eliminated, SplineGivenDense};
use crate::estimate::solver::levenberg_marquardt::{Effort, LeastSquares, minimise};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Standard deviations of a contact position, of the slip of a contact that sticks over one step, and of the moment of the forces, metres; and of a
/// measured force, newtons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrictionNoise {
    pub sensor_m: f64,
    pub slip_m: f64,
    pub forces_m: f64,
    pub pads_n: f64,
}

impl FrictionNoise {
    /// Half the squares over their variances.
    fn cost(&self, squares: &Squares) -> f64 {
        let Self { sensor_m, slip_m, forces_m, pads_n } = self;
        let over = |squares: f64, sd: &f64| 0.5 * squares / (sd * sd);
        over(squares.contacts, sensor_m)
            + over(squares.rolls, slip_m)
            + over(squares.forces, forces_m)
            + over(squares.pads, pads_n)
    }
}

/// Standard deviations that may be estimated, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    /// Least and largest of the contacts; the same where it is known.
    pub sensor_m: [f64; 2],
    /// Least of the slip and of the forces.
    pub slip_m: f64,
    pub forces_m: f64,
    /// Least of a measured force, as a share of the weight.
    pub pads: f64,
}

/// An optimum.
pub(crate) struct Optimum {
    pub unknowns: Unknowns,
    pub corrected: Arc<Corrected>,
    pub noise: FrictionNoise,
    /// Whether the standard deviations have settled.
    pub settled: bool,
    /// Forces that are measured, and compared.
    pub measured: usize,
    /// Half the squares of all residuals, and what the prior adds.
    pub cost: f64,
    squares: Squares,
    /// Samples whose forces miss something, and the root mean square of what they miss, in standard deviations.
    pub missed: usize,
    pub misfit: f64,
    /// The normal equations there: what error bars need.
    pub eliminated: Eliminated,
    /// By how much slip and forces say less than their equations: pads creep the same way for many samples.
    pub inflation: f64,
}

/// Change of a logarithm at which the standard deviations have settled.
const SETTLED: f64 = 0.05;

/// Largest factors by which one round changes a standard deviation.
const LARGEST_FALL: f64 = 0.2;
const LARGEST_RISE: f64 = 5.0;

/// Of a round, whose standard deviations are not the last, and of the end. The modes that contacts have at the start make the cost smooth near by only.
const OF_A_ROUND: Effort = Effort { steps: 8, tolerance: 1e-3, follows_valleys: false };
const AT_THE_END: Effort = Effort { steps: 40, tolerance: 1e-6, follows_valleys: false };

/// Information that holds an angle where it is, rad⁻².
const HELD: f64 = 1e12;

/// Redundancy of residuals of one kind that is assumed at least.
const LEAST_REDUNDANCY: f64 = 3.0;

impl Optimum {
    /// Standard deviation of an unknown that all samples share.
    pub fn sd(&self, covariance: &DMatrix<f64>, unknown: usize) -> f64 {
        (self.inflation * covariance[(unknown, unknown)].max(0.0)).sqrt()
    }

    /// The same of a linear function of them.
    pub fn sd_along(&self, covariance: &DMatrix<f64>, row: &DVector<f64>) -> f64 {
        (self.inflation * row.dot(&(covariance * row)).max(0.0)).sqrt()
    }

    /// Root mean square of what the forces of all samples miss, metres: nothing where they are within the cones.
    pub fn forces_missed_m(&self) -> f64 {
        self.noise.forces_m * self.misfit * (self.missed as f64 / self.unknowns.psi.len().max(1) as f64).sqrt()
    }

    /// Its cost at other standard deviations.
    pub fn cost_at(&self, noise: FrictionNoise) -> f64 {
        self.prior_cost() + noise.cost(&self.squares)
    }

    /// What of its cost is that of the prior.
    pub fn prior_cost(&self) -> f64 {
        self.cost - self.noise.cost(&self.squares)
    }

    /// Covariance of shape and friction in a frame that does not turn.
    pub fn covariance_of_object(&self) -> Option<DMatrix<f64>> {
        let coefficients = &self.unknowns.coefficients;
        let of_object = coefficients.len() + 2;
        let mut turn = DVector::zeros(self.eliminated.information().nrows());
        turn.rows_mut(0, coefficients.len()).copy_from(&Layout::of_coefficients(coefficients).rotation(coefficients));
        let mut information = self.eliminated.information().clone();
        let square = turn.norm_squared();
        if square > 0.0 {
            information.ger(HELD / (square * square), &turn, &turn, 1.0);
        }
        Some(information.cholesky()?.inverse().view((0, 0), (of_object, of_object)).into_owned())
    }
}

struct Point {
    unknowns: Unknowns,
    corrected: Arc<Corrected>,
    residuals: Residuals,
}

struct AtNoise<'a> {
    problem: &'a Problem<'a>,
    noise: FrictionNoise,
}

impl AtNoise<'_> {
    fn point(&self, unknowns: Unknowns, corrected: Arc<Corrected>) -> Point {
        let residuals = self.problem.residuals(&unknowns, &corrected, None);
        Point { unknowns, corrected, residuals }
    }

    fn linearised(&self, at: &Point) -> Linearised {
        self.problem.linearise(&at.unknowns, &at.corrected, &at.residuals)
    }

    fn summed(&self, at: &Unknowns, linearised: &Linearised) -> Arrow {
        let FrictionNoise { sensor_m, slip_m, forces_m, pads_n } = self.noise;
        let mut arrow = linearised.contacts.clone();
        arrow.scale(1.0 / (sensor_m * sensor_m));
        arrow.add(1.0 / (slip_m * slip_m), &linearised.rolls);
        arrow.add(1.0 / (forces_m * forces_m), &linearised.forces);
        arrow.add(1.0 / (pads_n * pads_n), &linearised.pads);
        self.problem.add_prior(at, &mut arrow);
        arrow
    }
}

impl LeastSquares for AtNoise<'_> {
    type Point = Point;

    fn cost(&self, at: &Point) -> f64 {
        self.noise.cost(&at.residuals.squares()) + self.problem.prior_cost(&at.unknowns)
    }

    fn arrow(&self, at: &Point) -> Arrow {
        self.summed(&at.unknowns, &self.linearised(at))
    }

    fn stepped(&self, from: &Point, dense: &DVector<f64>, band: &[f64]) -> Point {
        let unknowns = self.problem.stepped(&from.unknowns, dense, band);
        let moved = unknowns.calibration != from.unknowns.calibration;
        let corrected =
            if moved { Arc::new(self.problem.corrected(&unknowns.calibration)) } else { Arc::clone(&from.corrected) };
        self.point(unknowns, corrected)
    }
}

impl Problem<'_> {
    /// The optimum with the standard deviations that the residuals have.
    pub fn optimum(
        &mut self,
        start: Unknowns,
        start_noise: FrictionNoise,
        bounds: Bounds,
        (rounds, freedom): (usize, f64),
    ) -> Option<Optimum> {
        let corrected = Arc::new(self.corrected(&start.calibration));
        let (mut noise, mut settled) = (start_noise, false);
        let (mut unknowns, mut corrected) = (start, corrected);
        for _ in 0..rounds {
            self.reweigh(&unknowns, &corrected, [noise.slip_m, noise.forces_m, noise.pads_n], freedom);
            let cost = AtNoise { problem: self, noise };
            let (at, _) = minimise(&cost, cost.point(unknowns, corrected), OF_A_ROUND)?;
            let updated = cost.updated(&at, bounds)?;
            let change = |to: f64, from: f64| (to / from).ln().abs();
            let moved = change(updated.sensor_m, noise.sensor_m)
                .max(change(updated.slip_m, noise.slip_m))
                .max(change(updated.forces_m, noise.forces_m))
                .max(change(updated.pads_n, noise.pads_n));
            (unknowns, corrected, noise) = (at.unknowns, at.corrected, updated);
            if moved < SETTLED {
                settled = true;
                break;
            }
        }
        let of_cost = AtNoise { problem: self, noise };
        let (at, cost) = minimise(&of_cost, of_cost.point(unknowns, corrected), AT_THE_END)?;
        let sliding = self.sliding(&at.residuals);
        let linearised = self.linearise(&at.unknowns, &at.corrected, &sliding);
        let eliminated = of_cost.summed(&at.unknowns, &linearised).eliminated(0.0)?;
        let squares = at.residuals.squares();
        let missed = at.residuals.missed();
        let misfit = (squares.forces / missed.max(1) as f64).sqrt() / noise.forces_m;
        let inflation = at.residuals.inflation(noise.slip_m, noise.forces_m, noise.pads_n);
        let measured = at.residuals.measured();
        let Point { unknowns, corrected, .. } = at;
        Some(Optimum {
            unknowns,
            corrected,
            noise,
            settled,
            measured,
            cost,
            squares,
            missed,
            misfit,
            eliminated,
            inflation,
        })
    }
}

impl AtNoise<'_> {
    /// The standard deviations that the residuals have.
    fn updated(&self, at: &Point, bounds: Bounds) -> Option<FrictionNoise> {
        let linearised = self.linearised(at);
        let eliminated = self.summed(&at.unknowns, &linearised).eliminated(0.0)?;
        let (covariance, given) = (eliminated.covariance(), eliminated.given_dense());
        let squares = at.residuals.squares();
        let estimate = |squares: f64, count: usize, arrow: &Arrow, sd_m: f64, least_m: f64| {
            let used = used(arrow, &covariance, &given) / (sd_m * sd_m);
            let found = (squares / (count as f64 - used).max(LEAST_REDUNDANCY)).sqrt();
            found.clamp(LARGEST_FALL * sd_m, LARGEST_RISE * sd_m).max(least_m)
        };
        let [least_m, most_m] = bounds.sensor_m;
        let readings = at.corrected.measurements.seen();
        let FrictionNoise { sensor_m, slip_m, forces_m, pads_n } = self.noise;
        let least_n = bounds.pads * at.unknowns.weight_n;
        let pads_n = match at.residuals.measured() {
            0 => pads_n,
            measured => estimate(squares.pads, measured, &linearised.pads, pads_n, least_n),
        };
        Some(FrictionNoise {
            sensor_m: estimate(squares.contacts, readings, &linearised.contacts, sensor_m, least_m).min(most_m),
            slip_m: estimate(squares.rolls, self.problem.steps_that_roll(), &linearised.rolls, slip_m, bounds.slip_m),
            forces_m: estimate(squares.forces, at.residuals.missed(), &linearised.forces, forces_m, bounds.forces_m),
            pads_n,
        })
    }
}

/// The share of the unknowns that some residuals determine.
fn used(arrow: &Arrow, covariance: &DMatrix<f64>, given: &SplineGivenDense) -> f64 {
    given.determined_by(arrow, covariance)
}
