//! `cargo xtask limits`: what half and twice each limit of the certificate would do, as a Markdown table.
//!
//! Each trial is simulated and scored as in `cargo xtask monte-carlo`. A result carries the numbers that its verdict rests on, so the
//! verdict by other limits needs no new reconstruction, except for the limits in [`ANEW`], which enter these numbers.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, bail};
use palpate::reconstruct::{CertificateLimits, Findings};
use palpate_sweep::{Job, ReconstructChoice, Row, ScoreChoice, Source, Status};
use rayon::prelude::*;
use serde_json::{Map, Value};

use crate::studies::monte_carlo::{set, simulation};
use crate::studies::tables::{self, Place, Write};

/// Options of `cargo xtask limits`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Motions that know nothing of the shape, with as many jumps as come (default: motions without jumps).
    #[arg(long)]
    jumps: bool,
    /// Trials; with jumps in all, without for each kind of noise.
    #[arg(long, default_value = "300")]
    trials: u64,
    /// Seed of the first trial.
    #[arg(long, default_value = "1")]
    seed: u64,
    #[command(flatten)]
    write: Write,
}

impl Arguments {
    /// The command that makes this table again.
    fn command(&self) -> String {
        let jumps = if self.jumps { " --jumps" } else { "" };
        format!("cargo xtask limits{jumps} --trials {} --seed {}", self.trials, self.seed)
    }

    /// The page quotes the table through jumps.
    fn places(&self) -> &'static [Place] {
        if self.jumps { &[tables::LIMITS] } else { &[] }
    }
}

/// Every limit, in the order of the table.
const NAMES: [&str; 23] = [
    "model_allowance",
    "chi2_sds",
    "chi2_excess_stated",
    "chi2_excess_estimated",
    "concavity",
    "unstable_share",
    "stability_slack",
    "coverage",
    "ambiguity_rad",
    "reversals",
    "psi_sd_rad",
    "largest_psi_sd_rad",
    "r_sd",
    "r_sd_with_short_jumps",
    "short_jump_rad",
    "outliers",
    "tails",
    "symmetry_probability",
    "symmetry_deviation",
    "rig_off_sds",
    "rig_unsettled_sds",
    "balance_sensor_sds",
    "balance_allowances",
];

/// Limits that enter the numbers that a verdict rests on: the log is reconstructed anew with each value of them.
const ANEW: [&str; 2] = ["model_allowance", "stability_slack"];

/// Multiples of the default.
const FACTORS: [f64; 3] = [0.5, 1.0, 2.0];

/// The default limits as a table of names and values.
fn defaults() -> anyhow::Result<Map<String, Value>> {
    match serde_json::to_value(CertificateLimits::default())? {
        Value::Object(limits) => Ok(limits),
        other => bail!("the limits of the certificate are {other}, not a table"),
    }
}

/// A multiple of a value; of a count, rounded down.
fn multiple(value: &Value, factor: f64) -> anyhow::Result<Value> {
    let scaled = factor * value.as_f64().context("a limit that is no number")?;
    Ok(if value.is_u64() { Value::from(scaled as u64) } else { Value::from(scaled) })
}

/// The default limits, one of them multiplied.
fn scaled(name: &str, factor: f64) -> anyhow::Result<CertificateLimits> {
    let mut limits = defaults()?;
    let value = limits.get_mut(name).with_context(|| format!("there is no limit {name}"))?;
    *value = multiple(value, factor)?;
    Ok(serde_json::from_value(Value::Object(limits))?)
}

/// What a trial came to by some limits.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Judged {
    certified: bool,
    com_certified: bool,
    solved: bool,
    beyond_chance: bool,
}

/// One trial: its row by the default limits, what its verdict rests on, and its rows by the limits of [`ANEW`].
struct Trial {
    row: Row,
    findings: Option<Findings>,
    anew: Vec<(&'static str, f64, Row)>,
}

impl Trial {
    /// Simulates and reconstructs trial `seed`. `None` where there is no log.
    fn run(job: &Job) -> anyhow::Result<Option<Self>> {
        let (outcome, found) = job.run_with(CertificateLimits::default(), 0, Path::new(""));
        let row = outcome.row;
        if row.status == Status::NoLog {
            return Ok(None);
        }
        let without_reference = Job { score: ScoreChoice::default(), ..job.clone() };
        let mut anew = Vec::new();
        for name in ANEW {
            for factor in FACTORS.into_iter().filter(|factor| *factor != 1.0) {
                let (outcome, _) = without_reference.run_with(scaled(name, factor)?, 0, Path::new(""));
                anew.push((name, factor, with_reference(outcome.row, &row)));
            }
        }
        Ok(Some(Self { row, findings: found.and_then(|found| found.findings), anew }))
    }

