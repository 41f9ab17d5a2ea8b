//! Batch smoothing: the same residuals, the same start, the same optimum.
//!
//! A pebble is turned all the way around; contact positions have 0.1 mm of noise. Unknown are the coefficients of the support
//! function and an orientation per sample. Every solver starts at the truth, disturbed by a few percent and 0.02 rad, and goes
//! on until its cost falls by less than the same share of it. The time is that from arrays in memory to the answer, with
//! what each needs to set its problem up. palpate takes one thread for short logs and all that there are for long ones; its peers take
//! one (two make Ceres slower here, which hands out a sample at a time).

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, bail};
use palpate::plan::{PalmLimits, plan_turn};
use palpate::reconstruct::{ReconstructError, SmoothOptions, Smoothed, smooth_from};
use palpate::sensor::Touchpad;
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateOptions, simulate};
use palpate::{Log, Sample};

use super::Context;
use super::Worker;
use super::row::{Agreement, NOBODY, Row};
use super::turns::{Turns, timed};
use crate::{debian, workspace};

/// Name of this job.
pub const JOB: &str = "smoothing";

/// Mean radius of the pebble, metres.
const SIZE_M: f64 = 0.03;

/// Standard deviation of the contact positions, and of the balance, metres.
const NOISE_M: f64 = 1e-4;

/// How long the palms move, seconds.
const DURATION_S: f64 = 90.0;

/// A solver stops when a step lowers its cost by less than this share.
const TOLERANCE: f64 = 1e-7;

/// Costs further apart than this share are not the same optimum.
const SAME_COST: f64 = 1e-6;

/// A peer that needs longer than this for one run is given up, seconds.
const PATIENCE_S: f64 = 1200.0;

/// All numbers of samples, and of harmonics.
const SAMPLES: [usize; 4] = [300, 1_000, 10_000, 100_000];
const HARMONICS: [usize; 3] = [8, 16, 32];

/// Samples that palpate smooths on one thread.
const ON_ONE_THREAD: usize = 4096;

/// Samples of the log that has to fit into memory, and its harmonics.
const MANY: (usize, usize) = (1_000_000, 8);

/// A solver, and the largest problems that it is given: samples times coefficients, in a quick run and in a full one.
struct Peer {
    name: &'static str,
    start: fn(&Context, &Path) -> anyhow::Result<Worker>,
    largest: [usize; 2],
}

const PEERS: [Peer; 3] = [
    Peer { name: "Ceres", start: ceres, largest: [usize::MAX, usize::MAX] },
    Peer { name: "SciPy", start: scipy, largest: [usize::MAX, usize::MAX] },
    Peer { name: "CasADi, IPOPT", start: casadi, largest: [33_000, 330_000] },
];

/// Why GTSAM is not among them.
const NO_GTSAM: &str = "left out: a factor of one's own must be a Python function, called for every sample and step; only C++ could be fair";

/// A log with all that a solver is told.
struct Case {
    log: Log,
    shape: SupportFunction,
    psi_rad: Vec<f64>,
    options: SmoothOptions,
}

/// palpate and all peers.
pub fn run(context: &Context, rows: &mut Vec<Row>) -> anyhow::Result<()> {
    for n in SAMPLES {
        for k in HARMONICS {
            let case = Case::new(n, k)?;
            let file = case.write(&context.folder)?;
            let fitting = |peer: &&Peer| n * (2 * k + 1) <= peer.largest[usize::from(!context.quick)];
            for peer in PEERS.iter().filter(fitting) {
                let row = case.against(peer, context, &file).unwrap_or_else(|error| Row {
                    n: Some(n),
                    k: Some(k),
                    ..Row::remark(JOB, peer.name, format!("{error:#}"))
                });
                eprintln!("{JOB}, {n} samples, {k} harmonics, {}: ratio {:?}; {}", peer.name, row.ratio, row.agreement);
                rows.push(row);
            }
            fs::remove_file(&file).with_context(|| file.display().to_string())?;
        }
    }
    rows.push(Row::remark(JOB, "GTSAM", NO_GTSAM));
    rows.push(many()?);
    Ok(())
}

/// A million samples in this process, with the most memory that it has ever had.
fn many() -> anyhow::Result<Row> {
    let (n, k) = MANY;
    let case = Case::new(n, k)?;
    let (seconds, smoothed) = timed(|| case.smoothed());
    smoothed?;
    let memory = peak_memory_gib().map_or_else(|| "unknown".to_owned(), |gib| format!("{gib:.1} GiB"));
    let text = format!("palpate alone; peak memory of the process, log and start included: {memory}");
    Ok(Row { n: Some(n), k: Some(k), palpate_s: Some(seconds), ..Row::remark(JOB, NOBODY, text) })
}

/// The most memory that this process has ever had, where Linux says so.
fn peak_memory_gib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / (1 << 20) as f64)
}

