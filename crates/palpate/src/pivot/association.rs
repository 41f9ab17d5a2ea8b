//! Which side of the object a segment felt: the rotation of its contact angles against those that are placed already. The readings of a
//! segment lie on a piece of the closed curve (r, d) of the shape; where another rotation lays them on it as well, that is a rival.

use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix, Dyn};
use pulp::{Arch, Simd, WithSimd};

use crate::estimate::model::contact::{Supports, supports};
use crate::math::lanes::{LANES, Lanes, Number, sin_cos};
use crate::pivot::calibration::{Measured, PivotCalibration, Reading, TOLD};
use crate::pivot::smoother::{HELD_INFORMATION, Noise, Problem, State};

/// Rotations that are tried over the whole turn: three degrees apart, for which each θ, which is free, makes up.
const ROTATIONS: usize = 120;

/// Angles at which the shape is held ready: half a degree apart, a multiple of the rotations. θ makes up for the rest.
const NODES: usize = 6 * ROTATIONS;

/// Nodes of one rotation.
const PER_ROTATION: usize = NODES / ROTATIONS;

/// Nodes that follow each other by one rotation, and the first of them again, so that eight of them are always side by side.
const ROW: usize = ROTATIONS + LANES;

/// Samples of a segment that are compared.
const COMPARED: usize = 14;

/// How far the closed form may be off, radians: half a step of the rotations and a few per cent of a turn.
const TURN_SD_RAD: f64 = 0.1;

/// One possible rotation of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    /// Added to the contact angles of the segment, radians in [0, 2π).
    pub rotation_rad: f64,
    /// −ln of the predictive density of its readings, in nats, up to a constant of the segment.
    pub cost: f64,
}

/// What is known of shape and constants before a segment is placed, in tables over the contact angle.
pub(super) struct Known {
    noise: Noise,
    stated: PivotCalibration,
    /// Open constants.
    open: Vec<usize>,
    order: usize,
    /// Of the information on coefficients and open constants.
    lower: DMatrix<f64>,
    /// A table for each of: r and d, metres, their derivatives by θ in units of the noise, the unit vector across them, and L⁻¹ times the derivative
    /// across the curve by the unknowns, that by the constants left out.
    tables: Vec<[[f64; ROW]; PER_ROTATION]>,
}

/// Places among the tables.
const R: usize = 0;
const D: usize = 1;
const SLOPE: usize = 2;
const ACROSS: usize = 4;
const COLUMN: usize = 6;

impl Known {
    /// From the most likely coefficients and constants of a state, whose contact angles do not matter, and the factorised information.
    pub fn new(problem: &Problem, state: &State, factor: &Cholesky<f64, Dyn>) -> Self {
        let mut known = Self {
            noise: problem.noise,
            stated: problem.stated.with_told(state.told),
            open: problem.open.iter().map(|&(constant, _)| constant).collect(),
            order: problem.order,
            lower: factor.l(),
            tables: vec![[[0.0; ROW]; PER_ROTATION]; COLUMN + problem.unknowns()],
        };
        Arch::new().dispatch(Tabulating { known: &mut known, coefficients: &state.coefficients });
        known
    }

    /// All rotations at which the predictive density of a segment has a maximum, the best first. `theta_rad` are its contact angles up to
    /// the rotation.
    pub fn placements(&self, readings: &[Reading], theta_rad: &[f64]) -> Vec<Placement> {
        let stride = readings.len().div_ceil(COMPARED).max(1);
        let places = (stride / 2..readings.len()).step_by(stride);
        let (some, first): (Vec<Reading>, Vec<usize>) =
            places.map(|index| (readings[index], Self::nearest(theta_rad[index]))).unzip();
        let measured: Vec<Measured> = self.stated.measured(&some).collect();
        let constants: Vec<[Vec<f64>; 2]> = measured.iter().map(|measured| self.by_constants(measured)).collect();
        let costs =
            Arch::new().dispatch(Comparing { known: self, first: &first, measured: &measured, constants: &constants });
        let at = |turn: usize| costs[turn % ROTATIONS];
        let mut minima: Vec<Placement> = (0..ROTATIONS)
            .filter(|&turn| at(turn) <= at(turn + ROTATIONS - 1) && at(turn) < at(turn + 1) && at(turn).is_finite())
            .map(|turn| Placement { rotation_rad: TAU * turn as f64 / ROTATIONS as f64, cost: at(turn) })
            .collect();
        minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        minima
    }

