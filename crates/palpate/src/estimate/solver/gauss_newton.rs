//! Maximum likelihood over all samples at once by Gauss-Newton with variable projection (`docs/theory.md`, maximum likelihood;
//! not in the paper).
//!
//! Unknown are the coefficients a of the support function and one orientation ψ per sample. Each ψ occurs only in the three
//! residuals of its own sample, so that a step eliminates it exactly (Schur complement): the rows of a sample are projected on
//! the complement of their derivative by ψ, which leaves two rows in a alone. A step costs O(N M²) with M = 2K + 1, and the
//! inverse of the reduced matrix is the posterior covariance of the shape. Levenberg-Marquardt damping makes every step a
//! descent.
//!
//! The problem in one line:
//! minimise Σᵢ [(ŝ1 − s1)² + (ŝ2 − s2)²]/σ² + g²/σ_b² + Σₖ k⁴(aₖ² + bₖ²)/c² + Σⱼ max(0, ε − v(θⱼ))²/σ_v².

use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact_lanes::Block;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::layout::{Layout, coefficients_to_order};
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::{Convexity, Prior};
use crate::estimate::solver::convex_step::Penalised;
use crate::estimate::solver::normal_equations::{Linearising, Normal, SHARE};
use crate::estimate::solver::outer_products::OuterProducts;
use crate::estimate::solver::posterior::Posterior;
use crate::math::lanes::{LANES, Lanes, Number};
use crate::mechanics::Forces;
use crate::mechanics::force_model::ForceModel;
use nalgebra::{Cholesky, DVector, Dyn};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// A shape and a motion.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    /// (a0, a1 … aK, b1 … bK), metres.
    pub coefficients: Vec<f64>,
    /// One orientation per instant of the problem, radians.
    pub psi: Vec<f64>,
    /// The minimised sum of squares.
    pub cost: f64,
}

/// The optimum for one number of harmonics, with the noise and the prior that go with it.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    pub estimate: Estimate,
    pub order: usize,
    pub noise: Noise,
    pub prior: Prior,
    /// Of this number of harmonics, noise and prior.
    pub evidence: Evidence,
}

/// Effort of a fit that is repeated without some of its samples: to a small part of what the posterior leaves open.
const WITHOUT_SOME: StoppingCriteria = StoppingCriteria { iterations: 12, tolerance: 1e-4 };

impl Fit {
    /// The optimum of other samples, from this one and with its noise, prior and number of harmonics. A sample that is set aside goes along, but
    /// does not bend the shape.
    pub fn at_optimum_of(&self, measurements: &Measurements) -> Self {
        let Estimate { coefficients, psi, .. } = self.estimate.clone();
        let smoother = Smoother::new(measurements, self.order, self.noise, self.prior);
        Self { estimate: smoother.run_chord(coefficients, psi, WITHOUT_SOME), ..self.clone() }
    }
}

/// When an iteration ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StoppingCriteria {
    pub iterations: usize,
    /// Relative fall of the cost below which the optimum counts as reached.
    pub tolerance: f64,
}

/// An accepted step: its normal equations, and the Cholesky factor of their damped matrix.
pub(crate) struct Taken {
    pub normal: Normal,
    pub factor: Cholesky<f64, Dyn>,
}

/// Levenberg-Marquardt damping: at first; divided by 5 after a step that lowers the cost and multiplied by 5 after one that does
/// not; never below the least, at which a step is a plain Gauss-Newton step; and given up above the largest where the cost is not
/// finite. Where the matrix cannot be factored the damping is raised tenfold, from at least [`SINGULAR_DAMPING`].
pub(crate) const FIRST_DAMPING: f64 = 1e-4;
const RELAXED: f64 = 0.2;
const TIGHTENED: f64 = 5.0;
const LEAST_DAMPING: f64 = 1e-12;
const LARGEST_DAMPING: f64 = 1e8;
const RAISED: f64 = 10.0;
const SINGULAR_DAMPING: f64 = 1e-8;

