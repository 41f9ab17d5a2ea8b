//! Rig files that are read, the template, and every way in which a rig file can be wrong, with the whole message that the user sees.

use std::io;
use std::path::Path;

use palpate::sensor::{Calibration, Rig, Tolerances};

use super::*;
use crate::rig::conventions::{Direction, PalmConventions};
use crate::rig::key::TABLES;
use crate::rig::parse::{parse_rig, read_rig};
use crate::rig::rig_error::RigError;

/// What the user is told of a rig file.
fn message(text: &str) -> String {
    parse_rig("rig.toml", text).map_or_else(|error| error.to_string(), |_| "accepted".to_string())
}

#[track_caller]
fn refused(text: &str, expected: &str) {
    assert_eq!(message(text), expected);
}

#[track_caller]
fn read(text: &str) -> RigFile {
    parse_rig("rig.toml", text).expect("a rig file")
}

#[test]
fn every_key_is_read() {
    let palm = "zero_m = 1e-3\nzero_sd_m = 2e-3\nscale = 1.02\nscale_sd = 0.003\nsurface_offset_m = 4e-3\nsurface_offset_sd_m = 0\n\
        direction = \"to_base\"\nlength_m = 0.055\nreading_sd_m = 5e-5\ncounts_per_inch = 200\nlevels = 128\nfriction = 0.3\n\
        friction_sd = 0.05\nbase_x_m = 0.01\nbase_y_m = -0.02\n";
    let angles = "phi1_zero_rad = 0.01\nphi2_zero_rad = -0.02\nphi1_zero_sd_rad = 0.03\nphi2_zero_sd_rad = 0.04\nsign1 = -1\n\
        sign2 = 1.0\nreading_sd_rad = 1e-4\n";
    let found = read(&format!("[palm2]\n{palm}[angles]\n{angles}[clock]\noffset_s = 0.005\noffset_sd_s = 0.001\n"));

    let (mut calibration, mut tolerances) = (Calibration::default(), Tolerances::default());
    (calibration.zero_m[1], calibration.scale[1], calibration.surface_m[1]) = (1e-3, 1.02, 4e-3);
    (calibration.angle_zero_rad, calibration.clock_offset_s) = ([0.01, -0.02], 0.005);
    (tolerances.zero_sd_m[1], tolerances.scale_sd[1], tolerances.surface_sd_m[1]) = (2e-3, 0.003, 0.0);
    (tolerances.angle_zero_sd_rad, tolerances.clock_offset_sd_s) = ([0.03, 0.04], 0.001);
    assert_eq!(found.rig, Rig::new(calibration, tolerances));

    let palm2 = PalmConventions { direction: Direction::ToBase { length_m: 0.055 }, base_m: [Some(0.01), Some(-0.02)] };
    let palms = [PalmConventions::default(), palm2];
    assert_eq!(found.conventions, Conventions { palms, angle_signs: [-1.0, 1.0] });
    let pad = Pad {
        reading_sd_m: Some(5e-5),
        counts_per_inch: Some(200.0),
        levels: Some(128),
        friction: Some(0.3),
        friction_sd: Some(0.05),
    };
    assert_eq!((found.pads, found.angle_reading_sd_rad), ([Pad::default(), pad], Some(1e-4)));
}

#[test]
fn other_units_are_understood() {
    let si = "[palm1]\nzero_m = 0.0003\nzero_sd_m = 20e-6\nlength_m = 0.055\n[angles]\nphi1_zero_rad = 0.0\n[clock]\noffset_s = 0.005";
    let other =
        "[palm1]\nzero_mm = 0.3\nzero_sd_um = 20\nlength_cm = 5.5\n[angles]\nphi1_zero_deg = 0\n[clock]\noffset_ms = 5";
    assert_eq!(read(si), read(other));
    let angles = read("[angles]\nphi1_zero_deg = 1\nphi2_zero_sd_deg = 0.25\nreading_sd_deg = 0.1");
    assert_eq!(angles.rig.calibration.angle_zero_rad[0], 1_f64.to_radians());
    assert_eq!(angles.rig.tolerances.angle_zero_sd_rad, [0.5_f64.to_radians(), 0.25_f64.to_radians()]);
    assert_eq!(angles.angle_reading_sd_rad, Some(0.1_f64.to_radians()));
}

