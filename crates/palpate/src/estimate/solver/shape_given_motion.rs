//! The shape at given orientations: contacts (eq. 3 of Moll & Erdmann 2001) and balance are linear in the coefficients of the support
//! function, so that the normal equations have their minimum in closed form, and equations of different samples add up. Where the samples
//! turn by ω, their equations N c = n turn along, N → R N Rᵀ and n → R n with R turning (a_k, b_k) by kω.

use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::contact::combine;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::palms::Contacts;
use nalgebra::{DMatrix, DVector};
use std::ops::AddAssign;

/// The normal equations of the coefficients at given orientations.
#[derive(Clone)]
pub(crate) struct ShapeGivenMotion {
    information: DMatrix<f64>,
    right: DVector<f64>,
    /// Squared residuals without a shape.
    square: f64,
}

impl ShapeGivenMotion {
    /// Those of the prior alone.
    pub fn of_prior(prior: Prior, order: usize) -> Self {
        let information = prior.standard_deviations(order).into_iter().map(|sd| 1.0 / (sd * sd));
        let information =
            DMatrix::from_diagonal(&DVector::from_iterator(Layout::of_shape(order).unknowns(), information));
        Self { right: DVector::zeros(information.nrows()), information, square: 0.0 }
    }

    /// Those of some samples alone.
    pub fn of_samples(measurements: &Measurements, psi: &[f64], samples: &[usize], order: usize, noise: Noise) -> Self {
        let mut sum = Self::of_nothing(order);
        for &index in samples {
            let instant = &measurements.instants[index];
            let rows = rows(instant, psi[index], order);
            let measured = [instant.s1, instant.s2, 0.0];
            for ((row, measured), weight) in rows.column_iter().zip(measured).zip(noise.weights(instant)) {
                sum.add_row(&row.into_owned(), measured, weight);
            }
        }
        sum
    }

    /// Those that say nothing.
    pub fn of_nothing(order: usize) -> Self {
        let unknowns = Layout::of_shape(order).unknowns();
        Self { information: DMatrix::zeros(unknowns, unknowns), right: DVector::zeros(unknowns), square: 0.0 }
    }

    /// Adds that the coefficients times `row` are `measured`, up to a standard deviation of one over the weight.
    pub fn add_row(&mut self, row: &DVector<f64>, measured: f64, weight: f64) {
        self.information.ger(weight * weight, row, row, 1.0);
        self.right.axpy(weight * weight * measured, row, 1.0);
        self.square += (weight * measured).powi(2);
    }

    /// The same with every orientation larger by `omega`, radians.
    pub fn turned(&self, omega: f64) -> Self {
        let order = Layout::of_coefficients(self.right.as_slice()).order;
        let layout = Layout::of_shape(order);
        let mut turned = self.clone();
        for k in 1..=order {
            let (sin, cos) = (k as f64 * omega).sin_cos();
            let (a, b) = (Layout::cosine(k), layout.sine(k));
            let turn = |of_a: f64, of_b: f64| (cos * of_a + sin * of_b, cos * of_b - sin * of_a);
            for i in 0..self.right.len() {
                let (of_a, of_b) = turn(turned.information[(a, i)], turned.information[(b, i)]);
                (turned.information[(a, i)], turned.information[(b, i)]) = (of_a, of_b);
            }
            for i in 0..self.right.len() {
                let (of_a, of_b) = turn(turned.information[(i, a)], turned.information[(i, b)]);
                (turned.information[(i, a)], turned.information[(i, b)]) = (of_a, of_b);
            }
            let (of_a, of_b) = turn(turned.right[a], turned.right[b]);
            (turned.right[a], turned.right[b]) = (of_a, of_b);
        }
        turned
    }

    /// The least sum of squares, and the coefficients that have it. `None` where they are not determined.
    pub fn minimum(&self) -> Option<(f64, Vec<f64>)> {
        let coefficients = self.information.clone().cholesky()?.solve(&self.right);
        Some((self.square - self.right.dot(&coefficients), coefficients.as_slice().to_vec()))
    }
}

impl AddAssign<&Self> for ShapeGivenMotion {
    fn add_assign(&mut self, other: &Self) {
        self.information += &other.information;
        self.right += &other.right;
        self.square += other.square;
    }
}

