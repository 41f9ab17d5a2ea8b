//! The Gaussian posterior of the unknowns that all instants share (`docs/theory.md`, error bars).
//!
//! A common rotation of shape and motion is not observable and is no error. It is either held fixed, where one Gaussian serves as
//! the prior of further samples, or taken out by inner constraints, as in geodesy: what is left after the best rotation over the
//! felt boundary is the projection P = 1 − ρ(ρᵀG)/(ρᵀGρ), where ρ are the coefficients of r' and G is the Gram matrix of the
//! basis over the felt boundary.

use nalgebra::{DMatrix, DVector};

use crate::estimate::model::layout::Layout;

/// A Gaussian over the shared unknowns, by its mean and its information (the inverse of the covariance).
#[derive(Clone, Debug)]
pub(crate) struct Posterior {
    pub layout: Layout,
    pub mean: DVector<f64>,
    pub information: DMatrix<f64>,
}

/// Information on a rotation that is held fixed, rad⁻²: a standard deviation of a thousandth of a radian.
const HELD: f64 = 1e6;

impl Posterior {
    /// The same with the rotation of the shape held fixed. `None` where something is not finite.
    pub fn holding_rotation(mut self) -> Option<Self> {
        let rotation = self.layout.rotation(self.mean.as_slice());
        let length = rotation.norm_squared();
        if length > 0.0 {
            self.information += &rotation * rotation.transpose() * (HELD / (length * length));
        }
        self.information.iter().all(|value| value.is_finite()).then_some(self)
    }

    /// −2 ln of the density at some coefficients, up to a constant.
    pub fn squared_distance(&self, coefficients: &[f64]) -> f64 {
        let off = DVector::from_row_slice(coefficients) - &self.mean;
        (&self.information * &off).dot(&off)
    }

    /// Half the derivative of [`Self::squared_distance`].
    pub fn gradient(&self, coefficients: &[f64]) -> DVector<f64> {
        &self.information * (DVector::from_row_slice(coefficients) - &self.mean)
    }

    /// The covariance. `None` where the information does not determine every unknown.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(self.information.clone().cholesky()?.inverse())
    }

    /// The covariance after the best rotation over the boundary at the normal angles `felt`.
    pub fn covariance_over(&self, felt: &[f64]) -> Option<DMatrix<f64>> {
        self.covariance_without(&DMatrix::from_columns(&[self.rotation()]), felt)
    }

    /// The same after the best rotation and translation: that of the form, wherever the centre of mass may be in it.
    pub fn covariance_of_form(&self, felt: &[f64]) -> Option<DMatrix<f64>> {
        self.covariance_without(&self.rotation_and_translation(), felt)
    }

    /// The rows of the best translation over that boundary, beside the best rotation: where the form lies about the centre of mass. `None` where too
    /// little is felt to tell one.
    pub fn translation_over(&self, felt: &[f64]) -> Option<[DVector<f64>; 2]> {
        let directions = self.rotation_and_translation();
        let weights = self.weights(&directions, felt);
        let rows = weights.tr_mul(&directions).try_inverse()? * weights.transpose();
        Some([1, 2].map(|row| rows.row(row).transpose()))
    }

    /// How the unknowns change with a rotation, and with a translation along either axis.
    fn rotation_and_translation(&self) -> DMatrix<f64> {
        let along = |harmonic: usize| {
            let mut translation = DVector::zeros(self.layout.unknowns());
            translation[harmonic] = 1.0;
            translation
        };
        // r grows by x cos θ + y sin θ.
        DMatrix::from_columns(&[self.rotation(), along(1), along(1 + self.layout.order)])
    }

    /// The covariance with the rotation that a linear function of the unknowns tells, by its row, taken out.
    pub fn covariance_turned_by(&self, row: &DVector<f64>) -> Option<DMatrix<f64>> {
        let inverse = self.covariance()?;
        Some(projected(
            inverse,
            &DMatrix::from_columns(&[self.rotation()]),
            &DMatrix::from_columns(std::slice::from_ref(row)),
        ))
    }

    fn rotation(&self) -> DVector<f64> {
        self.layout.rotation(self.mean.as_slice())
    }

    /// The covariance after the best steps along some directions, in the least squares of r at `felt`.
    fn covariance_without(&self, directions: &DMatrix<f64>, felt: &[f64]) -> Option<DMatrix<f64>> {
        Some(projected(self.covariance()?, directions, &self.weights(directions, felt)))
    }

    /// The Gram matrix of the basis over the boundary at `felt`, times these directions.
    fn weights(&self, directions: &DMatrix<f64>, felt: &[f64]) -> DMatrix<f64> {
        let mut weights = DMatrix::zeros(directions.nrows(), directions.ncols());
        for &theta in felt {
            let row = self.layout.support_row(theta);
            weights += &row * row.tr_mul(directions);
        }
        weights
    }

    /// The direction with the largest variance, of unit length, and the standard deviation along it. `None` when that is not
    /// finite.
    pub fn weakest_direction(&self) -> Option<(f64, DVector<f64>)> {
        let eigen = self.information.clone().symmetric_eigen();
        let (index, least) = eigen.eigenvalues.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let sd = 1.0 / least.max(0.0).sqrt();
        sd.is_finite().then(|| (sd, eigen.eigenvectors.column(index).into_owned()))
    }
}

