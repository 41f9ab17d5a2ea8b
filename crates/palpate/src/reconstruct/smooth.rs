//! Maximum likelihood over all samples at once (`docs/theory.md`, maximum likelihood; none of it is in the paper).
//!
//! Unknown are the coefficients a of the support function and one orientation ψ per sample. Each ψ stands in the three
//! residuals of its own sample only, so a Gauss-Newton step eliminates it exactly: the rows of a sample are projected on the
//! complement of their derivative by ψ, which leaves two rows in a alone. The cost is O(N M²) with M = 2K + 1, and the
//! inverse of the reduced matrix is the posterior covariance of the shape.
//!
//! The whole problem in one line:
//! minimise Σᵢ [(ŝ1 − s1)² + (ŝ2 − s2)²]/σ² + g²/σ_b² + Σₖ k⁴(aₖ² + bₖ²)/c² + Σⱼ max(0, ε − v(θⱼ))²/σ_v².

mod near;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::problem::{Instant, Problem};
use super::residuals::{Linearised, Residuals, residuals};

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
    psi_slope: Vec<f64>,
    /// Squared norm of the weighted derivative of each sample's residuals by ψ.
    psi_information: Vec<f64>,
}

impl Normal {
    /// Derivative of ψ of one instant by the coefficients.
    pub fn psi_slope(&self, instant: usize) -> &[f64] {
        let unknowns = self.gradient.len();
        &self.psi_slope[instant * unknowns..(instant + 1) * unknowns]
    }

