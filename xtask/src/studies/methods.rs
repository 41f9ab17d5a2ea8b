//! `cargo xtask methods`: the paper's method against maximum likelihood on the same logs, as a Markdown table.
//!
//! Objects and motions are those of `cargo xtask monte-carlo` without jumps. The methods that integrate are run twice: given the
//! true initial values, and with initial values of their own finding. Maximum likelihood is given nothing.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::bail;
use palpate::compare::{TruthError, compare};
use palpate::reconstruct::{Method, Reconstructor, Start};
use palpate::simulate::Simulation;
use rayon::prelude::*;

use crate::studies::exact;
use crate::studies::monte_carlo::{NoiseKind, quantile, simulation};
use crate::studies::tables::{self, Table, Write};

/// Options of `cargo xtask methods`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Trials; about seven in ten give a log without a jump
    #[arg(long, default_value_t = 200)]
    trials: u64,
    /// Seed of the first trial
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Standard deviation of the contact positions, mm
    #[arg(long, value_name = "MM", default_value_t = 0.1)]
    noise_mm: f64,
    /// Instead of trials, the logs (NAME.csv with NAME.truth beside it) of this folder, a row for each log and method
    #[arg(long, value_name = "DIR")]
    logs: Option<PathBuf>,
    /// Instead of trials, the methods that integrate on exact logs: how they converge, and what they make of ill-conditioned places
    #[arg(long, conflicts_with = "logs")]
    exact: bool,
    #[command(flatten)]
    write: Write,
}

impl Arguments {
    /// The command that makes the table again.
    fn command(&self) -> String {
        match &self.logs {
            None if self.exact => "cargo xtask methods --exact".to_owned(),
            Some(dir) => format!("cargo xtask methods --logs {}", dir.display()),
            None => format!(
                "cargo xtask methods --trials {} --seed {} --noise-mm {}",
                self.trials, self.seed, self.noise_mm
            ),
        }
    }
}

/// How a method was run.
#[derive(Clone, Copy)]
struct Run {
    name: &'static str,
    method: Method,
    given_start: bool,
}

const RUNS: [Run; 5] = [
    Run { name: "ODE, true initial values", method: Method::Ode, given_start: true },
    Run { name: "ODE, searched initial values", method: Method::Ode, given_start: false },
    Run { name: "quadrature, true initial values", method: Method::Quadrature, given_start: true },
    Run { name: "quadrature, searched initial values", method: Method::Quadrature, given_start: false },
    Run { name: "likelihood, nothing given", method: Method::Likelihood, given_start: false },
];

/// The last of the runs, which the others are held against.
const LIKELIHOOD: usize = RUNS.len() - 1;

/// The errors of each run on one log, and the seconds taken; `None` where there was no result.
type Outcome = [Option<(TruthError, f64)>; RUNS.len()];

/// Runs the comparison and prints its tables.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let places = match &arguments.logs {
        None if arguments.exact => vec![tables::METHODS_STEPS, tables::METHODS_CROSSINGS],
        None => vec![tables::METHODS],
        Some(_) => vec![tables::METHODS_LOGS],
    };
    arguments.write.check(&places)?;
    let made = match &arguments.logs {
        None if arguments.exact => vec![exact::steps()?, exact::crossings()?],
        None => vec![on_trials(arguments)?],
        Some(dir) => vec![on_logs(&logs_of(dir)?, &METHODS)?],
    };
    let command = arguments.command();
    let tables: Vec<Table> =
        places.into_iter().zip(made).map(|(place, table)| (place, format!("    {command}\n\n{table}"))).collect();
    tables.iter().for_each(|(_, text)| println!("{text}\n"));
    arguments.write.tables(&tables, &command)
}

/// All methods, told the truth or nothing, on simulated logs.
fn on_trials(arguments: &Arguments) -> anyhow::Result<String> {
    let started = Instant::now();
    let outcomes: Vec<Outcome> = (arguments.seed..arguments.seed + arguments.trials)
        .into_par_iter()
        .filter_map(|seed| trial(seed, 1e-3 * arguments.noise_mm).transpose())
        .collect::<anyhow::Result<_>>()?;
    if outcomes.is_empty() {
        bail!("no trial gave a log without a jump");
    }
    let mut lines = vec![
        "| method | results | RMS shape (mm) | Hausdorff (mm) | RMS orientation (deg) | RMS centre of mass (mm) | shape against likelihood | orientation against likelihood | seconds |".to_owned(),
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|".to_owned(),
    ];
    for (index, run) in RUNS.iter().enumerate() {
        let of = |value: &dyn Fn(&TruthError) -> f64| -> Vec<f64> {
            outcomes.iter().filter_map(|outcome| outcome[index].as_ref()).map(|(errors, _)| value(errors)).collect()
        };
        let ratio = |value: &dyn Fn(&TruthError) -> f64| -> Vec<f64> {
            let both = outcomes.iter().filter_map(|outcome| outcome[index].as_ref().zip(outcome[LIKELIHOOD].as_ref()));
            both.map(|(this, best)| value(&this.0) / value(&best.0)).collect()
        };
        let seconds = outcomes.iter().filter_map(|outcome| outcome[index].as_ref()).map(|(_, seconds)| *seconds);
        lines.push(format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            run.name,
            of(&|e| e.rms_r_m).len(),
            spread(of(&|e| 1e3 * e.rms_r_m)),
            spread(of(&|e| 1e3 * e.hausdorff_m)),
            spread(of(&|e| e.rms_psi_rad.to_degrees())),
            spread(of(&|e| 1e3 * e.rms_com_m)),
            spread(ratio(&|e| e.rms_r_m)),
            spread(ratio(&|e| e.rms_psi_rad)),
            spread(seconds.collect()),
        ));
    }
    eprintln!("{:.0} s", started.elapsed().as_secs_f64());
    lines.push(format!("\n{} of {} trials gave a log without a jump.", outcomes.len(), arguments.trials));
    Ok(lines.join("\n"))
}

