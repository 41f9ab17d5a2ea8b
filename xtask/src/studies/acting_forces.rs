//! `cargo xtask monte-carlo --friction` and `--fast`: from nothing, objects on which friction acts and objects between fast palms, as a Markdown table.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::bail;
use palpate_sweep::{
    ActingForces, BAND_95_SDS, DrawnForces, ForcesJob, Job, Outcome, ReconstructChoice, Row, ScoreChoice, Source,
    Status, Sweep,
};

use crate::studies::monte_carlo::{keep, quantile};

/// A form is right within this share of the mean radius (RMS error after the best translation), a motion within so many radians.
const RIGHT_FORM: f64 = 0.003;
const RIGHT_PSI_RAD: f64 = 1.5 * std::f64::consts::PI / 180.0;

/// A coefficient of friction is wrong beyond so many of its own standard deviations, where it is off by more than harms nobody.
const WRONG_SDS: f64 = 5.0;
const HARMLESS_FRICTION: f64 = 0.005;

/// One trial that gave a log.
struct Trial<'a> {
    job: ForcesJob,
    drawn: DrawnForces,
    outcome: &'a Outcome,
}

impl Trial<'_> {
    fn row(&self) -> &Row {
        &self.outcome.row
    }

    fn is_right(&self) -> bool {
        let row = self.row();
        let form = row.rms_form_m.zip(row.mean_radius_m).is_some_and(|(error, size)| error < RIGHT_FORM * size);
        form && row.rms_psi_rad.is_some_and(|error| error < RIGHT_PSI_RAD)
    }

    fn is_wrong(&self) -> bool {
        let row = self.row();
        let friction = row.com_certified
            && row.worst_friction_sds.is_some_and(|sds| sds > WRONG_SDS)
            && row.worst_friction_error.is_some_and(|error| error > HARMLESS_FRICTION);
        row.beyond_error_bars == Some(true) || friction
    }

    fn tell(&self) {
        let (row, drawn) = (self.row(), self.drawn);
        let sds = |name: &str, of: Option<f64>| of.map_or_else(String::new, |sds| format!(" {name} {sds:.1} sd"));
        println!(
            "seed {} {}: mu {:.3} {:.3} pads {} speed {:.1} samples {} jumps {} felt {:.2} right {} certified {} centre {} wrong {} form {:.4} mm psi {:.2} deg centre {:.4} mm{}{}{} {:.1} s; {}",
            self.job.seed,
            row.object,
            drawn.friction[0],
            drawn.friction[1],
            drawn.measured.iter().filter(|measured| **measured).count(),
            drawn.speed,
            row.samples.unwrap_or(0),
            row.jumps.unwrap_or(0),
            row.coverage.unwrap_or(f64::NAN),
            self.is_right(),
            row.certified,
            row.com_certified,
            self.is_wrong(),
            row.rms_form_m.unwrap_or(f64::NAN) * 1e3,
            row.rms_psi_rad.unwrap_or(f64::NAN).to_degrees(),
            row.rms_com_m.unwrap_or(f64::NAN) * 1e3,
            sds("of the centre", row.com_error_sds),
            sds("of mu", row.worst_friction_sds),
            sds("of k", row.gyration_error_sds),
            self.outcome.reconstruct_s.unwrap_or(f64::NAN),
            row.reason
        );
    }
}

/// Folders of the study: for the table of all trials, and for the logs and truths of those that are not right or not certified.
#[derive(Clone, Copy)]
pub struct Folders<'a> {
    pub out: Option<&'a Path>,
    pub keep: Option<&'a Path>,
}

/// Runs the study and returns its table, with the command that made it above.
pub fn run(
    forces: ActingForces,
    seeds: impl Iterator<Item = u64>,
    verbose: bool,
    folders: Folders,
    command: &str,
) -> anyhow::Result<String> {
    let started = Instant::now();
    let jobs: Vec<ForcesJob> = seeds.map(|seed| ForcesJob { seed, forces }).collect();
    let sweep = Sweep {
        jobs: jobs
            .iter()
            .map(|job| Job {
                source: Source::Forces(*job),
                reconstruct: ReconstructChoice::default(),
                score: ScoreChoice::default(),
            })
            .collect(),
        base: PathBuf::new(),
    };
    let threads = std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let outcomes = match folders.out {
        Some(dir) => sweep.run_in(dir, threads, &mut |_| ())?,
        None => sweep.run(threads, &mut |_| ())?,
    };
    let usable = jobs.iter().zip(&outcomes).filter(|(_, outcome)| outcome.row.status != Status::NoLog);
    let trials: Vec<Trial> = usable.map(|(job, outcome)| Trial { job: *job, drawn: job.drawn(), outcome }).collect();
    if trials.is_empty() {
        bail!("no trial could be simulated");
    }
    for trial in trials.iter().filter(|trial| verbose || trial.is_wrong() || trial.row().status == Status::Panicked) {
        trial.tell();
    }
    if let Some(folder) = folders.keep {
        let is_worth_it = |trial: &&Trial| !trial.is_right() || !trial.row().certified || trial.is_wrong();
        for trial in trials.iter().filter(|trial| trials.len() == 1 || is_worth_it(trial)) {
            keep(folder, &format!("{}.csv", trial.job.seed), trial.job.simulate()?)?;
        }
    }
    let panics = trials.iter().filter(|trial| trial.row().status == Status::Panicked).count();
    let rows: String = groups(forces, &trials).iter().map(|(name, of)| row(name, of)).collect();
    let remark = format!(
        "{} trials in {:.0} s; {} gave a usable log; {panics} panics.",
        jobs.len(),
        started.elapsed().as_secs_f64(),
        trials.len()
    );
    Ok(format!("    {command}\n\n{HEADING}{rows}\n{remark}"))
}

