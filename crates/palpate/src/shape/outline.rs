//! Shapes from outlines: as many harmonics as the outline asks for, and what the fit costs it in corners and sides.

use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

use super::fit::{area_and_centroid, convex_hull};
use super::{BoundaryPoint, ShapeError, SupportFunction};

/// A fit this close to the outline, as a share of the mean radius, is close enough: 0.03 mm of an object of 30 mm, less than the noise of
/// any pad.
const OUTLINE_TOLERANCE: f64 = 1e-3;
/// Most harmonics of a shape made from an outline: with them sharp corners and flat sides of 60 mm are followed to 0.3 mm. A convex series
/// comes closer in inverse proportion to their number.
const MOST_OUTLINE_HARMONICS: usize = 256;
/// Fewest that are tried; twice as many follow.
const FEWEST_OUTLINE_HARMONICS: usize = 8;
/// Normal angles at which an outline is read.
const OUTLINE_NODES: usize = 2880;

/// A convex shape made from an outline, and how far it is from it. Few harmonics round corners off and let flat sides bulge.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineFit {
    /// The shape, about its centre of mass.
    pub shape: SupportFunction,
    /// How far the outline stands out of the shape at most, metres: what its corners lose.
    pub cut_m: f64,
    /// How far the shape stands out of the convex hull of the outline at most, metres: what its sides gain.
    pub bulge_m: f64,
    /// Depth of the deepest dent of the outline, metres: palms feel the convex hull, which closes it. 0 for a convex outline.
    pub dent_m: f64,
}

impl OutlineFit {
    /// Largest distance between the shape and the convex hull of the outline, metres (the Hausdorff distance of the two).
    pub fn residual_m(&self) -> f64 {
        self.cut_m.max(self.bulge_m)
    }

    /// Whether the outline has a dent that counts: one deeper than the tolerance of the fit.
    pub fn is_dented(&self) -> bool {
        self.dent_m > OUTLINE_TOLERANCE * self.shape.mean_radius_m()
    }

    /// A shape against the support function (θ, r) of its outline.
    fn against(shape: SupportFunction, outline: impl Iterator<Item = (f64, f64)>) -> Self {
        let (mut cut_m, mut bulge_m) = (0.0_f64, 0.0_f64);
        for (theta, r) in outline {
            let gained_m = shape.radius_m(theta) - r;
            (cut_m, bulge_m) = (cut_m.max(-gained_m), bulge_m.max(gained_m));
        }
        Self { shape, cut_m, bulge_m, dent_m: 0.0 }
    }

    /// A shape without error.
    pub(super) fn exact(shape: SupportFunction) -> Self {
        Self { shape, cut_m: 0.0, bulge_m: 0.0, dent_m: 0.0 }
    }

    /// The same in another size, `factor` times as large.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            shape: self.shape.scaled(factor),
            cut_m: factor * self.cut_m,
            bulge_m: factor * self.bulge_m,
            dent_m: factor * self.dent_m,
        }
    }

    /// The same about another centre of mass, (x, y) metres from this one.
    pub fn about(&self, x_m: f64, y_m: f64) -> Self {
        Self { shape: self.shape.translated(-x_m, -y_m), ..self.clone() }
    }
}

