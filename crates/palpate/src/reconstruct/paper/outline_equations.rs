//! Least squares of the outline on integrated pieces: r and d = −r' at both contacts against the coefficients of the support
//! function, as the contact-point error of section 3 of Moll & Erdmann 2001. Turning a piece turns its normal equations, so that
//! many arrangements of pieces can be tried cheaply.

use crate::estimate::closed_form::Contact;
use crate::estimate::measurements::Measurements;
use crate::estimate::model::layout::Layout;
use crate::estimate::model::prior::Prior;
use nalgebra::{DMatrix, DVector};

/// Instants of a piece in its normal equations, about: many times the number of coefficients.
const ROWS: usize = 300;

/// Prior information on the mean radius, in units of the size of the object: it only keeps the equations regular.
const RADIUS_INFORMATION: f64 = 1e-6;

/// Normal equations of the coefficients (a₀, a₁ … a_K, b₁ … b_K): those that minimise |rows · a − data|² / σ².
#[derive(Clone, Debug)]
pub(crate) struct OutlineEquations {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// |data|² / σ².
    square: f64,
}

impl OutlineEquations {
    /// The prior alone: harmonics that fall with the square of their number.
    pub fn prior(order: usize, prior: Prior) -> Self {
        let size = Layout::of_shape(order).unknowns();
        let mut normal = DMatrix::zeros(size, size);
        for k in 1..=order {
            let weight = ((k * k) as f64 / prior.scale_m).powi(2);
            normal[(k, k)] = weight;
            normal[(order + k, order + k)] = weight;
        }
        normal[(0, 0)] = RADIUS_INFORMATION / (prior.size_m * prior.size_m);
        Self { normal, right: DVector::zeros(size), square: 0.0 }
    }

    /// The contacts of a piece, each of r and d with the standard deviation `sd_m`.
    pub fn new(measurements: &Measurements, contacts: &[Contact], order: usize, sd_m: f64) -> Self {
        let size = Layout::of_shape(order).unknowns();
        let stride = contacts.len().div_ceil(ROWS).max(1);
        let weight = stride as f64 / (sd_m * sd_m);
        let (mut normal, mut right, mut square) = (DMatrix::zeros(size, size), DVector::zeros(size), 0.0);
        let mut rows = [DVector::zeros(size), DVector::zeros(size)];
        for (instant, contact) in measurements.instants.iter().zip(contacts).step_by(stride) {
            let (theta1, theta2) = instant.contact_angles(contact.psi);
            for (theta, r, d) in [(theta1, contact.r1, contact.d1), (theta2, contact.r2, contact.d2)] {
                rows[0][0] = 1.0;
                rows[1][0] = 0.0;
                for k in 1..=order {
                    let number = k as f64;
                    let (sin, cos) = (number * theta).sin_cos();
                    (rows[0][k], rows[0][order + k]) = (cos, sin);
                    (rows[1][k], rows[1][order + k]) = (number * sin, -number * cos);
                }
                for (row, value) in rows.iter().zip([r, d]) {
                    normal.ger(weight, row, row, 1.0);
                    right.axpy(weight * value, row, 1.0);
                    square += weight * value * value;
                }
            }
        }
        Self { normal, right, square }
    }

    /// The sum of two normal equations.
    pub fn and(&self, other: &Self) -> Self {
        Self {
            normal: &self.normal + &other.normal,
            right: &self.right + &other.right,
            square: self.square + other.square,
        }
    }

    /// The same after ψ of all contacts was raised by `angle` (every θ falls by as much).
    pub fn turned(&self, angle: f64) -> Self {
        let order = self.right.len() / 2;
        let mut turned = self.clone();
        for k in 1..=order {
            let (sin, cos) = (angle * k as f64).sin_cos();
            // cos k(θ − α) = cos kθ cos kα + sin kθ sin kα, sin k(θ − α) = sin kθ cos kα − cos kθ sin kα.
            let pair = |a: f64, b: f64| (a * cos + b * sin, b * cos - a * sin);
            (turned.right[k], turned.right[order + k]) = pair(turned.right[k], turned.right[order + k]);
            for i in 0..=2 * order {
                (turned.normal[(k, i)], turned.normal[(order + k, i)]) =
                    pair(turned.normal[(k, i)], turned.normal[(order + k, i)]);
            }
            for i in 0..=2 * order {
                (turned.normal[(i, k)], turned.normal[(i, order + k)]) =
                    pair(turned.normal[(i, k)], turned.normal[(i, order + k)]);
            }
        }
        turned
    }

    /// The coefficients that fit best and the sum of squares that they leave. `None` where nothing can be solved.
    pub fn solve(&self) -> Option<(Vec<f64>, f64)> {
        let solution = self.normal.clone().cholesky()?.solve(&self.right);
        let left = self.square - self.right.dot(&solution);
        left.is_finite().then(|| (solution.iter().copied().collect(), left.max(0.0)))
    }

    /// The sum of squares that the best fit leaves; infinite where nothing can be solved.
    pub fn misfit(&self) -> f64 {
        self.solve().map_or(f64::INFINITY, |(_, left)| left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::{PalmMotion, PalmPair};
    use crate::shape::NamedShape;

    #[test]
    fn the_shape_comes_back_and_turns_with_its_piece() {
        let shape = NamedShape::Pebble.shape(0.03).expect("a positive size");
        let palms: Vec<(f64, PalmPair)> =
            PalmMotion::random(1, 10.0, 1.0).and_then(|motion| motion.sample(30.0)).expect("possible");
        let log = crate::Log {
            samples: palms.iter().map(|(time_s, palms)| crate::Sample::new(*time_s, *palms, 0.0, 0.0)).collect(),
        };
        let measurements = Measurements::new(&log, None);
        // Any motion serves: balance does not enter here.
        let contacts: Vec<Contact> = palms
            .iter()
            .map(|(time_s, palms)| {
                let psi = 0.7 * time_s;
                let (theta1, theta2) = palms.contact_angles(psi);
                let (one, two) = (shape.at(theta1), shape.at(theta2));
                Contact { psi, r1: one.r, d1: one.d, r2: two.r, d2: two.d }
            })
            .collect();
        let prior = OutlineEquations::prior(8, Prior::new(0.03, 0.015));
        let equations = OutlineEquations::new(&measurements, &contacts, 8, 1e-6);
        for angle in [0.0, 1.1] {
            let (coefficients, _) = equations.turned(angle).and(&prior).solve().expect("solvable");
            let found = crate::shape::SupportFunction::from_coefficients(&coefficients);
            for step in 0..20 {
                let theta = 0.3 * f64::from(step);
                let off = found.at(theta - angle).r - shape.at(theta).r;
                assert!(off.abs() < 1e-3 * 0.03, "{off}");
            }
        }
    }
}
