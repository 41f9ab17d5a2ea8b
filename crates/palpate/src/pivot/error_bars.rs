//! Error bars: the covariance of the shape after the best rotation over the felt boundary, and the standard deviation of each contact angle.

use nalgebra::{DMatrix, DVector};

use crate::estimate::model::layout::Layout;
use crate::estimate::solver::posterior::Posterior;
use crate::pivot::smoother::{Linear, State, curve_row};

/// Covariance of the unknowns where a common rotation is no error.
#[derive(Clone, Debug)]
pub(super) struct ErrorBars {
    layout: Layout,
    /// Of coefficients and open constants.
    pub covariance: DMatrix<f64>,
    /// Standard deviation of each contact angle, radians.
    pub theta_sd_rad: Vec<f64>,
}

impl ErrorBars {
    /// At an optimum, whose boundary was felt at these angles (radians). What is believed of the motion between readings decides which side of d = 0 they
    /// are on, and how far an angle is known; it does not narrow the bars of the shape, which are those of the readings `alone`: how an object is dragged
    /// is no law.
    pub fn new(linear: &Linear, alone: &Linear, state: &State, felt_rad: &[f64]) -> Option<Self> {
        let layout = linear.layout(&state.coefficients);
        let mut mean = DVector::zeros(layout.unknowns());
        mean.rows_mut(0, state.coefficients.len()).copy_from_slice(&state.coefficients);
        let posterior = Posterior { layout, mean, information: alone.held(&state.coefficients) };
        let covariance = posterior.covariance_over(felt_rad)?;
        let theta_sd_rad = angles(linear, state, &covariance, layout.order);
        Some(Self { layout, covariance, theta_sd_rad })
    }

    /// Standard deviation of r(θ), metres.
    pub fn r_sd_m(&self, theta_rad: f64) -> f64 {
        let row = self.layout.support_row(theta_rad);
        (&self.covariance * &row).dot(&row).max(0.0).sqrt()
    }

    /// Standard deviation of the radius of curvature v(θ), metres.
    pub fn v_sd_m(&self, theta_rad: f64) -> f64 {
        let mut row = self.layout.support_row(theta_rad);
        for k in 1..=self.layout.order {
            let bends = 1.0 - (k * k) as f64;
            row[Layout::cosine(k)] *= bends;
            row[self.layout.sine(k)] *= bends;
        }
        (&self.covariance * &row).dot(&row).max(0.0).sqrt()
    }

    /// Covariance of the coefficients alone, row by row, square metres.
    pub fn of_shape(&self) -> Vec<f64> {
        let unknowns = Layout::of_shape(self.layout.order).unknowns();
        self.covariance.view((0, 0), (unknowns, unknowns)).iter().copied().collect()
    }
}

/// Standard deviations of the contact angles: what readings and the motion between them leave, and what shape and constants add.
fn angles(linear: &Linear, state: &State, covariance: &DMatrix<f64>, order: usize) -> Vec<f64> {
    let own = linear.angle_variances();
    if let Some(gains) = linear.angles_by_unknowns() {
        let spread = covariance * &gains;
        let added = gains.column_iter().zip(spread.column_iter()).map(|(gain, spread)| gain.dot(&spread).max(0.0));
        return own.iter().zip(added).map(|(own, added)| (own + added).sqrt()).collect();
    }
    let unknowns = covariance.nrows();
    let mut row = DVector::zeros(unknowns);
    let samples = state.theta_rad.iter().zip(&linear.told.slopes).zip(&linear.constants).zip(own);
    samples
        .map(|(((theta, slope), constants), own)| {
            let along = [slope[0] / linear.scales[0], slope[1] / linear.scales[1]];
            row.rows_mut(0, 2 * order + 1).copy_from(&curve_row(*theta, order, along));
            for (place, by) in constants.iter().enumerate() {
                row[2 * order + 1 + place] = -(along[0] * by[0] + along[1] * by[1]);
            }
            (own + (covariance * &row).dot(&row).max(0.0) * own * own).sqrt()
        })
        .collect()
}
