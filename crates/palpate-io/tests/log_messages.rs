//! Every way in which a palm log can be wrong, with the whole message that the user sees.

use std::io::Write;
use std::path::Path;

use palpate_io::{log_from_columns, parse_log, read_log};

const HEADER: &str = "time_s,phi1_rad,phi2_rad,s1_mm,s2_mm";

/// Lines of a good log: the header and 14 rows, so that row n is line n + 1.
fn good() -> Vec<String> {
    let mut lines = vec![HEADER.to_string()];
    lines.extend((0..14).map(|row| format!("{:.2},1.04,{:.2},29.7,31.8", 0.05 * row as f64, 1.2 + 0.01 * row as f64)));
    lines
}

fn text(lines: &[String]) -> String {
    lines.join("\n") + "\n"
}

/// A good log with one line replaced (from 1).
fn with_line(line: usize, content: &str) -> String {
    let mut lines = good();
    lines[line - 1] = content.to_string();
    text(&lines)
}

fn message(bytes: &[u8]) -> String {
    match parse_log("log.csv", bytes) {
        Ok(_) => "accepted".to_string(),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn expect(content: &str, expected: &str) {
    assert_eq!(message(content.as_bytes()), expected);
}

#[test]
fn a_negative_angle_between_the_palms_comes_with_the_remedy_that_goes_with_all_of_the_log() {
    let written = |angles: fn(f64, f64) -> (f64, f64)| {
        let row = |row: usize| {
            let (phi1, phi2) = angles(1.04, 1.2 + 0.01 * row as f64);
            format!("{:.2},{phi1:.2},{phi2:.2},29.7,31.8", 0.05 * row as f64)
        };
        text(&std::iter::once(HEADER.to_string()).chain((0..14).map(row)).collect::<Vec<_>>())
    };
    let negative =
        "rad is negative; this is the angle from palm 1 to palm 2, counter-clockwise, between 0 and pi (180 deg):";
    let at = "log.csv, line 2, column phi2_rad: -1.20";
    expect(
        &written(|phi1, phi2| (phi1, -phi2)),
        &format!("{at} {negative} phi2 is counted clockwise, so write `sign2 = -1` below `[angles]` into the rig file"),
    );
    expect(
        &written(|phi1, phi2| (-phi1, -phi2)),
        &format!(
            "{at} {negative} phi1 and phi2 are counted clockwise, so write `sign1 = -1` and `sign2 = -1` below `[angles]` into the rig file"
        ),
    );
    expect(
        &written(|phi1, phi2| (phi1 + phi2, -phi2)),
        &format!(
            "{at} {negative} the palms are swapped: palm 1 must be the one that palm 2 is counter-clockwise of, so exchange the names of s1 and s2 (and of base points and forces), and write phi1 + phi2 for phi1 and -phi2 for phi2"
        ),
    );
}

#[test]
fn good_is_good() {
    expect(&text(&good()), "accepted");
}

#[test]
fn header() {
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1_mm,pressure"),
        "log.csv, line 1: there is no column for s2; it must be named s2_m, s2_cm, s2_mm or s2_um (the header has: time_s, phi1_rad, phi2_rad, s1_mm, pressure)",
    );
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1_inch,s2_mm"),
        "log.csv, line 1, column s1_inch: the unit \"inch\" is unknown; convert the column and name it s1_m, s1_cm, s1_mm or s1_um",
    );
    expect(
        &with_line(1, "time_s,phi1_grad,phi2_rad,s1_mm,s2_mm"),
        "log.csv, line 1, column phi1_grad: the unit \"grad\" is unknown; convert the column and name it phi1_rad or phi1_deg",
    );
    expect(
        &with_line(1, "Time_min,phi1_rad,phi2_rad,s1_mm,s2_mm"),
        "log.csv, line 1, column Time_min: the unit \"min\" is unknown; convert the column and name it time_s, time_ms, time_us or time_ns",
    );
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1,s2_mm"),
        "log.csv, line 1, column s1: the name has no unit; name the column s1_m, s1_cm, s1_mm or s1_um",
    );
    expect(
        &text(
            &good()
                .iter()
                .map(|line| format!("{line},{}", if line == HEADER { "force1_kg" } else { "1" }))
                .collect::<Vec<_>>(),
        ),
        "log.csv, line 1, column force1_kg: the unit \"kg\" is unknown; convert the column and name it force1_n",
    );
    expect(
        &text(
            &good()
                .iter()
                .map(|line| format!("{line},{}", if line == HEADER { "force1_n" } else { "-0.5" }))
                .collect::<Vec<_>>(),
        ),
        "log.csv, line 2, column force1_n: -0.5 is negative; a palm only pushes: reverse the sign of the column, or leave the cell empty where the sensor drifts",
    );
    expect(
        &text(
            &good()
                .iter()
                .map(|line| format!("{line},{}", if line == HEADER { "s1_m" } else { "1" }))
                .collect::<Vec<_>>(),
        ),
        "log.csv, line 1: the header has s1 twice, as s1_mm and s1_m; remove one of the columns",
    );
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1_mm,s1_mm"),
        "log.csv, line 1: the header has s1 twice, as s1_mm and s1_mm; remove one of the columns",
    );
    expect(
        &text(&good()[1..]),
        "log.csv, line 1: there are numbers where the header should be; put a line with the column names above them, such as time_s,phi1_rad,phi2_rad,s1_m,s2_m",
    );
    expect(
        &with_line(1, "time_s phi1_rad phi2_rad s1_mm s2_mm").replace(',', " "),
        "log.csv, line 1: the column names are separated by blanks; separate names and numbers by commas, semicolons or tabs",
    );
}

