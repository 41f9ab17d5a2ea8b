//! Levenberg and Marquardt's method for normal equations shaped like an arrow.

use super::arrow::Arrow;
use nalgebra::DVector;

/// A cost that is half a sum of squares, nearly.
pub(crate) trait LeastSquares {
    /// Unknowns, with what depends on them.
    type Point;

    fn cost(&self, at: &Self::Point) -> f64;

    /// The normal equations there.
    fn arrow(&self, at: &Self::Point) -> Arrow;

    /// The point after a step of the dense unknowns and of those in the band.
    fn stepped(&self, from: &Self::Point, dense: &DVector<f64>, band: &[f64]) -> Self::Point;
}

/// Damping of the first step, factors by which it changes, its largest and its least value.
const DAMPING: f64 = 1e-3;
const LESS_DAMPING: f64 = 0.125;
const MORE_DAMPING: f64 = 6.0;
const MOST_DAMPING: f64 = 1e8;
const LEAST_DAMPING: f64 = 1e-10;

/// The optimum from some start, and its cost, after at most so many steps; ends where one lowers the cost by no more than its share `tolerance`.
pub(crate) fn minimise<P: LeastSquares>(
    problem: &P,
    start: P::Point,
    steps: usize,
    tolerance: f64,
) -> Option<(P::Point, f64)> {
    let mut cost = problem.cost(&start);
    let (mut at, mut damping) = (start, DAMPING);
    for _ in 0..steps {
        let arrow = problem.arrow(&at);
        let mut fall = 0.0;
        while damping <= MOST_DAMPING {
            let step = arrow.eliminated(damping).map(|eliminated| eliminated.step(&arrow));
            let better = step.and_then(|(dense, band)| {
                let there = problem.stepped(&at, &dense, &band);
                let cost_there = problem.cost(&there);
                (cost_there < cost).then_some((there, cost_there))
            });
            if let Some((there, cost_there)) = better {
                fall = cost - cost_there;
                (at, cost) = (there, cost_there);
                damping = (damping * LESS_DAMPING).max(LEAST_DAMPING);
                break;
            }
            damping *= MORE_DAMPING;
        }
        if fall <= tolerance * cost.abs() {
            break;
        }
    }
    cost.is_finite().then_some((at, cost))
}
