//! Palm logs that are read: units, tolerated oddities, notes, and the round trip through a file.

use palpate::palms::PalmPair;
use palpate::{Log, Sample};
use palpate_io::{LogFile, WriteProblem, parse_log, read_log, write_log};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

fn parse(text: &str) -> LogFile {
    parse_log("log.csv", text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

fn rows(header: &str, row: impl Fn(usize) -> String) -> String {
    let rows: Vec<String> = (0..14).map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

fn plain() -> String {
    rows("time_s,phi1_rad,phi2_rad,s1_m,s2_m", |row| format!("{row},1.04,1.2,0.0297,0.0318"))
}

#[test]
fn every_unit_is_converted() {
    let file = parse(&rows(
        "force2_n,base2_y_mm,base2_x_cm,base1_y_m,base1_x_mm,s2_sd_cm,s1_sd_mm,s2_cm,s1_mm,phi2_deg,phi1_deg,time_ms,force1_n",
        |row| format!("2,-4,3,0.002,1,0.02,0.1,3.18,29.7,90,180,{},1.5", 50 * row),
    ));
    let sample = file.log.samples[1];
    let expected = Sample {
        time_s: 0.05,
        palms: PalmPair {
            phi1_rad: std::f64::consts::PI,
            phi2_rad: std::f64::consts::FRAC_PI_2,
            base1_m: [0.001, 0.002],
            base2_m: [0.03, -0.004],
        },
        s1_m: Some(0.0297),
        s2_m: Some(0.0318),
        s1_sd_m: Some(0.0001),
        s2_sd_m: Some(0.0002),
        force1_n: Some(1.5),
        force2_n: Some(2.0),
    };
    assert_eq!(sample, expected);
    assert_eq!(file.notes, Vec::<String>::new());
}

#[test]
fn oddities_of_other_programs_are_tolerated() {
    let expected = parse(&plain());
    let same = |text: String| assert_eq!(parse(&text).log, expected.log, "{text}");
    same(plain().replace('\n', "\r\n"));
    same(plain().replace('\n', "\r"));
    same(format!("\u{feff}{}", plain()));
    same(plain().replace(',', " , "));
    same(plain().replace(',', ";"));
    same(plain().replace(',', "\t"));
    same(plain().replace("1.04", "\"1.04\"").replace("time_s", "\"time_s\""));
    same(plain().replace('\n', "\n\n"));
    same(plain() + ",,,,\n\n");
    same(plain().to_uppercase());
    same(plain().trim_end().to_string());
}

#[test]
fn what_spreadsheets_write_is_read() {
    let expected = parse(&plain());
    let same = |text: String| assert_eq!(parse(&text).log, expected.log, "{text}");
    // Decimal commas, and the line by which a spreadsheet says what separates its columns.
    let semicolons = plain().replace(',', ";").replace('.', ",");
    same(semicolons.clone());
    same(format!("sep=;\n{semicolons}"));
    same(format!("\u{feff}\"SEP=;\"\r\n{}", semicolons.replace('\n', "\r\n")));
    same(format!("sep=\t\n{}", semicolons.replace(';', "\t")));
    same(format!("# robot: left hand\nsep=,\n{}", plain()));
    // A comma in a name does not make a file one with commas.
    let noted = |mark: &str| {
        rows(&format!("time_s{mark}phi1_rad{mark}phi2_rad{mark}s1_m{mark}s2_m{mark}left, dry"), |row| {
            format!("{row}{mark}1,04{mark}1,2{mark}0,0297{mark}0,0318{mark}")
        })
    };
    same(noted(";"));
    same(noted("\t"));
    // Units in brackets, a degree sign, a micro sign, another name of time.
    let header = "time_s,phi1_rad,phi2_rad,s1_m,s2_m";
    same(plain().replace(header, "Time [s],Phi1 (rad),phi2 [rad],S1 (m),s2(m)"));
    same(plain().replace(header, "timestamp_s,phi1_rad,phi2_rad,s1_m,s2_m"));
    same(plain().replace(header, "Time_Stamp (s),phi1_rad,phi2_rad,s1_m,s2_m"));
    let degrees = parse(&rows("time (us);phi1 [°];phi2 °;s1 [µm];s2_um", |row| {
        format!("{};60;74,5;29700;31800", 50_000 * row)
    }));
    let sample = degrees.log.samples[3];
    assert_eq!((sample.time_s, sample.s1_m, sample.s2_m), (0.15, Some(0.0297), Some(0.0318)));
    assert_eq!(sample.palms, PalmPair::hinged(60.0_f64.to_radians(), 74.5_f64.to_radians()));
    let nanoseconds = parse(&rows("time_ns,phi1_rad,phi2_rad,s1_m,s2_m", |row| {
        format!("{},1.04,1.2,0.0297,0.0318", 50_000_000 * row)
    }));
    assert_eq!(nanoseconds.log.samples[3].time_s, 0.15);
}

#[test]
fn the_first_name_of_a_quantity_comes_first() {
    let text = rows("timestamp,time_s,phi1_rad,phi2_rad,s1_m,s2_m", |row| format!("noon,{row},1.04,1.2,0.0297,0.0318"));
    assert_eq!(parse(&text).log, parse(&plain()).log);
    assert_eq!(parse(&text).notes, ["columns ignored: timestamp"]);
    let error = parse_log("log.csv", text.replace("time_s,", "t,").as_bytes()).expect_err("a timestamp in no unit");
    assert_eq!(
        error.to_string(),
        "log.csv, line 1, column timestamp: the name has no unit; name the column timestamp_s, timestamp_ms, timestamp_us or timestamp_ns"
    );
}

#[test]
fn names_of_time_are_known_by_any_unit() {
    for (name, expected) in
        [("time", "time_s"), ("Time (ms)", "time_s"), ("timestamp", "timestamp_s"), ("time_stamp_x", "time_stamp_s")]
    {
        assert_eq!(palpate_io::name_in_seconds(name).as_deref(), Some(expected));
    }
    assert_eq!(palpate_io::name_in_seconds("timer"), None);
}

#[test]
fn an_empty_cell_or_nan_is_no_contact() {
    let text = plain() + "14,1.04,1.2,,0.03\n15,1.04,1.2,0.03,NaN\n16,1.04,1.2, ,nan\n";
    let contacts: Vec<_> = parse(&text).log.samples[14..].iter().map(|sample| (sample.s1_m, sample.s2_m)).collect();
    assert_eq!(contacts, [(None, Some(0.03)), (Some(0.03), None), (None, None)]);
}

#[test]
fn metadata_is_found_above_and_between() {
    let text = format!("# object: egg\n#seed:7\n# seed: 7\n{}# stopped: by hand\n# the end\n", plain());
    let pairs = [("object", "egg"), ("seed", "7"), ("stopped", "by hand")];
    assert_eq!(parse(&text).metadata, pairs.map(|(key, value)| (key.to_string(), value.to_string())));
}

#[test]
fn notes_tell_what_was_left_aside_and_what_may_be_cut_off() {
    let notes = |text: &str| parse(text).notes;
    assert_eq!(
        notes(&rows("time_s,phi1_rad,phi2_rad,s1_m,s2_m,s1_raw,,temperature", |row| format!(
            "{row},1,1,0.03,0.03,a,b,c"
        ))),
        ["columns ignored: s1_raw, (no name), temperature"]
    );
    assert_eq!(
        notes(plain().trim_end()),
        ["the last line has no line break; if the file was cut off, its last value may be wrong"]
    );
}

#[test]
fn metadata_that_would_not_read_back_is_refused() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("log.csv");
    for (key, value) in [("", "a"), ("a:b", "c"), ("1", "a"), ("a", "b\nc")] {
        let error = write_log(&path, &Log::default(), &[(key.to_string(), value.to_string())]);
        let problem = error.expect_err("it would not read back").problem;
        assert!(matches!(problem, WriteProblem::Metadata { .. }), "{problem}");
    }
    assert!(!path.exists());
}

#[test]
fn a_log_is_not_written_over_a_folder() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let error = write_log(folder.path(), &Log::default(), &[]).expect_err("a folder is there");
    let expected =
        format!("{}: a folder of that name exists; choose another name for the file", folder.path().display());
    assert_eq!(error.to_string(), expected);
    let path = folder.path().join("file").join("log.csv");
    std::fs::write(folder.path().join("file"), "").expect("a file for the test");
    let error = write_log(&path, &Log::default(), &[]).expect_err("a file is in the way");
    let expected = format!(
        "{}: a file of that name exists; choose another name for the folder",
        folder.path().join("file").display()
    );
    assert_eq!(error.to_string(), expected);
}

fn a_sample(contacts: impl Strategy<Value = (Option<f64>, Option<f64>)>) -> impl Strategy<Value = (f64, Sample)> {
    let palms = (-12.0..12.0, 0.0011..3.1405, [-0.7..0.7, -1e-3..1e-3], [-1e-300..1e-300, -0.5..0.5]);
    let stated = [option::of(1e-12..1.0), option::of(1e-6..1e-3)];
    let force = option::of(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO);
    (1e-6..10.0, palms, contacts, stated, force).prop_map(|(step, palms, contacts, stated, force)| {
        let (phi1_rad, phi2_rad, base1_m, base2_m) = palms;
        let sample = Sample {
            time_s: 0.0,
            palms: PalmPair { phi1_rad, phi2_rad, base1_m, base2_m },
            s1_m: contacts.0,
            s2_m: contacts.1,
            s1_sd_m: stated[0],
            s2_sd_m: stated[1],
            force1_n: force,
            force2_n: None,
        };
        (step, sample)
    })
}

fn a_log() -> impl Strategy<Value = Log> {
    let both = (1e-3..2.0).prop_flat_map(|s1: f64| (Just(Some(s1)), (2e-3..3e-3).prop_map(Some)));
    let either = (option::of(0.0..0.2), option::of(prop_oneof![0.0..0.2, 1e-310..1e-3]));
    (-1e6..1e9, vec(a_sample(both), 12..16), vec(a_sample(either), 0..20), any::<bool>()).prop_map(
        |(mut time, first, rest, hinged)| {
            let samples = first.into_iter().chain(rest).map(|(step, mut sample)| {
                time += step;
                sample.time_s = time;
                if hinged {
                    sample.palms = PalmPair::hinged(sample.palms.phi1_rad, sample.palms.phi2_rad);
                }
                sample
            });
            Log { samples: samples.collect() }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_reads_back_the_same(log in a_log(), value in "[a-z:# ,\"ß]{0,20}") {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("new").join("log.csv");
        let metadata = [("made by".to_string(), value.trim().to_string())];
        write_log(&path, &log, &metadata).expect("it can be written");
        let file = read_log(&path).unwrap_or_else(|error| panic!("{error}"));
        prop_assert_eq!(file.log, log);
        prop_assert_eq!(file.metadata, metadata);
        let left: Vec<_> = path.parent().expect("it has one").read_dir().expect("it is there").collect();
        prop_assert_eq!(left.len(), 1);
    }
}

#[test]
fn a_recording_that_was_cut_off_is_read_up_to_its_last_whole_line() {
    let samples: Vec<Sample> = (0..14)
        .map(|k| Sample {
            force1_n: (k % 2 == 0).then_some(1.5),
            ..Sample::new(0.1 * f64::from(k), PalmPair::hinged(1.0, 1.3), 0.03, 0.031)
        })
        .collect();
    let mut text = palpate_io::log_csv_header(&[("rig".to_owned(), "exact".to_owned())]);
    samples.iter().for_each(|sample| palpate_io::push_log_row(&mut text, sample));
    let whole = palpate_io::parse_log("log.csv", text.as_bytes()).expect("a whole recording");
    assert_eq!((whole.log.samples, whole.notes), (samples.clone(), vec![]));
    let last_line = text.trim_end().rfind('\n').expect("several lines") + 1;
    for end in last_line + 1..text.len() {
        let cut = palpate_io::parse_log("log.csv", &text.as_bytes()[..end]).expect("a recording that was cut off");
        assert_eq!(cut.log.samples, samples[..13], "{end}");
        assert_eq!(cut.notes, ["the recording ended in the middle of a line, which is left out"], "{end}");
    }
    let other = text.replace("palpate record", "a robot");
    assert!(palpate_io::parse_log("log.csv", &other.as_bytes()[..last_line + 1]).is_err());
}

#[test]
fn a_line_break_in_what_a_recording_says_of_itself_breaks_no_line() {
    let samples: Vec<Sample> =
        (0..14).map(|k| Sample::new(0.1 * f64::from(k), PalmPair::hinged(1.0, 1.3), 0.03, 0.031)).collect();
    let mut text = palpate_io::log_csv_header(&[("object".to_owned(), "an egg\r\nof a hen".to_owned())]);
    samples.iter().for_each(|sample| palpate_io::push_log_row(&mut text, sample));
    assert!(text.lines().any(|line| line == "# object: an egg  of a hen"), "{text}");
    assert_eq!(palpate_io::parse_log("log.csv", text.as_bytes()).expect("a recording").log.samples, samples);
}
