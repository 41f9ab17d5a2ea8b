//! `cargo xtask monte-carlo`: accuracy, honesty and speed over many simulated objects, as Markdown tables.
//!
//! A sweep of its own: every trial draws an object and a palm motion from its seed, simulates the log, and reconstructs it twice,
//! from nothing and from the truth. *Solved* means that the first is as good as the second (RMS error of r within 1.5 times). The
//! Cramér-Rao bound is evaluated at the truth, with the constants of the rig open where they are drawn. Each trial works on one thread, so that its seconds are its own.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::bail;
use palpate::sensor::Rig;
use palpate_sweep::{
    ActingForces, Conditions, Job, MotionKind, MotionShape, NoiseShape, Object, Outcome, ReconstructChoice, Row,
    ScoreChoice, SimulateJob, Simulated, Source, Status, Sweep, Touchpads, VariedJob,
};
use rayon::prelude::*;

use crate::studies::acting_forces;
use crate::studies::rows;
use crate::studies::tables::{self, Place, Table, Write};

/// Options of `cargo xtask monte-carlo`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Motions that know nothing of the shape, with as many jumps as come (default: motions without jumps).
    #[arg(long)]
    jumps: bool,
    /// Symmetric objects of even mass, in place of the mixture (only with `--jumps`).
    #[arg(long, requires = "jumps")]
    symmetric: bool,
    /// Objects, motions, sensors and logs of many more kinds, each factor drawn by itself (only with `--jumps`).
    #[arg(long, requires = "jumps", conflicts_with = "symmetric")]
    varied: bool,
    /// Of the seeds only those whose noise is as the estimator assumes it and which feel at least 60 % of the boundary (only with `--varied`).
    #[arg(long, requires = "varied")]
    well_felt: bool,
    /// Rigs that nobody calibrated, drawn from the default tolerances (only with `--jumps`, over the mixture).
    #[arg(long, requires = "jumps", conflicts_with_all = ["symmetric", "varied"])]
    rig: bool,
    /// Palms with friction, each object, motion and coefficient drawn.
    #[arg(long, conflicts_with_all = ["jumps", "symmetric", "varied", "rig", "fast", "csv"])]
    friction: bool,
    /// Palms so fast that the inertia of the object counts.
    #[arg(long, conflicts_with_all = ["jumps", "symmetric", "varied", "rig", "csv"])]
    fast: bool,
    /// Trials; with jumps in all, without for each kind of noise [default: 500 with jumps, 200 without].
    #[arg(long)]
    trials: Option<u64>,
    /// Seed of the first trial; of several, as many trials from each on, and one table with a row for each.
    #[arg(long, default_value = "1", value_delimiter = ',')]
    seed: Vec<u64>,
    /// Print a line for each trial that was not solved or not certified.
    #[arg(long)]
    verbose: bool,
    /// Keep the logs (and truths) of such trials, or of the only one, in this folder.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Folder for the table of all trials; a study that was stopped goes on from there.
    #[arg(short, long = "out", value_name = "DIR")]
    out: Option<PathBuf>,
    /// Write a row for each trial, without seconds, for `cargo xtask compare-rows`.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    write: Write,
}

impl Arguments {
    /// Trials from each seed on; without jumps for each kind of noise.
    fn trials(&self) -> u64 {
        self.trials.unwrap_or(if self.jumps || self.forces().is_some() { 500 } else { 200 })
    }

    /// What acts besides gravity.
    fn forces(&self) -> Option<ActingForces> {
        match (self.friction, self.fast) {
            (true, _) => Some(ActingForces::Friction),
            (_, true) => Some(ActingForces::Inertia),
            _ => None,
        }
    }

    /// The command that makes these tables again.
    fn command(&self) -> String {
        self.command_for(self.trials(), &self.seed)
    }

