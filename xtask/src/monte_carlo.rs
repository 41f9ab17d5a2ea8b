//! `cargo xtask monte-carlo`: accuracy, honesty and speed over many simulated objects, as Markdown tables.
//!
//! A sweep of its own: every trial draws an object and a palm motion from its seed, simulates the log, and reconstructs it twice,
//! from nothing and from the truth. *Solved* means that the first is as good as the second (RMS error of r within 1.5 times). The
//! Cramér-Rao bound is evaluated at the truth. Each trial works on one thread, so that its seconds are its own.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::bail;
use palpate_sweep::{
    Job, MotionKind, Object, Outcome, ReconstructChoice, ScoreChoice, SimulateJob, Source, Status, Sweep, Touchpads,
};

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
    /// Folder for the table of all trials; a study that was stopped goes on from there.
    #[arg(short, long = "out", value_name = "DIR")]
    out: Option<PathBuf>,
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

    pub(crate) fn touchpads(self) -> Touchpads {
        match self {
            Self::Gaussian(noise_sd_m) => Touchpads { noise_sd_m, ..Touchpads::default() },
            Self::CountsPerInch(counts) => Touchpads { counts_per_inch: Some(counts), ..Touchpads::default() },
        }
    }
}

/// One trial that gave a log, and what it came to.
struct Trial<'a> {
    seed: u64,
    noise: NoiseKind,
    job: &'a SimulateJob,
    outcome: &'a Outcome,
}

impl Trial<'_> {
    fn solved(&self) -> bool {
        self.outcome.row.solved == Some(true)
    }

    /// Certified, and worse than the optimum by more than chance.
    fn wrong(&self) -> bool {
        self.outcome.row.wrong == Some(true)
    }

    fn felt(&self) -> f64 {
        number(self.outcome.row.reference_coverage)
    }

    fn seconds(&self) -> f64 {
        number(self.outcome.reconstruct_s)
    }

    fn worth_a_look(&self) -> bool {
        !self.solved() || !self.outcome.row.certified || self.wrong()
    }

    fn tell(&self) {
        let row = &self.outcome.row;
        println!(
            "seed {} {} {}: jumps {} felt {:.2} solved {} certified {} wrong {} r {:.4} mm (from truth {:.4}, bound {:.4}) psi {:.2} deg alternatives {} {:.1} s; {}",
            self.seed,
            row.object,
            self.noise.name(),
            row.jumps.unwrap_or(0),
            self.felt(),
            self.solved(),
            row.certified,
            self.wrong(),
            number(row.rms_r_m) * 1e3,
            number(row.reference_rms_r_m) * 1e3,
            number(row.bound_r_m) * 1e3,
            number(row.rms_psi_rad).to_degrees(),
            row.alternatives.unwrap_or(0),
            self.seconds(),
            row.reason
        );
    }

    /// Writes the log and its truth, simulated once more, into a folder.
    fn keep(&self, folder: &Path) -> anyhow::Result<()> {
        let simulated = self.job.simulate()?;
        let path = folder.join(format!("{}-{}.csv", self.seed, self.noise.name().replace(' ', "-")));
        palpate_io::write_log(&path, &simulated.simulation.log, &[("object".to_owned(), simulated.object)])?;
        palpate_io::write_truth(&palpate_io::truth_dir_of(&path), &simulated.simulation.truth)?;
        Ok(())
    }
}

/// The value below which a share of some sorted values lies; `None` of nothing.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    sorted.get(((sorted.len() as f64 * share) as usize).min(sorted.len().saturating_sub(1))).copied()
}

