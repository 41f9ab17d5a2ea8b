//! `palpate record` as a user runs it: from every kind of source that needs no device, through kills and full disks, and on to `reconstruct`.
#![cfg(unix)]

mod common;

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use common::{command, folder, palpate};
use palpate::Sample;
use palpate::palms::PalmPair;
use rand::{RngExt, SeedableRng};

/// Between two looks at a file.
const PAUSE: Duration = Duration::from_millis(5);

/// A log that `reconstruct` certifies.
fn simulate(dir: &Path) {
    let arguments = ["simulate", "--shape", "egg", "--duration-s", "40", "--rate-hz", "10", "-q", "-o", "egg.csv"];
    assert_eq!(palpate(dir, &arguments).code, Some(0));
}

fn with_input(dir: &Path, arguments: &[&str], input: &[u8]) -> common::Ran {
    let mut command = command(dir, arguments);
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // A program that has seen enough closes the pipe.
    let _ = child.stdin.take().expect("a pipe").write_all(input);
    child.wait_with_output().expect("the program ends").into()
}

#[test]
fn what_is_recorded_is_reconstructed_from_both_formats_alike() {
    let dir = folder();
    simulate(dir.path());
    let log = fs::read(dir.path().join("egg.csv")).expect("the log");
    fs::write(dir.path().join("rig.toml"), "[palm1]\nzero_sd_mm = 0\nscale_sd = 0\nsurface_offset_sd_mm = 0\n[palm2]\nzero_sd_mm = 0\nscale_sd = 0\nsurface_offset_sd_mm = 0\n[angles]\nphi1_zero_sd_deg = 0\nphi2_zero_sd_deg = 0\n").expect("a rig");
    let mut shapes = Vec::new();
    for name in ["copy.csv", "copy.mcap"] {
        let ran = with_input(dir.path(), &["record", "-", "--rig", "rig.toml", "-o", name], &log);
        assert_eq!(
            (ran.code, ran.stdout.as_str()),
            (Some(0), format!("{name}: 401 samples, 40.0 s\nlost: nothing\n").as_str()),
            "{}",
            ran.stderr
        );
        let ran = palpate(dir.path(), &["reconstruct", name, "-o", "result"]);
        assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
        shapes.push(fs::read(dir.path().join("result/shape.csv")).expect("a shape"));
    }
    assert_eq!(palpate(dir.path(), &["reconstruct", "egg.csv", "-o", "result"]).code, Some(0));
    shapes.push(fs::read(dir.path().join("result/shape.csv")).expect("a shape"));
    assert!(shapes[0] == shapes[1] && shapes[1] == shapes[2]);
}

#[test]
fn strokes_are_recorded_with_what_is_said_of_rig_and_object() {
    let dir = folder();
    let rows: String = (0..40).map(|index| format!("{},500,31,{}\n", 50 * index, 500 + index % 3)).collect();
    let text = format!("# swing_period_s: 0.41\ntime_ms,pivot_x_mm,pivot_y_mm,s_mm\n{rows}2000,500,x,\n");
    fs::write(dir.path().join("rig.toml"), "arm_sd_m = 2e-5\n").expect("a rig");
    for name in ["strokes.csv", "strokes.mcap"] {
        let ran = with_input(dir.path(), &["record", "-", "--rig", "rig.toml", "-o", name], text.as_bytes());
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        assert!(ran.stdout.contains("40 samples") && ran.stdout.contains("1 faulty line"), "{}", ran.stdout);
        let path = dir.path().join(name);
        let file = if name.ends_with("mcap") {
            palpate_live::read_mcap_strokes(&path, None).map_err(|error| error.to_string())
        } else {
            palpate_io::read_strokes(&path).map_err(|error| error.to_string())
        };
        let file = file.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((file.log.samples.len(), file.log.swing_period_s), (40, Some(0.41)), "{name}");
        assert_eq!(file.rig.and_then(|rig| rig.arm_sd_m), Some(2e-5), "{name}");
    }
    // An arm is no input device.
    let evdev = palpate(dir.path(), &["record", "evdev:a,b?angles=c", "-o", "none.csv"]);
    assert_ne!(evdev.code, Some(0));
}