/// The rows of the table.
fn groups<'a>(forces: ActingForces, trials: &'a [Trial<'a>]) -> Vec<(String, Vec<&'a Trial<'a>>)> {
    let of = |name: &str, counts: &dyn Fn(&Trial) -> bool| {
        (name.to_owned(), trials.iter().filter(|trial| counts(trial)).collect::<Vec<_>>())
    };
    let mut groups = vec![of("all", &|_| true)];
    match forces {
        ActingForces::Friction => {
            groups.push(of("no friction", &|t| t.drawn.friction == [0.0; 2]));
            let largest = |t: &Trial| t.drawn.friction[0].max(t.drawn.friction[1]);
            for (low, high) in [(0.0, 0.1), (0.1, 0.2), (0.2, 0.3), (0.3, 0.4)] {
                let name = format!("larger coefficient {low} to {high}");
                groups.push(of(&name, &|t| largest(t) > low && largest(t) <= high));
            }
            groups.push(of("equal on both palms", &|t| t.drawn.friction[0] == t.drawn.friction[1] && largest(t) > 0.0));
            groups.push(of("with measured forces", &|t| t.drawn.measured != [false; 2] && largest(t) > 0.0));
            groups.push(of("without a jump", &|t| t.row().jumps == Some(0) && largest(t) > 0.0));
            groups.push(of("at least 25 % felt", &|t| {
                t.row().coverage.is_some_and(|felt| felt >= 0.25) && largest(t) > 0.0
            }));
        }
        ActingForces::Inertia => {
            for (low, high) in [(1.0, 3.0), (3.0, 10.0), (10.0, 50.0)] {
                groups.push(of(&format!("{low} to {high} times as fast"), &|t| (low..high).contains(&t.drawn.speed)));
            }
        }
    }
    groups.retain(|(_, of)| !of.is_empty());
    groups
}

const HEADING: &str = "\
| trials of | logs | right | certified | with centre of mass | certified, wrong | centre of mass: error (median, mm) | inside 95 % band | friction: error (median) | inside 95 % band | radius of gyration inside 95 % band | seconds (median) | (95 %) |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

fn row(name: &str, of: &[&Trial]) -> String {
    let share = |counts: &dyn Fn(&Trial) -> bool| {
        format!("{:.1} %", 100.0 * of.iter().filter(|trial| counts(trial)).count() as f64 / of.len() as f64)
    };
    // Of what is certified with its centre of mass.
    let told = |value: fn(&Row) -> Option<f64>| -> Vec<f64> {
        let mut values: Vec<f64> =
            of.iter().filter(|trial| trial.row().com_certified).filter_map(|trial| value(trial.row())).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let median = |values: &[f64], digits: usize| {
        quantile(values, 0.5).map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
    };
    let mean = |shares: &[f64]| match shares.len() {
        0 => "–".to_owned(),
        count => format!("{:.1} %", 100.0 * shares.iter().sum::<f64>() / count as f64),
    };
    let inside =
        |sds: &[f64]| mean(&sds.iter().map(|sds| f64::from(u8::from(*sds <= BAND_95_SDS))).collect::<Vec<_>>());
    let mut seconds: Vec<f64> = of.iter().filter_map(|trial| trial.outcome.reconstruct_s).collect();
    seconds.sort_by(f64::total_cmp);
    format!(
        "| {name} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        of.len(),
        share(&|trial| trial.is_right()),
        share(&|trial| trial.row().certified),
        share(&|trial| trial.row().com_certified),
        of.iter().filter(|trial| trial.is_wrong()).count(),
        median(&told(|row| row.rms_com_m.map(|error| 1e3 * error)), 4),
        inside(&told(|row| row.com_error_sds)),
        median(&told(|row| row.worst_friction_error), 4),
        mean(&told(|row| row.friction_inside_band)),
        inside(&told(|row| row.gyration_error_sds)),
        median(&seconds, 1),
        quantile(&seconds, 0.95).map_or_else(|| "–".to_owned(), |value| format!("{value:.1}")),
    )
}
