//! `cargo xtask python-cost`: what it costs to reconstruct from Python rather than from Rust.
//!
//! The same log is reconstructed by turns in this program and in a Python process that stays alive, so that both meet
//! the same machine at the same time; one call is made before any is counted. Both are compiled with the same profile.

use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;
use std::time::Instant;

use anyhow::{Context, bail};
use palpate::palms::PalmPair;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};

use crate::python::Environment;
use crate::workspace;

/// Reconstructs once for each line that comes in, and says how long the call took, and one number of what came out.
const WORKER: &str = "
import sys, time
import palpate
log = palpate.Log.from_csv(sys.argv[1])
for _ in sys.stdin:
    started = time.perf_counter()
    result = palpate.reconstruct(log)
    seconds = time.perf_counter() - started
    print(seconds, result.shape.perimeter_m, flush=True)
";

/// Options of `cargo xtask python-cost`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Samples of the log
    #[arg(long, default_value_t = 900)]
    samples: usize,
    /// Calls of each kind
    #[arg(long, default_value_t = 30)]
    calls: usize,
}

/// Measures and prints.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let environment = Environment::provide()?;
    environment.install_wheel(if cfg!(debug_assertions) { "dev" } else { "release" })?;
    let path = workspace::target().join("python").join("cost.csv");
    let pebble = NamedShape::Pebble.shape(0.03)?;
    let plan = plan_turn(&pebble, &PalmLimits::default(), 90.0)?;
    let mut motion: Vec<(f64, PalmPair)> = plan.motion.sample(arguments.samples as f64 / 90.0)?;
    motion.truncate(arguments.samples);
    let options = SimulateOptions {
        touchpad: Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() },
        seed: 1,
        start_psi_rad: plan.start_psi_rad,
        ..SimulateOptions::default()
    };
    palpate_io::write_log(&path, &simulate(&pebble, &motion, &options)?.log, &[])?;
    let log = palpate_io::read_log(&path)?.log;

    let mut worker = environment.python();
    worker.args(["-c", WORKER]).arg(&path).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut worker = worker.spawn().context("python")?;
    let mut ask = worker.stdin.take().context("python has no input")?;
    let mut answers = BufReader::new(worker.stdout.take().context("python has no output")?).lines();
    let mut in_python = || -> anyhow::Result<(f64, f64)> {
        writeln!(ask)?;
        let answer = answers.next().context("python ended")??;
        let (seconds, perimeter) = answer.split_once(' ').context("python gave no answer")?;
        Ok((seconds.parse()?, perimeter.parse()?))
    };
    let in_rust = || -> anyhow::Result<(f64, f64)> {
        let started = Instant::now();
        let found = palpate::reconstruct(&log)?;
        Ok((started.elapsed().as_secs_f64(), found.shape.perimeter_m()))
    };
    if in_python()?.1 != in_rust()?.1 {
        bail!("the two results differ");
    }
    if arguments.calls == 0 {
        bail!("--calls must be at least 1");
    }
    let (mut python_s, mut rust_s) = (Vec::new(), Vec::new());
    for call in 0..arguments.calls {
        // Neither is always the first.
        if call % 2 == 0 {
            python_s.push(in_python()?.0);
            rust_s.push(in_rust()?.0);
        } else {
            rust_s.push(in_rust()?.0);
            python_s.push(in_python()?.0);
        }
    }
    drop(ask);
    worker.wait()?;
    let mut ratios: Vec<f64> = python_s.iter().zip(&rust_s).map(|(python, rust)| python / rust).collect();
    println!("{} samples, {} calls of each by turns", arguments.samples, arguments.calls);
    println!("Rust    median {:.4} s", median(&mut rust_s));
    println!("Python  median {:.4} s", median(&mut python_s));
    println!("Python costs {:+.2} % (median of the pairs)", 1e2 * (median(&mut ratios) - 1.0));
    Ok(())
}

/// The median, which sorts; NaN of nothing.
pub fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => f64::NAN,
        count if count % 2 == 0 => 0.5 * (values[middle - 1] + values[middle]),
        _ => values[middle],
    }
}