#[test]
fn what_was_lost_is_told_and_a_recording_is_not_overwritten() {
    let dir = folder();
    let text = "time_s,phi1_deg,phi2_deg,s1_mm,s2_mm\n1,60,74,29,31\n1,60,74,29,31\nx\n2,60,0,29,31\n3,60,74,29,31\n";
    let ran = with_input(dir.path(), &["record", "-", "-o", "log.csv"], text.as_bytes());
    assert_eq!(ran.code, Some(0));
    assert_eq!(ran.stdout, "log.csv: 2 samples, 2.0 s\nlost: 2 faulty lines or messages, 1 doubled sample\n");
    assert!(ran.stderr.contains("note: the first fault: standard input, line 4: "), "{}", ran.stderr);
    let ran = with_input(dir.path(), &["record", "-", "-o", "log.csv"], text.as_bytes());
    assert_eq!(ran.code, Some(2));
    assert!(ran.stderr.contains("there is such a file already"), "{}", ran.stderr);
}

#[test]
fn bad_sources_end_in_one_message_and_leave_no_file() {
    let dir = folder();
    fs::write(dir.path().join("plan.toml"), "shape = 'cube'\n").expect("a plan");
    for (source, code, expected) in [
        ("serial:", 2, "serial:"),
        ("missing.csv", 1, "missing.csv: it cannot be opened"),
        ("sim:plan.toml", 2, "plan.toml: shape: "),
        ("mcap:plan.toml", 2, "this is no MCAP file"),
        ("-", 2, "column"),
    ] {
        let ran = with_input(dir.path(), &["record", source, "-o", "log.csv"], b"time_s,phi1_inch\n1,2\n");
        assert_eq!(ran.code, Some(code), "{source}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{source}: {}", ran.stderr);
        assert!(!dir.path().join("log.csv").exists(), "{source}");
    }
}

#[test]
fn a_simulated_rig_and_a_growing_file_are_recorded() {
    let dir = folder();
    fs::write(
        dir.path().join("plan.toml"),
        "motion = 'zigzag'\nduration_s = 10\nrate_hz = 20\nspeed = 0\ndropout = 0.1\n",
    )
    .expect("a plan");
    let ran = palpate(dir.path(), &["record", "sim:plan.toml", "-o", "sim.mcap"]);
    assert_eq!(
        (ran.code, ran.stdout.as_str()),
        (Some(0), "sim.mcap: 201 samples, 10.0 s\nlost: nothing\n"),
        "{}",
        ran.stderr
    );
    let ran = palpate(dir.path(), &["record", "mcap:sim.mcap", "-o", "sim.csv", "--rotate-s", "5"]);
    assert_eq!(
        (ran.code, ran.stdout.as_str()),
        (Some(0), "sim.0001.csv and 2 more: 201 samples, 10.0 s\nlost: nothing\n"),
        "{}",
        ran.stderr
    );
    let mut child = Recording::start(command(dir.path(), &["record", "sim.0001.csv", "-o", "follow.csv"]));
    child.until(&dir.path().join("follow.csv"), |text| text.lines().count() >= 100);
    // Ctrl-C.
    assert!(Command::new("kill").args(["-INT", &child.0.id().to_string()]).status().expect("kill").success());
    let mut said = String::new();
    child.0.stdout.take().expect("a pipe").read_to_string(&mut said).expect("text");
    assert_eq!(
        (child.0.wait().expect("an end").code(), said.as_str()),
        (Some(0), "follow.csv: 100 samples, 5.0 s\nlost: nothing\n")
    );
}

/// A recording that is running; it is ended with the test.
struct Recording(Child);

impl Recording {
    fn start(mut command: Command) -> Self {
        Self(
            command
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .stderr(Stdio::piped())
                .spawn()
                .expect("the program starts"),
        )
    }

