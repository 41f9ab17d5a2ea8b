//! Chord (Shamanskii) steps for the smoother, from a start near the optimum. Near the optimum the normal matrix hardly changes
//! any more; it is kept then, and only the gradient is evaluated anew (V. E. Shamanskii, *Ukrainian Mathematical Journal* 19,
//! 1967): such a step costs O(M) for each sample, not O(M²).
//!
//! The orientations of the start are kept too: they are not brought to the minima of their samples before the first step, since
//! at a slightly wrong shape some of these minima are the wrong ones.

use crate::estimate::measurements::Instant;
use crate::estimate::model::contact_lanes::{Block, Waves, Weighted, dots};
use crate::estimate::model::layout::coefficients_to_order;
use crate::estimate::model::noise::Noise;
use crate::estimate::solver::gauss_newton::{
    Estimate, FIRST_DAMPING, PROJECTIONS, Smoother, StoppingCriteria, Taken, moved,
};
use crate::estimate::solver::normal_equations::{PSI_INFORMATION, SHARE};
use crate::math::lanes::{LANES, Lanes, Number};
use crate::mechanics::force_model::ForceModel;
use nalgebra::DVector;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// How a descent to the optimum ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Termination {
    /// The last step lowered the cost by less than the tolerance.
    Converged,
    /// As many steps as were allowed were taken, and the last one still lowered the cost by more than the tolerance.
    StepsUsedUp,
    /// No step lowers the cost, however short: the optimum is reached to rounding, or the start is a point where Gauss-Newton cannot go on.
    NoBetterStep,
}

/// Where a descent ended, and how.
pub(crate) struct Descent {
    pub estimate: Estimate,
    pub termination: Termination,
    /// Steps taken, each with a matrix of its own.
    pub steps: usize,
}

/// The matrix is evaluated anew as long as steps lower the cost by more than this share of it: far from the optimum it changes
/// too much.
const FAR: f64 = 0.5;

/// A kept matrix serves as long as each step gains less than this share of what the one before gained: slower convergence costs
/// more chord steps than a new matrix.
const CONTRACTION: f64 = 0.1;

/// The normal equations without their matrix, at one estimate.
pub(crate) struct Slope {
    pub cost: f64,
    pub gradient: DVector<f64>,
    /// As in [`super::normal_equations::Normal`].
    pub psi_offset: Vec<f64>,
}

