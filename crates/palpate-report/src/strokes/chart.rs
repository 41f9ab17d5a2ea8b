//! A chart as it stands in the page of strokes: curves over time or angle, and a lane below for their error bars. It is drawn twice, for a
//! broad and for a narrow window, so that the page needs no script to be read.

use std::fmt::Write;

use crate::data::root_mean_square;
use crate::drawing::plot::{number, range, ticks, with_air};
use crate::html::escape;

/// Widths of a chart for a broad and for a narrow window, and the class that shows it there.
const SIZES: [(f64, &str); 2] = [(620.0, "broad"), (340.0, "narrow")];

/// What stays free of curves around them.
const LEFT: f64 = 46.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 24.0;

/// The lane and the words above it.
const LANE: f64 = 56.0;
const LANE_GAP: f64 = 26.0;

/// The lane shows so many times the band's own size, root mean square.
const LANE_REACH: f64 = 1.8;

/// Below this many millimetres a lane counts in micrometres.
const MICRO_MM: f64 = 0.2;

pub(super) struct Chart<'a> {
    /// Of the element in the page.
    pub id: &'a str,
    /// What it shows, for those who cannot see it.
    pub name: &'a str,
    pub x: &'a [f64],
    pub x_unit: &'a str,
    pub height: f64,
    pub curves: Vec<Curve<'a>>,
    /// Range of the curves; that of their values where it is not given.
    pub y: Option<[f64; 2]>,
    /// Dashed lines across, such as noise.
    pub levels: Vec<f64>,
    /// Dashed lines down, such as the beginnings of strokes.
    pub marks: &'a [f64],
    pub lane: Option<Lane>,
}

/// Values over x; what is not finite leaves a gap.
pub(super) struct Curve<'a> {
    pub class: &'a str,
    pub y: Vec<f64>,
    /// Single dots and no line.
    pub dots: bool,
}

/// Half of the width of a 95 % band, and the error where the truth is known.
pub(super) struct Lane {
    pub unit: &'static str,
    pub band: Vec<f64>,
    pub error: Option<Vec<f64>>,
}

impl Chart<'_> {
    /// The chart as an element of the page.
    pub fn drawn(&self) -> String {
        let drawings: String = SIZES.iter().map(|&(width, class)| self.at_width(width, class)).collect();
        format!("<div class=\"plot\" id=\"{}\">{drawings}</div>", self.id)
    }

    fn at_width(&self, width: f64, class: &str) -> String {
        let lane_height = if self.lane.is_some() { LANE_GAP + LANE } else { 0.0 };
        let floor = TOP + self.height + lane_height;
        let x = Axis::new(range(self.x.iter().copied()), [LEFT, width - RIGHT]);
        let values = self.curves.iter().flat_map(|curve| curve.y.iter().copied());
        let y = Axis::new(self.y.unwrap_or_else(|| with_air(range(values))), [TOP + self.height, TOP]);
        let mut svg = format!(
            "<svg class=\"{class}\" viewBox=\"0 0 {width} {}\" role=\"img\" aria-label=\"{}\" data-from=\"{}\" data-to=\"{}\" \
             data-left=\"{LEFT}\" data-right=\"{}\">",
            floor + BOTTOM,
            escape(self.name),
            x.range[0],
            x.range[1],
            width - RIGHT
        );
        for tick in ticks(y.range) {
            let class = if tick == 0.0 { "zero" } else { "grid" };
            y_tick(&mut svg, y.at(tick), x.pixels[1], class, &number(tick, y.range));
        }
        let x_ticks = ticks(x.range);
        for (index, &tick) in x_ticks.iter().enumerate() {
            let place = x.at(tick);
            let unit = if index + 1 == x_ticks.len() { self.x_unit } else { "" };
            let _ = write!(
                svg,
                "<path class=\"rule\" d=\"M{place:.1} {floor}v4\"/><text x=\"{place:.1}\" y=\"{}\" text-anchor=\"middle\">{}{unit}</text>",
                floor + 17.0,
                number(tick, x.range)
            );
        }
        let _ = write!(svg, "<path class=\"rule\" d=\"M{LEFT} {floor}H{}\"/>", x.pixels[1]);
        for &mark in self.marks {
            let _ = write!(svg, "<path class=\"jump\" d=\"M{:.1} {TOP}V{floor}\"/>", x.at(mark));
        }
        for level in self.levels.iter().map(|&level| y.at(level)) {
            let _ = write!(svg, "<path class=\"sigma\" d=\"M{LEFT} {level:.1}H{}\"/>", x.pixels[1]);
        }
        for curve in &self.curves {
            let points = self.x.iter().zip(&curve.y).map(|(&at, &value)| [x.at(at), y.inside(value)]);
            let line = if curve.dots { dots(points) } else { path(points) };
            let _ = write!(svg, "<path class=\"{}\" d=\"{line}\"/>", curve.class);
        }
        if let Some(lane) = &self.lane {
            lane.draw(&mut svg, self.x, &x, TOP + self.height + LANE_GAP);
        }
        let _ = write!(svg, "<path class=\"play-cursor\" d=\"M0 {TOP}V{floor}\" visibility=\"hidden\"/></svg>");
        svg
    }
}

