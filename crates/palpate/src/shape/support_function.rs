//! The support function r(theta) as a truncated Fourier series, and what follows from it:
//! d = -r', the radius of curvature v = r + r'' and the boundary x = r n + d t
//! (Moll & Erdmann 2001, section 3; Santaló, *Integral Geometry and Geometric Probability*, 1976).

use std::f64::consts::{PI, TAU};

/// Supporting lines that [`SupportFunction::concavity_m`] looks at, and for each harmonic: r bends over arcs of 1/K.
const HULL_NODES: usize = 720;
const HULL_NODES_PER_HARMONIC: usize = 32;

/// Support function of a convex planar object about its centre of mass,
///
/// r(θ) = a₀ + Σₖ aₖ cos kθ + bₖ sin kθ, k = 1 … K, in metres.
///
/// θ is the angle of the outward normal n = (cos θ, sin θ) in the object frame, in radians; every finite angle is
/// allowed. The tangent is t = (sin θ, −cos θ), so that the boundary is run clockwise along t.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SupportFunction {
    #[cfg_attr(feature = "serde", serde(rename = "mean_radius_m"))]
    mean_m: f64,
    /// `[a_k, b_k]` for k = 1 … K.
    harmonics_m: Vec<[f64; 2]>,
}

/// The contact support function (r, d) at one normal angle, with the radius of curvature v, all in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSupport {
    /// Distance from the centre of mass to the supporting line.
    pub r: f64,
    /// Signed distance along t from the foot of the supporting line to the contact point, d = −r'.
    pub d: f64,
    /// Radius of curvature, v = r + r''; not negative where the object is convex.
    pub v: f64,
}

/// A point of the boundary in the object frame, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryPoint {
    /// Coordinate along the object's x axis.
    pub x_m: f64,
    /// Coordinate along the object's y axis.
    pub y_m: f64,
}

impl SupportFunction {
    /// From the mean radius a₀ and the harmonics `[a_k, b_k]`, k = 1 … K, in metres.
    pub fn new(mean_m: f64, harmonics_m: Vec<[f64; 2]>) -> Self {
        Self { mean_m, harmonics_m }
    }

    /// From the vector (a₀, a₁ … a_K, b₁ … b_K) that the estimator works with; its length must be odd.
    pub(crate) fn from_coefficients(coefficients: &[f64]) -> Self {
        let order = coefficients.len() / 2;
        let harmonics = (1..=order).map(|k| [coefficients[k], coefficients[order + k]]).collect();
        Self::new(coefficients[0], harmonics)
    }

    /// The same vector of this shape.
    pub(crate) fn coefficients(&self) -> Vec<f64> {
        let of = |index: usize| self.harmonics_m.iter().map(move |pair| pair[index]);
        std::iter::once(self.mean_m).chain(of(0)).chain(of(1)).collect()
    }

    /// Mean radius a₀ in metres; the perimeter is 2π a₀ (Cauchy).
    pub fn mean_radius_m(&self) -> f64 {
        self.mean_m
    }

    /// The harmonics `[a_k, b_k]`, k = 1 … K, in metres.
    pub fn harmonics_m(&self) -> &[[f64; 2]] {
        &self.harmonics_m
    }

    /// Number of harmonics that can be seen with contact positions of the standard deviation `sensor_sd_m`: those beyond it amount to less
    /// than a hundredth of it together. At least 2, unless there are fewer.
    pub(crate) fn visible_order(&self, sensor_sd_m: f64) -> usize {
        let mut tail = 0.0;
        let mut order = self.harmonics_m.len();
        while order > 2 {
            let [a, b] = self.harmonics_m[order - 1];
            tail += 0.5 * (a * a + b * b);
            if tail.sqrt() > 0.01 * sensor_sd_m {
                break;
            }
            order -= 1;
        }
        order
    }

    /// Whether a coefficient is infinite or not a number.
    pub fn has_nonfinite(&self) -> bool {
        !self.mean_m.is_finite() || self.harmonics_m.iter().flatten().any(|value| !value.is_finite())
    }

    /// r, d and v at the normal angle `theta_rad`.
    pub fn at(&self, theta_rad: f64) -> ContactSupport {
        let (sin, cos) = theta_rad.sin_cos();
        self.towards(cos, sin)
    }

