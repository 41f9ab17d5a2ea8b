//! `cargo xtask monte-carlo`: accuracy over many simulated objects.

use anyhow::bail;

/// Options of `cargo xtask monte-carlo`.
#[derive(clap::Args)]
pub struct Arguments {}

/// Runs the study.
pub fn run(_arguments: &Arguments) -> anyhow::Result<()> {
    bail!("not yet: the accuracy study is written together with the estimator")
}
