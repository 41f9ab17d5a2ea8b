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
use crate::estimate::solver::normal_equations::{LARGEST_TURN, Normal, PSI_INFORMATION};
use crate::estimate::solver::posterior::Posterior;
use crate::estimate::solver::shape_given_motion::rows;
use crate::estimate::work::Work;

/// Newton steps that bring an orientation from that of the sample before to its minimum.
const SETTLING: usize = 4;

/// Samples that stay linearised where the shape is now; when there are so many, the older half is folded into the Gaussian for good.
const WINDOW: usize = 256;

/// Samples between two linearisations of all of them.
const RELINEARISED_EVERY: usize = 64;

/// A boundary is known where its standard deviation is below so many of those of a contact position.
const KNOWN_SDS: f64 = 3.0;

/// Effort of a fit to these samples: the Gaussian holds the shape next to its optimum.
const FITTING: StoppingCriteria = StoppingCriteria { iterations: 2, tolerance: 1e-9 };

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

fn is_finite(belief: &Posterior) -> bool {
    belief.mean.iter().chain(belief.information.iter()).all(|value| value.is_finite())
}

/// −2 ln of Student's t.
fn student(square: f64) -> f64 {
    (STUDENT + 1.0) * (square / STUDENT).ln_1p()
}

/// The Gaussian, with what is derived from it.
#[derive(Clone)]
pub(super) struct ShapeBelief {
    /// Given all samples but those of the window.
    base: Posterior,
    window: Vec<(Instant, f64)>,
    not_relinearised: usize,
    /// Given all of them.
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
        Some(Self {
            base: belief.clone(),
            window: Vec::new(),
            not_relinearised: 0,
            covariance: belief.covariance()?,
            belief,
            table: OnceCell::new(),
            noise,
            prior,
            work: Work::for_log(0, 1),
        })
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

    /// Whether the boundary at both contacts is known, so that only the right pose explains where they are.
    pub fn knows(&self, instant: &Instant, psi: f64) -> bool {
        let by_shape = rows(instant, psi, self.belief.layout.order);
        let weights = self.noise.weights(instant);
        [0, 1].into_iter().all(|contact| {
            let row = by_shape.column(contact);
            // One that was not seen tells nothing.
            weights[contact] > 0.0 && weights[contact] * (&self.covariance * row).dot(&row).sqrt() < KNOWN_SDS
        })
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
        self.not_relinearised += samples.len();
        if self.not_relinearised < RELINEARISED_EVERY {
            if let Some((belief, samples)) = self.given(&self.belief, samples) {
                self.window.extend(samples);
                self.believe(belief);
            }
            return;
        }
        self.not_relinearised = 0;
        let all = self.window.iter().copied().chain(samples).collect();
        if let Some((belief, window)) = self.given(&self.base, all) {
            self.window = window;
            self.believe(belief);
        }
        if self.window.len() >= WINDOW {
            let older = self.window.drain(..WINDOW / 2).collect();
            if let Some(base) = self.linearised(older) {
                self.base = base;
            }
        }
    }

    fn believe(&mut self, belief: Posterior) {
        if let Some(covariance) = belief.covariance() {
            (self.belief, self.covariance, self.table) = (belief, covariance, OnceCell::new());
        }
    }

    /// A Gaussian given some samples more, and these samples at the orientations that go with it; `None` where something is not finite.
    fn given(&self, prior: &Posterior, samples: Vec<(Instant, f64)>) -> Option<(Posterior, Vec<(Instant, f64)>)> {
        let (measurements, psi) = self.measurements(&samples);
        let plain = Smoother::new(&measurements, prior.layout.order, self.noise, self.prior);
        let smoother = Smoother { belief: Some(prior), ..plain };
        let estimate = smoother.run(self.coefficients().to_vec(), psi, FITTING);
        let information = smoother.linearise_without_convexity(&estimate.coefficients, &estimate.psi).matrix;
        let samples = samples.into_iter().zip(estimate.psi).map(|((instant, _), psi)| (instant, psi)).collect();
        let mean = DVector::from_vec(estimate.coefficients);
        let belief = Posterior { layout: prior.layout, mean, information };
        (estimate.cost.is_finite() && is_finite(&belief)).then_some((belief, samples))
    }

    /// The Gaussian of all samples before the window and of some more, linearised where the shape is now.
    fn linearised(&self, samples: Vec<(Instant, f64)>) -> Option<Posterior> {
        let (measurements, psi) = self.measurements(&samples);
        let plain = Smoother::new(&measurements, self.base.layout.order, self.noise, self.prior);
        let smoother = Smoother { belief: Some(&self.base), ..plain };
        let Normal { matrix, gradient, .. } = smoother.linearise_without_convexity(self.coefficients(), &psi);
        let step = matrix.clone().cholesky()?.solve(&gradient);
        let belief = Posterior { layout: self.base.layout, mean: &self.belief.mean - step, information: matrix };
        is_finite(&belief).then_some(belief)
    }

