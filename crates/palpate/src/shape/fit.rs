//! Support functions from other descriptions of a shape, by least squares in the harmonics: sampled support functions,
//! boundary points, polygons.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};
use thiserror::Error;

use super::{BoundaryPoint, SupportFunction};

/// Share of a circle that makes up for a radius of curvature that rounding has left below zero.
const ROUNDING: f64 = 1e-9;

/// Why a shape could not be made from data.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// Too few points for the number of harmonics.
    #[error("{points} points are too few: {order} harmonics need at least {needed}")]
    TooFewPoints {
        /// How many there are.
        points: usize,
        /// Number of harmonics asked for.
        order: usize,
        /// How many it takes.
        needed: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {index} (from 0) is not finite")]
    NotFinite {
        /// Index of the point.
        index: usize,
    },
    /// The points lie on a line or leave so wide a gap that the harmonics are not determined.
    #[error(
        "the points do not determine a shape: they lie on a line, or leave a gap too wide for the number of harmonics"
    )]
    Undetermined,
    /// The corners of a rectangle cannot be rounded so much.
    #[error("the corner radius of a rectangle must be from 0 to half of its shorter side")]
    CornerRadius,
    /// The mean radius, or another size, is not positive and finite.
    #[error("{what} must be positive and finite")]
    OutOfRange {
        /// Which.
        what: &'static str,
    },
}

impl SupportFunction {
    /// The support function of `order` harmonics closest, in least squares, to samples (θ in radians, r in metres).
    ///
    /// Exact for samples of a support function of at most `order` harmonics. The result need not be convex.
    ///
    /// # Errors
    /// With fewer than 2 `order` + 1 samples, values that are not finite, or angles that do not determine the harmonics.
    pub fn from_samples(samples: &[(f64, f64)], order: usize) -> Result<Self, ShapeError> {
        let size = 2 * order + 1;
        if samples.len() < size {
            return Err(ShapeError::TooFewPoints { points: samples.len(), order, needed: size });
        }
        if let Some(index) = samples.iter().position(|(theta, r)| !theta.is_finite() || !r.is_finite()) {
            return Err(ShapeError::NotFinite { index });
        }
        if let Some(fit) = from_even_samples(samples, order) {
            return Ok(fit);
        }
        let mut normal = DMatrix::<f64>::zeros(size, size);
        let mut right = DVector::<f64>::zeros(size);
        let mut row = vec![0.0; size];
        for &(theta, r) in samples {
            row[0] = 1.0;
            for k in 1..=order {
                let (sin, cos) = (k as f64 * theta).sin_cos();
                (row[k], row[order + k]) = (cos, sin);
            }
            for i in 0..size {
                right[i] += row[i] * r;
                for j in 0..=i {
                    normal[(i, j)] += row[i] * row[j];
                }
            }
        }
        normal.fill_upper_triangle_with_lower_triangle();
        // The diagonal is about N / 2; a pivot far below it says that the angles leave a combination undetermined.
        let solver = normal.cholesky().ok_or(ShapeError::Undetermined)?;
        let floor = 1e-5 * (samples.len() as f64).sqrt();
        if solver.l_dirty().diagonal().iter().any(|pivot| *pivot < floor) {
            return Err(ShapeError::Undetermined);
        }
        Ok(Self::from_coefficients(solver.solve(&right).as_slice()))
    }

    /// The support function of `order` harmonics closest to the convex hull of boundary points (or of the corners of a
    /// polygon), metres, in any order.
    ///
    /// The origin of the object frame, its centre of mass, is `center_of_mass`, or the centroid of the hull's area. Corners
    /// are rounded as much as the number of harmonics asks for ([`Self::damped_to_convex`]); [`Self::from_outline`] chooses that number by the
    /// outline, and says what is lost.
    ///
    /// # Errors
    /// With fewer than three points, points on a line, or coordinates that are not finite.
    pub fn from_boundary_points(
        points: &[BoundaryPoint],
        order: usize,
        center_of_mass: Option<BoundaryPoint>,
    ) -> Result<Self, ShapeError> {
        if points.len() < 3 {
            return Err(ShapeError::TooFewPoints { points: points.len(), order, needed: 3 });
        }
        if let Some(index) = points.iter().position(|point| !point.x_m.is_finite() || !point.y_m.is_finite()) {
            return Err(ShapeError::NotFinite { index });
        }
        let hull = convex_hull(points);
        let (area, centroid) = area_and_centroid(&hull).ok_or(ShapeError::Undetermined)?;
        let extent = points.iter().map(|p| (p.x_m - centroid.x_m).hypot(p.y_m - centroid.y_m)).fold(0.0, f64::max);
        let center = center_of_mass.unwrap_or(centroid);
        if area <= 1e-12 * extent * extent || !(center.x_m.is_finite() && center.y_m.is_finite()) {
            return Err(ShapeError::Undetermined);
        }
        let count = (16 * (order + 1)).max(720);
        let samples: Vec<(f64, f64)> = (0..count)
            .map(|index| {
                let theta = TAU * index as f64 / count as f64;
                let (sin, cos) = theta.sin_cos();
                let r = hull.iter().map(|p| (p.x_m - center.x_m) * cos + (p.y_m - center.y_m) * sin);
                (theta, r.fold(f64::NEG_INFINITY, f64::max))
            })
            .collect();
        Ok(Self::from_samples(&samples, order)?.damped_to_convex())
    }