#[test]
fn nothing_in_it() {
    expect("", "log.csv: the file is empty; it needs a header line with the column names and a line for each sample");
    expect(
        "\u{feff}\r\n\n",
        "log.csv: the file is empty; it needs a header line with the column names and a line for each sample",
    );
    expect(
        "# a: b\n",
        "log.csv: the file holds only comments; it needs a header line with the column names and a line for each sample",
    );
    expect(
        &text(&good()[..1]),
        "log.csv, line 1: there is only a header and no line below it; was the recording stopped before it began?",
    );
    expect(
        &text(&good()[..9]),
        "log.csv: 8 of its 8 samples have a contact on both palms, and at least 12 are needed to solve for a shape; record longer, or check the touch threshold",
    );
    expect(
        &text(&good()).replace("29.7", ""),
        "log.csv: 0 of its 14 samples have a contact on both palms, and at least 12 are needed to solve for a shape; record longer, or check the touch threshold",
    );
}

#[test]
fn cut_off_or_ragged() {
    let whole = text(&good());
    expect(
        &whole[..whole.len() - 12],
        "log.csv, line 15: the last row has 3 of 5 cells, the file looks cut off; copy it again, or delete that row",
    );
    expect(
        &with_line(4, "0.1,1.04,1.2"),
        "log.csv, line 4: the row has 3 cells, the header has 5; complete the row or delete it",
    );
    expect(
        &with_line(4, "0,10,1,04,1,22,29,7,31,8"),
        "log.csv, line 4: the row has 10 cells, the header has 5; name every column in the header, and write numbers with a decimal point, not a decimal comma",
    );
    expect(
        &with_line(4, "0.1,1.04,\"1.2,29.7,31.8"),
        "log.csv, line 4: a double quote is not closed; remove the quotes, numbers need none",
    );
}

#[test]
fn not_text() {
    assert_eq!(message(b"time_s,\0\x01\x02"), "log.csv: this is a binary file, not text; export it as CSV");
    assert_eq!(message(b"\xff\xfet\0i\0"), "log.csv: the text is encoded in UTF-16; save it as CSV in UTF-8");
    assert_eq!(
        message(b"time_s\n# gr\xf6\xdfe\n"),
        "log.csv, line 2: the text is not UTF-8; save the file as CSV in UTF-8"
    );
}

