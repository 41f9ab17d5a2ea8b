//! Maximum likelihood over all samples at once (`docs/theory.md`, maximum likelihood; none of it is in the paper).
//!
//! Unknown are the coefficients a of the support function and one orientation ψ per sample. Each ψ stands in the three
//! residuals of its own sample only, so a Gauss-Newton step eliminates it exactly: the rows of a sample are projected on the
//! complement of their derivative by ψ, which leaves two rows in a alone. The cost is O(N M²) with M = 2K + 1, and the
//! inverse of the reduced matrix is the posterior covariance of the shape.
//!
//! The whole problem in one line:
//! minimise Σᵢ [(ŝ1 − s1)² + (ŝ2 − s2)²]/σ² + g²/σ_b² + Σₖ k⁴(aₖ² + bₖ²)/c² + Σⱼ max(0, ε − v(θⱼ))²/σ_v².

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::problem::{Instant, Problem};
use super::residuals::{Harmonics, Residuals, residuals};

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

    /// Information on ψ of one instant from its own sample, the shape being known.
    pub fn psi_information(&self, instant: usize) -> f64 {
        self.psi_information[instant]
    }
}

/// Adds `rows`ᵀ `rows` to the upper triangle; four rows a time, so that the inner loop does eight operations per element.
struct RowSink {
    unknowns: usize,
    buffer: Vec<f64>,
    filled: usize,
    upper: Vec<f64>,
    gradient: Vec<f64>,
}

impl RowSink {
    const BLOCK: usize = 4;

    fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            buffer: vec![0.0; Self::BLOCK * unknowns],
            filled: 0,
            upper: vec![0.0; unknowns * unknowns],
            gradient: vec![0.0; unknowns],
        }
    }

    fn push(&mut self, residual: f64, row: impl Iterator<Item = f64>) {
        let start = self.filled * self.unknowns;
        for ((slot, gradient), value) in
            self.buffer[start..start + self.unknowns].iter_mut().zip(&mut self.gradient).zip(row)
        {
            *slot = value;
            *gradient += residual * value;
        }
        self.filled += 1;
        if self.filled == Self::BLOCK {
            self.flush();
        }
    }

    fn flush(&mut self) {
        let m = self.unknowns;
        self.buffer[self.filled * m..].fill(0.0);
        let (first, rest) = self.buffer.split_at(m);
        let (second, rest) = rest.split_at(m);
        let (third, fourth) = rest.split_at(m);
        for i in 0..m {
            let (w0, w1, w2, w3) = (first[i], second[i], third[i], fourth[i]);
            let target = &mut self.upper[i * m + i..(i + 1) * m];
            let (f, s, t, q) = (&first[i..], &second[i..], &third[i..], &fourth[i..]);
            for ((((slot, a), b), c), d) in target.iter_mut().zip(f).zip(s).zip(t).zip(q) {
                *slot += w0 * a + w1 * b + w2 * c + w3 * d;
            }
        }
        self.filled = 0;
    }

    fn finish(mut self) -> (DMatrix<f64>, DVector<f64>) {
        self.flush();
        let m = self.unknowns;
        let matrix = DMatrix::from_fn(m, m, |i, j| self.upper[i.min(j) * m + i.max(j)]);
        (matrix, DVector::from_vec(self.gradient))
    }
}

/// Everything that defines the cost, for one number of harmonics.
pub(super) struct Smoother<'a> {
    pub problem: &'a Problem,
    pub order: usize,
    pub noise: Noise,
    pub prior: Prior,
    convexity: Convexity,
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
    /// One row of v per node.
    rows: Vec<Vec<f64>>,
}

impl Convexity {
    fn new(order: usize, size_m: f64, nodes: usize) -> Self {
        let rows = (0..nodes)
            .map(|node| {
                let theta = std::f64::consts::TAU * node as f64 / nodes as f64;
                let mut row = vec![1.0; 2 * order + 1];
                for k in 1..=order {
                    let number = k as f64;
                    let (sin, cos) = (number * theta).sin_cos();
                    row[k] = (1.0 - number * number) * cos;
                    row[order + k] = (1.0 - number * number) * sin;
                }
                row
            })
            .collect();
        Self { margin_m: 8e-3 * size_m, sd_m: 5e-4 * size_m, rows }
    }