impl<F: ForceModel> Smoother<'_, F> {
    /// Runs down to the minimum from a start that is near it.
    pub fn run_chord(&self, coefficients: Vec<f64>, psi: Vec<f64>, effort: StoppingCriteria) -> Estimate {
        self.descend(coefficients, psi, effort).estimate
    }

    /// The same, telling how it ended.
    pub fn descend(&self, mut coefficients: Vec<f64>, mut psi: Vec<f64>, effort: StoppingCriteria) -> Descent {
        coefficients_to_order(&mut coefficients, self.order);
        let cost = self.project_orientations(&coefficients, &mut psi, 0);
        let mut estimate = Estimate { coefficients, psi, cost };
        let mut damping = FIRST_DAMPING;
        for steps in 0..effort.iterations {
            let before = estimate.cost;
            let Some(taken) = self.step(&mut estimate, &mut damping) else {
                return Descent { estimate, termination: Termination::NoBetterStep, steps };
            };
            let fall = before - estimate.cost;
            if fall <= effort.tolerance * estimate.cost
                || (fall < FAR * estimate.cost && self.chord_steps(&mut estimate, &taken, fall, effort.tolerance))
            {
                return Descent { estimate, termination: Termination::Converged, steps: steps + 1 };
            }
        }
        Descent { estimate, termination: Termination::StepsUsedUp, steps: effort.iterations }
    }

    /// Takes further steps with the matrix of one that lowered the cost by `fall`; whether the minimum is reached.
    fn chord_steps(&self, estimate: &mut Estimate, taken: &Taken, mut fall: f64, tolerance: f64) -> bool {
        let mut slope = self.project_with_gradient(&estimate.coefficients, &mut estimate.psi, 0);
        loop {
            let step = -taken.factor.solve(&slope.gradient);
            let coefficients = moved(&estimate.coefficients, &step);
            let mut psi = taken.normal.turned(&estimate.psi, &slope.psi_offset, &step);
            let there = self.project_with_gradient(&coefficients, &mut psi, PROJECTIONS);
            let cost = there.cost;
            let next = estimate.cost - cost;
            // No orientation is converged to its last digit, so that a gain this small may come out as a loss.
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
            if next > CONTRACTION * fall {
                return false;
            }
            (slope, fall) = (there, next);
        }
    }

    /// Brings each ψ to the minimum of its own sample, and returns what [`Smoother::linearise`] would find there, but for the
    /// matrix.
    pub(crate) fn project_with_gradient(&self, coefficients: &[f64], psi: &mut [f64], rounds: usize) -> Slope {
        let mut psi_offset = vec![0.0; psi.len()];
        let of_psi = psi.par_chunks_mut(SHARE).zip(psi_offset.par_chunks_mut(SHARE));
        let shares = self.measurements.instants.par_chunks(SHARE).zip(of_psi);
        let parts: Vec<(f64, Vec<f64>)> = shares
            .map(|(instants, (psi, offset))| {
                let (force_model, noise) = (self.force_model, self.noise);
                Arch::new().dispatch(ProjectingWithGradient {
                    force_model,
                    instants,
                    noise,
                    coefficients,
                    psi,
                    rounds,
                    offset,
                })
            })
            .collect();
        let (mut cost, mut gradient) = (self.shape_cost(coefficients), self.shape_gradient(coefficients));
        for (of_share, slope) in parts {
            cost += of_share;
            gradient.iter_mut().zip(slope).for_each(|(sum, slope)| *sum += slope);
        }
        Slope { cost, gradient, psi_offset }
    }

    /// Half the gradient of the prior and of convexity.
    fn shape_gradient(&self, coefficients: &[f64]) -> DVector<f64> {
        let mut gradient = match self.belief {
            Some(belief) => belief.gradient(coefficients),
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

/// [`Smoother::project_with_gradient`] for the samples alone, compiled for several instruction sets.
struct ProjectingWithGradient<'a, F> {
    force_model: F,
    instants: &'a [Instant],
    noise: Noise,
    coefficients: &'a [f64],
    psi: &'a mut [f64],
    rounds: usize,
    offset: &'a mut [f64],
}

impl<F: ForceModel> WithSimd for ProjectingWithGradient<'_, F> {
    /// Cost and half the gradient.
    type Output = (f64, Vec<f64>);

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> (f64, Vec<f64>) {
        let Self { force_model, instants, noise, coefficients, psi, rounds, offset } = self;
        let mut waves = Waves::new(coefficients.len() / 2);
        let mut sums = vec![Lanes::ZERO; coefficients.len()];
        let mut cost = 0.0;
        let of_psi = psi.chunks_mut(LANES).zip(offset.chunks_mut(LANES));
        for (instants, (psi, psi_offset)) in instants.chunks(LANES).zip(of_psi) {
            let block = Block::new(force_model, instants, noise);
            let Weighted { value, by_psi } = block.project_orientations(coefficients, psi, rounds, Some(&mut waves));
            cost += dots(&value, &value).sum();
            // The part of the residuals that ψ absorbs is not in the gradient of the shape.
            let (overlap, information) = (dots(&by_psi, &value), dots(&by_psi, &by_psi));
            let taken = Lanes::from_fn(|lane| overlap[lane] / (information[lane] + PSI_INFORMATION));
            psi_offset.iter_mut().zip(taken.0).for_each(|(offset, taken)| *offset = -taken);
            let share = [value[0] - taken * by_psi[0], value[1] - taken * by_psi[1], value[2] - taken * by_psi[2]];
            let mixture = block.mixture(&share);
            for (index, sums) in sums.iter_mut().enumerate() {
                *sums = *sums + mixture.element(&waves, index);
            }
        }
        (cost, sums.iter().map(|lanes| lanes.sum()).collect())
    }
}