impl Case {
    fn new(samples: usize, harmonics: usize) -> anyhow::Result<Self> {
        let pebble = NamedShape::Pebble.shape(SIZE_M)?;
        let plan = plan_turn(&pebble, &PalmLimits::default(), DURATION_S)?;
        let mut motion = plan.motion.sample(samples as f64 / DURATION_S)?;
        motion.truncate(samples);
        let simulated = simulate(
            &pebble,
            &motion,
            &SimulateOptions {
                touchpad: Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() },
                seed: 1,
                start_psi_rad: plan.start_psi_rad,
                ..SimulateOptions::default()
            },
        )?;
        if !simulated.jumps.is_empty() {
            bail!("the pebble jumps");
        }
        // Three percent off in every harmonic that it has.
        let wrong = |index: usize, value: f64| value * (1.0 + 0.03 * (1.7 * index as f64).sin());
        let harmonics_m = pebble.harmonics_m().iter().enumerate();
        let shape = SupportFunction::new(
            wrong(1, pebble.mean_radius_m()),
            harmonics_m.map(|(index, [a, b])| [wrong(index + 2, *a), wrong(index + 3, *b)]).collect(),
        );
        let turned = |index: usize| 0.02 * (0.37 * index as f64).cos();
        let motion = simulated.truth.motion.iter().enumerate();
        Ok(Self {
            shape,
            psi_rad: motion.map(|(index, pose)| pose.psi_rad + turned(index)).collect(),
            options: SmoothOptions {
                harmonics,
                sensor_sd_m: NOISE_M,
                balance_sd_m: NOISE_M,
                size_m: SIZE_M,
                prior_scale_m: 0.5 * SIZE_M,
                most_steps: 100,
                tolerance: TOLERANCE,
            },
            log: simulated.log,
        })
    }

    /// The start as (a0, a1 … aK, b1 … bK), metres.
    fn coefficients(&self) -> Vec<f64> {
        vector(&self.shape, self.options.harmonics)
    }

    /// Writes the problem for the peers: little-endian floats, first N, K, σ, σ_b, then the prior standard deviations of the
    /// coefficients and their start (2K + 1 each), then φ1, φ2, s1, s2 and the start of ψ (N each).
    fn write(&self, folder: &Path) -> anyhow::Result<PathBuf> {
        let SmoothOptions { harmonics, sensor_sd_m, balance_sd_m, size_m, prior_scale_m, .. } = self.options;
        let samples = &self.log.samples;
        let mut numbers = vec![samples.len() as f64, harmonics as f64, sensor_sd_m, balance_sd_m];
        let sd_m = |k: usize| if k == 1 { size_m } else { prior_scale_m / (k * k) as f64 };
        numbers.push(10.0 * size_m);
        numbers.extend((1..=harmonics).chain(1..=harmonics).map(sd_m));
        numbers.extend(self.coefficients());
        let columns: [fn(&Sample) -> f64; 4] = [
            |sample| sample.palms.phi1_rad,
            |sample| sample.palms.phi2_rad,
            |sample| sample.s1_m.unwrap_or(f64::NAN),
            |sample| sample.s2_m.unwrap_or(f64::NAN),
        ];
        columns.iter().for_each(|column| numbers.extend(samples.iter().map(column)));
        numbers.extend(&self.psi_rad);
        let path = folder.join(format!("smooth-{}-{harmonics}.bin", samples.len()));
        let bytes: Vec<u8> = numbers.into_iter().flat_map(f64::to_le_bytes).collect();
        fs::write(&path, bytes).with_context(|| path.display().to_string())?;
        Ok(path)
    }

    /// Threads that palpate takes.
    fn threads(&self) -> usize {
        if self.log.samples.len() > ON_ONE_THREAD { rayon::current_num_threads() } else { 1 }
    }

    fn smoothed(&self) -> Result<Smoothed, ReconstructError> {
        smooth_from(&self.log, &self.shape, &self.psi_rad, &self.options)
    }

    fn against(&self, peer: &Peer, context: &Context, file: &Path) -> anyhow::Result<Row> {
        let mut worker = (peer.start)(context, file)?;
        let mut ours: Option<Smoothed> = None;
        let mut theirs = Vec::new();
        let turns = Turns { most: 25, budget_s: if context.quick { 1.0 } else { 20.0 } };
        let medians = turns.take(
            || {
                let (seconds, smoothed) = timed(|| self.smoothed());
                ours = Some(smoothed?);
                Ok(seconds)
            },
            || {
                theirs = worker.ask("solve")?.iter().map(|word| word.parse()).collect::<Result<Vec<f64>, _>>()?;
                theirs.first().copied().context("the peer says nothing")
            },
        )?;
        let agreement = self.agreement(&ours.context("palpate did not run")?, &theirs)?;
        let size = (Some(self.log.samples.len()), Some(self.options.harmonics));
        Ok(Row::compared(JOB, size, peer.name, medians, agreement))
    }

    /// `theirs` are seconds, cost, steps and coefficients.
    fn agreement(&self, ours: &Smoothed, theirs: &[f64]) -> anyhow::Result<Agreement> {
        let [_, cost, steps, theirs @ ..] = theirs else { bail!("the peer's answer is too short") };
        if theirs.len() != 2 * self.options.harmonics + 1 {
            bail!("the peer has {} coefficients", theirs.len());
        }
        let higher = cost / ours.cost - 1.0;
        let off_m = largest_difference_m(&vector(&ours.shape, self.options.harmonics), theirs);
        let held = if ours.held_convex { "; held convex, which peers do not" } else { "" };
        Ok(Agreement {
            holds: higher.abs() <= SAME_COST,
            text: format!(
                "cost {higher:+.0e}, coefficients {:.1e} µm; {steps:.0} steps{held}; palpate on {} {}",
                1e6 * off_m,
                self.threads(),
                if self.threads() == 1 { "thread" } else { "threads" }
            ),
        })
    }
}

