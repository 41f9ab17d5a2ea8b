//! The prior of the shape (`docs/theory.md`, maximum likelihood): independent harmonics whose standard deviations fall with the
//! square of their number, and a penalty on v < 0 that keeps the shape convex.

use crate::shape::Symmetry;
use pulp::{Arch, Simd, WithSimd};

/// The prior of the coefficients: a_k, b_k ~ N(0, (c/k²)²) for k ≥ 2, and wide priors on the mean radius and on the first
/// harmonic, which is the place of the centre of mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Prior {
    /// Rough size of the object, metres.
    pub size_m: f64,
    /// c above, metres.
    pub scale_m: f64,
    /// Standard deviation of the first harmonic, which is the place of the origin, metres.
    pub origin_sd_m: f64,
    /// Harmonics that it excludes have the standard deviation [`EXCLUDED_SD`]; a mirror maps θ to −θ.
    pub symmetry: Symmetry,
    /// Order of the rotation by which the form nearly comes to itself, wherever its centre of mass is; 1 where nothing is known of that.
    pub form_order: u32,
}

/// What is left to harmonics that a form which nearly comes to itself has no need of, as a share of the others'. (The first is where the centre of mass
/// is in it.)
const NEARLY: f64 = 0.03;

/// Prior standard deviation of the mean radius, as a multiple of the size: so wide that it does not bias it.
const RADIUS_SD: f64 = 10.0;

/// Prior standard deviation of a harmonic that the symmetry excludes, as a share of the size: nothing that a log could tell, and
/// large enough for the normal equations.
const EXCLUDED_SD: f64 = 1e-9;

impl Prior {
    /// Without symmetry.
    pub const fn new(size_m: f64, scale_m: f64) -> Self {
        Self { size_m, scale_m, origin_sd_m: size_m, symmetry: Symmetry::NONE, form_order: 1 }
    }

    /// Whether the symmetry leaves a_k and b_k free.
    pub fn is_free(&self, k: usize) -> [bool; 2] {
        let allowed = self.symmetry.allows_harmonic(k);
        [allowed, allowed && !self.symmetry.mirror]
    }

    /// What is left to the k-th harmonic from the second on, as a share of c/k².
    pub fn share(&self, k: usize) -> f64 {
        if k.is_multiple_of(self.form_order as usize) { 1.0 } else { NEARLY }
    }

    /// Prior standard deviations of the coefficient vector (a0, a1 … aK, b1 … bK).
    pub fn standard_deviations(&self, order: usize) -> Vec<f64> {
        let harmonic = |k: usize, free: bool| match (free, k) {
            (false, _) => EXCLUDED_SD * self.size_m,
            (true, 1) => self.origin_sd_m,
            (true, _) => self.share(k) * self.scale_m / (k * k) as f64,
        };
        let mut sd = vec![RADIUS_SD * self.size_m];
        for which in 0..2 {
            sd.extend((1..=order).map(|k| harmonic(k, self.is_free(k)[which])));
        }
        sd
    }
}

/// Margin ε and standard deviation σ_v of the convexity penalty, as shares of the size: v stays positive between the nodes, and a
/// violation by a thousandth of the size costs more than any reading gains.
const MARGIN: f64 = 8e-3;
const MARGIN_SD: f64 = 5e-4;

/// Keeps the radius of curvature positive: rows max(0, ε − v(θⱼ))/σ_v at nodes fine enough for K harmonics.
pub(crate) struct Convexity {
    margin_m: f64,
    sd_m: f64,
    order: usize,
    nodes: usize,
    /// (1 − k²) cos kθ for k = 1 … K at the nodes of half a turn, 0 to π; those of the other half mirror them.
    cosines: Vec<f64>,
    /// (1 − k²) sin kθ at the same.
    sines: Vec<f64>,
}

