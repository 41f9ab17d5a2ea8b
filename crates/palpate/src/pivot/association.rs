//! Which side of the object a segment felt: the rotation of its contact angles against those that are placed already. The readings of a
//! segment lie on a piece of the closed curve (r, d) of the shape; where another rotation lays them on it as well, that is a rival.

use std::borrow::Cow;
use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::pivot::calibration::{Measured, Reading, TOLD};
use crate::pivot::curve::curve;
use crate::pivot::smoother::{Problem, State, across, curve_row};
use crate::shape::ContactSupport;

/// Rotations that are tried over the whole turn: three degrees apart, for which each θ, which is free, makes up.
const ROTATIONS: usize = 120;

/// Angles at which the shape is held ready: half a degree apart, a multiple of the rotations. θ makes up for the rest.
const NODES: usize = 6 * ROTATIONS;

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

/// What is known of shape and constants before a segment is placed, in a table over the contact angle.
pub(super) struct Known<'a> {
    problem: &'a Problem<'a>,
    told: [f64; TOLD],
    /// Of the information on coefficients and open constants.
    factor: Cholesky<f64, Dyn>,
    nodes: Vec<Node>,
}

/// The shape at one contact angle.
struct Node {
    r_m: f64,
    d_m: f64,
    /// Derivatives of r and d by θ, in units of the noise, and the unit vector across them.
    slope: [f64; 2],
    across: [f64; 2],
    /// L⁻¹ times the derivative across the curve by the unknowns, that by the constants left out.
    column: Vec<f64>,
}

impl<'a> Known<'a> {
    /// From the most likely coefficients and constants of a state, whose contact angles do not matter, and the factorised information.
    pub fn new(problem: &'a Problem<'a>, state: &State, factor: Cholesky<f64, Dyn>) -> Self {
        let theta_rad: Vec<f64> = (0..NODES).map(|node| TAU * node as f64 / NODES as f64).collect();
        let noise = problem.noise;
        let node = |(contact, theta_rad): (ContactSupport, &f64)| {
            let slope = [-contact.d / noise.r_m, (contact.r - contact.v) / noise.d_m];
            let across = across(slope);
            let row = curve_row(*theta_rad, problem.order, [across[0] / noise.r_m, across[1] / noise.d_m]);
            let mut column = DVector::zeros(problem.unknowns());
            column.rows_mut(0, row.len()).copy_from(&row);
            let column = solved(&factor, column);
            Node { r_m: contact.r, d_m: contact.d, slope, across, column }
        };
        let nodes = curve(&state.coefficients, &theta_rad).into_iter().zip(&theta_rad).map(node).collect();
        Self { problem, told: state.told, factor, nodes }
    }

    /// All rotations at which the predictive density of a segment has a maximum, the best first. `theta_rad` are its contact angles up to
    /// the rotation.
    pub fn placements(&self, readings: &[Reading], theta_rad: &[f64]) -> Vec<Placement> {
        let stride = readings.len().div_ceil(COMPARED).max(1);
        let places = (stride / 2..readings.len()).step_by(stride);
        let (some, first): (Vec<Reading>, Vec<usize>) =
            places.map(|index| (readings[index], Self::nearest(theta_rad[index]))).unzip();
        let measured: Vec<Measured> = self.problem.stated.with_told(self.told).measured(&some).collect();
        let constants: Vec<[Vec<f64>; 2]> = measured.iter().map(|measured| self.by_constants(measured)).collect();
        let costs: Vec<f64> = (0..ROTATIONS)
            .map(|turn| {
                let at = |first: &usize| &self.nodes[(first + turn * (NODES / ROTATIONS)) % NODES];
                let nodes: Vec<&Node> = first.iter().map(at).collect();
                self.neg_log_predictive(&nodes, &measured, &constants)
            })
            .collect();
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

    /// L⁻¹ times the derivatives of r and d, in units of the noise, by the open constants.
    fn by_constants(&self, measured: &Measured) -> [Vec<f64>; 2] {
        let noise = self.problem.noise;
        [(measured.r_by, noise.r_m), (measured.d_by, noise.d_m)].map(|(by, noise_m)| {
            let mut column = DVector::zeros(self.problem.unknowns());
            let of_shape = 2 * self.problem.order + 1;
            for (place, &(constant, _)) in self.problem.open.iter().enumerate() {
                column[of_shape + place] = -by[constant] / noise_m;
            }
            if self.problem.open.is_empty() { Vec::new() } else { solved(&self.factor, column) }
        })
    }

    /// −ln of the predictive density of readings at these contact angles, each of them free.
    fn neg_log_predictive(&self, nodes: &[&Node], measured: &[Measured], constants: &[[Vec<f64>; 2]]) -> f64 {
        let (samples, noise) = (nodes.len(), self.problem.noise);
        let (mut left, mut turned) = (DVector::zeros(samples), 0.0);
        for (index, (node, measured)) in nodes.iter().zip(measured).enumerate() {
            let residual = [(node.r_m - measured.r_m) / noise.r_m, (node.d_m - measured.d_m) / noise.d_m];
            left[index] = node.across[0] * residual[0] + node.across[1] * residual[1];
            // A reading far from the curve is free to move along its tangent only for so long: what it would turn by counts too.
            let square = node.slope[0] * node.slope[0] + node.slope[1] * node.slope[1] + 1e-3;
            let turn = (node.slope[0] * residual[0] + node.slope[1] * residual[1]) / square;
            turned += (turn / TURN_SD_RAD).powi(2);
        }
        let columns: Vec<Cow<[f64]>> = nodes
            .iter()
            .zip(constants)
            .map(|(node, [by_r, by_d])| {
                let mut column = Cow::Borrowed(&node.column[..]);
                if !by_r.is_empty() {
                    let by = by_r.iter().zip(by_d).map(|(r, d)| node.across[0] * r + node.across[1] * d);
                    column.to_mut().iter_mut().zip(by).for_each(|(value, by)| *value += by);
                }
                column
            })
            .collect();
        // The lower triangle is what is read.
        let mut predicted = DMatrix::<f64>::identity(samples, samples);
        for column in 0..samples {
            for row in column..samples {
                let both = columns[row].iter().zip(columns[column].iter());
                predicted[(row, column)] += both.map(|(a, b)| a * b).sum::<f64>();
            }
        }
        let Some(factor) = Cholesky::new(predicted) else { return f64::INFINITY };
        let log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
        0.5 * left.dot(&factor.solve(&left)) + log_determinant + 0.5 * turned
    }
}

/// L⁻¹ times a column; not a number where there is none, so that no place is better for it.
fn solved(factor: &Cholesky<f64, Dyn>, mut column: DVector<f64>) -> Vec<f64> {
    if !factor.l_dirty().solve_lower_triangular_mut(&mut column) {
        column.fill(f64::NAN);
    }
    column.as_slice().to_vec()
}
