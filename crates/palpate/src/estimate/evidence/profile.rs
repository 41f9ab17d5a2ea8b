//! The profile of the posterior along the direction of the shape that leaves most of the motion open: optima with the shape held at places along it,
//! each with its probability (D. M. Bates and D. G. Watts, *Nonlinear Regression Analysis and Its Applications*, 1988, chapter 6; the
//! probabilities: L. Tierney and J. B. Kadane, *Accurate approximations for posterior moments and marginal densities*, Journal of the American
//! Statistical Association 81, 1986). Where little was felt the posterior is a long valley, and its curvature at the optimum says less than its length.

use crate::estimate::evidence::fit::evidence_at;
use crate::estimate::measurements::Measurements;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, PROJECTIONS, Smoother, StoppingCriteria};
use crate::estimate::solver::posterior::Posterior;
use nalgebra::{DMatrix, DVector};

/// Effort of the smoother at each place: it begins where that at the one before ended.
const STOPPING: StoppingCriteria = StoppingCriteria { iterations: 40, tolerance: 1e-7 };

/// Places on each side of the answer, in the standard deviations that the curvature promises. What is wider than the last one is known to no
/// degree that a certificate could stand on.
const PLACES_SD: [f64; 10] = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 32.0];

/// The profile ends where the probability has fallen so far, in nats: farther away the whole tail adds less than a hundredth of a variance.
const ENDS_BELOW: f64 = 8.0;

/// Information with which a shape is held at its place, per squared standard deviation: to a hundredth of one.
const HELD: f64 = 1e4;

/// The same with which it is kept from turning, which costs nothing and would bring it anywhere along a row: to a thousandth of a radian.
const HELD_TURN: f64 = 1e6;

/// What is possible along the direction that a log determines least.
pub(crate) struct Profile {
    /// Optima with the shape held at each place, the first at the answer, and ln of the evidence of each place and its surroundings.
    pub places: Vec<(f64, Fit)>,
    /// The answer moved by one standard deviation to first order: what its own error bars know of this direction.
    pub linear: Estimate,
}

/// An optimum and the direction along which its profile goes.
pub(crate) struct Center<'a> {
    measurements: &'a Measurements,
    answer: Fit,
    free: Smoother<'a>,
    direction: Direction,
    held: Fit,
}

impl<'a> Center<'a> {
    /// `None` where it cannot be determined.
    pub fn new(measurements: &'a Measurements, answer: Fit) -> Option<Self> {
        let free = Smoother::new(measurements, answer.order, answer.noise, answer.prior).strictly_convex();
        let direction = Direction::weakest(&free, &answer.estimate)?;
        let mut center = Self { measurements, held: answer.clone(), answer, free, direction };
        center.held = center.held_at(0.0, center.answer.estimate.clone())?;
        Some(center)
    }

    /// ln of the evidence of the answer alone, up to what all models have in common.
    pub fn log_evidence(&self) -> f64 {
        self.held.evidence.log()
    }

    fn held_at(&self, place: f64, start: Estimate) -> Option<Fit> {
        let Fit { order, noise, prior, .. } = self.answer;
        let belief = self.direction.holding(&self.free, &self.answer.estimate.coefficients, place)?;
        let smoother = Smoother::with_belief(self.measurements, order, noise, prior, &belief).strictly_convex();
        let Estimate { coefficients, mut psi, .. } = smoother.run(start.coefficients, start.psi, STOPPING);
        let cost = self.free.project_orientations(&coefficients, &mut psi, PROJECTIONS);
        let estimate = Estimate { coefficients, psi, cost };
        let (evidence, _) = evidence_at(&smoother, &estimate)?;
        evidence.log().is_finite().then(|| Fit { estimate, evidence, ..self.answer.clone() })
    }

    /// The profile, as far as ln of its evidence is above `least_log`.
    pub fn profile(&self, least_log: f64) -> Profile {
        let ends_log = least_log.max(self.log_evidence() - ENDS_BELOW);
        let mut places = vec![(self.log_evidence() + width(0).ln(), self.held.clone())];
        for side in [-1.0, 1.0] {
            let (mut at, mut here) = (self.held.estimate.clone(), 0.0);
            for (index, place) in PLACES_SD.into_iter().enumerate() {
                let start = self.free.moved(&at, &(&self.direction.step * (side * (place - here))));
                let Some(fit) = self.held_at(side * place, start) else { break };
                let log_evidence = fit.evidence.log();
                (at, here) = (fit.estimate.clone(), place);
                places.push((log_evidence + width(index + 1).ln(), fit));
                if log_evidence < ends_log {
                    break;
                }
            }
        }
        Profile { places, linear: self.free.moved(&self.answer.estimate, &self.direction.step) }
    }
}

/// Width that a place stands for, in standard deviations; that of the answer is the first.
fn width(index: usize) -> f64 {
    let at = |index: usize| if index == 0 { 0.0 } else { PLACES_SD[index - 1] };
    let last = PLACES_SD.len();
    let (before, after) = match index {
        0 => (-PLACES_SD[0], PLACES_SD[0]),
        index => (at(index - 1), at((index + 1).min(last))),
    };
    0.5 * (after - before)
}

/// The direction of the shape that turns the samples most against each other, within what the curvature leaves open.
struct Direction {
    /// A step of one standard deviation.
    step: DVector<f64>,
    /// How far a shape is along it, in standard deviations: a row.
    row: DVector<f64>,
}