/// Damped steps that are tried before a point counts as a minimum.
const MOST_TRIALS: usize = 12;

/// Newton steps that bring each ψ to the minimum of its own sample after a step of the shape: it is that near already.
pub(crate) const PROJECTIONS: usize = 2;

/// Nodes at which convexity is enforced: a factor of the number of harmonics K, and a constant. With 6K + 12, v may dip a little
/// between nodes, which a search tolerates; with 24K + 24 nothing that matters dips between them.
const NODES: [usize; 2] = [6, 12];
const STRICT_NODES: [usize; 2] = [24, 24];

/// Everything that defines the cost, for one number of harmonics.
pub(crate) struct Smoother<'a, F = Forces> {
    pub force_model: F,
    pub measurements: &'a Measurements,
    pub order: usize,
    pub noise: Noise,
    pub prior: Prior,
    pub convexity: Convexity,
    /// 1/(prior standard deviation)² of each coefficient.
    pub precision: Vec<f64>,
    /// The posterior given other samples, in place of the prior.
    pub belief: Option<&'a Posterior>,
}

impl<'a> Smoother<'a> {
    pub fn new(measurements: &'a Measurements, order: usize, noise: Noise, prior: Prior) -> Self {
        Self::with_forces(Forces::default(), measurements, order, noise, prior)
    }

    /// The same with the posterior given other samples as the prior of the shape (of the same order).
    pub fn with_belief(
        measurements: &'a Measurements,
        order: usize,
        noise: Noise,
        prior: Prior,
        belief: &'a Posterior,
    ) -> Self {
        Self { belief: Some(belief), ..Self::new(measurements, order, noise, prior) }
    }
}

impl<'a, F: ForceModel> Smoother<'a, F> {
    /// With a given force model, whose residual depends on its own instant only.
    pub fn with_forces(
        force_model: F,
        measurements: &'a Measurements,
        order: usize,
        noise: Noise,
        prior: Prior,
    ) -> Self {
        const { assert!(F::NEIGHBOURS == 0, "orientations that depend on each other need a banded elimination") };
        Self {
            force_model,
            measurements,
            order,
            noise,
            prior,
            convexity: Convexity::new(order, prior.size_m, NODES[0] * order + NODES[1]),
            precision: prior.standard_deviations(order).iter().map(|sd| 1.0 / (sd * sd)).collect(),
            belief: None,
        }
    }

    /// The same with convexity enforced at so many nodes that v does not dip between them.
    pub fn strictly_convex(mut self) -> Self {
        self.convexity = Convexity::new(self.order, self.prior.size_m, STRICT_NODES[0] * self.order + STRICT_NODES[1]);
        self
    }

    /// Whether the convexity constraint is active.
    pub fn holds_convex(&self, coefficients: &[f64]) -> bool {
        self.convexity.violations(coefficients).next().is_some()
    }

    /// The terms of the cost in the shape alone: prior and convexity.
    pub fn shape_cost(&self, coefficients: &[f64]) -> f64 {
        let prior: f64 = match self.belief {
            Some(belief) => belief.squared_distance(coefficients),
            None => self.precision.iter().zip(coefficients).map(|(precision, value)| precision * value * value).sum(),
        };
        let convexity: f64 = self.convexity.violations(coefficients).map(|(_, residual)| residual * residual).sum();
        prior + convexity
    }

    /// The posterior of the shape given the samples: the Gaussian at an estimate, its rotation fixed (turning the shape would
    /// turn the samples with it). `None` when it is not finite.
    pub fn posterior(&self, estimate: &Estimate) -> Option<Posterior> {
        let information = self.linearise(&estimate.coefficients, &estimate.psi).matrix;
        Posterior { layout: self.layout(), mean: self.of_order(estimate), information }.holding_rotation()
    }