    /// The violated nodes: residual and row.
    fn violations<'b>(&'b self, coefficients: &'b [f64]) -> impl Iterator<Item = (f64, &'b Vec<f64>)> {
        self.rows.iter().filter_map(move |row| {
            let v: f64 = row.iter().zip(coefficients).map(|(a, b)| a * b).sum();
            (v < self.margin_m).then(|| ((self.margin_m - v) / self.sd_m, row))
        })
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
        self.convexity.rows.clear();
        self
    }

    fn shape_cost(&self, coefficients: &[f64]) -> f64 {
        let prior: f64 = match self.belief {
            Some(belief) => {
                let off = DVector::from_row_slice(coefficients) - &belief.mean;
                (&belief.information * &off).dot(&off)
            }
            None => {
                let sd = self.prior.standard_deviations(self.order);
                sd.iter().zip(coefficients).map(|(sd, value)| (value / sd).powi(2)).sum()
            }
        };
        let convexity: f64 = self.convexity.violations(coefficients).map(|(residual, _)| residual * residual).sum();
        prior + convexity
    }

    /// Brings each ψ to the minimum of its own sample by a few Newton steps, and returns the cost there.
    fn settle(&self, coefficients: &[f64], psi: &mut [f64], rounds: usize) -> f64 {
        let mut cost = self.shape_cost(coefficients);
        for (instant, psi) in self.problem.instants.iter().zip(psi.iter_mut()) {
            let weights = self.noise.weights(instant);
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
            let (mut square, mut slope, mut curvature) = weighted(&residuals(instant, coefficients, *psi));
            for _ in 0..rounds {
                // Worth less than 1e-6 of a squared standard deviation: settled.
                if slope * slope <= 1e-6 * curvature || curvature <= 0.0 {
                    break;
                }
                let moved = *psi - (slope / curvature).clamp(-0.1, 0.1);
                let next = weighted(&residuals(instant, coefficients, moved));
                if next.0 >= square {
                    break;
                }
                *psi = moved;
                (square, slope, curvature) = next;
            }
            cost += square;
        }
        cost
    }

    /// The normal equations at an estimate, with every ψ eliminated.
    pub fn linearise(&self, coefficients: &[f64], psi: &[f64]) -> Normal {
        let unknowns = 2 * self.order + 1;
        let count = self.problem.len();
        let mut sink = RowSink::new(unknowns);
        let mut harmonics = Harmonics::new(self.order);
        let mut rows = [vec![0.0; unknowns], vec![0.0; unknowns], vec![0.0; unknowns]];
        let mut psi_offset = vec![0.0; count];
        let mut psi_slope = vec![0.0; count * unknowns];
        let mut psi_information = vec![0.0; count];
        for (index, instant) in self.problem.instants.iter().enumerate() {
            let at = harmonics.linearise(instant, coefficients, psi[index], &mut rows);
            let w = self.noise.weights(instant);
            let e = [w[0] * at.value[0], w[1] * at.value[1], w[2] * at.value[2]];
            let p = [w[0] * at.by_psi[0], w[1] * at.by_psi[1], w[2] * at.by_psi[2]];
            let information = p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
            psi_information[index] = information;
            let [first, second, third] = turned_frame(p);
            // What ψ cannot take up: two whole rows, and of the third the share that one radian of freedom leaves.
            let left = (PSI_INFORMATION / (information + PSI_INFORMATION)).sqrt();
            for q in [first, second, third.map(|value| value * left)] {
                let f = [q[0] * w[0], q[1] * w[1], q[2] * w[2]];
                let row = rows[0].iter().zip(&rows[1]).zip(&rows[2]);
                sink.push(
                    q[0] * e[0] + q[1] * e[1] + q[2] * e[2],
                    row.map(|((a, b), c)| f[0] * a + f[1] * b + f[2] * c),
                );
            }
            let scale = -1.0 / (information + PSI_INFORMATION);
            let f = [scale * p[0] * w[0], scale * p[1] * w[1], scale * p[2] * w[2]];
            psi_offset[index] = scale * (p[0] * e[0] + p[1] * e[1] + p[2] * e[2]);
            let row = rows[0].iter().zip(&rows[1]).zip(&rows[2]);
            let slope = &mut psi_slope[index * unknowns..(index + 1) * unknowns];
            for (slot, ((a, b), c)) in slope.iter_mut().zip(row) {
                *slot = f[0] * a + f[1] * b + f[2] * c;
            }
        }
        for (residual, row) in self.convexity.violations(coefficients) {
            sink.push(residual, row.iter().map(|value| -value / self.convexity.sd_m));
        }
        let (mut matrix, mut gradient) = sink.finish();
        match self.belief {
            Some(belief) => {
                gradient += &belief.information * (DVector::from_row_slice(coefficients) - &belief.mean);
                matrix += &belief.information;
            }
            None => {
                for (index, sd) in self.prior.standard_deviations(self.order).iter().enumerate() {
                    matrix[(index, index)] += 1.0 / (sd * sd);
                    gradient[index] += coefficients[index] / (sd * sd);
                }
            }
        }
        Normal { matrix, gradient, psi_offset, psi_slope, psi_information }
    }

    /// Runs Gauss-Newton with Levenberg-Marquardt damping down to a minimum.
    pub fn run(&self, mut coefficients: Vec<f64>, mut psi: Vec<f64>, effort: Effort) -> Estimate {
        coefficients_to_order(&mut coefficients, self.order);
        let mut cost = self.settle(&coefficients, &mut psi, 2);
        let mut damping = 1e-4;
        for _ in 0..effort.iterations {
            let normal = self.linearise(&coefficients, &psi);
            let mut fell = None;
            for _ in 0..12 {
                let mut damped = normal.matrix.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] *= 1.0 + damping;
                }
                let Some(factor) = Cholesky::new(damped) else {
                    damping = (damping * 10.0).max(1e-8);
                    continue;
                };
                let step = -factor.solve(&normal.gradient);
                let moved: Vec<f64> = coefficients.iter().zip(step.iter()).map(|(a, b)| a + b).collect();
                let mut turned: Vec<f64> = psi
                    .iter()
                    .enumerate()
                    .map(|(i, psi)| {
                        let slope: f64 = normal.psi_slope(i).iter().zip(step.iter()).map(|(a, b)| a * b).sum();
                        psi + (normal.psi_offset[i] + slope).clamp(-0.3, 0.3)
                    })
                    .collect();
                let next = self.settle(&moved, &mut turned, 2);
                if next < cost {
                    fell = Some(cost - next);
                    (coefficients, psi, cost) = (moved, turned, next);
                    damping = (damping * 0.2).max(1e-12);
                    break;
                }
                damping *= 5.0;
                if !next.is_finite() && damping > 1e8 {
                    break;
                }
            }
            match fell {
                Some(fall) if fall > effort.tolerance * cost => {}
                _ => break,
            }
        }
        Estimate { coefficients, psi, cost }
    }

    /// Cholesky factor of the posterior information of the shape, at an optimum.
    pub fn factor(&self, normal: &Normal) -> Option<Cholesky<f64, Dyn>> {
        Cholesky::new(normal.matrix.clone())
    }
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
