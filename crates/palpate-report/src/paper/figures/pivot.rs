//! Figure 9: the pivoting grasp, and what comes of it.

use palpate::compare::RigidMotion;
use palpate::pivot::{PivotLog, PivotSample, compare_strokes};

use crate::drawing::colors::{BLUE, GREEN, INK, OBJECT, RED, RULE};
use crate::drawing::plot::{Labels, Plot, range};
use crate::drawing::svg::{Anchor, Point, Sheet, View, area, line, plain};
use crate::paper::figures::results::{PANEL, pad_and_contact};
use crate::paper::figures::scene::outline;
use crate::paper::input::StrokesTrial;

/// Instants of the first stroke at which the object is drawn.
const INSTANTS: usize = 5;

/// Set-up, shape about the pivot, and orientation.
pub(in crate::paper) fn pivoting_grasp(trial: &StrokesTrial) -> String {
    let mut sheet = Sheet::new(3.0 * PANEL[0], PANEL[1]);
    set_up_panel(&mut sheet, trial);
    let rotation_rad = compare_strokes(trial.found, trial.truth).map_or(0.0, |errors| errors.rotation_rad);
    shape_panel(&mut sheet, [PANEL[0], 0.0], trial, rotation_rad);
    orientation_panel(&mut sheet, [2.0 * PANEL[0], 0.0], trial, rotation_rad);
    sheet.finish("Figure 9: the pivoting grasp")
}

/// The samples of the first stroke, from the first contact to where it is lost.
fn first_stroke(log: &PivotLog) -> std::ops::Range<usize> {
    let seen = |index: &usize| log.samples[*index].s_m.is_some();
    let first = (0..log.samples.len()).find(seen).unwrap_or(0);
    first..(first..log.samples.len()).find(|index| !seen(index)).unwrap_or(log.samples.len())
}

/// The pose of an object that is held at its origin: carries its frame into the global one.
fn pivoted(sample: &PivotSample, psi_rad: f64) -> RigidMotion {
    RigidMotion { angle_rad: psi_rad, offset_m: [sample.pivot_x_m, sample.pivot_y_m] }
}

/// The object at instants of the first stroke, dragged over the pad by its pivot.
fn set_up_panel(sheet: &mut Sheet, trial: &StrokesTrial) {
    sheet.text([0.5 * PANEL[0], 18.0], "(a) Set-up", plain(14.0).bold());
    let stroke = first_stroke(trial.log);
    if stroke.is_empty() {
        return;
    }
    let at = |part: usize| stroke.start + part * (stroke.len() - 1) / (INSTANTS - 1);
    let instants: Vec<(usize, Vec<Point>)> = (0..INSTANTS)
        .map(at)
        .filter_map(|index| {
            let pose = pivoted(&trial.log.samples[index], trial.truth.motion.get(index)?.psi_rad);
            Some((index, outline(trial.shape).map(|point| pose.apply(point)).collect()))
        })
        .collect();
    let [x, y] = [0, 1].map(|axis| range(instants.iter().flat_map(|(_, body)| body).map(|point| point[axis])));
    let view = View::fitting([x[0], y[0]], [x[1], y[1]], [30.0, 40.0], [PANEL[0] - 60.0, PANEL[1] - 110.0]);
    let last = instants.len().saturating_sub(1);
    for (number, (_, body)) in instants.iter().enumerate() {
        let body: Vec<Point> = body.iter().map(|point| view.at(*point)).collect();
        if number == last {
            sheet.path(body, true, line(INK, 1.6).filled(OBJECT));
        } else {
            sheet.path(body, true, line(RULE, 1.2));
        }
    }
    sheet.segment(view.at([x[0], 0.0]), view.at([x[1], 0.0]), line(INK, 4.0));
    let pivot = |index: usize| view.at([trial.log.samples[index].pivot_x_m, trial.log.samples[index].pivot_y_m]);
    sheet.path(stroke.map(pivot), false, line(GREEN, 1.2).dashed());
    for (index, _) in &instants {
        sheet.dot(pivot(*index), 4.0, area(GREEN));
        if let Some(s_m) = trial.log.samples[*index].s_m {
            sheet.dot(view.at([s_m, 0.0]), 4.6, area(RED));
        }
    }
    pad_and_contact(sheet);
    let y = PANEL[1] - 13.0;
    sheet.dot([217.0, y - 4.0], 4.0, area(GREEN));
    sheet.text([227.0, y], "pivot, which the arm drags", plain(12.0).anchored(Anchor::Start));
}

