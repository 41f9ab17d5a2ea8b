//! The trials of a study row by row, as CSV, and `cargo xtask compare-rows`, which tells where two versions differ.
//!
//! Nothing in a row depends on when or where it was made, so rows of two versions of the estimator can be laid side by side.

use std::collections::{BTreeMap, HashMap};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use palpate_sweep::Outcome;
use palpate_sweep::columns::{Values, columns};

/// Numbers closer than this, relative to the larger, are the same.
const SAME: f64 = 1e-9;

/// Columns that say which trial a row is.
const KEY: [&str; 6] = ["seed", "motion", "noise_sd_m", "counts_per_inch", "angle_noise_sd_rad", "dropout"];

/// Columns that are a verdict.
const VERDICTS: [&str; 3] = ["certified", "com_certified", "wrong"];

/// The place of a row in its study, which another choice of trials changes.
const NUMBER: &str = "job";

/// Options of `cargo xtask compare-rows`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rows of `cargo xtask monte-carlo --csv`
    a: PathBuf,
    /// Rows of the same trials by another version
    b: PathBuf,
}

/// Writes a row for each outcome, numbers with all their digits.
pub fn write(path: &Path, outcomes: &[Outcome]) -> anyhow::Result<()> {
    palpate_io::write_whole(path, csv(outcomes).as_bytes())?;
    Ok(())
}

fn csv(outcomes: &[Outcome]) -> String {
    let (names, cells): (Vec<&str>, Vec<Vec<String>>) =
        columns(outcomes).map(|(name, values)| (name, cells(values))).unzip();
    let mut text = names.join(",") + "\n";
    for row in 0..outcomes.len() {
        let line: Vec<String> = cells.iter().map(|column| quoted(&column[row])).collect();
        text += &(line.join(",") + "\n");
    }
    text
}

/// The values of a column as text; none is empty.
fn cells(values: Values<'_>) -> Vec<String> {
    fn all<T: ToString>(values: Vec<T>) -> Vec<String> {
        values.iter().map(T::to_string).collect()
    }
    fn maybe<T: ToString>(values: Vec<Option<T>>) -> Vec<String> {
        values.iter().map(|value| value.as_ref().map(T::to_string).unwrap_or_default()).collect()
    }
    match values {
        Values::Counts(values) => all(values),
        Values::MaybeCounts(values) => maybe(values),
        // The shortest text that is read back as the same number.
        Values::Numbers(values) => values.iter().map(|v| v.map(|v| format!("{v:?}")).unwrap_or_default()).collect(),
        Values::Flags(values) => all(values),
        Values::MaybeFlags(values) => maybe(values),
        Values::Texts(values) => all(values),
        Values::MaybeTexts(values) => maybe(values),
    }
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

/// A table: names of its columns, and rows of as many cells.
#[derive(Debug, PartialEq)]
struct Rows {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Rows {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
        Self::parse(&text).with_context(|| path.display().to_string())
    }

    fn parse(text: &str) -> anyhow::Result<Self> {
        let mut rows: Vec<Vec<String>> = vec![vec![String::new()]];
        let mut in_quotes = false;
        let mut characters = text.chars().peekable();
        while let Some(character) = characters.next() {
            let row = rows.last_mut().context("no row")?;
            let cell = row.last_mut().context("no cell")?;
            match character {
                '"' if in_quotes && characters.peek() == Some(&'"') => cell.extend(characters.next()),
                '"' => in_quotes = !in_quotes,
                ',' if !in_quotes => row.push(String::new()),
                '\r' if !in_quotes => {}
                '\n' if !in_quotes => rows.push(vec![String::new()]),
                _ => cell.push(character),
            }
        }
        rows.retain(|row| row.len() > 1);
        if rows.is_empty() {
            bail!("there is no table");
        }
        let names = rows.remove(0);
        if let Some(index) = rows.iter().position(|row| row.len() != names.len()) {
            bail!("row {}: {} cells, but there are {} columns", index + 1, rows[index].len(), names.len());
        }
        if let Some(missing) = KEY.iter().find(|name| !names.iter().any(|other| other == *name)) {
            bail!("there is no column {missing}");
        }
        Ok(Self { names, rows })
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|other| other == name)
    }

    /// The rows by what tells them apart; the second of the same trial has a number of its own.
    fn by_trial(&self) -> BTreeMap<(Vec<String>, usize), &[String]> {
        let mut seen: HashMap<Vec<String>, usize> = HashMap::new();
        let key = |row: &[String]| -> Vec<String> {
            KEY.iter().filter_map(|name| self.column(name)).map(|column| row[column].clone()).collect()
        };
        let mut rows = BTreeMap::new();
        for row in &self.rows {
            let key = key(row);
            let times = seen.entry(key.clone()).or_default();
            rows.insert((key, *times), row.as_slice());
            *times += 1;
        }
        rows
    }
}

