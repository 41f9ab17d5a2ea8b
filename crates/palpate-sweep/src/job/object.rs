//! The objects of simulated jobs: named ones, and kinds of which each seed draws one.

use std::f64::consts::TAU;
use std::str::FromStr;
use std::sync::Arc;

use palpate::shape::{NamedShape, RandomShape, ShapeError, SupportFunction, ellipse, random_shape, rounded_polygon};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// What the object of a job is. `mass_offset` is how far the centre of mass lies from the centroid, in a direction that the seed
/// draws, as a share of the mean radius.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Object {
    /// A third each: Fourier shapes of order 3 to 8, ellipses, rounded polygons; sizes and centres of mass as the seed has it.
    /// These are the objects of the accuracy study.
    Mixed,
    /// What people make: an ellipse, a rounded triangle, square or hexagon, a bar, or an egg (a mirror image of itself, no more),
    /// of even mass; sizes as the seed has it.
    Symmetric,
    /// A shape with a name; the seed draws nothing.
    Named {
        /// Its name.
        name: ShapeName,
        /// Mean radius (perimeter / 2π), metres.
        mean_radius_m: f64,
    },
    /// A random smooth shape.
    Fourier {
        /// Number of harmonics.
        order: usize,
        /// Mean radius, metres.
        mean_radius_m: f64,
        /// See above.
        mass_offset: f64,
    },
    /// An ellipse.
    Ellipse {
        /// Short axis over long axis.
        axis_ratio: f64,
        /// Mean radius, metres.
        mean_radius_m: f64,
        /// See above.
        mass_offset: f64,
    },
    /// A regular polygon with rounded corners.
    Polygon {
        /// Number of corners.
        corners: u32,
        /// Mean radius, metres.
        mean_radius_m: f64,
        /// See above.
        mass_offset: f64,
    },
    /// A shape made from an outline in a file, which is read when the plan is: other machines need no file.
    Outline {
        /// The file as the plan names it.
        file: String,
        /// The shape, in the size of the plan.
        #[serde(with = "shared")]
        shape: Arc<SupportFunction>,
        /// See above; `None` for the centre of mass of the file.
        mass_offset: Option<f64>,
    },
}

/// A value that jobs share, written out for each.
mod shared {
    use std::sync::Arc;

    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<T: Serialize, S: Serializer>(value: &Arc<T>, serializer: S) -> Result<S::Ok, S::Error> {
        value.as_ref().serialize(serializer)
    }

    pub(super) fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Arc<T>, D::Error> {
        T::deserialize(deserializer).map(Arc::new)
    }
}

/// The name of a shape, as text in files.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ShapeName(pub NamedShape);

impl TryFrom<String> for ShapeName {
    type Error = <NamedShape as FromStr>::Err;

    fn try_from(name: String) -> Result<Self, Self::Error> {
        name.parse().map(Self)
    }
}

impl From<ShapeName> for String {
    fn from(name: ShapeName) -> Self {
        name.0.to_string()
    }
}

/// Radius and smoothness of the corners of [`Object::Polygon`]: in the middle of those that [`Object::Mixed`] draws.
const CORNER_RADIUS: f64 = 0.35;
const CORNER_SMOOTHNESS_RAD: f64 = 0.4;

impl Object {
    /// The object of a seed: what it is called in the table, and its support function about the centre of mass.
    ///
    /// # Errors
    /// When a number is out of range.
    pub fn of_seed(&self, seed: u64) -> Result<(String, SupportFunction), ShapeError> {
        self.draw(&mut ChaCha8Rng::seed_from_u64(seed))
    }