    /// The command that makes so many trials of this study from each of these seeds.
    fn command_for(&self, trials: u64, seeds: &[u64]) -> String {
        let seeds: Vec<String> = seeds.iter().map(u64::to_string).collect();
        let jumps = if self.jumps { " --jumps" } else { "" };
        let symmetric = if self.symmetric { " --symmetric" } else { "" };
        let varied = if self.varied { " --varied" } else { "" };
        let well_felt = if self.well_felt { " --well-felt" } else { "" };
        let rig = if self.rig { " --rig" } else { "" };
        let friction = if self.friction { " --friction" } else { "" };
        let fast = if self.fast { " --fast" } else { "" };
        format!(
            "cargo xtask monte-carlo{jumps}{symmetric}{varied}{well_felt}{rig}{friction}{fast} --trials {trials} --seed {}",
            seeds.join(",")
        )
    }

    /// The tables that this study is for: the whole one, and the short one of the README. None has sets of trials without jumps.
    fn places(&self) -> &'static [Place] {
        match (self.jumps, self.seed.len()) {
            (_, 1) if self.friction => &[tables::MONTE_CARLO_FRICTION],
            (_, 1) if self.fast => &[tables::MONTE_CARLO_FAST],
            (_, 1) if self.well_felt => &[tables::MONTE_CARLO_WELL_FELT],
            (_, 1) if self.varied => &[tables::MONTE_CARLO_VARIED],
            (_, 1) if self.rig => &[tables::MONTE_CARLO_RIG],
            (_, 1) if self.symmetric => &[tables::MONTE_CARLO_SYMMETRIC],
            _ if self.symmetric || self.varied || self.rig || self.friction || self.fast => &[],
            (false, 1) => &[tables::MONTE_CARLO, tables::ACCURACY],
            (true, 1) => &[tables::MONTE_CARLO_JUMPS],
            (true, _) => &[tables::MONTE_CARLO_SETS],
            (false, _) => &[],
        }
    }
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
    /// The seed that its set begins with.
    set: u64,
    seed: u64,
    noise: NoiseKind,
    source: &'a Source,
    outcome: &'a Outcome,
}

impl Trial<'_> {
    fn solved(&self) -> bool {
        self.outcome.row.solved == Some(true)
    }

    fn certified(&self) -> bool {
        self.outcome.row.certified
    }

    /// Certified, and worse than the optimum by more than chance; under varied conditions, of which many have errors that no optimum
    /// knows of, beyond its own error bars.
    fn wrong(&self) -> bool {
        let row = &self.outcome.row;
        match self.source {
            Source::Varied(_) => row.beyond_error_bars == Some(true),
            _ => row.wrong == Some(true),
        }
    }

    fn panicked(&self) -> bool {
        self.outcome.row.status == Status::Panicked
    }

    /// The conditions of a varied trial.
    fn conditions(&self) -> Option<Conditions> {
        match self.source {
            Source::Varied(job) => Some(job.conditions()),
            _ => None,
        }
    }

    /// Whether the noise is as the estimator assumes it.
    fn as_assumed(&self) -> bool {
        self.conditions().is_none_or(|conditions| conditions.as_assumed())
    }

    fn felt(&self) -> f64 {
        number(self.outcome.row.reference_coverage)
    }

    fn seconds(&self) -> f64 {
        number(self.outcome.reconstruct_s)
    }

    fn worth_a_look(&self) -> bool {
        !self.solved()
            || !self.certified()
            || self.wrong()
            || self.outcome.row.symmetry_order > Some(1)
            || self.outcome.row.symmetry_mirror == Some(true)
    }

    fn tell(&self) {
        let row = &self.outcome.row;
        println!(
            "seed {} {} {}: jumps {} felt {:.2} solved {} certified {} wrong {} r {:.4} mm (from truth {:.4}, bound {:.4}) psi {:.2} deg alternatives {} symmetry {}{}{} {:.1} s; {}",
            self.seed,
            row.object,
            self.conditions().map_or_else(
                || self.noise.name(),
                |conditions| {
                    let (motion, sensor) = conditions.words();
                    format!("({motion}; {sensor}; {} samples)", row.samples.unwrap_or(0))
                }
            ),
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
            row.symmetry_order.unwrap_or(0),
            if row.symmetry_mirror == Some(true) { "m" } else { "" },
            row.worst_constant_sds.map_or_else(String::new, |sds| format!(" constants {sds:.1} sd")),
            self.seconds(),
            row.reason
        );
    }

    /// Writes the log and its truth, simulated once more, into a folder.
    fn keep(&self, folder: &Path) -> anyhow::Result<()> {
        let simulated = match self.source {
            Source::Simulate(job) => job.simulate()?,
            Source::Varied(job) => job.simulate()?,
            Source::Forces(_) | Source::Log(_) => return Ok(()),
        };
        let name = format!("{}-{}.csv", self.seed, self.noise.name().replace(' ', "-"));
        keep(folder, &name, simulated)
    }
}

