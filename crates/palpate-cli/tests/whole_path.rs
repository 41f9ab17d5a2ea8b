//! The way of a user from nothing to a result, on logs of our own and of other people's simulators.

mod common;

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::Stdio;

use common::{Ran, command, example, folder, names, palpate};
use serde_json::Value;

const RESULT_FILES: [&str; 4] = ["motion.csv", "report.html", "shape.csv", "summary.json"];

fn summary(dir: &Path) -> Value {
    let text = fs::read_to_string(dir.join("summary.json")).expect("there is a summary");
    serde_json::from_str(&text).expect("the summary is JSON")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// Reconstructs a log of the examples, compares it with its truth, and gives the error of r in millimetres.
fn reconstruct_example(name: &str) -> (Ran, Value) {
    reconstruct_with(name, &[])
}

fn reconstruct_with(name: &str, options: &[&str]) -> (Ran, Value) {
    let dir = folder();
    let (log, truth) = (example(&format!("{name}.csv")), example(&format!("{name}.truth")));
    let arguments = ["reconstruct", text(&log), "-o", "out", "--truth", text(&truth)];
    let ran = palpate(dir.path(), &[&arguments, options].concat());
    (ran, summary(&dir.path().join("out")))
}

fn error_mm(summary: &Value) -> f64 {
    1e3 * summary["truth"]["rms_r_m"].as_f64().expect("an error")
}

#[test]
fn the_demo_needs_nothing_and_is_certified_and_right() {
    let dir = folder();
    let ran = palpate(dir.path(), &["demo"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert_eq!(ran.stderr, "");
    assert!(ran.stdout.contains("certified: shape, motion and centre of mass\n"), "{}", ran.stdout);
    assert!(ran.stdout.contains("palpate-demo/report.html"), "{}", ran.stdout);
    assert_eq!(names(dir.path()), ["palpate-demo"]);
    let result = dir.path().join("palpate-demo");
    assert_eq!(names(&result), RESULT_FILES);
    let summary = summary(&result);
    assert_eq!(summary["certified"], true);
    assert!(summary["coverage"].as_f64() > Some(0.95), "{summary}");
    assert!(error_mm(&summary) < 0.03, "{summary}");
    let report = fs::read_to_string(result.join("report.html")).expect("there is a report");
    assert!(report.starts_with("<!doctype html>"));
}

#[test]
fn the_demo_finds_the_errors_of_a_rig_that_nobody_calibrated() {
    let dir = folder();
    fs::write(dir.path().join("rig.toml"), "").expect("a rig of default tolerances");
    let ran = palpate(dir.path(), &["demo", "--rig", "rig.toml"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.contains("zero of pad 1"), "{}", ran.stdout);
    let summary = summary(&dir.path().join("palpate-demo"));
    assert!(error_mm(&summary) < 0.03, "{summary}");
    let zero = &summary["calibration"]["s1_zero_m"];
    // It was drawn, and found.
    assert!(zero["sd"].as_f64() < Some(1e-4) && zero["value"].as_f64().expect("a zero").abs() > 1e-5, "{zero}");
    let unread = palpate(dir.path(), &["demo", "--rig", "none.toml"]);
    assert_eq!(unread.code, Some(2), "{}", unread.stderr);
}

#[test]
fn a_simulated_log_comes_back() {
    let dir = folder();
    let made = palpate(dir.path(), &["simulate", "--shape", "egg", "--noise-mm", "0.2", "-o", "egg.csv"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    assert_eq!(names(dir.path()), ["egg.csv", "egg.truth"]);
    let ran = palpate(dir.path(), &["reconstruct", "egg.csv", "--truth", "egg.truth"]);
    assert_eq!(ran.code, Some(0), "{}\n{}", ran.stdout, ran.stderr);
    assert_eq!(names(dir.path()), ["egg.csv", "egg.palpate", "egg.truth"]);
    let summary = summary(&dir.path().join("egg.palpate"));
    assert!(error_mm(&summary) < 0.06, "{summary}");
}

#[test]
fn several_logs_go_into_one_folder_and_the_worst_counts() {
    let dir = folder();
    let simulate = |name: &str| palpate(dir.path(), &["simulate", "--shape", "egg", "--duration-s", "40", "-o", name]);
    assert_eq!(simulate("a.csv").code, Some(0));
    let log = fs::read(dir.path().join("a.csv")).expect("a log");
    let compressed = fs::File::create(dir.path().join("b.csv.gz")).expect("a file");
    let mut encoder = flate2::write::GzEncoder::new(compressed, flate2::Compression::fast());
    encoder.write_all(&log).and_then(|()| encoder.finish().map(drop)).expect("the log is compressed");
    fs::write(dir.path().join("bad.csv"), "time_s\n1\n").expect("a file");

    let ran = palpate(dir.path(), &["reconstruct", "bad.csv", "a.csv", "b.csv.gz", "-o", "out"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert!(
        ran.stderr.starts_with("error: bad.csv, line 1: there are no columns for phi1, phi2, s1 and s2"),
        "{}",
        ran.stderr
    );
    assert!(ran.stdout.starts_with("bad.csv:\na.csv:\ncertified: "), "{}", ran.stdout);
    assert_eq!(names(&dir.path().join("out")), ["a", "b"]);
    for name in ["a", "b"] {
        assert_eq!(names(&dir.path().join("out").join(name)), RESULT_FILES);
    }
    let of = |name: &str| fs::read_to_string(dir.path().join("out").join(name).join("shape.csv")).expect("a shape");
    assert_eq!(of("a"), of("b"));

    let ran = palpate(dir.path(), &["reconstruct", "a.csv", "b.csv.gz", "--json"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let logs: Vec<Value> =
        serde_json::Deserializer::from_str(&ran.stdout).into_iter().map(|json| json.expect("JSON")).collect();
    assert_eq!([&logs[0]["log"], &logs[1]["log"]], ["a.csv", "b.csv.gz"]);
    assert_eq!(names(dir.path()), ["a.csv", "a.palpate", "a.truth", "b.csv.gz", "b.palpate", "bad.csv", "out"]);
}

#[test]
fn logs_of_independent_simulators_are_certified_and_right() {
    for (name, limit_mm) in [("egg_full_turn_oracle_n0.1mm", 0.03), ("pebble_full_turn_mujoco_sensor", 0.03)] {
        let (ran, summary) = reconstruct_example(name);
        assert_eq!(ran.code, Some(0), "{name}: {}", ran.stdout);
        assert_eq!(summary["certified"], true, "{name}");
        assert!(error_mm(&summary) < limit_mm, "{name}: {summary}");
    }
}

#[test]
fn a_log_with_jumps_is_certified_and_right() {
    let dir = folder();
    let gif = dir.path().join("film/stone.gif");
    let (ran, summary) = reconstruct_with("stone_zigzag_oracle", &["--animation", text(&gif)]);
    // Its motion is a film too.
    let film = fs::read(&gif).expect("there is an animation");
    assert!(film.starts_with(b"GIF89a") && film.len() < 2_000_000, "{} bytes", film.len());
    assert_eq!(ran.code, Some(0), "{}", ran.stdout);
    assert!(ran.stdout.contains(" samples, 8 jumps; sensor noise "), "{}", ran.stdout);
    assert!(error_mm(&summary) < 0.01, "{summary}");
    let (jumps, details) = (&summary["jumps"], &summary["jump_details"]);
    assert_eq!(jumps.as_array().map(Vec::len), Some(8));
    for (index, jump) in details.as_array().into_iter().flatten().enumerate() {
        assert_eq!(jump["time_s"], jumps[index]);
        assert_eq!(jump["physical"], true, "{jump}");
        assert!(jump["height_drop_m"].as_f64() > Some(0.0), "{jump}");
    }
}

#[test]
fn a_log_of_fast_palms_is_certified_with_the_inertia_of_the_object() {
    let (ran, summary) = reconstruct_example("ellipse_fast_10x_mujoco");
    assert_eq!(ran.code, Some(0), "{}", ran.stdout);
    assert_eq!((&summary["com_certified"], &summary["forces"]), (&true.into(), &"inertial".into()), "{summary}");
    // A disc of that outline has 24.026 mm.
    let radius_m = summary["gyration_radius_m"]["value"].as_f64().expect("a number");
    assert!((radius_m - 0.024_026).abs() < 2e-5, "{summary}");
    assert!(ran.stdout.contains("  turns   with a radius of gyration of 24.0"), "{}", ran.stdout);
    assert!(error_mm(&summary) < 0.01 && summary["truth"]["rms_com_m"].as_f64() < Some(2e-5), "{summary}");
}

#[test]
fn fast_palms_are_simulated() {
    let dir = folder();
    let simulate =
        |more: &[&str]| palpate(dir.path(), &[&["simulate", "-o", "fast.csv", "--speed", "10"], more].concat());
    let ran = simulate(&["--rate-hz", "100", "--noise-mm", "0"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("1001 samples, on its way at all times"), "{}", ran.stdout);
    let refused = simulate(&["--friction", "0.1"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("--friction"), "{}", refused.stderr);
    let thrown = simulate(&["--motion", "random", "--duration-s", "5"]);
    assert!(thrown.stderr.contains("loses contact with palm"), "{}", thrown.stderr);
}

#[test]
fn a_log_with_friction_is_certified_and_the_summary_says_how_much() {
    let (ran, summary) = reconstruct_with("ellipse_friction_0.10_mujoco", &["--calibrated"]);
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{}", ran.stdout);
    assert!(ran.stdout.starts_with("certified"), "{}", ran.stdout);
    assert_eq!(summary["certified"], true);
    assert_eq!(summary["com_certified"], true);
    assert_eq!(summary["forces"], "coulomb");
    for palm in ["mu1", "mu2"] {
        let coefficient = summary["friction"][palm]["value"].as_f64().expect("a number");
        assert!((coefficient - 0.1).abs() < 0.001, "{summary}");
    }
    let truth = &summary["truth"];
    for (name, limit) in [("rms_form_m", 1e-4), ("rms_com_m", 1e-4), ("rms_psi_rad", 1e-3)] {
        assert!(truth[name].as_f64() < Some(limit) && truth[name].is_number(), "{name}: {summary}");
    }
    assert!(ran.stdout.contains("with friction 0.0996 ± 0.0011 on palm 1"), "{}", ran.stdout);
}

#[test]
fn a_killed_run_leaves_no_half_result() {
    let dir = folder();
    let log = example("egg_full_turn_oracle_n0.1mm.csv");
    let arguments = ["reconstruct", text(&log), "-o", "out", "-q"];
    let started = std::time::Instant::now();
    assert_eq!(palpate(dir.path(), &arguments).code, Some(0));
    let whole_run = started.elapsed();
    fs::remove_dir_all(dir.path().join("out")).expect("there is a result");
    for share in [0.2, 0.6, 0.9, 0.95, 1.0, 1.05] {
        let mut child = command(dir.path(), &arguments).spawn().expect("the program starts");
        std::thread::sleep(whole_run.mul_f64(share));
        // It may have ended by then; all the better.
        let _ = child.kill();
        child.wait().expect("the program ends");
        let out = dir.path().join("out");
        if out.exists() {
            assert_eq!(names(&out), RESULT_FILES, "killed after {share} of the time");
            assert_eq!(summary(&out)["certified"], true);
            let report = fs::read_to_string(out.join("report.html")).expect("there is a report");
            assert!(report.trim_end().ends_with("</html>"));
            fs::remove_dir_all(&out).expect("there is a result");
        }
    }
    // Temporary folders are hidden.
    assert!(names(dir.path()).iter().all(|name| name.starts_with(".palpate-partial-")), "{:?}", names(dir.path()));
    assert_eq!(palpate(dir.path(), &arguments).code, Some(0));
}

#[test]
fn the_summary_has_what_others_rely_on() {
    let dir = folder();
    let log = example("egg_full_turn_oracle_n0.1mm.csv");
    let ran = palpate(dir.path(), &["reconstruct", text(&log), "-o", "deep/er/out", "--json"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let result = dir.path().join("deep/er/out");
    assert_eq!(ran.stdout, fs::read_to_string(result.join("summary.json")).expect("there is a summary"));
    let summary = summary(&result);
    for (key, is_right) in [
        ("certified", Value::is_boolean as fn(&Value) -> bool),
        ("com_certified", Value::is_boolean),
        ("reason", Value::is_string),
        ("chi2_per_dof", Value::is_number),
        ("jumps", Value::is_array),
        ("coverage", Value::is_number),
        ("alternatives", Value::is_u64),
        ("sensor_sd_m", Value::is_number),
        ("samples", Value::is_u64),
        ("harmonics", Value::is_u64),
        ("seconds", Value::is_number),
        ("version", Value::is_string),
    ] {
        assert!(is_right(&summary[key]), "{key}: {summary}");
    }
    assert_eq!(summary["samples"], 2044);
    assert_eq!(summary["log"], "egg_full_turn_oracle_n0.1mm.csv");
    assert!(summary.get("truth").is_none(), "the truth beside the log was used without being asked for");

    let first_line = |name: &str| {
        let text = fs::read_to_string(result.join(name)).expect("the file is there");
        (text.lines().next().unwrap_or_default().to_string(), text.lines().count() - 1)
    };
    let (shape, points) = first_line("shape.csv");
    assert_eq!(shape, "theta_rad,r_m,r_sd_m,x_m,y_m,curvature_radius_m,touches");
    assert!(points >= 720);
    let (motion, poses) = first_line("motion.csv");
    assert_eq!(motion, "time_s,psi_rad,psi_sd_rad,com_x_m,com_y_m,com_sd_m,theta1_rad,theta2_rad,piece,mode1,mode2");
    assert_eq!(poses, 2044);
}

#[test]
fn the_number_of_threads_changes_nothing_and_an_earlier_result_is_replaced() {
    let dir = folder();
    let log = example("stone_zigzag_oracle.csv");
    let run = |threads: &str| {
        let ran = palpate(dir.path(), &["reconstruct", text(&log), "-o", "out", "--threads", threads]);
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert_eq!(names(dir.path()), ["out"]);
        assert_eq!(names(&dir.path().join("out")), RESULT_FILES);
        ["shape.csv", "motion.csv"].map(|name| fs::read(dir.path().join("out").join(name)).expect("the file is there"))
    };
    assert!(run("1") == run("3"), "results differ");
}

#[test]
fn quiet_means_quiet() {
    let dir = folder();
    let made = palpate(dir.path(), &["simulate", "-o", "trial.csv", "--quiet"]);
    let ran = palpate(dir.path(), &["reconstruct", "trial.csv", "-o", "out", "-q"]);
    for ran in [made, ran] {
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert_eq!((ran.stdout.as_str(), ran.stderr.as_str()), ("", ""));
    }
}

#[test]
fn notes_about_a_log_go_to_standard_error_and_into_the_summary() {
    let dir = folder();
    let log = fs::read_to_string(example("egg_full_turn_oracle_n0.1mm.csv")).expect("the log is there");
    let log: String = log
        .lines()
        .map(|line| line.to_string() + if line.starts_with("time") { ",humidity\n" } else { ",40\n" })
        .collect();
    fs::write(dir.path().join("egg.csv"), log).expect("the log is written");
    let ran = palpate(dir.path(), &["reconstruct", "egg.csv", "-o", "out"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stderr.starts_with("note: ") && ran.stderr.contains("humidity"), "{}", ran.stderr);
    assert!(!ran.stdout.contains("humidity"), "{}", ran.stdout);
    assert!(summary(&dir.path().join("out"))["notes"][0].as_str().is_some_and(|note| note.contains("humidity")));
}

#[test]
fn a_closed_pipe_is_not_an_error() {
    let dir = folder();
    for arguments in [&["demo"][..], &["--help"], &["reconstruct", "--help"]] {
        let mut child = command(dir.path(), arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        drop(child.stdout.take());
        let ran: Ran = child.wait_with_output().expect("the program ends").into();
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""), "{arguments:?}");
    }
    assert_eq!(names(&dir.path().join("palpate-demo")), RESULT_FILES);
}

#[test]
fn a_place_that_cannot_be_written_is_no_fault_of_the_input() {
    if !Path::new("/dev/full").exists() {
        return;
    }
    let dir = folder();
    let log = example("egg_full_turn_oracle_n0.1mm.csv");
    let full = fs::File::options().write(true).open("/dev/full").expect("/dev/full opens");
    let ran: Ran = command(dir.path(), &["reconstruct", text(&log), "-o", "out"])
        .stdout(full)
        .output()
        .expect("the program starts")
        .into();
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.starts_with("error: standard output cannot be written: "), "{}", ran.stderr);
}

#[test]
fn help_teaches_with_examples_and_names_every_option() {
    let dir = folder();
    let help = |arguments: &[&str]| {
        let ran = palpate(dir.path(), arguments);
        assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
        assert!(ran.stdout.contains("Example"), "{}", ran.stdout);
        ran.stdout
    };
    let all = help(&["--help"]);
    for name in ["demo", "simulate", "reconstruct", "Exit codes"] {
        assert!(all.contains(name), "{name}");
    }
    help(&["demo", "--help"]);
    let reconstruct = help(&["reconstruct", "--help"]);
    for name in ["--out", "--truth", "--harmonics", "--sensor-sd-mm", "--threads", "--json", "--quiet", "Exit codes"] {
        assert!(reconstruct.contains(name), "{name}");
    }
    let simulate = help(&["simulate", "--help"]);
    for name in [
        "--out",
        "--shape",
        "--radius-mm",
        "--com-offset-mm",
        "--com-mm",
        "--motion",
        "--duration-s",
        "--rate-hz",
        "--finger-gap-mm",
        "--pad",
        "--palm-length-mm",
        "--noise-mm",
        "--counts-per-inch",
        "--angle-noise-deg",
        "--dropout",
        "--seed",
    ] {
        assert!(simulate.contains(name), "{name}");
    }
    assert_eq!(palpate(dir.path(), &["--version"]).stdout, format!("palpate {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn the_methods_that_integrate_give_a_result_that_is_never_certified() {
    let dir = folder();
    let (log, truth) = (example("egg_full_turn_oracle_n0.1mm.csv"), example("egg_full_turn_oracle_n0.1mm.truth"));
    for method in ["ode", "quadrature"] {
        let arguments = ["reconstruct", text(&log), "-o", method, "--truth", text(&truth), "--method", method];
        let ran = palpate(dir.path(), &arguments);
        assert_eq!(ran.code, Some(3), "{method}: {}", ran.stderr);
        let summary = summary(&dir.path().join(method));
        assert_eq!(summary["certified"], false);
        assert!(summary["reason"].as_str().is_some_and(|reason| reason.contains(method)), "{summary}");
        assert!(summary["truth"]["rms_r_m"].as_f64().is_some(), "{summary}");
        assert_eq!(names(&dir.path().join(method)), RESULT_FILES);
    }
    let ran = palpate(dir.path(), &["reconstruct", text(&log), "--method", "guess"]);
    assert_eq!(ran.code, Some(2));
}

#[test]
fn boundary_felt_too_few_times_is_left_out_and_diagnostics_are_written() {
    let dir = folder();
    let log = example("egg_full_turn_oracle_n0.1mm.csv");
    let whole = palpate(dir.path(), &["reconstruct", text(&log), "-o", "whole"]);
    let (whole_dir, out) = (dir.path().join("whole"), dir.path().join("out"));
    let touches = |dir: &Path| -> Vec<u32> {
        palpate_io::read_shape_csv(dir).expect("a shape").iter().map(|point| point.touches).collect()
    };
    let before = touches(&whole_dir);
    let most = before.iter().copied().max().expect("there is an outline");
    assert!(before.iter().any(|&count| count < most), "some is felt less often than other");
    let least = most.to_string();
    let pruned =
        palpate(dir.path(), &["reconstruct", text(&log), "-o", "out", "--min-touches", &least, "--diagnostics"]);
    assert_eq!((whole.code, pruned.code), (Some(0), Some(0)), "{}", pruned.stderr);
    let expected: Vec<u32> = before.iter().map(|&count| if count < most { 0 } else { count }).collect();
    assert_eq!(touches(&out), expected);
    assert!(summary(&out)["coverage"].as_f64() < summary(&whole_dir)["coverage"].as_f64());
    let table = fs::read_to_string(out.join("diagnostics.csv")).expect("there are diagnostics");
    assert!(table.starts_with("time_s,generalized_r1_m,"), "{}", &table[..80]);
    assert_eq!(
        table.lines().count(),
        1 + fs::read_to_string(out.join("motion.csv")).expect("a motion").lines().count() - 1
    );
    // The folder is still one that a later result may replace.
    let again = palpate(dir.path(), &["reconstruct", text(&log), "-o", "out", "--min-touches", "0"]);
    assert_eq!(again.code, Some(2), "none is felt fewer than 0 times");
    let again = palpate(dir.path(), &["reconstruct", text(&log), "-o", "out"]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert_eq!(names(&out), RESULT_FILES);
}

/// A log as another rig writes it: palm 2 counts clockwise, pad 1 from its tip, 0.2 m away.
fn as_another_rig_writes_it(log: &str) -> String {
    let mut lines = log.lines();
    let header = lines.next().expect("a header");
    let names: Vec<&str> = header.split(',').collect();
    let turned = |(name, cell): (&&str, &str)| match (*name, cell.parse::<f64>()) {
        ("phi2_rad", Ok(phi2)) => format!("{}", -phi2),
        ("s1_m", Ok(s1)) => format!("{}", 0.2 - s1),
        ("s1_mm", Ok(s1)) => format!("{}", 200.0 - s1),
        _ => cell.to_owned(),
    };
    let rows = lines.map(|line| names.iter().zip(line.split(',')).map(turned).collect::<Vec<String>>().join(","));
    std::iter::once(header.to_owned()).chain(rows).collect::<Vec<String>>().join("\n")
}

const RIG: &str = "\
[palm1]
direction = \"to_base\"
length_mm = 200
zero_sd_mm = 0.3
[angles]
sign2 = -1
";

#[test]
fn a_rig_file_says_how_the_rig_counts_and_what_is_not_known_of_it() {
    let dir = folder();
    let log = fs::read_to_string(example("pebble_full_turn_mujoco_sensor.csv")).expect("an example");
    fs::write(dir.path().join("log.csv"), as_another_rig_writes_it(&log)).expect("written");
    fs::write(dir.path().join("rig.toml"), RIG).expect("written");
    let truth = example("pebble_full_turn_mujoco_sensor.truth");
    let ran =
        palpate(dir.path(), &["reconstruct", "log.csv", "--rig", "rig.toml", "-o", "out", "--truth", text(&truth)]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(
        ran.stdout.contains("size    is known to 0.7 %") && ran.stdout.contains("zero of pad 1 "),
        "{}",
        ran.stdout
    );
    let summary = summary(&dir.path().join("out"));
    assert!(error_mm(&summary) < 0.05, "{}", error_mm(&summary));
    let zero = &summary["calibration"]["s1_zero_m"];
    assert_eq!(zero["prior_sd"].as_f64(), Some(3e-4));
    assert!(zero["sd"].as_f64().expect("a number") < 1e-4);
    // Without the rig file the line says what is wrong with it.
    let ran = palpate(dir.path(), &["reconstruct", "log.csv", "-o", "without"]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("line 2"), "{}", ran.stderr);
}

#[test]
fn a_rig_file_is_printed_and_checked() {
    let dir = folder();
    let ran = palpate(dir.path(), &["rig", "--template"]);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    fs::write(dir.path().join("rig.toml"), &ran.stdout).expect("written");
    let checked = palpate(dir.path(), &["rig", "rig.toml"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    assert!(checked.stdout.contains("zero_sd_m = 0.0005"), "{}", checked.stdout);
    fs::write(dir.path().join("wrong.toml"), "[palm1]\nzero_m = 5\n").expect("written");
    for arguments in [&["rig", "wrong.toml"][..], &["reconstruct", "log.csv", "--rig", "wrong.toml"]] {
        let refused = palpate(dir.path(), arguments);
        assert_eq!(refused.code, Some(2));
        assert!(refused.stderr.contains("wrong.toml, line 2, key palm1.zero_m"), "{}", refused.stderr);
    }
    assert_eq!(palpate(dir.path(), &["rig"]).code, Some(2));
}

/// Errors and conventions of a rig that `simulate` writes with.
const OFF: &str = "[palm1]
zero_mm = 0.4
[palm2]
direction = \"to_base\"
length_mm = 300
[angles]
phi2_zero_deg = -0.3
sign1 = -1
";

#[test]
fn a_simulated_rig_is_calibrated_by_its_logs() {
    let dir = folder();
    fs::write(dir.path().join("off.toml"), OFF).expect("written");
    for (shape, log) in [("egg", "1.csv"), ("pebble", "2.csv")] {
        let made = palpate(
            dir.path(),
            &["simulate", "--shape", shape, "--rig", "off.toml", "--noise-mm", "0.05", "--duration-s", "40", "-o", log],
        );
        assert_eq!(made.code, Some(0), "{}", made.stderr);
    }
    let used = palpate_io::read_rig(&dir.path().join("1.rig.toml")).expect("a rig file");
    assert_eq!((used.rig.calibration.zero_m, used.rig.tolerances.zero_sd_m), ([4e-4, 0.0], [0.0; 2]));
    // The log says by what rig it is to be taken.
    let ran = palpate(dir.path(), &["reconstruct", "1.csv", "-o", "out", "--truth", "1.truth"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(error_mm(&summary(&dir.path().join("out"))) < 0.05);
    // Signs and directions are known, the errors are not.
    let known = OFF.replace("zero_mm = 0.4\n", "").replace("phi2_zero_deg = -0.3\n", "");
    fs::write(dir.path().join("known.toml"), known).expect("written");
    let ran = palpate(dir.path(), &["calibrate", "1.csv", "2.csv", "--rig", "known.toml", "-o", "rig.toml"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(ran.stdout.contains("calibrated by 2 of 2 logs") && ran.stdout.contains("zero of pad 1"), "{}", ran.stdout);
    let found = palpate_io::read_rig(&dir.path().join("rig.toml")).expect("a rig file");
    let (calibration, tolerances) = (found.rig.calibration, found.rig.tolerances);
    assert!((calibration.zero_m[0] - 4e-4).abs() < 4.0 * tolerances.zero_sd_m[0] && tolerances.zero_sd_m[0] < 3e-5);
    let off_rad = calibration.angle_zero_rad[1] + 0.3_f64.to_radians();
    assert!(off_rad.abs() < 4.0 * tolerances.angle_zero_sd_rad[1], "{off_rad}");
    assert_eq!(found.conventions.angle_signs, [-1.0, 1.0]);
    let json = palpate(dir.path(), &["calibrate", "1.csv", "--rig", "known.toml", "-o", "one.toml", "--json"]);
    let json: Value = serde_json::from_str(&json.stdout).expect("JSON");
    assert_eq!(json["logs"][0]["is_used"].as_bool(), Some(true));
    // A disc of another radius.
    let ran = palpate(
        dir.path(),
        &["calibrate", "1.csv", "--rig", "known.toml", "--known-radius-mm", "5", "-o", "disc.toml"],
    );
    assert_eq!(ran.code, Some(2), "{}", ran.stdout);
    assert!(!dir.path().join("disc.toml").exists());
}

#[test]
fn own_shapes_motions_and_touchpads_are_simulated() {
    let dir = folder();
    let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).expect("a file");
    write("soap.csv", "x_mm;y_mm\n0;0\n60;0\n60;40\n30;38,5\n0;40\n");
    write("soap.svg", "<svg><path d=\"M0,0 h60 v40 h-60 z\"/></svg>");
    write("pad.toml", "noise_sd_m = 0\ncounts_per_inch = 254\n");
    let simulate = |more: &[&str]| {
        let ran = palpate(
            dir.path(),
            &[&["simulate", "-o", "log.csv", "--motion", "zigzag", "--duration-s", "20"], more].concat(),
        );
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        let shape = fs::read_to_string(dir.path().join("log.truth/shape.csv")).expect("a truth");
        let r = |line: &str| line.split(',').nth(1).and_then(|r| r.parse::<f64>().ok()).expect("r");
        let rows: Vec<f64> = shape.lines().skip(1).map(r).collect();
        // To the right, up, left and down.
        (ran.stderr, [0, 1, 2, 3].map(|quarter| rows[quarter * rows.len() / 4]))
    };
    let close = |found: [f64; 4], expected: [f64; 4], tolerance: f64| {
        assert!(
            found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < tolerance),
            "{found:?} {expected:?}"
        );
    };
    let (notes, r) = simulate(&["--shape", "soap.csv"]);
    close(r, [0.03, 0.0202, 0.03, 0.0198], 5e-4);
    assert!(
        notes.starts_with("note: soap.csv: the shape has 256 harmonics; corners of the outline are cut by up to 0."),
        "{notes}"
    );
    assert!(notes.ends_with("note: soap.csv: the outline has a dent 1.50 mm deep, which palms do not feel: its convex hull takes its place\n"), "{notes}");
    let (notes, r) = simulate(&["--shape", "soap.svg", "--com-mm", "5,-2", "--mass-g", "80"]);
    close(r, [0.025, 0.022, 0.035, 0.018], 5e-4);
    assert!(
        notes.starts_with(
            "note: soap.svg: the outline is the path in line 1; user units are taken for millimetres: 60.0 mm across\n"
        ),
        "{notes}"
    );
    // A truth is a shape about its centre of mass.
    fs::copy(dir.path().join("log.truth/shape.csv"), dir.path().join("again.csv")).expect("a copy");
    close(simulate(&["--shape", "again.csv"]).1, r, 1e-4);
    close(simulate(&["--shape", "again.csv", "--com-mm", "0,0"]).1, [0.03, 0.02, 0.03, 0.02], 5e-4);
    let (notes, r) = simulate(&["--shape", "stadium:60x40", "--com-mm", "0,1"]);
    close(r, [0.03, 0.019, 0.03, 0.021], 5e-4);
    assert!(notes.starts_with("note: stadium:60x40: the shape has 256 harmonics"), "{notes}");
    assert_eq!(simulate(&["--shape", "egg"]).0, "");

    // The log is a motion: the same palms at the same times, in steps of the pad.
    let made = palpate(dir.path(), &["simulate", "-o", "first.csv", "--duration-s", "30", "--finger-gap-mm", "10"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let ran = palpate(
        dir.path(),
        &["simulate", "-o", "second.csv", "--motion", "first.csv", "--pad", "pad.toml", "--shape", "egg"],
    );
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    let rows = |name: &str| {
        let text = fs::read_to_string(dir.path().join(name)).expect("a log");
        let rows = text.lines().skip_while(|line| !line.starts_with("time_s")).skip(1);
        rows.map(|row| row.split(',').map(|cell| cell.parse::<f64>().expect("a number")).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    let (first, second) = (rows("first.csv"), rows("second.csv"));
    assert!(first.len() == 601 && second.len() == 601);
    for (first, second) in first.iter().zip(&second) {
        assert_eq!((&first[..3], &first[5..]), (&second[..3], &second[5..]));
        assert!(second[3..5].iter().all(|s| (1e4 * s - (1e4 * s).round()).abs() < 1e-6), "{second:?}");
    }
}

/// Flat sides, which no series of few harmonics has: the centre of mass was certified 25 of its error bars off.
#[test]
fn error_bars_of_flat_sides_hold_what_the_harmonics_leave_out() {
    let dir = folder();
    let simulated = ["simulate", "--shape", "stadium:60x40", "--seed", "2", "-o", "stadium.csv"];
    assert_eq!(palpate(dir.path(), &simulated).code, Some(0));
    let ran = palpate(dir.path(), &["reconstruct", "stadium.csv", "-o", "out", "--truth", "stadium.truth"]);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    let out = dir.path().join("out");
    let motion = fs::read_to_string(out.join("motion.csv")).expect("a motion");
    let mut rows = motion.lines().filter(|line| !line.starts_with('#'));
    let column = rows.next().expect("a header").split(',').position(|name| name == "com_sd_m").expect("a column");
    let squares: Vec<f64> = rows
        .map(|row| row.split(',').nth(column).and_then(|sd| sd.parse::<f64>().ok()).expect("an error bar").powi(2))
        .collect();
    let sd_m = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let error_m = summary(&out)["truth"]["rms_com_m"].as_f64().expect("an error");
    assert!(error_m < 5.0 * sd_m, "{error_m} {sd_m}");
}
