//! A sheet to draw on: SVG elements one after the other, in pixels, y downwards. What has no finite place is left out.

use std::fmt::Write;

use crate::drawing::colors::INK;
use crate::html::escape;

/// Fonts of all text. The first is the one that PNG files are made with.
const FONTS: &str = "DejaVu Sans, Verdana, sans-serif";

/// A point in pixels, or in metres where a [`View`] is used.
pub(crate) type Point = [f64; 2];

/// How a line or area is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    pub stroke: &'static str,
    pub width: f64,
    pub fill: &'static str,
    /// Pattern of dashes; empty for a full line.
    pub dashes: &'static str,
}

/// A thin line of that colour.
pub(crate) const fn line(stroke: &'static str, width: f64) -> Pen {
    Pen { stroke, width, fill: "none", dashes: "" }
}

/// An area of that colour without an outline.
pub(crate) const fn area(fill: &'static str) -> Pen {
    Pen { stroke: "none", width: 0.0, fill, dashes: "" }
}

impl Pen {
    /// The same, dashed.
    pub const fn dashed(self) -> Self {
        Self { dashes: "5 4", ..self }
    }

    /// The same, filled.
    pub const fn filled(self, fill: &'static str) -> Self {
        Self { fill, ..self }
    }
}

/// Which end of a text is at its point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text is set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Type {
    pub size: f64,
    pub anchor: Anchor,
    pub color: &'static str,
    pub bold: bool,
    pub italic: bool,
}

/// Plain text of that size in the middle of its point.
pub(crate) const fn plain(size: f64) -> Type {
    Type { size, anchor: Anchor::Middle, color: INK, bold: false, italic: false }
}

impl Type {
    pub const fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    pub const fn colored(self, color: &'static str) -> Self {
        Self { color, ..self }
    }

    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub const fn italic(self) -> Self {
        Self { italic: true, ..self }
    }
}

/// An SVG document in the making.
#[derive(Clone, Debug)]
pub(crate) struct Sheet {
    width: f64,
    height: f64,
    body: String,
}

impl Sheet {
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// A line through points, closed or not; a point that is not finite breaks it.
    pub fn path(&mut self, points: impl IntoIterator<Item = Point>, closed: bool, pen: Pen) {
        let mut d = String::new();
        let mut broken = true;
        for [x, y] in points {
            if !(x.is_finite() && y.is_finite()) {
                broken = true;
                continue;
            }
            let _ = write!(d, "{}{x:.2} {y:.2}", if broken { "M" } else { "L" });
            broken = false;
        }
        if d.is_empty() {
            return;
        }
        let end = if closed { "Z" } else { "" };
        let _ = writeln!(self.body, "<path d=\"{d}{end}\"{}/>", attributes(pen));
    }

    /// What is drawn meanwhile, more or less opaque (0 to 1).
    #[cfg(feature = "png")]
    pub fn faded(&mut self, opacity: f64, draw: impl FnOnce(&mut Self)) {
        let _ = writeln!(self.body, "<g opacity=\"{opacity:.3}\">");
        draw(self);
        let _ = writeln!(self.body, "</g>");
    }

    pub fn segment(&mut self, from: Point, to: Point, pen: Pen) {
        self.path([from, to], false, pen);
    }

    pub fn dot(&mut self, [x, y]: Point, radius: f64, pen: Pen) {
        if x.is_finite() && y.is_finite() {
            let _ = writeln!(self.body, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\"{}/>", attributes(pen));
        }
    }

    /// Many small dots as one element.
    pub fn dots(&mut self, points: impl IntoIterator<Item = Point>, radius: f64, color: &'static str) {
        let mut d = String::new();
        for [x, y] in points.into_iter().filter(|point| point.iter().all(|value| value.is_finite())) {
            let _ = write!(d, "M{x:.1} {y:.1}h0");
        }
        if !d.is_empty() {
            let width = 2.0 * radius;
            let _ = writeln!(
                self.body,
                "<path d=\"{d}\" stroke=\"{color}\" stroke-width=\"{width:.2}\" stroke-linecap=\"round\" fill=\"none\"/>"
            );
        }
    }

