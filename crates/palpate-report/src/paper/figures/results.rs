//! Figures 7 and 8: what was reconstructed, against what is true.

use std::f64::consts::TAU;

use palpate::compare::procrustes_rotation_rad;
use palpate::palms::Palm;
use palpate::reconstruct::diagnostics;
use palpate::sensor::VisionSystem;

use crate::drawing::colors::{BLUE, GREEN, GREY, INK, OBJECT, RED, RULE};
use crate::drawing::plot::{Labels, Plot, range};
use crate::drawing::svg::{Anchor, Point, Sheet, View, area, line, plain};
use crate::paper::figures::scene::{observed_points, outline, palm_ends, palms, true_pose, view_of};
use crate::paper::input::{Method, Trial};

/// Size of a panel.
pub(super) const PANEL: Point = [480.0, 360.0];

/// The observed points in the frame of the true object, with the number of times that their place was felt; and the rotation
/// (radians) that brings them there, by SVD.
struct Aligned {
    points: Vec<(f64, Point, u32)>,
    angle_rad: f64,
}

fn aligned(trial: &Trial, method: Method) -> Aligned {
    let found = trial.found(method);
    let touches = |theta: f64| {
        let nodes = found.outline.len().max(1);
        let node = (theta.rem_euclid(TAU) / TAU * nodes as f64).round() as usize % nodes;
        found.outline.get(node).map_or(0, |point| point.touches)
    };
    let (mut observed, mut real) = (Vec::new(), Vec::new());
    for (sample, (felt, pose)) in trial.log.samples.iter().zip(&trial.truth.motion).enumerate() {
        let (theta1, theta2) = felt.palms.contact_angles(pose.psi_rad);
        for (point, theta) in observed_points(trial, found, sample).into_iter().zip([theta1, theta2]) {
            let Some(point) = point else { continue };
            let boundary = trial.shape.boundary_point(theta);
            observed.push(point);
            real.push([boundary.x_m, boundary.y_m]);
        }
    }
    let plain_points: Vec<Point> = observed.iter().map(|(_, point)| *point).collect();
    let angle_rad = procrustes_rotation_rad(&plain_points, &real).unwrap_or(0.0);
    let (sin, cos) = angle_rad.sin_cos();
    let points = observed
        .into_iter()
        .map(|(theta, [x, y])| (theta + angle_rad, [x * cos - y * sin, x * sin + y * cos], touches(theta)))
        .collect();
    Aligned { points, angle_rad }
}

/// Figure 7: shape, radius function, orientation, and error of the contact vector.
pub(in crate::paper) fn differences(trial: &Trial, method: Method) -> String {
    let mut sheet = Sheet::new(2.0 * PANEL[0], 2.0 * PANEL[1]);
    let aligned = aligned(trial, method);
    shape_panel(&mut sheet, [0.0, 0.0], trial, method, &aligned, 0, "(a) Shape");
    radius_panel(&mut sheet, [PANEL[0], 0.0], trial, method, &aligned);
    orientation_panel(&mut sheet, [0.0, PANEL[1]], trial, method, &aligned, "(c) Orientation");
    vector_panel(&mut sheet, PANEL, trial, method);
    sheet.finish(&format!("Figure 7: actual and observed shape and motion, {}, {}", trial.name, method.name()))
}

/// Figure 8: the set-up, the observed shape and the observed motion.
pub(in crate::paper) fn experiment(trial: &Trial, method: Method, vision: &VisionSystem, min_touches: u32) -> String {
    let mut sheet = Sheet::new(3.0 * PANEL[0], PANEL[1]);
    set_up_panel(&mut sheet, trial, vision);
    let aligned = aligned(trial, method);
    shape_panel(&mut sheet, [PANEL[0], 0.0], trial, method, &aligned, min_touches, "(b) Shape");
    orientation_panel(&mut sheet, [2.0 * PANEL[0], 0.0], trial, method, &aligned, "(c) Motion");
    sheet.finish(&format!("Figure 8: the experiment, {}", method.name()))
}