impl Lane {
    fn draw(&self, svg: &mut String, at: &[f64], x: &Axis, top: f64) {
        let rms = |values: &[f64]| root_mean_square(values.iter().copied());
        let error = self.error.as_ref().map_or(0.0, |error| 1.2 * rms(error));
        let reach =
            [rms(&self.band), error].into_iter().filter(|size| size.is_finite()).fold(0.0, f64::max) * LANE_REACH;
        let reach = if reach > 0.0 { reach } else { 1.0 };
        let (factor, unit) = if self.unit == "mm" && reach < MICRO_MM { (1e3, "µm") } else { (1.0, self.unit) };
        let y = Axis::new([-reach, reach], [top + LANE, top]);
        // The lane is low: room for one number on either side of 0.
        let shown = ticks([0.0, factor * reach]).into_iter().rfind(|tick| *tick <= 0.8 * factor * reach).unwrap_or(0.0);
        for tick in [-shown, 0.0, shown] {
            let class = if tick == 0.0 { "zero" } else { "grid" };
            y_tick(svg, y.at(tick / factor), x.pixels[1], class, &number(tick, [-factor * reach, factor * reach]));
        }
        // A band for each run of values.
        let edge = |index: usize, sign: f64| [x.at(at[index]), y.inside(sign * self.band[index])];
        let mut from = 0;
        while from < self.band.len() {
            let run = self.band[from..].iter().take_while(|band| band.is_finite()).count();
            if run > 1 {
                let upper = (from..from + run).map(|index| edge(index, 1.0));
                let lower = (from..from + run).rev().map(|index| edge(index, -1.0));
                let _ = write!(svg, "<path class=\"band lane\" d=\"{}Z\"/>", path(upper.chain(lower)));
            }
            from += run.max(1);
        }
        if let Some(error) = &self.error {
            let points = at.iter().zip(error).map(|(&at, &error)| [x.at(at), y.inside(error)]);
            let _ = write!(svg, "<path class=\"error\" d=\"{}\"/>", path(points));
        }
        let words = if self.error.is_some() { "95 % band and actual error" } else { "95 % band" };
        let _ = write!(svg, "<text x=\"{LEFT}\" y=\"{}\">{words}, {unit}</text>", top - 8.0);
    }
}

fn y_tick(svg: &mut String, place: f64, right: f64, class: &str, text: &str) {
    let _ = write!(
        svg,
        "<path class=\"{class}\" d=\"M{LEFT} {place:.1}H{right}\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
        LEFT - 8.0,
        place + 4.0
    );
}

/// A range of values and where its ends are in the picture.
struct Axis {
    range: [f64; 2],
    pixels: [f64; 2],
}

impl Axis {
    fn new(range: [f64; 2], pixels: [f64; 2]) -> Self {
        let range = if range[1] > range[0] { range } else { with_air(range) };
        Self { range, pixels }
    }

    fn at(&self, value: f64) -> f64 {
        let ([low, high], [from, to]) = (self.range, self.pixels);
        from + (to - from) * (value - low) / (high - low)
    }

    /// The same, for a value outside the range at its edge.
    fn inside(&self, value: f64) -> f64 {
        if value.is_finite() { self.at(value.clamp(self.range[0], self.range[1])) } else { f64::NAN }
    }
}

/// A path through points, broken where one is missing.
pub(super) fn path(points: impl Iterator<Item = [f64; 2]>) -> String {
    let mut line = String::new();
    let mut pen = 'M';
    for [x, y] in points {
        if x.is_finite() && y.is_finite() {
            let _ = write!(line, "{pen}{x:.1} {y:.1}");
            pen = 'L';
        } else {
            pen = 'M';
        }
    }
    line
}

fn dots(points: impl Iterator<Item = [f64; 2]>) -> String {
    let mut line = String::new();
    for [x, y] in points.filter(|point| point.iter().all(|value| value.is_finite())) {
        let _ = write!(line, "M{x:.1} {y:.1}h0");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_leaves_a_gap() {
        let points = [[0.0, 0.0], [1.0, 1.0], [2.0, f64::NAN], [3.0, 3.0]];
        assert_eq!(path(points.into_iter()), "M0.0 0.0L1.0 1.0M3.0 3.0");
        assert_eq!(dots(points.into_iter()), "M0.0 0.0h0M1.0 1.0h0M3.0 3.0h0");
    }

    #[test]
    fn a_chart_without_a_value_is_a_chart() {
        let lane = Some(Lane { unit: "mm", band: vec![], error: None });
        let curves = vec![Curve { class: "line", y: vec![], dots: false }];
        let chart = Chart {
            id: "a",
            name: "<a>",
            x: &[],
            x_unit: " s",
            height: 100.0,
            curves,
            y: None,
            levels: vec![],
            marks: &[],
            lane,
        };
        let drawn = chart.drawn();
        assert!(drawn.contains("class=\"narrow\"") && drawn.contains("&lt;a&gt;") && !drawn.contains("NaN"), "{drawn}");
    }
}
