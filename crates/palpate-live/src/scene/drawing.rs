//! Messages of a scene: lengths in metres, x to the right and y up in the plane in which the palms turn, z towards whoever looks.

use foxglove::messages::line_primitive::Type;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    Color, FrameTransform, LinePrimitive, PackedElementField, Point3, PointCloud, Pose, PoseInFrame, Quaternion,
    SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive, Timestamp, Vector3,
};
use palpate::Sample;
use palpate::live::Estimate;
use palpate::reconstruct::OutlinePoint;

/// The frame in which the palms are, and that of the object: its centre of mass is the origin.
pub(super) const PALMS: &str = "palms";
pub(super) const OBJECT: &str = "object";

/// Palms are drawn so far beyond the furthest contact, as a factor; and where there is none yet, so long, metres.
const BEYOND_CONTACT: f64 = 1.3;
const LENGTH_M: f64 = 0.08;

/// Lines, contacts and the centre of mass are drawn so large, metres.
const PALM_M: f64 = 1.5e-3;
const OUTLINE_M: f64 = 7e-4;
const BAND_M: f64 = 2e-4;
const CONTACT_M: f64 = 2.4e-3;
const CENTER_M: f64 = 2e-3;
const TEXT_M: f64 = 5e-3;

/// Standard deviations on each side of a 95 % band.
const BAND_SDS: f64 = 1.96;

const PALM_COLOR: Color = Color { r: 0.45, g: 0.48, b: 0.53, a: 1.0 };
const FELT: Color = Color { r: 0.12, g: 0.47, b: 0.71, a: 1.0 };
const UNFELT: Color = Color { a: 0.25, ..FELT };
const BAND: Color = Color { a: 0.5, ..FELT };
const CONTACT: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };
const CENTER: Color = Color { r: 0.8, g: 0.47, b: 0.65, a: 1.0 };
const CERTIFIED: Color = Color { r: 0.0, g: 0.62, b: 0.45, a: 1.0 };
const DOUBTED: Color = Color { r: 0.5, g: 0.5, b: 0.5, a: 1.0 };

/// Palms, contacts and the verdict at a sample.
pub(super) fn palms(sample: &Sample, estimate: &Estimate, time: Timestamp) -> SceneUpdate {
    let seen_m = [sample.s1_m, sample.s2_m];
    let furthest_m = seen_m.iter().flatten().copied().fold(0.0, f64::max);
    let length_m = if furthest_m > 0.0 { BEYOND_CONTACT * furthest_m } else { LENGTH_M };
    let at = |s_m: [f64; 2]| <[[f64; 2]; 2]>::from(sample.palms.contact_points_m(s_m[0], s_m[1]));
    let (bases, ends) = (at([0.0; 2]), at([length_m; 2]));
    let lines = [0, 1].map(|palm| LinePrimitive {
        points: vec![point(bases[palm]), point(ends[palm])],
        color: Some(PALM_COLOR),
        ..line(Type::LineStrip, PALM_M)
    });
    let places = at(seen_m.map(|s_m| s_m.unwrap_or(f64::NAN)));
    let seen = places.into_iter().zip(seen_m).filter(|(_, s_m)| s_m.is_some());
    let contacts = seen.map(|(place, _)| sphere(place, CONTACT_M, CONTACT));
    let (text, color) =
        if estimate.is_certified() { ("certified".to_owned(), CERTIFIED) } else { (estimate.reason(), DOUBTED) };
    let verdict = TextPrimitive {
        pose: Some(pose([0.0, -2.0 * TEXT_M], 0.0)),
        billboard: true,
        font_size: TEXT_M,
        color: Some(color),
        text: format!("{:.0} % felt, {text}", 100.0 * estimate.coverage),
        ..TextPrimitive::default()
    };
    let palms = SceneEntity { lines: lines.into(), spheres: contacts.collect(), ..entity("palms", PALMS, time) };
    let verdict = SceneEntity { texts: vec![verdict], ..entity("verdict", PALMS, time) };
    SceneUpdate { entities: vec![palms, verdict], ..SceneUpdate::default() }
}

/// The boundary in the frame of the object: what was felt, what was not, and the band that it is in.
pub(super) fn object(estimate: &Estimate, time: Timestamp) -> SceneUpdate {
    let points = &estimate.outline;
    let closed = || points.iter().chain(points.first());
    let color = |point: &OutlinePoint| if point.touches > 0 { FELT } else { UNFELT };
    let outline = LinePrimitive {
        points: closed().map(|at| point([at.x_m, at.y_m])).collect(),
        colors: closed().map(color).collect(),
        ..line(Type::LineStrip, OUTLINE_M)
    };
    let band = [-BAND_SDS, BAND_SDS].map(|sds| LinePrimitive {
        points: closed().map(|at| point(moved_out(at, sds * at.r_sd_m))).collect(),
        color: Some(BAND),
        ..line(Type::LineStrip, BAND_M)
    });
    let lines = std::iter::once(outline).chain(band).collect();
    let spheres = vec![sphere([0.0, 0.0], CENTER_M, CENTER)];
    let object = SceneEntity { frame_locked: true, lines, spheres, ..entity("object", OBJECT, time) };
    SceneUpdate { entities: vec![object], ..SceneUpdate::default() }
}