fn shape_panel(
    sheet: &mut Sheet,
    corner: Point,
    trial: &Trial,
    method: Method,
    aligned: &Aligned,
    min_touches: u32,
    title: &str,
) {
    sheet.text([corner[0] + 0.5 * PANEL[0], corner[1] + 18.0], title, plain(14.0).bold());
    let radius = 1.3 * trial.shape.mean_radius_m();
    let place = [corner[0] + 20.0, corner[1] + 30.0];
    let view = View::fitting([-radius; 2], [radius; 2], place, [PANEL[0] - 40.0, PANEL[1] - 74.0]);
    sheet.segment(view.at([-1.2 * radius, 0.0]), view.at([1.2 * radius, 0.0]), line(RULE, 1.0));
    sheet.segment(view.at([0.0, -radius]), view.at([0.0, radius]), line(RULE, 1.0));
    sheet.path(outline(trial.shape).map(|point| view.at(point)), true, line(INK, 1.4));
    let kept = |touches: u32| touches >= min_touches;
    let left_out = aligned.points.iter().filter(|point| !kept(point.2)).map(|point| view.at(point.1));
    sheet.dots(left_out, 1.3, "#b9c1ca");
    sheet.dots(aligned.points.iter().filter(|point| kept(point.2)).map(|point| view.at(point.1)), 1.3, method.color());
    sheet.dot(view.at([0.0, 0.0]), 4.0, area(GREEN));
    let bar = 10f64.powf(radius.log10().floor());
    let start = [corner[0] + 24.0, corner[1] + PANEL[1] - 30.0];
    sheet.segment(start, [start[0] + bar / view.metres(1.0), start[1]], line(INK, 2.0));
    let kind = plain(12.0).anchored(Anchor::Start);
    sheet.text([start[0], start[1] + 17.0], &format!("{:.0} mm", 1e3 * bar), kind);
    let mut x = corner[0] + 150.0;
    let y = corner[1] + PANEL[1] - 13.0;
    let mut entry = |name: &str, color: &'static str, dots: bool| {
        if dots {
            sheet.dots((0..4).map(|i| [x + 5.0 * f64::from(i), y - 4.0]), 1.6, color);
        } else {
            sheet.segment([x, y - 4.0], [x + 16.0, y - 4.0], line(color, 1.4));
        }
        sheet.text([x + 23.0, y], name, kind);
        x += 40.0 + 7.4 * name.chars().count() as f64;
    };
    entry("actual", INK, false);
    entry("observed", method.color(), true);
    if min_touches > 1 {
        entry(if min_touches == 2 { "felt only once" } else { "felt too few times" }, "#b9c1ca", true);
    }
}

fn radius_panel(sheet: &mut Sheet, corner: Point, trial: &Trial, method: Method, aligned: &Aligned) {
    let actual: Vec<Point> = (0..=360)
        .map(|degree| [f64::from(degree), 1e3 * trial.shape.radius_m(f64::from(degree).to_radians())])
        .collect();
    let found = trial.found(method);
    let mut observed: Vec<Point> = found
        .outline
        .iter()
        .filter(|point| point.touches > 0)
        .map(|point| [(point.theta_rad + aligned.angle_rad).rem_euclid(TAU).to_degrees(), 1e3 * point.r_m])
        .collect();
    observed.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let y = range(actual.iter().chain(&observed).map(|point| point[1]));
    let labels = Labels { title: "(b) Radius function", x: "normal angle θ (degrees)", y: "r (mm)" };
    let plot = Plot::new(sheet, corner, PANEL, [0.0, 360.0], y, labels);
    plot.curve(sheet, actual, line(INK, 1.6));
    plot.dots(sheet, observed, 1.3, method.color());
    plot.legend(sheet, &[("actual", line(INK, 1.6)), ("observed", line(method.color(), 2.6))], None);
}

fn orientation_panel(sheet: &mut Sheet, corner: Point, trial: &Trial, method: Method, aligned: &Aligned, title: &str) {
    let found = trial.found(method);
    let actual: Vec<Point> = trial.truth.motion.iter().map(|pose| [pose.time_s, pose.psi_rad.to_degrees()]).collect();
    // The observed angle nearest to the actual one: whole turns and the choice of the object frame mean nothing.
    let observed: Vec<Point> = found
        .motion
        .iter()
        .zip(&actual)
        .map(|(pose, real)| {
            let psi = (pose.psi_rad - aligned.angle_rad).to_degrees();
            [pose.time_s, psi - 360.0 * ((psi - real[1]) / 360.0).round()]
        })
        .collect();
    let y = range(actual.iter().chain(&observed).map(|point| point[1]));
    let x = range(actual.iter().map(|point| point[0]));
    let plot = Plot::new(sheet, corner, PANEL, x, y, Labels { title, x: "time (s)", y: "orientation ψ (degrees)" });
    let end = actual.last().map(|point| point[1]);
    plot.curve(sheet, actual, line(INK, 1.6));
    plot.curve(sheet, observed, line(method.color(), 1.8).dashed());
    plot.legend(sheet, &[("actual", line(INK, 1.6)), ("observed", line(method.color(), 1.8).dashed())], end);
}

