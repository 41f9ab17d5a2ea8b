//! What several figures draw alike: palms, object and contacts at one instant, in the global frame.

use palpate::Reconstruction;
use palpate::compare::RigidMotion;
use palpate::palms::{Palm, PalmPair};
use palpate::shape::SupportFunction;
use std::f64::consts::TAU;

use crate::drawing::svg::{Pen, Point, Sheet, View, area};
use crate::paper::input::Trial;

/// The outline of a shape in its own frame, metres.
pub(in crate::paper) fn outline(shape: &SupportFunction) -> impl Iterator<Item = Point> + use<'_> {
    (0..240).map(|step| {
        let point = shape.boundary_point(TAU * f64::from(step) / 240.0);
        [point.x_m, point.y_m]
    })
}

/// Draws both palms, `length_m` long.
pub(in crate::paper) fn palms(sheet: &mut Sheet, view: &View, palms: &PalmPair, length_m: f64, pen: Pen) {
    for palm in [Palm::One, Palm::Two] {
        let (base, end) = palm_ends(palms, palm, length_m);
        sheet.segment(view.at(base), view.at(end), pen);
    }
    let mut base = |base: Point| sheet.dot(view.at(base), 1.1 * pen.width, area(pen.stroke));
    base(palms.base1_m);
    if palms.base2_m != palms.base1_m {
        base(palms.base2_m);
    }
}

/// A view that holds a body and both palms, `length_m` long.
pub(in crate::paper) fn view_of(body: &[Point], palms: &PalmPair, length_m: f64, corner: Point, size: Point) -> View {
    let ends = [Palm::One, Palm::Two].map(|palm| palm_ends(palms, palm, length_m));
    let all = || body.iter().copied().chain(ends.iter().flat_map(|(base, end)| [*base, *end]));
    let low = [0, 1].map(|axis| all().map(|point| point[axis]).fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|axis| all().map(|point| point[axis]).fold(f64::NEG_INFINITY, f64::max));
    View::fitting(low, high, corner, size)
}

/// Base and a point `length_m` from it along a palm, metres.
pub(in crate::paper) fn palm_ends(palms: &PalmPair, palm: Palm, length_m: f64) -> (Point, Point) {
    let tangent = palms.tangent(palm);
    let (base, sign) = match palm {
        Palm::One => (palms.base1_m, 1.0),
        Palm::Two => (palms.base2_m, -1.0),
    };
    (base, [base[0] + sign * length_m * tangent[0], base[1] + sign * length_m * tangent[1]])
}

/// The reconstructed pose at a sample: carries the object frame into the global one.
pub(in crate::paper) fn pose(found: &Reconstruction, sample: usize) -> RigidMotion {
    found.motion.get(sample).map_or(RigidMotion { angle_rad: 0.0, offset_m: [0.0; 2] }, |pose| RigidMotion {
        angle_rad: pose.psi_rad,
        offset_m: [pose.com_x_m, pose.com_y_m],
    })
}

/// The true pose at a sample.
pub(in crate::paper) fn true_pose(trial: &Trial, sample: usize) -> RigidMotion {
    trial.truth.motion.get(sample).map_or(RigidMotion { angle_rad: 0.0, offset_m: [0.0; 2] }, |pose| RigidMotion {
        angle_rad: pose.psi_rad,
        offset_m: [pose.com_x_m, pose.com_y_m],
    })
}

/// Where the contacts of a sample were felt, in the object frame that a reconstruction gives the object: the sensed points,
/// brought back by the reconstructed pose. Metres; with the normal angle there.
pub(in crate::paper) fn observed_points(
    trial: &Trial,
    found: &Reconstruction,
    sample: usize,
) -> [Option<(f64, Point)>; 2] {
    let (Some(sample_felt), Some(pose_found)) = (trial.log.samples.get(sample), found.motion.get(sample)) else {
        return [None, None];
    };
    let pose = pose(found, sample);
    let (one, two) =
        sample_felt.palms.contact_points_m(sample_felt.s1_m.unwrap_or(0.0), sample_felt.s2_m.unwrap_or(0.0));
    [
        sample_felt.s1_m.map(|_| (pose_found.theta1_rad, pose.undo(one))),
        sample_felt.s2_m.map(|_| (pose_found.theta2_rad, pose.undo(two))),
    ]
}
