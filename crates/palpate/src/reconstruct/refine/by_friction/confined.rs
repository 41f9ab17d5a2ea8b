//! Centre of mass and friction as the intervals of contacts that stick confine them, where the equations of those that slide tell less.
//!
//! The normal equations of an optimum know only what vanishes; that a moment vanishes *somewhere* within a cone is no equation. Both are compared with
//! form and motion as they are: the axes along which the posterior of the intervals ([`posterior`](crate::estimate::friction::posterior)) is narrower
//! than that of the equations get the information that these lack.

use super::Settled;
use crate::estimate::coverage::{NODES, felt_nodes};
use crate::estimate::friction::posterior::{Given, second_moments};
use crate::estimate::friction::problem::{BESIDES_SHAPE, Unknowns, of_sample};
use crate::estimate::friction::smoother::Optimum;
use crate::estimate::model::layout::Layout;
use crate::estimate::solver::posterior::Posterior;
use nalgebra::{DVector, Matrix4};
use std::f64::consts::TAU;

/// Standard deviations of the posterior of what the samples confine, over what it would be if none of them shared their errors of form and motion.
const SHARED_ERRORS: f64 = 3.0;

impl Settled {
    /// Adds to the normal equations what the intervals tell beyond them.
    pub(super) fn confine(&mut self) {
        if let Some(axes) = self.confined_axes() {
            axes.into_iter().for_each(|(axis, information)| self.optimum.eliminated.inform(&axis, information));
        }
    }

    /// Linear functions of the dense unknowns, and the information on each that the equations lack. `None` where no sample slides on both palms.
    fn confined_axes(&self) -> Option<Vec<(DVector<f64>, f64)>> {
        let Optimum { unknowns, eliminated, corrected, inflation, .. } = &self.optimum;
        if !self.slides_on_both() {
            return None;
        }
        let [of_shape, dense] = [unknowns.coefficients.len(), eliminated.information().nrows()];
        // The support function about the centre of mass falls as that moves.
        let directions = [(1, -1.0), (1 + of_shape / 2, -1.0), (of_shape, 1.0), (of_shape + 1, 1.0)];
        let information = eliminated.information();
        let of_equations = Matrix4::from_fn(|i, j| {
            let ((i, sign), (j, other)) = (directions[i], directions[j]);
            sign * other * information[(i, j)] / inflation
        });
        let (given_dense, samples) = (eliminated.given_dense(), unknowns.psi.len());
        let psi_sd: Vec<f64> =
            (0..samples).map(|index| given_dense.variance(of_sample(samples, index)).max(0.0).sqrt()).collect();
        let given = Given {
            measurements: &corrected.measurements,
            coefficients: &unknowns.coefficients,
            friction: unknowns.friction,
            psi: &unknowns.psi,
            psi_sd: &psi_sd,
            regimes: &self.regimes,
        };
        let covariance = of_equations.try_inverse()?;
        let of_intervals = SHARED_ERRORS.powi(2) * second_moments(&given, &covariance)?;
        let inverse = covariance.cholesky()?.l().try_inverse()?;
        let whitened = (inverse * of_intervals * inverse.transpose()).symmetric_eigen();
        let rows = self.optimum.center_and_friction()?;
        let axes = whitened.eigenvalues.iter().zip(whitened.eigenvectors.column_iter());
        let axis = |vector: nalgebra::VectorView4<f64>| {
            let shares = inverse.transpose() * vector;
            rows.iter().zip(shares.iter()).fold(DVector::zeros(dense), |sum, (row, share)| sum + row * *share)
        };
        let lacking = axes.filter(|(ratio, _)| **ratio < 1.0);
        Some(lacking.map(|(ratio, vector)| (axis(vector), (1.0 / ratio - 1.0) * inflation)).collect())
    }
}

impl Optimum {
    /// The rows of the place of the centre of mass in the felt form, metres, and of both coefficients of friction.
    pub(super) fn center_and_friction(&self) -> Option<[DVector<f64>; 4]> {
        let Unknowns { coefficients, psi, .. } = &self.unknowns;
        let felt: Vec<f64> =
            felt_nodes(&self.corrected.measurements, psi).map(|node| TAU * node as f64 / NODES as f64).collect();
        let layout = Layout { order: coefficients.len() / 2, shared: BESIDES_SHAPE };
        let mut mean = DVector::zeros(layout.unknowns());
        mean.rows_mut(0, coefficients.len()).copy_from_slice(coefficients);
        let posterior = Posterior { layout, mean, information: self.eliminated.information().clone() };
        let [x, y] = posterior.translation_over(&felt)?;
        let friction = |palm: usize| {
            let mut row = DVector::zeros(layout.unknowns());
            row[coefficients.len() + palm] = 1.0;
            row
        };
        // The support function about the centre of mass falls as that moves.
        Some([-x, -y, friction(0), friction(1)])
    }
}
