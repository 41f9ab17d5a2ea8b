//! Maximum likelihood over all samples at once (`docs/theory.md`, maximum likelihood; none of it is in the paper).
//!
//! Unknown are the coefficients a of the support function and one orientation ψ per sample. Each ψ stands in the three
//! residuals of its own sample only, so a Gauss-Newton step eliminates it exactly: the rows of a sample are projected on the
//! complement of their derivative by ψ, which leaves two rows in a alone. The cost is O(N M²) with M = 2K + 1, and the
//! inverse of the reduced matrix is the posterior covariance of the shape.
//!
//! The whole problem in one line:
//! minimise Σᵢ [(ŝ1 − s1)² + (ŝ2 − s2)²]/σ² + g²/σ_b² + Σₖ k⁴(aₖ² + bₖ²)/c² + Σⱼ max(0, ε − v(θⱼ))²/σ_v².

mod block;
mod near;
mod sums;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use block::{Block, Waves, dots, turned_frames};
use sums::OuterProducts;

use super::problem::{Instant, Problem};
use crate::math::lanes::{LANES, Lanes, Number};
use crate::mechanics::force_model::ForceModel;
use crate::mechanics::frictionless::Frictionless;

/// Standard deviations of the measurements, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    /// Of the contact positions.
    pub sensor_m: f64,
    /// Of the balance equation g.
    pub balance_m: f64,
}

impl Noise {
    /// Weights of the three residuals of an instant, 1/m.
    pub fn weights(&self, instant: &Instant) -> [f64; 3] {
        let inverse = 1.0 / self.sensor_m;
        [instant.weight1 * inverse, instant.weight2 * inverse, instant.balance_weight / self.balance_m]
    }
}

/// What is believed of the shape before anything is felt: a_k, b_k ~ N(0, (c/k²)²) for k ≥ 2, and a wide prior on the mean
/// radius and on the first harmonic (where the centre of mass is).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Prior {
    /// Rough size of the object, metres.
    pub size_m: f64,
    /// c above, metres.
    pub scale_m: f64,
}

impl Prior {
    /// Prior standard deviations of the coefficient vector (a0, a1 … aK, b1 … bK).
    pub fn standard_deviations(&self, order: usize) -> Vec<f64> {
        let harmonic = |k: usize| if k == 1 { self.size_m } else { self.scale_m / (k * k) as f64 };
        let mut sd = vec![10.0 * self.size_m];
        sd.extend((1..=order).map(harmonic));
        sd.extend((1..=order).map(harmonic));
        sd
    }
}

/// A shape and a motion.
#[derive(Clone, Debug)]
pub(super) struct Estimate {
    /// (a0, a1 … aK, b1 … bK), metres.
    pub coefficients: Vec<f64>,
    /// One orientation per instant of the problem, radians.
    pub psi: Vec<f64>,
    /// The minimised sum of squares.
    pub cost: f64,
}

/// Samples that one thread takes at a time. The sums over each share are added in order, so that nothing depends on how many threads
/// there are.
const SHARE: usize = 512 * LANES;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    pub iterations: usize,
    /// Relative fall of the cost below which the optimum counts as reached.
    pub tolerance: f64,
}

/// Information on the change of ψ in one step, from nowhere: one radian. Matters only where a sample says nothing of ψ.
const PSI_INFORMATION: f64 = 1.0;

/// The normal equations in the shape alone, at one estimate.
pub(super) struct Normal {
    pub matrix: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// dψᵢ = offsetᵢ + slopeᵢ · da.
    psi_offset: Vec<f64>,
    /// For eight instants after eight, element by element.
    psi_slope: Vec<Lanes>,
    /// Squared norm of the weighted derivative of each sample's residuals by ψ.
    psi_information: Vec<f64>,
}

impl Normal {
    /// Derivative of ψ of one instant by the coefficients.
    pub fn psi_slope(&self, instant: usize) -> DVector<f64> {
        let (block, lane) = (instant / LANES * self.gradient.len(), instant % LANES);
        DVector::from_fn(self.gradient.len(), |element, _| self.psi_slope[block + element][lane])
    }

