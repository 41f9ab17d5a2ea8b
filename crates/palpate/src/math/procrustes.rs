//! Rigid motions of the plane, and the one that best carries one set of points onto another: SVD alignment, the solution of
//! the orthogonal Procrustes problem by singular value decomposition (G. H. Golub and C. F. Van Loan, *Matrix Computations*,
//! third edition 1996, section 12.4.1). Moll & Erdmann (2001, section 4) align the observed shape with the actual one in
//! this way.

use nalgebra::Matrix2;

/// A rotation about the origin, and then a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMotion {
    /// Counter-clockwise, radians, from −π to π.
    pub angle_rad: f64,
    /// Translation, metres.
    pub offset_m: [f64; 2],
}

impl RigidMotion {
    /// Where the motion carries a point, metres.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle_rad.sin_cos();
        [x * cos - y * sin + self.offset_m[0], x * sin + y * cos + self.offset_m[1]]
    }

    /// The point that the motion carries to this one, metres.
    pub fn undo(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle_rad.sin_cos();
        let (x, y) = (x - self.offset_m[0], y - self.offset_m[1]);
        [x * cos + y * sin, y * cos - x * sin]
    }
}

/// The motion that carries `from` closest to `to`, in least squares; point i of one belongs to point i of the other (metres).
///
/// `None` when there are no points, as many on either side, or the points tell no rotation (all in one place).
pub fn procrustes(from: &[[f64; 2]], to: &[[f64; 2]]) -> Option<RigidMotion> {
    if from.is_empty() || from.len() != to.len() {
        return None;
    }
    let (center_from, center_to) = (center(from), center(to));
    let rotation = rotation(from, to, center_from, center_to)?;
    let carried = RigidMotion { angle_rad: rotation, offset_m: [0.0; 2] }.apply(center_from);
    Some(RigidMotion { angle_rad: rotation, offset_m: [center_to[0] - carried[0], center_to[1] - carried[1]] })
}

/// The rotation about the origin alone that carries `from` closest to `to`, radians; otherwise as [`procrustes`].
pub fn procrustes_rotation_rad(from: &[[f64; 2]], to: &[[f64; 2]]) -> Option<f64> {
    if from.is_empty() || from.len() != to.len() {
        return None;
    }
    rotation(from, to, [0.0; 2], [0.0; 2])
}

/// With the correlation C = Σ to fromᵀ = U Σ Vᵀ the best rotation is U diag(1, det U Vᵀ) Vᵀ.
fn rotation(from: &[[f64; 2]], to: &[[f64; 2]], center_from: [f64; 2], center_to: [f64; 2]) -> Option<f64> {
    let mut correlation = Matrix2::zeros();
    for (a, b) in from.iter().zip(to) {
        let (ax, ay) = (a[0] - center_from[0], a[1] - center_from[1]);
        let (bx, by) = (b[0] - center_to[0], b[1] - center_to[1]);
        correlation += Matrix2::new(bx * ax, bx * ay, by * ax, by * ay);
    }
    if correlation.iter().any(|value| !value.is_finite()) || correlation.norm() == 0.0 {
        return None;
    }
    let svd = correlation.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let proper = Matrix2::new(1.0, 0.0, 0.0, (u * v_t).determinant().signum());
    let rotation = u * proper * v_t;
    Some(rotation[(1, 0)].atan2(rotation[(0, 0)])).filter(|angle| angle.is_finite())
}

fn center(points: &[[f64; 2]]) -> [f64; 2] {
    let count = points.len() as f64;
    [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: [[f64; 2]; 4] = [[0.02, 0.0], [0.0, 0.01], [-0.015, -0.01], [0.004, -0.02]];

    #[test]
    fn a_rigid_motion_is_found_again() {
        for angle_rad in [-3.0, -1.0, 0.0, 0.4, 3.1] {
            let motion = RigidMotion { angle_rad, offset_m: [0.3, -0.2] };
            let found = procrustes(&POINTS, &POINTS.map(|point| motion.apply(point))).expect("points");
            assert!((found.angle_rad - angle_rad).abs() < 1e-12);
            for point in POINTS {
                let back = found.undo(motion.apply(point));
                assert!((back[0] - point[0]).hypot(back[1] - point[1]) < 1e-14);
            }
        }
    }

    #[test]
    fn a_mirrored_set_is_turned_not_mirrored() {
        let mirrored = POINTS.map(|[x, y]| [x, -y]);
        let found = procrustes(&POINTS, &mirrored).expect("points");
        let misfit = |angle_rad: f64| -> f64 {
            let motion = RigidMotion { angle_rad, ..found };
            POINTS
                .iter()
                .zip(mirrored)
                .map(|(a, b)| {
                    let carried = motion.apply(*a);
                    (carried[0] - b[0]).powi(2) + (carried[1] - b[1]).powi(2)
                })
                .sum()
        };
        // No rotation about the same centre does better (the centre is near the origin).
        let rotations = (0..360).map(|degree| f64::from(degree).to_radians());
        assert!(rotations.map(misfit).fold(f64::INFINITY, f64::min) > misfit(found.angle_rad) - 1e-5);
        assert!(found.angle_rad.is_finite());
    }

    #[test]
    fn points_that_tell_nothing_are_refused() {
        assert_eq!(procrustes(&[], &[]), None);
        assert_eq!(procrustes(&POINTS, &POINTS[1..]), None);
        assert_eq!(procrustes(&[[1.0, 2.0]; 3], &[[0.0, 1.0]; 3]), None);
        assert_eq!(procrustes_rotation_rad(&[[f64::NAN, 0.0]], &[[1.0, 0.0]]), None);
    }
}
