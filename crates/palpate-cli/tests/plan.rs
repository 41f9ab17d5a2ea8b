//! `palpate plan`: what is planned is felt when it is run through, for either rig, from a shape and from a log.

mod common;

use std::fs;
use std::path::Path;

use common::{folder, palpate};
use serde_json::Value;

/// A run that must end so.
fn ran(dir: &Path, arguments: &[&str], code: i32) -> common::Ran {
    let ran = palpate(dir, arguments);
    assert_eq!(ran.code, Some(code), "{arguments:?}: {}{}", ran.stdout, ran.stderr);
    ran
}

/// The coverage that a plan of strokes promises.
fn promised(file: &Path) -> f64 {
    let text = fs::read_to_string(file).expect("a plan");
    let last = text.lines().last().and_then(|line| line.split(',').next_back()).expect("a row");
    last.parse().expect("a number")
}

/// The summary of a log that must be certified.
fn certified(dir: &Path, log: &str) -> Value {
    let found = ran(dir, &["reconstruct", log, "--json", "-o", &format!("{log}.found")], 0);
    let summary: Value = serde_json::from_str(&found.stdout).expect("JSON");
    assert_eq!(summary["certified"], true, "{summary}");
    summary
}

#[test]
fn planned_strokes_feel_what_was_promised_and_certify_it() {
    let dir = folder();
    let planned = ran(dir.path(), &["plan", "pebble", "--rig", "pivot", "-o", "plan.csv"], 0);
    assert!(planned.stdout.contains("of the boundary\n  1   "), "{}", planned.stdout);
    let text = fs::read_to_string(dir.path().join("plan.csv")).expect("a plan");
    assert!(text.contains("# planned for: pebble\nstroke,along_m,press,coverage\n1,0."), "{text}");
    ran(dir.path(), &["simulate", "--rig", "pivot", "--motion", "plan.csv", "-o", "felt.csv"], 0);
    let felt = certified(dir.path(), "felt.csv")["coverage"].as_f64().expect("a number");
    let promised = promised(&dir.path().join("plan.csv"));
    assert!(promised > 0.8 && felt > promised - 0.03, "promised {promised}, felt {felt}");
}

#[test]
fn the_next_strokes_are_planned_by_a_log_of_the_first() {
    let dir = folder();
    let limits = ["--along-mm", "260,340", "--most-strokes", "1"];
    ran(dir.path(), &[&["plan", "egg", "--rig", "pivot", "-o", "first.csv"][..], &limits].concat(), 0);
    // Twice, so that the log tells at which angle the object hangs.
    let text = fs::read_to_string(dir.path().join("first.csv")).expect("a plan");
    let again = text.lines().filter(|line| line.starts_with("1,")).map(|line| format!("2{}\n", &line[1..]));
    fs::write(dir.path().join("first.csv"), format!("{text}{}", again.collect::<String>())).expect("a file");
    ran(
        dir.path(),
        &["simulate", "--shape", "egg", "--rig", "pivot", "--motion", "first.csv", "-o", "first-felt.csv"],
        0,
    );
    let planned = palpate(dir.path(), &["plan", "first-felt.csv", "--along-mm", "150,450", "-o", "next.csv"]);
    assert!(matches!(planned.code, Some(0 | 3)), "{}{}", planned.stdout, planned.stderr);
    assert!(planned.stderr.contains("swing_period_s"), "{}", planned.stderr);
    ran(dir.path(), &["simulate", "--shape", "egg", "--rig", "pivot", "--motion", "next.csv", "-o", "felt.csv"], 0);
    let felt = certified(dir.path(), "felt.csv")["coverage"].as_f64().expect("a number");
    let promised = promised(&dir.path().join("next.csv"));
    // What was never felt is only guessed.
    assert!(promised > 0.5 && felt > promised - 0.1, "promised {promised}, felt {felt}");
}

#[test]
fn planned_palms_carry_the_object_round_and_a_log_of_it_plans_the_same() {
    let dir = folder();
    let planned = ran(dir.path(), &["plan", "egg", "--duration-s", "40", "-o", "motion.csv"], 0);
    assert!(planned.stdout.contains("all the way around") && planned.stdout.contains("100 %"), "{}", planned.stdout);
    let arguments = ["simulate", "--shape", "egg", "--motion", "motion.csv", "-o", "egg.csv"];
    let made = ran(dir.path(), &arguments, 0);
    assert!(made.stdout.contains("no jump"), "{}", made.stdout);
    assert!(certified(dir.path(), "egg.csv")["coverage"].as_f64() > Some(0.99));
    let again = ran(dir.path(), &["plan", "egg.csv", "--duration-s", "40", "-o", "again.csv"], 0);
    assert!(again.stdout.contains("all the way around"), "{}", again.stdout);
}

#[test]
fn sticky_palms_carry_it_too() {
    let dir = folder();
    let planned =
        ran(dir.path(), &["plan", "egg", "--friction", "0.2,0.3", "--duration-s", "40", "-o", "motion.csv"], 0);
    let slick = ran(dir.path(), &["plan", "egg", "--duration-s", "40", "-o", "slick.csv"], 0);
    assert_ne!(planned.stdout.replace("motion", ""), slick.stdout.replace("slick", ""));
    let arguments = ["simulate", "--shape", "egg", "--motion", "motion.csv", "--friction", "0.2,0.3", "-o", "egg.csv"];
    assert!(ran(dir.path(), &arguments, 0).stdout.contains("no jump"));
}

#[test]
fn what_cannot_be_planned_is_refused_by_name() {
    let dir = folder();
    let refused = |arguments: &[&str], what: &str| {
        let ran = ran(dir.path(), &[arguments, &["-o", "plan.csv"]].concat(), 2);
        assert!(ran.stderr.contains(what), "{}", ran.stderr);
        assert!(!dir.path().join("plan.csv").exists());
    };
    refused(&["plan", "eggg"], "or a log");
    refused(&["plan", "missing.csv"], "no such file");
    refused(&["plan", "egg", "--press", "2"], "--press");
    refused(&["plan", "egg", "--rig", "pivot", "--duration-s", "2"], "--duration-s");
    refused(&["plan", "egg", "--rig", "pivot", "--along-mm", "300,200"], "in order");
    let off_the_pad = ["plan", "egg", "--rig", "pivot", "--palm-length-mm", "100", "--along-mm", "900,950"];
    refused(&off_the_pad, "no stroke within these limits");
    refused(&["plan", "egg", "--calibrated"], "--calibrated");
    ran(dir.path(), &["simulate", "--rig", "pivot", "--motion", "zigzag", "-o", "s.csv"], 2);
    ran(dir.path(), &["simulate", "--pivot-mm", "0,1", "-o", "s.csv"], 2);
    ran(dir.path(), &["simulate", "--rig", "pivot", "-o", "s.csv"], 0);
    refused(&["plan", "s.csv", "--com-mm", "0,1"], "--com-mm");
    fs::write(dir.path().join("bad.csv"), "stroke,along_m,press\n1,0.3,3\n3,0.2,3\n").expect("a file");
    let ran = ran(dir.path(), &["simulate", "--rig", "pivot", "--motion", "bad.csv", "-o", "t.csv"], 2);
    assert!(ran.stderr.contains("line 3, column stroke"), "{}", ran.stderr);
}
