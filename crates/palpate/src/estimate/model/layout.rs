//! The order of the unknowns that all instants share: the coefficients (a₀, a₁ … a_K, b₁ … b_K) of the support function, followed
//! by the shared parameters of calibration and forces, of which there are none yet.

use nalgebra::{DMatrix, DVector};

/// The order of the unknowns that all instants share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Number of harmonics K.
    pub order: usize,
    /// Parameters besides the shape.
    pub shared: usize,
}

impl Layout {
    /// For a shape with K harmonics and nothing else.
    pub fn of_shape(order: usize) -> Self {
        Self { order, shared: 0 }
    }

    /// For the coefficients of a shape.
    pub fn of_coefficients(coefficients: &[f64]) -> Self {
        Self::of_shape(coefficients.len() / 2)
    }

    /// Number of unknowns.
    pub fn unknowns(self) -> usize {
        2 * self.order + 1 + self.shared
    }

    /// Index of a_k, k = 1 … K.
    pub fn cosine(k: usize) -> usize {
        k
    }

    /// Index of b_k, k = 1 … K.
    pub fn sine(self, k: usize) -> usize {
        self.order + k
    }

    /// r(θ) as a row: (1, cos kθ …, sin kθ …, 0 …).
    pub fn support_row(self, theta: f64) -> DVector<f64> {
        let mut row = DVector::zeros(self.unknowns());
        row[0] = 1.0;
        for k in 1..=self.order {
            let (sin, cos) = (theta * k as f64).sin_cos();
            row[Self::cosine(k)] = cos;
            row[self.sine(k)] = sin;
        }
        row
    }

    /// r'(θ) as a row.
    pub fn slope_row(self, theta: f64) -> DVector<f64> {
        let mut row = DVector::zeros(self.unknowns());
        for k in 1..=self.order {
            let (sin, cos) = (theta * k as f64).sin_cos();
            row[Self::cosine(k)] = -(k as f64) * sin;
            row[self.sine(k)] = k as f64 * cos;
        }
        row
    }

    /// The change of the unknowns when the shape turns by one radian: the coefficients of r'.
    pub fn rotation(self, coefficients: &[f64]) -> DVector<f64> {
        let mut rotation = DVector::zeros(self.unknowns());
        for k in 1..=self.order {
            rotation[Self::cosine(k)] = k as f64 * coefficients[self.sine(k)];
            rotation[self.sine(k)] = -(k as f64) * coefficients[Self::cosine(k)];
        }
        rotation
    }
}

/// Turns a shape by `angle` in its frame: r(θ) becomes r(θ − angle).
pub(crate) fn rotate(coefficients: &mut [f64], angle: f64) {
    let layout = Layout::of_coefficients(coefficients);
    for k in 1..=layout.order {
        let (sin, cos) = (angle * k as f64).sin_cos();
        let (cosine, sine) = (Layout::cosine(k), layout.sine(k));
        let (x, y) = (coefficients[cosine], coefficients[sine]);
        (coefficients[cosine], coefficients[sine]) = (x * cos - y * sin, x * sin + y * cos);
    }
}

/// The covariance of the coefficients of a shape in its frame turned by `angle`, as [`rotate`] turns it.
pub(crate) fn rotated_covariance(covariance: &DMatrix<f64>, angle: f64) -> DMatrix<f64> {
    let columns = |mut matrix: DMatrix<f64>| {
        matrix.column_iter_mut().for_each(|mut column| rotate(column.as_mut_slice(), angle));
        matrix
    };
    columns(columns(covariance.clone()).transpose())
}

/// Changes the number of harmonics: cuts, or pads with zeros.
pub(crate) fn coefficients_to_order(coefficients: &mut Vec<f64>, order: usize) {
    let old = Layout::of_coefficients(coefficients).order;
    if old == order {
        return;
    }
    let mut changed = vec![0.0; Layout::of_shape(order).unknowns()];
    changed[0] = coefficients[0];
    let kept = old.min(order);
    changed[1..=kept].copy_from_slice(&coefficients[1..=kept]);
    changed[order + 1..=order + kept].copy_from_slice(&coefficients[old + 1..=old + kept]);
    *coefficients = changed;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::SupportFunction;

    const COEFFICIENTS: [f64; 7] = [0.03, 0.002, -0.001, 0.0005, 0.003, 0.0007, -0.0004];

    #[test]
    fn the_row_of_the_support_function_gives_its_value() {
        let shape = SupportFunction::from_coefficients(&COEFFICIENTS);
        let row = Layout::of_shape(3).support_row(1.3);
        assert!((row.dot(&DVector::from_row_slice(&COEFFICIENTS)) - shape.at(1.3).r).abs() < 1e-16);
        let with_shared = Layout { order: 3, shared: 2 };
        assert_eq!(with_shared.unknowns(), 9);
        assert_eq!(with_shared.support_row(1.3).rows(0, 7), row);
        assert_eq!(with_shared.support_row(1.3).rows(7, 2).amax(), 0.0);
    }

    #[test]
    fn a_rotation_is_the_change_of_the_coefficients_in_a_small_turn() {
        let step = 1e-7;
        let mut turned = COEFFICIENTS;
        rotate(&mut turned, -step);
        let rotation = Layout::of_shape(3).rotation(&COEFFICIENTS);
        for index in 0..7 {
            let slope = (turned[index] - COEFFICIENTS[index]) / step;
            assert!((slope - rotation[index]).abs() < 1e-8, "{index}: {slope} {}", rotation[index]);
        }
        let shape = SupportFunction::from_coefficients(&COEFFICIENTS).rotated(0.7);
        let mut same = COEFFICIENTS;
        rotate(&mut same, 0.7);
        assert_eq!(shape.coefficients(), same);
        // Of one certain direction, the covariance is that direction's square.
        let direction = DVector::from_row_slice(&COEFFICIENTS);
        let turned = DVector::from_row_slice(&same);
        let covariance = rotated_covariance(&(&direction * direction.transpose()), 0.7);
        assert!((covariance - &turned * turned.transpose()).amax() < 1e-18);
    }
}
