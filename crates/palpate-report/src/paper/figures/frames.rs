//! Figure 6: the shape as it is being reconstructed, in 27 frames.

use crate::drawing::colors::{GREEN, GREY, INK, OBJECT, RED, RULE};
use crate::drawing::svg::{Anchor, Point, Sheet, View, area, line, plain};
use crate::paper::figures::scene::{observed_points, outline, palm_ends, palms, pose, true_pose};
use crate::paper::input::{Method, Trial};
use palpate::palms::Palm;

/// Frames that there are.
pub(in crate::paper) const FRAMES: usize = 27;
const COLUMNS: usize = 7;
const CELL: Point = [176.0, 168.0];

/// All frames on one sheet: frame k after k/27 of the measurements.
pub(in crate::paper) fn frames(trial: &Trial, method: Method) -> String {
    let found = trial.found(method);
    let samples = trial.log.samples.len();
    let rows = (FRAMES + 1).div_ceil(COLUMNS);
    let mut sheet = Sheet::new(CELL[0] * COLUMNS as f64, CELL[1] * rows as f64);
    let length = 3.4 * trial.shape.mean_radius_m();
    // One view for all frames, so that motion is seen as motion.
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (sample, felt) in trial.log.samples.iter().enumerate().step_by(5) {
        let center = true_pose(trial, sample).offset_m;
        let radius = 1.15 * trial.shape.mean_radius_m();
        let ends = [Palm::One, Palm::Two].map(|palm| palm_ends(&felt.palms, palm, length).1);
        for axis in 0..2 {
            for point in ends.into_iter().chain([felt.palms.base1_m, felt.palms.base2_m]) {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
            low[axis] = low[axis].min(center[axis] - radius);
            high[axis] = high[axis].max(center[axis] + radius);
        }
    }
    let mut dots: Vec<Point> = Vec::new();
    let mut taken = 0;
    for frame in 0..FRAMES {
        let corner = [CELL[0] * (frame % COLUMNS) as f64, CELL[1] * (frame / COLUMNS) as f64];
        let count = (samples * (frame + 1)) / FRAMES;
        let Some(sample) = count.checked_sub(1) else { continue };
        dots.extend((taken..count).flat_map(|i| observed_points(trial, found, i)).flatten().map(|(_, point)| point));
        taken = count;
        let view = View::fitting(low, high, [corner[0] + 8.0, corner[1] + 20.0], [CELL[0] - 16.0, CELL[1] - 28.0]);
        sheet.rectangle(corner, CELL, line(RULE, 1.0));
        let real = true_pose(trial, sample);
        let body = outline(trial.shape).map(|point| view.at(real.apply(point)));
        sheet.path(body, true, line(GREY, 0.8).filled(OBJECT));
        palms(&mut sheet, &view, &trial.log.samples[sample].palms, length, line(INK, 2.4));
        let here = pose(found, sample);
        sheet.dots(dots.iter().map(|point| view.at(here.apply(*point))), 1.15, method.color());
        sheet.dot(view.at(here.offset_m), 3.4, area(GREEN));
        for (_, point) in observed_points(trial, found, sample).into_iter().flatten() {
            sheet.dot(view.at(here.apply(point)), 3.4, area(RED));
        }
        sheet.text([corner[0] + 8.0, corner[1] + 15.0], &count.to_string(), plain(11.0).anchored(Anchor::Start));
    }
    legend(&mut sheet, method);
    sheet.finish(&format!("Figure 6: {} frames of the reconstruction, {}", FRAMES, trial.name))
}

/// In the cell that is left.
fn legend(sheet: &mut Sheet, method: Method) {
    let corner = [CELL[0] * (FRAMES % COLUMNS) as f64 + 16.0, CELL[1] * (FRAMES / COLUMNS) as f64 + 30.0];
    let entry = |row: usize| [corner[0], corner[1] + 22.0 * row as f64];
    let beside = |row: usize| [corner[0] + 16.0, corner[1] + 22.0 * row as f64 + 4.0];
    let kind = plain(11.0).anchored(Anchor::Start);
    for (row, (radius, color, name)) in
        [(3.4, GREEN, "centre of mass"), (3.4, RED, "contact points"), (1.6, method.color(), "shape felt so far")]
            .into_iter()
            .enumerate()
    {
        sheet.dot(entry(row), radius, area(color));
        sheet.text(beside(row), name, kind);
    }
    let [x, y] = entry(3);
    sheet.rectangle([x - 5.0, y - 5.0], [10.0, 10.0], line(GREY, 0.8).filled(OBJECT));
    sheet.text(beside(3), "the object", kind);
    sheet.text([corner[0] - 5.0, corner[1] + 98.0], "upper left: measurements", kind);
    sheet.text([corner[0] - 5.0, corner[1] + 114.0], method.name(), kind.bold());
}