    /// Orientations after a step of the coefficients, given what each would turn by without one.
    fn turned(&self, psi: &[f64], offset: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let mut turned = psi.to_vec();
        let slopes = self.psi_slope.par_chunks(SHARE / LANES * step.len());
        turned.par_chunks_mut(SHARE).zip(offset.par_chunks(SHARE)).zip(slopes).for_each(|((psi, offset), slopes)| {
            Arch::new().dispatch(Turning { psi, offset, slopes, step: step.as_slice() });
        });
        turned
    }

    /// Information on ψ of one instant from its own sample, the shape being known.
    pub fn psi_information(&self, instant: usize) -> f64 {
        self.psi_information[instant]
    }
}

/// A step that was taken: with these equations, and this factor of their matrix, damped.
struct Taken {
    normal: Normal,
    factor: Cholesky<f64, Dyn>,
}

/// Everything that defines the cost, for one number of harmonics.
pub(super) struct Smoother<'a, F = Frictionless> {
    force_model: F,
    pub problem: &'a Problem,
    pub order: usize,
    pub noise: Noise,
    pub prior: Prior,
    convexity: Convexity,
    /// 1/(prior standard deviation)² of each coefficient.
    precision: Vec<f64>,
    belief: Option<&'a Belief>,
}

/// What other samples told of the shape: a Gaussian that takes the place of the prior.
pub(super) struct Belief {
    pub information: DMatrix<f64>,
    pub mean: DVector<f64>,
}

/// Keeps the radius of curvature positive: rows max(0, ε − v(θⱼ))/σ_v at nodes fine enough for K harmonics.
struct Convexity {
    margin_m: f64,
    sd_m: f64,
    order: usize,
    nodes: usize,
    /// (1 − k²) cos kθ for k = 1 … K at the nodes of half a turn, 0 to π; those of the other half mirror them.
    cosines: Vec<f64>,
    /// (1 − k²) sin kθ at the same.
    sines: Vec<f64>,
}

impl Convexity {
    /// At an even number of nodes.
    fn new(order: usize, size_m: f64, nodes: usize) -> Self {
        let circle: Vec<(f64, f64)> =
            (0..nodes).map(|node| (std::f64::consts::TAU * node as f64 / nodes as f64).sin_cos()).collect();
        let half = nodes / 2 + 1;
        let (mut cosines, mut sines) = (Vec::with_capacity(order * half), Vec::with_capacity(order * half));
        for k in 1..=order {
            let bending = 1.0 - (k * k) as f64;
            for node in 0..half {
                let (sin, cos) = circle[k * node % nodes];
                cosines.push(bending * cos);
                sines.push(bending * sin);
            }
        }
        Self { margin_m: 8e-3 * size_m, sd_m: 5e-4 * size_m, order, nodes, cosines, sines }
    }

    fn none() -> Self {
        Self { margin_m: 0.0, sd_m: 1.0, order: 0, nodes: 0, cosines: Vec::new(), sines: Vec::new() }
    }

    /// The violated nodes and their residuals.
    fn violations(&self, coefficients: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        // What v has in common at θ and −θ, and what it has opposite.
        let half = if self.nodes == 0 { 0 } else { self.nodes / 2 + 1 };
        let (mut common, mut opposite) = (vec![coefficients[0]; half], vec![0.0; half]);
        let (a, b) = coefficients[1..].split_at(coefficients.len() / 2);
        Arch::new().dispatch(Summing { factors: a, columns: &self.cosines, sums: &mut common });
        Arch::new().dispatch(Summing { factors: b, columns: &self.sines, sums: &mut opposite });
        (0..self.nodes).filter_map(move |node| {
            let (mirrored, sign) = self.mirrored(node);
            let v = common[mirrored] + sign * opposite[mirrored];
            (v < self.margin_m).then(|| (node, (self.margin_m - v) / self.sd_m))
        })
    }

    /// The node of the first half that a node is or mirrors, and the sign of its sines.
    fn mirrored(&self, node: usize) -> (usize, f64) {
        if 2 * node <= self.nodes { (node, 1.0) } else { (self.nodes - node, -1.0) }
    }

