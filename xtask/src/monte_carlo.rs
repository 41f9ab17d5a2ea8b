//! `cargo xtask monte-carlo`: accuracy, honesty and speed over many simulated objects, as Markdown tables.
//!
//! Every trial draws an object and a palm motion from its seed, simulates the log, and reconstructs it twice: from nothing,
//! and from the truth. *Solved* means that the first is as good as the second (RMS error of r within 1.5 times). The
//! Cramér-Rao bound is evaluated at the truth.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, bail};
use palpate::compare::{compare, true_support};
use palpate::palms::{PalmMotion, PalmPair};
use palpate::reconstruct::{
    OutlinePoint, Pose, ReconstructOptions, Reconstruction, cramer_rao_bound_m, reconstruct, reconstruct_from,
};
use palpate::sensor::Touchpad;
use palpate::shape::{RandomShape, SupportFunction, ellipse, random_shape, rounded_polygon};
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use palpate::{Log, Truth};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Options of `cargo xtask monte-carlo`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Motions that know nothing of the shape, with as many jumps as come (default: motions without jumps).
    #[arg(long)]
    jumps: bool,
    /// Trials; with jumps in all, without for each kind of noise [default: 500 with jumps, 200 without].
    #[arg(long)]
    trials: Option<u64>,
    /// Seed of the first trial.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print a line for each trial that was not solved or not certified.
    #[arg(long)]
    verbose: bool,
    /// Keep the logs (and truths) of such trials in this folder.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
}

/// How the pads err.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum NoiseKind {
    Gaussian(f64),
    CountsPerInch(f64),
}

const NOISES: [NoiseKind; 4] = [
    NoiseKind::Gaussian(0.03e-3),
    NoiseKind::Gaussian(0.1e-3),
    NoiseKind::Gaussian(0.3e-3),
    NoiseKind::CountsPerInch(200.0),
];

impl NoiseKind {
    fn name(self) -> String {
        match self {
            Self::Gaussian(sd) => format!("{:.2} mm", sd * 1e3),
            Self::CountsPerInch(counts) => format!("{counts} counts per inch"),
        }
    }

    fn sd_m(self) -> f64 {
        match self {
            Self::Gaussian(sd) => sd,
            Self::CountsPerInch(counts) => 0.0254 / counts / 12f64.sqrt(),
        }
    }

    fn pad(self) -> Touchpad {
        match self {
            Self::Gaussian(noise_sd_m) => Touchpad { noise_sd_m, ..Touchpad::ideal() },
            Self::CountsPerInch(counts) => Touchpad { counts_per_inch: Some(counts), ..Touchpad::ideal() },
        }
    }
}

/// What one trial came to.
struct Outcome {
    seed: u64,
    object: String,
    noise: NoiseKind,
    jumps: usize,
    felt: f64,
    certified: bool,
    com_certified: bool,
    solved: bool,
    /// Certified, and worse than the optimum by more than chance.
    wrong: bool,
    rms_r_m: f64,
    reference_m: f64,
    bound_m: f64,
    rms_psi_rad: f64,
    /// Share of the felt outline inside its 95 % band.
    inside: f64,
    alternatives: usize,
    seconds: f64,
    reason: String,
    /// The log and its truth, where they are to be kept.
    kept: Option<(Log, Truth)>,
}

impl Outcome {
    fn worth_a_look(&self) -> bool {
        !self.solved || !self.certified || self.wrong
    }
}