    /// The same as the prior of further samples, which may release the nodes that now hold the shape convex: that of samples and prior alone.
    pub fn belief(&self, estimate: &Estimate) -> Option<Posterior> {
        let information = self.linearise_without_convexity(&estimate.coefficients, &estimate.psi).matrix;
        Posterior { layout: self.layout(), mean: self.of_order(estimate), information }.holding_rotation()
    }

    fn of_order(&self, estimate: &Estimate) -> DVector<f64> {
        let mut coefficients = estimate.coefficients.clone();
        coefficients_to_order(&mut coefficients, self.order);
        DVector::from_vec(coefficients)
    }

    /// The order of the unknowns in their vector.
    pub fn layout(&self) -> Layout {
        Layout { order: self.order, shared: F::PARAMETERS.len() }
    }

    /// An estimate after a step of the shape, with every ψ adjusted to first order.
    pub fn moved(&self, estimate: &Estimate, step: &DVector<f64>) -> Estimate {
        let normal = self.linearise(&estimate.coefficients, &estimate.psi);
        let psi = normal.turned(&estimate.psi, &vec![0.0; estimate.psi.len()], step);
        Estimate { coefficients: moved(&estimate.coefficients, step), psi, cost: f64::INFINITY }
    }

    /// Brings each ψ to the minimum of its own sample by a few Newton steps, and returns the cost there.
    pub fn project_orientations(&self, coefficients: &[f64], psi: &mut [f64], rounds: usize) -> f64 {
        let shares = self.measurements.instants.par_chunks(SHARE).zip(psi.par_chunks_mut(SHARE));
        let samples: Vec<f64> = shares
            .map(|(instants, psi)| {
                Arch::new().dispatch(Projecting {
                    force_model: self.force_model,
                    instants,
                    noise: self.noise,
                    coefficients,
                    psi,
                    rounds,
                })
            })
            .collect();
        self.shape_cost(coefficients) + samples.iter().sum::<f64>()
    }

    /// The normal equations at an estimate, with every ψ eliminated.
    pub fn linearise(&self, coefficients: &[f64], psi: &[f64]) -> Normal {
        self.held_convex(self.linearise_without_convexity(coefficients, psi), coefficients)
    }

    /// Those of samples and prior with the nodes that hold the shape convex.
    pub fn held_convex(&self, mut normal: Normal, coefficients: &[f64]) -> Normal {
        let mut row = DVector::zeros(normal.gradient.len());
        for (node, residual) in self.convexity.violations(coefficients) {
            self.convexity.row(node, row.as_mut_slice());
            normal.matrix.ger(1.0, &row, &row, 1.0);
            normal.gradient.axpy(residual, &row, 1.0);
        }
        normal
    }

    /// The same for samples and prior alone.
    pub fn linearise_without_convexity(&self, coefficients: &[f64], psi: &[f64]) -> Normal {
        let unknowns = self.layout().unknowns();
        self.measurements.work.add_step(psi.len(), unknowns);
        let mut psi_slope = vec![Lanes::ZERO; psi.len().div_ceil(LANES) * unknowns];
        let (mut psi_offset, mut psi_information) = (vec![0.0; psi.len()], vec![0.0; psi.len()]);
        let slopes = psi_slope.par_chunks_mut(SHARE / LANES * unknowns);
        let of_psi = psi_offset.par_chunks_mut(SHARE).zip(psi_information.par_chunks_mut(SHARE)).zip(slopes);
        let shares = self.measurements.instants.par_chunks(SHARE).zip(psi.par_chunks(SHARE)).zip(of_psi);
        let parts: Vec<OuterProducts> = shares
            .map(|((instants, psi), ((offset, information), slopes))| {
                let (force_model, noise) = (self.force_model, self.noise);
                Arch::new().dispatch(Linearising {
                    force_model,
                    instants,
                    noise,
                    coefficients,
                    psi,
                    offset,
                    information,
                    slopes,
                })
            })
            .collect();
        let mut parts = parts.into_iter();
        let mut sums = parts.next().unwrap_or_else(|| OuterProducts::new(unknowns, 0));
        parts.for_each(|part| sums.add(part));
        let (mut matrix, mut gradient) = sums.finish(unknowns);
        match self.belief {
            Some(belief) => {
                gradient += belief.gradient(coefficients);
                matrix += &belief.information;
            }
            None => {
                for (index, precision) in self.precision.iter().enumerate() {
                    matrix[(index, index)] += precision;
                    gradient[index] += precision * coefficients[index];
                }
            }
        }
        Normal { matrix, gradient, psi_offset, psi_slope, psi_information }
    }

