//! Random smooth convex shapes.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::{ShapeError, SupportFunction};

/// How often a shape is drawn before one is made convex by force.
const MOST_DRAWS: usize = 2000;

/// What random shapes are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomShape {
    /// Mean radius, metres.
    pub mean_radius_m: f64,
    /// Number of harmonics, at least 1.
    pub order: usize,
    /// Harmonic k has the standard deviation `amplitude` · mean radius / (1 + k²).
    pub amplitude: f64,
    /// Standard deviation of each coordinate of the centre of mass against the middle of the shape, as a fraction of the
    /// mean radius. (The first harmonic.)
    pub mass_offset: f64,
    /// Smallest radius of curvature allowed, as a fraction of the mean radius, 0 to below 1.
    pub smallest_curvature: f64,
}

impl Default for RandomShape {
    /// Pebbles of 30 mm mean radius, six harmonics.
    fn default() -> Self {
        Self { mean_radius_m: 0.03, order: 6, amplitude: 0.5, mass_offset: 0.1, smallest_curvature: 0.15 }
    }
}

/// A random smooth convex shape; the same seed gives the same shape.
///
/// Shapes are drawn until one is as smooth as asked. After 2000 draws the harmonics of the last one are shrunk until
/// it is, so that this always ends.
///
/// # Errors
/// When a property is out of range.
pub fn random_shape(kind: &RandomShape, seed: u64) -> Result<SupportFunction, ShapeError> {
    let not_negative = |value: f64| value >= 0.0 && value.is_finite();
    if !(kind.mean_radius_m > 0.0 && kind.mean_radius_m.is_finite()) {
        return Err(ShapeError::OutOfRange { what: "the mean radius" });
    }
    if !(1..=512).contains(&kind.order) || !not_negative(kind.amplitude) || !not_negative(kind.mass_offset) {
        return Err(ShapeError::OutOfRange {
            what: "the order (at most 512), amplitude and mass offset of a random shape",
        });
    }
    if !(0.0..1.0).contains(&kind.smallest_curvature) {
        return Err(ShapeError::OutOfRange { what: "the smallest curvature radius (as a fraction below 1)" });
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let margin = kind.smallest_curvature * kind.mean_radius_m;
    let mut draw = || {
        let harmonics = (1..=kind.order).map(|k| {
            let spread = if k == 1 { kind.mass_offset } else { kind.amplitude / (1.0 + (k * k) as f64) };
            [0, 1].map(|_| rng.sample::<f64, _>(StandardNormal) * spread * kind.mean_radius_m)
        });
        SupportFunction::new(kind.mean_radius_m, harmonics.collect())
    };
    let mut shape = draw();
    for _ in 1..MOST_DRAWS {
        if shape.min_curvature_radius_m() > margin {
            return Ok(shape);
        }
        shape = draw();
    }
    // v = mean + (harmonics from the second on), so one factor on these settles it; a little more for rounding.
    let mean = kind.mean_radius_m;
    let factor = 0.999 * (mean - margin) / (mean - shape.min_curvature_radius_m());
    let shrunk = shape.harmonics_m().iter().enumerate();
    let shrunk =
        shrunk.map(|(index, &[a, b])| if index == 0 { [a, b] } else { [a * factor.min(1.0), b * factor.min(1.0)] });
    Ok(SupportFunction::new(mean, shrunk.collect()))
}
