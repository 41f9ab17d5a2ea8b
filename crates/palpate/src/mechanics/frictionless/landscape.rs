//! The potential energy of an object between two still palms as a function of its orientation ψ, and where it rests.
//!
//! The centre of mass lies at the height h(ψ) = (r₁ sin φ₁₂ + r₂ sin φ₁) / sin φ₂. The object is in force/torque balance
//! where h' = 0, that is g = d₁ sin φ₁₂ + d₂ sin φ₁ = 0 (the concurrency of the three force lines, eq. 10 of
//! Moll & Erdmann 2001), and rests stably where g' = (v₁ − r₁) sin φ₁₂ + (v₂ − r₂) sin φ₁ > 0.
//!
//! With the palms held still, L = h sin φ₂ is one trigonometric polynomial in ψ, with g = L'. All searches here walk it by
//! steps that a bound on its third derivative proves free of a zero of g, so that no minimum can be stepped over:
//! as long as f > 0, f(s) ≥ f + f' s − M s²/2 with M ≥ |f''| has no zero before
//! s* = 2 f / (√(f'² + 2 M f) − f'). The walk converges quadratically, like Newton's method, and from one side.

use std::f64::consts::TAU;

use crate::palms::{PalmAngles, PalmPair};
use crate::shape::SupportFunction;

/// Below this fraction of the mean radius, an energy landscape counts as flat (a disc about its centre of mass).
const FLAT: f64 = 1e-12;

/// Most steps of a walk: far beyond what any landscape needs, so that nothing can hang.
const MOST_STEPS: usize = 200_000;

/// An interval that ends at a balanced pose may miss it by this much, radians.
const ROUNDING_RAD: f64 = 1e-12;

/// The height of the centre of mass over all orientations of one object between two still palms.
#[derive(Clone, Debug)]
pub struct EnergyLandscape {
    /// [A_k, B_k] of L(ψ) = A₀ + Σ A_k cos kψ + B_k sin kψ, metres; L = h sin φ₂ without the base points.
    harmonics_m: Vec<[f64; 2]>,
    mean_m: f64,
    sin2: f64,
    base_height_m: f64,
    size_m: f64,
    /// Bounds of |L'|, |L'''| and |L''''| over all ψ.
    slope_bound_m: f64,
    third_bound_m: f64,
    fourth_bound_m: f64,
}

/// A stable pose of an object between two still palms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestPose {
    /// Orientation ψ in radians, in [0, 2π).
    pub psi_rad: f64,
    /// Height of the centre of mass over the origin, metres.
    pub height_m: f64,
    /// d²h/dψ² in metres, positive; 0 where the pose is about to vanish.
    pub stiffness_m: f64,
}

/// An interval of ψ with one balanced pose in it, a stable one.
#[derive(Clone, Copy, Debug)]
struct Basin {
    /// How far it reaches to either side of its middle, radians.
    radius_rad: f64,
    /// M/g': the error that Newton's method leaves is at most this times the square of its step.
    bend: f64,
    /// Newton's step from the middle, radians, to be subtracted.
    step: f64,
}

impl EnergyLandscape {
    /// The landscape of `shape` between `palms`, which must not be parallel (sin φ₂ > 0).
    pub fn new(shape: &SupportFunction, palms: &PalmPair) -> Self {
        Self::between(shape, palms, &palms.angles())
    }