    /// Writes the derivative of the residual of a node by the coefficients.
    fn row(&self, node: usize, row: &mut [f64]) {
        let (mirrored, sign) = self.mirrored(node);
        let half = self.nodes / 2 + 1;
        let scale = -1.0 / self.sd_m;
        row[0] = scale;
        for k in 0..self.order {
            row[1 + k] = scale * self.cosines[k * half + mirrored];
            row[1 + self.order + k] = scale * sign * self.sines[k * half + mirrored];
        }
    }
}

impl<'a> Smoother<'a> {
    pub fn new(problem: &'a Problem, order: usize, noise: Noise, prior: Prior) -> Self {
        Self::with_forces(Frictionless, problem, order, noise, prior)
    }

    /// The same over further samples, with the belief that others left of the shape (of the same order).
    pub fn with_belief(problem: &'a Problem, order: usize, noise: Noise, prior: Prior, belief: &'a Belief) -> Self {
        Self { belief: Some(belief), ..Self::new(problem, order, noise, prior) }
    }
}

impl<'a, F: ForceModel> Smoother<'a, F> {
    /// With a model of the forces of one's own.
    pub fn with_forces(force_model: F, problem: &'a Problem, order: usize, noise: Noise, prior: Prior) -> Self {
        Self {
            force_model,
            problem,
            order,
            noise,
            prior,
            convexity: Convexity::new(order, prior.size_m, 6 * order + 12),
            precision: prior.standard_deviations(order).iter().map(|sd| 1.0 / (sd * sd)).collect(),
            belief: None,
        }
    }

    /// The same with convexity watched so closely that nothing dips between the nodes.
    pub fn strictly_convex(mut self) -> Self {
        self.convexity = Convexity::new(self.order, self.prior.size_m, 24 * self.order + 24);
        self
    }

    /// The same with convexity left out, for a first look.
    pub fn without_convexity(mut self) -> Self {
        self.convexity = Convexity::none();
        self
    }

    /// Whether convexity keeps the shape from going where the samples would have it.
    pub fn holds_convex(&self, coefficients: &[f64]) -> bool {
        self.convexity.violations(coefficients).next().is_some()
    }

    fn shape_cost(&self, coefficients: &[f64]) -> f64 {
        let prior: f64 = match self.belief {
            Some(belief) => {
                let off = DVector::from_row_slice(coefficients) - &belief.mean;
                (&belief.information * &off).dot(&off)
            }
            None => self.precision.iter().zip(coefficients).map(|(precision, value)| precision * value * value).sum(),
        };
        let convexity: f64 = self.convexity.violations(coefficients).map(|(_, residual)| residual * residual).sum();
        prior + convexity
    }

    /// What the samples tell of the shape: the Gaussian at an estimate, with its rotation held fast (turning the shape would
    /// turn the samples with it). `None` when they tell nothing.
    pub fn belief(&self, estimate: &Estimate) -> Option<Belief> {
        let mut information = self.linearise(&estimate.coefficients, &estimate.psi).matrix;
        let mut coefficients = estimate.coefficients.clone();
        coefficients_to_order(&mut coefficients, self.order);
        let mean = DVector::from_vec(coefficients);
        let mut rotation = DVector::zeros(mean.len());
        for k in 1..=self.order {
            rotation[k] = k as f64 * mean[self.order + k];
            rotation[self.order + k] = -(k as f64) * mean[k];
        }
        let length = rotation.norm_squared();
        if length > 0.0 {
            information += &rotation * rotation.transpose() * (1e6 / (length * length));
        }
        information.iter().all(|value| value.is_finite()).then_some(Belief { information, mean })
    }

    /// An estimate after a step of the shape, with every ψ turned along.
    pub fn moved(&self, estimate: &Estimate, step: &DVector<f64>) -> Estimate {
        let normal = self.linearise(&estimate.coefficients, &estimate.psi);
        let psi = normal.turned(&estimate.psi, &vec![0.0; estimate.psi.len()], step);
        Estimate { coefficients: moved(&estimate.coefficients, step), psi, cost: f64::INFINITY }
    }

    /// Brings each ψ to the minimum of its own sample by a few Newton steps, and returns the cost there.
    fn settle(&self, coefficients: &[f64], psi: &mut [f64], rounds: usize) -> f64 {
        let shares = self.problem.instants.par_chunks(SHARE).zip(psi.par_chunks_mut(SHARE));
        let samples: Vec<f64> = shares
            .map(|(instants, psi)| {
                Arch::new().dispatch(Settling { force_model: self.force_model, instants, noise: self.noise, coefficients, psi, rounds })
            })
            .collect();
        self.shape_cost(coefficients) + samples.iter().sum::<f64>()
    }

