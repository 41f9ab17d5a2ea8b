//! Shapes by name.

use std::f64::consts::{PI, TAU};
use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::{OutlineFit, RandomShape, ShapeError, SupportFunction, random_shape, rounded_rectangle};

/// Corner radius of a rectangle where none is given, as a share of its shorter side: a bar of soap.
const RECTANGLE_CORNER: f64 = 0.2;

/// A shape known by its name; [`NamedShape::shape`] makes it in the size asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NamedShape {
    /// A circle about its centre of mass. It never turns: the palms feel its outline and no motion.
    Circle,
    /// A disc with its mass off the centre by 0.25 radii.
    Disc,
    /// An ellipse with axes 1.4 : 1 and its mass off the centre.
    Ellipse,
    /// An egg of even mass.
    Egg,
    /// A triangle with rounded corners, of even mass.
    Triangle,
    /// A square with rounded corners, its mass off the centre.
    Square,
    /// One random smooth shape, always the same.
    Pebble,
    /// Another, with its mass far off the centre.
    Stone,
    /// A random smooth shape with this seed (`random:SEED`).
    Random(u64),
    /// A rectangle with rounded corners, of even mass (`rectangle:60x40` or, with a corner radius, `rectangle:60x40x8`, millimetres).
    Rectangle {
        /// Side along x, metres.
        length_m: f64,
        /// Side along y, metres.
        width_m: f64,
        /// Radius of the corners, metres.
        corner_radius_m: f64,
    },
    /// Two half discs and a rectangle between them, of even mass (`stadium:60x40`, millimetres).
    Stadium {
        /// Its length, metres.
        length_m: f64,
        /// Its width, metres.
        width_m: f64,
    },
}

/// The name is not the name of a shape.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("no shape is named \"{name}\"; {}", self.advice())]
pub struct UnknownShape {
    /// What was asked for.
    pub name: String,
}

impl UnknownShape {
    /// How a shape of this kind is written, or what kinds there are.
    fn advice(&self) -> String {
        let written = [
            ("rect", "a rectangle is written rectangle:60x40, or rectangle:60x40x5 with a corner radius; millimetres"),
            ("stadium", "a stadium is written stadium:60x40; millimetres"),
            ("random", "a random shape is written random:7, with a seed"),
        ];
        let kind = self.name.trim().to_ascii_lowercase();
        let known = written.iter().find(|(begin, _)| kind.starts_with(begin)).map(|(_, how)| (*how).to_owned());
        known.unwrap_or_else(|| format!("known are {} (sizes in millimetres)", NamedShape::NAMES.join(", ")))
    }
}

impl NamedShape {
    /// All names, for help texts; sizes in millimetres.
    pub const NAMES: [&'static str; 11] = [
        "circle",
        "disc",
        "ellipse",
        "egg",
        "triangle",
        "square",
        "pebble",
        "stone",
        "random:SEED",
        "rectangle:LENGTHxWIDTH[xCORNER]",
        "stadium:LENGTHxWIDTH",
    ];

    /// The shape with this mean radius (perimeter / 2π) in metres; `None` for the size in its name, or [`Self::USUAL_RADIUS_M`].
    ///
    /// # Errors
    /// When the mean radius, or a size in the name, is not positive and finite.
    pub fn fitted(self, mean_radius_m: Option<f64>) -> Result<OutlineFit, ShapeError> {
        let fit = match self {
            Self::Rectangle { length_m, width_m, corner_radius_m } => {
                rounded_rectangle(length_m, width_m, corner_radius_m)?
            }
            Self::Stadium { length_m, width_m } => rounded_rectangle(length_m, width_m, 0.5 * length_m.min(width_m))?,
            _ => return self.shape(mean_radius_m.unwrap_or(Self::USUAL_RADIUS_M)).map(OutlineFit::exact),
        };
        match mean_radius_m {
            None => Ok(fit),
            Some(radius) if radius > 0.0 && radius.is_finite() => Ok(fit.scaled(radius / fit.shape.mean_radius_m())),
            Some(_) => Err(ShapeError::OutOfRange { what: "the mean radius" }),
        }
    }

    /// Mean radius of a shape whose name has no size, metres.
    pub const USUAL_RADIUS_M: f64 = 0.03;

