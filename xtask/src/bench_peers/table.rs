//! The comparison as a Markdown table for people and as JSON for programs.

use std::fs;
use std::path::Path;

use anyhow::Context;

use super::row::Row;

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