#[test]
fn toml_is_read_in_all_its_ways() {
    let found = read("[palm1]\nzero_mm = 0.3\nlevels = 16\n");
    assert_eq!(read("palm1.zero_mm = 0.3\npalm1.levels = 0x10\n"), found);
    assert_eq!(read("\u{feff}palm1 = { zero_mm = 3e-1, levels = 1_6 } # a comment\r\n"), found);
}

#[test]
fn a_length_without_a_direction_is_kept() {
    let palm = read("[palm1]\nlength_mm = 55.5").conventions.palms[0];
    assert_eq!(palm.direction, Direction::FromBase { length_m: Some(0.0555) });
}

#[test]
fn no_toml() {
    let end = "correct the line: it should be such as [palm1], or zero_mm = 0.3, or # a comment";
    for text in ["[palm1]\nzero_mm 0.3\n", "[palm1]\ndirection = to_base\n", "[palm1]\nzero_mm = 0,3\n"] {
        let message = message(text);
        assert!(message.starts_with("rig.toml, line 2: ") && message.ends_with(end), "{message}");
    }
    refused("[palm1]\nscale = 1\nscale = 1\n", &format!("rig.toml, line 3: duplicate key; {end}"));
}

#[test]
fn many_keys_take_no_time() {
    let text: String = (0..100_000).map(|index| format!("a{index} = 1\n")).collect();
    assert!(message(&text).starts_with("rig.toml, line 1, key a0: "));
    let text = format!("[clock]\noffset_ms = 1\n\n[palm1]\n# {}\nfriction = -1", "x".repeat(1 << 16));
    assert!(message(&text).starts_with("rig.toml, line 6, key palm1.friction: -1 is negative"));
}

#[test]
fn unknown_names() {
    refused(
        "\n[palm3]\nzero_mm = 1\n",
        "rig.toml, line 2, key palm3: a rig file has no such table; did you mean [palm1]?",
    );
    refused("clock = 3\n", "rig.toml, line 1, key clock: this is a table; write [clock] in a line and its keys below");
    refused("zero_mm = 3\n", "rig.toml, line 1, key zero_mm: a rig file has no such key; did you mean palm1.zero_mm?");
    refused(
        "[palm2]\nscale = 1\nsurface_ofset_mm = 2\n",
        "rig.toml, line 3, key palm2.surface_ofset_mm: a rig file has no such key; did you mean palm2.surface_offset_mm?",
    );
    refused(
        "[palm1]\nphi1_zero_deg = 2\n",
        "rig.toml, line 2, key palm1.phi1_zero_deg: a rig file has no such key; did you mean angles.phi1_zero_deg?",
    );
    refused(
        "[palm1]\nscale_m = 2\n",
        "rig.toml, line 2, key palm1.scale_m: a rig file has no such key; did you mean palm1.scale?",
    );
}

#[test]
fn control_characters_are_escaped_and_long_names_cut() {
    let text = format!("\"{}\\u001b\" = 1\n", "x".repeat(1 << 16));
    let message = parse_rig("r\u{1b}.toml", &text).map_or_else(|error| error.to_string(), |_| String::new());
    assert!(message.starts_with("r\\u{1b}.toml, line 1, key xxx") && message.contains('…'), "{message}");
    assert!(message.len() < 200 && !message.contains('\u{1b}'));
}

#[test]
fn units() {
    refused(
        "[palm1]\nzero = 0.3\n",
        "rig.toml, line 2, key palm1.zero: the key has no unit; name it zero_m, zero_cm, zero_mm or zero_um",
    );
    refused(
        "[palm1]\nzero_inch = 0.3\n",
        "rig.toml, line 2, key palm1.zero_inch: the unit \"inch\" is unknown; convert the value and name the key zero_m, zero_cm, zero_mm or zero_um",
    );
    refused(
        "[clock]\noffset_sd_min = 3\n",
        "rig.toml, line 2, key clock.offset_sd_min: the unit \"min\" is unknown; convert the value and name the key offset_sd_s, offset_sd_ms, offset_sd_us or offset_sd_ns",
    );
    refused(
        "[palm1]\nzero_mm = 0.3\nscale = 1\nzero_m = 3e-4\n",
        "rig.toml, line 4, key palm1.zero_m: line 2 gives the same as palm1.zero_mm; remove one of the two",
    );
}

