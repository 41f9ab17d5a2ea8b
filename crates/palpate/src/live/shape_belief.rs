//! The shape as a Gaussian that new samples sharpen: an iterated information filter whose measurement update is the Gauss-Newton step of the batch
//! estimator with the Gaussian in place of the prior (`docs/theory.md`, online; Bell & Cathey 1993).

use std::cell::OnceCell;

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use crate::estimate::association::candidates::candidates;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::residuals;
use crate::estimate::model::noise::{Noise, STUDENT, Spread};
use crate::estimate::model::prior::Prior;
use crate::estimate::model::table::SupportTable;
use crate::estimate::solver::error_bars::pose_variances;
use crate::estimate::solver::gauss_newton::{Smoother, StoppingCriteria};
use crate::estimate::solver::normal_equations::{LARGEST_TURN, PSI_INFORMATION};
use crate::estimate::solver::posterior::Posterior;
use crate::estimate::solver::shape_given_motion::rows;
use crate::estimate::work::Work;

/// Newton steps that bring an orientation from that of the sample before to its minimum.
const SETTLING: usize = 4;

/// Effort of folding a few samples: the Gaussian holds the shape next to its optimum.
const FOLDING: StoppingCriteria = StoppingCriteria { iterations: 2, tolerance: 1e-9 };

/// An orientation of a sample, at the minimum of its misfit for one shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settled {
    pub psi: f64,
    /// Squared standard deviations by which contacts and balance are missed.
    pub misfit: f64,
}

/// The minimum next to `psi`.
pub(super) fn settled(instant: &Instant, coefficients: &[f64], noise: Noise, mut psi: f64) -> Settled {
    for _ in 0..SETTLING {
        let at = residuals(instant, coefficients, psi);
        let weights = noise.weights(&weighed(instant, at.value[2], noise));
        let (mut gradient, mut information) = (0.0, PSI_INFORMATION);
        for ((weight, value), by_psi) in weights.iter().zip(at.value).zip(at.by_psi) {
            gradient += weight * weight * value * by_psi;
            information += (weight * by_psi).powi(2);
        }
        let step = gradient / information;
        if step.is_finite() {
            psi -= step.clamp(-LARGEST_TURN, LARGEST_TURN);
        }
    }
    let value = residuals(instant, coefficients, psi).value;
    let weights = noise.weights(instant);
    let contacts = (weights[0] * value[0]).powi(2) + (weights[1] * value[1]).powi(2);
    Settled { psi, misfit: contacts + student((weights[2] * value[2]).powi(2)) }
}

/// An instant with the weight that a balance missed by `balance_m` has.
fn weighed(instant: &Instant, balance_m: f64, noise: Noise) -> Instant {
    let square = (instant.balance_weight * balance_m / noise.balance_m).powi(2);
    let balance_weight = instant.balance_weight * ((STUDENT + 1.0) / (STUDENT + square)).sqrt();
    Instant { balance_weight, ..*instant }
}

/// −2 ln of Student's t.
fn student(square: f64) -> f64 {
    (STUDENT + 1.0) * (square / STUDENT).ln_1p()
}

/// The Gaussian, with what is derived from it.
pub(super) struct ShapeBelief {
    belief: Posterior,
    covariance: DMatrix<f64>,
    table: OnceCell<SupportTable>,
    noise: Noise,
    prior: Prior,
    work: Work,
}

impl ShapeBelief {
    /// `None` where it does not determine the shape.
    pub fn new(belief: Posterior, noise: Noise, prior: Prior) -> Option<Self> {
        let covariance = belief.covariance()?;
        Some(Self { belief, covariance, table: OnceCell::new(), noise, prior, work: Work::for_log(0, 1) })
    }

    /// The coefficients at the mean.
    pub fn coefficients(&self) -> &[f64] {
        self.belief.mean.as_slice()
    }

    /// The Gaussian itself.
    pub fn posterior(&self) -> &Posterior {
        &self.belief
    }

    /// Period of the orientation, radians.
    pub fn period_rad(&self) -> f64 {
        self.prior.symmetry.period_rad()
    }

    /// The orientation next to `psi` that explains a sample best, with its misfit by what is known of the shape.
    pub fn settled(&self, instant: &Instant, psi: f64) -> Settled {
        let Settled { psi, .. } = settled(instant, self.coefficients(), self.noise, psi);
        Settled { psi, misfit: self.misfit(instant, psi) }
    }