/// The boundary as it is, and the points that were felt.
fn shape_panel(sheet: &mut Sheet, corner: Point, trial: &StrokesTrial, rotation_rad: f64) {
    sheet.text([corner[0] + 0.5 * PANEL[0], corner[1] + 18.0], "(b) Shape about the pivot", plain(14.0).bold());
    let body: Vec<Point> = outline(&trial.shape.rotated(rotation_rad)).collect();
    let radius = 1.1 * body.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    if !(radius > 0.0 && radius.is_finite()) {
        return;
    }
    let place = [corner[0] + 20.0, corner[1] + 30.0];
    let view = View::fitting([-radius; 2], [radius; 2], place, [PANEL[0] - 40.0, PANEL[1] - 74.0]);
    sheet.path(body.iter().map(|point| view.at(*point)), true, line(INK, 1.4));
    // The contact of every sample in the frame of the object that was found.
    let felt = trial
        .log
        .samples
        .iter()
        .zip(&trial.found.motion)
        .filter_map(|(sample, found)| Some(view.at(pivoted(sample, found.psi_rad?).undo([sample.s_m?, 0.0]))));
    sheet.dots(felt, 1.3, BLUE);
    sheet.dot(view.at([0.0, 0.0]), 4.0, area(GREEN));
    let y = corner[1] + PANEL[1] - 13.0;
    let kind = plain(12.0).anchored(Anchor::Start);
    sheet.segment([corner[0] + 150.0, y - 4.0], [corner[0] + 166.0, y - 4.0], line(INK, 1.4));
    sheet.text([corner[0] + 173.0, y], "actual", kind);
    sheet.dots((0..4).map(|i| [corner[0] + 240.0 + 5.0 * f64::from(i), y - 4.0]), 1.6, BLUE);
    sheet.text([corner[0] + 263.0, y], "observed", kind);
}

/// The orientation while the pad feels the object.
fn orientation_panel(sheet: &mut Sheet, corner: Point, trial: &StrokesTrial, rotation_rad: f64) {
    let felt = || trial.found.motion.iter().zip(&trial.truth.motion);
    let degrees = |time_s: f64, psi_rad: Option<f64>| [time_s, psi_rad.map_or(f64::NAN, f64::to_degrees)];
    let actual: Vec<Point> =
        felt().map(|(found, real)| degrees(real.time_s, found.psi_rad.map(|_| real.psi_rad - rotation_rad))).collect();
    // The observed angle nearest to the actual one: while the object is lifted, nobody counts its turns.
    let observed: Vec<Point> = felt()
        .zip(&actual)
        .map(|((found, _), real)| {
            let [time_s, psi] = degrees(found.time_s, found.psi_rad);
            [time_s, psi - 360.0 * ((psi - real[1]) / 360.0).round()]
        })
        .collect();
    let is_known = |point: &&Point| point[1].is_finite();
    let y = range(actual.iter().chain(&observed).filter(is_known).map(|point| point[1]));
    let x = range(trial.truth.motion.iter().map(|pose| pose.time_s));
    let labels = Labels { title: "(c) Orientation", x: "time (s)", y: "orientation ψ (degrees)" };
    let plot = Plot::new(sheet, corner, PANEL, x, y, labels);
    let end = actual.iter().rfind(is_known).map(|point| point[1]);
    plot.curve(sheet, actual, line(INK, 1.6));
    plot.curve(sheet, observed, line(BLUE, 1.8).dashed());
    plot.legend(sheet, &[("actual", line(INK, 1.6)), ("observed", line(BLUE, 1.8).dashed())], end);
}