/// P C Pᵀ with P = 1 − D (WᵀD)⁻¹ Wᵀ, the projection along the columns of D onto where those of W vanish; C where there is none.
fn projected(covariance: DMatrix<f64>, directions: &DMatrix<f64>, weights: &DMatrix<f64>) -> DMatrix<f64> {
    let Some(inverse) = weights.tr_mul(directions).try_inverse() else { return covariance };
    let projection =
        DMatrix::identity(covariance.nrows(), covariance.ncols()) - directions * inverse * weights.transpose();
    &projection * covariance * projection.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn posterior() -> Posterior {
        let layout = Layout::of_shape(2);
        let mean = DVector::from_vec(vec![0.03, 2e-3, 1e-3, -1e-3, 5e-4]);
        let root =
            DMatrix::from_fn(5, 5, |i, j| (1.3 * i as f64 + 0.7 * (j * j) as f64).sin() + f64::from(i == j) * 3.0);
        Posterior { layout, mean, information: &root * root.transpose() }
    }

    #[test]
    fn the_distance_is_least_at_the_mean_and_its_gradient_matches_differences() {
        let posterior = posterior();
        let at = [0.5, -0.2, 0.3, 0.1, -0.4];
        assert_eq!(posterior.squared_distance(posterior.mean.as_slice()), 0.0);
        let gradient = posterior.gradient(&at);
        for index in 0..5 {
            let moved = |step: f64| {
                let mut there = at;
                there[index] += step;
                posterior.squared_distance(&there)
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((slope - 2.0 * gradient[index]).abs() < 1e-6 * slope.abs().max(1.0));
        }
    }

    #[test]
    fn the_weakest_direction_is_an_eigenvector_with_the_largest_variance() {
        let posterior = posterior();
        let (sd, direction) = posterior.weakest_direction().expect("determined");
        let covariance = posterior.covariance().expect("determined");
        assert!((&covariance * &direction - &direction * (sd * sd)).amax() < 1e-9 * sd * sd);
        let largest = covariance.symmetric_eigen().eigenvalues.max();
        assert!((largest / (sd * sd) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_rotation_has_little_variance_when_held_and_none_when_projected_out() {
        let free = posterior();
        let rotation = free.layout.rotation(free.mean.as_slice());
        let unit = &rotation / rotation.norm();
        let along = |covariance: &DMatrix<f64>| (covariance * &unit).dot(&unit);
        let held = free.clone().holding_rotation().expect("finite");
        let before = along(&free.covariance().expect("determined"));
        assert!(along(&held.covariance().expect("determined")) < 1e-3 * before);
        // Over the whole circle the projection is orthogonal in the Gram matrix, which weighs all harmonics alike.
        let felt: Vec<f64> = (0..64).map(|node| std::f64::consts::TAU * f64::from(node) / 64.0).collect();
        assert!(along(&free.covariance_over(&felt).expect("determined")) < 1e-12 * before);
        // A translation has none when it is projected out as well, and the rotation that ψ tells has none of ψ.
        let of_form = free.covariance_of_form(&felt).expect("determined");
        assert!(along(&of_form) < 1e-12 * before && of_form[(1, 1)] < 1e-12 && of_form[(3, 3)] < 1e-12);
        assert!(free.covariance_over(&felt).expect("determined")[(1, 1)] > 1e-3);
        // Over any boundary, a translation is told as it is, and a rotation as none.
        let [x, y] = free.translation_over(&felt[..20]).expect("enough is felt");
        let moved = DVector::from_vec(vec![0.0, 0.2, 0.0, -0.1, 0.0]) + &rotation * 0.3;
        assert!((x.dot(&moved) - 0.2).abs() < 1e-9 && (y.dot(&moved) + 0.1).abs() < 1e-9);
        let psi = DVector::from_vec(vec![0.3, -0.2, 0.5, 0.1, 0.7]);
        let turned = free.covariance_turned_by(&psi).expect("determined");
        assert!((&turned * &psi).dot(&psi) < 1e-12 && along(&turned) > 1e-3);
        let mut undetermined = free;
        undetermined.information.fill(0.0);
        assert!(undetermined.covariance().is_none() && undetermined.weakest_direction().is_none());
    }
}