/// NaN where there is none.
fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
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
    let jobs: Vec<SimulateJob> =
        trials.iter().map(|(seed, noise)| simulation(*seed, *noise, arguments.jumps)).collect();
    let sweep = sweep(&jobs);
    let threads = std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let outcomes = match &arguments.out {
        Some(dir) => sweep.run_in(dir, threads, &mut |_| ())?,
        None => sweep.run(threads, &mut |_| ())?,
    };
    let trials: Vec<Trial> = trials
        .iter()
        .zip(&jobs)
        .zip(&outcomes)
        .filter(|(_, outcome)| outcome.row.status != Status::NoLog)
        .map(|((&(seed, noise), job), outcome)| Trial { seed, noise, job, outcome })
        .collect();
    if trials.is_empty() {
        bail!("no trial could be simulated");
    }
    if arguments.verbose {
        trials.iter().filter(|trial| trial.worth_a_look()).for_each(Trial::tell);
    }
    if let Some(folder) = &arguments.keep {
        std::fs::create_dir_all(folder)?;
        for trial in trials.iter().filter(|trial| trial.worth_a_look()) {
            trial.keep(folder)?;
        }
    }
    heading();
    for noise in NOISES {
        row(&noise.name(), &trials.iter().filter(|o| o.noise == noise).collect::<Vec<_>>());
    }
    row("all", &trials.iter().collect::<Vec<_>>());
    if arguments.jumps {
        row("at least 60 % felt", &trials.iter().filter(|o| o.felt() >= 0.6).collect::<Vec<_>>());
        for (low, high) in [(0, 0), (1, 2), (3, 5), (6, 9), (10, 1000)] {
            let of =
                trials.iter().filter(|o| (low..=high).contains(&o.outcome.row.jumps.unwrap_or(0))).collect::<Vec<_>>();
            row(&if low == high { format!("{low} jumps") } else { format!("{low} to {high} jumps") }, &of);
        }
    }
    println!(
        "\n{} trials in {:.0} s; {} gave a usable log (the object stayed between the palms{}).",
        jobs.len(),
        started.elapsed().as_secs_f64(),
        trials.len(),
        if arguments.jumps { "" } else { ", did not jump, and half of its boundary was felt" }
    );
    Ok(())
}

fn heading() {
    println!(
        "| trials of | logs | solved | certified | certified, wrong | solved, not certified | RMS r / bound (median) | RMS r (median, mm) | inside 95 % band: solved | certified | seconds (median) | (95 %) |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
}

fn row(name: &str, of: &[&Trial]) {
    if of.is_empty() {
        return;
    }
    let share = |test: &dyn Fn(&Trial) -> bool| 100.0 * of.iter().filter(|o| test(o)).count() as f64 / of.len() as f64;
    let solved: Vec<&&Trial> = of.iter().filter(|o| o.solved()).collect();
    let quantile = |mut values: Vec<f64>, share: f64| {
        values.sort_by(f64::total_cmp);
        quantile(&values, share).unwrap_or(f64::NAN)
    };
    let inside_band = |counts: &dyn Fn(&Trial) -> bool| {
        let counted = || of.iter().filter(|o| counts(o)).filter_map(|o| o.outcome.row.inside_band);
        100.0 * counted().sum::<f64>() / counted().count() as f64
    };
    println!(
        "| {name} | {} | {:.1} % | {:.1} % | {} | {:.1} % | {:.2} | {:.4} | {:.1} % | {:.1} % | {:.2} | {:.2} |",
        of.len(),
        share(&|o| o.solved()),
        share(&|o| o.outcome.row.certified),
        of.iter().filter(|o| o.wrong()).count(),
        share(&|o| o.solved() && !o.outcome.row.certified),
        quantile(solved.iter().map(|o| number(o.outcome.row.rms_r_m) / number(o.outcome.row.bound_r_m)).collect(), 0.5),
        1e3 * quantile(solved.iter().map(|o| number(o.outcome.row.rms_r_m)).collect(), 0.5),
        inside_band(&|o| o.solved()),
        inside_band(&|o| o.outcome.row.certified),
        quantile(of.iter().map(|o| o.seconds()).collect(), 0.5),
        quantile(of.iter().map(|o| o.seconds()).collect(), 0.95),
    );
}

/// The simulation of a trial.
pub(crate) fn simulation(seed: u64, noise: NoiseKind, jumps: bool) -> SimulateJob {
    let motion = if jumps { MotionKind::Random } else { MotionKind::RandomJumpFree };
    SimulateJob { seed, object: Object::Mixed, motion, samples: None, touchpads: noise.touchpads() }
}

fn sweep(simulations: &[SimulateJob]) -> Sweep {
    let jobs = simulations.iter().map(|simulation| Job {
        source: Source::Simulate(simulation.clone()),
        reconstruct: ReconstructChoice::default(),
        score: ScoreChoice { reference: true, bound: true },
    });
    Sweep { jobs: jobs.collect(), base: PathBuf::new() }
}
