//! The step of Gauss-Newton for a shape that stays convex: the exact minimum of the quadratic model of samples and prior plus the
//! penalty Σⱼ max(0, ε − v(θⱼ))²/σ_v². The penalty is quadratic but for where it begins, and stiff: linearised with the nodes that are violated
//! at the start alone, steps along flat sides stay short. A semismooth Newton iteration over the violated nodes, each time with the exact
//! minimum along the line, ends after a few rounds (L. Qi and J. Sun, *Mathematical Programming* 58, 1993). No sample is looked at again.

use crate::estimate::model::prior::Convexity;
use crate::estimate::solver::gauss_newton::moved;
use crate::estimate::solver::normal_equations::Normal;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Rounds of the semismooth iteration: most steps take two to four, and what is short of the minimum is a descent too.
const ROUNDS: usize = 20;

/// A round that lowers the cost by less than this share of what all have is the last: samples are not that linear.
const ENOUGH: f64 = 0.01;

/// Unknowns for which a new factor costs as much as its update by one node.
const UPDATE_COST: usize = 10;

/// Newton steps along a line at most, and the share of the first slope at which they end.
const LINE_STEPS: usize = 30;
const LINE_ENOUGH: f64 = 1e-6;

/// The quadratic model of samples and prior at one estimate, with the penalty.
pub(crate) struct Penalised<'a> {
    convexity: &'a Convexity,
    coefficients: &'a [f64],
    normal: &'a Normal,
    /// Residuals of all nodes at the estimate.
    residuals: Vec<f64>,
    /// The matrix of the model with the nodes that are violated there.
    matrix: DMatrix<f64>,
}

impl<'a> Penalised<'a> {
    /// `normal` is that of samples and prior.
    pub fn new(convexity: &'a Convexity, coefficients: &'a [f64], normal: &'a Normal) -> Self {
        let residuals = convexity.residuals(coefficients);
        let mut matrix = normal.matrix.clone();
        let mut row = DVector::zeros(coefficients.len());
        for node in violated(&residuals) {
            convexity.row(node, row.as_mut_slice());
            matrix.syger(1.0, &row, &row, 1.0);
        }
        Self { convexity, coefficients, normal, residuals, matrix }
    }

    /// The step to the minimum with Levenberg-Marquardt damping, and the Cholesky factor of the matrix there. `None` when that matrix cannot
    /// be factored.
    pub fn minimum(&self, damping: f64) -> Option<(DVector<f64>, Cholesky<f64, Dyn>)> {
        let unknowns = self.coefficients.len();
        let damped: DVector<f64> = self.matrix.diagonal() * damping;
        let mut matrix = self.matrix.clone();
        (0..unknowns).for_each(|i| matrix[(i, i)] += damped[i]);
        let mut step = DVector::zeros(unknowns);
        let mut residuals = self.residuals.clone();
        let mut row = DVector::zeros(unknowns);
        let (mut round, mut fall) = (0, 0.0);
        let mut factor = Cholesky::new(matrix.clone())?;
        loop {
            let mut of_samples = &self.normal.matrix * &step + &self.normal.gradient + damped.component_mul(&step);
            let before = of_samples.clone();
            for node in violated(&residuals) {
                self.convexity.row(node, row.as_mut_slice());
                of_samples.axpy(residuals[node], &row, 1.0);
            }
            let newton = -factor.solve(&of_samples);
            let there = self.convexity.residuals(&moved(self.coefficients, &(&step + &newton)));
            let bent = (&self.normal.matrix * &newton + damped.component_mul(&newton)).dot(&newton);
            let slope = before.dot(&newton);
            let share = along_line(slope, bent, &residuals, &there);
            step.axpy(share, &newton, 1.0);
            let next: Vec<f64> = residuals.iter().zip(&there).map(|(a, b)| a + share * (b - a)).collect();
            let changed: Vec<usize> =
                (0..next.len()).filter(|&node| (next[node] > 0.0) != (residuals[node] > 0.0)).collect();
            let last = penalty(&residuals) - penalty(&next) - 2.0 * share * slope - share * share * bent;
            fall += last;
            round += 1;
            if changed.is_empty() || round == ROUNDS || last <= ENOUGH * fall {
                return Some((step, factor));
            }
            let few = changed.len() * UPDATE_COST <= unknowns;
            for node in changed {
                self.convexity.row(node, row.as_mut_slice());
                let sign = if next[node] > 0.0 { 1.0 } else { -1.0 };
                matrix.syger(sign, &row, &row, 1.0);
                if few {
                    factor.rank_one_update(&row, sign);
                }
            }
            if !few {
                factor = Cholesky::new(matrix.clone())?;
            }
            residuals = next;
        }
    }
}

/// The penalty at these residuals.
fn penalty(residuals: &[f64]) -> f64 {
    residuals.iter().map(|residual| residual.max(0.0).powi(2)).sum()
}

/// The nodes that these residuals violate.
fn violated(residuals: &[f64]) -> impl Iterator<Item = usize> {
    (0..residuals.len()).filter(|&node| residuals[node] > 0.0)
}

/// The share t of a Newton step, at most 1, at the minimum of `slope` t + `bent` t²/2 + Σⱼ max(0, rⱼ(t))²/2, where rⱼ goes from
/// `from` at t = 0 to `to` at t = 1: the derivative is a chain of straight lines, followed by Newton steps within a bracket.
fn along_line(slope: f64, bent: f64, from: &[f64], to: &[f64]) -> f64 {
    let derivatives = |t: f64| {
        from.iter().zip(to).fold((slope + bent * t, bent), |(first, second), (a, b)| {
            let (residual, rate) = (a + t * (b - a), b - a);
            if residual > 0.0 { (first + residual * rate, second + rate * rate) } else { (first, second) }
        })
    };
    let (mut low, mut high, mut t) = (0.0, 1.0, 1.0);
    for _ in 0..LINE_STEPS {
        let (first, second) = derivatives(t);
        if (t == 1.0 && first <= 0.0) || first.abs() <= LINE_ENOUGH * slope.abs() {
            break;
        }
        if first > 0.0 {
            high = t;
        } else {
            low = t;
        }
        let next = t - first / second;
        t = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    t
}

#[cfg(test)]
mod tests;