impl SupportFunction {
    /// The shape of an outline, given by points in order round it (or the corners of a polygon), metres.
    ///
    /// A support function describes what is convex: the shape is that of the convex hull, with as many harmonics as it takes to come within
    /// a thousandth of the mean radius, 256 at most; the fit says how far it is off. The origin, the centre of mass, is the centroid of the
    /// area within the outline.
    ///
    /// # Errors
    /// With fewer than three points, points on a line, an outline that crosses itself so much that it has no area, or coordinates that are not
    /// finite.
    pub fn from_outline(points: &[BoundaryPoint]) -> Result<OutlineFit, ShapeError> {
        if points.len() < 3 {
            return Err(ShapeError::TooFewPoints { points: points.len(), order: FEWEST_OUTLINE_HARMONICS, needed: 3 });
        }
        if let Some(index) = points.iter().position(|point| !point.x_m.is_finite() || !point.y_m.is_finite()) {
            return Err(ShapeError::NotFinite { index });
        }
        let hull = convex_hull(points);
        let (hull_area_m2, _) = area_and_centroid(&hull).ok_or(ShapeError::Undetermined)?;
        let (_, center) = area_and_centroid(points)
            .or_else(|| area_and_centroid(&points.iter().rev().copied().collect::<Vec<_>>()))
            .filter(|(area_m2, _)| *area_m2 > 1e-9 * hull_area_m2)
            .ok_or(ShapeError::Undetermined)?;
        let extent_m = points.iter().map(|p| (p.x_m - center.x_m).hypot(p.y_m - center.y_m)).fold(0.0, f64::max);
        if hull_area_m2 <= 1e-12 * extent_m * extent_m {
            return Err(ShapeError::Undetermined);
        }
        let dent_m = deepest_dent_m(points, &hull);
        let hull: Vec<BoundaryPoint> =
            hull.iter().map(|p| BoundaryPoint { x_m: p.x_m - center.x_m, y_m: p.y_m - center.y_m }).collect();
        let height = |point: &BoundaryPoint, theta: f64| {
            let (sin, cos) = theta.sin_cos();
            point.x_m * cos + point.y_m * sin
        };
        let node = |node: usize| TAU * node as f64 / OUTLINE_NODES as f64;
        let r = |theta: f64| hull.iter().map(|point| height(point, theta)).fold(f64::NEG_INFINITY, f64::max);
        let nodes = (0..OUTLINE_NODES).map(node).map(|theta| (theta, r(theta)));
        // Where a side is flat r has a kink, and the fit is worst.
        let sides = sides(&hull);
        let kinks = sides.iter().zip(&hull).map(|(side, from)| (side.normal_rad, height(from, side.normal_rad)));
        let support: Vec<(f64, f64)> = nodes.chain(kinks).collect();
        let all = of_polygon(&hull, &sides, MOST_OUTLINE_HARMONICS);
        let truncated = |order: usize| {
            let harmonics = all.harmonics_m().iter().take(order).copied().collect();
            Ok(SupportFunction::new(all.mean_radius_m(), harmonics))
        };
        Ok(OutlineFit { dent_m, ..fit(&support, truncated, MOST_OUTLINE_HARMONICS)? })
    }

    /// The convex shape closest to samples (θ in radians, r in metres) of a support function about the centre of mass, with as many harmonics as
    /// for [`Self::from_outline`], but no more than a third of the samples.
    ///
    /// # Errors
    /// As [`Self::from_samples`].
    pub fn from_support(samples: &[(f64, f64)]) -> Result<OutlineFit, ShapeError> {
        let most = MOST_OUTLINE_HARMONICS.min(samples.len().saturating_sub(1) / 3).max(1);
        fit(samples, |order| Self::from_samples(samples, order), most)
    }
}

/// A side of a convex polygon.
struct Side {
    length_m: f64,
    /// Angle of its outward normal.
    normal_rad: f64,
}

/// The sides of a polygon with its corners counter-clockwise; each begins at the corner of its index.
fn sides(hull: &[BoundaryPoint]) -> Vec<Side> {
    let next = hull.iter().skip(1).chain(hull.first());
    let side = |(from, to): (&BoundaryPoint, &BoundaryPoint)| {
        let (x_m, y_m) = (to.x_m - from.x_m, to.y_m - from.y_m);
        Side { length_m: x_m.hypot(y_m), normal_rad: (-x_m).atan2(y_m) }
    };
    hull.iter().zip(next).map(side).collect()
}

/// The first harmonics of the support function of a convex polygon, exactly: its radius of curvature is nothing but a peak of weight `length_m` at the
/// normal of each side, and r_k = v_k / (1 − k²).
fn of_polygon(hull: &[BoundaryPoint], sides: &[Side], order: usize) -> SupportFunction {
    let perimeter_m: f64 = sides.iter().map(|side| side.length_m).sum();
    let harmonic = |k: usize| {
        let order = k as f64;
        let peaks = sides.iter().fold([0.0, 0.0], |[cosines, sines], side| {
            let (sin, cos) = (order * side.normal_rad).sin_cos();
            [cosines + side.length_m * cos, sines + side.length_m * sin]
        });
        peaks.map(|peaks| peaks / (PI * (1.0 - order * order)))
    };
    // The first harmonic is where the polygon lies: ∮ r n dθ / π, corner by corner from the side before to the side after.
    let mut first = [0.0, 0.0];
    for (index, corner) in hull.iter().enumerate() {
        let from = sides[(index + sides.len() - 1) % sides.len()].normal_rad;
        let turn = (sides[index].normal_rad - from).rem_euclid(TAU);
        let ((sin0, cos0), (sin1, cos1)) = (from.sin_cos(), (from + turn).sin_cos());
        let half = 0.5 * (sin1 * cos1 - sin0 * cos0);
        let (cos2, sin2, mixed) = (0.5 * turn + half, 0.5 * turn - half, 0.5 * (sin1 * sin1 - sin0 * sin0));
        first[0] += (corner.x_m * cos2 + corner.y_m * mixed) / PI;
        first[1] += (corner.x_m * mixed + corner.y_m * sin2) / PI;
    }
    let harmonics = std::iter::once(first).chain((2..=order).map(harmonic)).collect();
    SupportFunction::new(perimeter_m / TAU, harmonics)
}