#[test]
fn dates_are_no_seconds() {
    for stamp in ["2026-01-31T12:00:00.5Z", "12:00:01", "31.01.2026 12:00:00"] {
        let said = format!(
            "\"{stamp}\" is a date or a time of day; write the seconds since the start, such as 12.5, under the name time_s"
        );
        expect(
            &with_line(3, &format!("{stamp},1.04,1.21,29.7,31.8")),
            &format!("log.csv, line 3, column time_s: {said}"),
        );
        // At once, and not only after the column has a unit.
        let log = with_line(2, &format!("{stamp},1.04,1.21,29.7,31.8")).replace("time_s", "timestamp");
        expect(&log, &format!("log.csv, line 1, column timestamp: {said}"));
    }
}

#[test]
fn cells() {
    expect(
        &with_line(3, "0.05,1.04,1.21,abc,31.8"),
        "log.csv, line 3, column s1_mm: \"abc\" is not a number; write one such as 12.5, or leave the cell empty where no contact was seen",
    );
    expect(
        &with_line(3, "0.05,1.04,\u{1b}[2J,29.7,31.8"),
        "log.csv, line 3, column phi2_rad: \"\\u{1b}[2J\" is not a number; write one such as 12.5",
    );
    expect(
        &with_line(3, &format!("0.05,{},1.21,29.7,31.8", "x".repeat(1000))),
        &format!("log.csv, line 3, column phi1_rad: \"{}…\" is not a number; write one such as 12.5", "x".repeat(40)),
    );
    expect(
        &with_line(3, "0.05,1.04,1.21,\"29,7\",31.8"),
        "log.csv, line 3, column s1_mm: \"29,7\" has a comma in a number; write it with a decimal point and without marks between thousands, or separate the columns by semicolons",
    );
    let decimal_commas = text(&good()).replace(',', ";").replace('.', ",");
    expect(&decimal_commas, "accepted");
    expect(
        &decimal_commas.replace("0,10", "0.10"),
        "log.csv, line 4, column time_s: \"0.10\" has a decimal point, unlike 0,00 in line 2; write all numbers with a decimal point and without marks between thousands",
    );
    expect(
        &text(&good()).replace(',', "\t").replace("29.7", "1,234"),
        "log.csv, line 2, column s1_mm: \"1,234\" has a decimal comma, unlike 0.00 in line 2; write all numbers with a decimal point and without marks between thousands",
    );
    expect(
        &decimal_commas.replace("29,7", "1.029,7"),
        "log.csv, line 2, column s1_mm: \"1.029,7\" has a decimal point, unlike 0,00 in line 2; write all numbers with a decimal point and without marks between thousands",
    );
    expect(
        &with_line(3, "0.05,,1.21,29.7,31.8"),
        "log.csv, line 3, column phi1_rad: the cell is empty where a number must be; fill it in, or delete the row",
    );
    expect(
        &with_line(3, "nan,1.04,1.21,29.7,31.8"),
        "log.csv, line 3, column time_s: nan stands where a number must be; fill it in, or delete the row",
    );
    expect(
        &with_line(3, "0.05,1.04,1.21,-Inf,31.8"),
        "log.csv, line 3, column s1_mm: \"-Inf\" is infinite; delete the row, or leave the cell empty where no contact was seen",
    );
    expect(
        &with_line(3, "0.05,1e999,1.21,29.7,31.8"),
        "log.csv, line 3, column phi1_rad: \"1e999\" is infinite; delete the row",
    );
}

#[test]
fn time() {
    expect(
        &with_line(5, "0.05,1.04,1.21,29.7,31.8"),
        "log.csv, line 5, column time_s: 0.05 comes after 0.10 (line 4), time decreases; sort the rows, or split the file where it starts again",
    );
    expect(
        &with_line(5, "# a comment\n0.1,1.04,1.21,29.7,31.8"),
        "log.csv, line 6, column time_s: 0.1 occurs twice, first in line 4; delete one of the two rows, or write time with more digits",
    );
}