/// What two tables have that differs.
#[derive(Debug, Default, PartialEq)]
struct Difference {
    /// A line for each row that differs.
    lines: Vec<String>,
    /// Trials in both tables, in the first alone, in the second alone.
    trials: [usize; 3],
    /// Rows that differ, by column.
    columns: BTreeMap<String, usize>,
    /// Rows with another verdict.
    verdicts: usize,
    /// Columns that only one table has.
    only_one_has: Vec<String>,
}

impl Difference {
    fn of(a: &Rows, b: &Rows) -> Self {
        let mut difference = Self::default();
        let mut shared = Vec::new();
        for (place, name) in a.names.iter().enumerate().filter(|(_, name)| *name != NUMBER) {
            match b.column(name) {
                Some(other) => shared.push((name, place, other)),
                None => difference.only_one_has.push(name.clone()),
            }
        }
        difference.only_one_has.extend(b.names.iter().filter(|name| a.column(name).is_none()).cloned());
        let (of_a, of_b) = (a.by_trial(), b.by_trial());
        difference.trials[1] = of_a.keys().filter(|key| !of_b.contains_key(*key)).count();
        difference.trials[2] = of_b.keys().filter(|key| !of_a.contains_key(*key)).count();
        for (key, row) in &of_a {
            let Some(other) = of_b.get(key) else { continue };
            difference.trials[0] += 1;
            let cells = shared.iter().map(|&(name, here, there)| (name, &row[here], &other[there]));
            let differing: Vec<_> = cells.filter(|(_, one, two)| !same(one, two)).collect();
            if differing.is_empty() {
                continue;
            }
            let named = KEY.iter().zip(&key.0).filter(|(_, value)| !value.is_empty() && *value != "0.0");
            let mut line = named.map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(" ");
            for (place, (name, one, two)) in differing.iter().enumerate() {
                let mark = if place == 0 { ":" } else { "," };
                // A string takes everything.
                let _ = write!(line, "{mark} {name} {} -> {}", shown(one), shown(two));
                *difference.columns.entry((*name).clone()).or_default() += 1;
            }
            difference.verdicts +=
                usize::from(differing.iter().any(|(name, ..)| VERDICTS.iter().any(|verdict| name == verdict)));
            difference.lines.push(line);
        }
        difference
    }

    fn summary(&self) -> String {
        let [both, first, second] = self.trials;
        let mut text = format!("{both} trials in both: {} differ", self.lines.len());
        if !self.columns.is_empty() {
            let counts: Vec<String> = self.columns.iter().map(|(name, count)| format!("{name} {count}")).collect();
            text += &format!(" ({})", counts.join(", "));
        }
        text += &format!(", the verdict in {}", self.verdicts);
        if first + second > 0 {
            text += &format!("; {first} trials in the first alone, {second} in the second alone");
        }
        if !self.only_one_has.is_empty() {
            text += &format!("; not compared: {}", self.only_one_has.join(", "));
        }
        text
    }
}

fn same(a: &str, b: &str) -> bool {
    if a == b {
        return true;
    }
    match (a.parse::<f64>(), b.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= SAME * a.abs().max(b.abs()),
        _ => false,
    }
}

fn shown(cell: &str) -> String {
    match cell {
        "" => "none".to_owned(),
        cell if cell.contains(' ') => format!("{cell:?}"),
        cell => cell.to_owned(),
    }
}

