//! The predictive shape, a Gaussian over the coefficients, and the predictive (marginal) likelihood of one sample at an
//! orientation: −2 ln p = eᵀS⁻¹e + ln det S with S = 1 + JΣJᵀ (`docs/theory.md`, section on the decoded motion). Boundary that
//! was hardly felt can explain a sample as well, at the price of its uncertainty.

use crate::estimate::association::candidates::minima;
use crate::estimate::association::transitions::near;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::combine;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::table::SupportTable;
use crate::estimate::solver::gauss_newton::{Fit, Smoother};
use crate::mechanics::Forces;
use crate::mechanics::force_model::{ForceModel, MotionState};
use crate::palms::Contacts;
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::f64::consts::TAU;

/// Other orientations of a sample that are reported at most: every one of them costs a fit.
const OTHER_ORIENTATIONS: usize = 4;

/// Normal angles at which the spread of r and d is tabulated: a cosine of 48 waves is linear between two of them to a hundredth.
const SPREAD_ENTRIES: usize = 1024;

/// Directions of the shape that are left out of its spread may move d by this share of the noise, together.
const LEFT_OUT: f64 = 0.03;

/// The posterior of the shape given some of the samples, tabulated: it is asked for thousands of orientations.
pub(crate) struct PredictiveShape {
    table: SupportTable,
    /// r and d over the circle as Σ of independent unit normal variables: entry, then r's shares of all, then d's.
    spread: Vec<f64>,
    /// Number of these variables.
    rank: usize,
    noise: Noise,
}

impl PredictiveShape {
    /// The posterior at a fit, given these samples. `None` when they do not determine it.
    pub fn from(measurements: &Measurements, fit: &Fit) -> Option<Self> {
        let belief = Smoother::new(measurements, fit.order, fit.noise, fit.prior).belief(&fit.estimate)?;
        let covariance = belief.covariance()?;
        Some(Self::new(belief.mean.as_slice(), &covariance, fit.noise))
    }

    fn new(coefficients: &[f64], covariance: &DMatrix<f64>, noise: Noise) -> Self {
        let layout = Layout::of_coefficients(coefficients);
        // Of b_k as of a_k; r moves by 1 for each metre of it, d by k.
        let effect = |index: usize| (if index <= layout.order { index } else { index - layout.order } as f64).max(1.0);
        let tolerance = LEFT_OUT * noise.sensor_m.min(noise.balance_m);
        let root = truncated_root(covariance, effect, tolerance * tolerance);
        let rank = root.ncols();
        let rows = DMatrix::from_fn(2 * SPREAD_ENTRIES, layout.unknowns(), |row, index| {
            let theta = TAU / SPREAD_ENTRIES as f64 * (row / 2) as f64;
            let (sin, cos) = (effect(index) * theta).sin_cos();
            match (index, row % 2) {
                (0, part) => 1.0 - part as f64,
                (_, 0) => {
                    if index <= layout.order {
                        cos
                    } else {
                        sin
                    }
                }
                _ => effect(index) * if index <= layout.order { sin } else { -cos },
            }
        });
        // Column-major: an entry's shares of r and d stand together.
        let spread = (root.transpose() * rows.transpose()).as_slice().to_vec();
        Self { table: SupportTable::new(coefficients), spread, rank, noise }
    }

    /// The shares of r (then of d) at a normal angle, by linear interpolation.
    fn shares_at(&self, theta: f64) -> [(&[f64], f64); 2] {
        let place = theta.rem_euclid(TAU) * (SPREAD_ENTRIES as f64 / TAU);
        let entry = (place as usize).min(SPREAD_ENTRIES - 1);
        let x = place - entry as f64;
        let shares = |entry: usize| &self.spread[2 * self.rank * entry..2 * self.rank * (entry + 1)];
        [(shares(entry), 1.0 - x), (shares((entry + 1) % SPREAD_ENTRIES), x)]
    }

