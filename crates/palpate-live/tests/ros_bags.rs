//! ROS 2 bags in MCAP: what a map of topics finds in them, and what it says where it does not.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use palpate_live::{RigKind, SourceError, mcap_rig_kind, read_mcap_log, read_mcap_strokes};

const MAP: &str = r#"
phi1 = { topic = "/joint_states", field = "position[palm1]" }
phi2 = { topic = "/joint_states", field = "position[palm2]" }
s1 = { topic = "/palm1/contact", field = "point.x" }
s2 = { topic = "/pads", field = "data[0]", unit = "mm" }
force1 = { topic = "/palm1/wrench", field = "wrench.force.z" }
"#;

/// A little-endian CDR message that begins with a stamp at so many milliseconds.
fn stamped(time_ms: u32) -> Vec<u8> {
    let mut bytes = vec![0, 1, 0, 0];
    for value in [time_ms / 1000, time_ms % 1000 * 1_000_000, 1] {
        bytes.extend(value.to_le_bytes());
    }
    // An empty frame, ended and padded.
    bytes.extend([0; 4]);
    bytes
}

fn floats(mut bytes: Vec<u8>, values: &[f64]) -> Vec<u8> {
    while !(bytes.len() - 4).is_multiple_of(8) {
        bytes.push(0);
    }
    values.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes
}

fn joints(time_ms: u32, phi1_rad: f64, phi2_rad: f64) -> Vec<u8> {
    let mut bytes = stamped(time_ms);
    bytes.extend(2_u32.to_le_bytes());
    for name in [b"palm2\0", b"palm1\0"] {
        bytes.extend(6_u32.to_le_bytes());
        bytes.extend(name);
        bytes.extend([0; 2]);
    }
    bytes.extend(2_u32.to_le_bytes());
    let mut bytes = floats(bytes, &[phi2_rad, phi1_rad]);
    bytes.extend([0; 8]);
    bytes
}

/// A bag of half a second: angles at 50 Hz, touch at 100 Hz; each message may be spoiled on its way.
fn bag(dir: &Path, encoding: &str, spoil: impl Fn(&str, &mut Vec<u8>)) -> PathBuf {
    let mut file = Cursor::new(Vec::new());
    let mut writer = WriteOptions::new().compression(None).profile("ros2").create(&mut file).expect("a bag");
    let topics = [
        ("/joint_states", "sensor_msgs/msg/JointState"),
        ("/palm1/contact", "geometry_msgs/msg/PointStamped"),
        ("/pads", "std_msgs/msg/Float64MultiArray"),
        ("/palm1/wrench", "geometry_msgs/msg/WrenchStamped"),
        ("/camera", "sensor_msgs/msg/Image"),
    ];
    let channels: Vec<u16> = topics
        .iter()
        .map(|(topic, schema)| {
            let schema = writer.add_schema(schema, "ros2msg", b"").expect("a schema");
            writer.add_channel(schema, topic, encoding, &BTreeMap::new()).expect("a channel")
        })
        .collect();
    let mut write = |time_ms: u32, index: usize, mut data: Vec<u8>| {
        spoil(topics[index].0, &mut data);
        let log_time = u64::from(time_ms) * 1_000_000;
        let header = MessageHeader { channel_id: channels[index], sequence: 0, log_time, publish_time: log_time };
        writer.write_to_known_channel(&header, &data).expect("a message");
    };
    for time_ms in (1000..1500).step_by(5) {
        let phi_rad = f64::from(time_ms) / 10_000.0;
        if time_ms % 20 == 0 {
            write(time_ms, 0, joints(time_ms, 1.0 + phi_rad, 1.5 - phi_rad));
            write(time_ms, 4, vec![7; 100]);
        }
        if time_ms % 10 == 5 {
            write(time_ms, 1, floats(stamped(time_ms), &[0.03, 0.0, 0.0]));
            write(time_ms, 3, floats(stamped(time_ms), &[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]));
            // No layout: no dimensions, no offset, then one number.
            write(time_ms, 2, floats(vec![0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0], &[40.0]));
        }
    }
    writer.finish().expect("a bag");
    drop(writer);
    let path = dir.join("bag.mcap");
    fs::write(&path, file.into_inner()).expect("a bag");
    path
}

fn read(dir: &Path, bag: &Path, map: &str) -> Result<palpate_io::LogFile, SourceError> {
    let path = dir.join("topics.toml");
    fs::write(&path, map).expect("a map");
    read_mcap_log(bag, Some(&path), None).map(|(file, _)| file)
}