    /// Mean radius (perimeter / 2π) by the size in the name, metres, or [`Self::USUAL_RADIUS_M`].
    pub fn usual_radius_m(self) -> f64 {
        let of = |length_m: f64, width_m: f64, corner_m: f64| (length_m + width_m - 4.0 * corner_m) / PI + corner_m;
        match self {
            Self::Rectangle { length_m, width_m, corner_radius_m } => of(length_m, width_m, corner_radius_m),
            Self::Stadium { length_m, width_m } => of(length_m, width_m, 0.5 * length_m.min(width_m)),
            _ => Self::USUAL_RADIUS_M,
        }
    }

    /// The shape with this mean radius (perimeter / 2π) in metres.
    ///
    /// # Errors
    /// When the mean radius is not positive and finite.
    pub fn shape(self, mean_radius_m: f64) -> Result<SupportFunction, ShapeError> {
        if !(mean_radius_m > 0.0 && mean_radius_m.is_finite()) {
            return Err(ShapeError::OutOfRange { what: "the mean radius" });
        }
        let random = |seed, kind: RandomShape| random_shape(&RandomShape { mean_radius_m, ..kind }, seed);
        let unit = match self {
            Self::Circle => SupportFunction::new(1.0, Vec::new()),
            Self::Disc => SupportFunction::new(1.0, vec![[0.25, 0.0]]),
            Self::Ellipse => ellipse(1.4, 1.0)?.translated(0.15, 0.1),
            Self::Egg => about_centroid(&SupportFunction::new(1.0, vec![[0.0, 0.0], [0.07, 0.0], [0.03, 0.0]])),
            Self::Triangle => rounded_polygon(3, 0.35, 0.2)?,
            Self::Square => rounded_polygon(4, 0.35, 0.2)?.translated(0.12, 0.05),
            Self::Pebble => return random(4, RandomShape { mass_offset: 0.05, ..RandomShape::default() }),
            Self::Stone => return random(11, RandomShape { mass_offset: 0.15, ..RandomShape::default() }),
            Self::Random(seed) => return random(seed, RandomShape::default()),
            Self::Rectangle { .. } | Self::Stadium { .. } => {
                return self.fitted(Some(mean_radius_m)).map(|fit| fit.shape);
            }
        };
        Ok(unit.scaled(mean_radius_m / unit.mean_radius_m()))
    }
}

impl FromStr for NamedShape {
    type Err = UnknownShape;

    fn from_str(name: &str) -> Result<Self, UnknownShape> {
        let lower = name.trim().to_ascii_lowercase();
        Ok(match lower.as_str() {
            "circle" => Self::Circle,
            "disc" => Self::Disc,
            "ellipse" => Self::Ellipse,
            "egg" => Self::Egg,
            "triangle" => Self::Triangle,
            "square" => Self::Square,
            "pebble" => Self::Pebble,
            "stone" => Self::Stone,
            other => return with_parameters(other).ok_or_else(|| UnknownShape { name: name.to_owned() }),
        })
    }
}

/// A name with parameters after a colon.
fn with_parameters(name: &str) -> Option<NamedShape> {
    let (kind, parameters) = name.split_once(':')?;
    if kind == "random" {
        return parameters.parse().ok().map(NamedShape::Random);
    }
    let sizes_m: Vec<f64> = parameters.split('x').map(millimeters).collect::<Option<_>>()?;
    match (kind, &sizes_m[..]) {
        ("rectangle", &[length_m, width_m]) => {
            let corner_radius_m = RECTANGLE_CORNER * length_m.min(width_m);
            Some(NamedShape::Rectangle { length_m, width_m, corner_radius_m })
        }
        ("rectangle", &[length_m, width_m, corner_radius_m]) => {
            Some(NamedShape::Rectangle { length_m, width_m, corner_radius_m })
        }
        ("stadium", &[length_m, width_m]) => Some(NamedShape::Stadium { length_m, width_m }),
        _ => None,
    }
}

/// A length in millimetres as metres.
fn millimeters(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().map(|length| length / 1000.0)
}

/// A length in metres as millimetres, without the last digits, which rounding has left.
fn in_millimeters(length_m: f64) -> f64 {
    (1e9 * length_m).round() / 1e6
}