    /// JΣJᵀ of the three residuals, in units of these weights.
    fn spread_of_residuals(&self, instant: &Instant, at: Contacts, psi: f64, weights: [f64; 3]) -> Matrix3<f64> {
        let forces = Forces::default().row(&MotionState::at_rest(instant.palms, at));
        let rows = [
            instant.palms.positions_row([weights[0], 0.0]),
            instant.palms.positions_row([0.0, weights[1]]),
            instant.palms.positions_row([0.0; 2]).plus(weights[2], &forces),
        ];
        let (theta1, theta2) = instant.contact_angles(psi);
        let [near1, near2] = [self.shares_at(theta1), self.shares_at(theta2)];
        let rank = self.rank;
        let [mut s00, mut s01, mut s02, mut s11, mut s12, mut s22] = [0.0; 6];
        let read = |near: &[(&[f64], f64); 2], index: usize| {
            let [(before, share), (after, other)] = near;
            share * before[index] + other * after[index]
        };
        for index in 0..rank {
            let (r1, r2) = (read(&near1, index), read(&near2, index));
            let (d1, d2) = (read(&near1, rank + index), read(&near2, rank + index));
            let [a, b, c] =
                std::array::from_fn(|j| rows[j].r[0] * r1 + rows[j].r[1] * r2 + rows[j].d[0] * d1 + rows[j].d[1] * d2);
            s00 += a * a;
            s01 += a * b;
            s02 += a * c;
            s11 += b * b;
            s12 += b * c;
            s22 += c * c;
        }
        Matrix3::new(s00, s01, s02, s01, s11, s12, s02, s12, s22)
    }

    /// −2 ln of the predictive density of a sample at an orientation, the shape integrated out, up to a constant.
    pub fn neg_log_predictive(&self, instant: &Instant, psi: f64) -> f64 {
        let at = self.table.contacts(instant, psi);
        let value = combine(instant, at).value;
        let weights = self.noise.weights(&Instant { balance_weight: 1.0, ..*instant });
        // In units of the noise; a contact that was not seen has rows of zeros and contributes nothing.
        let covariance = self.spread_of_residuals(instant, at, psi, weights) + Matrix3::identity();
        let missed = Vector3::from_fn(|j, _| weights[j] * value[j]);
        let Some(factor) = covariance.cholesky() else { return f64::INFINITY };
        let Some(independent) = factor.l().solve_lower_triangular(&missed) else { return f64::INFINITY };
        let [first, second, balance] = [independent[0], independent[1], independent[2]];
        let spread = 2.0 * factor.l_dirty().diagonal().iter().map(|l| l.ln()).sum::<f64>();
        // The innovation of the balance given both contacts follows Student's t, as everywhere.
        first * first + second * second + (STUDENT + 1.0) * (balance * balance / STUDENT).ln_1p() + spread
    }

    /// Margin (−2 ln of the ratio of predictive densities) of the orientation near `psi` over the most likely other one, and the
    /// most likely other orientations, best first.
    pub fn elsewhere(&self, instant: &Instant, psi: f64, period: f64) -> (f64, Vec<f64>) {
        let mut here = self.neg_log_predictive(instant, psi);
        let mut others = Vec::new();
        for (other, neg_log_predictive) in minima(psi, period, &|psi| self.neg_log_predictive(instant, psi)) {
            if near(psi, other, period) {
                here = here.min(neg_log_predictive);
            } else {
                others.push((other, neg_log_predictive));
            }
        }
        others.sort_by(|a, b| a.1.total_cmp(&b.1));
        others.truncate(OTHER_ORIENTATIONS);
        let margin = others.first().map_or(f64::INFINITY, |(_, neg_log_predictive)| neg_log_predictive - here);
        (margin, others.into_iter().map(|(psi, _)| psi).collect())
    }
}

/// A root R of a covariance, RRᵀ = Σ but for a rest with Σ effect² variance below `least`: Cholesky's with the largest pivot first,
/// which ends early where few directions are uncertain.
fn truncated_root(covariance: &DMatrix<f64>, effect: impl Fn(usize) -> f64, least: f64) -> DMatrix<f64> {
    let count = covariance.nrows();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    let mut left: Vec<f64> = covariance.diagonal().iter().copied().collect();
    let moves = |left: &[f64], index: usize| effect(index).powi(2) * left[index];
    while columns.len() < count && (0..count).map(|index| moves(&left, index)).sum::<f64>() > least {
        let largest = |a: &usize, b: &usize| moves(&left, *a).total_cmp(&moves(&left, *b));
        let Some(pivot) = (0..count).max_by(largest).filter(|&pivot| left[pivot] > 0.0) else { break };
        let length = left[pivot].sqrt();
        let column: Vec<f64> = (0..count)
            .map(|index| {
                let explained: f64 = columns.iter().map(|column| column[index] * column[pivot]).sum();
                (covariance[(index, pivot)] - explained) / length
            })
            .collect();
        left.iter_mut().zip(&column).for_each(|(left, entry)| *left = (*left - entry * entry).max(0.0));
        left[pivot] = 0.0;
        columns.push(column);
    }
    DMatrix::from_fn(count, columns.len(), |row, column| columns[column][row])
}

#[cfg(test)]
mod tests;
