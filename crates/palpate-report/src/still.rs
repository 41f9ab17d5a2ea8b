//! The shape as it stands in the page where no script may draw it.

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
    let stride = result.outline.len().div_ceil(POINTS).max(1);
    let itself = result.felt_itself();
    let finite = |point: [f64; 2]| point.iter().all(|value| value.is_finite());
    let mut points: Vec<([f64; 2], &str)> = result
        .outline
        .iter()
        .zip(itself)
        .step_by(stride)
        .map(|(point, itself)| {
            let class = match (point.touches > 0, itself) {
                (true, true) => "felt",
                (true, false) => "copied",
                (false, _) => "unfelt",
            };
            ([point.x_m, point.y_m], class)
        })
        .filter(|(point, _)| finite(*point))
        .collect();
    let range = |axis: usize| {
        let values = || points.iter().map(|(point, _)| point[axis]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    };
    let ((left, right), (low, high)) = (range(0), range(1));
    let scale = (SIDE - 2.0 * BORDER) / (right - left).max(high - low);
    if points.len() < 3 || !scale.is_finite() || scale <= 0.0 {
        return note();
    }
    let place = |[x, y]: [f64; 2]| {
        (0.5 * SIDE + scale * (x - 0.5 * (left + right)), 0.5 * SIDE - scale * (y - 0.5 * (low + high)))
    };
    points.push(points[0]);
    let mut drawing = String::new();
    let mut from = 0;
    while from + 1 < points.len() {
        // A run of one kind, up to the first point of the next.
        let run = points[from..].iter().take_while(|(_, class)| *class == points[from].1).count();
        let to = (from + run).min(points.len() - 1);
        let mut line = String::new();
        for (index, (point, _)) in points[from..=to].iter().enumerate() {
            let (x, y) = place(*point);
            let _ = write!(line, "{}{x:.1} {y:.1}", if index == 0 { 'M' } else { 'L' });
        }
        let _ = write!(drawing, "<path class=\"{}\" d=\"{line}\"/>", points[from].1);
        from = to;
    }
    let (x, y) = place([0.0; 2]);
    let _ = write!(
        drawing,
        "<circle class=\"com-disc\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"7\"/>\
         <path class=\"com-quarter\" d=\"M{x:.1} {y:.1}v-7a7 7 0 0 1 7 7zm0 0v7a7 7 0 0 1 -7 -7z\"/>"
    );
    let widest_mm = 0.25 * SIDE / scale * 1e3;
    let power = 10f64.powf(widest_mm.log10().floor());
    if let Some(mm) = [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|mm| *mm <= widest_mm) {
        let (end, foot) = (SIDE - 4.0, SIDE - 6.0);
        let start = end - 1e-3 * mm * scale;
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
        "<section class=\"card still\"><h2>Shape</h2>\
         <svg viewBox=\"0 0 {SIDE} {SIDE}\" role=\"img\" aria-label=\"Outline of the object in its own frame\">{drawing}</svg>\
         <p>Solid: felt. Dashed: never felt, or known by symmetry. The mark is the centre of mass.</p></section>{}",
        note()
    )
}

fn note() -> String {
    "<p class=\"note\">The other figures, and the error bars, are drawn by a script inside this file; enable scripts to see them.</p>"
        .to_owned()
}