#[test]
fn palm_angles() {
    const RANGE: &str =
        "the angle from palm 1 to palm 2 must lie between 0 and pi (180 deg), and not within 0.001 rad of either";
    expect(
        &with_line(3, "0.05,1.04,0,29.7,31.8"),
        &format!("log.csv, line 3, column phi2_rad: 0 rad makes the palms parallel; {RANGE}"),
    );
    expect(
        &with_line(3, "0.05,1.04,3.1416,29.7,31.8"),
        &format!("log.csv, line 3, column phi2_rad: 3.1416 rad makes the palms parallel; {RANGE}"),
    );
    expect(
        &with_line(3, "0.05,1.04,74.0,29.7,31.8"),
        "log.csv, line 3, column phi2_rad: 74.0 rad looks like degrees; if it is, name the column phi2_deg",
    );
    expect(
        &with_line(3, "0.05,60,1.21,29.7,31.8"),
        "log.csv, line 3, column phi1_rad: 60 rad looks like degrees; if it is, name the column phi1_deg",
    );
    expect(
        &with_line(3, "0.05,1.04,-1.21,29.7,31.8"),
        "log.csv, line 3, column phi2_rad: -1.21 rad is negative; this is the angle from palm 1 to palm 2, counter-clockwise, between 0 and pi (180 deg): reverse its sign, and that of phi1 if this is counted clockwise too; or, if palm 2 stands under the names of palm 1, exchange s1 and s2, and write phi1 + phi2 for phi1 and -phi2 for phi2",
    );
    expect(
        &with_line(3, "0.05,1.04,4,29.7,31.8"),
        "log.csv, line 3, column phi2_rad: 4 rad is out of range; the angle from palm 1 to palm 2, counter-clockwise, must lie between 0 and pi (180 deg); if it is counted from the horizontal, subtract phi1",
    );
    expect(
        &with_line(1, "time_s,phi1_deg,phi2_rad,s1_mm,s2_mm").replace(",1.04,", ",800,"),
        "log.csv, line 2, column phi1_deg: 800 deg is out of range; the angle of palm 1 against the X axis must lie within two turns",
    );
}

#[test]
fn lengths() {
    expect(
        &with_line(3, "0.05,1.04,1.21,-0.1,31.8"),
        "log.csv, line 3, column s1_mm: -0.1 mm is negative; it is the distance from the base of the palm to the contact: add how far from the base the pad begins, or leave the cell empty where no contact was seen",
    );
    expect(
        &with_line(3, "0.05,1.04,1.21,1e6,31.8"),
        "log.csv, line 3, column s1_mm: 1e6 mm is more than 2 m; correct it, or name the column s1_um if that is its unit",
    );
    // On each side of the limit; 88 in metres is an object of the size of a house.
    let in_meters = |s1: &str| with_line(1, "time_s,phi1_rad,phi2_rad,s1_m,s2_mm").replace("29.7", s1);
    expect(&in_meters("2"), "accepted");
    expect(
        &in_meters("2.1"),
        "log.csv, line 2, column s1_m: 2.1 m is more than 2 m; correct it, or name the column s1_cm, s1_mm or s1_um if that is its unit",
    );
    expect(
        &in_meters("88"),
        "log.csv, line 2, column s1_m: 88 m is more than 2 m; correct it, or name the column s1_cm, s1_mm or s1_um if that is its unit",
    );
    expect(
        &text(
            &good()
                .iter()
                .map(|line| format!("{line},{}", if line == HEADER { "s2_sd_mm" } else { "0" }))
                .collect::<Vec<_>>(),
        ),
        "log.csv, line 2, column s2_sd_mm: 0 mm is not a standard deviation, which must be above 0; omit the column if it is unknown",
    );
}

#[test]
fn sizes_that_no_palms_have() {
    let short = |s2: &str| text(&good()).replace("31.8", s2);
    expect(&short("1"), "accepted");
    expect(
        &short("0.0318"),
        "log.csv, line 1, column s2_mm: no contact is more than 0.0318 mm from the base of its palm, and palms shorter than 1 mm feel nothing; correct the column, or name the column s2_m or s2_cm if that is its unit",
    );
    // One contact far enough out is enough.
    expect(&short("0.9").replacen(",0.9\n", ",1.1\n", 1), "accepted");

    let opening = |widest: &str| {
        with_line(1, "time_s,phi1_rad,phi2_deg,s1_mm,s2_mm")
            .replace(",1.", &format!(",{widest}"))
            .replace(&format!(",{widest}04,"), ",1.04,")
    };
    expect(&opening("3.2"), "accepted");
    expect(
        &opening("1."),
        "log.csv, line 1, column phi2_deg: the palms never open wider than 1.33 deg, too little for an object between them; correct the column, or name the column phi2_rad if that is its unit",
    );
    expect(
        &text(&good()).replace(",1.2", ",0.02").replace(",1.3", ",0.03"),
        "log.csv, line 1, column phi2_rad: the palms never open wider than 0.033 rad, too little for an object between them; correct the column",
    );
}

