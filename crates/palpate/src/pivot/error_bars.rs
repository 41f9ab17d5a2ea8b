//! Error bars: the covariance of the shape after the best rotation over the felt boundary, and the standard deviation of each contact angle.

use nalgebra::{DMatrix, DVector};

use crate::pivot::smoother::{Linear, State};

/// Covariance of the unknowns where a common rotation is no error.
#[derive(Clone, Debug)]
pub(super) struct ErrorBars {
    order: usize,
    /// Of coefficients and open constants.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of each contact angle, radians.
    pub theta_sd_rad: Vec<f64>,
}

impl ErrorBars {
    /// At an optimum, whose boundary was felt at these angles (radians).
    pub fn new(linear: &Linear, state: &State, felt_rad: &[f64]) -> Option<Self> {
        let order = state.coefficients.len() / 2;
        let covariance = linear.factorised(&state.coefficients, 0.0)?.inverse();
        let unknowns = covariance.nrows();
        // A change δ of the shape turned by α = gᵀδ is least over the felt boundary: g = Σ r' row / Σ r'².
        let (mut weight, mut square) = (DVector::zeros(unknowns), 0.0);
        for &theta in felt_rad {
            let slope = -crate::pivot::smoother::contact(&state.coefficients, theta)[1];
            weight += support_row(theta, order, unknowns) * slope;
            square += slope * slope;
        }
        let mut projection = DMatrix::identity(unknowns, unknowns);
        if square > 0.0 {
            // r(θ + α): the slope of the shape itself.
            let mut slope = DVector::zeros(unknowns);
            for k in 1..=order {
                slope[k] = k as f64 * state.coefficients[order + k];
                slope[order + k] = -(k as f64) * state.coefficients[k];
            }
            projection -= &slope * (weight / square).transpose();
        }
        let covariance = &projection * covariance * projection.transpose();
        let theta_sd_rad = angles(linear, state, &covariance, order);
        Some(Self { order, covariance, theta_sd_rad })
    }

    /// Standard deviation of r(θ), metres.
    pub fn r_sd_m(&self, theta_rad: f64) -> f64 {
        let row = support_row(theta_rad, self.order, self.covariance.nrows());
        (&self.covariance * &row).dot(&row).max(0.0).sqrt()
    }

    /// Standard deviation of the radius of curvature v(θ), metres.
    pub fn v_sd_m(&self, theta_rad: f64) -> f64 {
        let mut row = support_row(theta_rad, self.order, self.covariance.nrows());
        for k in 1..=self.order {
            let bends = 1.0 - (k * k) as f64;
            row[k] *= bends;
            row[self.order + k] *= bends;
        }
        (&self.covariance * &row).dot(&row).max(0.0).sqrt()
    }

    /// Covariance of the coefficients alone, row by row, square metres.
    pub fn of_shape(&self) -> Vec<f64> {
        let unknowns = 2 * self.order + 1;
        self.covariance.view((0, 0), (unknowns, unknowns)).iter().copied().collect()
    }
}

/// dr/d(unknowns) at θ.
fn support_row(theta: f64, order: usize, unknowns: usize) -> DVector<f64> {
    let mut row = DVector::zeros(unknowns);
    row[0] = 1.0;
    for k in 1..=order {
        let (sin, cos) = (k as f64 * theta).sin_cos();
        row[k] = cos;
        row[order + k] = sin;
    }
    row
}

/// Standard deviations of the contact angles: what their own readings leave, and what shape and constants add.
fn angles(linear: &Linear, state: &State, covariance: &DMatrix<f64>, order: usize) -> Vec<f64> {
    let unknowns = covariance.nrows();
    let mut row = DVector::zeros(unknowns);
    state
        .theta_rad
        .iter()
        .zip(&linear.slopes)
        .zip(&linear.constants)
        .map(|((theta, slope), constants)| {
            let scale = linear.scales;
            let square = slope[0] * slope[0] + slope[1] * slope[1] + 1e-3;
            let along = [slope[0] / scale[0], slope[1] / scale[1]];
            row[0] = along[0];
            for k in 1..=order {
                let (sin, cos) = (k as f64 * theta).sin_cos();
                row[k] = along[0] * cos + along[1] * k as f64 * sin;
                row[order + k] = along[0] * sin - along[1] * k as f64 * cos;
            }
            for (place, by) in constants.iter().enumerate() {
                row[2 * order + 1 + place] = -(along[0] * by[0] + along[1] * by[1]);
            }
            (1.0 / square + (covariance * &row).dot(&row).max(0.0) / (square * square)).sqrt()
        })
        .collect()
}