/// Runs the study and prints its tables.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let trials: Vec<(u64, NoiseKind)> = if arguments.jumps {
        (0..arguments.trials.unwrap_or(500))
            .map(|i| (arguments.seed + i, NOISES[(arguments.seed + i + 3) as usize % 4]))
            .collect()
    } else {
        let each = arguments.trials.unwrap_or(200);
        NOISES.iter().flat_map(|noise| (0..each).map(|i| (arguments.seed + i, *noise))).collect()
    };
    let count = trials.len();
    let outcomes: Vec<Outcome> = trials
        .into_par_iter()
        .map(|(seed, noise)| trial(seed, noise, arguments).with_context(|| format!("trial {seed}")))
        .filter_map(|outcome| match outcome {
            Ok(outcome) => outcome.map(Ok),
            Err(error) => Some(Err(error)),
        })
        .collect::<anyhow::Result<_>>()?;
    if outcomes.is_empty() {
        bail!("no trial could be simulated");
    }
    if arguments.verbose {
        for o in outcomes.iter().filter(|o| o.worth_a_look()) {
            println!(
                "seed {} {} {}: jumps {} felt {:.2} solved {} certified {} wrong {} r {:.4} mm (from truth {:.4}, bound {:.4}) psi {:.2} deg alternatives {} {:.1} s; {}",
                o.seed,
                o.object,
                o.noise.name(),
                o.jumps,
                o.felt,
                o.solved,
                o.certified,
                o.wrong,
                o.rms_r_m * 1e3,
                o.reference_m * 1e3,
                o.bound_m * 1e3,
                o.rms_psi_rad.to_degrees(),
                o.alternatives,
                o.seconds,
                o.reason
            );
        }
    }
    if let Some(folder) = &arguments.keep {
        std::fs::create_dir_all(folder)?;
        for o in &outcomes {
            if let Some((log, truth)) = &o.kept {
                let path = folder.join(format!("{}-{}.csv", o.seed, o.noise.name().replace(' ', "-")));
                palpate_io::write_log(&path, log, &[("object".to_owned(), o.object.clone())])?;
                palpate_io::write_truth(&palpate_io::truth_dir_of(&path), truth)?;
            }
        }
    }
    heading();
    for noise in NOISES {
        row(&noise.name(), &outcomes.iter().filter(|o| o.noise == noise).collect::<Vec<_>>());
    }
    row("all", &outcomes.iter().collect::<Vec<_>>());
    if arguments.jumps {
        row("at least 60 % felt", &outcomes.iter().filter(|o| o.felt >= 0.6).collect::<Vec<_>>());
        for (low, high) in [(0, 0), (1, 2), (3, 5), (6, 9), (10, 1000)] {
            let of = outcomes.iter().filter(|o| (low..=high).contains(&o.jumps)).collect::<Vec<_>>();
            row(&if low == high { format!("{low} jumps") } else { format!("{low} to {high} jumps") }, &of);
        }
    }
    println!(
        "\n{count} trials in {:.0} s; {} gave a usable log (the object stayed between the palms{}).",
        started.elapsed().as_secs_f64(),
        outcomes.len(),
        if arguments.jumps { "" } else { ", did not jump, and half of its boundary was felt" }
    );
    Ok(())
}