impl Direction {
    /// `None` where the information does not determine every unknown.
    fn weakest(smoother: &Smoother, answer: &Estimate) -> Option<Self> {
        let normal = smoother.linearise(&answer.coefficients, &answer.psi);
        let slopes: Vec<DVector<f64>> = (0..answer.psi.len()).map(|sample| normal.psi_slope(sample)).collect();
        let mean = slopes.iter().sum::<DVector<f64>>() / slopes.len() as f64;
        let mut spread = DMatrix::zeros(mean.len(), mean.len());
        for slope in slopes {
            let apart = slope - &mean;
            spread.ger(1.0, &apart, &apart, 1.0);
        }
        let root = smoother.posterior(answer)?.information.cholesky()?.unpack();
        // In units in which the shape has the standard deviation one in every direction.
        let half = root.solve_lower_triangular(&spread)?;
        let whitened = root.solve_lower_triangular(&half.transpose())?;
        let eigen = whitened.iter().all(|value| value.is_finite()).then(|| whitened.symmetric_eigen())?;
        let (largest, _) = eigen.eigenvalues.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        let along = eigen.eigenvectors.column(largest).into_owned();
        Some(Self { step: root.tr_solve_lower_triangular(&along)?, row: root * along })
    }

    /// The prior of shapes that are so far along it from given coefficients, and not turned against them.
    fn holding(&self, smoother: &Smoother, coefficients: &[f64], place_sd: f64) -> Option<Posterior> {
        let layout = smoother.layout();
        let rotation = layout.rotation(coefficients);
        let turned = &rotation / rotation.norm_squared();
        let coefficients = DVector::from_row_slice(coefficients);
        let mut information = DMatrix::from_diagonal(&DVector::from_row_slice(&smoother.precision));
        let mut pull = DVector::zeros(coefficients.len());
        for (row, held, place) in [(&self.row, HELD, place_sd), (&turned, HELD_TURN, 0.0)] {
            information.ger(held, row, row, 1.0);
            pull.axpy(held * (row.dot(&coefficients) + place), row, 1.0);
        }
        let mean = information.clone().cholesky()?.solve(&pull);
        Some(Posterior { layout, mean, information })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::evidence::tests::{optimum, turned};

    /// Variance of the motion along the profile, over what the curvature says.
    fn wider_by(measurements: &Measurements, fit: &Fit) -> f64 {
        let center = Center::new(measurements, fit.clone()).expect("determined");
        let Profile { places, linear } = center.profile(f64::NEG_INFINITY);
        let most = places.iter().map(|(log, _)| *log).fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = places.iter().map(|(log, _)| (log - most).exp()).collect();
        let squares = places.iter().map(|(_, place)| turned(&fit.estimate, &place.estimate));
        let mean =
            squares.zip(&weights).map(|(square, weight)| square * weight).sum::<f64>() / weights.iter().sum::<f64>();
        mean / turned(&fit.estimate, &linear)
    }

    #[test]
    fn the_profile_of_a_long_log_is_what_the_curvature_says() {
        let (measurements, fit) = optimum(5, 600, 10);
        let wider = wider_by(&measurements, &fit);
        assert!((0.8..1.25).contains(&wider), "{wider}");
    }

    #[test]
    fn that_of_a_second_is_a_long_valley() {
        let (measurements, fit) = optimum(5_973_073, 100, 1);
        let wider = wider_by(&measurements, &fit);
        assert!(wider > 4.0, "{wider}");
    }

    #[test]
    fn the_profile_ends_where_it_falls_below_what_counts() {
        let (measurements, fit) = optimum(5, 600, 10);
        let center = Center::new(&measurements, fit).expect("determined");
        let places = |below: f64| center.profile(center.log_evidence() - below).places.len();
        // The first place on each side is looked at in any case; so far the evidence falls by half the square of the place.
        assert_eq!([0.1, 1.0, 3.0, ENDS_BELOW, f64::INFINITY].map(places), [3, 5, 7, 10, 10]);
    }

    #[test]
    fn a_place_is_held_and_not_turned() {
        let (measurements, fit) = optimum(5, 600, 10);
        let smoother = Smoother::new(&measurements, fit.order, fit.noise, fit.prior);
        let direction = Direction::weakest(&smoother, &fit.estimate).expect("determined");
        // A standard deviation along its own row, which a rotation does not change.
        let rotation = smoother.layout().rotation(&fit.estimate.coefficients);
        assert!((direction.row.dot(&direction.step) - 1.0).abs() < 1e-9);
        assert!(direction.row.dot(&rotation).abs() < 1e-3 * direction.row.norm() * rotation.norm());
        let held = direction.holding(&smoother, &fit.estimate.coefficients, 2.0).expect("determined");
        let along = |coefficients: &DVector<f64>| direction.row.dot(coefficients);
        let here = DVector::from_row_slice(&fit.estimate.coefficients);
        assert!((along(&held.mean) - along(&here) - 2.0).abs() < 0.1, "{}", along(&held.mean) - along(&here));
        // The gradient of the prior alone and of the two springs, by differences.
        let at = &here + &direction.step * 0.3;
        let squared = |at: &DVector<f64>| held.squared_distance(at.as_slice());
        let step = direction.step.clone() * 1e-3;
        let slope = (squared(&(&at + &step)) - squared(&(&at - &step))) / 2.0;
        assert!((slope - 2.0 * held.gradient(at.as_slice()).dot(&step)).abs() < 1e-6 * slope.abs());
    }

    #[test]
    fn widths_fill_the_line() {
        let last = PLACES_SD.len();
        let both: f64 = width(0) + 2.0 * (1..=last).map(width).sum::<f64>();
        assert!((both - 2.0 * PLACES_SD[last - 1]).abs() < 1e-12, "{both}");
    }
}