    /// Squared distance of a sample from what is predicted: Gaussian contacts and a balance with Student's t, each with the variance that
    /// the shape leaves.
    fn misfit(&self, instant: &Instant, psi: f64) -> f64 {
        let value = residuals(instant, self.coefficients(), psi).value;
        let by_shape = rows(instant, psi, self.belief.layout.order);
        let spread = by_shape.tr_mul(&(&self.covariance * &by_shape));
        let weights = self.noise.weights(instant);
        let balance = (weights[2] * value[2]).powi(2) / (1.0 + weights[2].powi(2) * spread[(2, 2)]);
        // A contact that was not seen has no residual, and the variance of one.
        let of_contacts = Matrix2::from_fn(|i, j| {
            let own = if i == j { 1.0 } else { 0.0 };
            weights[i] * weights[j] * spread[(i, j)] + own
        });
        let missed = Vector2::new(weights[0] * value[0], weights[1] * value[1]);
        let contacts = of_contacts.cholesky().map_or(f64::INFINITY, |factor| missed.dot(&factor.solve(&missed)));
        contacts + student(balance)
    }

    /// Orientations that explain a sample, wherever they are.
    pub fn elsewhere(&self, instant: &Instant, psi: f64) -> Vec<Settled> {
        let table = self.table.get_or_init(|| SupportTable::new(self.coefficients()));
        let at = rows(instant, psi, self.belief.layout.order);
        let variance = |residual: usize| {
            let row = at.column(residual);
            (&self.covariance * row).dot(&row)
        };
        let spread = Spread {
            contact_m2: self.noise.sensor_m.powi(2) + variance(0).max(variance(1)),
            balance_m2: self.noise.balance_m.powi(2) + variance(2),
            balance_memory: 1.0,
        };
        let found = candidates(table, instant, spread, psi, self.period_rad());
        found.into_iter().map(|(psi, _)| self.settled(instant, psi)).collect()
    }

    /// Takes in samples at their orientations. What would make the Gaussian undetermined is left out.
    pub fn fold(&mut self, samples: Vec<(Instant, f64)>) {
        let (coefficients, noise) = (self.coefficients(), self.noise);
        let weigh = |(instant, psi): &(Instant, f64)| {
            weighed(instant, residuals(instant, coefficients, *psi).value[2], noise)
        };
        let instants = samples.iter().map(weigh).collect();
        let measurements = Measurements { instants, work: self.work.clone() };
        let psi = samples.into_iter().map(|(_, psi)| psi).collect();
        let plain = Smoother::new(&measurements, self.belief.layout.order, noise, self.prior);
        let smoother = Smoother { belief: Some(&self.belief), ..plain };
        let estimate = smoother.run(coefficients.to_vec(), psi, FOLDING);
        if !estimate.cost.is_finite() {
            return;
        }
        let information = smoother.linearise_without_convexity(&estimate.coefficients, &estimate.psi).matrix;
        let mean = DVector::from_vec(estimate.coefficients);
        let belief = Posterior { layout: self.belief.layout, mean, information };
        if belief.mean.iter().chain(belief.information.iter()).all(|value| value.is_finite())
            && let Some(covariance) = belief.covariance()
        {
            (self.belief, self.covariance, self.table) = (belief, covariance, OnceCell::new());
        }
    }

    /// Standard deviations of ψ (radians) and of the centre of mass (metres) at one sample, by a covariance of the shape.
    pub fn pose_sd(&self, instant: &Instant, psi: f64, covariance: &DMatrix<f64>) -> (f64, f64) {
        let at = residuals(instant, self.coefficients(), psi);
        let weights = self.noise.weights(&weighed(instant, at.value[2], self.noise));
        let by_shape = rows(instant, psi, self.belief.layout.order);
        let mut slope = DVector::zeros(by_shape.nrows());
        let mut information = PSI_INFORMATION;
        for (residual, row) in by_shape.column_iter().enumerate() {
            slope.axpy(-weights[residual].powi(2) * at.by_psi[residual], &row, 1.0);
            information += (weights[residual] * at.by_psi[residual]).powi(2);
        }
        let own = (slope / information, 1.0 / information);
        let (psi_variance, com_variance) =
            pose_variances(self.belief.layout, covariance, own, (instant, self.coefficients(), psi));
        (psi_variance.sqrt(), com_variance.sqrt())
    }
}
