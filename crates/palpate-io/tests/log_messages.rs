//! Every way in which a palm log can be wrong, with the whole message that the user sees.

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
        "log.csv, line 1: there is no column for s2; it must be named s2_m, s2_cm or s2_mm (the header has: time_s, phi1_rad, phi2_rad, s1_mm, pressure)",
    );
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1_inch,s2_mm"),
        "log.csv, line 1, column s1_inch: the unit \"inch\" is unknown; convert the column and name it s1_m, s1_cm or s1_mm",
    );
    expect(
        &with_line(1, "time_s,phi1_grad,phi2_rad,s1_mm,s2_mm"),
        "log.csv, line 1, column phi1_grad: the unit \"grad\" is unknown; convert the column and name it phi1_rad or phi1_deg",
    );
    expect(
        &with_line(1, "Time_min,phi1_rad,phi2_rad,s1_mm,s2_mm"),
        "log.csv, line 1, column Time_min: the unit \"min\" is unknown; convert the column and name it time_s or time_ms",
    );
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1,s2_mm"),
        "log.csv, line 1, column s1: the name has no unit; name the column s1_m, s1_cm or s1_mm",
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
        &text(&good()).replace(',', ";").replace('.', ","),
        "log.csv, line 2, column time_s: \"0,00\" has a comma in a number; write it with a decimal point and without marks between thousands",
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
        "log.csv, line 3, column s1_mm: 1e6 mm is more than 100 m; correct it",
    );
    expect(
        &with_line(1, "time_s,phi1_rad,phi2_rad,s1_m,s2_m").replace("29.7", "129.7"),
        "log.csv, line 2, column s1_m: 129.7 m is more than 100 m; correct it, or name the column s1_mm if it is in millimetres",
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
    assert_eq!(message(&short), "columns, column s2: the name has no unit; name the column s2_m, s2_cm or s2_mm");
    assert!(message(&[]).starts_with("columns: there is no column for time"));
}