fn heading() {
    println!(
        "| trials of | logs | solved | certified | certified, wrong | solved, not certified | RMS r / bound (median) | RMS r (median, mm) | inside 95 % band | seconds (median) | (95 %) |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
}

fn row(name: &str, of: &[&Outcome]) {
    if of.is_empty() {
        return;
    }
    let share =
        |test: &dyn Fn(&Outcome) -> bool| 100.0 * of.iter().filter(|o| test(o)).count() as f64 / of.len() as f64;
    let solved: Vec<&&Outcome> = of.iter().filter(|o| o.solved).collect();
    let quantile = |values: Vec<f64>, q: f64| {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values
            .get(((values.len() as f64 * q) as usize).min(values.len().saturating_sub(1)))
            .copied()
            .unwrap_or(f64::NAN)
    };
    println!(
        "| {name} | {} | {:.1} % | {:.1} % | {} | {:.1} % | {:.2} | {:.4} | {:.1} % | {:.2} | {:.2} |",
        of.len(),
        share(&|o| o.solved),
        share(&|o| o.certified),
        of.iter().filter(|o| o.wrong).count(),
        share(&|o| o.solved && !o.certified),
        quantile(solved.iter().map(|o| o.rms_r_m / o.bound_m).collect(), 0.5),
        1e3 * quantile(solved.iter().map(|o| o.rms_r_m).collect(), 0.5),
        100.0 * solved.iter().map(|o| o.inside).sum::<f64>() / solved.len().max(1) as f64,
        quantile(of.iter().map(|o| o.seconds).collect(), 0.5),
        quantile(of.iter().map(|o| o.seconds).collect(), 0.95),
    );
}

/// A random object: Fourier of order 3 to 8, an ellipse or a rounded polygon, its centre of mass up to 0.2 radius from the
/// centroid.
pub(crate) fn object(rng: &mut ChaCha8Rng) -> anyhow::Result<(String, SupportFunction)> {
    let radius = rng.random_range(0.018..0.04);
    let (name, shape) = match rng.random_range(0..3) {
        0 => {
            let order = rng.random_range(3..=8);
            let kind = RandomShape { mean_radius_m: radius, order, mass_offset: 0.0, ..RandomShape::default() };
            (format!("Fourier {order}"), random_shape(&kind, rng.random())?)
        }
        1 => {
            let ratio = rng.random_range(0.55..0.9);
            (format!("ellipse {ratio:.2}"), ellipse(radius * 1.15, radius * 1.15 * ratio)?)
        }
        _ => {
            let corners = rng.random_range(3..=6);
            let smoothness: f64 = rng.random_range(0.3..0.5);
            let shape = rounded_polygon(corners, rng.random_range(0.2..0.5), smoothness)?;
            let scaled = shape.harmonics_m().iter().map(|[a, b]| [a * radius, b * radius]).collect();
            (format!("polygon {corners}"), SupportFunction::new(shape.mean_radius_m() * radius, scaled))
        }
    };
    let centroid = shape.centroid();
    let (off, towards) = (0.2 * radius * rng.random_range(0.0f64..1.0).sqrt(), rng.random_range(0.0..TAU));
    let shape = shape.translated(off * towards.cos() - centroid.x_m, off * towards.sin() - centroid.y_m);
    Ok((name, shape.rotated(rng.random_range(0.0..TAU))))
}

/// A motion and what the palms feel; `None` when the object leaves the palms, or jumps where it must not.
pub(crate) fn felt(shape: &SupportFunction, noise: NoiseKind, jumps: bool, rng: &mut ChaCha8Rng) -> Option<Simulation> {
    let samples = rng.random_range(600..=1200);
    for attempt in 0..if jumps { 5 } else { 60 } {
        let amplitude = if jumps { 1.0 } else { rng.random_range(0.3..1.0) };
        let motion = PalmMotion::random(rng.random(), 0.01 * f64::from(samples - 1), amplitude).ok()?;
        let motion: Vec<(f64, PalmPair)> = motion.sample(100.0).ok()?;
        let options = SimulateOptions {
            touchpad: noise.pad(),
            seed: rng.random(),
            start_psi_rad: rng.random_range(0.0..TAU),
            ..SimulateOptions::default()
        };
        let Ok(simulation) = simulate(shape, &motion, &options) else { continue };
        if jumps || (simulation.jumps.is_empty() && coverage(&simulation) > if attempt < 40 { 0.5 } else { 0.4 }) {
            return Some(simulation);
        }
    }
    None
}

/// Share of the boundary between the lowest and the highest contact angles, jumps aside.
fn coverage(simulation: &Simulation) -> f64 {
    let mut seen = [false; 360];
    for (sample, pose) in simulation.log.samples.iter().zip(&simulation.truth.motion) {
        let (one, two) = sample.palms.contact_angles(pose.psi_rad);
        for theta in [one, two] {
            seen[(theta.rem_euclid(TAU) / TAU * 360.0) as usize % 360] = true;
        }
    }
    seen.iter().filter(|seen| **seen).count() as f64 / 360.0
}

fn trial(seed: u64, noise: NoiseKind, arguments: &Arguments) -> anyhow::Result<Option<Outcome>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (object, shape) = object(&mut rng)?;
    let Some(simulation) = felt(&shape, noise, arguments.jumps, &mut rng) else { return Ok(None) };
    let Simulation { log, truth, jumps } = simulation;
    let options = ReconstructOptions::default();
    let clock = Instant::now();
    let found = reconstruct(&log, &options, &|_| ());
    let seconds = clock.elapsed().as_secs_f64();
    let psi: Vec<f64> = truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let reference = reconstruct_from(&log, &shape, &psi, &options)?;
    let from_truth = compare(&reference, &truth)?;
    let (reference_m, reference_psi) = (from_truth.rms_r_m, from_truth.rms_psi_rad);
    let bound_m = cramer_rao_bound_m(&log, &shape, &psi, noise.sd_m()).unwrap_or(f64::NAN);
    let mut outcome = Outcome {
        seed,
        object,
        noise,
        jumps: jumps.len(),
        felt: reference.coverage,
        certified: false,
        com_certified: false,
        solved: false,
        wrong: false,
        rms_r_m: f64::NAN,
        reference_m,
        bound_m,
        rms_psi_rad: f64::NAN,
        inside: 0.0,
        alternatives: 0,
        seconds,
        reason: String::new(),
        kept: None,
    };
    match found {
        Ok(found) => {
            let errors = compare(&found, &truth)?;
            outcome.rms_r_m = errors.rms_r_m;
            outcome.rms_psi_rad = errors.rms_psi_rad;
            let near = 1.5 * reference_m + 1e-6;
            outcome.solved = errors.rms_r_m <= near;
            outcome.certified = found.certified;
            outcome.com_certified = found.com_certified;
            outcome.wrong = found.certified
                && (errors.rms_r_m > (3.0 * reference_m).max(4.0 * bound_m) + 1e-6
                    || errors.rms_psi_rad > (3.0 * reference_psi).max(0.02));
            outcome.inside = inside_band(&found, &truth)?;
            outcome.alternatives = found.alternatives;
            outcome.reason = found.reason.clone();
        }
        Err(error) => outcome.reason = error.to_string(),
    }
    if arguments.keep.is_some() && outcome.worth_a_look() {
        outcome.kept = Some((log, truth));
    }
    Ok(Some(outcome))
}

