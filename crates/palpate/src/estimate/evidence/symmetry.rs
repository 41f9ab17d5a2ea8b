//! Symmetry of the object by the evidence: which symmetric models a general fit leaves open, and how likely each is.
//!
//! A symmetric model is the general one with some coefficients u zero (harmonics that are no multiple of the order; sines in the
//! frame of the mirror). Models that are nested like this have the ratio of evidences p(u = 0 | log) / p(u = 0), both densities at
//! once known from the Gaussian posterior and the prior of the general fit (J. M. Dickey, *Ann. Math. Stat.* 42, 204, 1971). Where
//! the pieces of a symmetric object were laid on each other, the ratio still ranks the models; the fit of the symmetric model, with
//! an evidence of its own, decides.

use crate::estimate::coverage::{NODES, felt_nodes, images};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::{Layout, rotate, rotated_covariance};
use crate::estimate::model::prior::Prior;
use crate::estimate::model::sensor_memory::samples_per_error_by;
use crate::estimate::solver::gauss_newton::{Estimate, Fit, Smoother, StoppingCriteria};
use crate::estimate::solver::normal_equations::Normal;
use crate::shape::Symmetry;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};

/// Orders of rotation that are considered: those of things that people make. 1 is a mirror alone.
pub(super) const ORDERS: [u32; 7] = [1, 2, 3, 4, 5, 6, 8];

/// Symmetric models besides the general one: each order with a mirror and without, but for no symmetry at all.
const MODELS: f64 = 13.0;

/// Prior probability that an object is symmetric in one way or another; its models share it evenly.
const SYMMETRIC: f64 = 0.5;

/// Steps of the golden sections that refine the axis of a mirror: to a thousandth of the interval.
const AXIS_STEPS: usize = 14;

/// ln of the prior odds of one symmetric model against the general one.
pub(crate) fn log_prior_odds() -> f64 {
    (SYMMETRIC / MODELS / (1.0 - SYMMETRIC)).ln()
}

/// A symmetric model that a general fit leaves open.
pub(crate) struct SymmetricModel {
    pub symmetry: Symmetry,
    /// The most likely coefficients under it, in the frame of its mirror.
    pub coefficients: Vec<f64>,
    /// By how much the general frame is turned for that, radians: r(θ) becomes r(θ − turn), ψ becomes ψ − turn.
    pub turn: f64,
    /// ln of the ratio of its evidence to that of the general model.
    pub log_ratio: f64,
    /// Squared standard deviations by which the general posterior misses it, and how many of the unknowns that it excludes the log
    /// determines.
    pub missed: f64,
    pub determined: f64,
}

impl SymmetricModel {
    /// Whether the log contradicts it: the general posterior misses it by more than chance.
    pub fn is_contradicted(&self) -> bool {
        self.missed > self.determined + CONTRADICTED_SDS * (2.0 * self.determined).sqrt() + 1.0
    }
}

/// A symmetric model is contradicted when χ² of what it excludes is so many standard deviations above its expectation: an object
/// that is nearly symmetric is not called so when the log can tell, however much simpler the model is.
const CONTRADICTED_SDS: f64 = 3.0;

/// What the general model says of a symmetric one.
pub(crate) struct AgainstGeneral {
    pub model: SymmetricModel,
    /// Standard deviation of the difference of r between copies that were both felt, metres.
    pub deviation_sd_m: f64,
}

/// A symmetric model at its own optimum, held against the general one that has this optimum for a start, whose errors are as large as those of contacts
/// with a memory are. `None` where the log does
/// not determine the general one.
pub(crate) fn against_general(measurements: &Measurements, symmetric: &Fit) -> Option<AgainstGeneral> {
    let symmetry = symmetric.prior.symmetry;
    let prior = Prior { symmetry: Symmetry::NONE, ..symmetric.prior };
    let smoother = Smoother::new(measurements, symmetric.order, symmetric.noise, prior).strictly_convex();
    let Estimate { coefficients, psi, .. } = symmetric.estimate.clone();
    let general = smoother.run(coefficients, psi, STOPPING);
    let samples_per_error = samples_per_error_by(measurements, &general.coefficients, &general.psi);
    let posterior = |normal: &Normal| {
        let covariance = smoother.factor(normal)?.inverse() * samples_per_error;
        Some(General { mean: general.coefficients.clone(), covariance, prior })
    };
    let mut felt = vec![false; NODES];
    felt_nodes(measurements, &general.psi).for_each(|node| felt[node] = true);
    // That it is convex is known of the general object too.
    let convex = posterior(&smoother.linearise(&general.coefficients, &general.psi))?;
    let deviation_sd_m = convex.deviation_sd_m(symmetry, &felt);
    let general = posterior(&smoother.linearise_without_convexity(&general.coefficients, &general.psi))?;
    Some(AgainstGeneral { model: general.near(symmetry)?, deviation_sd_m })
}