#[test]
fn angles_are_interpolated_at_the_instants_of_touch() {
    let dir = tempfile::tempdir().expect("a folder");
    let bag = bag(dir.path(), "cdr", |_, _| {});
    let file = read(dir.path(), &bag, MAP).expect("a log");
    // The last touch is after the last angles.
    assert_eq!(file.log.samples.len(), 48);
    for (index, sample) in file.log.samples.iter().enumerate() {
        let time_s = 1.005 + 0.01 * index as f64;
        assert!((sample.time_s - (time_s - 1.0)).abs() < 1e-9, "{index}: {}", sample.time_s);
        assert!((sample.palms.phi1_rad - (1.0 + time_s / 10.0)).abs() < 1e-9, "{index}");
        assert!((sample.palms.phi2_rad - (1.5 - time_s / 10.0)).abs() < 1e-9, "{index}");
        assert_eq!((sample.s1_m, sample.s2_m), (Some(0.03), Some(0.04)));
        assert_eq!((sample.force1_n, sample.force2_n), (Some(2.0), None));
    }
    assert_eq!(file.notes, ["left out or noticed: 2 readings without palm angles"]);
}

#[test]
fn the_pivot_is_interpolated_at_the_instants_of_touch_of_a_pad() {
    let dir = tempfile::tempdir().expect("a folder");
    let bag = bag(dir.path(), "cdr", |_, _| {});
    let map = r#"
        pivot_x = { topic = "/joint_states", field = "position[palm1]" }
        pivot_y = { topic = "/joint_states", field = "position[palm2]", unit = "cm" }
        s = { topic = "/pads", field = "data[0]", unit = "mm" }
    "#;
    let path = dir.path().join("topics.toml");
    fs::write(&path, map).expect("a map");
    assert_eq!(mcap_rig_kind(&bag, Some(&path)), RigKind::Pivot);
    let file = read_mcap_strokes(&bag, Some(&path)).expect("a log");
    assert!(file.log.samples.len() >= 45, "{}", file.log.samples.len());
    for sample in &file.log.samples {
        // Times are counted from the first message of all, those of the pad are of its log time.
        let time_s = 1.0 + sample.time_s;
        assert!((sample.pivot_x_m - (1.0 + time_s / 10.0)).abs() < 1e-9, "{sample:?}");
        assert!((sample.pivot_y_m - 0.01 * (1.5 - time_s / 10.0)).abs() < 1e-9, "{sample:?}");
        assert_eq!(sample.s_m, Some(0.04));
    }
}

#[test]
fn messages_that_are_damaged_are_counted_and_the_first_is_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let bag = bag(dir.path(), "cdr", |topic, data| {
        if topic == "/palm1/contact" {
            data.truncate(20);
        }
        if topic == "/palm1/wrench" {
            data.resize(300_000, 0);
        }
    });
    let error = read(dir.path(), &bag, MAP).expect_err("no positions").to_string();
    assert!(error.contains("0 samples have a contact on both palms, and 12 are needed"), "{error}");
    assert!(error.contains("50 faulty lines or messages, 50 overlong lines or messages"), "{error}");
    assert!(error.contains("topic /palm1/contact: "), "{error}");
}

#[test]
fn what_a_bag_does_not_hold_is_named() {
    let dir = tempfile::tempdir().expect("a folder");
    let bag = bag(dir.path(), "cdr", |_, _| {});
    for (from, to, expected) in [
        ("/palm1/contact", "/palm1/touch", "there is no message of the topic /palm1/touch"),
        ("point.x", "data[3]", "topic /palm1/contact: its messages are \"geometry_msgs/msg/PointStamped\""),
    ] {
        let error = read(dir.path(), &bag, &MAP.replace(from, to)).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    }
    let error = read_mcap_log(&bag, None, None).map(|_| ()).expect_err("no recording").to_string();
    assert!(error.contains("it holds no samples that palpate recorded"), "{error}");
    let other = self::bag(dir.path(), "protobuf", |_, _| {});
    let error = read(dir.path(), &other, MAP).expect_err("an encoding that is not read").to_string();
    assert!(error.contains("encoded as \"protobuf\"; only cdr and json are read"), "{error}");
}

#[test]
fn a_bag_that_is_damaged_anywhere_is_no_panic() {
    let dir = tempfile::tempdir().expect("a folder");
    let bag = bag(dir.path(), "cdr", |_, _| {});
    let bytes = fs::read(&bag).expect("the bag");
    for at in (0..bytes.len()).step_by(61) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x55;
        fs::write(&bag, &damaged).expect("a bag");
        if let Ok(file) = read(dir.path(), &bag, MAP) {
            assert!(file.log.samples.len() <= 50);
        }
        fs::write(&bag, &bytes[..at]).expect("a bag");
        // What was cut off is read as far as it goes.
        let _ = read(dir.path(), &bag, MAP);
    }
}
