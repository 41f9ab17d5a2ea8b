//! The comparison as a Markdown table for people and as JSON for programs.

use std::fs;
use std::path::Path;

use anyhow::Context;

use super::row::{NOBODY, Row};

/// Writes `peers.md` and `peers.json`.
pub fn save(rows: &[Row], folder: &Path) -> anyhow::Result<()> {
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        fs::write(&path, text + "\n").with_context(|| path.display().to_string())
    };
    write("peers.md", markdown(rows))?;
    write("peers.json", serde_json::to_string_pretty(rows)?)
}

/// The table.
pub fn markdown(rows: &[Row]) -> String {
    let mut lines = vec![
        "| job | N | K | peer | palpate (s) | peer (s) | ratio | agreement |".to_owned(),
        "|---|---:|---:|---|---:|---:|---:|---|".to_owned(),
    ];
    lines.extend(rows.iter().map(|row| {
        let count = |count: Option<usize>| count.map(|count| count.to_string()).unwrap_or_default();
        let number = |value: Option<f64>| value.map(digits).unwrap_or_default();
        format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} |",
            row.job,
            count(row.n),
            count(row.k),
            row.peer,
            number(row.palpate_s),
            number(row.peer_s),
            number(row.ratio),
            row.agreement.replace('|', "\\|").replace('\n', " "),
        )
    }));
    lines.join("\n")
}

/// The rows of smoothing with all peers beside each other: a line for each size, palpate's time that of its turns with the first
/// peer, and each ratio that of its own turns.
pub fn smoothing(rows: &[Row]) -> String {
    // What has no size is a remark, and what has no peer is palpate alone.
    let compared = || rows.iter().filter_map(|row| Some((row.n?, row.k?, row))).filter(|(.., row)| row.peer != NOBODY);
    let mut peers: Vec<&str> = Vec::new();
    let mut sizes: Vec<(usize, usize)> = Vec::new();
    for (n, k, row) in compared() {
        if !peers.contains(&row.peer.as_str()) {
            peers.push(&row.peer);
        }
        if !sizes.contains(&(n, k)) {
            sizes.push((n, k));
        }
    }
    let mut lines = vec![
        peers
            .iter()
            .fold("| N | K | palpate (ms) |".to_owned(), |line, peer| line + &format!(" {peer} (ms) | ratio |")),
        "|---:|---:|---:|".to_owned() + &"---:|---:|".repeat(peers.len()),
    ];
    for (n, k) in sizes {
        let of =
            |peer: &str| compared().find(|(a, b, row)| (*a, *b) == (n, k) && row.peer == peer).map(|(.., row)| row);
        let ms = |seconds: Option<f64>| seconds.map(|seconds| digits(1e3 * seconds)).unwrap_or_default();
        let palpate_s = peers.iter().find_map(|peer| of(peer)?.palpate_s);
        let mut line = format!("| {} | {k} | {} |", thousands(n), ms(palpate_s));
        for peer in &peers {
            let ratio = match of(peer) {
                Some(Row { ratio: Some(ratio), .. }) => digits(*ratio),
                Some(Row { peer_s: Some(_), .. }) => "another optimum".to_owned(),
                Some(_) => "failed".to_owned(),
                None => String::new(),
            };
            line += &format!(" {} | {ratio} |", ms(of(peer).and_then(|row| row.peer_s)));
        }
        lines.push(line);
    }
    lines.join("\n")
}

/// A number with a space between thousands, from five digits on.
fn thousands(number: usize) -> String {
    if number < 10_000 { number.to_string() } else { format!("{} {:03}", thousands(number / 1000), number % 1000) }
}

/// Three significant digits.
fn digits(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    let decimals = if magnitude.is_finite() { (2.0 - magnitude).clamp(0.0, 9.0) } else { 0.0 };
    format!("{value:.0$}", decimals as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench_peers::row::Agreement;
    use crate::bench_peers::turns::Medians;

    fn rows() -> [Row; 3] {
        let medians = Medians { palpate_s: 0.001234, peer_s: 0.1234 };
        let agreement = |holds, text: &str| Agreement { holds, text: text.to_owned() };
        let size = (Some(300), Some(8));
        [
            Row::compared("smoothing", size, "Ceres", medians, agreement(true, "cost 1e-9")),
            Row::compared("smoothing", size, "SciPy", medians, agreement(false, "cost 0.2: |not| the optimum")),
            Row::remark("smoothing", "GTSAM", "cannot be\ninstalled"),
        ]
    }

    #[test]
    fn the_table_gives_no_ratio_to_a_wrong_answer() {
        let text = markdown(&rows());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[2], "| smoothing | 300 | 8 | Ceres | 0.00123 | 0.123 | 100 | cost 1e-9 |");
        assert_eq!(lines[3], "| smoothing | 300 | 8 | SciPy | 0.00123 | 0.123 |  | cost 0.2: \\|not\\| the optimum |");
        assert_eq!(lines[4], "| smoothing |  |  | GTSAM |  |  |  | cannot be installed |");
    }

    #[test]
    fn smoothing_has_a_line_for_each_size() {
        let alone = Row { n: Some(1_000_000), k: Some(8), ..Row::remark("smoothing", NOBODY, "alone") };
        let medians = Medians { palpate_s: 0.0039, peer_s: 0.109 };
        let agreement = Agreement { holds: true, text: String::new() };
        let larger = Row::compared("smoothing", (Some(10_000), Some(8)), "Ceres", medians, agreement);
        let text = smoothing(&[rows().as_slice(), &[larger, alone]].concat());
        let expected = "| N | K | palpate (ms) | Ceres (ms) | ratio | SciPy (ms) | ratio |\n\
                        |---:|---:|---:|---:|---:|---:|---:|\n\
                        | 300 | 8 | 1.23 | 123 | 100 | 123 | another optimum |\n\
                        | 10 000 | 8 | 3.90 | 109 | 27.9 |  |  |";
        assert_eq!(text, expected);
    }

    #[test]
    fn json_has_the_same_rows() {
        let folder = std::env::temp_dir().join(format!("palpate-peers-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder");
        save(&rows(), &folder).expect("it can be written");
        let text = fs::read_to_string(folder.join("peers.json")).expect("it was written");
        fs::remove_dir_all(&folder).expect("it can be removed");
        let read: serde_json::Value = serde_json::from_str(&text).expect("it is JSON");
        assert_eq!(read[0]["n"], 300);
        assert_eq!(read[0]["ratio"].as_f64().map(f64::round), Some(100.0));
        assert!(read[1]["ratio"].is_null());
        assert_eq!(read[2]["agreement"], "cannot be\ninstalled");
    }
}