    /// The same, with the angles of the palms.
    pub(crate) fn between(shape: &SupportFunction, palms: &PalmPair, angles: &PalmAngles) -> Self {
        let &PalmAngles { sin1, cos1, sin12, cos12, sin2, .. } = angles;
        let ([x1, y1], [x2, y2]) = (palms.base1_m, palms.base2_m);
        // b_k · n̄_k
        let (offset1, offset2) = (y1 * cos1 - x1 * sin1, x2 * sin12 - y2 * cos12);
        let mut landscape = Self {
            harmonics_m: Vec::with_capacity(shape.harmonics_m().len()),
            mean_m: shape.mean_radius_m() * (sin12 + sin1),
            sin2,
            base_height_m: (offset1 * sin12 + offset2 * sin1) / sin2,
            size_m: shape.mean_radius_m().abs(),
            slope_bound_m: 0.0,
            third_bound_m: 0.0,
            fourth_bound_m: 0.0,
        };
        // Cosine and sine of kα₁ and kα₂, where θ₁ = α₁ − ψ and θ₂ = α₂ − ψ: α₁ = φ₁ − π/2 and α₂ = φ₁₂ − 3π/2.
        let ((mut c1, mut s1), (mut c2, mut s2)) = ((1.0, 0.0), (1.0, 0.0));
        for (index, &[a, b]) in shape.harmonics_m().iter().enumerate() {
            let k = (index + 1) as f64;
            (c1, s1) = (c1 * sin1 + s1 * cos1, s1 * sin1 - c1 * cos1);
            (c2, s2) = (-c2 * sin12 - s2 * cos12, c2 * cos12 - s2 * sin12);
            let cosine = sin12 * (a * c1 + b * s1) + sin1 * (a * c2 + b * s2);
            let sine = sin12 * (a * s1 - b * c1) + sin1 * (a * s2 - b * c2);
            landscape.harmonics_m.push([cosine, sine]);
            let amplitude = (cosine * cosine + sine * sine).sqrt();
            landscape.slope_bound_m += k * amplitude;
            landscape.third_bound_m += k * k * k * amplitude;
            landscape.fourth_bound_m += k * k * k * k * amplitude;
        }
        landscape
    }

    /// L and its first three derivatives.
    fn derivatives(&self, psi_rad: f64) -> [f64; 4] {
        let (sin, cos) = psi_rad.sin_cos();
        let (mut c, mut s) = (1.0, 0.0);
        let mut sums = [self.mean_m, 0.0, 0.0, 0.0];
        for (index, &[a, b]) in self.harmonics_m.iter().enumerate() {
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
            let k = (index + 1) as f64;
            let (even, odd) = (a * c + b * s, k * (b * c - a * s));
            sums[0] += even;
            sums[1] += odd;
            sums[2] -= k * k * even;
            sums[3] -= k * k * odd;
        }
        sums
    }

    /// Height h of the centre of mass over the origin, metres.
    pub fn height_m(&self, psi_rad: f64) -> f64 {
        self.derivatives(psi_rad)[0] / self.sin2 + self.base_height_m
    }

    /// Balance g = d₁ sin φ₁₂ + d₂ sin φ₁ = h' sin φ₂, metres: 0 where the object is in force/torque balance.
    pub fn balance_m(&self, psi_rad: f64) -> f64 {
        self.derivatives(psi_rad)[1]
    }

    /// g' = (v₁ − r₁) sin φ₁₂ + (v₂ − r₂) sin φ₁, metres: positive where a balanced pose is stable.
    pub fn balance_slope_m(&self, psi_rad: f64) -> f64 {
        self.derivatives(psi_rad)[2]
    }

    /// Whether every orientation is balanced alike: a disc with its mass in the centre.
    pub fn is_flat(&self) -> bool {
        self.slope_bound_m <= FLAT * self.size_m || !self.slope_bound_m.is_finite()
    }

    /// |g| that counts as zero in a walk: near the rounding of g itself.
    fn nothing_m(&self) -> f64 {
        2e-16 * self.slope_bound_m.max(1e-3 * self.size_m)
    }

    /// The first zero of g met when ψ moves from `psi_rad` by at most `reach_rad` in the direction `sign` (±1).
    fn first_balance(&self, psi_rad: f64, sign: f64, reach_rad: f64) -> Option<f64> {
        let bound = self.third_bound_m;
        let [_, start, ..] = self.derivatives(psi_rad);
        let side = if start >= 0.0 { 1.0 } else { -1.0 };
        let mut travelled = 0.0;
        for _ in 0..MOST_STEPS {
            let psi = psi_rad + sign * travelled;
            let [_, g, slope, _] = self.derivatives(psi);
            let (f, f1) = (side * g, side * sign * slope);
            if f <= self.nothing_m() {
                return Some(self.polished(psi));
            }
            let root = (f1 * f1 + 2.0 * bound * f).sqrt();
            let step = if f1 < 0.0 { 2.0 * f / (root - f1) } else { (f1 + root) / bound };
            if step <= f64::EPSILON * (1.0 + psi.abs()) {
                return Some(self.polished(psi));
            }
            travelled += step;
            if travelled > reach_rad {
                return None;
            }
        }
        None
    }

