//! Figures 1 to 5: the arrangements, and the geometry of contact, from computed values.

use std::f64::consts::TAU;

use palpate::palms::{GeneralizedContactSupport, Palm, PalmPair};
use palpate::shape::SupportFunction;

use crate::drawing::colors::{BLUE, GREEN, GREY, INK, OBJECT, ORANGE, RED};
use crate::drawing::svg::{Anchor, Pen, Point, Sheet, View, arc, area, line, plain};
use crate::paper::figures::scene::{outline, palm_ends, palms, view_of};
use palpate::compare::RigidMotion;

const PALM: Pen = line(INK, 5.0);
const THIN: Pen = line(GREY, 1.2);

/// An object at rest between palms.
pub(in crate::paper) struct Rest<'a> {
    pub shape: &'a SupportFunction,
    pub palms: PalmPair,
    pub psi_rad: f64,
}

impl Rest<'_> {
    fn pose(&self) -> RigidMotion {
        let (theta1, theta2) = self.palms.contact_angles(self.psi_rad);
        let center = self.palms.center_of_mass_m(self.shape.at(theta1), self.shape.at(theta2));
        RigidMotion { angle_rad: self.psi_rad, offset_m: center }
    }

    /// (s₁, s₂), metres.
    fn readings(&self) -> (f64, f64) {
        self.palms.contact_positions_m(self.shape, self.psi_rad)
    }

    fn contacts(&self) -> (Point, Point) {
        let (s1, s2) = self.readings();
        self.palms.contact_points_m(s1, s2)
    }

    /// Object and palms, in a view that holds them.
    fn draw(&self, sheet: &mut Sheet, corner: Point, size: Point) -> View {
        let radius = self.shape.mean_radius_m();
        let length = 3.6 * radius;
        let pose = self.pose();
        let body: Vec<Point> = outline(self.shape).map(|point| pose.apply(point)).collect();
        let view = view_of(&body, &self.palms, length, corner, size);
        sheet.path(body.iter().map(|point| view.at(*point)), true, line(INK, 1.6).filled(OBJECT));
        palms(sheet, &view, &self.palms, length, PALM);
        view
    }
}

/// Figure 1: the two arrangements.
pub(in crate::paper) fn arrangements(hinged: &Rest, apart: &Rest) -> String {
    let mut sheet = Sheet::new(1000.0, 500.0);
    for (index, (rest, title)) in [(hinged, "(a) Two palms"), (apart, "(b) Two fingers")].into_iter().enumerate() {
        let left = 500.0 * index as f64;
        let view = rest.draw(&mut sheet, [left + 50.0, 30.0], [400.0, 390.0]);
        let center = rest.pose().offset_m;
        let (one, two) = rest.contacts();
        let gravity = [view.at(center), view.at([center[0], center[1] - view.metres(62.0)])];
        sheet.arrow(gravity[0], gravity[1], line(GREEN, 2.0));
        sheet.text(
            [gravity[0][0] + 9.0, 0.55 * gravity[0][1] + 0.45 * gravity[1][1]],
            "gravity",
            plain(14.0).anchored(Anchor::Start).colored(GREEN),
        );
        for (palm, contact, name) in [(Palm::One, one, "s₁"), (Palm::Two, two, "s₂")] {
            let (base, _) = palm_ends(&rest.palms, palm, 1.0);
            // Beside the palm, away from the object.
            let normal = rest.palms.normal(palm);
            let off = |point: Point, pixels: f64| {
                view.at([point[0] - view.metres(pixels) * normal[0], point[1] - view.metres(pixels) * normal[1]])
            };
            sheet.dimension(off(base, 16.0), off(contact, 16.0), line(RED, 1.4));
            let middle = off([0.5 * (base[0] + contact[0]), 0.5 * (base[1] + contact[1])], 32.0);
            sheet.text([middle[0], middle[1] + 5.0], name, plain(17.0).italic().colored(RED));
            sheet.dot(view.at(contact), 5.5, area(RED));
        }
        sheet.dot(view.at(center), 5.5, area(GREEN));
        angles(&mut sheet, &view, &rest.palms, rest.readings().0);
        sheet.text([left + 250.0, 485.0], title, plain(16.0).bold());
    }
    sheet.finish("Figure 1: the two arrangements of palms")
}

