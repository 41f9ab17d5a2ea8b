//! The paper's differential equations, integrated from the same initial values over the same readings: palpate's fixed steps against
//! SciPy's `solve_ivp`.
//!
//! The piece of the log has no jump, and the lines of force keep off the centre of mass, where the equations are singular. The
//! readings are free of noise, so that the truth says how exact either is. SciPy is given the method and the tolerance with which it is
//! fastest among those that reach palpate's accuracy. Smoothing and splines are made beforehand for both; both run on one thread.

use std::fs;

use anyhow::{Context as _, bail};
use palpate::Log;
use palpate::palms::PalmMotion;
use palpate::reconstruct::PaperEquations;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate::truth::TruePose;

use super::Context;
use super::Worker;
use super::row::{Agreement, Row};
use super::turns::{Turns, timed};

const JOB: &str = "paper's equations";
const PEER: &str = "SciPy solve_ivp";

/// The program, from the root of the workspace.
const PROGRAM: &str = "bench/peers/scipy_ode.py";

/// Mean radius of the pebble, metres.
const SIZE_M: f64 = 0.03;

/// The random motion, and the part of it that is integrated, seconds: the pebble turns by 137°.
const SEED: u64 = 2;
const DURATION_S: f64 = 90.0;
const PART_S: [f64; 2] = [5.0, 16.0];

/// Samples of the part.
const SAMPLES: usize = 900;

/// SciPy's methods for equations that are not stiff, and LSODA, which is compiled.
const METHODS: [&str; 4] = ["LSODA", "DOP853", "RK45", "RK23"];

/// Tolerances from loose to tight.
const TOLERANCES: [f64; 6] = [1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12];

/// A run of SciPy that takes longer than this is given up, seconds.
const PATIENCE_S: f64 = 60.0;

/// Compares.
pub fn run(context: &Context, rows: &mut Vec<Row>) -> anyhow::Result<()> {
    let piece = Piece::new()?;
    let equations = PaperEquations::new(&piece.log)?;
    let mine = || equations.integrate(piece.start_m.0, piece.start_m.1);
    let error = {
        let found = mine()?;
        let values: [Vec<f64>; 3] = [
            found.iter().map(|sample| sample.r1_m).collect(),
            found.iter().map(|sample| sample.r2_m).collect(),
            found.iter().map(|sample| sample.psi_rad).collect(),
        ];
        piece.error(&values.concat())?
    };
    let path = context.folder.join("paper-equations.json");
    fs::write(&path, piece.json()).with_context(|| path.display().to_string())?;
    let environment = context.python_with(&["numpy", "scipy"])?;
    let mut worker = Worker::start(environment.python().arg(PROGRAM).arg(&path), PATIENCE_S)?;
    let mut best: Option<(f64, String, f64)> = None;
    for method in METHODS {
        for tolerance in TOLERANCES {
            let question = format!("{method} {tolerance:e}");
            let (_, values) = answer(&mut worker, &question)?;
            let error_of_peer = piece.error(&values)?;
            if error_of_peer <= error {
                let (seconds, _) = answer(&mut worker, &question)?;
                if best.as_ref().is_none_or(|(least, ..)| seconds < *least) {
                    best = Some((seconds, question, error_of_peer));
                }
                break;
            }
        }
    }
    let Some((_, question, error_of_peer)) = best else {
        bail!("{PEER} does not come as near to the truth as palpate: {error:.1e}");
    };
    let turns = Turns { most: if context.quick { 31 } else { 101 }, budget_s: 20.0 };
    let medians = turns.take(
        || {
            let (seconds, found) = timed(mine);
            found?;
            Ok(seconds)
        },
        || Ok(answer(&mut worker, &question)?.0),
    )?;
    let text =
        format!("largest error of ψ (rad) and of r (mean radii): palpate {error:.1e}, {question} {error_of_peer:.1e}");
    let agreement = Agreement { holds: true, text };
    rows.push(Row::compared(JOB, (Some(SAMPLES), None), PEER, medians, agreement));
    Ok(())
}

/// Seconds, and r₁, r₂, ψ at all samples.
fn answer(worker: &mut Worker, question: &str) -> anyhow::Result<(f64, Vec<f64>)> {
    let words = worker.ask(question)?;
    let numbers: Vec<f64> = words.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
    let (seconds, values) = numbers.split_first().context("an empty answer")?;
    Ok((*seconds, values.to_vec()))
}

/// What is felt between two times, and what is true.
struct Piece {
    log: Log,
    motion: Vec<TruePose>,
    /// r₁ and r₂ at all samples.
    support_m: Vec<(f64, f64)>,
    start_m: (f64, f64),
}

impl Piece {
    fn new() -> anyhow::Result<Self> {
        let shape = NamedShape::Pebble.shape(SIZE_M)?;
        let motion = PalmMotion::random(SEED, DURATION_S, 1.0)?;
        let [start_s, end_s] = PART_S;
        let part = (0..SAMPLES).map(|sample| start_s + (end_s - start_s) * sample as f64 / (SAMPLES - 1) as f64);
        // From the start, so that the pose is the right one.
        let before: Vec<f64> = (0..(10.0 * start_s) as usize).map(|step| 0.1 * step as f64).collect();
        let palms: Vec<_> = before.iter().copied().chain(part).map(|time_s| (time_s, motion.at(time_s))).collect();
        let mut simulated = simulate(&shape, &palms, &SimulateOptions::default())?;
        let log = Log { samples: simulated.log.samples.split_off(before.len()) };
        let motion = simulated.truth.motion.split_off(before.len());
        let support_m: Vec<(f64, f64)> = log
            .samples
            .iter()
            .zip(&motion)
            .map(|(sample, pose)| {
                let (theta1, theta2) = sample.palms.contact_angles(pose.psi_rad);
                (shape.radius_m(theta1), shape.radius_m(theta2))
            })
            .collect();
        let start_m = *support_m.first().context("no samples")?;
        Ok(Self { log, motion, support_m, start_m })
    }

    fn json(&self) -> String {
        let channel = |value: fn(&palpate::Sample) -> f64| -> Vec<f64> { self.log.samples.iter().map(value).collect() };
        let piece = serde_json::json!({
            "time_s": channel(|sample| sample.time_s),
            "phi1_rad": channel(|sample| sample.palms.phi1_rad),
            "phi2_rad": channel(|sample| sample.palms.phi2_rad),
            "s1_m": channel(|sample| sample.s1_m.unwrap_or(f64::NAN)),
            "s2_m": channel(|sample| sample.s2_m.unwrap_or(f64::NAN)),
            "start_r1_m": self.start_m.0,
            "start_r2_m": self.start_m.1,
        });
        piece.to_string()
    }

    /// Largest error of ψ in radians and of r in mean radii.
    fn error(&self, values: &[f64]) -> anyhow::Result<f64> {
        if values.len() != 3 * SAMPLES {
            bail!("{} values came back, not {}", values.len(), 3 * SAMPLES);
        }
        let first = self.motion.first().context("no samples")?.psi_rad;
        let errors = self.motion.iter().zip(&self.support_m).enumerate().map(|(sample, (pose, (r1, r2)))| {
            let [found1, found2, psi] = [0, 1, 2].map(|channel| values[channel * SAMPLES + sample]);
            let off = [(found1 - r1) / SIZE_M, (found2 - r2) / SIZE_M, psi - (pose.psi_rad - first)];
            off.into_iter().fold(0.0, |largest: f64, off| largest.max(off.abs()))
        });
        Ok(errors.fold(0.0, f64::max))
    }
}