    /// r, d and v where the outward normal is (`cos`, `sin`).
    pub(crate) fn towards(&self, cos: f64, sin: f64) -> ContactSupport {
        let (mut c, mut s) = (1.0, 0.0);
        let (mut r, mut d, mut v) = (self.mean_m, 0.0, self.mean_m);
        for (index, &[a, b]) in self.harmonics_m.iter().enumerate() {
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
            let k = (index + 1) as f64;
            let term = a * c + b * s;
            r += term;
            d += k * (a * s - b * c);
            v += (1.0 - k * k) * term;
        }
        ContactSupport { r, d, v }
    }

    /// r alone at the normal angle `theta_rad`, metres.
    pub fn radius_m(&self, theta_rad: f64) -> f64 {
        let (sin, cos) = theta_rad.sin_cos();
        let (mut c, mut s) = (1.0, 0.0);
        let mut r = self.mean_m;
        for &[a, b] in &self.harmonics_m {
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
            r += a * c + b * s;
        }
        r
    }

    /// The boundary point whose outward normal has the angle `theta_rad`: x = r n + d t.
    pub fn boundary_point(&self, theta_rad: f64) -> BoundaryPoint {
        let ContactSupport { r, d, .. } = self.at(theta_rad);
        let (sin, cos) = theta_rad.sin_cos();
        BoundaryPoint { x_m: r * cos + d * sin, y_m: r * sin - d * cos }
    }

    /// Enclosed area in square metres, ½∮ r v dθ = π a₀² + π/2 Σ (1 − k²)(aₖ² + bₖ²).
    pub fn area_m2(&self) -> f64 {
        let harmonics: f64 = self
            .harmonics_m
            .iter()
            .enumerate()
            .map(|(index, [a, b])| {
                let k = (index + 1) as f64;
                (1.0 - k * k) * (a * a + b * b)
            })
            .sum();
        PI * self.mean_m * self.mean_m + 0.5 * PI * harmonics
    }

    /// Perimeter in metres, 2π a₀.
    pub fn perimeter_m(&self) -> f64 {
        TAU * self.mean_m
    }

    /// Centroid of the enclosed area in the object frame, ∮ x r v dθ / (3 A). Differs from the origin when the mass is
    /// not spread evenly. The trapezoid rule used is exact for a trigonometric polynomial.
    pub fn centroid(&self) -> BoundaryPoint {
        let nodes = 3 * self.harmonics_m.len() + 4;
        let (mut x, mut y) = (0.0, 0.0);
        for node in 0..nodes {
            let theta = TAU * node as f64 / nodes as f64;
            let ContactSupport { r, v, .. } = self.at(theta);
            let point = self.boundary_point(theta);
            x += point.x_m * r * v;
            y += point.y_m * r * v;
        }
        let scale = TAU / nodes as f64 / (3.0 * self.area_m2());
        BoundaryPoint { x_m: x * scale, y_m: y * scale }
    }

    /// Radius of gyration about the origin of an even mass over the area, metres: ¼ ∮ (r² + d²) r v dθ over the area is its square. The trapezoid
    /// rule used is exact for a trigonometric polynomial.
    pub fn uniform_gyration_radius_m(&self) -> f64 {
        let nodes = 4 * self.harmonics_m.len() + 4;
        let step = TAU / nodes as f64;
        let of_node = |node: usize| {
            let ContactSupport { r, d, v } = self.at(step * node as f64);
            (r * r + d * d) * r * v
        };
        let integral: f64 = (0..nodes).map(of_node).sum();
        (0.25 * step * integral / self.area_m2()).max(0.0).sqrt()
    }