/// φ₁ and φ₂ at a hinge; at two bases the angle of each palm. `s1_m` is what must stay free for the dimension of s₁.
fn angles(sheet: &mut Sheet, view: &View, palms: &PalmPair, s1_m: f64) {
    let (phi1, phi12) = (palms.phi1_rad, palms.phi12_rad());
    let (b1, b2) = (palms.base1_m, palms.base2_m);
    let mut angle = |center: Point, from: f64, to: f64, pixels: f64, name: Option<&str>| {
        let radius = view.metres(pixels);
        sheet.path(arc(center, radius, from, to).map(|point| view.at(point)), false, line(BLUE, 1.6));
        if let Some(name) = name {
            let (middle, at) = (0.5 * (from + to), radius + view.metres(16.0));
            let place = view.at([center[0] + at * middle.cos(), center[1] + at * middle.sin()]);
            sheet.text([place[0], place[1] + 5.0], name, plain(16.0).italic().colored(BLUE));
        }
    };
    let reach = if s1_m > view.metres(120.0) { 36.0 } else { 92.0 };
    angle(b1, 0.0, phi1, reach, Some("φ₁"));
    if b1 == b2 {
        angle(b1, phi1, phi12, 48.0, Some("φ₂"));
    } else {
        angle(b2, 0.0, phi12, 22.0, None);
    }
    if b1 != b2 {
        let [x, y] = view.at([0.5 * (b1[0] + b2[0]), 0.5 * (b1[1] + b2[1])]);
        sheet.text([x, y + 26.0], "φ₁ + φ₂", plain(16.0).italic().colored(BLUE));
    }
    for (base, pixels) in if b1 == b2 { vec![(b1, reach + 30.0)] } else { vec![(b1, reach + 30.0), (b2, 34.0)] } {
        sheet.segment(view.at(base), view.at([base[0] + view.metres(pixels), base[1]]), THIN.dashed());
    }
}

/// Figure 2: the contact support function at the normal angle that shows d best.
pub(in crate::paper) fn contact_support(shape: &SupportFunction) -> String {
    let angles = (30..110).map(|degree| f64::from(degree).to_radians());
    let theta_rad = angles.max_by(|a, b| shape.at(*a).d.total_cmp(&shape.at(*b).d)).unwrap_or(1.0);
    let mut sheet = Sheet::new(640.0, 470.0);
    let radius = 1.35 * shape.mean_radius_m();
    let view = View::fitting([-radius, -0.9 * radius], [1.25 * radius, 1.5 * radius], [20.0, 20.0], [600.0, 430.0]);
    sheet.path(outline(shape).map(|point| view.at(point)), true, line(INK, 1.6).filled(OBJECT));
    let contact = shape.at(theta_rad);
    let (sin, cos) = theta_rad.sin_cos();
    let foot = [contact.r * cos, contact.r * sin];
    let point = shape.boundary_point(theta_rad);
    let touch = [point.x_m, point.y_m];
    let along = |from: Point, length: f64| [from[0] + length * sin, from[1] - length * cos];
    let span = 1.15 * shape.mean_radius_m();
    sheet.segment(view.at(along(foot, -span)), view.at(along(foot, span)), THIN);
    sheet.segment(view.at([0.0, 0.0]), view.at([1.5 * radius.min(span), 0.0]), THIN.dashed());
    sheet.path(arc([0.0, 0.0], view.metres(36.0), 0.0, theta_rad).map(|p| view.at(p)), false, line(BLUE, 1.6));
    let half = 0.5 * theta_rad;
    let place = view.at([view.metres(50.0) * half.cos(), view.metres(50.0) * half.sin()]);
    sheet.text([place[0], place[1] + 5.0], "θ", plain(17.0).italic().colored(BLUE));
    sheet.segment(view.at([0.0, 0.0]), view.at(foot), line(RED, 2.2));
    sheet.segment(view.at(foot), view.at(touch), line(ORANGE, 2.6));
    sheet.segment(view.at([0.0, 0.0]), view.at(touch), line(INK, 1.4).dashed());
    let beside = |a: Point, b: Point, pixels: f64| {
        let (pa, pb) = (view.at(a), view.at(b));
        let (dx, dy) = (pb[0] - pa[0], pb[1] - pa[1]);
        let length = dx.hypot(dy).max(1e-9);
        [0.5 * (pa[0] + pb[0]) + pixels * dy / length, 0.5 * (pa[1] + pb[1]) - pixels * dx / length + 5.0]
    };
    sheet.text(beside([0.0, 0.0], foot, 24.0), "r(θ)", plain(17.0).italic().colored(RED));
    sheet.text(beside(foot, touch, 20.0), "d(θ)", plain(17.0).italic().colored(ORANGE));
    sheet.text(beside([0.0, 0.0], touch, -24.0), "x(θ)", plain(17.0).italic());
    let arm = view.metres(62.0);
    sheet.arrow(view.at(foot), view.at([foot[0] + arm * cos, foot[1] + arm * sin]), line(INK, 1.8));
    let tip = view.at([foot[0] + 1.25 * arm * cos, foot[1] + 1.25 * arm * sin]);
    sheet.text([tip[0], tip[1] + 5.0], "n(θ)", plain(16.0).italic());
    let from = along(foot, 0.55 * span);
    sheet.arrow(view.at(from), view.at(along(from, arm)), line(INK, 1.8));
    let tip = view.at(along(from, 1.3 * arm));
    sheet.text([tip[0] + 12.0, tip[1] - 2.0], "t(θ)", plain(16.0).italic());
    let (center, touch_at) = (view.at([0.0, 0.0]), view.at(touch));
    sheet.dot(touch_at, 5.5, area(RED));
    sheet.dot(center, 5.5, area(GREEN));
    sheet.text([center[0] - 12.0, center[1] + 22.0], "O", plain(16.0).italic().colored(GREEN));
    sheet.finish("Figure 2: the contact support function")
}