/// (a0, a1 … aK, b1 … bK), metres.
fn vector(shape: &SupportFunction, harmonics: usize) -> Vec<f64> {
    let of = |index: usize| (0..harmonics).map(move |k| shape.harmonics_m().get(k).map_or(0.0, |pair| pair[index]));
    std::iter::once(shape.mean_radius_m()).chain(of(0)).chain(of(1)).collect()
}

/// The largest difference of two vectors of coefficients once the one is turned onto the other: a common rotation is open.
fn largest_difference_m(ours: &[f64], theirs: &[f64]) -> f64 {
    let order = ours.len() / 2;
    let turned = |angle: f64| {
        let mut turned = theirs.to_vec();
        for k in 1..=order {
            let (sin, cos) = (k as f64 * angle).sin_cos();
            turned[k] = cos * theirs[k] - sin * theirs[order + k];
            turned[order + k] = sin * theirs[k] + cos * theirs[order + k];
        }
        turned
    };
    let mut angle = 0.0;
    for _ in 0..20 {
        let now = turned(angle);
        let (mut slope, mut square) = (0.0, 0.0);
        for k in 1..=order {
            let by_angle = [-(k as f64) * now[order + k], k as f64 * now[k]];
            slope += by_angle[0] * (ours[k] - now[k]) + by_angle[1] * (ours[order + k] - now[order + k]);
            square += by_angle[0].powi(2) + by_angle[1].powi(2);
        }
        angle += slope / square.max(f64::MIN_POSITIVE);
    }
    turned(angle).iter().zip(ours).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Ceres Solver from Debian, with a program of ours around it. Both are compiled for any processor of this kind, as palpate is.
fn ceres(context: &Context, file: &Path) -> anyhow::Result<Worker> {
    let program = context.folder.join("ceres");
    let source = workspace::root().join("bench/peers/ceres/smooth.cpp");
    let changed = |path: &Path| fs::metadata(path).and_then(|data| data.modified()).ok();
    if changed(&program) < changed(&source) {
        if !Path::new("/usr/include/ceres/ceres.h").exists() {
            debian::install(&["g++", "libceres-dev"])?;
        }
        let mut compile = Command::new("g++");
        compile.args(["-std=c++17", "-O3", "-DNDEBUG", "-I/usr/include/eigen3"]).arg(&source).arg("-o").arg(&program);
        workspace::run(compile.args(["-lceres", "-lglog"]))?;
    }
    let mut command = Command::new(program);
    Worker::start(command.arg(file).args(["1", &TOLERANCE.to_string()]), PATIENCE_S)
}

/// `scipy.optimize.least_squares` with sparse derivatives.
fn scipy(context: &Context, file: &Path) -> anyhow::Result<Worker> {
    let mut python = context.python_with(&["numpy", "scipy"])?.python();
    Worker::start(python.arg("bench/peers/smooth_scipy.py").arg(file).arg(TOLERANCE.to_string()), PATIENCE_S)
}

/// IPOPT with the exact second derivatives of CasADi. It stops at a gradient, not at a fall of the cost.
fn casadi(context: &Context, file: &Path) -> anyhow::Result<Worker> {
    let mut python = context.python_with(&["numpy", "casadi"])?.python();
    Worker::start(python.arg("bench/peers/smooth_casadi.py").arg(file), PATIENCE_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_that_differ_by_a_rotation_do_not_differ() {
        let pebble = NamedShape::Pebble.shape(SIZE_M).expect("a valid size");
        let harmonics = pebble.harmonics_m().len();
        let (here, there) = (vector(&pebble, harmonics), vector(&pebble.rotated(0.02), harmonics));
        assert!(largest_difference_m(&here, &there) < 1e-12);
        let mut other = there.clone();
        other[2] += 1e-6;
        assert!((1e-7..2e-6).contains(&largest_difference_m(&here, &other)));
    }
}
