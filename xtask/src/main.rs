//! Development tasks: `cargo xtask test`, `cargo xtask doc`, `cargo xtask guide`, `cargo xtask dist`, `cargo xtask deny`, `cargo xtask monte-carlo`, `cargo xtask limits`,
//! `cargo xtask compare-rows`, `cargo xtask methods`, `cargo xtask paper`, `cargo xtask slips`, `cargo xtask python-cost`, `cargo xtask ray-cost`, `cargo xtask bench-peers`, `cargo xtask bench-live`,
//! `cargo xtask fuzz`. Without a task it lists them.
#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "tables and progress go to the terminal")]

mod axe;
mod bench_peers;
mod browser;
mod debian;
mod deny;
mod dist;
mod doc;
#[cfg(test)]
mod docs;
mod fuzz;
mod guide;
#[cfg(test)]
mod packages;
mod python;
mod studies;
mod test;
mod tools;
mod workspace;

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

/// Development tasks.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    task: Option<Task>,
}

#[derive(Subcommand)]
enum Task {
    /// Run every test of the workspace: units, properties, documentation, command line, the report in a browser, and Python.
    Test(test::Arguments),
    /// Make the documentation of the crates with formulas rendered, complete in one folder.
    Doc(doc::Arguments),
    /// Make the documentation as one site with search, and the references of Python and Rust in it.
    Guide(guide::Arguments),
    /// Make everything that is handed to others: the program, the Debian package, the wheel, the sources, notices and checksums.
    Dist(dist::Arguments),
    /// Check licences, sources and security advisories of all dependencies.
    Deny(deny::Arguments),
    /// Measure accuracy over many simulated objects and write the tables that the documentation quotes.
    MonteCarlo(studies::monte_carlo::Arguments),
    /// Measure accuracy and honesty of strokes of a pivoting grasp over many simulated objects, and print the table as Markdown
    MonteCarloPivot(studies::pivot::Arguments),
    /// Count what half and twice each limit of the certificate would do, and write the table that the documentation quotes.
    Limits(studies::limits::Arguments),
    /// Compare the trials of two studies row by row; fails where a verdict differs.
    CompareRows(studies::rows::Arguments),
    /// Compare the paper's method with maximum likelihood on the same logs, and write the table that the documentation quotes.
    Methods(studies::methods::Arguments),
    /// Make the figures of the paper, and write their errors and pictures into the documentation.
    Paper(studies::paper::Arguments),
    /// Make the usual mistakes in right logs, count those that are named, and write the table that the documentation quotes.
    Slips(studies::slips::Arguments),
    /// Measure the overhead of a reconstruction from Python over one from Rust.
    PythonCost(studies::python_cost::Arguments),
    /// Measure the overhead of a sweep on a Ray cluster over one on the threads of this machine.
    RayCost(studies::ray_cost::Arguments),
    /// Compare the speed of palpate with other solvers and engines on the same inputs, and write the table that the documentation quotes.
    BenchPeers(bench_peers::Arguments),
    /// Measure time, memory and delay of the online estimator, and write the tables that the documentation quotes.
    BenchLive(studies::bench_live::Arguments),
    /// Feed random inputs to the reader of logs and the estimator, and keep those on which they fail.
    Fuzz(fuzz::Arguments),
}

fn main() -> ExitCode {
    let done = match Arguments::parse().task {
        Some(Task::Test(arguments)) => test::run(&arguments),
        Some(Task::Doc(arguments)) => doc::run(&arguments),
        Some(Task::Guide(arguments)) => guide::run(&arguments),
        Some(Task::Dist(arguments)) => dist::run(&arguments),
        Some(Task::Deny(arguments)) => deny::run(&arguments),
        Some(Task::MonteCarlo(arguments)) => studies::monte_carlo::run(&arguments),
        Some(Task::MonteCarloPivot(arguments)) => studies::pivot::run(&arguments),
        Some(Task::Limits(arguments)) => studies::limits::run(&arguments),
        Some(Task::CompareRows(arguments)) => studies::rows::run(&arguments),
        Some(Task::Methods(arguments)) => studies::methods::run(&arguments),
        Some(Task::Paper(arguments)) => studies::paper::run(&arguments),
        Some(Task::Slips(arguments)) => studies::slips::run(&arguments),
        Some(Task::PythonCost(arguments)) => studies::python_cost::run(&arguments),
        Some(Task::RayCost(arguments)) => studies::ray_cost::run(&arguments),
        Some(Task::BenchPeers(arguments)) => bench_peers::run(&arguments),
        Some(Task::BenchLive(arguments)) => studies::bench_live::run(&arguments),
        Some(Task::Fuzz(arguments)) => fuzz::run(&arguments),
        None => Arguments::command().print_help().map_err(Into::into),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
