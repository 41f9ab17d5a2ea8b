//! A plot: a frame with ticks, and curves in it.

use crate::drawing::colors::{INK, RULE};
use crate::drawing::svg::{Anchor, Pen, Point, Sheet, area, line, plain};

/// A frame on a sheet and the ranges that it shows.
#[derive(Clone, Debug)]
pub(crate) struct Plot {
    corner: Point,
    size: Point,
    x: [f64; 2],
    y: [f64; 2],
}

/// What is written beside a plot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Labels<'a> {
    pub title: &'a str,
    pub x: &'a str,
    pub y: &'a str,
}

impl Plot {
    /// Draws frame, ticks and labels in the part of the sheet at `corner`; the ranges are widened to hold some air.
    pub fn new(sheet: &mut Sheet, corner: Point, size: Point, x: [f64; 2], y: [f64; 2], labels: Labels) -> Self {
        let y = with_air(y);
        let inner_corner = [corner[0] + 62.0, corner[1] + 30.0];
        let inner = [size[0] - 74.0, size[1] - 76.0];
        let plot = Self { corner: inner_corner, size: inner, x: if x[1] > x[0] { x } else { with_air(x) }, y };
        for tick in ticks(plot.x) {
            let [px, _] = plot.at([tick, 0.0]);
            sheet.segment([px, inner_corner[1]], [px, inner_corner[1] + inner[1]], line(RULE, 1.0));
            sheet.text([px, inner_corner[1] + inner[1] + 17.0], &number(tick, plot.x), plain(12.0));
        }
        for tick in ticks(plot.y) {
            let [_, py] = plot.at([0.0, tick]);
            sheet.segment([inner_corner[0], py], [inner_corner[0] + inner[0], py], line(RULE, 1.0));
            let place = [inner_corner[0] - 6.0, py + 4.0];
            sheet.text(place, &number(tick, plot.y), plain(12.0).anchored(Anchor::End));
        }
        sheet.rectangle(inner_corner, inner, line(INK, 1.0));
        let middle = inner_corner[0] + 0.5 * inner[0];
        sheet.text([middle, corner[1] + 18.0], labels.title, plain(14.0).bold());
        sheet.text([middle, corner[1] + size[1] - 10.0], labels.x, plain(13.0));
        let beside = [corner[0] + 14.0, inner_corner[1] + 0.5 * inner[1]];
        sheet.turned_text(beside, 90.0, labels.y, plain(13.0));
        plot
    }

    fn at(&self, [x, y]: Point) -> Point {
        [
            self.corner[0] + self.size[0] * (x - self.x[0]) / (self.x[1] - self.x[0]),
            self.corner[1] + self.size[1] * (1.0 - (y - self.y[0]) / (self.y[1] - self.y[0])),
        ]
    }

    /// Points outside the frame stop at its edge.
    fn inside(&self, [x, y]: Point) -> Point {
        self.at([x, if y.is_finite() { y.clamp(self.y[0], self.y[1]) } else { y }])
    }

    pub fn curve(&self, sheet: &mut Sheet, points: impl IntoIterator<Item = Point>, pen: Pen) {
        sheet.path(points.into_iter().map(|point| self.inside(point)), false, pen);
    }

    pub fn dots(&self, sheet: &mut Sheet, points: impl IntoIterator<Item = Point>, radius: f64, color: &'static str) {
        sheet.dots(points.into_iter().map(|point| self.inside(point)), radius, color);
    }

    /// Names of curves, each as it is drawn, in the upper right corner, or the lower one where a curve ends high.
    pub fn legend(&self, sheet: &mut Sheet, entries: &[(&str, Pen)], end: Option<f64>) {
        let width = 26.0 + 7.6 * entries.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0) as f64;
        let height = 10.0 + 17.0 * entries.len() as f64;
        let high = end.is_some_and(|end| end > 0.5 * (self.y[0] + self.y[1]));
        let down = if high { self.size[1] - height - 6.0 } else { 6.0 };
        let corner = [self.corner[0] + self.size[0] - width - 14.0, self.corner[1] + down];
        sheet.rectangle(corner, [width + 8.0, height], area("#ffffffdd"));
        for (index, (name, pen)) in entries.iter().enumerate() {
            let y = corner[1] + 17.0 + 17.0 * index as f64;
            sheet.segment([corner[0] + 5.0, y - 4.0], [corner[0] + 25.0, y - 4.0], *pen);
            sheet.text([corner[0] + 31.0, y], name, plain(12.0).anchored(Anchor::Start));
        }
    }
}

/// The range of some values; from 0 to 1 when there are none.
pub(crate) fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let [low, high] = values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    if low <= high { [low, high] } else { [0.0, 1.0] }
}

/// A little wider, so that no curve lies on the frame.
pub(crate) fn with_air([low, high]: [f64; 2]) -> [f64; 2] {
    let air = 0.06 * (high - low).max(1e-6 * low.abs().max(high.abs())).max(1e-9);
    [low - air, high + air]
}

/// Round numbers in a range, about five.
pub(crate) fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let step = step([low, high]);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last.min(first + 20)).map(|index| index as f64 * step).collect()
}

fn step([low, high]: [f64; 2]) -> f64 {
    let rough = ((high - low) / 5.0).max(1e-12);
    let magnitude = 10f64.powf(rough.log10().floor());
    let factor = rough / magnitude;
    magnitude
        * if factor < 1.5 {
            1.0
        } else if factor < 3.5 {
            2.0
        } else if factor < 7.5 {
            5.0
        } else {
            10.0
        }
}

/// Numbers all of which are closer to 0 are written as powers of ten.
const SMALL: f64 = 1e-5;

/// A tick's number with the digits that tell it from its neighbours.
pub(crate) fn number(tick: f64, range: [f64; 2]) -> String {
    let decimals = (-step(range).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = if range.iter().any(|end| end.abs() > SMALL) {
        format!("{tick:.decimals$}")
    } else if tick.abs() < 0.5 * step(range) {
        // 0 but for rounding: ticks are multiples of the step.
        "0".to_owned()
    } else {
        format!("{tick:.1e}").replace(".0e", "e")
    };
    // No −0.
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
        text.trim_start_matches('-').to_owned()
    } else {
        text.replace('-', "−")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks([0.0, 10.0]), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(number(-0.02, [-0.02, 0.03]), "−0.02");
        assert_eq!(number(-0.0, [-1.0, 1.0]), "0.0");
        let tiny = [-2e-10, 4e-10];
        assert_eq!(
            ticks(tiny).into_iter().map(|tick| number(tick, tiny)).collect::<Vec<_>>(),
            ["−2e−10", "−1e−10", "0", "1e−10", "2e−10", "3e−10", "4e−10"]
        );
        for range in [[-1e-5, 1e-5], [3.0, 3.1], [-1e6, 1e7], [0.0, 0.0]] {
            let count = ticks(with_air(range)).len();
            assert!((2..=12).contains(&count), "{range:?}: {count}");
        }
    }

    #[test]
    fn the_range_of_nothing_is_something() {
        assert_eq!(range([]), [0.0, 1.0]);
        assert_eq!(range([f64::NAN, 2.0, -1.0]), [-1.0, 2.0]);
    }
}
