//! `cargo xtask paper`: the figures of the paper by `palpate paper`, and the table of their errors, in the documentation.
//!
//! The test of `palpate paper` compares the documented table with the errors that the program gives.

use std::fs;

use anyhow::{Context, bail};

use crate::studies::tables::{self, Write};
use crate::workspace;

/// Pictures in the documentation, and the figures that they show.
const PICTURES: [(&str, &str); 5] = [
    ("paper-figure-3.png", "figure-3-frames.png"),
    ("paper-figure-6.png", "figure-6-palms-ode.png"),
    ("paper-figure-7.png", "figure-7-palms-ode.png"),
    ("paper-figure-8.png", "figure-8-ode.png"),
    ("paper-figure-9.png", "figure-9-pivoting-grasp.png"),
];

const COMMAND: &str = "cargo xtask paper";

/// Options of `cargo xtask paper`.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(flatten)]
    write: Write,
}

/// Makes the figures under the target folder and prints the table.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.write.check(&[tables::PAPER])?;
    let folder = workspace::target().join("paper");
    let mut program = workspace::cargo();
    program.args(["run", "--release", "--quiet", "--package", "palpate-cli", "--", "paper", "--out"]).arg(&folder);
    workspace::run(&mut program)?;
    let table = table(&fs::read_to_string(folder.join("errors.csv"))?)?;
    println!("{table}");
    arguments.write.tables(&[(tables::PAPER, table)], COMMAND)?;
    if let Some(root) = arguments.write.root() {
        for (picture, figure) in PICTURES {
            workspace::copy(&folder.join(figure), &root.join("docs/images").join(picture))?;
        }
    }
    Ok(())
}

/// The errors as a table to read: millimetres, degrees, three digits.
fn table(csv: &str) -> anyhow::Result<String> {
    let mut rows = csv.lines();
    let header = "log,method,rms_r_m,hausdorff_m,rms_psi_rad,rms_com_m,rms_contact_vector_m,certified";
    if rows.next() != Some(header) {
        bail!("errors.csv has other columns than {header}");
    }
    let mut lines = vec![
        "| log | method | RMS shape (mm) | Hausdorff (mm) | RMS orientation (deg) | RMS centre of mass (mm) | RMS contact vector (mm) | certified |".to_owned(),
        "|---|---|---:|---:|---:|---:|---:|---|".to_owned(),
    ];
    for row in rows {
        let cells: Vec<&str> = row.split(',').collect();
        let [log, method, numbers @ .., certified] = cells.as_slice() else {
            bail!("a row of errors.csv is short: {row}")
        };
        let numbers: Vec<f64> =
            numbers.iter().map(|number| number.parse()).collect::<Result<_, _>>().context(row.to_owned())?;
        let [shape_m, hausdorff_m, psi_rad, com_m, vector_m] = numbers[..] else {
            bail!("a row of errors.csv is short: {row}")
        };
        let shown =
            [1e3 * shape_m, 1e3 * hausdorff_m, psi_rad.to_degrees(), 1e3 * com_m, 1e3 * vector_m].map(three_digits);
        lines.push(format!("| {log} | {method} | {} | {certified} |", shown.join(" | ")));
    }
    Ok(lines.join("\n"))
}

/// Three significant digits.
fn three_digits(value: f64) -> String {
    match value.abs().log10().floor() {
        magnitude if (-4.0..3.0).contains(&magnitude) => format!("{value:.0$}", (2.0 - magnitude).max(0.0) as usize),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_become_a_table_to_read() {
        let csv = "log,method,rms_r_m,hausdorff_m,rms_psi_rad,rms_com_m,rms_contact_vector_m,certified\n\
                   palms,ode,3.85e-4,5.67e-4,4.5e-2,6.41e-4,1.1849e-3,no\n";
        let table = table(csv).expect("a table");
        assert!(table.ends_with("| palms | ode | 0.385 | 0.567 | 2.58 | 0.641 | 1.18 | no |"), "{table}");
        assert!(super::table("a,b\n1,2\n").is_err());
        assert_eq!([0.0351, 1e-12, 88.04, 123.4].map(three_digits), ["0.0351", "1.00e-12", "88.0", "123"]);
    }
}