/// Writes a log and its truth into a folder, which is made where it is not there.
pub(super) fn keep(folder: &Path, name: &str, simulated: Simulated) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder)?;
    let path = folder.join(name);
    palpate_io::write_log(&path, &simulated.simulation.log, &[("object".to_owned(), simulated.object)])?;
    palpate_io::write_truth(&palpate_io::truth_dir_of(&path), &simulated.simulation.truth)?;
    Ok(())
}

/// The value below which a share of some sorted values lies; `None` of nothing.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    sorted.get(((sorted.len() as f64 * share) as usize).min(sorted.len().saturating_sub(1))).copied()
}

/// NaN where there is none.
fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

/// Runs the study, prints its tables, and writes them where that is asked for.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.write.check(arguments.places())?;
    if let Some(forces) = arguments.forces() {
        let command = arguments.command();
        let seeds = arguments.seed.iter().flat_map(|first| *first..first + arguments.trials());
        let folders = acting_forces::Folders { out: arguments.out.as_deref(), keep: arguments.keep.as_deref() };
        let text = acting_forces::run(forces, seeds, arguments.verbose, folders, &command)?;
        println!("{text}");
        let tables: Vec<Table> = arguments.places().iter().map(|place| (*place, text.clone())).collect();
        return arguments.write.tables(&tables, &command);
    }
    let started = Instant::now();
    let trials: Vec<(u64, u64, NoiseKind)> =
        arguments.seed.iter().flat_map(|first| set(*first, arguments.trials(), arguments.jumps)).collect();
    let trials: Vec<(u64, u64, NoiseKind)> =
        trials.into_par_iter().filter(|(_, seed, _)| !arguments.well_felt || is_well_felt(*seed)).collect();
    let source = |seed: u64, noise: NoiseKind| match simulation(seed, noise, arguments.jumps) {
        _ if arguments.varied => Source::Varied(VariedJob { seed }),
        job if arguments.rig => Source::Simulate(SimulateJob { rig: Some(Box::new(Rig::uncalibrated())), ..job }),
        job if arguments.symmetric => Source::Simulate(SimulateJob { object: Object::Symmetric, ..job }),
        job => Source::Simulate(job),
    };
    let sources: Vec<Source> = trials.iter().map(|(_, seed, noise)| source(*seed, *noise)).collect();
    let sweep = sweep(&sources);
    let threads = std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let outcomes = match &arguments.out {
        Some(dir) => sweep.run_in(dir, threads, &mut |_| ())?,
        None => sweep.run(threads, &mut |_| ())?,
    };
    if let Some(path) = &arguments.csv {
        rows::write(path, &outcomes)?;
    }
    let trials: Vec<Trial> = trials
        .iter()
        .zip(&sources)
        .zip(&outcomes)
        .filter(|(_, outcome)| outcome.row.status != Status::NoLog)
        .map(|((&(set, seed, noise), source), outcome)| Trial { set, seed, noise, source, outcome })
        .collect();
    if trials.is_empty() {
        bail!("no trial could be simulated");
    }
    if arguments.verbose {
        trials.iter().filter(|trial| trial.worth_a_look()).for_each(Trial::tell);
    }
    for trial in trials.iter().filter(|trial| trial.wrong() || trial.panicked()) {
        let kind = if trial.panicked() { "a panic" } else { "certified and wrong" };
        println!("{kind}: {} --verbose", arguments.command_for(1, &[trial.seed]));
    }
    if let Some(folder) = &arguments.keep {
        for trial in trials.iter().filter(|trial| trials.len() == 1 || trial.worth_a_look()) {
            trial.keep(folder)?;
        }
    }
    let panics = trials.iter().filter(|trial| trial.panicked()).count();
    let remark = format!(
        "{} trials in {:.0} s; {} gave a usable log (the object stayed between the palms{}); {panics} panics.",
        sources.len(),
        started.elapsed().as_secs_f64(),
        trials.len(),
        if arguments.jumps { "" } else { ", did not jump, and half of its boundary was felt" }
    );
    let command = arguments.command();
    let texts: Vec<String> = if let [_] = arguments.seed[..] {
        let groups = groups(&trials, arguments.jumps);
        let long = format!(
            "    {command}\n\n{}{}\n{remark}",
            if arguments.rig { with_cells(HEADING, &RIG_HEADINGS) } else { HEADING.to_owned() },
            groups
                .iter()
                .map(|group| if arguments.rig { with_cells(&row(group), &[&rig_cells(group)]) } else { row(group) })
                .collect::<String>()
        );
        let in_short =
            groups.iter().filter(|group| !arguments.jumps || SHORT_WITH_JUMPS.contains(&group.name.as_str()));
        vec![long, format!("{SHORT_HEADING}{}", in_short.map(short_row).collect::<String>())]
    } else {
        let rows = arguments.seed.iter().filter_map(|first| {
            let of: Vec<&Trial> = trials.iter().filter(|trial| trial.set == *first).collect();
            (!of.is_empty()).then(|| set_row(&Group { name: first.to_string(), of }))
        });
        vec![format!("    {command}\n\n{SETS_HEADING}{}\n{remark}", rows.collect::<String>())]
    };
    println!("{}", texts[0]);
    let tables: Vec<Table> = arguments.places().iter().copied().zip(texts).collect();
    arguments.write.tables(&tables, &command)
}

