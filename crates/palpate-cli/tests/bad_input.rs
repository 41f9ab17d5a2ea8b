//! Bad input and wrong usage: one clear message, exit code 2, nothing written.

mod common;

use std::fs;
use std::io::Write;

use common::{folder, names, palpate};

const HEADER: &str = "time_s,phi1_deg,phi2_deg,s1_mm,s2_mm\n";

/// A log of `count` good rows.
fn good(count: usize) -> String {
    (0..count).fold(HEADER.to_string(), |log, row| log + &good_row(row))
}

fn good_row(row: usize) -> String {
    format!("{:.2},{},{},30.1,31.2\n", 0.05 * row as f64, 60.0, 74.0 + 0.1 * row as f64)
}

/// A good log with one more row at its end.
fn with_row(row: &str) -> String {
    good(20) + row + "\n" + &(22..30).map(good_row).collect::<String>()
}

/// The message for a log with these bytes, after having checked what goes for all of them.
fn refusal(bytes: impl AsRef<[u8]>) -> String {
    let dir = folder();
    fs::write(dir.path().join("trial.csv"), bytes).expect("the log is written");
    let ran = palpate(dir.path(), &["reconstruct", "trial.csv", "-o", "out"]);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert_eq!(ran.stdout, "");
    assert_eq!(names(dir.path()), ["trial.csv"], "something was written");
    let lines: Vec<&str> = ran.stderr.lines().collect();
    let [message] = lines[..] else { panic!("not one line: {}", ran.stderr) };
    message.strip_prefix("error: ").expect("an error").to_string()
}

#[test]
fn a_missing_column_is_named() {
    assert_eq!(
        refusal(good(20).replace("s2_mm", "force")),
        "trial.csv, line 1: there is no column for s2; it must be named s2_m, s2_cm, s2_mm or s2_um (the header has: time_s, phi1_deg, phi2_deg, s1_mm, force)"
    );
}

#[test]
fn an_unknown_unit_is_named() {
    assert_eq!(
        refusal(good(20).replace("s2_mm", "s2_inch")),
        "trial.csv, line 1, column s2_inch: the unit \"inch\" is unknown; convert the column and name it s2_m, s2_cm, s2_mm or s2_um"
    );
}

#[test]
fn a_column_without_a_unit_is_refused() {
    assert_eq!(
        refusal(good(20).replace("phi1_deg", "phi1")),
        "trial.csv, line 1, column phi1: the name has no unit; name the column phi1_rad or phi1_deg"
    );
}

#[test]
fn text_in_a_number_is_refused() {
    assert_eq!(
        refusal(with_row("1.0,60,75,thirty,31")),
        "trial.csv, line 22, column s1_mm: \"thirty\" is not a number; write one such as 12.5, or leave the cell empty where no contact was seen"
    );
}

#[test]
fn time_running_backwards_is_refused() {
    assert_eq!(
        refusal(with_row("0.5,60,75,30,31")),
        "trial.csv, line 22, column time_s: 0.5 comes after 0.95 (line 21), time decreases; sort the rows, or split the file where it starts again"
    );
}

#[test]
fn an_infinite_value_is_refused() {
    assert_eq!(
        refusal(with_row("1.0,60,75,inf,31")),
        "trial.csv, line 22, column s1_mm: \"inf\" is infinite; delete the row, or leave the cell empty where no contact was seen"
    );
}

#[test]
fn parallel_palms_are_refused() {
    assert_eq!(
        refusal(with_row("1.0,60,180,30,31")),
        "trial.csv, line 22, column phi2_deg: 180 deg makes the palms parallel; the angle from palm 1 to palm 2 must lie between 0 and pi (180 deg), and not within 0.001 rad of either"
    );
}

#[test]
fn a_negative_contact_position_is_refused() {
    assert_eq!(
        refusal(with_row("1.0,60,75,-30,31")),
        "trial.csv, line 22, column s1_mm: -30 mm is negative; it is the distance from the base of the palm to the contact: add how far from the base the pad begins, or leave the cell empty where no contact was seen"
    );
}