/// Prints the rows that differ, and fails where a verdict does.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let difference = Difference::of(&Rows::read(&arguments.a)?, &Rows::read(&arguments.b)?);
    for line in &difference.lines {
        println!("{line}");
    }
    println!("{}", difference.summary());
    if difference.trials[0] == 0 {
        bail!("no trial is in both tables");
    }
    if difference.verdicts > 0 {
        bail!("the verdict differs in {} of {} trials", difference.verdicts, difference.trials[0]);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use palpate_sweep::Row;

    use super::*;

    fn outcomes() -> Vec<Outcome> {
        let row = |seed, rms_r_m, certified, reason: &str| Row {
            seed: Some(seed),
            motion: Some("random".to_owned()),
            noise_sd_m: Some(1e-4),
            angle_noise_sd_rad: Some(0.0),
            rms_r_m: Some(rms_r_m),
            certified,
            wrong: Some(false),
            reason: reason.to_owned(),
            ..Row::default()
        };
        let rows = [row(1, 1.0 / 3.0, true, ""), row(2, 1e-6, false, "one, \"two\"\nthree"), row(3, 2e-6, true, "")];
        rows.map(|row| Outcome { row, reconstruct_s: Some(1.5), job_s: 2.5 }).to_vec()
    }

    fn parsed(outcomes: &[Outcome]) -> Rows {
        Rows::parse(&csv(outcomes)).expect("what was written can be read")
    }

    #[test]
    fn what_is_written_is_read_back_to_the_last_bit() {
        let rows = parsed(&outcomes());
        assert_eq!(rows.rows.len(), 3);
        let cell = |row: usize, name| rows.rows[row][rows.column(name).expect("a column")].as_str();
        assert_eq!(cell(0, "rms_r_m").parse(), Ok(1.0 / 3.0));
        assert_eq!(cell(1, "reason"), "one, \"two\"\nthree");
        assert_eq!((cell(0, "solved"), cell(0, "wrong"), cell(0, "certified")), ("", "false", "true"));
        assert!(!rows.names.iter().any(|name| name.ends_with("_s")), "seconds depend on the machine");
    }

    #[test]
    fn what_does_not_differ_is_not_told() {
        let (a, mut b) = (outcomes(), outcomes());
        b[0].row.rms_r_m = Some((1.0 + 1e-11) / 3.0);
        b[0].row.job = 7;
        b[1].job_s = 100.0;
        b.swap(0, 1);
        let difference = Difference::of(&parsed(&a), &parsed(&b));
        assert_eq!(difference.lines, Vec::<String>::new());
        assert_eq!(difference.summary(), "3 trials in both: 0 differ, the verdict in 0");
    }

    #[test]
    fn what_differs_is_told_with_both_values() {
        let (a, mut b) = (outcomes(), outcomes());
        b[0].row.rms_r_m = Some(0.25);
        b[1].row.certified = true;
        b[1].row.rms_r_m = None;
        b.remove(2);
        let difference = Difference::of(&parsed(&a), &parsed(&b));
        assert_eq!(
            difference.lines,
            [
                "seed 1 motion random noise_sd_m 0.0001: rms_r_m 0.3333333333333333 -> 0.25",
                "seed 2 motion random noise_sd_m 0.0001: certified false -> true, rms_r_m 1e-6 -> none",
            ]
        );
        assert_eq!(
            difference.summary(),
            "2 trials in both: 2 differ (certified 1, rms_r_m 2), the verdict in 1; \
             1 trials in the first alone, 0 in the second alone"
        );
    }

    #[test]
    fn a_table_that_is_not_one_is_refused() {
        for (text, said) in [
            ("", "no table"),
            ("a,b\n1,2\n", "no column seed"),
            ("seed,motion,noise_sd_m,counts_per_inch,angle_noise_sd_rad,dropout\n1,2\n", "row 1: 2 cells"),
        ] {
            let error = Rows::parse(text).expect_err("it is not a table of rows");
            assert!(error.to_string().contains(said), "{error}");
        }
    }
}
