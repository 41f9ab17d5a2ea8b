//! The shape as it stands in the page where no script draws it.

use palpate::Reconstruction;
use std::fmt::Write;

use crate::html;

/// Side of the picture in its own units, and what stays free around the outline.
const SIDE: f64 = 400.0;
const BORDER: f64 = 24.0;
/// Points that the outline is drawn with.
const POINTS: usize = 360;

/// A card with the outline; nothing but a note where there is none.
pub(crate) fn still(result: &Reconstruction) -> String {
    let itself = result.felt_itself();
    let points = result.outline.iter().zip(itself).map(|(point, itself)| {
        let class = match (point.touches > 0, itself) {
            (true, true) => "felt",
            (true, false) => "copied",
            (false, _) => "unfelt",
        };
        ([point.x_m, point.y_m], class)
    });
    let drawing = Still::of(points.collect()).map(|still| still.drawn("", &center_mark(still.place([0.0; 2]))));
    let card = drawing.map(|drawing| {
        format!(
            "<section class=\"card still\"><h2>Shape</h2>{drawing}\
             <p>Solid: felt. Dashed: never felt, or known by symmetry. The mark is the centre of mass.</p></section>"
        )
    });
    card.unwrap_or_default() + &note()
}

/// The mark of a centre of mass.
pub(crate) fn center_mark((x, y): (f64, f64)) -> String {
    format!(
        "<circle class=\"com-disc\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"7\"/>\
         <path class=\"com-quarter\" d=\"M{x:.1} {y:.1}v-7a7 7 0 0 1 7 7zm0 0v7a7 7 0 0 1 -7 -7z\"/>"
    )
}

/// An outline, closed, each point with the class of the line that begins there.
pub(crate) struct Still<'a> {
    points: Vec<([f64; 2], &'a str)>,
    middle_m: [f64; 2],
    /// Units of the picture per metre.
    scale: f64,
}

impl<'a> Still<'a> {
    /// The outline through points in metres; `None` where there is nothing to draw.
    pub(crate) fn of(all: Vec<([f64; 2], &'a str)>) -> Option<Self> {
        let stride = all.len().div_ceil(POINTS).max(1);
        let finite = |point: [f64; 2]| point.iter().all(|value| value.is_finite());
        let mut points: Vec<_> = all.into_iter().step_by(stride).filter(|(point, _)| finite(*point)).collect();
        let range = |axis: usize| {
            let values = || points.iter().map(|(point, _)| point[axis]);
            (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
        };
        let ((left, right), (low, high)) = (range(0), range(1));
        let scale = (SIDE - 2.0 * BORDER) / (right - left).max(high - low);
        if points.len() < 3 || !scale.is_finite() || scale <= 0.0 {
            return None;
        }
        points.push(points[0]);
        Some(Self { points, middle_m: [0.5 * (left + right), 0.5 * (low + high)], scale })
    }

    /// Where a point in metres is in the picture.
    pub(crate) fn place(&self, [x_m, y_m]: [f64; 2]) -> (f64, f64) {
        let [middle_x_m, middle_y_m] = self.middle_m;
        (0.5 * SIDE + self.scale * (x_m - middle_x_m), 0.5 * SIDE - self.scale * (y_m - middle_y_m))
    }

    /// A path through points in metres.
    pub(crate) fn path(&self, class: &str, points_m: impl Iterator<Item = [f64; 2]>) -> String {
        let mut line = String::new();
        for (index, point) in points_m.enumerate() {
            let (x, y) = self.place(point);
            let _ = write!(line, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        }
        format!("<path class=\"{class}\" d=\"{line}\"/>")
    }

    /// The picture, with a scale, and with what lies below and above the outline.
    pub(crate) fn drawn(&self, below: &str, above: &str) -> String {
        let points = &self.points;
        let mut drawing = below.to_owned();
        let mut from = 0;
        while from + 1 < points.len() {
            // A run of one kind, up to the first point of the next.
            let run = points[from..].iter().take_while(|(_, class)| *class == points[from].1).count();
            let to = (from + run).min(points.len() - 1);
            drawing += &self.path(points[from].1, points[from..=to].iter().map(|(point, _)| *point));
            from = to;
        }
        drawing += above;
        let widest_mm = 0.25 * SIDE / self.scale * 1e3;
        let power = 10f64.powf(widest_mm.log10().floor());
        if let Some(mm) = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|mm| *mm <= widest_mm) {
            let (end, foot) = (SIDE - 4.0, SIDE - 6.0);
            let start = end - 1e-3 * mm * self.scale;
            let _ = write!(
                drawing,
                "<path class=\"scale\" d=\"M{start:.1} {:.1}V{foot:.1}H{end:.1}V{:.1}\"/>\
                 <text class=\"strong\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{} mm</text>",
                foot - 4.0,
                foot - 4.0,
                0.5 * (start + end),
                foot - 7.0,
                html::escape(&crate::figures::decimals(mm, if mm < 1.0 { 4 } else { 0 }))
            );
        }
        format!(
            "<svg viewBox=\"0 0 {SIDE} {SIDE}\" role=\"img\" aria-label=\"Outline of the object in its own frame\">{drawing}</svg>"
        )
    }
}

fn note() -> String {
    "<p class=\"note\">The other figures, and the error bars, are drawn by a script inside this file; enable scripts to see them.</p>"
        .to_owned()
}