    /// Orientations after a step of the coefficients, given what each would turn by without one.
    fn turned(&self, psi: &[f64], offset: &[f64], step: &DVector<f64>) -> Vec<f64> {
        let turn = |i: usize| (offset[i] + long_dot(self.psi_slope(i), step.as_slice())).clamp(-0.3, 0.3);
        psi.iter().enumerate().map(|(i, psi)| psi + turn(i)).collect()
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

/// The sum of outer products of rows, each with its residual as the last element: the normal matrix, and in its last
/// row the gradient. Only the lower triangle (and a little above it) is kept.
struct RowSink {
    /// Length of a row with its residual, made even.
    width: usize,
    buffer: Vec<f64>,
    filled: usize,
    columns: Vec<f64>,
}

impl RowSink {
    /// Rows that are taken in at a time, so that each element of the sum is touched once for all of them.
    const BLOCK: usize = 4;

    fn new(unknowns: usize) -> Self {
        let width = (unknowns + 1).next_multiple_of(2);
        Self { width, buffer: vec![0.0; Self::BLOCK * width], filled: 0, columns: vec![0.0; width * width] }
    }

    /// Takes in the row that `write` writes, of as many elements as there are unknowns, and its residual.
    fn push(&mut self, unknowns: usize, residual: f64, write: impl FnOnce(&mut [f64])) {
        let row = &mut self.buffer[self.filled * self.width..(self.filled + 1) * self.width];
        write(&mut row[..unknowns]);
        row[unknowns] = residual;
        self.filled += 1;
        if self.filled == Self::BLOCK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.buffer[self.filled * self.width..].fill(0.0);
        self.filled = 0;
        let mut rows = self.buffer.chunks_exact(self.width);
        add_outer_products(&mut self.columns, self.width, std::array::from_fn(|_| rows.next().unwrap_or_default()));
    }

    fn finish(mut self, unknowns: usize) -> (DMatrix<f64>, DVector<f64>) {
        self.flush();
        let at = |row: usize, column: usize| self.columns[column * self.width + row];
        let mut matrix = DMatrix::zeros(unknowns, unknowns);
        for column in 0..unknowns {
            for row in column..unknowns {
                matrix[(row, column)] = at(row, column);
                matrix[(column, row)] = at(row, column);
            }
        }
        (matrix, DVector::from_fn(unknowns, |column, _| at(unknowns, column)))
    }
}

/// Adds the outer products of four rows (of even length) to the lower triangle of a matrix, given by its columns. All goes
/// in pairs of elements, as in the registers of every processor of today; so one element above the diagonal comes along.
/// (On its own, not inlined: the compiler then knows that rows and columns do not overlap, a quarter less work.)
#[inline(never)]
fn add_outer_products(columns: &mut [f64], width: usize, rows: [&[f64]; RowSink::BLOCK]) {
    let [first, second, third, fourth] = rows.map(|row| row[..width].as_chunks::<2>().0);
    for (index, column) in columns.chunks_exact_mut(width).enumerate() {
        let (start, i) = (index / 2, index % 2);
        let (f, s, t, q) = (first[start][i], second[start][i], third[start][i], fourth[start][i]);
        let target = &mut column.as_chunks_mut::<2>().0[start..];
        let rest = first[start..].iter().zip(&second[start..]).zip(&third[start..]).zip(&fourth[start..]);
        for (pair, (((a, b), c), d)) in target.iter_mut().zip(rest) {
            *pair = std::array::from_fn(|i| pair[i] + (f * a[i] + s * b[i] + t * c[i] + q * d[i]));
        }
    }
}

/// Everything that defines the cost, for one number of harmonics.
pub(super) struct Smoother<'a> {
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
        let columns = self.cosines.chunks_exact(half.max(1)).zip(self.sines.chunks_exact(half.max(1)));
        for ((a, b), (cosines, sines)) in a.iter().zip(b).zip(columns) {
            for (v, cosine) in common.iter_mut().zip(cosines) {
                *v += a * cosine;
            }
            for (v, sine) in opposite.iter_mut().zip(sines) {
                *v += b * sine;
            }
        }
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
        Self {
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

    /// The same over further samples, with the belief that others left of the shape (of the same order).
    pub fn with_belief(problem: &'a Problem, order: usize, noise: Noise, prior: Prior, belief: &'a Belief) -> Self {
        Self { belief: Some(belief), ..Self::new(problem, order, noise, prior) }
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

    /// Brings each ψ to the minimum of its own sample by a few Newton steps, and returns the cost there.
    fn settle(&self, coefficients: &[f64], psi: &mut [f64], rounds: usize) -> f64 {
        let mut cost = self.shape_cost(coefficients);
        for (instant, psi) in self.problem.instants.iter().zip(psi.iter_mut()) {
            let weights = self.noise.weights(instant);
            cost += settle_one(weights, psi, rounds, |psi| residuals(instant, coefficients, psi)).square;
        }
        cost
    }

    /// The normal equations at an estimate, with every ψ eliminated.
    pub fn linearise(&self, coefficients: &[f64], psi: &[f64]) -> Normal {
        let unknowns = 2 * self.order + 1;
        let count = self.problem.len();
        let mut sink = RowSink::new(unknowns);
        let mut linearised = Linearised::new(self.order);
        let mut psi_offset = vec![0.0; count];
        let mut psi_slope = vec![0.0; count * unknowns];
        let mut psi_information = vec![0.0; count];
        for (index, instant) in self.problem.instants.iter().enumerate() {
            let at = linearised.at(instant, coefficients, psi[index]);
            let w = self.noise.weights(instant);
            let e = [w[0] * at.value[0], w[1] * at.value[1], w[2] * at.value[2]];
            let p = [w[0] * at.by_psi[0], w[1] * at.by_psi[1], w[2] * at.by_psi[2]];
            let information = dot(p, p);
            psi_information[index] = information;
            let [first, second, along] = turned_frame(p);
            let weighted = |q: [f64; 3]| [q[0] * w[0], q[1] * w[1], q[2] * w[2]];
            for q in [first, second] {
                sink.push(unknowns, dot(q, e), |row| linearised.mixed_row(instant, weighted(q), row));
            }
            // Along its own derivative ψ takes up all but the share that one radian of freedom leaves.
            let slope = &mut psi_slope[index * unknowns..(index + 1) * unknowns];
            linearised.mixed_row(instant, weighted(along), slope);
            let left = (PSI_INFORMATION / (information + PSI_INFORMATION)).sqrt();
            sink.push(unknowns, left * dot(along, e), |row| {
                for (slot, value) in row.iter_mut().zip(slope.iter()) {
                    *slot = left * value;
                }
            });
            let scale = -information.sqrt() / (information + PSI_INFORMATION);
            psi_offset[index] = scale * dot(along, e);
            slope.iter_mut().for_each(|value| *value *= scale);
        }
        for (node, residual) in self.convexity.violations(coefficients) {
            sink.push(unknowns, residual, |row| self.convexity.row(node, row));
        }
        let (mut matrix, mut gradient) = sink.finish(unknowns);
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

/// One sample at a shape, its ψ settled.
struct SettledOne {
    at: Residuals,
    /// The sum of its weighted squares.
    square: f64,
    /// The last trial was no better and was taken back.
    taken_back: bool,
}

/// Brings ψ to the minimum of its own sample by a few Newton steps.
#[inline(always)]
fn settle_one(
    weights: [f64; 3],
    psi: &mut f64,
    rounds: usize,
    mut residuals_at: impl FnMut(f64) -> Residuals,
) -> SettledOne {
    let weighted = |at: &Residuals| {
        let (mut square, mut slope, mut curvature) = (0.0, 0.0, 0.0);
        for ((weight, value), by_psi) in weights.iter().zip(at.value).zip(at.by_psi) {
            let (e, p) = (weight * value, weight * by_psi);
            square += e * e;
            slope += e * p;
            curvature += p * p;
        }
        (square, slope, curvature)
    };
    let mut at = residuals_at(*psi);
    let (mut square, mut slope, mut curvature) = weighted(&at);
    for _ in 0..rounds {
        // Worth less than 1e-6 of a squared standard deviation: settled.
        if slope * slope <= 1e-6 * curvature || curvature <= 0.0 {
            break;
        }
        let moved = *psi - (slope / curvature).clamp(-0.1, 0.1);
        let there = residuals_at(moved);
        let next = weighted(&there);
        if next.0 >= square {
            return SettledOne { at, square, taken_back: true };
        }
        (*psi, at) = (moved, there);
        (square, slope, curvature) = next;
    }
    SettledOne { at, square, taken_back: false }
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

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The inner product of long vectors, in four sums that do not wait for each other.
fn long_dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Three orthonormal vectors, the last along `p` (any three, where p vanishes).
fn turned_frame(p: [f64; 3]) -> [[f64; 3]; 3] {
    let norm = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
    if norm <= 0.0 || !norm.is_finite() {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    // Householder reflection that carries p to the third axis; its other two columns span the complement.
    let sign = if p[2] < 0.0 { -1.0 } else { 1.0 };
    let u = [p[0] / norm, p[1] / norm, p[2] / norm + sign];
    let beta = 2.0 / (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    [
        [1.0 - beta * u[0] * u[0], -beta * u[0] * u[1], -beta * u[0] * u[2]],
        [-beta * u[0] * u[1], 1.0 - beta * u[1] * u[1], -beta * u[1] * u[2]],
        [p[0] / norm, p[1] / norm, p[2] / norm],
    ]
}

#[cfg(test)]
mod tests;
