//! The whole reconstruction from nothing, of random objects and motions, without jumps and through them.
//!
//! No other open program does this. What is timed is palpate alone, on all processors and on one, and where its folder is given, the
//! numpy prototype of the same idea on the first logs.

use std::fs;
use std::path::Path;

use anyhow::Context as _;
use palpate::Reconstruction;
use palpate::palms::PalmMotion;
use palpate::plan::plan_jump_free;
use palpate::reconstruct::ReconstructError;
use palpate::sensor::Touchpad;
use palpate::shape::{RandomShape, random_shape};
use palpate::simulate::{SimulateOptions, Simulation, simulate};

use super::Context;
use super::Worker;
use super::row::{Agreement, Row};
use super::turns::{Turns, timed};

const JOB: &str = "from nothing";
const PROTOTYPE: &str = "numpy prototype";

/// The program that calls the prototype, from the root of the workspace.
const PROGRAM: &str = "bench/peers/prototype_grow.py";

/// Samples of a log, how long the palms move (seconds), and the noise of the contact positions (metres).
const SAMPLES: usize = 900;
const DURATION_S: f64 = 90.0;
const NOISE_M: f64 = 1e-4;

/// Logs of each kind, quick and full.
const LOGS: [u64; 2] = [10, 20];

/// Logs that the prototype is given, quick and full; it takes half a minute for each.
const PROTOTYPE_LOGS: [u64; 2] = [1, 4];

/// A run of the prototype that takes longer than this is given up, seconds.
const PATIENCE_S: f64 = 600.0;

/// Orientations further apart than this are not the same motion, radians RMS.
const SAME_RAD: f64 = 0.02;

/// Times them.
pub fn run(context: &Context, rows: &mut Vec<Row>) -> anyhow::Result<()> {
    let count = LOGS[usize::from(!context.quick)];
    for jumps in [false, true] {
        let logs: Vec<Simulation> = (1..=count)
            .map(|seed| simulated(seed, jumps).with_context(|| format!("seed {seed}")))
            .collect::<Result<_, _>>()?;
        for threads in [rayon::current_num_threads(), 1] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            rows.push(alone(&logs, jumps, threads, &pool));
        }
    }
    if let Some(folder) = &context.prototype {
        for seed in 1..=PROTOTYPE_LOGS[usize::from(!context.quick)] {
            let row = against_prototype(context, folder, seed);
            rows.push(row.unwrap_or_else(|error| Row::remark(JOB, PROTOTYPE, format!("{error:#}"))));
        }
    }
    Ok(())
}

/// A random object in a random motion.
fn simulated(seed: u64, jumps: bool) -> anyhow::Result<Simulation> {
    let shape = random_shape(&RandomShape::default(), seed)?;
    let (motion, start_psi_rad) = if jumps {
        (PalmMotion::random(seed, DURATION_S, 1.0)?, 0.0)
    } else {
        let planned = plan_jump_free(&shape, seed, DURATION_S)?;
        (planned.motion, planned.start_psi_rad)
    };
    let mut palms = motion.sample(SAMPLES as f64 / DURATION_S)?;
    palms.truncate(SAMPLES);
    let touchpad = Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() };
    Ok(simulate(&shape, &palms, &SimulateOptions { touchpad, seed, start_psi_rad, ..SimulateOptions::default() })?)
}

fn solved(simulation: &Simulation) -> Result<Reconstruction, ReconstructError> {
    palpate::reconstruct(&simulation.log)
}

