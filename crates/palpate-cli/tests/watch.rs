//! `palpate watch` as a user runs it.
#![cfg(unix)]

mod common;

use std::fs;
use std::io::Write;
use std::process::Stdio;

use common::{Ran, command, folder, palpate};
use serde_json::Value;

/// A plan of a log that `reconstruct` certifies, as fast as possible.
const PLAN: &str = "shape = 'egg'\nduration_s = 40\nrate_hz = 10\nspeed = 0\n";

fn with_input(dir: &std::path::Path, arguments: &[&str], input: &[u8]) -> Ran {
    let mut command = command(dir, arguments);
    let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child.expect("the program starts");
    // A program that has seen enough closes the pipe.
    let _ = child.stdin.take().expect("a pipe").write_all(input);
    child.wait_with_output().expect("the program ends").into()
}

fn lines(ran: &Ran) -> Vec<Value> {
    ran.stdout
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{line}: {error}")))
        .collect()
}

#[test]
fn what_is_watched_is_recorded_and_ends_as_the_log_does() {
    let dir = folder();
    fs::write(dir.path().join("plan.toml"), PLAN).expect("a plan");
    let arguments = ["watch", "sim:plan.toml", "--json", "--log", "log.csv", "--scene", "scene.mcap", "-o", "live"];
    let ran = palpate(dir.path(), &arguments);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let all = lines(&ran);
    let (last, estimates) = all.split_last().expect("lines");
    assert_eq!(estimates.len(), 401);
    for key in ["time_s", "samples", "psi_rad", "com_x_m", "com_y_m", "coverage", "certified", "r_sd_m"] {
        assert!(estimates.iter().all(|estimate| estimate.get(key).is_some()), "{key}");
    }
    assert!(estimates[0]["psi_rad"].is_null() && estimates[0]["certified"] == false);
    assert_eq!(estimates[0]["reason"], "too few samples for a first search");
    assert!(estimates[400]["psi_rad"].is_number() && estimates[400]["certified"] == true);
    assert!(last["final"] == true && last["certified"] == true && last["samples"] == 401);

    // What the recording gives is the same to the byte, and so is a replay of it.
    let ran = palpate(dir.path(), &["reconstruct", "log.csv", "-o", "after"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert_eq!(palpate(dir.path(), &["reconstruct", "scene.mcap", "-o", "scene"]).code, Some(0), "it is a log as well");
    for name in ["shape.csv", "motion.csv"] {
        let read = |folder: &str| fs::read(dir.path().join(folder).join(name)).expect("a file of the result");
        assert!(read("live") == read("after") && read("live") == read("scene"), "{name}");
    }
    let log = fs::read(dir.path().join("log.csv")).expect("the recording");
    let again = with_input(dir.path(), &["watch", "-", "--json"], &log);
    assert!(lines(&again)[..401] == *estimates, "the recording states its rig, and is replayed as it was");
}

#[test]
fn the_rig_of_a_stream_is_what_it_says_unless_another_is_stated() {
    let dir = folder();
    fs::write(dir.path().join("plan.toml"), PLAN).expect("a plan");
    assert_eq!(palpate(dir.path(), &["record", "sim:plan.toml", "-o", "log.csv"]).code, Some(0));
    let log = fs::read_to_string(dir.path().join("log.csv")).expect("the recording");
    assert!(log.contains("\n# rig: exact\n"), "{log:.200}");
    // All around, but seldom: that takes least to reconstruct.
    let is_row = |line: &&str| line.starts_with(|first: char| first.is_ascii_digit());
    let (head, rows) = (log.lines().filter(|line| !is_row(line)), log.lines().filter(is_row).step_by(4));
    let few: String = head.chain(rows).flat_map(|line| [line, "\n"]).collect();
    let unsaid = few.replace("# rig: exact\n", "");
    let wrong = few.replace("# rig: exact\n", "# rig: left hand\n");
    let has_constants = |text: &str, more: &[&str]| {
        let arguments: Vec<&str> = ["watch", "-", "--json"].iter().chain(more).copied().collect();
        let ran = with_input(dir.path(), &arguments, text.as_bytes());
        let last = lines(&ran).pop().unwrap_or_else(|| panic!("{}", ran.stderr));
        last["calibration"].as_object().is_some_and(|constants| !constants.is_empty())
    };
    assert!(!has_constants(&few, &[]));
    assert!(has_constants(&unsaid, &[]));
    assert!(!has_constants(&unsaid, &["--calibrated"]));
    let ran = with_input(dir.path(), &["watch", "-"], wrong.as_bytes());
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
}

#[test]
fn strokes_are_watched_and_end_as_their_log_does() {
    let dir = folder();
    let made = palpate(dir.path(), &["simulate", "--rig", "pivot", "--shape", "egg", "-o", "strokes.csv"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let log = fs::read(dir.path().join("strokes.csv")).expect("a log");
    let ran = with_input(dir.path(), &["watch", "-", "--json", "-o", "live"], &log);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let all = lines(&ran);
    let (last, estimates) = all.split_last().expect("lines");
    for key in ["time_s", "samples", "psi_rad", "psi_sd_rad", "coverage", "certified", "r_sd_m"] {
        assert!(estimates.iter().all(|estimate| estimate.get(key).is_some()), "{key}");
    }
    assert!(estimates[0]["psi_rad"].is_null() && estimates[0]["certified"] == false);
    assert_eq!(estimates[0]["reason"], "too few samples for a first search");
    let certified = estimates.iter().filter(|estimate| estimate["certified"] == true).count();
    assert!(certified > estimates.len() / 4, "{certified} of {}", estimates.len());
    assert!(estimates.iter().any(|estimate| estimate["certified"] == true && estimate["psi_rad"].is_number()));
    assert!(last["final"] == true && last["certified"] == true && last["rig"] == "pivot");
    assert_eq!(last["samples"], estimates.len());
    let after = palpate(dir.path(), &["reconstruct", "strokes.csv", "-o", "after"]);
    assert_eq!(after.code, Some(0), "{}", after.stderr);
    for name in ["shape.csv", "motion.csv", "summary.json"] {
        let read = |folder: &str| fs::read(dir.path().join(folder).join(name)).expect("a file of the result");
        assert!(read("live") == read("after"), "{name}");
    }
    let ran = with_input(dir.path(), &["watch", "-"], &log);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stdout.contains("% felt") && ran.stdout.contains("\ncertified: shape about the pivot"),
        "{}",
        ran.stdout
    );
    let few: Vec<u8> = log.split_inclusive(|byte| *byte == b'\n').take(20).flatten().copied().collect();
    let ran = with_input(dir.path(), &["watch", "-"], &few);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(ran.stderr.contains("at least 30 are needed"), "{}", ran.stderr);
}

#[test]
fn strokes_of_a_plan_are_recorded_and_drawn_and_both_are_logs_of_their_rig() {
    let dir = folder();
    let plan = "motion = 'strokes'\nshape = 'egg'\nspeed = 0\nrig = 'rig.toml'\n";
    fs::write(dir.path().join("plan.toml"), plan).expect("a plan");
    fs::write(dir.path().join("rig.toml"), "[pad]\ntilt_rad = 0.1\n").expect("a rig");
    let arguments = ["watch", "sim:plan.toml", "--json", "--log", "log.csv", "--scene", "scene.mcap", "-o", "live"];
    let ran = palpate(dir.path(), &arguments);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let all = lines(&ran);
    assert!(all.last().is_some_and(|last| last["final"] == true && last["rig"] == "pivot"));
    // The tilt of the pad is in both.
    for (log, out) in [("log.csv", "after"), ("scene.mcap", "scene")] {
        let ran = palpate(dir.path(), &["reconstruct", log, "-o", out]);
        assert_eq!(ran.code, Some(0), "{log}: {}", ran.stderr);
        for name in ["shape.csv", "motion.csv"] {
            let read = |folder: &str| fs::read(dir.path().join(folder).join(name)).expect("a file of the result");
            assert!(read("live") == read(out), "{log}: {name}");
        }
    }
    let log = fs::read(dir.path().join("log.csv")).expect("the recording");
    let again = lines(&with_input(dir.path(), &["watch", "-", "--json"], &log));
    assert!(again[..again.len() - 1] == all[..all.len() - 1], "a replay is the same");
    let ran = palpate(dir.path(), &["record", "mcap:scene.mcap", "-o", "copy.csv"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let read = |name: &str| palpate_io::read_strokes(&dir.path().join(name)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(read("copy.csv").log, read("log.csv").log);
}

#[test]
fn without_a_terminal_there_are_plain_lines_and_the_result() {
    let dir = folder();
    fs::write(dir.path().join("plan.toml"), PLAN).expect("a plan");
    let ran = palpate(dir.path(), &["watch", "sim:plan.toml"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(!ran.stdout.contains('\x1b'));
    assert!(ran.stdout.contains("40.0 s, 401 samples, psi ") && ran.stdout.contains("\ncertified: "), "{}", ran.stdout);
    assert!(!ran.stdout.contains("report"), "there is none: {}", ran.stdout);
    let ran = palpate(dir.path(), &["watch", "sim:plan.toml", "-q"]);
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(0), ""));
}

#[test]
fn what_cannot_be_watched_ends_in_one_message() {
    let dir = folder();
    for (arguments, code, expected) in [
        (vec!["watch", "missing.csv"], 1, "missing.csv: it cannot be opened"),
        (vec!["watch", "-"], 2, "samples with both contacts seen"),
        (vec!["watch", "-", "--rig", "missing.toml"], 2, "missing.toml"),
        (vec!["watch", "-", "--log", "log.txt"], 2, "log.txt"),
    ] {
        let ran = with_input(dir.path(), &arguments, b"time_s,phi1_deg,phi2_deg,s1_mm,s2_mm\n1,60,74,29,31\n");
        assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
    let ran = with_input(dir.path(), &["watch", "-"], b"time_s,phi1_deg,phi2_deg,s1_mm,s2_mm\n");
    assert_eq!((ran.code, ran.stderr.contains("no sample came")), (Some(2), true), "{}", ran.stderr);
}
