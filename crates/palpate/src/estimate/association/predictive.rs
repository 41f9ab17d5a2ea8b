//! The predictive shape, a Gaussian over the coefficients, and the predictive (marginal) likelihood of one sample at an
//! orientation: −2 ln p = eᵀS⁻¹e + ln det S with S = 1 + JΣJᵀ (`docs/theory.md`, section on the decoded motion). Boundary that
//! was hardly felt can explain a sample as well, at the price of its uncertainty.

use crate::estimate::association::candidates::minima;
use crate::estimate::association::transitions::near;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::combine;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::{Noise, STUDENT};
use crate::estimate::model::table::{SupportTable, fraction_of_turn};
use crate::estimate::solver::gauss_newton::{Fit, PROJECTIONS, Smoother};
use crate::estimate::solver::normal_equations::{LARGEST_TURN, PSI_INFORMATION};
use crate::mechanics::Forces;
use crate::mechanics::force_model::{ForceModel, MotionState};
use crate::palms::Contacts;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::f64::consts::TAU;

/// Other orientations of a sample that are reported at most: every one of them costs a fit.
const OTHER_ORIENTATIONS: usize = 4;

/// Normal angles at which the spread of r and d is tabulated: for each harmonic (a cosine is linear between two of them to half a
/// hundredth), and at least.
const SPREAD_ENTRIES: usize = 32;
const LEAST_ENTRIES: usize = 1024;

/// Directions of the shape that are left out of its spread may move d by this share of the noise, together.
const LEFT_OUT: f64 = 0.03;

