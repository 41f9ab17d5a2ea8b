//! Outlines as SVG, for notebooks.

use std::f64::consts::TAU;
use std::fmt::Write;

use palpate::shape::SupportFunction;
use palpate::{Reconstruction, reconstruct::OutlinePoint};

/// Side of the square picture, in its own units.
const SIDE: f64 = 220.0;
/// Free border.
const BORDER: f64 = 16.0;
/// Points that an outline is drawn with.
const POINTS: u32 = 240;
/// Half the width of a 95 % band, in standard deviations.
const BAND: f64 = 1.959_964;

/// A square picture of an object about its centre of mass.
struct Picture {
    text: String,
    scale: f64,
    middle: [f64; 2],
}

impl Picture {
    /// Large enough for these points (metres).
    fn around(points: &[[f64; 2]]) -> Self {
        let range = |axis: usize| {
            let values = || points.iter().map(|point| point[axis]).filter(|value| value.is_finite());
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((left, right), (bottom, top)) = (range(0), range(1));
        let extent = (right - left).max(top - bottom);
        let extent = if extent.is_finite() && extent > 0.0 { extent } else { 1.0 };
        let mid = |low: f64, high: f64| if low.is_finite() && high.is_finite() { 0.5 * (low + high) } else { 0.0 };
        let mut text = String::new();
        let height = SIDE + 14.0;
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{SIDE}\" height=\"{height}\" viewBox=\"0 0 {SIDE} {height}\" \
             font-family=\"sans-serif\" font-size=\"10\">"
        );
        Self { text, scale: (SIDE - 2.0 * BORDER) / extent, middle: [mid(left, right), mid(bottom, top)] }
    }

    fn place(&self, [x, y]: [f64; 2]) -> (f64, f64) {
        (0.5 * SIDE + self.scale * (x - self.middle[0]), 0.5 * SIDE - self.scale * (y - self.middle[1]))
    }

    fn path(&mut self, points: &[[f64; 2]], closed: bool, style: &str) {
        let mut pen = 'M';
        let mut line = String::new();
        for point in points.iter().filter(|point| point[0].is_finite() && point[1].is_finite()) {
            let (x, y) = self.place(*point);
            let _ = write!(line, "{pen}{x:.2} {y:.2}");
            pen = 'L';
        }
        if closed && !line.is_empty() {
            line.push('Z');
        }
        let _ = write!(self.text, "<path d=\"{line}\" {style}/>");
    }

    /// A cross in the centre of mass and a bar of a round length.
    fn finished(mut self) -> String {
        let (x, y) = self.place([0.0, 0.0]);
        let _ = write!(
            self.text,
            "<path d=\"M{:.2} {y:.2}h10M{x:.2} {:.2}v10\" stroke=\"#c0392b\" stroke-width=\"1.5\" fill=\"none\"/>",
            x - 5.0,
            y - 5.0
        );
        let widest_mm = 1e3 * 0.4 * SIDE / self.scale;
        let power = 10f64.powf(widest_mm.log10().floor());
        let length_mm = [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|l| *l <= widest_mm).unwrap_or(power);
        let width = 1e-3 * length_mm * self.scale;
        let _ = write!(
            self.text,
            "<path d=\"M{BORDER} {SIDE}h{width:.2}\" stroke=\"#777\" stroke-width=\"1.5\"/>\
             <text x=\"{:.2}\" y=\"{:.2}\" fill=\"#777\">{length_mm} mm</text></svg>",
            BORDER + width + 5.0,
            SIDE + 3.5
        );
        self.text
    }
}

/// The outline of a shape.
pub fn outline(shape: &SupportFunction) -> String {
    let points: Vec<[f64; 2]> = (0..POINTS)
        .map(|step| shape.boundary_point(TAU * f64::from(step) / f64::from(POINTS)))
        .map(|point| [point.x_m, point.y_m])
        .collect();
    let mut picture = Picture::around(&points);
    picture.path(&points, true, "fill=\"#2a78c4\" fill-opacity=\"0.12\" stroke=\"#2a78c4\" stroke-width=\"1.5\"");
    picture.finished()
}

/// The outline of a result with its 95 % band; dashed where it was never felt.
pub fn result(result: &Reconstruction) -> String {
    let moved = |point: &OutlinePoint, by: f64| {
        let (sin, cos) = point.theta_rad.sin_cos();
        [point.x_m + by * cos, point.y_m + by * sin]
    };
    let stride = (result.outline.len() / POINTS as usize).max(1);
    let mut points: Vec<&OutlinePoint> = result.outline.iter().step_by(stride).collect();
    points.extend(result.outline.first());
    let line: Vec<[f64; 2]> = points.iter().map(|point| moved(point, 0.0)).collect();
    let mut picture = Picture::around(&line);
    picture.path(&line, false, "fill=\"none\" stroke=\"#999\" stroke-dasharray=\"3 3\"");
    for run in points.chunk_by(|a, b| (a.touches > 0) == (b.touches > 0)) {
        if run.first().is_some_and(|point| point.touches > 0) {
            let mut band: Vec<[f64; 2]> = run.iter().map(|point| moved(point, BAND * point.r_sd_m)).collect();
            band.extend(run.iter().rev().map(|point| moved(point, -BAND * point.r_sd_m)));
            picture.path(&band, true, "fill=\"#2a78c4\" fill-opacity=\"0.3\" stroke=\"none\"");
            let along: Vec<[f64; 2]> = run.iter().map(|point| moved(point, 0.0)).collect();
            picture.path(&along, false, "fill=\"none\" stroke=\"#2a78c4\" stroke-width=\"1.5\"");
        }
    }
    picture.finished()
}