#[test]
fn times_that_no_log_has() {
    let with_times = |unit: &str, time: fn(usize) -> f64| {
        let rows = (0..14).map(|row| format!("{},1.04,1.2,29.7,31.8\n", time(row)));
        format!("time_{unit},phi1_rad,phi2_rad,s1_mm,s2_mm\n{}", rows.collect::<String>())
    };
    // Thirteen steps; on each side of eleven days and a half.
    expect(&with_times("s", |row| 1e6 / 13.0 * row as f64 * 0.999), "accepted");
    expect(
        &with_times("s", |row| 1e9 * row as f64),
        "log.csv, line 1, column time_s: the log lasts 13000000000 s, more than 1000000 s; correct the times, or split the log, or name the column time_ms, time_us or time_ns if that is its unit",
    );
    expect(
        &with_times("s", |row| 1e5 * row as f64),
        "log.csv, line 1, column time_s: the log lasts 1300000 s, more than 1000000 s; correct the times, or split the log, or name the column time_ms, time_us or time_ns if that is its unit",
    );
    expect(&with_times("us", |row| 101.0 * row as f64), "accepted");
    expect(
        &with_times("us", |row| 99.0 * row as f64),
        "log.csv, line 1, column time_us: the samples follow each other every 99 us, more than 10000 per second; correct the times, or name the column time_s or time_ms if that is its unit",
    );
    expect(&with_times("ns", |row| 5e7 * row as f64), "accepted");
}

#[test]
fn base_points_too_far_apart() {
    let with_base = |unit: &str, x1: f64, x2: f64| {
        let add = |line: &String| {
            let cells = if line == HEADER { format!("base1_x_{unit},base2_x_{unit}") } else { format!("{x1},{x2}") };
            format!("{line},{cells}")
        };
        text(&good().iter().map(add).collect::<Vec<_>>())
    };
    expect(&with_base("m", 50.0, 51.9), "accepted");
    expect(
        &with_base("m", 25.0, -25.5),
        "log.csv, line 2, column base2_x_m: the base points of the palms are 50.5 m apart, more than 2 m; correct them, or name the column base2_x_cm, base2_x_mm or base2_x_um if that is its unit",
    );
    expect(
        &with_base("m", 101.0, 101.0),
        "log.csv, line 2, column base1_x_m: 101 m is more than 100 m; correct it, or name the column base1_x_cm, base1_x_mm or base1_x_um if that is its unit",
    );
}

#[test]
fn all_missing_columns_are_told_at_once() {
    // One without a unit is told with the others.
    expect(
        &with_line(1, "time,phi1_rad,phi2_grad,pos,s2_mm"),
        "log.csv, line 1: there are no columns for time, phi2 and s1; they must be named time_s, time_ms, time_us or time_ns (did you mean time?), and phi2_rad or phi2_deg (did you mean phi2_grad?), and s1_m, s1_cm, s1_mm or s1_um (the header has: time, phi1_rad, phi2_grad, pos, s2_mm)",
    );
    expect(
        &with_line(1, "t [s],phi1_rad,phi_2_rad,pos,s2_mm"),
        "log.csv, line 1: there are no columns for time, phi2 and s1; they must be named time_s, time_ms, time_us or time_ns (did you mean t [s]?), and phi2_rad or phi2_deg (did you mean phi_2_rad?), and s1_m, s1_cm, s1_mm or s1_um (the header has: t [s], phi1_rad, phi_2_rad, pos, s2_mm)",
    );
}