/// The predicted s1, s2 and balance of an instant as linear functions of the coefficients.
pub(crate) fn rows(instant: &Instant, psi: f64, order: usize) -> DMatrix<f64> {
    let layout = Layout::of_shape(order);
    let (theta1, theta2) = instant.contact_angles(psi);
    let mut rows = DMatrix::zeros(layout.unknowns(), 3);
    let blank = Instant { s1: 0.0, s2: 0.0, ..*instant };
    let mut put = |unknown: usize, r: [f64; 2], d: [f64; 2]| {
        let value = combine(&blank, Contacts { r, d, v: [0.0; 2] }).value;
        (0..3).for_each(|residual| rows[(unknown, residual)] = value[residual]);
    };
    put(0, [1.0; 2], [0.0; 2]);
    for k in 1..=order {
        let number = k as f64;
        let [(sin1, cos1), (sin2, cos2)] = [theta1, theta2].map(|theta| (number * theta).sin_cos());
        put(Layout::cosine(k), [cos1, cos2], [number * sin1, number * sin2]);
        put(layout.sine(k), [sin1, sin2], [-number * cos1, -number * cos2]);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::residuals;
    use crate::palms::PalmMotion;
    use crate::sensor::Touchpad;
    use crate::shape::NamedShape;
    use crate::simulate::{SimulateOptions, simulate};

    const NOISE: Noise = Noise { sensor_m: 1e-4, balance_m: 3e-5 };

    /// A log of a stone without noise, its true coefficients and motion.
    fn felt() -> (Measurements, Vec<f64>, Vec<f64>) {
        let shape = NamedShape::Stone.shape(0.03).expect("a positive size");
        let motion = PalmMotion::random(5, 20.0, 1.0).and_then(|motion| motion.sample(10.0)).expect("possible");
        let options = SimulateOptions { touchpad: Touchpad::ideal(), ..SimulateOptions::default() };
        let run = simulate(&shape, &motion, &options).expect("possible");
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        (Measurements::new(&run.log, None), shape.coefficients(), psi)
    }

    fn all(psi: &[f64]) -> Vec<usize> {
        (0..psi.len()).collect()
    }

    #[test]
    fn at_the_true_orientations_the_minimum_is_the_true_shape() {
        let (measurements, truth, psi) = felt();
        let order = truth.len() / 2;
        let mut sum = ShapeGivenMotion::of_prior(Prior::new(3e4, 1.5e4), order);
        sum += &ShapeGivenMotion::of_samples(&measurements, &psi, &all(&psi), order, NOISE);
        let (cost, found) = sum.minimum().expect("determined");
        assert!(cost.abs() < 1e-3, "{cost}");
        found.iter().zip(&truth).for_each(|(found, truth)| assert!((found - truth).abs() < 1e-7, "{found} {truth}"));
    }

    #[test]
    fn the_cost_is_that_of_the_residuals() {
        let (measurements, truth, mut psi) = felt();
        psi.iter_mut().enumerate().for_each(|(index, psi)| *psi += 0.1 * (index as f64).sin());
        let (order, prior) = (truth.len() / 2, Prior::new(0.03, 0.015));
        let mut sum = ShapeGivenMotion::of_prior(prior, order);
        sum += &ShapeGivenMotion::of_samples(&measurements, &psi, &all(&psi), order, NOISE);
        let (least, found) = sum.minimum().expect("determined");
        let cost = |coefficients: &[f64]| -> f64 {
            let of_instants = measurements.instants.iter().zip(&psi).map(|(instant, psi)| {
                let value = residuals(instant, coefficients, *psi).value;
                value.iter().zip(NOISE.weights(instant)).map(|(value, weight)| (value * weight).powi(2)).sum::<f64>()
            });
            let of_shape = coefficients.iter().zip(prior.standard_deviations(order)).map(|(c, sd)| (c / sd).powi(2));
            of_instants.sum::<f64>() + of_shape.sum::<f64>()
        };
        assert!((cost(&found) / least - 1.0).abs() < 1e-6, "{} {least}", cost(&found));
        for index in 0..found.len() {
            for step_m in [1e-5, -1e-5] {
                let mut moved = found.clone();
                moved[index] += step_m;
                assert!(cost(&moved) > least, "coefficient {index}");
            }
        }
    }

    #[test]
    fn the_equations_turn_with_the_orientations() {
        let (measurements, truth, psi) = felt();
        let of_samples =
            |psi: &[f64]| ShapeGivenMotion::of_samples(&measurements, psi, &all(psi), truth.len() / 2, NOISE);
        let here = of_samples(&psi);
        for omega in [0.3, -2.0, 5.0] {
            let turned = here.turned(omega);
            let direct = of_samples(&psi.iter().map(|psi| psi + omega).collect::<Vec<f64>>());
            let scale = direct.information.amax();
            assert!((&turned.information - &direct.information).amax() < 1e-10 * scale);
            assert!((&turned.right - &direct.right).amax() < 1e-10 * direct.right.amax());
            assert!((turned.square - direct.square).abs() < 1e-10 * direct.square);
        }
    }

    #[test]
    fn without_samples_nothing_is_determined() {
        let (measurements, _, psi) = felt();
        assert!(ShapeGivenMotion::of_samples(&measurements, &psi, &[], 4, NOISE).minimum().is_none());
    }
}