    /// Samples with the weights that their balance has here.
    fn measurements(&self, samples: &[(Instant, f64)]) -> (Measurements, Vec<f64>) {
        let weigh = |(instant, psi): &(Instant, f64)| {
            weighed(instant, residuals(instant, self.coefficients(), *psi).value[2], self.noise)
        };
        let instants = samples.iter().map(weigh).collect();
        (Measurements { instants, work: self.work.clone() }, samples.iter().map(|(_, psi)| *psi).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{PalmLimits, plan_turn};
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    const NOISE: Noise = Noise { sensor_m: 1e-4, balance_m: 1e-5 };

    /// A log of an egg with noise, and its orientations.
    fn felt() -> (Measurements, Vec<f64>, Vec<f64>) {
        let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
        let plan = plan_turn(&shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
        let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
        let start_psi_rad = plan.start_psi_rad;
        let options = SimulateOptions { touchpad, start_psi_rad, ..SimulateOptions::default() };
        let run = simulate(&shape, &plan.motion.sample(40.0).expect("possible"), &options).expect("possible");
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        (Measurements::new(&run.log, None), psi, shape.coefficients())
    }

    /// The optimum of the first `count` samples.
    fn optimum(measurements: &Measurements, psi: &[f64], start: &[f64], count: usize) -> (Posterior, Vec<f64>) {
        let first = measurements.of(measurements.instants[..count].to_vec());
        let smoother = Smoother::new(&first, 8, NOISE, Prior::new(0.03, 0.015));
        let effort = StoppingCriteria { iterations: 40, tolerance: 1e-12 };
        let estimate = smoother.run(start.to_vec(), psi[..count].to_vec(), effort);
        (smoother.belief(&estimate).expect("determined"), estimate.psi)
    }

    /// Distance of a shape from another in standard deviations of that, after the best rotation: root mean square over normal angles.
    fn distance_sds(of: &Posterior, coefficients: &[f64], felt: &[f64]) -> f64 {
        let covariance = of.covariance_over(felt).expect("determined");
        let off = DVector::from_row_slice(coefficients) - &of.mean;
        let rotation = of.layout.rotation(of.mean.as_slice());
        let rows: Vec<DVector<f64>> = felt.iter().map(|theta| of.layout.support_row(*theta)).collect();
        let turn = rows.iter().map(|row| row.dot(&off) * row.dot(&rotation)).sum::<f64>()
            / rows.iter().map(|row| row.dot(&rotation).powi(2)).sum::<f64>();
        let off = off - rotation * turn;
        let squares = rows.iter().map(|row| row.dot(&off).powi(2) / (&covariance * row).dot(row));
        (squares.sum::<f64>() / rows.len() as f64).sqrt()
    }

    /// Samples of the first optimum.
    const FIRST: usize = 600;

    #[test]
    fn folding_samples_one_block_after_the_other_gives_the_optimum_of_all() {
        let (measurements, psi, start) = felt();
        for after in [64, 600] {
            let (belief, settled) = optimum(&measurements, &psi, &start, FIRST);
            let mut shape = ShapeBelief::new(belief, NOISE, Prior::new(0.03, 0.015)).expect("determined");
            let mut newest = *settled.last().expect("an orientation");
            for block in measurements.instants[FIRST..FIRST + after].chunks(8) {
                let samples = block.iter().map(|instant| {
                    newest = shape.settled(instant, newest).psi;
                    (*instant, newest)
                });
                let samples = samples.collect();
                shape.fold(samples);
                assert!(shape.window.len() < WINDOW);
            }
            let (all, settled) = optimum(&measurements, &psi, shape.coefficients(), FIRST + after);
            let felt: Vec<f64> = measurements
                .instants
                .iter()
                .zip(&settled)
                .map(|(instant, psi)| instant.contact_angles(*psi).0)
                .collect();
            let distance = distance_sds(&all, shape.coefficients(), &felt);
            assert!(distance < 0.5, "{after} samples: {distance} standard deviations");
        }
    }

    #[test]
    fn what_is_no_number_is_left_out() {
        let (measurements, psi, start) = felt();
        let (belief, _) = optimum(&measurements, &psi, &start, 80);
        let mut shape = ShapeBelief::new(belief, NOISE, Prior::new(0.03, 0.015)).expect("determined");
        let before = shape.coefficients().to_vec();
        let bad = Instant { s1: f64::NAN, ..measurements.instants[80] };
        for _ in 0..RELINEARISED_EVERY {
            shape.fold(vec![(bad, psi[80])]);
        }
        assert_eq!(shape.coefficients(), before);
        assert!(shape.settled(&bad, psi[80]).psi.is_finite());
        assert!(!shape.elsewhere(&measurements.instants[80], psi[80]).is_empty());
    }
}