fn vector_panel(sheet: &mut Sheet, corner: Point, trial: &Trial, method: Method) {
    let errors: Vec<Point> = diagnostics(trial.log, trial.found(method))
        .iter()
        .map(|sample| [sample.time_s, sample.contact_vector_error_m.map_or(f64::NAN, |error| 1e3 * error)])
        .collect();
    let y = range(errors.iter().map(|point| point[1]).chain([0.0]));
    let x = range(errors.iter().map(|point| point[0]));
    let labels = Labels { title: "(d) Error in the norm of the contact vector", x: "time (s)", y: "error (mm)" };
    let plot = Plot::new(sheet, corner, PANEL, x, y, labels);
    plot.curve(sheet, [[x[0], 0.0], [x[1], 0.0]], line(GREY, 1.2));
    plot.curve(sheet, errors, line(method.color(), 1.3));
}

/// Says below a set-up what pad and contact are drawn as.
pub(super) fn pad_and_contact(sheet: &mut Sheet) {
    let y = PANEL[1] - 13.0;
    let kind = plain(12.0).anchored(Anchor::Start);
    sheet.segment([30.0, y - 4.0], [48.0, y - 4.0], line(INK, 4.0));
    sheet.text([54.0, y], "touchpad", kind);
    sheet.dot([135.0, y - 4.0], 4.6, area(RED));
    sheet.text([145.0, y], "contact", kind);
}

/// The set-up at a third of the motion: palms with their pads, the object, and the arrows that the camera follows.
fn set_up_panel(sheet: &mut Sheet, trial: &Trial, vision: &VisionSystem) {
    sheet.text([0.5 * PANEL[0], 18.0], "(a) Set-up", plain(14.0).bold());
    let sample = trial.log.samples.len() / 3;
    let Some(felt) = trial.log.samples.get(sample) else { return };
    let length = trial.pad_length_m;
    let pose = true_pose(trial, sample);
    let body: Vec<Point> = outline(trial.shape).map(|point| pose.apply(point)).collect();
    let view = view_of(&body, &felt.palms, 1.25 * length, [40.0, 34.0], [PANEL[0] - 80.0, PANEL[1] - 84.0]);
    palms(sheet, &view, &felt.palms, 1.25 * length, line(GREY, 8.0));
    for palm in [Palm::One, Palm::Two] {
        let (base, end) = palm_ends(&felt.palms, palm, length);
        sheet.segment(view.at(base), view.at(end), line(INK, 4.0));
    }
    sheet.path(body.iter().map(|point| view.at(*point)), true, line(INK, 1.6).filled(OBJECT));
    let marker = line(BLUE, 3.0);
    let on_object: Vec<Point> = vision.object_markers_m.iter().map(|marker| view.at(pose.apply(*marker))).collect();
    if let [tail, head, others @ ..] = on_object.as_slice() {
        sheet.arrow(*tail, *head, marker);
        others.iter().for_each(|point| sheet.dot(*point, 4.0, area(BLUE)));
    }
    for point in vision.on_palms(&felt.palms) {
        sheet.dot(view.at(point), 3.4, line(BLUE, 1.6).filled("#ffffff"));
    }
    let (one, two) = felt.palms.contact_points_m(felt.s1_m.unwrap_or(f64::NAN), felt.s2_m.unwrap_or(f64::NAN));
    for point in [one, two] {
        sheet.dot(view.at(point), 4.6, area(RED));
    }
    let y = PANEL[1] - 13.0;
    let kind = plain(12.0).anchored(Anchor::Start);
    pad_and_contact(sheet);
    sheet.arrow([212.0, y - 4.0], [232.0, y - 4.0], marker);
    sheet.dot([243.0, y - 4.0], 3.4, line(BLUE, 1.6).filled("#ffffff"));
    sheet.text([252.0, y], "markers for the camera", kind);
}