#[test]
fn too_few_samples_are_refused() {
    assert_eq!(
        refusal(good(5)),
        "trial.csv: 5 of its 5 samples have a contact on both palms, and at least 12 are needed to solve for a shape; record longer, or check the touch threshold"
    );
}

#[test]
fn samples_without_contact_do_not_count() {
    let log = good(20).replace("30.1,31.2", ",31.2");
    assert_eq!(
        refusal(log),
        "trial.csv: 0 of its 20 samples have a contact on both palms, and at least 12 are needed to solve for a shape; record longer, or check the touch threshold"
    );
}

#[test]
fn an_empty_file_is_refused() {
    assert_eq!(
        refusal(""),
        "trial.csv: the file is empty; it needs a header line with the column names and a line for each sample"
    );
}

#[test]
fn a_header_alone_is_refused() {
    assert_eq!(
        refusal(HEADER),
        "trial.csv, line 1: there is only a header and no line below it; was the recording stopped before it began?"
    );
}

#[test]
fn a_file_that_was_cut_off_is_refused() {
    let log = good(20);
    assert_eq!(
        refusal(&log[..log.len() - 6]),
        "trial.csv, line 21: the last row has 4 of 5 cells, the file looks cut off; copy it again, or delete that row"
    );
}

#[test]
fn a_binary_file_is_refused() {
    assert_eq!(
        refusal([0x89, b'P', b'N', b'G', 0, 0, 1, 0xff]),
        "trial.csv: this is a binary file, not text; export it as CSV"
    );
}

#[test]
fn a_log_in_utf_16_is_refused() {
    let bytes: Vec<u8> = [0xff, 0xfe].into_iter().chain(good(20).encode_utf16().flat_map(u16::to_le_bytes)).collect();
    assert_eq!(refusal(bytes), "trial.csv: the text is encoded in UTF-16; save it as CSV in UTF-8");
}

/// Runs a command that is wrong in itself: exit code 2, nothing written, and no Rust on the screen.
fn misuse(prepare: impl Fn(&std::path::Path), arguments: &[&str]) -> String {
    let dir = folder();
    prepare(dir.path());
    let before = names(dir.path());
    let ran = palpate(dir.path(), arguments);
    assert_eq!(ran.code, Some(2), "{}", ran.stderr);
    assert_eq!(ran.stdout, "");
    assert_eq!(names(dir.path()), before, "something was written");
    ran.stderr.lines().next().unwrap_or_default().to_string()
}

fn with_good_log(dir: &std::path::Path) {
    fs::write(dir.join("trial.csv"), good(20)).expect("the log is written");
}

#[test]
fn a_missing_log_is_refused() {
    assert_eq!(
        misuse(|_| {}, &["reconstruct", "trial.csv", "-o", "out"]),
        "error: trial.csv: no such file; check the path"
    );
}

#[test]
fn a_log_in_the_wrong_unit_is_refused() {
    assert_eq!(
        refusal(good(20).replace("s1_mm,s2_mm", "s1_m,s2_m")),
        "trial.csv, line 2, column s1_m: 30.1 m is more than 2 m; correct it, or name the column s1_cm, s1_mm or s1_um if that is its unit"
    );
}

#[test]
fn logs_that_cannot_go_together_are_refused() {
    let prepare = |dir: &std::path::Path| {
        with_good_log(dir);
        fs::create_dir(dir.join("b")).expect("a folder");
        fs::copy(dir.join("trial.csv"), dir.join("b/trial.csv")).expect("a copy");
    };
    assert_eq!(
        misuse(prepare, &["reconstruct", "trial.csv", "b/trial.csv", "-o", "out"]),
        "error: trial.csv and b/trial.csv would both be written to out/trial; reconstruct them in two calls"
    );
    assert_eq!(
        misuse(prepare, &["reconstruct", "trial.csv", "b/trial.csv", "--truth", "trial.truth"]),
        "error: --truth belongs to one log; reconstruct that one by itself"
    );
    assert_eq!(
        misuse(prepare, &["reconstruct", "trial.csv", "b/trial.csv", "--animation", "trial.gif"]),
        "error: --animation shows one log; reconstruct that one by itself"
    );
    assert_eq!(
        misuse(with_good_log, &["reconstruct", "trial.csv", "--animation", "trial.mp4"]),
        "error: trial.mp4: an animation is a GIF file; let its name end in .gif"
    );
    assert_eq!(
        misuse(prepare, &["reconstruct", "-"]),
        "error: standard input has no name for its result; give a folder with -o DIR"
    );
}

