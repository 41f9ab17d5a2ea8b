//! Messages of a scene: lengths in metres, x to the right and y up in the plane of the rig, z towards whoever looks.

use foxglove::messages::line_primitive::Type;
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{
    Color, FrameTransform, LinePrimitive, PackedElementField, Point3, PointCloud, Pose, PoseInFrame, Quaternion,
    SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive, Timestamp, Vector3,
};
use palpate::reconstruct::OutlinePoint;

use super::moment::Moment;

/// The frame of the object: its origin is the centre of mass, or the pivot.
const OBJECT: &str = "object";

/// Lines, contacts, the centre of mass and the pivot are drawn so large, metres.
const SURFACE_M: f64 = 1.5e-3;
const OUTLINE_M: f64 = 7e-4;
const BAND_M: f64 = 2e-4;
const CONTACT_M: f64 = 2.4e-3;
const CENTER_M: f64 = 2e-3;
const TEXT_M: f64 = 5e-3;

/// Standard deviations on each side of a 95 % band.
const BAND_SDS: f64 = 1.96;

const SURFACE_COLOR: Color = Color { r: 0.45, g: 0.48, b: 0.53, a: 1.0 };
const FELT: Color = Color { r: 0.12, g: 0.47, b: 0.71, a: 1.0 };
const UNFELT: Color = Color { a: 0.25, ..FELT };
const BAND: Color = Color { a: 0.5, ..FELT };
const CONTACT: Color = Color { r: 0.84, g: 0.37, b: 0.0, a: 1.0 };
const CENTER: Color = Color { r: 0.8, g: 0.47, b: 0.65, a: 1.0 };
const CERTIFIED: Color = Color { r: 0.0, g: 0.62, b: 0.45, a: 1.0 };
const DOUBTED: Color = Color { r: 0.5, g: 0.5, b: 0.5, a: 1.0 };

/// Surfaces, contacts and the verdict at a sample.
pub(super) fn surfaces(moment: &Moment, time: Timestamp) -> SceneUpdate {
    let lines = moment.ends_m.iter().map(|ends_m| LinePrimitive {
        points: ends_m.map(point).into(),
        color: Some(SURFACE_COLOR),
        ..line(Type::LineStrip, SURFACE_M)
    });
    let contacts = moment.contacts_m.iter().map(|at_m| sphere(*at_m, CONTACT_M, CONTACT));
    let pivot = moment.pivot_m.map(|at_m| sphere(at_m, CENTER_M, CENTER));
    let (text, color) = match &moment.doubt {
        None => ("certified", CERTIFIED),
        Some(doubt) => (doubt.as_str(), DOUBTED),
    };
    // Below the middle of what is seen.
    let ends = moment.ends_m.iter().flatten();
    let [x_m, y_m] = match moment.pivot_m {
        Some([x_m, _]) => [x_m, ends.map(|end| end[1]).fold(f64::INFINITY, f64::min)],
        None => [0.0; 2],
    };
    let verdict = TextPrimitive {
        pose: Some(pose([x_m, y_m - 2.0 * TEXT_M], 0.0)),
        billboard: true,
        font_size: TEXT_M,
        color: Some(color),
        text: format!("{:.0} % felt, {text}", 100.0 * moment.coverage),
        ..TextPrimitive::default()
    };
    let spheres = contacts.chain(pivot).collect();
    let surfaces = SceneEntity { lines: lines.collect(), spheres, ..entity(moment.surfaces, moment.frame, time) };
    let verdict = SceneEntity { texts: vec![verdict], ..entity("verdict", moment.frame, time) };
    SceneUpdate { entities: vec![surfaces, verdict], ..SceneUpdate::default() }
}

/// The boundary in the frame of the object: what was felt, what was not, and the band that it is in.
pub(super) fn object(moment: &Moment, time: Timestamp) -> SceneUpdate {
    let points = moment.outline;
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
    let center = moment.is_about_mass.then(|| sphere([0.0, 0.0], CENTER_M, CENTER));
    let spheres = center.into_iter().collect();
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
pub(super) fn boundary(moment: &Moment, time: Timestamp) -> PointCloud {
    const FIELDS: [&str; 5] = ["x", "y", "z", "r_sd_m", "touches"];
    let field = |(index, name): (usize, &&str)| PackedElementField {
        name: (*name).to_owned(),
        offset: (index * size_of::<f32>()) as u32,
        r#type: NumericType::Float32.into(),
    };
    let values = |at: &OutlinePoint| [at.x_m as f32, at.y_m as f32, 0.0, at.r_sd_m as f32, at.touches as f32];
    let data: Vec<u8> = moment.outline.iter().flat_map(values).flat_map(f32::to_le_bytes).collect();
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
pub(super) fn pose_of(moment: &Moment, time: Timestamp) -> Option<(PoseInFrame, FrameTransform)> {
    let (at_m, psi_rad) = moment.pose?;
    let pose = pose(at_m, psi_rad);
    let transform = FrameTransform {
        timestamp: Some(time),
        parent_frame_id: moment.frame.to_owned(),
        child_frame_id: OBJECT.to_owned(),
        translation: pose.position,
        rotation: pose.orientation,
    };
    Some((PoseInFrame { timestamp: Some(time), frame_id: moment.frame.to_owned(), pose: Some(pose) }, transform))
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
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn an_object_is_turned_counter_clockwise() {
        let turned = pose([0.0, 0.0], FRAC_PI_2).orientation.expect("turned");
        assert!((turned.z - turned.w).abs() < 1e-12 && turned.z > 0.0);
    }
}