    /// A zero of g improved by Newton steps, as long as they make |g| smaller.
    fn polished(&self, psi_rad: f64) -> f64 {
        let (mut best, mut least) = (psi_rad, self.balance_m(psi_rad).abs());
        for _ in 0..6 {
            let [_, g, slope, _] = self.derivatives(best);
            let next = best - g / slope;
            if !next.is_finite() || (next - best).abs() > 1e-6 {
                break;
            }
            let value = self.balance_m(next).abs();
            if value >= least {
                break;
            }
            (best, least) = (next, value);
        }
        best
    }

    /// The minimum of the energy reached from `psi_rad` by going downhill all the way, ψ unwrapped.
    ///
    /// This is where an object goes when its pose vanishes: the next minimum downhill, however flat the way is. From a
    /// maximum, where both ways lead down, it goes towards larger ψ. On a flat landscape it stays.
    pub fn descend(&self, psi_rad: f64) -> f64 {
        if self.is_flat() || !psi_rad.is_finite() {
            return psi_rad;
        }
        let mut from = psi_rad;
        let [_, g, slope, _] = self.derivatives(from);
        if g.abs() <= self.nothing_m() {
            if slope > 0.0 {
                return self.polished(from);
            }
            // On a maximum (or an inflection): leave it. No other zero of g lies within 2|g'|/M.
            from += (slope.abs() / self.third_bound_m).clamp(1e-9, 1e-3);
        }
        let sign = if self.balance_m(from) > 0.0 { -1.0 } else { 1.0 };
        self.first_balance(from, sign, TAU + 0.1).unwrap_or(from)
    }

    /// All stable poses, ψ increasing in [0, 2π). Empty on a flat landscape, where every orientation is as good.
    pub fn stable_poses(&self) -> Vec<RestPose> {
        let mut poses = Vec::new();
        if self.is_flat() {
            return poses;
        }
        // Start away from a zero of g, so that a pose at ψ = 0 is met once and only once.
        let start = (0..64)
            .map(|i| TAU * f64::from(i) / 64.0)
            .max_by(|a, b| self.balance_m(*a).abs().total_cmp(&self.balance_m(*b).abs()))
            .unwrap_or(0.0);
        let mut psi = start;
        while let Some(rest) = self.first_balance(psi, 1.0, start + TAU - psi) {
            let slope = self.balance_slope_m(rest);
            if slope > 0.0 {
                poses.push(RestPose {
                    psi_rad: rest.rem_euclid(TAU),
                    height_m: self.height_m(rest),
                    stiffness_m: slope / self.sin2,
                });
            }
            psi = rest.max(psi) + (slope.abs() / self.third_bound_m).max(1e-9);
            if psi >= start + TAU {
                break;
            }
        }
        poses.sort_by(|a, b| a.psi_rad.total_cmp(&b.psi_rad));
        poses
    }

    /// The balanced pose near `psi_rad` if it is proved to be unique and stable there, by Newton's method.
    pub(crate) fn continued(&self, psi_rad: f64) -> Option<f64> {
        let Basin { radius_rad, bend, mut step } = self.basin(psi_rad)?;
        let mut psi = psi_rad;
        for _ in 0..8 {
            psi -= step;
            // What is left is at most this.
            if bend * step * step <= f64::EPSILON {
                break;
            }
            let [_, g, slope, _] = self.derivatives(psi);
            step = g / slope;
        }
        Some(psi).filter(|psi| (psi - psi_rad).abs() <= radius_rad + ROUNDING_RAD)
    }

    /// Whether the balanced pose `rest_rad` is proved to be the one near `psi_rad`, and stable.
    pub(crate) fn continues_to(&self, psi_rad: f64, rest_rad: f64) -> bool {
        self.basin(psi_rad).is_some_and(|basin| (rest_rad - psi_rad).abs() <= basin.radius_rad + ROUNDING_RAD)
    }

    /// Kantorovich's condition at `psi_rad`: |g| M ≤ ¼ g'², with M a bound on |g''| over the interval of radius 2|g|/g'. There
    /// g' stays above half its value in the middle, so that g has one zero and no other.
    fn basin(&self, psi_rad: f64) -> Option<Basin> {
        let [_, g, slope, third] = self.derivatives(psi_rad);
        if slope <= 0.0 {
            return None;
        }
        let radius_rad = 2.0 * g.abs() / slope;
        let bound = third.abs() + self.fourth_bound_m * radius_rad;
        (g.abs() * bound <= 0.25 * slope * slope).then_some(Basin { radius_rad, bend: bound / slope, step: g / slope })
    }
}