    /// Smallest radius of curvature over the whole circle, in metres: the object is convex exactly when it is not negative.
    pub fn min_curvature_radius_m(&self) -> f64 {
        // A grid fine enough to bracket every minimum, then Newton-free refinement by ternary search.
        let nodes = (16 * (self.harmonics_m.len() + 1)).max(64);
        let step = TAU / nodes as f64;
        let v = |theta: f64| self.at(theta).v;
        let grid: Vec<f64> = (0..nodes).map(|node| v(step * node as f64)).collect();
        let mut smallest = f64::INFINITY;
        for node in 0..nodes {
            let before = grid[(node + nodes - 1) % nodes];
            let after = grid[(node + 1) % nodes];
            if grid[node] <= before && grid[node] <= after {
                let (mut low, mut high) = (step * (node as f64 - 1.0), step * (node as f64 + 1.0));
                for _ in 0..60 {
                    let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                    if v(left) < v(right) { high = right } else { low = left }
                }
                smallest = smallest.min(v(0.5 * (low + high))).min(grid[node]);
            }
        }
        smallest
    }

    /// How far the boundary is from a convex one, in metres: by how much r(θ) is largest above the support function of the convex object
    /// that all supporting lines leave; 0 where the radius of curvature is nowhere negative, infinite where r(θ) is not positive. A
    /// radius of curvature that is negative over a short arc, as where few harmonics follow a corner, leaves nanometres.
    pub fn concavity_m(&self) -> f64 {
        if self.is_convex() {
            return 0.0;
        }
        let nodes = HULL_NODES.max(HULL_NODES_PER_HARMONIC * self.harmonics_m.len());
        let angle = |node: usize| TAU * node as f64 / nodes as f64;
        let r: Vec<f64> = (0..nodes).map(|node| self.at(angle(node)).r).collect();
        let Some(nearest) = (0..nodes).min_by(|&a, &b| r[a].total_cmp(&r[b])).filter(|&node| r[node] > 0.0) else {
            return f64::INFINITY;
        };
        // The convex hull of the points n/r of the dual plane: a line that leaves it is touched by the object.
        let dual = |node: usize| {
            let (sin, cos) = angle(node % nodes).sin_cos();
            [cos / r[node % nodes], sin / r[node % nodes]]
        };
        let turns_left = |a: usize, b: usize, c: usize| {
            let [a, b, c] = [a, b, c].map(dual);
            (b[0] - a[0]) * (c[1] - b[1]) > (b[1] - a[1]) * (c[0] - b[0])
        };
        let mut touched: Vec<usize> = Vec::new();
        for node in nearest..=nearest + nodes {
            while let [.., before, last] = touched[..]
                && !turns_left(before, last, node)
            {
                touched.pop();
            }
            touched.push(node);
        }
        let above = |pair: &[usize]| {
            let [from, to] = [pair[0], pair[1]];
            let corner = |node: usize| {
                let share = |node: usize, other: usize| r[node % nodes] * angle(other).sin();
                (share(from, to - node) + share(to, node - from)) / angle(to - from).sin()
            };
            (from + 1..to).map(|node| r[node % nodes] - corner(node)).fold(0.0, f64::max)
        };
        touched.windows(2).map(above).fold(0.0, f64::max)
    }

    /// Whether the radius of curvature is nowhere negative.
    pub fn is_convex(&self) -> bool {
        self.min_curvature_radius_m() >= 0.0
    }

    /// The same object turned by `angle_rad` (counter-clockwise) in its frame: r(θ) becomes r(θ − angle).
    pub fn rotated(&self, angle_rad: f64) -> Self {
        let harmonics = self
            .harmonics_m
            .iter()
            .enumerate()
            .map(|(index, &[a, b])| {
                let (sin, cos) = (angle_rad * (index + 1) as f64).sin_cos();
                [a * cos - b * sin, a * sin + b * cos]
            })
            .collect();
        Self::new(self.mean_m, harmonics)
    }

    /// The same form in another size, `factor` times as large: every length grows with it.
    pub fn scaled(&self, factor: f64) -> Self {
        let harmonics = self.harmonics_m.iter().map(|[a, b]| [a * factor, b * factor]);
        Self::new(self.mean_m * factor, harmonics.collect())
    }

    /// The same object moved by (x, y) metres in its frame: the first harmonic gains (x, y).
    pub fn translated(&self, x_m: f64, y_m: f64) -> Self {
        let mut harmonics = self.harmonics_m.clone();
        if harmonics.is_empty() {
            harmonics.push([0.0, 0.0]);
        }
        harmonics[0][0] += x_m;
        harmonics[0][1] += y_m;
        Self::new(self.mean_m, harmonics)
    }
}