    /// The shape with its harmonics from the second on damped just enough (to 0.1 %) to make it convex.
    ///
    /// The radius of curvature is mixed with its average under the Jackson kernel, the narrowest of the kernels of this order
    /// that are nowhere negative (Weiße et al., Rev. Mod. Phys. 78, 275, 2006, eq. 71): where a convex outline has lost its
    /// convexity through the cut of its harmonics, this brings it back and rounds it by about π / K. Any other outline is
    /// shrunk towards a circle as well.
    pub fn damped_to_convex(&self) -> Self {
        let jackson = jackson(self.harmonics_m().len());
        if self.mixed(1.0, jackson).is_convex() {
            return least_convex(|part| self.mixed(part, jackson));
        }
        let averaged = self.averaged_to_convex();
        if averaged.is_convex() { averaged } else { least_convex(|part| averaged.mixed(part, |_| 0.0)) }
    }

    /// The shape whose radius of curvature is the average of that of this one under the Jackson kernel: convex where these are the harmonics of a
    /// convex outline.
    pub(super) fn averaged_to_convex(&self) -> Self {
        let averaged = self.mixed(1.0, jackson(self.harmonics_m().len()));
        if averaged.is_convex() { averaged } else { averaged.mixed(ROUNDING, |_| 0.0) }
    }

    /// Harmonic k ≥ 2 multiplied by 1 − part + part · factor(k).
    fn mixed(&self, part: f64, factor: impl Fn(f64) -> f64) -> Self {
        let harmonics = self.harmonics_m().iter().enumerate().map(|(index, &[a, b])| {
            let scale = if index == 0 { 1.0 } else { 1.0 - part + part * factor((index + 1) as f64) };
            [a * scale, b * scale]
        });
        Self::new(self.mean_radius_m(), harmonics.collect())
    }
}

/// What the Jackson kernel of this order multiplies harmonic k by.
fn jackson(order: usize) -> impl Fn(f64) -> f64 + Copy {
    let moments = order as f64 + 1.0;
    move |k| {
        let (sin, cos) = (PI * k / (moments + 1.0)).sin_cos();
        ((moments - k + 1.0) * cos + sin / (PI / (moments + 1.0)).tan()) / (moments + 1.0)
    }
}

/// The convex shape with the smallest part from 0 to 1, given that it is convex at 1.
fn least_convex(shape: impl Fn(f64) -> SupportFunction) -> SupportFunction {
    if shape(0.0).is_convex() {
        return shape(0.0);
    }
    let (mut bumpy, mut smooth) = (0.0, 1.0);
    while smooth - bumpy > 1e-3 {
        let middle = 0.5 * (bumpy + smooth);
        if shape(middle).is_convex() { smooth = middle } else { bumpy = middle }
    }
    shape(smooth)
}

/// The fit to angles that divide the circle evenly, where the harmonics are orthogonal.
fn from_even_samples(samples: &[(f64, f64)], order: usize) -> Option<SupportFunction> {
    let count = samples.len();
    let step = TAU / count as f64;
    let first = samples.first()?.0;
    // Files round their angles; those are uneven enough to lose digits here.
    if samples.iter().enumerate().any(|(index, (theta, _))| (theta - first - step * index as f64).abs() > 1e-12) {
        return None;
    }
    let mut coefficients = vec![0.0; 2 * order + 1];
    for &(theta, r) in samples {
        coefficients[0] += r / count as f64;
        for k in 1..=order {
            let (sin, cos) = (k as f64 * theta).sin_cos();
            coefficients[k] += 2.0 * r * cos / count as f64;
            coefficients[order + k] += 2.0 * r * sin / count as f64;
        }
    }
    Some(SupportFunction::from_coefficients(&coefficients))
}

/// The corners of the convex hull, counter-clockwise (Andrew's monotone chain).
pub(super) fn convex_hull(points: &[BoundaryPoint]) -> Vec<BoundaryPoint> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x_m.total_cmp(&b.x_m).then(a.y_m.total_cmp(&b.y_m)));
    let right_turn = |a: BoundaryPoint, b: BoundaryPoint, c: BoundaryPoint| {
        (b.x_m - a.x_m) * (c.y_m - a.y_m) - (b.y_m - a.y_m) * (c.x_m - a.x_m) <= 0.0
    };
    let chain = |points: &mut dyn Iterator<Item = BoundaryPoint>| {
        let mut chain: Vec<BoundaryPoint> = Vec::new();
        for point in points {
            while chain.len() >= 2 && right_turn(chain[chain.len() - 2], chain[chain.len() - 1], point) {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter().copied());
    hull.extend(chain(&mut sorted.iter().rev().copied()));
    hull
}

/// Area and centroid of a polygon with its corners counter-clockwise.
pub(super) fn area_and_centroid(corners: &[BoundaryPoint]) -> Option<(f64, BoundaryPoint)> {
    let origin = *corners.first()?;
    let (mut double_area, mut x, mut y) = (0.0, 0.0, 0.0);
    for (index, corner) in corners.iter().enumerate() {
        let next = corners[(index + 1) % corners.len()];
        let (ax, ay) = (corner.x_m - origin.x_m, corner.y_m - origin.y_m);
        let (bx, by) = (next.x_m - origin.x_m, next.y_m - origin.y_m);
        let cross = ax * by - ay * bx;
        double_area += cross;
        x += cross * (ax + bx);
        y += cross * (ay + by);
    }
    let centroid =
        BoundaryPoint { x_m: origin.x_m + x / (3.0 * double_area), y_m: origin.y_m + y / (3.0 * double_area) };
    (double_area > 0.0 && centroid.x_m.is_finite() && centroid.y_m.is_finite()).then_some((0.5 * double_area, centroid))
}