    /// The normal equations at an estimate, with every ψ eliminated.
    pub fn linearise(&self, coefficients: &[f64], psi: &[f64]) -> Normal {
        let unknowns = 2 * self.order + 1;
        let mut psi_slope = vec![Lanes::ZERO; psi.len().div_ceil(LANES) * unknowns];
        let (mut psi_offset, mut psi_information) = (vec![0.0; psi.len()], vec![0.0; psi.len()]);
        let slopes = psi_slope.par_chunks_mut(SHARE / LANES * unknowns);
        let of_psi = psi_offset.par_chunks_mut(SHARE).zip(psi_information.par_chunks_mut(SHARE)).zip(slopes);
        let shares = self.problem.instants.par_chunks(SHARE).zip(psi.par_chunks(SHARE)).zip(of_psi);
        let parts: Vec<OuterProducts> = shares
            .map(|((instants, psi), ((offset, information), slopes))| {
                let (force_model, noise) = (self.force_model, self.noise);
                Arch::new().dispatch(Linearising { force_model, instants, noise, coefficients, psi, offset, information, slopes })
            })
            .collect();
        let mut parts = parts.into_iter();
        let mut sums = parts.next().unwrap_or_else(|| OuterProducts::new(unknowns, 0));
        parts.for_each(|part| sums.add(part));
        let mut row = vec![0.0; unknowns];
        for (node, residual) in self.convexity.violations(coefficients) {
            self.convexity.row(node, &mut row);
            sums.push(&row, residual);
        }
        let (mut matrix, mut gradient) = sums.finish(unknowns);
        match self.belief {
            Some(belief) => {
                gradient += &belief.information * (DVector::from_row_slice(coefficients) - &belief.mean);
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
    pub fn run(&self, mut coefficients: Vec<f64>, mut psi: Vec<f64>, effort: Effort) -> Estimate {
        coefficients_to_order(&mut coefficients, self.order);
        let cost = self.settle(&coefficients, &mut psi, 2);
        let mut estimate = Estimate { coefficients, psi, cost };
        let mut damping = 1e-4;
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

    /// One step, damped until it lowers the cost. `None` when nothing lowers it.
    fn step(&self, estimate: &mut Estimate, damping: &mut f64) -> Option<Taken> {
        let normal = self.linearise(&estimate.coefficients, &estimate.psi);
        for _ in 0..12 {
            let mut damped = normal.matrix.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] *= 1.0 + *damping;
            }
            let Some(factor) = Cholesky::new(damped) else {
                *damping = (*damping * 10.0).max(1e-8);
                continue;
            };
            let step = -factor.solve(&normal.gradient);
            let coefficients = moved(&estimate.coefficients, &step);
            let mut psi = normal.turned(&estimate.psi, &normal.psi_offset, &step);
            let cost = self.settle(&coefficients, &mut psi, 2);
            if cost < estimate.cost {
                *estimate = Estimate { coefficients, psi, cost };
                *damping = (*damping * 0.2).max(1e-12);
                return Some(Taken { normal, factor });
            }
            *damping *= 5.0;
            if !cost.is_finite() && *damping > 1e8 {
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

/// Adds columns, each times its factor, compiled for several processors.
struct Summing<'a> {
    factors: &'a [f64],
    columns: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for Summing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { factors, columns, sums } = self;
        for (factor, column) in factors.iter().zip(columns.chunks_exact(sums.len().max(1))) {
            for (sum, value) in sums.iter_mut().zip(column) {
                *sum += factor * value;
            }
        }
    }
}

/// [`Normal::turned`], compiled for several processors.
struct Turning<'a> {
    psi: &'a mut [f64],
    offset: &'a [f64],
    slopes: &'a [Lanes],
    step: &'a [f64],
}

impl WithSimd for Turning<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { psi, offset, slopes, step } = self;
        let blocks = slopes.chunks_exact(step.len().max(1));
        for ((psi, offset), slopes) in psi.chunks_mut(LANES).zip(offset.chunks(LANES)).zip(blocks) {
            let mut turn = Lanes::loaded(offset);
            for (slopes, step) in slopes.iter().zip(step) {
                turn = turn + *slopes * *step;
            }
            psi.iter_mut().zip(turn.0).for_each(|(psi, turn)| *psi += turn.clamp(-0.3, 0.3));
        }
    }
}

/// [`Smoother::settle`] for the samples alone, compiled for several processors.
struct Settling<'a, F> {
    force_model: F,
    instants: &'a [Instant],
    noise: Noise,
    coefficients: &'a [f64],
    psi: &'a mut [f64],
    rounds: usize,
}