/// How a motion of a few samples is explained by a predictive shape: −2 ln of its likelihood is the sum of both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MotionMisfit {
    /// Squared distance, eᵀS⁻¹e.
    pub misfit: f64,
    /// ln det S.
    pub log_determinant: f64,
}

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

    /// The noise of the samples that it explains.
    pub fn noise(&self) -> Noise {
        self.noise
    }

    /// With this mean and covariance of the coefficients.
    pub fn new(coefficients: &[f64], covariance: &DMatrix<f64>, noise: Noise) -> Self {
        let layout = Layout::of_coefficients(coefficients);
        // Of b_k as of a_k; r moves by 1 for each metre of it, d by k.
        let effect = |index: usize| (if index <= layout.order { index } else { index - layout.order } as f64).max(1.0);
        let tolerance = LEFT_OUT * noise.sensor_m.min(noise.balance_m);
        let root = truncated_root(covariance, effect, tolerance * tolerance);
        let rank = root.ncols();
        let entries = (SPREAD_ENTRIES * layout.order).max(LEAST_ENTRIES);
        let waves: Vec<(f64, f64)> =
            (0..entries).map(|entry| (TAU * entry as f64 / entries as f64).sin_cos()).collect();
        let rows = DMatrix::from_fn(layout.unknowns(), 2 * entries, |index, column| {
            let (entry, k) = (column / 2, effect(index));
            let (sin, cos) = waves[entry * k as usize % entries];
            let (r, d) = if index <= layout.order { (cos, k * sin) } else { (sin, -k * cos) };
            match (index, column % 2) {
                (0, part) => 1.0 - part as f64,
                (_, 0) => r,
                _ => d,
            }
        });
        // Column-major: an entry's shares of r and d stand together.
        let spread = (root.transpose() * rows).as_slice().to_vec();
        Self { table: SupportTable::new(coefficients), spread, rank, noise }
    }

    /// The shares of r (then of d) at a normal angle, of the entries before and after it, each with its part in their linear interpolation.
    fn shares_at(&self, theta: f64) -> [(&[f64], f64); 2] {
        let width = 2 * self.rank;
        let entries = self.spread.len() / width;
        let place = fraction_of_turn(theta) * entries as f64;
        let entry = (place as usize).min(entries - 1);
        let x = place - entry as f64;
        let shares = |entry: usize| &self.spread[width * entry..width * (entry + 1)];
        [(shares(entry), 1.0 - x), (shares((entry + 1) % entries), x)]
    }

    /// Calls `visit` with what each independent variable adds to the three residuals, in units of these weights.
    fn for_each_share(
        &self,
        instant: &Instant,
        at: Contacts,
        psi: f64,
        weights: [f64; 3],
        mut visit: impl FnMut(usize, [f64; 3]),
    ) {
        let rank = self.rank;
        if rank == 0 {
            return;
        }
        let forces = Forces::default().row(&MotionState::at_rest(instant.palms, at));
        let rows = [
            instant.palms.positions_row([weights[0], 0.0]),
            instant.palms.positions_row([0.0, weights[1]]),
            instant.palms.positions_row([0.0; 2]).plus(weights[2], &forces),
        ];
        let (theta1, theta2) = instant.contact_angles(psi);
        let at1 = self.shares_at(theta1).map(|(shares, part)| (shares.split_at(rank), part));
        let at2 = self.shares_at(theta2).map(|(shares, part)| (shares.split_at(rank), part));
        let [((r1, d1), x1), ((r1_after, d1_after), y1)] = at1;
        let [((r2, d2), x2), ((r2_after, d2_after), y2)] = at2;
        let (r1_after, d1_after, r2_after, d2_after) =
            (&r1_after[..rank], &d1_after[..rank], &r2_after[..rank], &d2_after[..rank]);
        for index in 0..rank {
            let (r1, r2) = (x1 * r1[index] + y1 * r1_after[index], x2 * r2[index] + y2 * r2_after[index]);
            let (d1, d2) = (x1 * d1[index] + y1 * d1_after[index], x2 * d2[index] + y2 * d2_after[index]);
            visit(index, rows.each_ref().map(|row| row.r[0] * r1 + row.r[1] * r2 + row.d[0] * d1 + row.d[1] * d2));
        }
    }

    /// JΣJᵀ of the three residuals, in units of these weights.
    fn spread_of_residuals(&self, instant: &Instant, at: Contacts, psi: f64, weights: [f64; 3]) -> Matrix3<f64> {
        let [mut s00, mut s01, mut s02, mut s11, mut s12, mut s22] = [0.0; 6];
        self.for_each_share(instant, at, psi, weights, |_, [a, b, c]| {
            s00 += a * a;
            s01 += a * b;
            s02 += a * c;
            s11 += b * b;
            s12 += b * c;
            s22 += c * c;
        });
        Matrix3::new(s00, s01, s02, s01, s11, s12, s02, s12, s22)
    }

    /// Squared distance of a few samples from the predictive shape in some motion, every orientation and the shape free: eᵀS⁻¹e with
    /// S = 1 + JΣJᵀ + j jᵀ/p, where j are the derivatives by each orientation and p is the prior information on its change. Each round
    /// moves the orientations towards their optimum. Infinite where there is none.
    pub fn misfit_of_motion(&self, instants: &[Instant], psi: &mut [f64], rounds: usize) -> MotionMisfit {
        let rows = 3 * instants.len();
        // What each variable adds to all residuals, one variable after the other.
        let mut shares = vec![0.0; self.rank * rows];
        let (mut missed, mut slopes) = (DVector::zeros(rows), vec![[0.0; 3]; instants.len()]);
        let mut found = MotionMisfit { misfit: f64::INFINITY, log_determinant: 0.0 };
        for _ in 0..rounds {
            for (index, (instant, psi)) in instants.iter().zip(psi.iter_mut()).enumerate() {
                let weights = self.noise.weights(instant);
                for _ in 0..PROJECTIONS {
                    let at = combine(instant, self.table.contacts(instant, *psi));
                    let [value, slope] = [at.value, at.by_psi].map(|of| std::array::from_fn(|j| weights[j] * of[j]));
                    *psi -=
                        (dot(value, slope) / (dot(slope, slope) + PSI_INFORMATION)).clamp(-LARGEST_TURN, LARGEST_TURN);
                }
                let contacts = self.table.contacts(instant, *psi);
                let at = combine(instant, contacts);
                slopes[index] = std::array::from_fn(|j| weights[j] * at.by_psi[j]);
                for j in 0..3 {
                    missed[3 * index + j] = weights[j] * at.value[j];
                }
                self.for_each_share(instant, contacts, *psi, weights, |variable, share| {
                    shares[variable * rows + 3 * index..][..3].copy_from_slice(&share);
                });
            }
            let mut covariance = DMatrix::zeros(rows, rows);
            for share in shares.chunks_exact(rows) {
                for (column, factor) in share.iter().enumerate() {
                    let below = &mut covariance.as_mut_slice()[column * rows..][column..rows];
                    below.iter_mut().zip(&share[column..]).for_each(|(entry, other)| *entry += factor * other);
                }
            }
            for (index, slope) in slopes.iter().enumerate() {
                for (i, j) in (0..9).map(|entry| (entry / 3, entry % 3)) {
                    covariance[(3 * index + i, 3 * index + j)] +=
                        slope[i] * slope[j] / PSI_INFORMATION + f64::from(i == j);
                }
            }
            // Only its lower triangle is read.
            let Some(factor) = covariance.cholesky() else {
                return MotionMisfit { misfit: f64::INFINITY, log_determinant: 0.0 };
            };
            let solved = factor.solve(&missed);
            let log_determinant = 2.0 * factor.l_dirty().diagonal().iter().map(|l| l.ln()).sum::<f64>();
            found = MotionMisfit { misfit: missed.dot(&solved), log_determinant };
            for (index, (psi, slope)) in psi.iter_mut().zip(&slopes).enumerate() {
                let along: f64 = (0..3).map(|j| slope[j] * solved[3 * index + j]).sum();
                *psi -= (along / PSI_INFORMATION).clamp(-LARGEST_TURN, LARGEST_TURN);
            }
        }
        found
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

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
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