    /// The node next to an angle.
    fn nearest(theta_rad: f64) -> usize {
        (theta_rad.rem_euclid(TAU) / TAU * NODES as f64).round() as usize % NODES
    }

    /// L⁻¹ times the derivatives of r and d, in units of the noise, by the open constants; empty where there are none.
    fn by_constants(&self, measured: &Measured) -> [Vec<f64>; 2] {
        [(measured.r_by, self.noise.r_m), (measured.d_by, self.noise.d_m)].map(|(by, noise_m): ([f64; TOLD], f64)| {
            let unknowns = self.lower.nrows();
            let mut column = vec![0.0; if self.open.is_empty() { 0 } else { unknowns }];
            let of_shape = 2 * self.order + 1;
            for row in of_shape..column.len() {
                let before: f64 = (of_shape..row).map(|other| self.lower[(row, other)] * column[other]).sum();
                column[row] = (-by[self.open[row - of_shape]] / noise_m - before) / self.lower[(row, row)];
            }
            column
        })
    }

    /// Eight nodes of a table, one rotation apart each, from the one that is so many rotations beyond a first one.
    #[inline(always)]
    fn nodes(&self, table: usize, first: usize, turn: usize) -> Lanes {
        let from = (first / PER_ROTATION + turn) % ROTATIONS;
        Lanes::loaded(&self.tables[table][first % PER_ROTATION][from..])
    }
}

/// [`Known::new`], eight angles in step.
struct Tabulating<'a> {
    known: &'a mut Known,
    coefficients: &'a [f64],
}

impl WithSimd for Tabulating<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { known, coefficients } = self;
        let Noise { r_m, d_m } = known.noise;
        let (order, unknowns) = (known.order, known.lower.nrows());
        let mut waves = vec![[Lanes::ZERO; 2]; order];
        let mut column = vec![Lanes::ZERO; unknowns];
        for residue in 0..PER_ROTATION {
            for turn in (0..ROW).step_by(LANES) {
                let node = |lane: usize| ((turn + lane) * PER_ROTATION + residue) % NODES;
                let (sin, cos) = sin_cos(Lanes::from_fn(|lane| TAU * node(lane) as f64 / NODES as f64));
                let Supports { r: [r], d: [d], v: [v] } =
                    supports(coefficients, [cos], [sin], |index, [cos], [sin]| waves[index] = [cos, sin]);
                let slope = [d * (-1.0 / r_m), (r - v) * (1.0 / d_m)];
                let length = (slope[0] * slope[0] + slope[1] * slope[1]).map(f64::sqrt);
                let over = |a: Lanes, none: f64| {
                    Lanes::from_fn(|lane| if length[lane] > 0.0 { a[lane] / length[lane] } else { none })
                };
                let across = [over(slope[1], 0.0), over(-slope[0], 1.0)];
                let [r_share, d_share] = [across[0] * (1.0 / r_m), across[1] * (1.0 / d_m)];
                column.fill(Lanes::ZERO);
                column[0] = r_share;
                for (index, [cos, sin]) in waves.iter().enumerate() {
                    let k_share = d_share * (index + 1) as f64;
                    column[index + 1] = r_share * *cos + k_share * *sin;
                    column[order + index + 1] = r_share * *sin - k_share * *cos;
                }
                // Forward substitution.
                for row in 0..unknowns {
                    let mut left = column[row];
                    for (other, value) in column[..row].iter().enumerate() {
                        left = left - *value * known.lower[(row, other)];
                    }
                    column[row] = left * (1.0 / known.lower[(row, row)]);
                }
                let values = [r, d, slope[0], slope[1], across[0], across[1]];
                for (table, value) in known.tables.iter_mut().zip(values.iter().chain(&column)) {
                    table[residue][turn..turn + LANES].copy_from_slice(&value.0);
                }
            }
        }
    }
}

