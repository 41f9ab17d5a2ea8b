//! The truth brought into the frame of the reconstruction, so that both can be drawn over each other.
//!
//! With ψ_true = ψ + δ at every sample, θ_true = θ − δ, and a boundary point x_true of the true frame is R(δ) x_true in ours.

use std::f64::consts::{PI, TAU};

use palpate::{Reconstruction, Truth};

/// An angle in (−π, π].
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// δ = ψ_true − ψ: the most common difference, so that a misplaced piece does not spoil the picture of the others.
pub(crate) fn rotation_rad(result: &Reconstruction, truth: &Truth) -> Option<f64> {
    let poses = result.motion.iter().zip(&truth.motion);
    most_common(poses.map(|(pose, true_pose)| true_pose.psi_rad - pose.psi_rad))
}

/// The most common of some angles.
pub(crate) fn most_common(differences: impl Iterator<Item = f64>) -> Option<f64> {
    let differences: Vec<f64> = differences.filter(|difference| difference.is_finite()).collect();
    const BINS: usize = 180;
    let mut counts = [0_usize; BINS];
    let width = TAU / BINS as f64;
    for difference in &differences {
        counts[((difference.rem_euclid(TAU) / width) as usize).min(BINS - 1)] += 1;
    }
    let pair = |bin: usize| counts[bin] + counts[(bin + 1) % BINS];
    let best = (0..BINS).max_by_key(|&bin| pair(bin)).filter(|&bin| pair(bin) > 0)?;
    let centre = width * (best + 1) as f64;
    let near = differences.iter().map(|difference| wrapped(difference - centre)).filter(|d| d.abs() <= 2.0 * width);
    let (sum, count) = near.fold((0.0, 0_usize), |(sum, count), d| (sum + d, count + 1));
    Some(centre + sum / count.max(1) as f64)
}

/// A support function sampled on an increasing grid of angles, made periodic and smooth (cubic Hermite).
pub(crate) struct SampledSupport {
    /// (θ, r, dr/dθ)
    nodes: Vec<(f64, f64, f64)>,
}

impl SampledSupport {
    /// From (θ, r) over one turn; `None` where there is too little to draw or the angles do not increase.
    pub(crate) fn new(support: &[(f64, f64)]) -> Option<Self> {
        let count = support.len();
        let finite = support.iter().all(|(theta, r)| theta.is_finite() && r.is_finite());
        let increasing = support.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if count < 8 || !finite || !increasing || support[count - 1].0 - support[0].0 >= TAU {
            return None;
        }
        let nodes = (0..count)
            .map(|index| {
                let (theta, r) = support[index];
                let (before, after) = (support[(index + count - 1) % count], support[(index + 1) % count]);
                // Slope of the parabola through three neighbours, exact to second order on an uneven grid too.
                let (h0, h1) = ((theta - before.0).rem_euclid(TAU), (after.0 - theta).rem_euclid(TAU));
                let (s0, s1) = ((r - before.1) / h0, (after.1 - r) / h1);
                (theta, r, (s0 * h1 + s1 * h0) / (h0 + h1))
            })
            .collect();
        Some(Self { nodes })
    }

    /// r at any angle.
    pub(crate) fn r(&self, theta_rad: f64) -> f64 {
        let count = self.nodes.len();
        let first = self.nodes[0].0;
        let theta = first + (theta_rad - first).rem_euclid(TAU);
        let above = self.nodes.partition_point(|node| node.0 <= theta).clamp(1, count);
        let (left, right) = (self.nodes[above - 1], self.nodes[above % count]);
        let h = (right.0 - left.0).rem_euclid(TAU);
        let u = (theta - left.0) / h;
        let (w, z) = (1.0 - u, u * (1.0 - u));
        left.1 * (w + z * (w - u)) + right.1 * (u - z * (w - u)) + h * z * (left.2 * w - right.2 * u)
    }

    /// The boundary, x = r n + d t with d = −r', at about `points` of the nodes, turned by `rotation_rad`.
    pub(crate) fn boundary_m(&self, rotation_rad: f64, points: usize) -> Vec<[f64; 2]> {
        let stride = self.nodes.len().div_ceil(points.max(1));
        self.nodes
            .iter()
            .step_by(stride)
            .map(|&(theta, r, slope)| {
                let (sin, cos) = (theta + rotation_rad).sin_cos();
                [r * cos - slope * sin, r * sin + slope * cos]
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{SampledSupport, wrapped};
    use std::f64::consts::{PI, TAU};

    #[test]
    fn sampled_support_follows_its_function() {
        let r = |theta: f64| 0.03 + 0.004 * theta.cos() - 0.002 * (3.0 * theta).sin();
        let samples: Vec<(f64, f64)> =
            (0..720).map(|i| TAU * i as f64 / 720.0).map(|theta| (theta, r(theta))).collect();
        let sampled = SampledSupport::new(&samples).expect("a fine grid");
        for index in -50..150 {
            let theta = 0.1 * f64::from(index);
            assert!((sampled.r(theta) - r(theta)).abs() < 1e-9, "{theta}");
        }
        // At theta = 0: x = r, y = r' = -6 mm.
        let point = sampled.boundary_m(0.0, 720)[0];
        assert!((point[0] - 0.034).abs() < 1e-9 && (point[1] + 0.006).abs() < 1e-6, "{point:?}");
    }

    #[test]
    fn unusable_support_is_refused() {
        assert!(SampledSupport::new(&[]).is_none());
        assert!(SampledSupport::new(&[(0.0, f64::NAN); 10]).is_none());
        assert!(SampledSupport::new(&[(0.0, 1.0); 10]).is_none());
    }

    #[test]
    fn angles_wrap_to_half_a_turn() {
        assert!((wrapped(3.0 * PI + 0.1) - (0.1 - PI)).abs() < 1e-12);
        assert!(wrapped(f64::NAN).is_nan());
    }
}