#[test]
fn no_numbers() {
    let remedy = "is not a number; write one such as 0.5, without quotes and without a unit";
    refused("[palm1]\nzero_m = \"0.3 mm\"\n", &format!("rig.toml, line 2, key palm1.zero_m: \"0.3 mm\" {remedy}"));
    refused("[clock]\noffset_s = true\n", &format!("rig.toml, line 2, key clock.offset_s: true {remedy}"));
    refused("[palm1]\nscale = [1, 2]\n", &format!("rig.toml, line 2, key palm1.scale: [1, 2] {remedy}"));
    let remedy = "is not finite; write a number, or leave the key out if it is not known";
    refused("[palm1]\nzero_sd_mm = inf\n", &format!("rig.toml, line 2, key palm1.zero_sd_mm: inf mm {remedy}"));
    refused("[palm1]\nscale = nan\n", &format!("rig.toml, line 2, key palm1.scale: nan {remedy}"));
    refused("[palm1]\nscale = 1e999\n", &format!("rig.toml, line 2, key palm1.scale: 1e999 {remedy}"));
}

#[test]
fn constants_beyond_any_rig() {
    let beyond = |text: &str, key: &str, what: &str| refused(text, &format!("rig.toml, line 2, key {key}: {what}"));
    beyond("[palm1]\nzero_m = 0.3\n", "palm1.zero_m", "0.3 m is beyond 0.1 m; did you mean zero_mm?");
    beyond("[palm2]\nzero_mm = -300\n", "palm2.zero_mm", "-300 mm is beyond 0.1 m; correct it");
    beyond(
        "[palm1]\nsurface_offset_m = 2\n",
        "palm1.surface_offset_m",
        "2 m is beyond 0.1 m; did you mean surface_offset_mm?",
    );
    beyond("[palm1]\nlength_m = 55.5\n", "palm1.length_m", "55.5 m is beyond 10 m; did you mean length_mm?");
    beyond("[palm1]\nbase_x_m = -155.5\n", "palm1.base_x_m", "-155.5 m is beyond 100 m; did you mean base_x_mm?");
    beyond(
        "[angles]\nphi1_zero_rad = 2.5\n",
        "angles.phi1_zero_rad",
        "2.5 rad is beyond 0.5 rad (28.6 deg); did you mean phi1_zero_deg?",
    );
    beyond("[angles]\nphi2_zero_deg = 90\n", "angles.phi2_zero_deg", "90 deg is beyond 0.5 rad (28.6 deg); correct it");
    beyond("[clock]\noffset_s = 5\n", "clock.offset_s", "5 s is beyond 1 s; did you mean offset_ms?");
    let scale =
        "is not within 0.5 to 2; the scale is the reading over the position, 1 for a pad without error: correct it";
    beyond("[palm1]\nscale = 0.01\n", "palm1.scale", &format!("0.01 {scale}"));
}

#[test]
fn signs_of_numbers() {
    let wrong = |text: &str, key: &str, what: &str| refused(text, &format!("rig.toml, line 2, key {key}: {what}"));
    let sd =
        "is negative; a standard deviation is 0 (exact) or more: correct it, or leave the key out if it is not known";
    for (table, key, unit) in [
        ("palm1", "zero_sd_mm", " mm"),
        ("palm1", "scale_sd", ""),
        ("palm2", "surface_offset_sd_m", " m"),
        ("palm2", "reading_sd_um", " um"),
        ("angles", "phi1_zero_sd_deg", " deg"),
        ("angles", "phi2_zero_sd_rad", " rad"),
        ("angles", "reading_sd_rad", " rad"),
        ("clock", "offset_sd_ms", " ms"),
    ] {
        wrong(&format!("[{table}]\n{key} = -0.1\n"), &format!("{table}.{key}"), &format!("-0.1{unit} {sd}"));
    }
    let positive = "is not above 0; correct it, or leave the key out if it is not known";
    wrong("[palm1]\nlength_mm = 0\n", "palm1.length_mm", &format!("0 mm {positive}"));
    wrong("[palm1]\ncounts_per_inch = -200\n", "palm1.counts_per_inch", &format!("-200 {positive}"));
    let levels =
        "is no number of pressure levels; write a whole number from 2 on, or leave the key out if it is not known";
    wrong("[palm1]\nlevels = 1\n", "palm1.levels", &format!("1 {levels}"));
    wrong("[palm1]\nlevels = 12.5\n", "palm1.levels", &format!("12.5 {levels}"));
    let friction =
        "is negative; a coefficient of friction is 0 or more: correct it, or leave the key out to have it estimated";
    wrong("[palm1]\nfriction = -0.3\n", "palm1.friction", &format!("-0.3 {friction}"));
    let sign = "is no sign; write 1, or -1 if the encoder counts clockwise";
    wrong("[angles]\nsign1 = 0\n", "angles.sign1", &format!("0 {sign}"));
    wrong("[angles]\nsign2 = 1.5\n", "angles.sign2", &format!("1.5 {sign}"));
}