/// −ln of the predictive density of readings at each of the rotations, each contact angle free; eight rotations in step.
struct Comparing<'a> {
    known: &'a Known,
    /// The node of each reading that is next to its angle before it is rotated.
    first: &'a [usize],
    measured: &'a [Measured],
    constants: &'a [[Vec<f64>; 2]],
}

impl WithSimd for Comparing<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<f64> {
        let Self { known, first, measured, constants } = self;
        let (samples, unknowns) = (first.len(), known.lower.nrows());
        let (r_m, d_m) = (known.noise.r_m, known.noise.d_m);
        let mut columns = vec![Lanes::ZERO; samples * unknowns];
        // L of what is predicted, row by row, and what is left of the residuals.
        let (mut factor, mut left) = ([[Lanes::ZERO; COMPARED]; COMPARED], [Lanes::ZERO; COMPARED]);
        let mut costs = Vec::with_capacity(ROTATIONS);
        for turn in (0..ROTATIONS).step_by(LANES) {
            let mut turned = Lanes::ZERO;
            for (index, (&first, measured)) in first.iter().zip(measured).enumerate() {
                let at = |table: usize| known.nodes(table, first, turn);
                let residual = [
                    (at(R) - Lanes::from(measured.r_m)) * (1.0 / r_m),
                    (at(D) - Lanes::from(measured.d_m)) * (1.0 / d_m),
                ];
                let (slope, across) = ([at(SLOPE), at(SLOPE + 1)], [at(ACROSS), at(ACROSS + 1)]);
                left[index] = across[0] * residual[0] + across[1] * residual[1];
                // A reading far from the curve is free to move along its tangent only for so long: what it would turn by counts too.
                let square = slope[0] * slope[0] + slope[1] * slope[1];
                let along = slope[0] * residual[0] + slope[1] * residual[1];
                let turn_sds = Lanes::from_fn(|lane| along[lane] / (square[lane] + HELD_INFORMATION) / TURN_SD_RAD);
                turned = turned + turn_sds * turn_sds;
                let column = &mut columns[index * unknowns..(index + 1) * unknowns];
                column.iter_mut().enumerate().for_each(|(place, value)| *value = at(COLUMN + place));
                let [by_r, by_d] = &constants[index];
                for ((value, by_r), by_d) in column.iter_mut().zip(by_r).zip(by_d) {
                    *value = *value + across[0] * *by_r + across[1] * *by_d;
                }
            }
            let mut determinant = Lanes::from(1.0);
            let mut squares = Lanes::ZERO;
            for row in 0..samples {
                let of_row = &columns[row * unknowns..(row + 1) * unknowns];
                for other in 0..=row {
                    let of_other = &columns[other * unknowns..(other + 1) * unknowns];
                    let mut sum = if other == row { Lanes::from(1.0) } else { Lanes::ZERO };
                    for (a, b) in of_row.iter().zip(of_other) {
                        sum = sum + *a * *b;
                    }
                    for (a, b) in factor[row].iter().zip(&factor[other]).take(other) {
                        sum = sum - *a * *b;
                    }
                    factor[row][other] = if other == row {
                        sum.map(f64::sqrt)
                    } else {
                        Lanes::from_fn(|lane| sum[lane] / factor[other][other][lane])
                    };
                }
                let mut solved = left[row];
                for before in 0..row {
                    solved = solved - factor[row][before] * left[before];
                }
                left[row] = Lanes::from_fn(|lane| solved[lane] / factor[row][row][lane]);
                squares = squares + left[row] * left[row];
                determinant = determinant * factor[row][row];
            }
            let cost = (squares + turned) * 0.5 + determinant.map(f64::ln);
            // What is no number is no place.
            costs.extend(cost.0.map(|cost| if cost.is_finite() { cost } else { f64::INFINITY }));
        }
        costs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::support;
    use crate::pivot::harmonic_prior::HarmonicPrior;
    use crate::pivot::smoother::{across, curve_row};
    use crate::shape::ContactSupport;
    use nalgebra::DVector;