    pub fn rectangle(&mut self, [x, y]: Point, [width, height]: Point, pen: Pen) {
        if ![x, y, width, height].iter().all(|value| value.is_finite()) {
            return;
        }
        let _ = writeln!(
            self.body,
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\"{}/>",
            attributes(pen)
        );
    }

    /// A line with a head at its end.
    pub fn arrow(&mut self, from: Point, to: Point, pen: Pen) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy);
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let (ux, uy) = (dx / length, dy / length);
        let head = (4.0 + 2.5 * pen.width).min(0.6 * length);
        let base = [to[0] - ux * head, to[1] - uy * head];
        let side = 0.42 * head;
        self.segment(from, [to[0] - 0.6 * ux * head, to[1] - 0.6 * uy * head], pen);
        let corners = [to, [base[0] - uy * side, base[1] + ux * side], [base[0] + uy * side, base[1] - ux * side]];
        self.path(corners, true, area(pen.stroke));
    }

    /// A line with a head at either end: a dimension.
    pub fn dimension(&mut self, from: Point, to: Point, pen: Pen) {
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        self.arrow(middle, from, pen);
        self.arrow(middle, to, pen);
    }

    pub fn text(&mut self, [x, y]: Point, text: &str, kind: Type) {
        self.turned_text([x, y], 0.0, text, kind);
    }

    /// Text turned by an angle in degrees, counter-clockwise.
    pub fn turned_text(&mut self, [x, y]: Point, degrees: f64, text: &str, kind: Type) {
        if !(x.is_finite() && y.is_finite()) {
            return;
        }
        let anchor = match kind.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let turn =
            if degrees == 0.0 { String::new() } else { format!(" transform=\"rotate({} {x:.2} {y:.2})\"", -degrees) };
        let weight = if kind.bold { " font-weight=\"bold\"" } else { "" };
        let style = if kind.italic { " font-style=\"italic\"" } else { "" };
        let _ = writeln!(
            self.body,
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"{weight}{style}{turn}>{}</text>",
            kind.size,
            kind.color,
            escape(text)
        );
    }

    /// The document, with a title for those who cannot see it.
    pub fn finish(self, title: &str) -> String {
        let Self { width, height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"{FONTS}\" role=\"img\">\n<title>{}</title>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{body}</svg>\n",
            escape(title)
        )
    }
}

fn attributes(pen: Pen) -> String {
    let mut text = format!(" fill=\"{}\"", pen.fill);
    if pen.width > 0.0 {
        let _ = write!(
            text,
            " stroke=\"{}\" stroke-width=\"{:.2}\" stroke-linejoin=\"round\" stroke-linecap=\"round\"",
            pen.stroke, pen.width
        );
    }
    if !pen.dashes.is_empty() {
        let _ = write!(text, " stroke-dasharray=\"{}\"", pen.dashes);
    }
    text
}

/// From metres, y upwards, to a part of a sheet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    scale: f64,
    origin: Point,
}

impl View {
    /// Shows the box from `low` to `high` (metres) as large as it fits, in the middle of a part of the sheet.
    pub fn fitting(low: Point, high: Point, corner: Point, size: Point) -> Self {
        let extent = [0, 1].map(|axis| (high[axis] - low[axis]).max(1e-9));
        let scale = (size[0] / extent[0]).min(size[1] / extent[1]);
        let origin = [
            corner[0] + 0.5 * size[0] - scale * 0.5 * (low[0] + high[0]),
            corner[1] + 0.5 * size[1] + scale * 0.5 * (low[1] + high[1]),
        ];
        Self { scale, origin }
    }

    pub fn at(&self, [x, y]: Point) -> Point {
        [self.origin[0] + self.scale * x, self.origin[1] - self.scale * y]
    }

    /// Metres that a number of pixels are.
    pub fn metres(&self, pixels: f64) -> f64 {
        pixels / self.scale
    }
}

/// Points of an arc about `center` (any units, y upwards), from one angle to another in radians.
pub(crate) fn arc(center: Point, radius: f64, from: f64, to: f64) -> impl Iterator<Item = Point> {
    (0..=40).map(move |step| {
        let angle = from + (to - from) * f64::from(step) / 40.0;
        [center[0] + radius * angle.cos(), center[1] + radius * angle.sin()]
    })
}