/// Effort of the general fit that begins at a symmetric one.
const STOPPING: StoppingCriteria = StoppingCriteria { iterations: 20, tolerance: 1e-7 };

/// The symmetric models, the most likely first, by the posterior of samples and prior: the nodes that hold the shape convex would exclude
/// each that moves them. Empty where the log does not determine the general one.
pub(crate) fn symmetric_models(measurements: &Measurements, fit: &Fit) -> Vec<SymmetricModel> {
    let smoother = Smoother::new(measurements, fit.order, fit.noise, fit.prior).strictly_convex();
    let normal = smoother.linearise_without_convexity(&fit.estimate.coefficients, &fit.estimate.psi);
    let Some(factor) = smoother.factor(&normal) else { return Vec::new() };
    let general = General { mean: fit.estimate.coefficients.clone(), covariance: factor.inverse(), prior: fit.prior };
    let mut models: Vec<SymmetricModel> = ORDERS
        .into_iter()
        .flat_map(|order| [Symmetry { order, mirror: false }, Symmetry { order, mirror: true }])
        .filter(|symmetry| symmetry.is_any())
        .filter_map(|symmetry| general.with(symmetry))
        .collect();
    models.sort_by(|a, b| b.log_ratio.total_cmp(&a.log_ratio));
    models
}

/// The Gaussian posterior of a general fit.
struct General {
    mean: Vec<f64>,
    covariance: DMatrix<f64>,
    prior: Prior,
}

impl General {
    fn with(&self, symmetry: Symmetry) -> Option<SymmetricModel> {
        if !symmetry.mirror {
            return self.restricted(symmetry, 0.0);
        }
        self.mirrored(symmetry, axes(self.mean.as_slice(), symmetry))
    }

    /// The same, with the mirror near θ = 0.
    fn near(&self, symmetry: Symmetry) -> Option<SymmetricModel> {
        if symmetry.mirror { self.mirrored(symmetry, vec![0.0]) } else { self.restricted(symmetry, 0.0) }
    }