    /// Draws one: what it is called in the table, and its support function about the centre of mass.
    pub(crate) fn draw(&self, rng: &mut ChaCha8Rng) -> Result<(String, SupportFunction), ShapeError> {
        match *self {
            Self::Mixed => mixed(rng),
            Self::Symmetric => symmetric(rng),
            Self::Named { name, mean_radius_m } => Ok((name.0.to_string(), name.0.shape(mean_radius_m)?)),
            Self::Fourier { order, mean_radius_m, mass_offset } => {
                let kind = RandomShape { mean_radius_m, order, mass_offset: 0.0, ..RandomShape::default() };
                let shape = random_shape(&kind, rng.random())?;
                Ok((format!("Fourier {order}"), off_centre(&shape, mass_offset * mean_radius_m, rng)))
            }
            Self::Ellipse { axis_ratio, mean_radius_m, mass_offset } => {
                let unit = ellipse(1.0, axis_ratio)?;
                let shape = unit.scaled(mean_radius_m / unit.mean_radius_m());
                Ok((format!("ellipse {axis_ratio}"), off_centre(&shape, mass_offset * mean_radius_m, rng)))
            }
            Self::Polygon { corners, mean_radius_m, mass_offset } => {
                let unit = rounded_polygon(corners, CORNER_RADIUS, CORNER_SMOOTHNESS_RAD)?;
                let shape = unit.scaled(mean_radius_m);
                Ok((format!("polygon {corners}"), off_centre(&shape, mass_offset * mean_radius_m, rng)))
            }
            Self::Outline { ref file, ref shape, mass_offset } => {
                let shape = match mass_offset {
                    Some(offset) => off_centre(shape, offset * shape.mean_radius_m(), rng),
                    None => shape.as_ref().clone(),
                };
                Ok((file.clone(), shape))
            }
        }
    }
}

/// Fourier of order 3 to 8, an ellipse or a rounded polygon, its centre of mass up to 0.2 radius from the centroid.
fn mixed(rng: &mut ChaCha8Rng) -> Result<(String, SupportFunction), ShapeError> {
    let radius = rng.random_range(0.018..0.04);
    let (name, shape) = match rng.random_range(0..3) {
        0 => {
            let order = rng.random_range(3..=8);
            let kind = RandomShape { mean_radius_m: radius, order, mass_offset: 0.0, ..RandomShape::default() };
            (format!("Fourier {order}"), random_shape(&kind, rng.random())?)
        }
        1 => {
            let ratio = rng.random_range(0.55..0.9);
            (format!("ellipse {ratio:.2}"), ellipse(radius * 1.15, radius * 1.15 * ratio)?)
        }
        _ => {
            let corners = rng.random_range(3..=6);
            let smoothness: f64 = rng.random_range(0.3..0.5);
            let shape = rounded_polygon(corners, rng.random_range(0.2..0.5), smoothness)?;
            (format!("polygon {corners}"), shape.scaled(radius))
        }
    };
    let offset = 0.2 * radius * rng.random_range(0.0f64..1.0).sqrt();
    let shape = off_centre(&shape, offset, rng);
    Ok((name, shape.rotated(rng.random_range(0.0..TAU))))
}

/// An object of even mass that is its own image when turned by part of a circle, or in a mirror.
fn symmetric(rng: &mut ChaCha8Rng) -> Result<(String, SupportFunction), ShapeError> {
    let radius = rng.random_range(0.018..0.04);
    let (name, unit) = match rng.random_range(0..6) {
        0 => {
            let ratio = rng.random_range(0.55..0.9);
            (format!("ellipse {ratio:.2}"), ellipse(1.0, ratio)?)
        }
        1 => {
            // A disc moved along an ellipse: rounded ends and flat sides.
            let (length, corner): (f64, f64) = (rng.random_range(0.6..1.5), rng.random_range(0.4..0.6));
            let spine = ellipse(length, 0.15)?;
            let bar = SupportFunction::new(spine.mean_radius_m() + corner, spine.harmonics_m().to_vec());
            (format!("bar {:.1}", (length + corner) / (0.15 + corner)), bar)
        }
        2 => {
            let (second, third) = (rng.random_range(0.03..0.09), rng.random_range(0.01..0.04));
            let egg = SupportFunction::new(1.0, vec![[0.0, 0.0], [second, 0.0], [third, 0.0]]);
            let centroid = egg.centroid();
            ("egg".to_owned(), egg.translated(-centroid.x_m, -centroid.y_m))
        }
        kind => {
            let corners = [3, 4, 6][kind - 3];
            let smoothness = rng.random_range(0.25..0.5) * 3.0 / f64::from(corners);
            (format!("polygon {corners}"), rounded_polygon(corners, rng.random_range(0.2..0.5), smoothness)?)
        }
    };
    let shape = unit.scaled(radius / unit.mean_radius_m());
    Ok((name, shape.rotated(rng.random_range(0.0..TAU))))
}

/// The shape about a centre of mass `offset_m` away from its centroid, in a random direction.
pub(crate) fn off_centre(shape: &SupportFunction, offset_m: f64, rng: &mut ChaCha8Rng) -> SupportFunction {
    let centroid = shape.centroid();
    let towards = rng.random_range(0.0..TAU);
    shape.translated(offset_m * towards.cos() - centroid.x_m, offset_m * towards.sin() - centroid.y_m)
}