/// Whether a varied log is one of those that the goals are stated for.
fn is_well_felt(seed: u64) -> bool {
    let job = VariedJob { seed };
    job.conditions().as_assumed() && job.simulate().is_ok_and(|simulated| simulated.felt() >= LEAST_FELT)
}

/// The trials from a seed on: set, seed and noise of each.
pub(crate) fn set(first: u64, trials: u64, jumps: bool) -> Vec<(u64, u64, NoiseKind)> {
    let seeds = first..first + trials;
    if jumps {
        seeds.map(|seed| (first, seed, NOISES[((seed + 3) % 4) as usize])).collect()
    } else {
        NOISES.iter().flat_map(|noise| seeds.clone().map(move |seed| (first, seed, *noise))).collect()
    }
}

/// Trials that have a row of the table.
struct Group<'a> {
    name: String,
    of: Vec<&'a Trial<'a>>,
}

/// All rows of the table that have a trial.
fn groups<'a>(trials: &'a [Trial<'a>], jumps: bool) -> Vec<Group<'a>> {
    let those = |name: String, counts: &dyn Fn(&Trial<'a>) -> bool| Group {
        name,
        of: trials.iter().filter(|trial| counts(trial)).collect(),
    };
    let varied = trials.iter().any(|trial| trial.conditions().is_some());
    let mut groups: Vec<Group> = Vec::new();
    if varied {
        for kind in NoiseShape::ALL {
            groups.push(those(kind.name().to_owned(), &|o| o.conditions().is_some_and(|c| c.sensor.noise == kind)));
        }
        groups.push(those("outliers".to_owned(), &|o| o.conditions().is_some_and(|c| c.sensor.outliers > 0.0)));
        for kind in MotionShape::ALL {
            groups.push(those(kind.name().to_owned(), &|o| o.conditions().is_some_and(|c| c.motion.shape == kind)));
        }
        groups.push(those("noise as assumed".to_owned(), &Trial::as_assumed));
    } else {
        groups.extend(NOISES.iter().map(|noise| those(noise.name(), &|o| o.noise == *noise)));
    }
    groups.push(those(ALL.to_owned(), &|_| true));
    if jumps {
        groups.push(those(WELL_FELT.to_owned(), &|o| o.felt() >= LEAST_FELT && o.as_assumed()));
        for (low, high) in [(0, 0), (1, 2), (3, 5), (6, 9), (10, 1000)] {
            let name = if low == high { format!("{low} jumps") } else { format!("{low} to {high} jumps") };
            groups.push(those(name, &|o| (low..=high).contains(&o.outcome.row.jumps.unwrap_or(0))));
        }
    }
    groups.retain(|group| !group.of.is_empty());
    groups
}

const ALL: &str = "all";
const WELL_FELT: &str = "at least 60 % felt";

/// The share of the boundary meant by that.
const LEAST_FELT: f64 = 0.6;

/// Rows of the short table through jumps.
const SHORT_WITH_JUMPS: [&str; 2] = [ALL, WELL_FELT];

const HEADING: &str = "\
| trials of | logs | solved | certified | certified, wrong | solved, not certified | RMS r / bound (median) | RMS r (median, mm) | inside 95 % band: solved | certified | seconds (median) | (95 %) |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

/// Two more cells for each line of the heading, where rigs are drawn.
const RIG_HEADINGS: [&str; 2] =
    [" certified: constants of the rig inside 95 % band | all within 3 standard deviations |", "---:|---:|"];

const SHORT_HEADING: &str = "\
| trials of | logs | solved | certified | certified, wrong | error of r / Cramér-Rao bound (median) | certified: inside 95 % bands | RMS error of r (median) |
|---|---:|---:|---:|---:|---:|---:|---:|
";

const SETS_HEADING: &str = "\
| seeds from | logs | solved | at least 60 % felt: solved | certified | certified, wrong | solved, not certified | seconds (median) | (95 %) |
|---|---:|---:|---:|---:|---:|---:|---:|---:|
";

impl<'a> Group<'a> {
    /// Share of the trials that pass, percent.
    fn share(&self, test: impl Fn(&Trial<'a>) -> bool) -> f64 {
        100.0 * self.of.iter().filter(|trial| test(trial)).count() as f64 / self.of.len() as f64
    }

    fn wrong(&self) -> usize {
        self.of.iter().filter(|trial| trial.wrong()).count()
    }

    /// Quantile of a value of some of the trials.
    fn quantile(&self, share: f64, counts: impl Fn(&Trial<'a>) -> bool, value: impl Fn(&Trial<'a>) -> f64) -> f64 {
        let mut values: Vec<f64> = self.of.iter().filter(|trial| counts(trial)).map(|trial| value(trial)).collect();
        values.sort_by(f64::total_cmp);
        quantile(&values, share).unwrap_or(f64::NAN)
    }

    /// Error of r over its bound, of the solved ones, median.
    fn over_bound(&self) -> f64 {
        self.quantile(0.5, Trial::solved, |o| number(o.outcome.row.rms_r_m) / number(o.outcome.row.bound_r_m))
    }

    /// Error of r of the solved ones, median, mm.
    fn rms_r_mm(&self) -> f64 {
        1e3 * self.quantile(0.5, Trial::solved, |o| number(o.outcome.row.rms_r_m))
    }

    /// Mean share of the felt boundary inside the band of some of the trials, percent.
    fn inside_band(&self, counts: impl Fn(&Trial<'a>) -> bool) -> f64 {
        let counted = || self.of.iter().filter(|o| counts(o)).filter_map(|o| o.outcome.row.inside_band);
        100.0 * counted().sum::<f64>() / counted().count() as f64
    }

    fn seconds(&self, share: f64) -> f64 {
        self.quantile(share, |_| true, Trial::seconds)
    }
}

fn row(group: &Group) -> String {
    format!(
        "| {} | {} | {:.1} % | {:.1} % | {} | {:.1} % | {:.2} | {:.4} | {:.1} % | {:.1} % | {:.2} | {:.2} |\n",
        group.name,
        group.of.len(),
        group.share(Trial::solved),
        group.share(Trial::certified),
        group.wrong(),
        group.share(|o| o.solved() && !o.certified()),
        group.over_bound(),
        group.rms_r_mm(),
        group.inside_band(Trial::solved),
        group.inside_band(Trial::certified),
        group.seconds(0.5),
        group.seconds(0.95),
    )
}

/// Lines of a table with more cells at the end of each.
fn with_cells(lines: &str, cells: &[&str]) -> String {
    // The last cells go on where there are more lines than cells.
    let cells = cells.iter().chain(std::iter::repeat(cells.last().unwrap_or(&"")));
    lines.lines().zip(cells).map(|(line, cell)| format!("{line}{cell}\n")).collect()
}

/// What the logs told of their rigs.
fn rig_cells(group: &Group) -> String {
    let told =
        |of: fn(&Row) -> Option<f64>| group.of.iter().filter(|o| o.certified()).filter_map(move |o| of(&o.outcome.row));
    let mean_percent = |values: Vec<f64>| 100.0 * values.iter().sum::<f64>() / values.len() as f64;
    let inside: Vec<f64> = told(|row| row.constants_inside_band).collect();
    let within: Vec<f64> = told(|row| row.worst_constant_sds).map(|sds| f64::from(u8::from(sds <= 3.0))).collect();
    format!(" {:.1} % | {:.1} % |", mean_percent(inside), mean_percent(within))
}

fn short_row(group: &Group) -> String {
    format!(
        "| {} | {} | {:.1} % | {:.1} % | {} | {:.2} | {:.1} % | {:.4} mm |\n",
        group.name,
        group.of.len(),
        group.share(Trial::solved),
        group.share(Trial::certified),
        group.wrong(),
        group.over_bound(),
        group.inside_band(Trial::certified),
        group.rms_r_mm(),
    )
}

fn set_row(group: &Group) -> String {
    let well_felt = Group { name: String::new(), of: group.of.iter().copied().filter(|o| o.felt() >= 0.6).collect() };
    format!(
        "| {} | {} | {:.1} % | {:.1} % | {:.1} % | {} | {:.1} % | {:.2} | {:.1} |\n",
        group.name,
        group.of.len(),
        group.share(Trial::solved),
        well_felt.share(Trial::solved),
        group.share(Trial::certified),
        group.wrong(),
        group.share(|o| o.solved() && !o.certified()),
        group.seconds(0.5),
        group.seconds(0.95),
    )
}

/// The simulation of a trial.
pub(crate) fn simulation(seed: u64, noise: NoiseKind, jumps: bool) -> SimulateJob {
    let motion = if jumps { MotionKind::Random } else { MotionKind::RandomJumpFree };
    SimulateJob { seed, object: Object::Mixed, motion, samples: None, touchpads: noise.touchpads(), rig: None }
}

fn sweep(sources: &[Source]) -> Sweep {
    let jobs = sources.iter().map(|source| Job {
        source: source.clone(),
        reconstruct: ReconstructChoice::default(),
        score: ScoreChoice { reference: true, bound: true },
    });
    Sweep { jobs: jobs.collect(), base: PathBuf::new() }
}