impl Convexity {
    /// At an even number of nodes.
    pub fn new(order: usize, size_m: f64, nodes: usize) -> Self {
        let circle: Vec<(f64, f64)> =
            (0..nodes).map(|node| (std::f64::consts::TAU * node as f64 / nodes as f64).sin_cos()).collect();
        let half = nodes / 2 + 1;
        let (mut cosines, mut sines) = (Vec::with_capacity(order * half), Vec::with_capacity(order * half));
        for k in 1..=order {
            let bending = 1.0 - (k * k) as f64;
            for node in 0..half {
                let (sin, cos) = circle[k * node % nodes];
                cosines.push(bending * cos);
                sines.push(bending * sin);
            }
        }
        Self { margin_m: MARGIN * size_m, sd_m: MARGIN_SD * size_m, order, nodes, cosines, sines }
    }

    /// The violated nodes and their residuals.
    pub fn violations(&self, coefficients: &[f64]) -> impl Iterator<Item = (usize, f64)> {
        self.residuals(coefficients).into_iter().enumerate().filter(|(_, residual)| *residual > 0.0)
    }

    /// (ε − v(θⱼ))/σ_v at every node: linear in the coefficients, and positive where the node is violated.
    pub fn residuals(&self, coefficients: &[f64]) -> Vec<f64> {
        // The even and the odd part of v about θ = 0.
        let half = self.nodes / 2 + 1;
        let (mut even, mut odd) = (vec![coefficients[0]; half], vec![0.0; half]);
        let (a, b) = coefficients[1..].split_at(coefficients.len() / 2);
        Arch::new().dispatch(Summing { factors: a, columns: &self.cosines, sums: &mut even });
        Arch::new().dispatch(Summing { factors: b, columns: &self.sines, sums: &mut odd });
        let residual = |node: usize| {
            let (mirrored, sign) = self.mirrored(node);
            (self.margin_m - (even[mirrored] + sign * odd[mirrored])) / self.sd_m
        };
        (0..self.nodes).map(residual).collect()
    }

    /// The node of the first half that a node is or mirrors, and the sign of its sines.
    fn mirrored(&self, node: usize) -> (usize, f64) {
        if 2 * node <= self.nodes { (node, 1.0) } else { (self.nodes - node, -1.0) }
    }

    /// Writes the derivative of the residual of a node by the coefficients.
    pub fn row(&self, node: usize, row: &mut [f64]) {
        let (mirrored, sign) = self.mirrored(node);
        let half = self.nodes / 2 + 1;
        let scale = -1.0 / self.sd_m;
        row[0] = scale;
        for k in 0..self.order {
            row[1 + k] = scale * self.cosines[k * half + mirrored];
            row[1 + self.order + k] = scale * sign * self.sines[k * half + mirrored];
        }
    }
}

/// Adds columns, each times its factor, compiled for several instruction sets.
struct Summing<'a> {
    factors: &'a [f64],
    columns: &'a [f64],
    sums: &'a mut [f64],
}

impl WithSimd for Summing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { factors, columns, sums } = self;
        for (factor, column) in factors.iter().zip(columns.chunks_exact(sums.len().max(1))) {
            for (sum, value) in sums.iter_mut().zip(column) {
                *sum += factor * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_form_that_nearly_comes_to_itself_has_few_other_harmonics_but_its_centre_of_mass_anywhere() {
        let general = Prior::new(0.03, 0.01);
        let [any, nearly] = [general, Prior { form_order: 3, ..general }].map(|prior| prior.standard_deviations(6));
        // The mean radius, then a_k, then b_k.
        let shares: Vec<f64> = any.iter().zip(&nearly).map(|(any, nearly)| nearly / any).collect();
        let of_harmonics = [1.0, NEARLY, 1.0, NEARLY, NEARLY, 1.0];
        assert_eq!(shares[0], 1.0);
        for (found, expected) in shares[1..].iter().zip(of_harmonics.iter().chain(&of_harmonics)) {
            assert!((found / expected - 1.0).abs() < 1e-12, "{shares:?}");
        }
    }
}