    fn mirrored(&self, symmetry: Symmetry, axes: Vec<f64>) -> Option<SymmetricModel> {
        let mut best: Option<SymmetricModel> = None;
        let width = 0.5 * PI / Layout::of_coefficients(&self.mean).order as f64;
        for turn in axes {
            let found = self.restricted(symmetry, turn);
            if let Some(found) = found
                && best.as_ref().is_none_or(|best| found.log_ratio > best.log_ratio)
            {
                best = Some(found);
            }
        }
        // Golden sections about the best of them.
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let middle = best.as_ref()?.turn;
        let value = |turn: f64| self.restricted(symmetry, turn).map_or(f64::NEG_INFINITY, |found| found.log_ratio);
        let (mut low, mut high) = (middle - width, middle + width);
        for _ in 0..AXIS_STEPS {
            let (left, right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
            if value(left) > value(right) { high = right } else { low = left }
        }
        let refined = self.restricted(symmetry, 0.5 * (low + high))?;
        best.filter(|best| best.log_ratio > refined.log_ratio).or(Some(refined))
    }

    /// Root mean square, over pairs of copies that were both felt, of the standard deviation of the difference of r between them,
    /// whatever the frame is turned by.
    fn deviation_sd_m(&self, symmetry: Symmetry, felt: &[bool]) -> f64 {
        let layout = Layout::of_coefficients(&self.mean);
        let rotation = layout.rotation(&self.mean);
        let square = rotation.norm_squared();
        let angle = |node: usize| TAU * node as f64 / felt.len() as f64;
        let variance = |(node, image): (usize, usize)| {
            let mut row = layout.support_row(angle(node)) - layout.support_row(angle(image));
            if square > 0.0 {
                row -= &rotation * (row.dot(&rotation) / square);
            }
            row.dot(&(&self.covariance * &row)).max(0.0)
        };
        let images = |node: usize| images(node, felt.len(), symmetry, 0.0).map(move |image| (node, image));
        let pairs = (0..felt.len()).flat_map(images);
        let (sum, count) = pairs
            .filter(|&(node, image)| node < image && felt[node] && felt[image])
            .map(variance)
            .fold((0.0, 0_usize), |(sum, count), variance| (sum + variance, count + 1));
        (sum / count.max(1) as f64).sqrt()
    }

    /// The model whose mirror, if it has one, lies at θ = 0 in the frame turned by `turn`.
    fn restricted(&self, symmetry: Symmetry, turn: f64) -> Option<SymmetricModel> {
        let layout = Layout::of_coefficients(&self.mean);
        let prior = Prior { symmetry, ..self.prior };
        let mut mean = self.mean.clone();
        rotate(&mut mean, turn);
        let covariance = if turn == 0.0 { self.covariance.clone() } else { rotated_covariance(&self.covariance, turn) };
        let free = |index: usize| match index {
            0 => true,
            _ if index <= layout.order => prior.is_free(index)[0],
            _ => prior.is_free(index - layout.order)[1],
        };
        let zero: Vec<usize> = (0..layout.unknowns()).filter(|&index| !free(index)).collect();
        let of_zero = DVector::from_iterator(zero.len(), zero.iter().map(|&index| mean[index]));
        let block = DMatrix::from_fn(zero.len(), zero.len(), |i, j| covariance[(zero[i], zero[j])]);
        let factor = block.cholesky()?;
        let solved = factor.solve(&of_zero);
        let half_log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
        let general_sd = self.prior.standard_deviations(layout.order);
        let missed = of_zero.dot(&solved);
        let determined =
            zero.iter().map(|&index| 1.0 - (covariance[(index, index)] / general_sd[index].powi(2)).min(1.0)).sum();
        let log_ratio =
            -0.5 * missed - half_log_determinant + zero.iter().map(|&index| general_sd[index].ln()).sum::<f64>();
        let coefficients = (0..layout.unknowns())
            .map(|index| {
                let shift: f64 =
                    zero.iter().zip(&solved).map(|(&other, solved)| covariance[(index, other)] * solved).sum();
                if free(index) { mean[index] - shift } else { 0.0 }
            })
            .collect();
        log_ratio.is_finite().then_some(SymmetricModel { symmetry, coefficients, turn, log_ratio, missed, determined })
    }
}

/// Turns of a shape that make the largest allowed harmonic a cosine: the one that brings the axis of its mirror to θ = 0 is among them.
fn axes(coefficients: &[f64], symmetry: Symmetry) -> Vec<f64> {
    let layout = Layout::of_coefficients(coefficients);
    let squares = |k: usize| {
        let (a, b) = (coefficients[Layout::cosine(k)], coefficients[layout.sine(k)]);
        a * a + b * b
    };
    let allowed = (1..=layout.order).filter(|&k| symmetry.allows_harmonic(k));
    // A harmonic k turns k times as fast as the frame: its square counts as often as it says something of the axis.
    let Some(largest) =
        allowed.max_by(|&a, &b| ((a * a) as f64 * squares(a)).total_cmp(&((b * b) as f64 * squares(b))))
    else {
        return Vec::new();
    };
    let phase = f64::atan2(coefficients[layout.sine(largest)], coefficients[Layout::cosine(largest)]);
    // a cos kθ + b sin kθ = A cos k(θ − phase/k); any half period of the harmonic more is a mirror of it as well. Axes repeat
    // with half the period of the object.
    let axes = (2 * largest).div_ceil(symmetry.order.max(1) as usize);
    (0..axes).map(|axis| -(phase + PI * axis as f64) / largest as f64).collect()
}

/// The turn of a shape with this symmetry that brings the axis of its mirror to θ = 0; 0 without one.
pub(crate) fn turn_to_axis(coefficients: &[f64], symmetry: Symmetry) -> f64 {
    let layout = Layout::of_coefficients(coefficients);
    let sines = |turn: f64| -> f64 {
        let mut turned = coefficients.to_vec();
        rotate(&mut turned, turn);
        (1..=layout.order).map(|k| turned[layout.sine(k)].powi(2)).sum()
    };
    let axes = if symmetry.mirror { axes(coefficients, symmetry) } else { Vec::new() };
    axes.into_iter().min_by(|a, b| sines(*a).total_cmp(&sines(*b))).unwrap_or(0.0)
}

#[cfg(test)]
mod tests;
