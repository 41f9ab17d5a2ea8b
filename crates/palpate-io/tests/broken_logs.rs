//! Logs broken at random: never a panic, always one paragraph that names the file.

use palpate_io::parse_log;
use proptest::collection::vec;
use proptest::prelude::*;

/// One way to break a file.
#[derive(Clone, Debug)]
enum Damage {
    FlipByte(usize, u8),
    InsertBytes(usize, Vec<u8>),
    DeleteLine(usize),
    DoubleLine(usize),
    SwapLines(usize, usize),
    SwapCells(usize, usize, usize),
    ReplaceCell(usize, usize, String),
    CutAt(usize),
}

fn odd_cell() -> impl Strategy<Value = String> {
    let odd = [
        "1e308",
        "-1e308",
        "1e309",
        "1e-320",
        "5e-324",
        "-0",
        "0",
        "",
        " ",
        "NaN",
        "-nan",
        "inf",
        "-Infinity",
        "1,5",
        "\"",
        "\"\"\"",
        "#",
        "1e",
        "0x10",
        "٣",
        "\u{feff}",
        "\u{0}",
        "\t",
        ";",
        "1_000",
        "+.5",
        "time_s",
        "s1_inch",
        "é",
        "3.141592653589793",
        "1e400",
    ];
    prop_oneof![
        prop::sample::select(odd.to_vec()).prop_map(str::to_string),
        any::<f64>().prop_map(|value| format!("{value:?}")),
        "\\PC{0,8}",
    ]
}

fn damage() -> impl Strategy<Value = Damage> {
    let place = || 0..10_000_usize;
    prop_oneof![
        (place(), any::<u8>()).prop_map(|(at, byte)| Damage::FlipByte(at, byte)),
        (place(), vec(any::<u8>(), 0..6)).prop_map(|(at, bytes)| Damage::InsertBytes(at, bytes)),
        place().prop_map(Damage::DeleteLine),
        place().prop_map(Damage::DoubleLine),
        (place(), place()).prop_map(|(first, second)| Damage::SwapLines(first, second)),
        (place(), place(), place()).prop_map(|(line, first, second)| Damage::SwapCells(line, first, second)),
        (place(), place(), odd_cell()).prop_map(|(line, cell, text)| Damage::ReplaceCell(line, cell, text)),
        place().prop_map(Damage::CutAt),
    ]
}

fn good() -> Vec<u8> {
    let mut text =
        String::from("# object: egg\ntime_s,phi1_rad,phi2_deg,s1_mm,s2_m,s1_sd_mm,base2_x_cm,force1_n,extra\n");
    for row in 0..16 {
        text += &format!("{:.2},1.0{row},74.{row},29.{row},0.031{row},0.1,2.5,1.5,x\n", 0.05 * row as f64);
    }
    text.into_bytes()
}

fn edit_lines(bytes: &[u8], edit: impl FnOnce(&mut Vec<Vec<u8>>)) -> Vec<u8> {
    let mut lines: Vec<Vec<u8>> = bytes.split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
    edit(&mut lines);
    lines.join(&b'\n')
}

fn edit_cells(bytes: &[u8], line: usize, edit: impl FnOnce(&mut Vec<Vec<u8>>)) -> Vec<u8> {
    edit_lines(bytes, |lines| {
        let line = line % lines.len();
        let mut cells: Vec<Vec<u8>> = lines[line].split(|&byte| byte == b',').map(<[u8]>::to_vec).collect();
        edit(&mut cells);
        lines[line] = cells.join(&b',');
    })
}

fn apply(mut bytes: Vec<u8>, damage: Damage) -> Vec<u8> {
    match damage {
        Damage::FlipByte(at, byte) => {
            let at = at % bytes.len().max(1);
            bytes.iter_mut().skip(at).take(1).for_each(|found| *found = byte);
            bytes
        }
        Damage::InsertBytes(at, inserted) => {
            let at = at % (bytes.len() + 1);
            bytes.splice(at..at, inserted);
            bytes
        }
        Damage::DeleteLine(line) => edit_lines(&bytes, |lines| {
            lines.remove(line % lines.len());
        }),
        Damage::DoubleLine(line) => edit_lines(&bytes, |lines| {
            let line = line % lines.len();
            lines.insert(line, lines[line].clone());
        }),
        Damage::SwapLines(first, second) => edit_lines(&bytes, |lines| {
            let count = lines.len();
            lines.swap(first % count, second % count);
        }),
        Damage::SwapCells(line, first, second) => edit_cells(&bytes, line, |cells| {
            let count = cells.len();
            cells.swap(first % count, second % count);
        }),
        Damage::ReplaceCell(line, cell, text) => edit_cells(&bytes, line, |cells| {
            let cell = cell % cells.len();
            cells[cell] = text.into_bytes();
        }),
        Damage::CutAt(at) => {
            bytes.truncate(at % (bytes.len() + 1));
            bytes
        }
    }
}

/// A good log passes as usable; a bad one is told in one printable paragraph.
fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    match parse_log("dir/log.csv", bytes) {
        Ok(file) => {
            let samples = &file.log.samples;
            prop_assert!(samples.len() >= palpate_io::MIN_SAMPLES);
            prop_assert!(samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
            for sample in samples {
                let always = [sample.time_s, sample.palms.phi1_rad, sample.palms.phi2_rad];
                let sometimes =
                    [sample.s1_m, sample.s2_m, sample.s1_sd_m, sample.s2_sd_m, sample.force1_n, sample.force2_n];
                let bases = [sample.palms.base1_m, sample.palms.base2_m].concat();
                prop_assert!(
                    always.into_iter().chain(sometimes.into_iter().flatten()).chain(bases).all(f64::is_finite)
                );
                prop_assert!(sample.palms.phi2_rad.sin() > 9e-4);
                prop_assert!(sample.s1_m.into_iter().chain(sample.s2_m).all(|s| (0.0..=2.0).contains(&s)));
                prop_assert!(sample.s1_sd_m.into_iter().chain(sample.s2_sd_m).all(|sd| sd > 0.0));
            }
            for note in &file.notes {
                prop_assert!(!note.chars().any(char::is_control), "{note:?}");
            }
        }
        Err(error) => {
            let message = error.to_string();
            prop_assert!(message.starts_with("dir/log.csv"), "{message:?}");
            let length = message.chars().count();
            prop_assert!(length > "dir/log.csv: ".len() && length < 1500, "{message:?}");
            prop_assert!(!message.chars().any(char::is_control), "{message:?}");
            prop_assert!(error.line.is_none_or(|line| line >= 1));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in vec(any::<u8>(), 0..400)) {
        check(&bytes)?;
    }

    #[test]
    fn random_text_of_spreadsheets(text in "(sep=[;,|\t]\n)?[-+0-9.,;\t\n\"\\[\\]()°µ timephs_]{0,200}") {
        check(text.as_bytes())?;
    }

    #[test]
    fn random_text(text in "[-+0-9.,;\t\r\n\"#einfNaN_ ]{0,200}") {
        check(text.as_bytes())?;
    }

    #[test]
    fn a_good_log_damaged(damages in vec(damage(), 1..5)) {
        check(&damages.into_iter().fold(good(), apply))?;
    }
}

#[test]
fn the_good_log_is_good() {
    parse_log("log.csv", &good()).unwrap_or_else(|error| panic!("{error}"));
}