/// A row without a peer: the median over the logs, each reconstructed once.
fn alone(logs: &[Simulation], jumps: bool, threads: usize, pool: &rayon::ThreadPool) -> Row {
    let runs: Vec<(f64, bool)> = logs
        .iter()
        .map(|log| {
            let (seconds, found) = timed(|| pool.install(|| solved(log)));
            (seconds, found.is_ok_and(|found| found.is_certified()))
        })
        .collect();
    let mut seconds: Vec<f64> = runs.iter().map(|(seconds, _)| *seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let quantile = |share: f64| seconds[((seconds.len() - 1) as f64 * share).round() as usize];
    let certified = runs.iter().filter(|(_, certified)| *certified).count();
    let kind = if jumps {
        let most = logs.iter().map(|log| log.jumps.len()).max().unwrap_or(0);
        format!("up to {most} jumps")
    } else {
        "without jumps".to_owned()
    };
    Row {
        job: format!("{JOB}, {kind}"),
        n: Some(SAMPLES),
        k: None,
        peer: "none: no other open program".to_owned(),
        palpate_s: Some(quantile(0.5)),
        peer_s: None,
        ratio: None,
        agreement: format!(
            "{certified} of {} certified; 95 % within {:.2} s; {threads} {}",
            runs.len(),
            quantile(0.95),
            if threads == 1 { "thread" } else { "threads" }
        ),
    }
}

/// palpate on all processors and the prototype by turns on one log through jumps.
fn against_prototype(context: &Context, folder: &Path, seed: u64) -> anyhow::Result<Row> {
    let simulation = simulated(seed, true)?;
    let samples = &simulation.log.samples;
    let channel = |value: fn(&palpate::Sample) -> f64| -> Vec<f64> { samples.iter().map(value).collect() };
    let json = serde_json::json!({
        "phi1_rad": channel(|sample| sample.palms.phi1_rad),
        "phi2_rad": channel(|sample| sample.palms.phi2_rad),
        "s1_m": channel(|sample| sample.s1_m.unwrap_or(f64::NAN)),
        "s2_m": channel(|sample| sample.s2_m.unwrap_or(f64::NAN)),
    });
    let path = context.folder.join("from-nothing.json");
    fs::write(&path, json.to_string()).with_context(|| path.display().to_string())?;
    let environment = context.python_with(&["numpy"])?;
    let mut worker =
        Worker::start(environment.python().arg(PROGRAM).arg(std::path::absolute(folder)?).arg(&path), PATIENCE_S)?;
    let mut theirs = Vec::new();
    let medians = Turns { most: 1, budget_s: 0.0 }.take(
        || {
            let (seconds, found) = timed(|| solved(&simulation));
            found?;
            Ok(seconds)
        },
        || {
            let words = worker.ask("go")?;
            let numbers: Vec<f64> = words.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
            let (seconds, psi) = numbers.split_first().context("an empty answer")?;
            theirs = psi.to_vec();
            Ok(*seconds)
        },
    )?;
    let ours: Vec<f64> = solved(&simulation)?.motion.iter().map(|pose| pose.psi_rad).collect();
    let (ours, theirs) = (error_rad(&simulation, &ours), error_rad(&simulation, &theirs));
    let text = format!(
        "seed {seed}, {} jumps; RMS error of ψ: palpate {ours:.4} rad, prototype {theirs:.4} rad",
        simulation.jumps.len()
    );
    let agreement = Agreement { holds: ours < SAME_RAD && theirs < SAME_RAD, text };
    Ok(Row::compared(JOB, (Some(SAMPLES), None), PROTOTYPE, medians, agreement))
}

/// Root mean square of the error of ψ after the best common turn, radians; infinite when poses lack.
fn error_rad(simulation: &Simulation, psi_rad: &[f64]) -> f64 {
    let truth = &simulation.truth.motion;
    if psi_rad.len() != truth.len() {
        return f64::INFINITY;
    }
    let off: Vec<f64> = psi_rad.iter().zip(truth).map(|(found, pose)| found - pose.psi_rad).collect();
    let (sin, cos) = off.iter().fold((0.0, 0.0), |(sin, cos), off| (sin + off.sin(), cos + off.cos()));
    let turned: f64 = sin.atan2(cos);
    let squares: f64 = off.iter().map(|off| (2.0 * (0.5 * (off - turned)).sin()).powi(2)).sum();
    (squares / off.len() as f64).sqrt()
}
