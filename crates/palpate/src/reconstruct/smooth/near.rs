//! The smoother from a start that is near the optimum, where shape and motion are both believed: the orientations are not brought to
//! the minima of their samples before the first step, for at a shape that is a little wrong some of these minima are wrong ones.
//!
//! Near the optimum the normal matrix hardly changes any more. It is kept then, and only gradients are made anew (Shamanskii's
//! variant of Newton's method, *Ukrainian Mathematical Journal* 19, 1967): such a step costs O(M) for each sample, not O(M²).

use nalgebra::DVector;

use super::{
    Effort, Estimate, Linearised, PSI_INFORMATION, Smoother, Taken, coefficients_to_order, dot, moved, settle_one,
};

/// The matrix is made anew as long as steps lower the cost by more than this share of it.
const FAR: f64 = 0.5;

/// A kept matrix serves as long as each step gains less than this share of what the one before gained.
const SHRINKING: f64 = 0.1;

/// The normal equations without their matrix, at one estimate.
pub(super) struct Slope {
    pub cost: f64,
    pub gradient: DVector<f64>,
    /// As in [`super::Normal`].
    pub psi_offset: Vec<f64>,
}

impl Smoother<'_> {
    /// Runs down to the minimum from a start that is near it.
    pub fn run_near(&self, mut coefficients: Vec<f64>, mut psi: Vec<f64>, effort: Effort) -> Estimate {
        coefficients_to_order(&mut coefficients, self.order);
        let cost = self.settle(&coefficients, &mut psi, 0);
        let mut estimate = Estimate { coefficients, psi, cost };
        let mut damping = 1e-4;
        for _ in 0..effort.iterations {
            let before = estimate.cost;
            let Some(taken) = self.step(&mut estimate, &mut damping) else { break };
            let fall = before - estimate.cost;
            if fall <= effort.tolerance * estimate.cost {
                break;
            }
            if fall < FAR * estimate.cost && self.coast(&mut estimate, &taken, fall, effort.tolerance) {
                break;
            }
        }
        estimate
    }

    /// Takes further steps with the matrix of one that lowered the cost by `fall`; whether the minimum is reached.
    fn coast(&self, estimate: &mut Estimate, taken: &Taken, mut fall: f64, tolerance: f64) -> bool {
        let mut slope = self.settle_with_gradient(&estimate.coefficients, &mut estimate.psi, 0);
        loop {
            let step = -taken.factor.solve(&slope.gradient);
            let coefficients = moved(&estimate.coefficients, &step);
            let mut psi = taken.normal.turned(&estimate.psi, &slope.psi_offset, &step);
            let there = self.settle_with_gradient(&coefficients, &mut psi, 2);
            let cost = there.cost;
            let next = estimate.cost - cost;
            // No orientation is settled to its last digit: a gain that small may come out as a loss.
            let worth = tolerance * cost;
            if next.is_nan() || next <= -worth {
                return false;
            }
            if next > 0.0 {
                *estimate = Estimate { coefficients, psi, cost };
            }
            if next <= worth {
                return true;
            }
            if next > SHRINKING * fall {
                return false;
            }
            (slope, fall) = (there, next);
        }
    }

    /// Brings each ψ to the minimum of its own sample, and returns what [`Smoother::linearise`] would find there, but for the
    /// matrix.
    pub(super) fn settle_with_gradient(&self, coefficients: &[f64], psi: &mut [f64], rounds: usize) -> Slope {
        let mut cost = self.shape_cost(coefficients);
        let mut gradient = self.shape_gradient(coefficients);
        let mut linearised = Linearised::new(self.order);
        let mut psi_offset = Vec::with_capacity(psi.len());
        let mut row = vec![0.0; coefficients.len()];
        for (instant, psi) in self.problem.instants.iter().zip(psi.iter_mut()) {
            let w = self.noise.weights(instant);
            let settled = settle_one(w, psi, rounds, |psi| linearised.at(instant, coefficients, psi));
            if settled.taken_back {
                linearised.at(instant, coefficients, *psi);
            }
            cost += settled.square;
            let at = settled.at;
            let e = [w[0] * at.value[0], w[1] * at.value[1], w[2] * at.value[2]];
            let p = [w[0] * at.by_psi[0], w[1] * at.by_psi[1], w[2] * at.by_psi[2]];
            // What ψ takes up is no gradient of the shape.
            let taken = dot(p, e) / (dot(p, p) + PSI_INFORMATION);
            psi_offset.push(-taken);
            let share = std::array::from_fn(|i| w[i] * (e[i] - taken * p[i]));
            linearised.mixed_row(instant, share, &mut row);
            gradient.iter_mut().zip(&row).for_each(|(sum, value)| *sum += value);
        }
        Slope { cost, gradient, psi_offset }
    }

    /// Half the gradient of the prior and of convexity.
    fn shape_gradient(&self, coefficients: &[f64]) -> DVector<f64> {
        let mut gradient = match self.belief {
            Some(belief) => &belief.information * (DVector::from_row_slice(coefficients) - &belief.mean),
            None => DVector::from_iterator(
                coefficients.len(),
                self.precision.iter().zip(coefficients).map(|(precision, value)| precision * value),
            ),
        };
        let mut row = vec![0.0; coefficients.len()];
        for (node, residual) in self.convexity.violations(coefficients) {
            self.convexity.row(node, &mut row);
            gradient.iter_mut().zip(&row).for_each(|(sum, value)| *sum += residual * value);
        }
        gradient
    }
}
