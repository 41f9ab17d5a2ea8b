//! A scene as the programs read it that show it, and as a log.

use std::collections::BTreeMap;

use foxglove::Decode;
use foxglove::messages::{FrameTransform, PointCloud, PoseInFrame, SceneUpdate};
use mcap::MessageStream;
use palpate::Sample;
use palpate::compare::RigidMotion;
use palpate::live::Live;
use palpate::pivot::{PadPose, PivotSample, StrokesEstimate};
use palpate::plan::{PalmLimits, plan_turn};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate_live::{Moment, RecordError, SceneWriter, read_mcap_log, read_mcap_strokes};

/// Samples of each second.
const RATE_HZ: f64 = 100.0;
/// Of the stream.
const DURATION_S: u32 = 3;

#[test]
fn a_scene_holds_what_was_estimated_and_is_a_log() {
    let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
    let plan = plan_turn(&shape, &PalmLimits::default(), f64::from(DURATION_S)).expect("a motion without a jump");
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let options = SimulateOptions { touchpad, start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    let run = simulate(&shape, &plan.motion.sample(RATE_HZ).expect("possible"), &options).expect("possible");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.mcap");
    let mut scene = SceneWriter::create(&path, &[]).expect("a file");
    let mut live = Live::default();
    for sample in &run.log.samples {
        let estimate = live.push(sample);
        scene.push(sample, &Moment::of_palms(sample, estimate), || "{}".to_owned()).expect("room on the disk");
    }
    scene.finish().expect("room on the disk");
    assert!(
        matches!(SceneWriter::<Sample>::create(&path, &[]), Err(RecordError::Exists { .. })),
        "nothing is replaced"
    );

    let bytes = std::fs::read(&path).expect("a file");
    let mut messages: BTreeMap<String, Vec<Vec<u8>>> = BTreeMap::new();
    for message in MessageStream::new(&bytes).expect("MCAP") {
        let message = message.expect("a whole message");
        let schema = message.channel.schema.as_ref().expect("a schema");
        let is_foxglove = schema.name.starts_with("foxglove.");
        assert_eq!(is_foxglove, message.channel.message_encoding == "protobuf", "{}", schema.name);
        messages.entry(message.channel.topic.clone()).or_default().push(message.data.into_owned());
    }
    let of = |topic: &str| messages.get(topic).unwrap_or_else(|| panic!("{topic}: nothing"));
    assert_eq!(of("/palpate/sample").len(), run.log.samples.len());
    // 25 pictures a second at most.
    let pictures = of("/palpate/estimate").len() as u32;
    assert!((24 * DURATION_S..=25 * DURATION_S + 1).contains(&pictures), "{pictures}");

    let newest = live.estimate().pose.expect("a pose");
    let last = of("/palpate/pose").last().expect("a pose");
    let pose = PoseInFrame::decode(last.as_slice()).expect("a pose").pose.expect("a pose");
    let (place, turn) = (pose.position.expect("a place"), pose.orientation.expect("a turn"));
    // The last picture is less than a picture old.
    assert!((place.x - newest.com_x_m).hypot(place.y - newest.com_y_m) < 2e-3, "{place:?}");
    let psi = 2.0 * turn.z.atan2(turn.w);
    assert!(f64::sin(0.5 * (psi - newest.psi_rad)).abs() < 0.05, "{psi} {}", newest.psi_rad);
    let moved = FrameTransform::decode(of("/tf").last().expect("one").as_slice()).expect("a transform");
    assert_eq!((moved.parent_frame_id.as_str(), moved.child_frame_id.as_str()), ("palms", "object"));

    let cloud = of("/palpate/boundary").last().expect("a boundary");
    let cloud = PointCloud::decode(cloud.as_slice()).expect("a boundary");
    assert_eq!(cloud.data.len(), 720 * cloud.point_stride as usize);
    assert_eq!(cloud.frame_id, "object");
    let updates = of("/palpate/scene").iter().map(|data| SceneUpdate::decode(data.as_slice()).expect("a scene"));
    let entities: Vec<_> = updates.flat_map(|update| update.entities).collect();
    for id in ["palms", "verdict", "object"] {
        assert!(entities.iter().any(|entity| entity.id == id), "{id}");
    }
    let object = entities.iter().rfind(|entity| entity.id == "object").expect("an object");
    assert!(object.frame_locked && object.lines.iter().all(|line| line.points.len() == 721));

    // The contacts lie on the boundary where the object is.
    let held = entities.iter().rfind(|entity| entity.id == "palms").expect("palms");
    let (offset, turn) = (moved.translation.expect("a place"), moved.rotation.expect("a turn"));
    let pose = RigidMotion { angle_rad: 2.0 * turn.z.atan2(turn.w), offset_m: [offset.x, offset.y] };
    let boundary: Vec<[f64; 2]> = object.lines[0].points.iter().map(|at| pose.apply([at.x, at.y])).collect();
    assert_eq!(held.spheres.len(), 2);
    for contact in held.spheres.iter().filter_map(|sphere| sphere.pose?.position) {
        let distance_m = |at: &[f64; 2]| (at[0] - contact.x).hypot(at[1] - contact.y);
        let nearest_m = boundary.iter().map(distance_m).fold(f64::INFINITY, f64::min);
        assert!(nearest_m < 1e-3, "{contact:?}: {nearest_m} m from the boundary");
    }

    let (file, _) = read_mcap_log(&path, None, None).expect("a log");
    assert_eq!(file.log, run.log);
}

#[test]
fn a_scene_of_strokes_has_a_pad_and_a_pivot_and_is_a_log_of_strokes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.mcap");
    let mut scene = SceneWriter::create(&path, &[]).expect("a file");
    let mut estimate = StrokesEstimate::default();
    let samples: Vec<PivotSample> = (0..40)
        .map(|index| {
            let time_s = 0.05 * f64::from(index);
            let s_m = (index > 5).then_some(0.51);
            PivotSample { time_s, pivot_x_m: 0.5 + 0.02 * time_s, pivot_y_m: 0.03, s_m }
        })
        .collect();
    for sample in &samples {
        estimate.psi_rad = (sample.time_s > 1.0).then_some(0.3);
        let moment = Moment::of_strokes(sample, &estimate, &PadPose::default());
        scene.push(sample, &moment, || "{}".to_owned()).expect("room on the disk");
    }
    scene.finish().expect("room on the disk");
    assert_eq!(read_mcap_strokes(&path, None).expect("a log").log.samples, samples);

    let bytes = std::fs::read(&path).expect("a file");
    let messages = || MessageStream::new(&bytes).expect("MCAP").map(|message| message.expect("a whole message"));
    let moved = messages().filter(|message| message.channel.topic == "/tf").last().expect("a transform");
    let moved = FrameTransform::decode(&*moved.data).expect("a transform");
    assert_eq!((moved.parent_frame_id.as_str(), moved.child_frame_id.as_str()), ("world", "object"));
    let newest = samples.last().expect("samples");
    assert_eq!(moved.translation.map(|at| (at.x, at.y)), Some((newest.pivot_x_m, newest.pivot_y_m)));
    let scene = messages().filter(|message| message.channel.topic == "/palpate/scene").last().expect("a scene");
    let scene = SceneUpdate::decode(&*scene.data).expect("a scene");
    let pad = scene.entities.iter().find(|entity| entity.id == "pad").expect("a pad");
    // The contact and the pivot.
    assert_eq!((pad.lines.len(), pad.spheres.len()), (1, 2));
}