/// Share of the felt outline whose true r lies inside the 95 % band, after the best rotation.
fn inside_band(found: &Reconstruction, truth: &Truth) -> anyhow::Result<f64> {
    let shape = true_support(truth)?;
    let felt: Vec<&OutlinePoint> = found.outline.iter().filter(|point| point.touches > 0).collect();
    let (mut sin, mut cos) = (0.0, 0.0);
    for (Pose { psi_rad, .. }, real) in found.motion.iter().zip(&truth.motion) {
        sin += (real.psi_rad - psi_rad).sin();
        cos += (real.psi_rad - psi_rad).cos();
    }
    let mut turn = sin.atan2(cos);
    // Gauss-Newton for the rotation that the bands leave out: unweighted least squares over the felt outline.
    for _ in 0..20 {
        let (mut slope, mut curvature) = (0.0, 0.0);
        for point in &felt {
            let at = shape.at(point.theta_rad - turn);
            // ∂r(θ − turn)/∂turn = −r' = d.
            slope += (at.r - point.r_m) * at.d;
            curvature += at.d * at.d;
        }
        if curvature > 0.0 {
            turn -= slope / curvature;
        }
    }
    let inside =
        felt.iter().filter(|point| (shape.at(point.theta_rad - turn).r - point.r_m).abs() <= 1.959_964 * point.r_sd_m);
    Ok(inside.count() as f64 / felt.len().max(1) as f64)
}
