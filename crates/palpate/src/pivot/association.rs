//! Which side of the object a segment felt: the rotation of its contact angles against those that are placed already. The readings of a
//! segment lie on a piece of the closed curve (r, d) of the shape; where another rotation lays them on it as well, that is a rival.

use std::f64::consts::TAU;

use nalgebra::{Cholesky, DMatrix, Dyn};

use crate::pivot::calibration::Reading;
use crate::pivot::smoother::{Problem, State, Told};

/// Rotations that are tried over the whole turn: three degrees apart, for which each θ, which is free, makes up.
const ROTATIONS: usize = 120;

/// Samples of a segment that are compared.
const COMPARED: usize = 14;

/// One possible rotation of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    /// Added to the contact angles of the segment, radians in [0, 2π).
    pub rotation_rad: f64,
    /// −ln of the predictive density of its readings, in nats, up to a constant of the segment.
    pub cost: f64,
}

/// What is known of shape and constants before a segment is placed: their most likely values and the factorised information.
pub(super) struct Known<'a> {
    pub problem: &'a Problem<'a>,
    /// Coefficients and constants; its contact angles do not matter.
    pub state: &'a State,
    pub factor: Cholesky<f64, Dyn>,
}

impl Known<'_> {
    /// All rotations at which the predictive density of a segment has a maximum, the best first. `theta_rad` are its contact angles up to
    /// the rotation.
    pub fn placements(&self, readings: &[Reading], theta_rad: &[f64]) -> Vec<Placement> {
        let stride = readings.len().div_ceil(COMPARED).max(1);
        let compared: Vec<usize> = (stride / 2..readings.len()).step_by(stride).collect();
        let some: Vec<Reading> = compared.iter().map(|&index| readings[index]).collect();
        let angles: Vec<f64> = compared.iter().map(|&index| theta_rad[index]).collect();
        let problem = Problem { readings: &some, between: None, ..self.problem.clone() };
        let costs: Vec<f64> = (0..ROTATIONS)
            .map(|turn| {
                let rotation = TAU * turn as f64 / ROTATIONS as f64;
                let theta_rad = angles.iter().map(|angle| angle + rotation).collect();
                self.neg_log_predictive(&problem, theta_rad)
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

    /// −ln of the predictive density of readings at these contact angles, each of them free.
    fn neg_log_predictive(&self, problem: &Problem, theta_rad: Vec<f64>) -> f64 {
        let state = State { theta_rad, ..self.state.clone() };
        let Told { residuals, slopes, mut columns, left, .. } = problem.told(&state);
        if !self.factor.l_dirty().solve_lower_triangular_mut(&mut columns) {
            return f64::INFINITY;
        }
        let samples = left.len();
        let predicted = DMatrix::identity(samples, samples) + columns.tr_mul(&columns);
        let Some(factor) = Cholesky::new(predicted) else { return f64::INFINITY };
        let log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
        // A reading far from the curve is free to move along its tangent only for so long: what it would turn by counts too.
        let turned: f64 = residuals
            .iter()
            .zip(&slopes)
            .map(|(residual, slope)| {
                let square = slope[0] * slope[0] + slope[1] * slope[1] + 1e-3;
                let turn = (slope[0] * residual[0] + slope[1] * residual[1]) / square;
                (turn / TURN_SD_RAD).powi(2)
            })
            .sum();
        0.5 * left.dot(&factor.solve(&left)) + log_determinant + 0.5 * turned
    }
}

/// How far the closed form may be off, radians: half a step of the rotations and a few per cent of a turn.
const TURN_SD_RAD: f64 = 0.1;