impl fmt::Display for NamedShape {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Self::Circle => "circle",
            Self::Disc => "disc",
            Self::Ellipse => "ellipse",
            Self::Egg => "egg",
            Self::Triangle => "triangle",
            Self::Square => "square",
            Self::Pebble => "pebble",
            Self::Stone => "stone",
            Self::Random(seed) => return write!(formatter, "random:{seed}"),
            Self::Rectangle { length_m, width_m, corner_radius_m } => {
                let [length, width, corner] = [length_m, width_m, corner_radius_m].map(|size| in_millimeters(*size));
                return write!(formatter, "rectangle:{length}x{width}x{corner}");
            }
            Self::Stadium { length_m, width_m } => {
                return write!(formatter, "stadium:{}x{}", in_millimeters(*length_m), in_millimeters(*width_m));
            }
        };
        formatter.write_str(name)
    }
}

/// An ellipse about its middle with the semi-axes `a_m` along x and `b_m` along y, metres: r = √(a² cos²θ + b² sin²θ),
/// expanded until what is left out is below 10⁻¹³ of the size (at most 256 harmonics, enough for axes 10 : 1).
///
/// # Errors
/// When an axis is not positive and finite.
pub fn ellipse(a_m: f64, b_m: f64) -> Result<SupportFunction, ShapeError> {
    if !(a_m > 0.0 && b_m > 0.0 && a_m.is_finite() && b_m.is_finite()) {
        return Err(ShapeError::OutOfRange { what: "the axes of an ellipse" });
    }
    const NODES: usize = 2048;
    const MOST: usize = 256;
    let r: Vec<(f64, f64)> = (0..NODES)
        .map(|node| TAU * node as f64 / NODES as f64)
        .map(|theta| (theta, (a_m * theta.cos()).hypot(b_m * theta.sin())))
        .collect();
    let mean = r.iter().map(|(_, r)| r).sum::<f64>() / NODES as f64;
    let mut harmonics = Vec::with_capacity(MOST);
    for k in 1..=MOST {
        // Symmetric about both axes: even cosines only.
        let a = if k % 2 == 0 {
            r.iter().map(|(theta, r)| 2.0 * r * (k as f64 * theta).cos()).sum::<f64>() / NODES as f64
        } else {
            0.0
        };
        harmonics.push([a, 0.0]);
    }
    let wanted = harmonics.iter().rposition(|[a, _]| a.abs() > 1e-13 * mean).map_or(0, |last| last + 1);
    harmonics.truncate(wanted);
    Ok(SupportFunction::new(mean, harmonics))
}

/// A regular polygon with `corners` rounded corners, about its middle, of mean radius 1 m.
///
/// Its radius of curvature v is `corner_radius` (0 to 1) plus, at each side, a normal distribution of the width
/// `smoothness_rad` (radians, at least 0.02) that makes up the rest: r_k = v_k / (1 − k²). Convex by construction.
///
/// # Errors
/// When a number is out of range.
pub fn rounded_polygon(corners: u32, corner_radius: f64, smoothness_rad: f64) -> Result<SupportFunction, ShapeError> {
    if !(2..=64).contains(&corners) {
        return Err(ShapeError::OutOfRange { what: "the number of corners (2 to 64)" });
    }
    if !(corner_radius > 0.0 && corner_radius <= 1.0 && (0.02..=PI).contains(&smoothness_rad)) {
        return Err(ShapeError::OutOfRange { what: "the corner radius (up to 1) and smoothness (0.02 to pi rad)" });
    }
    let mut harmonics = Vec::new();
    for k in 1..=512_u32 {
        let order = f64::from(k);
        let spread = (-0.5 * order * order * smoothness_rad * smoothness_rad).exp();
        if spread < 1e-15 {
            break;
        }
        let curvature = if k % corners == 0 { 2.0 * (1.0 - corner_radius) * spread } else { 0.0 };
        harmonics.push([curvature / (1.0 - order * order).min(-1.0), 0.0]);
    }
    Ok(SupportFunction::new(1.0, harmonics))
}

/// The shape moved so that its origin is the centroid of its area (an even mass).
fn about_centroid(shape: &SupportFunction) -> SupportFunction {
    let centroid = shape.centroid();
    shape.translated(-centroid.x_m, -centroid.y_m)
}