    /// Readings of an arc, another shape than the one that is known, and what is known.
    fn example(open: Vec<(usize, f64)>) -> (Vec<Reading>, Vec<f64>, Problem<'static>, State) {
        let coefficients = vec![0.03, 0.004, -0.003, 0.0005, 0.002, 0.002, 0.0003];
        let theta_rad: Vec<f64> = (0..20).map(|index| 5.9 + 0.06 * f64::from(index)).collect();
        let reading = |theta: &f64| {
            let ContactSupport { r, d, .. } = support(&coefficients, *theta);
            Reading { along_m: 0.5, above_m: r, s_m: 0.5 - d }
        };
        let readings = theta_rad.iter().map(reading).collect();
        let problem = Problem {
            readings: &[],
            noise: Noise { r_m: 2e-5, d_m: 1e-4 },
            order: 3,
            size_m: 0.03,
            harmonics: HarmonicPrior::of_scale(0.01),
            stated: PivotCalibration::default(),
            open,
            between: None,
        };
        let known = coefficients.iter().map(|value| 1.002 * value).collect();
        (readings, theta_rad, problem, State { coefficients: known, told: [1e-5, 1e-3, 0.0], theta_rad: Vec::new() })
    }

    /// The information on the unknowns, some of it between them.
    fn factor(problem: &Problem) -> Cholesky<f64, Dyn> {
        let unknowns = problem.unknowns();
        let at = |i: usize, j: usize| {
            if i == j { 1e9 } else { 1e8 * ((3 * i.min(j) + 5 * i.max(j)) as f64).sin() / unknowns as f64 }
        };
        DMatrix::from_fn(unknowns, unknowns, at).cholesky().expect("it is positive definite")
    }

    #[test]
    fn a_segment_is_laid_where_it_was_felt() {
        let (readings, theta_rad, problem, state) = example(Vec::new());
        let known = Known::new(&problem, &state, &factor(&problem));
        let before: Vec<f64> = theta_rad.iter().map(|theta| theta - 2.0).collect();
        let placements = known.placements(&readings, &before);
        assert!((placements[0].rotation_rad - 2.0).abs() < TAU / ROTATIONS as f64, "{placements:?}");
    }

    /// As the density of a normal distribution has it, rotation by rotation.
    #[test]
    fn eight_rotations_are_as_each_of_them() {
        for open in [Vec::new(), vec![(0, 5e-4), (1, 0.01)]] {
            let (readings, theta_rad, problem, state) = example(open);
            let factor = factor(&problem);
            let known = Known::new(&problem, &state, &factor);
            let found = known.placements(&readings, &theta_rad);
            assert!(!found.is_empty());
            let (places, stated) = ((0..10).map(|place| 1 + 2 * place), problem.stated.with_told(state.told));
            for Placement { rotation_rad, cost } in found {
                let samples: Vec<(f64, Measured)> = places
                    .clone()
                    .map(|place| {
                        let node = Known::nearest(theta_rad[place]) as f64;
                        (TAU * node / NODES as f64 + rotation_rad, readings[place].measured(&stated))
                    })
                    .collect();
                let (mut columns, mut left) = (DMatrix::zeros(problem.unknowns(), 10), DVector::zeros(10));
                let mut turned = 0.0;
                for (index, (theta, measured)) in samples.iter().enumerate() {
                    let (residual, slope) = problem.missed(support(&state.coefficients, *theta), measured);
                    let across = across(slope);
                    left[index] = across[0] * residual[0] + across[1] * residual[1];
                    let square = slope[0].powi(2) + slope[1].powi(2) + HELD_INFORMATION;
                    turned += ((slope[0] * residual[0] + slope[1] * residual[1]) / square / TURN_SD_RAD).powi(2);
                    let shares = [across[0] / problem.noise.r_m, across[1] / problem.noise.d_m];
                    columns.view_mut((0, index), (7, 1)).copy_from(&curve_row(*theta, 3, shares));
                    for (place, &(constant, _)) in problem.open.iter().enumerate() {
                        columns[(7 + place, index)] =
                            -shares[0] * measured.r_by[constant] - shares[1] * measured.d_by[constant];
                    }
                }
                let predicted = DMatrix::identity(10, 10) + columns.transpose() * factor.solve(&columns);
                let solved = predicted.clone().cholesky().expect("positive definite").solve(&left);
                let expected = 0.5 * (left.dot(&solved) + predicted.determinant().ln() + turned);
                assert!((cost - expected).abs() < 1e-6 * expected.abs().max(1.0), "{cost} {expected}");
            }
        }
    }
}