    /// By the default limits with one of them multiplied.
    fn by(&self, name: &str, factor: f64, limits: &CertificateLimits) -> Judged {
        if let Some((.., row)) = self.anew.iter().find(|(other, at, _)| *other == name && *at == factor) {
            return judged(row, row.certified, row.com_certified);
        }
        // One of several answers is not certified by any limits.
        let single = self.row.alternatives == Some(1);
        let verdict = self.findings.as_ref().filter(|_| single).map(|findings| findings.verdict(limits));
        let (certified, com_certified) =
            verdict.map_or((false, false), |verdict| (verdict.is_certified(), verdict.is_com_certified()));
        judged(&self.row, certified, com_certified)
    }
}

fn judged(row: &Row, certified: bool, com_certified: bool) -> Judged {
    Judged {
        certified,
        com_certified,
        solved: row.is_solved() == Some(true),
        beyond_chance: row.is_beyond_chance() == Some(true),
    }
}

/// The row with the reference and the bound of another result for the same log.
fn with_reference(row: Row, of: &Row) -> Row {
    Row {
        reference_rms_r_m: of.reference_rms_r_m,
        reference_rms_psi_rad: of.reference_rms_psi_rad,
        bound_r_m: of.bound_r_m,
        ..row
    }
}

const HEADING: &str = "\
| limit | half, default, twice | certified | certified, wrong | solved, not certified | centre of mass certified |
|---|---|---:|---:|---:|---:|
";

/// A row of the table.
fn table_row(name: &str, trials: &[Trial]) -> anyhow::Result<String> {
    let default = defaults()?;
    let value = default.get(name).with_context(|| format!("there is no limit {name}"))?;
    let mut cells = [const { Vec::new() }; 5];
    for factor in FACTORS {
        let limits = scaled(name, factor)?;
        let judged: Vec<Judged> = trials.iter().map(|trial| trial.by(name, factor, &limits)).collect();
        let count = |test: fn(&Judged) -> bool| judged.iter().filter(|judged| test(judged)).count().to_string();
        cells[0].push(multiple(value, factor)?.to_string());
        cells[1].push(count(|judged| judged.certified));
        cells[2].push(count(|judged| judged.certified && judged.beyond_chance));
        cells[3].push(count(|judged| judged.solved && !judged.certified));
        cells[4].push(count(|judged| judged.com_certified));
    }
    let mark = if ANEW.contains(&name) { "*" } else { "" };
    let [values, counts @ ..] = cells.map(|of_factors| of_factors.join(" / "));
    Ok(format!("| `{name}`{mark} | {values} | {} |\n", counts.join(" | ")))
}

/// Runs the trials, prints the table, and writes it where that is asked for.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.write.check(arguments.places())?;
    let started = Instant::now();
    let jobs: Vec<Job> = set(arguments.seed, arguments.trials, arguments.jumps)
        .into_iter()
        .map(|(_, seed, noise)| job(Source::Simulate(simulation(seed, noise, arguments.jumps))))
        .collect();
    let tried: Vec<Option<Trial>> = jobs.par_iter().map(Trial::run).collect::<anyhow::Result<_>>()?;
    let trials: Vec<Trial> = tried.into_iter().flatten().collect();
    if trials.is_empty() {
        bail!("no trial could be simulated");
    }
    let rows: String = NAMES.iter().map(|name| table_row(name, &trials)).collect::<anyhow::Result<_>>()?;
    let command = arguments.command();
    let table = format!(
        "    {command}\n\n{HEADING}{rows}\n{} trials in {:.0} s, {} with a log. *: each value reconstructed anew.",
        jobs.len(),
        started.elapsed().as_secs_f64(),
        trials.len(),
    );
    println!("{table}");
    arguments
        .write
        .tables(&arguments.places().iter().map(|place| (*place, table.clone())).collect::<Vec<_>>(), &command)
}

fn job(source: Source) -> Job {
    Job { source, reconstruct: ReconstructChoice::default(), score: ScoreChoice { reference: true, bound: true } }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_table_has_every_limit() {
        let all: BTreeSet<String> = defaults().expect("a table").keys().cloned().collect();
        assert_eq!(all, NAMES.iter().map(ToString::to_string).collect());
        assert_eq!(all.len(), NAMES.len());
        assert!(ANEW.iter().all(|name| NAMES.contains(name)));
    }

    #[test]
    fn one_limit_is_multiplied_and_no_other() {
        let default = CertificateLimits::default();
        for name in NAMES {
            assert_eq!(scaled(name, 1.0).expect("a limit"), default, "{name}");
            assert_ne!(scaled(name, 2.0).expect("a limit"), default, "{name}");
        }
        let half = scaled("r_sd", 0.5).expect("a limit");
        assert_eq!((half.r_sd, half.psi_sd_rad), (0.5 * default.r_sd, default.psi_sd_rad));
        assert_eq!(scaled("reversals", 0.5).expect("a limit").reversals, 0, "a count is rounded down");
        assert!(scaled("no_such", 0.5).is_err());
    }

    #[test]
    fn the_default_limits_give_the_verdict_of_the_result() {
        let (_, seed, noise) = set(10_001, 1, true)[0];
        let trial = Trial::run(&job(Source::Simulate(simulation(seed, noise, true))));
        let trial = trial.expect("it can be run").expect("a log");
        let by_default = trial.by("r_sd", 1.0, &CertificateLimits::default());
        assert_eq!((by_default.certified, by_default.com_certified), (trial.row.certified, trial.row.com_certified));
        assert_eq!((Some(by_default.solved), by_default.beyond_chance), (trial.row.solved, false));
        assert!(by_default.certified, "{}", trial.row.reason);
        let strict = trial.by("r_sd", 0.0, &scaled("r_sd", 0.0).expect("a limit"));
        assert!(!strict.certified && !strict.com_certified && strict.solved);
        assert_eq!(trial.anew.len(), 4);
    }
}