/// Figure 3: the global frame, that of the object, and those of palms and object at the contacts.
pub(in crate::paper) fn frames(rest: &Rest) -> String {
    let mut sheet = Sheet::new(640.0, 520.0);
    let view = rest.draw(&mut sheet, [60.0, 20.0], [520.0, 440.0]);
    let toward = |[x, y]: Point, pixels: f64, angle: f64| {
        let (sin, cos) = angle.sin_cos();
        [x + view.metres(pixels) * cos, y + view.metres(pixels) * sin]
    };
    let label = |sheet: &mut Sheet, at: Point, name: &str, color: &'static str| {
        let [x, y] = view.at(at);
        sheet.text([x, y + 5.0], name, plain(16.0).italic().colored(color));
    };
    let arrow = |sheet: &mut Sheet, from: Point, angle: f64, pixels: f64, color: &'static str| {
        sheet.arrow(view.at(from), view.at(toward(from, pixels, angle)), line(color, 2.0));
    };
    let named = |sheet: &mut Sheet, from: Point, angle: f64, pixels: f64, name: &str, color: &'static str| {
        arrow(sheet, from, angle, pixels, color);
        label(sheet, toward(from, pixels + 14.0, angle), name, color);
    };
    // An arc, its name at a share of it.
    let turn =
        |sheet: &mut Sheet, center: Point, [from, to]: [f64; 2], pixels: f64, (name, share): (&str, f64), color| {
            sheet.path(arc(center, view.metres(pixels), from, to).map(|point| view.at(point)), false, line(color, 1.6));
            label(sheet, toward(center, pixels + 14.0, from + share * (to - from)), name, color);
        };
    let (hinge, center) = (rest.palms.base1_m, rest.pose().offset_m);
    let (phi1, phi12) = (rest.palms.phi1_rad, rest.palms.phi12_rad());
    named(&mut sheet, hinge, 0.0, 96.0, "X", INK);
    arrow(&mut sheet, hinge, 0.25 * TAU, 84.0, INK);
    label(&mut sheet, [hinge[0] + view.metres(14.0), hinge[1] + view.metres(80.0)], "Y", INK);
    turn(&mut sheet, hinge, [0.0, phi1], 62.0, ("φ₁", 0.5), BLUE);
    turn(&mut sheet, hinge, [phi1, phi12], 36.0, ("φ₂", 0.7), BLUE);
    // From the object's x axis to the normal of palm 1 that points out of the object: θ = φ₁ − ψ − π/2 (eq. 1).
    let psi = rest.psi_rad.rem_euclid(TAU);
    let theta = rest.palms.contact_angles(psi).0.rem_euclid(TAU);
    sheet.segment(view.at(center), view.at(toward(center, 76.0, 0.0)), THIN.dashed());
    let foot = rest.shape.at(theta).r;
    sheet.segment(view.at(center), view.at(toward(center, foot / view.metres(1.0), psi + theta)), THIN.dashed());
    named(&mut sheet, center, psi, 62.0, "x", GREEN);
    named(&mut sheet, center, psi + 0.25 * TAU, 62.0, "y", GREEN);
    turn(&mut sheet, center, [0.0, psi], 40.0, ("ψ", 0.5), GREEN);
    turn(&mut sheet, center, [psi, psi + theta], 24.0, ("θ", 0.5), ORANGE);
    sheet.dot(view.at(center), 5.5, area(GREEN));
    let (one, two) = rest.contacts();
    for (palm, contact, of_palm, of_object) in
        [(Palm::One, one, ["n̄₁", "t̄₁"], ["n(θ)", "t(θ)"]), (Palm::Two, two, ["n̄₂", "t̄₂"], ["n(θ₂)", "t(θ₂)"])]
    {
        let [normal, tangent] = [rest.palms.normal(palm), rest.palms.tangent(palm)].map(|[x, y]| y.atan2(x));
        let outside = normal + 0.5 * TAU;
        named(&mut sheet, contact, normal, 58.0, of_palm[0], RED);
        named(&mut sheet, contact, outside, 44.0, of_object[0], ORANGE);
        for (angle, pixels, name, color) in
            [(tangent, 58.0, of_palm[1], RED), (tangent + 0.5 * TAU, 44.0, of_object[1], ORANGE)]
        {
            arrow(&mut sheet, contact, angle, pixels, color);
            label(&mut sheet, toward(toward(contact, pixels - 6.0, angle), 20.0, outside), name, color);
        }
        sheet.dot(view.at(contact), 5.5, area(RED));
    }
    sheet.finish("Figure 3: the coordinate frames")
}