#[test]
fn standard_input_is_named_in_messages() {
    let dir = folder();
    let mut command = common::command(dir.path(), &["reconstruct", "-", "-o", "out"]);
    let mut child = command
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    child.stdin.take().expect("a pipe").write_all(good(5).as_bytes()).expect("it reads");
    let ran: common::Ran = child.wait_with_output().expect("it ends").into();
    assert_eq!(ran.code, Some(2));
    assert_eq!(
        ran.stderr,
        "error: standard input: 5 of its 5 samples have a contact on both palms, and at least 12 are needed to solve for a shape; record longer, or check the touch threshold\n"
    );
}

#[test]
fn a_folder_for_a_log_is_refused() {
    let prepare = |dir: &std::path::Path| fs::create_dir(dir.join("trial.csv")).expect("a folder");
    assert_eq!(
        misuse(prepare, &["reconstruct", "trial.csv", "-o", "out"]),
        "error: trial.csv: this is a folder; give the CSV file in it"
    );
}

#[test]
fn a_missing_truth_is_refused() {
    assert_eq!(
        misuse(with_good_log, &["reconstruct", "trial.csv", "-o", "out", "--truth", "trial.truth"]),
        "error: trial.truth: no such folder; check the path"
    );
}

#[test]
fn a_truth_of_another_log_is_refused() {
    let prepare = |dir: &std::path::Path| {
        with_good_log(dir);
        fs::create_dir(dir.join("trial.truth")).expect("a folder");
        let shape: String = (0..8).map(|row| format!("{},0.03\n", 0.7 * row as f64)).collect();
        fs::write(dir.join("trial.truth/shape.csv"), "theta_rad,r_m\n".to_string() + &shape).expect("a shape");
        fs::write(dir.join("trial.truth/motion.csv"), "time_s,psi_rad,com_x_m,com_y_m\n0,0,0,0.05\n")
            .expect("a motion");
    };
    assert_eq!(
        misuse(prepare, &["reconstruct", "trial.csv", "-o", "out", "--truth", "trial.truth"]),
        "error: trial.truth: motion.csv and the log differ in length (1 against 20 rows); give the truth of this log"
    );
}

#[test]
fn a_folder_with_other_things_is_left_alone() {
    let prepare = |dir: &std::path::Path| {
        with_good_log(dir);
        fs::create_dir(dir.join("out")).expect("a folder");
        fs::write(dir.join("out/thesis.tex"), "years of work").expect("a file");
    };
    assert_eq!(
        misuse(prepare, &["reconstruct", "trial.csv", "-o", "out"]),
        "error: out: the folder holds thesis.tex, which is not part of an earlier result and would be lost; choose another folder, or a new one inside it"
    );
}

#[test]
fn a_file_where_the_result_should_go_is_left_alone() {
    assert_eq!(
        misuse(with_good_log, &["reconstruct", "trial.csv", "-o", "trial.csv"]),
        "error: trial.csv: a file of that name exists; choose another name for the folder"
    );
}

#[test]
fn options_out_of_range_are_refused() {
    let with =
        |option: &str, value: &str| misuse(with_good_log, &["reconstruct", "trial.csv", "-o", "out", option, value]);
    assert_eq!(
        with("--harmonics", "1"),
        "error: invalid value '1' for '--harmonics <K>': a whole number from 2 to 64 is needed"
    );
    assert_eq!(
        with("--harmonics", "many"),
        "error: invalid value 'many' for '--harmonics <K>': a whole number from 2 to 64 is needed"
    );
    assert_eq!(with("--sensor-sd-mm", "0"), "error: invalid value '0' for '--sensor-sd-mm <MM>': it must be above 0");
    assert_eq!(
        with("--sensor-sd-mm", "nan"),
        "error: invalid value 'nan' for '--sensor-sd-mm <MM>': a number is needed, such as 12.5"
    );
    assert_eq!(with("--threads", "0"), "error: invalid value '0' for '--threads <N>': 0 is not in 1..=1024");
    assert_eq!(with("--colour", "red"), "error: unexpected argument '--colour' found");
}

