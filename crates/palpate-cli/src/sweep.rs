//! `palpate sweep`: a plan in, thousands of logs simulated or read and reconstructed, one table out.

use std::num::NonZero;
use std::path::{Path, PathBuf};

use palpate_sweep::table::{RESULTS_FILE, SECONDS_FILE};
use palpate_sweep::{Outcome, PlanError, Status, Sweep, SweepError, read_plan};

use crate::counted_progress::CountedProgress;
use crate::terminal::{Ending, Failure, Terminal};

const AFTER_HELP: &str = "\
A plan is a small TOML file. This one tries two objects with two kinds of noise and 100 seeds each, 400 jobs:

  kind = \"simulate\"
  trials = 100
  objects.named = { name = [\"egg\", \"stone\"], mean_radius_m = 0.03 }
  touchpads = [{ noise_sd_m = [0.1e-3, 0.3e-3] }]

and this one reconstructs recorded logs, and measures the errors of those with a truth folder beside them:

  kind = \"reconstruct\"
  logs = \"trials/*.csv\"

docs/sweeps.md has every key of a plan and every column of the table; examples/sweeps/ has plans to try.

DIR receives results.parquet, a row for each job in the order of the plan, and seconds.csv with the time each job took. A sweep
that was stopped resumes when the same command is given again; journal.jsonl holds what is finished. On one kind of processor and one
platform the bytes of results.parquet depend neither on the number of threads nor on interruptions.

Exit codes: 0 all jobs are done, certified or not;  2 bad plan or usage;  1 anything else.";

/// Reconstruct thousands of logs, simulated or recorded, into one table
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// The plan, a TOML file
    #[arg(value_name = "PLAN.toml")]
    plan: PathBuf,
    /// Folder for the tables, made if missing; to resume a sweep that was stopped, its folder
    #[arg(short, long = "out", value_name = "DIR")]
    out: PathBuf,
    /// Threads to work with [default: as many as there are processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Does what is not done yet, and says how it went.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    let plan = read_plan(&arguments.plan)?;
    let base = arguments.plan.parent().filter(|base| !base.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let sweep = Sweep::new(&plan, base)?;
    let threads = match arguments.threads.and_then(|threads| NonZero::new(threads.into())) {
        Some(threads) => threads,
        None => std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN),
    };
    let mut earlier = None;
    let outcomes = {
        let bar = CountedProgress::new(&terminal);
        sweep.run_in(&arguments.out, threads, &mut |done| {
            earlier.get_or_insert(done.finished);
            bar.update(done.finished, done.jobs);
        })?
    };
    terminal.say(&told(&outcomes, earlier.unwrap_or(0), &arguments.out))?;
    Ok(Ending::Success)
}

/// How it went, in a few lines.
fn told(outcomes: &[Outcome], earlier: u64, out: &Path) -> String {
    let count = |test: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|outcome| test(outcome)).count();
    let mut lines = vec![format!(
        "{} jobs{}: {} reconstructed, {} of them certified",
        outcomes.len(),
        if earlier > 0 { format!(", {earlier} of them finished before") } else { String::new() },
        count(&|outcome| outcome.row.status == Status::Reconstructed),
        count(&|outcome| outcome.row.certified),
    )];
    for (status, what) in [(Status::NoLog, "without a log"), (Status::NoResult, "without a result")] {
        let some = count(&|outcome| outcome.row.status == status);
        if some > 0 {
            lines.push(format!("  {some} {what}; the column reason says why"));
        }
    }
    lines.push(format!("  table    {}", out.join(RESULTS_FILE).display()));
    lines.push(format!("  seconds  {}", out.join(SECONDS_FILE).display()));
    lines.join("\n")
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Write(error) => error.into(),
            SweepError::Io { .. } | SweepError::Threads(_) | SweepError::Encode(_) => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}