    /// Runs Gauss-Newton with Levenberg-Marquardt damping down to a minimum.
    pub fn run(&self, mut coefficients: Vec<f64>, mut psi: Vec<f64>, effort: StoppingCriteria) -> Estimate {
        coefficients_to_order(&mut coefficients, self.order);
        let cost = self.project_orientations(&coefficients, &mut psi, PROJECTIONS);
        let mut estimate = Estimate { coefficients, psi, cost };
        let mut damping = FIRST_DAMPING;
        for _ in 0..effort.iterations {
            let before = estimate.cost;
            if self.step(&mut estimate, &mut damping).is_none()
                || before - estimate.cost <= effort.tolerance * estimate.cost
            {
                break;
            }
        }
        estimate
    }

    /// One step, damped until it lowers the cost. `None` when no damping lowers it.
    pub fn step(&self, estimate: &mut Estimate, damping: &mut f64) -> Option<Taken> {
        let normal = self.linearise_without_convexity(&estimate.coefficients, &estimate.psi);
        let penalised = Penalised::new(&self.convexity, &estimate.coefficients, &normal);
        for _ in 0..MOST_TRIALS {
            let Some((step, factor)) = penalised.minimum(*damping) else {
                *damping = (*damping * RAISED).max(SINGULAR_DAMPING);
                continue;
            };
            let coefficients = moved(&estimate.coefficients, &step);
            let mut psi = normal.turned(&estimate.psi, &normal.psi_offset, &step);
            let cost = self.project_orientations(&coefficients, &mut psi, PROJECTIONS);
            if cost < estimate.cost {
                *estimate = Estimate { coefficients, psi, cost };
                *damping = (*damping * RELAXED).max(LEAST_DAMPING);
                return Some(Taken { normal, factor });
            }
            *damping *= TIGHTENED;
            if !cost.is_finite() && *damping > LARGEST_DAMPING {
                break;
            }
        }
        None
    }

    /// Cholesky factor of the posterior information of the shape, at an optimum.
    pub fn factor(&self, normal: &Normal) -> Option<Cholesky<f64, Dyn>> {
        Cholesky::new(normal.matrix.clone())
    }
}

/// [`Smoother::project_orientations`] for the samples alone, compiled for several instruction sets.
struct Projecting<'a, F> {
    force_model: F,
    instants: &'a [Instant],
    noise: Noise,
    coefficients: &'a [f64],
    psi: &'a mut [f64],
    rounds: usize,
}

impl<F: ForceModel> WithSimd for Projecting<'_, F> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { force_model, instants, noise, coefficients, psi, rounds } = self;
        let mut cost = 0.0;
        for (instants, psi) in instants.chunks(LANES).zip(psi.chunks_mut(LANES)) {
            let block = Block::new(force_model, instants, noise);
            let projected = block.project_orientations(coefficients, psi, rounds, None);
            cost += projected.sums().0.sum();
        }
        cost
    }
}

/// Coefficients after a step.
pub(crate) fn moved(coefficients: &[f64], step: &DVector<f64>) -> Vec<f64> {
    coefficients.iter().zip(step.iter()).map(|(a, b)| a + b).collect()
}

#[cfg(test)]
mod tests;
