//! The other rig of the paper by the program: strokes are simulated, reconstructed, and refused where palms are meant.

mod common;

use std::fs;

use common::{folder, names, palpate};
use serde_json::Value;

#[test]
fn strokes_are_simulated_and_certified() {
    let dir = folder();
    let made = palpate(dir.path(), &["simulate", "--rig", "pivot", "--shape", "egg", "-o", "strokes.csv"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    assert!(made.stdout.contains("6 strokes"), "{}", made.stdout);
    let arguments = ["reconstruct", "strokes.csv", "--truth", "strokes.truth", "-o", "found"];
    let ran = palpate(dir.path(), &arguments);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.starts_with("certified"), "{}", ran.stdout);
    let found = dir.path().join("found");
    assert_eq!(names(&found), ["motion.csv", "report.html", "shape.csv", "summary.json"]);
    let summary: Value =
        serde_json::from_slice(&fs::read(found.join("summary.json")).expect("a summary")).expect("JSON");
    assert_eq!((&summary["rig"], &summary["certified"]), (&"pivot".into(), &true.into()));
    assert!(summary["truth"]["rms_r_m"].as_f64() < Some(5e-5), "{summary}");
    assert!(summary["truth"]["rms_psi_rad"].as_f64() < Some(0.01), "{summary}");
    // The same again in its place, on standard output.
    let again = palpate(dir.path(), &[&arguments[..], &["--json"]].concat());
    assert_eq!(serde_json::from_str::<Value>(&again.stdout).expect("JSON"), summary);
    let motion = fs::read_to_string(found.join("motion.csv")).expect("a motion");
    assert_eq!(motion.lines().count() as u64, 1 + summary["samples"].as_u64().expect("a count"));
}

#[test]
fn what_belongs_to_palms_is_refused_by_name() {
    let dir = folder();
    let refused = |arguments: &[&str], what: &str| {
        let ran = palpate(dir.path(), arguments);
        assert_eq!(ran.code, Some(2), "{}", ran.stderr);
        assert!(ran.stderr.contains(what), "{}", ran.stderr);
    };
    refused(&["simulate", "--rig", "pivot", "--speed", "2", "-o", "s.csv"], "--speed");
    let made = palpate(dir.path(), &["simulate", "--rig", "pivot", "-o", "s.csv", "-q"]);
    assert_eq!((made.code, made.stdout.as_str()), (Some(0), ""));
    refused(&["reconstruct", "s.csv", "--method", "ode"], "--method");
    fs::write(dir.path().join("rig.toml"), "[pad]\ntilt_deg = 3\n").expect("a file");
    refused(&["reconstruct", "s.csv", "--rig", "rig.toml"], "tilt_deg");
    fs::write(dir.path().join("bad.csv"), "time_s,pivot_x_m,pivot_y_m,s_m\n0,0.1,0.03,0.1\n1,x,0.03,0.1\n")
        .expect("a file");
    refused(&["reconstruct", "bad.csv"], "line 3, column pivot_x_m");
}