/// The methods of the table of logs.
const METHODS: [Method; 3] = [Method::Ode, Method::Quadrature, Method::Likelihood];

/// The logs of a folder, in order.
fn logs_of(dir: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut logs: Vec<PathBuf> =
        std::fs::read_dir(dir)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    logs.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    logs.sort();
    Ok(logs)
}

/// The methods, told nothing, on logs with their truth beside them.
fn on_logs(logs: &[PathBuf], methods: &[Method]) -> anyhow::Result<String> {
    let mut lines = vec![
        "| log | method | RMS shape (mm) | Hausdorff (mm) | RMS orientation (deg) | RMS centre of mass (mm) | jumps | certified |".to_owned(),
        "|---|---|---:|---:|---:|---:|---:|---|".to_owned(),
    ];
    for path in logs {
        let file = palpate_io::read_log(path)?;
        let truth = palpate_io::read_truth(&palpate_io::truth_dir_of(path))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let row = |method: &Method| {
            let Ok(found) = Reconstructor::new().method(*method).run(&file.log) else {
                return Ok(format!("| {name} | {method} | | | | | | no result |"));
            };
            let errors = compare(&found, &truth)?;
            Ok(format!(
                "| {name} | {method} | {} | {} | {} | {} | {} | {} |",
                digits(1e3 * errors.rms_r_m),
                digits(1e3 * errors.hausdorff_m),
                digits(errors.rms_psi_rad.to_degrees()),
                digits(1e3 * errors.rms_com_m),
                found.jumps.len(),
                if found.is_certified() { "yes" } else { "no" }
            ))
        };
        lines.extend(methods.par_iter().map(row).collect::<anyhow::Result<Vec<_>>>()?);
    }
    Ok(lines.join("\n"))
}

/// Two significant digits, at most five decimals.
pub(super) fn digits(value: f64) -> String {
    let magnitude = value.abs().log10().floor();
    let decimals = if magnitude.is_finite() { (1.0 - magnitude).clamp(0.0, 5.0) } else { 0.0 };
    format!("{value:.0$}", decimals as usize)
}

/// Median and the range from 5 to 95 %, with two significant digits.
fn spread(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| quantile(&values, share);
    match (at(0.5), at(0.05), at(0.95)) {
        (Some(median), Some(low), Some(high)) => {
            format!("{} ({} to {})", digits(median), digits(low), digits(high))
        }
        _ => "none".to_owned(),
    }
}

fn trial(seed: u64, noise_sd_m: f64) -> anyhow::Result<Option<Outcome>> {
    let Ok(simulated) = simulation(seed, NoiseKind::Gaussian(noise_sd_m), false).simulate() else { return Ok(None) };
    let (shape, Simulation { log, truth, .. }) = (simulated.shape, simulated.simulation);
    let psi: Vec<f64> = truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let mut outcome: Outcome = [None; RUNS.len()];
    for (run, outcome) in RUNS.iter().zip(&mut outcome) {
        let reconstructor = Reconstructor::new().method(run.method);
        let clock = Instant::now();
        let found = if run.given_start {
            reconstructor.start(Start::Motion { shape: shape.clone(), psi_rad: psi.clone() }).run(&log)
        } else {
            reconstructor.run(&log)
        };
        let seconds = clock.elapsed().as_secs_f64();
        if let Ok(found) = found {
            *outcome = Some((compare(&found, &truth)?, seconds));
        }
    }
    Ok(Some(outcome))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::tables::assert_documented;
    use crate::workspace;

    #[test]
    fn the_documented_table_of_logs_is_that_of_today() {
        let logs = workspace::root().join("examples/logs");
        let integrate = &METHODS[..2];
        // The rest of the rows takes many seconds; tests of the estimator on these logs hold them to limits.
        for (name, methods) in [
            ("egg_full_turn_oracle_n0.1mm", &METHODS[..]),
            ("ellipse_fast_10x_mujoco", &METHODS),
            ("ellipse_friction_0.10_mujoco", integrate),
            ("ellipse_full_turn_pymunk", integrate),
            ("pebble_full_turn_mujoco_sensor", &METHODS),
            ("stone_zigzag_oracle", &METHODS[2..]),
        ] {
            let log = logs.join(format!("{name}.csv"));
            assert_documented(tables::METHODS_LOGS, &on_logs(&[log], methods).expect("a table"), 0.1);
        }
    }
}