/// Figure 4: how sensor values, contact support functions and palm angle are related (eq. 3).
pub(in crate::paper) fn dependencies(rest: &Rest) -> String {
    let mut sheet = Sheet::new(640.0, 520.0);
    let view = rest.draw(&mut sheet, [60.0, 20.0], [520.0, 440.0]);
    let center = rest.pose().offset_m;
    let (one, two) = rest.contacts();
    let (theta1, theta2) = rest.palms.contact_angles(rest.psi_rad);
    for (palm, contact, support, names) in [
        (Palm::One, one, rest.shape.at(theta1), ["s₁", "r₁", "d₁"]),
        (Palm::Two, two, rest.shape.at(theta2), ["s₂", "r₂", "d₂"]),
    ] {
        let (normal, (base, _)) = (rest.palms.normal(palm), palm_ends(&rest.palms, palm, 1.0));
        let foot = [center[0] - support.r * normal[0], center[1] - support.r * normal[1]];
        let outside = |point: Point, pixels: f64| {
            view.at([point[0] - view.metres(pixels) * normal[0], point[1] - view.metres(pixels) * normal[1]])
        };
        let middle = |a: Point, b: Point| [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        sheet.dimension(outside(base, 44.0), outside(contact, 44.0), line(RED, 1.4));
        let place = outside(middle(base, contact), 60.0);
        sheet.text([place[0], place[1] + 5.0], names[0], plain(17.0).italic().colored(RED));
        sheet.segment(view.at(center), view.at(foot), line(BLUE, 2.0));
        let (place, tangent) = (middle(center, foot), rest.palms.tangent(palm));
        // Above the line, on the side of the palm's end.
        let sign = if palm == Palm::One { 1.0 } else { -1.0 };
        let shift = sign * view.metres(15.0);
        let place = view.at([place[0] + shift * tangent[0], place[1] + shift * tangent[1]]);
        sheet.text([place[0], place[1] + 5.0], names[1], plain(17.0).italic().colored(BLUE));
        sheet.dimension(outside(foot, 16.0), outside(contact, 16.0), line(ORANGE, 1.4));
        let place = outside(middle(foot, contact), 31.0);
        sheet.text([place[0], place[1] + 5.0], names[2], plain(17.0).italic().colored(ORANGE));
        for (point, pixels) in [(foot, 22.0), (contact, 50.0), (base, 50.0)] {
            sheet.segment(view.at(point), outside(point, pixels), THIN);
        }
        sheet.dot(view.at(contact), 5.5, area(RED));
    }
    sheet.dot(view.at(center), 5.5, area(GREEN));
    hinge_angle(&mut sheet, &view, &rest.palms);
    sheet.finish("Figure 4: sensor values, contact support functions and palm angle")
}

fn hinge_angle(sheet: &mut Sheet, view: &View, palms: &PalmPair) {
    let (from, to) = (palms.phi1_rad, palms.phi12_rad());
    let radius = view.metres(40.0);
    sheet.path(arc(palms.base1_m, radius, from, to).map(|point| view.at(point)), false, line(INK, 1.6));
    let (middle, at) = (0.5 * (from + to), radius + view.metres(15.0));
    let place = view.at([palms.base1_m[0] + at * middle.cos(), palms.base1_m[1] + at * middle.sin()]);
    sheet.text([place[0], place[1] + 5.0], "φ₂", plain(17.0).italic());
}

/// Figure 5: the generalised contact support functions, projections of the vector between the contacts.
pub(in crate::paper) fn generalized(rest: &Rest) -> String {
    let mut sheet = Sheet::new(640.0, 520.0);
    let view = rest.draw(&mut sheet, [60.0, 20.0], [520.0, 440.0]);
    let (one, two) = rest.contacts();
    let (s1, s2) = rest.readings();
    let general = GeneralizedContactSupport::of_readings(&rest.palms, s1, s2);
    // From the other contact straight to the palm's line, and along it to the contact. n̄ = −R n: x₁ − x₂ has the
    // component −r̃ along n̄ and −d̃ along t̄.
    for (palm, from, to, r, names) in
        [(Palm::One, two, one, general.r1, ["r̃₁", "d̃₁"]), (Palm::Two, one, two, -general.r2, ["r̃₂", "d̃₂"])]
    {
        let (normal, tangent) = (rest.palms.normal(palm), rest.palms.tangent(palm));
        let foot = [from[0] - r * normal[0], from[1] - r * normal[1]];
        let color = if palm == Palm::One { BLUE } else { ORANGE };
        let middle = |a: Point, b: Point| view.at([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
        sheet.segment(view.at(from), view.at(foot), line(color, 1.8).dashed());
        let place = middle(from, foot);
        let shift = view.metres(16.0);
        let aside = view.at([shift * tangent[0], shift * tangent[1]]);
        let origin = view.at([0.0, 0.0]);
        let sign = if palm == Palm::One { -1.0 } else { 1.0 };
        sheet.text(
            [place[0] + sign * (aside[0] - origin[0]), place[1] + sign * (aside[1] - origin[1]) + 5.0],
            names[0],
            plain(18.0).italic().colored(color),
        );
        let outside = |point: Point, pixels: f64| {
            view.at([point[0] - view.metres(pixels) * normal[0], point[1] - view.metres(pixels) * normal[1]])
        };
        sheet.dimension(outside(foot, 18.0), outside(to, 18.0), line(color, 1.4));
        let along = [0.5 * (foot[0] + to[0]), 0.5 * (foot[1] + to[1])];
        let place = outside(along, 36.0);
        sheet.text([place[0], place[1] + 6.0], names[1], plain(18.0).italic().colored(color));
    }
    sheet.arrow(view.at(two), view.at(one), line(INK, 2.2));
    for (point, name, left) in [(one, "x₁", 1.0), (two, "x₂", -1.0)] {
        let [x, y] = view.at(point);
        sheet.dot([x, y], 5.5, area(RED));
        sheet.text([x - 6.0 * left, y - 14.0], name, plain(17.0).italic().colored(RED));
    }
    sheet.finish("Figure 5: the generalised contact support functions")
}
