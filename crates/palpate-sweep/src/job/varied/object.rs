//! Objects of many kinds, with their mass in the middle or up to 0.3 mean radii from it.

use std::f64::consts::TAU;

use palpate::shape::{RandomShape, ShapeError, SupportFunction, ellipse, random_shape, rounded_polygon};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::job::object::{Object, off_centre};

/// Largest distance of the centre of mass from the centroid, over the mean radius.
const MASS_OFFSET: f64 = 0.3;

/// Share of the objects of even mass.
const EVEN_SHARE: f64 = 0.3;

/// Harmonics of shapes that are given as a function.
const ORDER: usize = 40;

/// Normal angles at which such a function is read.
const NODES: usize = 720;

/// Draws one: what it is called, and its support function about the centre of mass.
pub(super) fn draw(rng: &mut ChaCha8Rng) -> Result<(String, SupportFunction), ShapeError> {
    let radius = rng.random_range(0.018..0.04);
    let (name, unit) = match rng.random_range(0..10) {
        0 | 1 => return Object::Mixed.draw(rng),
        2 => return Object::Symmetric.draw(rng),
        3 => stadium(rng.random_range(0.2..1.0))?,
        4 => superellipse(rng.random_range(0.6..1.0), rng.random_range(2.2..4.0))?,
        5 => constant_width(rng),
        6 => stadium(rng.random_range(1.9..2.1))?,
        7 => nearly_round(rng),
        8 => flat_sided(rng)?,
        _ => nearly_symmetric(rng)?,
    };
    let unit = unit.scaled(1.0 / unit.mean_radius_m());
    let offset = MASS_OFFSET * rng.random_range(0.0f64..1.0).sqrt();
    let shape = if rng.random_bool(EVEN_SHARE) { off_centre(&unit, 0.0, rng) } else { off_centre(&unit, offset, rng) };
    Ok((name, shape.scaled(radius).rotated(rng.random_range(0.0..TAU))))
}

/// The shape with this support function, made convex where its series is not.
fn of_function(r: impl Fn(f64) -> f64) -> Result<SupportFunction, ShapeError> {
    let samples: Vec<(f64, f64)> =
        (0..NODES).map(|node| TAU * node as f64 / NODES as f64).map(|theta| (theta, r(theta))).collect();
    SupportFunction::from_samples(&samples, ORDER).map(|shape| shape.damped_to_convex())
}

/// Two half discs of radius 1, `length` (times two) apart; with 2 a bar three times as long as wide.
fn stadium(length: f64) -> Result<(String, SupportFunction), ShapeError> {
    // Sides that bulge by a hair: those of a support function cannot be quite flat.
    const BULGE: f64 = 0.03;
    let shape = of_function(|theta| 1.0 + length * theta.cos().hypot(BULGE * theta.sin()))?;
    let kind = if length > 1.5 { "bar" } else { "stadium" };
    Ok((format!("{kind} {:.1}", 1.0 + length), shape))
}

/// |x|^p + |y/ratio|^p = 1, by its support function (|cos|^q + |ratio sin|^q)^(1/q), 1/p + 1/q = 1.
fn superellipse(ratio: f64, power: f64) -> Result<(String, SupportFunction), ShapeError> {
    let dual = power / (power - 1.0);
    let r = |theta: f64| (theta.cos().abs().powf(dual) + (ratio * theta.sin()).abs().powf(dual)).powf(1.0 / dual);
    Ok((format!("superellipse {power:.1} {ratio:.2}"), of_function(r)?))
}

/// Constant width: odd harmonics alone, as in a Reuleaux triangle with round corners.
fn constant_width(rng: &mut ChaCha8Rng) -> (String, SupportFunction) {
    let corners: usize = [3, 5, 7][rng.random_range(0..3)];
    // v = 1 − (k² − 1) c cos kθ stays positive.
    let size = rng.random_range(0.4..0.9) / (corners * corners - 1) as f64;
    let mut harmonics = vec![[0.0, 0.0]; corners];
    harmonics[corners - 1][0] = size;
    (format!("constant width {corners}"), SupportFunction::new(1.0, harmonics))
}

/// Round to about a per cent.
fn nearly_round(rng: &mut ChaCha8Rng) -> (String, SupportFunction) {
    let harmonics = (1..=5_u32)
        .map(|k| {
            let size = 0.01 / f64::from(k);
            if k == 1 { [0.0, 0.0] } else { [rng.random_range(-size..size), rng.random_range(-size..size)] }
        })
        .collect();
    ("nearly round".to_owned(), SupportFunction::new(1.0, harmonics).damped_to_convex())
}

/// A polygon with flat sides and small corners.
fn flat_sided(rng: &mut ChaCha8Rng) -> Result<(String, SupportFunction), ShapeError> {
    let corners = rng.random_range(3..=6);
    let smoothness = rng.random_range(0.12..0.2);
    Ok((format!("flat sides {corners}"), rounded_polygon(corners, rng.random_range(0.1..0.2), smoothness)?))
}

/// A symmetric object with something on it: its harmonics differ from symmetry by 0.2 to 2 % of the radius.
fn nearly_symmetric(rng: &mut ChaCha8Rng) -> Result<(String, SupportFunction), ShapeError> {
    let corners = rng.random_range(2..=5);
    let symmetric = match corners {
        2 => ellipse(1.0, rng.random_range(0.6..0.9))?,
        _ => rounded_polygon(corners, rng.random_range(0.3..0.5), rng.random_range(0.3..0.5))?,
    };
    let mark = 10.0_f64.powf(rng.random_range(-2.7..-1.7));
    let kind = RandomShape { mean_radius_m: 1.0, order: 6, mass_offset: 0.0, ..RandomShape::default() };
    let other = random_shape(&kind, rng.random())?;
    let size = other.harmonics_m().iter().flatten().map(|value| 0.5 * value * value).sum::<f64>().sqrt();
    let scale = mark * symmetric.mean_radius_m() / size;
    let of_both = |theta: f64| symmetric.radius_m(theta) + scale * (other.radius_m(theta) - other.mean_radius_m());
    Ok((format!("nearly symmetric {corners} {:.1} %", 100.0 * mark), of_function(of_both)?))
}
