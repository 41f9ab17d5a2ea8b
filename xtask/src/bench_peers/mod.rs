//! `cargo xtask bench-peers`: palpate's speed against that of other people's solvers and engines.
//!
//! The peers are installed by the task itself, under the target folder. palpate and each peer work on the same inputs in the same
//! session, by turns, so that both meet the same machine; what is compared are medians. A faster wrong answer does not count:
//! every row says how far the results agree, and one that does not agree has no ratio. A peer that cannot be had leaves a row
//! with the reason.

mod from_nothing;
mod ode;
mod row;
mod simulation;
mod smoothing;
mod table;
mod turns;
mod worker;

use std::cell::RefCell;
use std::fs;
use std::path::PathBuf;

use anyhow::Context as _;

use crate::python::Environment;
use crate::studies::tables::{self, Place, Table, Write};
use crate::workspace;
use row::Row;
pub use worker::Worker;

/// Versions of the Python packages, from the root of the workspace.
pub const VERSIONS: &str = "bench/peers/requirements.txt";

/// Options of `cargo xtask bench-peers`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder for the table (peers.md, peers.json)
    #[arg(short, long, value_name = "DIR", default_value = "out/peers")]
    output: PathBuf,
    /// Smaller problems and fewer turns: under ten minutes on two processors
    #[arg(long)]
    quick: bool,
    /// Only this job
    #[arg(long, value_name = "JOB", value_parser = clap::builder::PossibleValuesParser::new(JOBS.map(|job| job.name)))]
    only: Option<String>,
    /// Folder of the numpy prototype (grow.py), for those who have it
    #[arg(long, value_name = "DIR")]
    prototype: Option<PathBuf>,
    #[command(flatten)]
    write: Write,
}

impl Arguments {
    /// The command that makes the tables again.
    fn command(&self) -> String {
        let quick = if self.quick { " --quick" } else { "" };
        let only = self.only.as_ref().map(|job| format!(" --only {job}")).unwrap_or_default();
        format!("cargo xtask bench-peers{quick}{only}")
    }

    /// The tables of the documentation that are whole after these jobs: one for smoothing, one for all else.
    fn places(&self) -> &'static [Place] {
        match self.only.as_deref() {
            None => &[tables::PEERS_SMOOTHING, tables::PEERS],
            Some(smoothing::JOB) => &[tables::PEERS_SMOOTHING],
            Some(_) => &[],
        }
    }
}

/// A kind of work that palpate and its peers can both do.
struct Job {
    name: &'static str,
    run: fn(&Context, &mut Vec<Row>) -> anyhow::Result<()>,
}

/// In the order in which they are run.
const JOBS: [Job; 4] = [
    Job { name: "smoothing", run: smoothing::run },
    Job { name: "simulation", run: simulation::run },
    Job { name: "ode", run: ode::run },
    Job { name: "from-nothing", run: from_nothing::run },
];

/// What every job is given.
pub struct Context {
    /// Whether to leave out what takes minutes.
    pub quick: bool,
    /// A folder of the task's own under the target folder, for logs, compiled peers and what they write.
    pub folder: PathBuf,
    /// Where the numpy prototype is.
    pub prototype: Option<PathBuf>,
    python: Environment,
    installed: RefCell<Vec<String>>,
}

impl Context {
    /// The Python of the peers, with these packages installed.
    pub fn python_with(&self, packages: &[&str]) -> anyhow::Result<&Environment> {
        let mut installed = self.installed.borrow_mut();
        let missing: Vec<&str> =
            packages.iter().copied().filter(|&name| !installed.iter().any(|i| i == name)).collect();
        if !missing.is_empty() {
            self.python.install(&missing, VERSIONS)?;
            installed.extend(missing.into_iter().map(str::to_owned));
        }
        Ok(&self.python)
    }
}

/// Runs the jobs, prints the table and saves it, after each job so that nothing is lost when a later one is stopped.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if cfg!(debug_assertions) {
        return as_users_have_it();
    }
    arguments.write.check(arguments.places())?;
    let folder = workspace::target().join("peers");
    for folder in [&folder, &arguments.output] {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let python = Environment::provide_in(folder.clone())?;
    let prototype = arguments.prototype.clone();
    let context = Context { quick: arguments.quick, folder, prototype, python, installed: RefCell::default() };
    let mut rows = Vec::new();
    for job in JOBS.iter().filter(|job| arguments.only.as_ref().is_none_or(|only| only == job.name)) {
        if let Err(error) = (job.run)(&context, &mut rows) {
            rows.push(Row::remark(job.name, "all", format!("{error:#}")));
        }
        table::save(&rows, &arguments.output)?;
    }
    println!("{}", table::markdown(&rows));
    let (smoothing, others): (Vec<Row>, Vec<Row>) = rows.into_iter().partition(|row| row.job == smoothing::JOB);
    let texts = [table::smoothing(&smoothing), table::markdown(&others)];
    let tables: Vec<Table> = arguments.places().iter().copied().zip(texts).collect();
    arguments.write.tables(&tables, &arguments.command())
}

/// The same task again, compiled with the optimisations that users have.
fn as_users_have_it() -> anyhow::Result<()> {
    let mut command = workspace::cargo();
    command.current_dir(std::env::current_dir()?).args(["run", "--quiet", "--release", "--manifest-path"]);
    command.arg(workspace::root().join("Cargo.toml")).args(["--package", "xtask", "--"]);
    workspace::run(command.args(std::env::args_os().skip(1)))
}