/// A point of the boundary moved along its outward normal.
fn moved_out(at: &OutlinePoint, by_m: f64) -> [f64; 2] {
    let by_m = if by_m.is_finite() { by_m } else { 0.0 };
    let (sin, cos) = at.theta_rad.sin_cos();
    [at.x_m + by_m * cos, at.y_m + by_m * sin]
}

/// The boundary as points with their standard deviations (metres) and touches: for programs that show no scenes.
pub(super) fn boundary(estimate: &Estimate, time: Timestamp) -> PointCloud {
    const FIELDS: [&str; 5] = ["x", "y", "z", "r_sd_m", "touches"];
    let field = |(index, name): (usize, &&str)| PackedElementField {
        name: (*name).to_owned(),
        offset: (index * size_of::<f32>()) as u32,
        r#type: NumericType::Float32.into(),
    };
    let values = |at: &OutlinePoint| [at.x_m as f32, at.y_m as f32, 0.0, at.r_sd_m as f32, at.touches as f32];
    let data: Vec<u8> = estimate.outline.iter().flat_map(values).flat_map(f32::to_le_bytes).collect();
    PointCloud {
        timestamp: Some(time),
        frame_id: OBJECT.to_owned(),
        pose: Some(pose([0.0, 0.0], 0.0)),
        point_stride: (FIELDS.len() * size_of::<f32>()) as u32,
        fields: FIELDS.iter().enumerate().map(field).collect(),
        data: data.into(),
    }
}

/// Where the object is.
pub(super) fn pose_of(at: &palpate::reconstruct::Pose, time: Timestamp) -> (PoseInFrame, FrameTransform) {
    let pose = pose([at.com_x_m, at.com_y_m], at.psi_rad);
    let transform = FrameTransform {
        timestamp: Some(time),
        parent_frame_id: PALMS.to_owned(),
        child_frame_id: OBJECT.to_owned(),
        translation: pose.position,
        rotation: pose.orientation,
    };
    (PoseInFrame { timestamp: Some(time), frame_id: PALMS.to_owned(), pose: Some(pose) }, transform)
}

fn entity(id: &str, frame: &str, time: Timestamp) -> SceneEntity {
    SceneEntity { timestamp: Some(time), frame_id: frame.to_owned(), id: id.to_owned(), ..SceneEntity::default() }
}

fn line(kind: Type, thickness: f64) -> LinePrimitive {
    LinePrimitive { r#type: kind.into(), thickness, pose: Some(pose([0.0, 0.0], 0.0)), ..LinePrimitive::default() }
}

fn sphere(at: [f64; 2], size: f64, color: Color) -> SpherePrimitive {
    let size = Some(Vector3 { x: size, y: size, z: size });
    SpherePrimitive { pose: Some(pose(at, 0.0)), size, color: Some(color) }
}

fn point([x, y]: [f64; 2]) -> Point3 {
    Point3 { x, y, z: 0.0 }
}

fn pose([x, y]: [f64; 2], turned_rad: f64) -> Pose {
    let (z, w) = (0.5 * turned_rad).sin_cos();
    Pose { position: Some(Vector3 { x, y, z: 0.0 }), orientation: Some(Quaternion { x: 0.0, y: 0.0, z, w }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate::palms::PalmPair;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

    #[test]
    fn contacts_lie_on_their_palms_and_an_object_is_turned_counter_clockwise() {
        // Palm 1 upright, palm 2 at 60 degrees to its left, its base 10 mm to the left.
        let palms_at = PalmPair { base2_m: [-0.01, 0.0], ..PalmPair::hinged(FRAC_PI_2, FRAC_PI_3) };
        let sample = Sample::new(0.0, palms_at, 0.03, 0.02);
        let scene = palms(&sample, &Estimate::default(), Timestamp::new(0, 0));
        let expected = [[0.0, 0.03], [-0.01 - 0.02 * FRAC_PI_3.sin(), 0.02 * FRAC_PI_3.cos()]];
        let entity = &scene.entities[0];
        for ((sphere, line), [x, y]) in entity.spheres.iter().zip(&entity.lines).zip(expected) {
            let contact = sphere.pose.and_then(|pose| pose.position).expect("a place");
            assert!((contact.x - x).hypot(contact.y - y) < 1e-12, "{contact:?}");
            // And between the ends of the line that is drawn for the palm.
            let [base, end] = line.points[..] else { panic!("two ends") };
            let [along, whole] = [[contact.x - base.x, contact.y - base.y], [end.x - base.x, end.y - base.y]];
            assert!((along[0] * whole[1] - along[1] * whole[0]).abs() < 1e-12);
            assert!(along[0] * whole[0] + along[1] * whole[1] > 0.0);
        }
        assert_eq!(entity.spheres.len(), 2);
        let one = Sample { s1_m: None, ..sample };
        assert_eq!(palms(&one, &Estimate::default(), Timestamp::new(0, 0)).entities[0].spheres.len(), 1);
        let turned = pose([0.0, 0.0], FRAC_PI_2).orientation.expect("turned");
        assert!((turned.z - turned.w).abs() < 1e-12 && turned.z > 0.0);
    }
}