    /// Waits until a file is as it should be.
    fn until(&mut self, path: &Path, is_so: impl Fn(&str) -> bool) {
        while !is_so(&String::from_utf8_lossy(&fs::read(path).unwrap_or_default())) {
            assert!(self.0.try_wait().expect("a process").is_none(), "the recording ended by itself");
            std::thread::sleep(PAUSE);
        }
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn sample(index: usize) -> Sample {
    Sample::new(0.01 * index as f64, PalmPair::hinged(1.0, 1.3), 0.03 + 1e-6 * index as f64, 0.03)
}

fn row(index: usize) -> String {
    let mut row = String::new();
    palpate_io::push_log_row(&mut row, &sample(index));
    row
}

fn samples_in(path: &Path) -> Vec<Sample> {
    let read = if path.extension().is_some_and(|extension| extension == "mcap") {
        palpate_live::read_mcap_log(path, None, None).map(|(file, _)| file).map_err(|error| error.to_string())
    } else {
        palpate_io::read_log(path).map_err(|error| error.to_string())
    };
    read.unwrap_or_else(|error| panic!("{error}")).log.samples
}

#[test]
fn after_a_kill_at_any_moment_the_file_can_be_read_and_holds_what_was_safe() {
    kill(20, 1);
}

#[test]
#[ignore = "a study: `cargo test -p palpate-cli --test record -- --ignored`"]
fn after_two_hundred_kills_all_files_can_be_read() {
    kill(200, 2);
}

fn kill(trials: u64, seed: u64) {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    for trial in 0..trials {
        let dir = folder();
        let name = if trial % 2 == 0 { "log.csv" } else { "log.mcap" };
        let path = dir.path().join(name);
        let mut recording = Recording::start(command(dir.path(), &["record", "-", "-o", name]));
        let mut input = recording.0.stdin.take().expect("a pipe");
        input.write_all(palpate_io::log_csv_header(&[]).as_bytes()).expect("a header");
        let safe = rng.random_range(20..200);
        (0..safe).for_each(|index| input.write_all(row(index).as_bytes()).expect("a line"));
        // Nothing more comes, and still these reach the file.
        let newest = format!("{},", sample(safe - 1).time_s);
        let newest = if name == "log.csv" { format!("\n{newest}") } else { format!("\"time_s\":{newest}") };
        recording.until(&path, |text| text.contains(&newest));
        (safe..safe + rng.random_range(0..3000))
            .for_each(|index| input.write_all(row(index).as_bytes()).expect("a line"));
        std::thread::sleep(Duration::from_micros(rng.random_range(0..2000)));
        recording.0.kill().expect("a kill");
        recording.0.wait().expect("an end");
        let found = samples_in(&path);
        assert!(found.len() >= safe, "{name}: {} of {safe}", found.len());
        assert!(found.iter().enumerate().all(|(index, found)| *found == sample(index)), "{name}");
    }
}

#[test]
fn a_disk_that_is_full_ends_the_recording_with_what_fits() {
    let dir = folder();
    let mut text = palpate_io::log_csv_header(&[]);
    (0..5000).for_each(|index| text.push_str(&row(index)));
    fs::write(dir.path().join("input.csv"), text).expect("an input");
    for name in ["log.csv", "log.mcap"] {
        // Files end at 50 kB: 100 blocks of 512 bytes, and no signal but a failure.
        let line = format!("trap '' XFSZ; ulimit -f 100; exec \"$1\" record - -o {name} < input.csv");
        let mut shell = Command::new("sh");
        let ran: common::Ran = shell
            .current_dir(dir.path())
            .args(["-c", &line, "sh", env!("CARGO_BIN_EXE_palpate")])
            .output()
            .expect("a shell")
            .into();
        assert_eq!(ran.code, Some(1), "{}", ran.stderr);
        assert!(
            ran.stderr.contains(&format!("{name}: writing failed: ")) && ran.stderr.contains("are kept"),
            "{}",
            ran.stderr
        );
        let kept = samples_in(&dir.path().join(name));
        assert!(ran.stderr.contains(&format!("the {} samples before that are kept", kept.len())), "{}", ran.stderr);
        assert!(kept.len() > 100 && kept.iter().enumerate().all(|(index, kept)| *kept == sample(index)), "{name}");
    }
    let ran = palpate(dir.path(), &["record", "input.csv", "-o", "/dev/full"]);
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.starts_with("error: /dev/full: it cannot be made: "), "{}", ran.stderr);
}