/// The convex shape with the fewest harmonics, up to `most`, that comes close enough to a support function (θ, r); `series` has as many as asked for.
fn fit(
    support: &[(f64, f64)],
    series: impl Fn(usize) -> Result<SupportFunction, ShapeError>,
    most: usize,
) -> Result<OutlineFit, ShapeError> {
    let mut order = FEWEST_OUTLINE_HARMONICS.min(most);
    loop {
        let fit = OutlineFit::against(series(order)?.damped_to_convex(), support.iter().copied());
        if order >= most || fit.residual_m() <= OUTLINE_TOLERANCE * fit.shape.mean_radius_m() {
            return Ok(fit);
        }
        order = (2 * order).min(most);
    }
}

/// How deep the points, in order, lie inside the sides of their hull.
fn deepest_dent_m(points: &[BoundaryPoint], hull: &[BoundaryPoint]) -> f64 {
    let bits = |point: &BoundaryPoint| (point.x_m.to_bits(), point.y_m.to_bits());
    let corners: BTreeSet<_> = hull.iter().map(bits).collect();
    let on_hull: Vec<usize> = (0..points.len()).filter(|&index| corners.contains(&bits(&points[index]))).collect();
    let mut deepest = 0.0_f64;
    for (place, &from) in on_hull.iter().enumerate() {
        let to = on_hull.get(place + 1).copied().unwrap_or(on_hull[0] + points.len());
        let (a, b) = (points[from], points[to % points.len()]);
        let (x, y) = (b.x_m - a.x_m, b.y_m - a.y_m);
        let length = x.hypot(y);
        for index in from + 1..to {
            let point = points[index % points.len()];
            let across = x * (point.y_m - a.y_m) - y * (point.x_m - a.x_m);
            if length > 0.0 {
                deepest = deepest.max(across.abs() / length);
            }
        }
    }
    deepest
}

/// A rectangle with rounded corners about its middle, long side along x, all in metres.
///
/// A stadium is one whose corners have a radius of half its width.
///
/// # Errors
/// When a size is not positive and finite, or the corner radius is below 0 or above half of a side.
pub fn rounded_rectangle(length_m: f64, width_m: f64, corner_radius_m: f64) -> Result<OutlineFit, ShapeError> {
    if ![length_m, width_m].iter().all(|side| *side > 0.0 && side.is_finite()) {
        return Err(ShapeError::OutOfRange { what: "the sides of a rectangle" });
    }
    if !(0.0..=0.5 * length_m.min(width_m)).contains(&corner_radius_m) {
        return Err(ShapeError::CornerRadius);
    }
    let (x_m, y_m) = (0.5 * length_m - corner_radius_m, 0.5 * width_m - corner_radius_m);
    // |cos θ| = 2/π − 4/π Σ (−1)^m cos 2mθ / (4m² − 1), and |sin θ| the same a quarter turn on.
    let even = |m: usize| {
        let sign = if m.is_multiple_of(2) { 1.0 } else { -1.0 };
        [0.0, -4.0 / PI * (sign * x_m + y_m) / (4.0 * (m * m) as f64 - 1.0)]
    };
    let harmonics = (1..=MOST_OUTLINE_HARMONICS / 2).flat_map(even).map(|a| [a, 0.0]).collect();
    let shape = SupportFunction::new(corner_radius_m + 2.0 / PI * (x_m + y_m), harmonics).averaged_to_convex();
    let r = |theta: f64| x_m * theta.cos().abs() + y_m * theta.sin().abs() + corner_radius_m;
    let samples =
        (0..OUTLINE_NODES).map(|node| TAU * node as f64 / OUTLINE_NODES as f64).map(|theta| (theta, r(theta)));
    Ok(OutlineFit::against(shape, samples))
}