#[test]
fn separators() {
    expect(
        &format!("sep=|\n{}", text(&good()).replace(',', "|")),
        "log.csv, line 1: the columns are said to be separated by \"|\"; separate them by commas, semicolons or tabs",
    );
    let wide = vec!["x"; 5000].join(",");
    expect(&wide, "log.csv, line 1: the line has 5000 cells, more than 4096; is it a log?");
    expect(
        &(HEADER.to_string() + &",".repeat(4091)),
        "log.csv, line 1: there is only a header and no line below it; was the recording stopped before it began?",
    );
}

#[test]
fn compressed_files() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join("log.csv.gz");
    let compressed = |bytes: &[u8]| {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).expect("into memory");
        encoder.finish().expect("into memory")
    };
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).expect("a file for the test");
        read_log(&path).map_err(|error| error.to_string().replace(&path.display().to_string(), "log.csv.gz"))
    };
    let whole = compressed(text(&good()).as_bytes());
    assert_eq!(
        read(&whole).map(|file| file.log),
        parse_log("log.csv", text(&good()).as_bytes()).map(|file| file.log).map_err(|_| String::new())
    );
    let damaged =
        "log.csv.gz: the gzip file is damaged or cut off; copy it again, or unpack what is left of it with gunzip";
    assert_eq!(read(&whole[..whole.len() - 9]), Err(damaged.to_string()));
    assert_eq!(read(b"\x1f\x8b and more"), Err(damaged.to_string()));
    // A bomb: half a megabyte that unpacks to more than there is memory for in a small machine.
    let bomb = compressed(&vec![b' '; 128 * 1024 * 1024 + 1]);
    assert_eq!(
        read(&bomb),
        Err("log.csv.gz: the compressed file holds more than 128 MiB; split the log, or log at a lower rate"
            .to_string())
    );
}

#[test]
fn no_file() {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let message = |path: &Path| read_log(path).expect_err("there is no log").to_string();
    let missing = folder.path().join("log.csv");
    assert_eq!(message(&missing), format!("{}: no such file; check the path", missing.display()));
    assert_eq!(
        message(folder.path()),
        format!("{}: this is a folder; give the CSV file in it", folder.path().display())
    );
}

#[test]
fn file_name_cannot_break_the_terminal() {
    let error = parse_log("a\u{1b}[2J\n.csv", b"").expect_err("it is empty").to_string();
    assert!(error.starts_with("a\\u{1b}[2J\\n.csv: "), "{error}");
}

/// The columns of [`good`], with one changed.
fn columns(changed: &str, change: impl Fn(usize, String) -> String) -> Vec<(String, Vec<String>)> {
    let lines = good();
    let cells = |column: usize| lines.iter().skip(1).filter_map(move |line| line.split(',').nth(column));
    HEADER
        .split(',')
        .enumerate()
        .map(|(column, name)| {
            let cell =
                |(row, cell): (usize, &str)| if name == changed { change(row, cell.into()) } else { cell.into() };
            (name.to_owned(), cells(column).enumerate().map(cell).collect())
        })
        .collect()
}

#[test]
fn columns_in_memory_follow_the_same_rules() {
    let from_file = parse_log("log.csv", text(&good()).as_bytes()).expect("a good log");
    assert_eq!(log_from_columns("columns", &columns("", |_, cell| cell)), Ok(from_file));

    let message =
        |columns: &[(String, Vec<String>)]| log_from_columns("columns", columns).expect_err("bad").to_string();
    // Rows count from 0.
    assert_eq!(
        message(&columns("s1_mm", |row, cell| if row == 3 { "wet".into() } else { cell })),
        "columns, line 3, column s1_mm: \"wet\" is not a number; write one such as 12.5, or leave the cell empty where no contact was seen"
    );
    let mut short = columns("", |_, cell| cell);
    short[4].1.pop();
    assert_eq!(
        message(&short),
        "columns, column s2_mm: the column has 13 values, the first one has 14; give one value for each sample"
    );
    short[4].0 = "s2".into();
    short[4].1.push("30".into());
    // A header in memory has no line.
    assert_eq!(
        message(&short),
        "columns, column s2: the name has no unit; name the column s2_m, s2_cm, s2_mm or s2_um"
    );
    assert!(
        message(&[])
            .starts_with("columns: there are no columns for time, phi1, phi2, s1 and s2; they must be named time_s")
    );
}