#[test]
fn what_belongs_together() {
    let length = "a pad that counts from the tip can only be turned round if its length is known; add palm2.length_m, or write \"from_base\"";
    refused("[palm2]\ndirection = \"to_base\"\n", &format!("rig.toml, line 2, key palm2.direction: {length}"));
    let direction = "is no direction; write \"from_base\" or \"to_base\", with the quotes";
    let key = "rig.toml, line 2, key palm1.direction";
    refused("[palm1]\ndirection = \"tip\"\n", &format!("{key}: \"tip\" {direction}"));
    refused("[palm1]\ndirection = -1\nlength_mm = 50\n", &format!("{key}: -1 {direction}"));
    refused(
        "[palm1]\nfriction_sd = 0.1\n",
        "rig.toml, line 2, key palm1.friction_sd: there is no coefficient of friction that this could belong to; \
        add palm1.friction, or remove this line",
    );
}

#[test]
fn files() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("rig.toml");
    let refused = |path: &Path, expected: &str| {
        let message = read_rig(path).map_or_else(|error| error.to_string(), |_| "accepted".to_string());
        assert_eq!(message, format!("{}: {expected}", path.display()));
    };
    refused(&path, "no such file; check the path");
    refused(dir.path(), "this is a folder; give the rig file in it");
    std::fs::write(&path, [0xff, 0xfe, 0x5b]).expect("room for a file");
    refused(&path, "the file is not text in UTF-8; save it as TOML in UTF-8");
    std::fs::write(&path, " ".repeat(1024 * 1024 + 1)).expect("room for a file");
    refused(&path, "the file is larger than 1024 KiB, that is no rig file; check the path");
    std::fs::write(&path, rig_template()).expect("room for a file");
    assert_eq!(read_rig(&path), Ok(RigFile::default()));
}

#[test]
fn what_the_system_says_comes_with_what_to_do() {
    let message = RigError::io("rig.toml", &io::ErrorKind::PermissionDenied.into()).to_string();
    assert_eq!(message, "rig.toml: cannot be read: permission denied; change the permissions, or choose another place");
}

#[test]
fn the_template_says_what_an_empty_file_says() {
    assert_eq!(parse_rig("template", rig_template()), Ok(RigFile::default()));
    assert_eq!(parse_rig("empty", ""), Ok(RigFile::default()));
}

/// The template with the keys that it only shows, `#key = value`.
fn shown() -> String {
    let line = |line: &str| match line.strip_prefix('#') {
        Some(rest) if rest.starts_with(|first: char| first.is_ascii_lowercase()) => format!("{rest}\n"),
        _ => format!("{line}\n"),
    };
    rig_template().lines().map(line).collect()
}

#[test]
fn the_template_shows_every_key_and_explains_it() {
    let text = shown();
    read(&text);
    for (table, keys) in TABLES {
        let section = text.split(&format!("[{table}]\n")).nth(1).unwrap_or_default();
        let section = section.split("\n[").next().unwrap_or_default();
        for key in keys {
            let line =
                section.lines().find(|line| key.names().iter().any(|name| line.starts_with(&format!("{name} ="))));
            let line = line.unwrap_or_else(|| panic!("{table} lacks {key:?}"));
            assert!(table == "palm2" || line.contains(" # "), "{line}");
        }
    }
    assert!(rig_template().lines().all(|line| line.chars().count() <= 150));
}