#[test]
fn no_command_shows_the_help() {
    assert_eq!(
        misuse(|_| {}, &[]),
        "Shape, motion and centre of mass of an unknown object from what two tactile palms feel"
    );
}

#[test]
fn an_impossible_simulation_is_refused() {
    let with = |options: &[&str]| misuse(|_| {}, &[&["simulate", "-o", "out.csv"], options].concat());
    assert_eq!(
        with(&["--shape", "banana"]),
        "error: invalid value 'banana' for '--shape <NAME|FILE>': no shape is named \"banana\"; known are circle, disc, ellipse, egg, triangle, square, pebble, stone, random:SEED, rectangle:LENGTHxWIDTH[xCORNER], stadium:LENGTHxWIDTH (sizes in millimetres), or a file .csv or .svg"
    );
    assert_eq!(with(&["--shape", "soap.svg"]), "error: soap.svg: no such file; check the path");
    assert_eq!(
        with(&["--motion", "wild"]),
        "error: invalid value 'wild' for '--motion <NAME|FILE>': turn, zigzag, random or a file .csv is needed"
    );
    assert_eq!(
        with(&["--pad", "soft"]),
        "error: invalid value 'soft' for '--pad <NAME|FILE>': ideal, interlink or a file .toml is needed"
    );
    assert_eq!(
        with(&["--motion", "palms.csv", "--rate-hz", "5"]),
        "error: palms.csv has its own times; leave --duration-s and --rate-hz out"
    );
    assert_eq!(
        with(&["--shape", "soap.svg", "--radius-mm", "5"]),
        "error: soap.svg: an outline has its own size; leave --radius-mm out"
    );
    assert_eq!(
        with(&["--com-mm", "90,3", "--motion", "zigzag"]),
        "error: --com-mm 90,3 puts the centre of mass outside the object"
    );
    assert_eq!(
        with(&["--palm-length-mm", "5"]),
        "error: no motion without a jump was found for this object within the limits of the palms; try --motion zigzag, or another --palm-length-mm or --com-offset-mm"
    );
    assert_eq!(
        with(&["--pad", "interlink", "--motion", "random"]),
        "error: at 0.000 s the contact runs off palm 1: 0.0643 m from its base, the palm reaches from 0 to 0.0555 m"
    );
    assert_eq!(with(&["--radius-mm", "-30"]), "error: invalid value '-30' for '--radius-mm <MM>': it must be above 0");
    assert_eq!(
        with(&["--com-offset-mm", "3"]),
        "error: invalid value '3' for '--com-offset-mm <X,Y>': two numbers with a comma between them are needed, such as 3,-2"
    );
    assert_eq!(
        with(&["--com-offset-mm", "-90,3", "--motion", "zigzag"]),
        "error: --com-offset-mm -90,3 puts the centre of mass outside the object"
    );
    assert_eq!(
        with(&["--dropout", "1"]),
        "error: invalid value '1' for '--dropout <SHARE>': it must be at least 0 and below 1"
    );
    assert_eq!(
        with(&["--rate-hz", "1e9"]),
        "error: the motion would have 100000000000 samples, more than 5 million: lower the rate or the duration"
    );
    assert_eq!(misuse(|_| {}, &["simulate", "-o", "."]), "error: .: this is a folder; give the file to write");
}

#[test]
fn a_demo_does_not_take_the_place_of_other_things() {
    let prepare = |dir: &std::path::Path| fs::write(dir.join("palpate-demo"), "a file").expect("a file");
    assert_eq!(
        misuse(prepare, &["demo"]),
        "error: palpate-demo: a file of that name exists; choose another name for the folder"
    );
}