impl<F: ForceModel> WithSimd for Settling<'_, F> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f64 {
        let Self { force_model, instants, noise, coefficients, psi, rounds } = self;
        let mut cost = 0.0;
        for (instants, psi) in instants.chunks(LANES).zip(psi.chunks_mut(LANES)) {
            let block = Block::new(force_model, instants, noise);
            let settled = block.settle(coefficients, psi, rounds, None);
            cost += settled.sums().0.sum();
        }
        cost
    }
}

/// [`Smoother::linearise`] for the samples alone, compiled for several processors.
struct Linearising<'a, F> {
    force_model: F,
    instants: &'a [Instant],
    noise: Noise,
    coefficients: &'a [f64],
    psi: &'a [f64],
    offset: &'a mut [f64],
    information: &'a mut [f64],
    slopes: &'a mut [Lanes],
}

impl<F: ForceModel> WithSimd for Linearising<'_, F> {
    type Output = OuterProducts;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> OuterProducts {
        let Self { force_model, instants, noise, coefficients, psi, offset, information, slopes } = self;
        let unknowns = coefficients.len();
        let mut sums = OuterProducts::new(unknowns, 3 * psi.len());
        let mut waves = Waves::new(unknowns / 2);
        let of_psi = offset.chunks_mut(LANES).zip(information.chunks_mut(LANES)).zip(slopes.chunks_exact_mut(unknowns));
        let blocks = instants.chunks(LANES).zip(psi.chunks(LANES)).zip(of_psi);
        for ((instants, psi), ((psi_offset, psi_information), slopes)) in blocks {
            let block = Block::new(force_model, instants, noise);
            let at = block.at(coefficients, &Lanes::loaded(psi), Some(&mut waves));
            let information = dots(&at.by_psi, &at.by_psi);
            let [first, second, along] = turned_frames(&at.by_psi);
            for share in [first, second] {
                let mixture = block.mixture(&share);
                sums.push_block(unknowns, dots(&share, &at.value), |index| mixture.element(&waves, index));
            }
            // Along its own derivative ψ takes up all but the share that one radian of freedom leaves.
            let mixture = block.mixture(&along);
            let value = dots(&along, &at.value);
            let left = information.map(|information| (PSI_INFORMATION / (information + PSI_INFORMATION)).sqrt());
            let scale = information.map(|information| -information.sqrt() / (information + PSI_INFORMATION));
            sums.push_block(unknowns, left * value, |index| {
                let element = mixture.element(&waves, index);
                slopes[index] = scale * element;
                left * element
            });
            psi_offset.copy_from_slice(&(scale * value).0[..psi.len()]);
            psi_information.copy_from_slice(&information.0[..psi.len()]);
        }
        sums
    }
}

fn moved(coefficients: &[f64], step: &DVector<f64>) -> Vec<f64> {
    coefficients.iter().zip(step.iter()).map(|(a, b)| a + b).collect()
}

/// Changes the number of harmonics: cuts, or pads with zeros.
pub(super) fn coefficients_to_order(coefficients: &mut Vec<f64>, order: usize) {
    let old = coefficients.len() / 2;
    if old == order {
        return;
    }
    let mut changed = vec![0.0; 2 * order + 1];
    changed[0] = coefficients[0];
    let kept = old.min(order);
    changed[1..=kept].copy_from_slice(&coefficients[1..=kept]);
    changed[order + 1..=order + kept].copy_from_slice(&coefficients[old + 1..=old + kept]);
    *coefficients = changed;
}

#[cfg(test)]
mod tests;
