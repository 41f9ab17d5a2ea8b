//! Hausdorff distance of two outlines on their felt part.

use std::f64::consts::TAU;

use super::alignment::Felt;
use crate::shape::{BoundaryPoint, SupportFunction};

/// Corners of the polygons that stand for the outlines; they lie within (2π/4096)²/8 ≈ 3·10⁻⁷ radii of curvature of them.
const CORNERS: usize = 4096;

/// The largest distance from a felt point of `found` to the outline of `truth`, or from its counterpart on `truth` to the
/// outline of `found`, with `truth` turned by `angle_rad`; metres.
pub(super) fn distance_m(felt: &[Felt], found: &SupportFunction, truth: &SupportFunction, angle_rad: f64) -> f64 {
    let truth = truth.rotated(angle_rad);
    let one_way = |from: &SupportFunction, to: &SupportFunction| {
        let outline: Vec<BoundaryPoint> =
            (0..CORNERS).map(|corner| to.boundary_point(TAU * corner as f64 / CORNERS as f64)).collect();
        felt.iter().map(|point| distance_to(&outline, from.boundary_point(point.theta_rad))).fold(0.0, f64::max)
    };
    one_way(found, &truth).max(one_way(&truth, found))
}

/// Distance of a point to a closed polygon line.
fn distance_to(polygon: &[BoundaryPoint], point: BoundaryPoint) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    let squares = polygon.iter().zip(next).map(|(a, b)| {
        let (ux, uy) = (b.x_m - a.x_m, b.y_m - a.y_m);
        let (px, py) = (point.x_m - a.x_m, point.y_m - a.y_m);
        let length2 = ux * ux + uy * uy;
        let along = if length2 > 0.0 { ((px * ux + py * uy) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let (x, y) = (px - along * ux, py - along * uy);
        x * x + y * y
    });
    squares.fold(f64::INFINITY, f64::min).sqrt()
}
