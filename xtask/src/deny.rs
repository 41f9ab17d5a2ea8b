//! `cargo xtask deny`: licences, sources and security advisories of all dependencies, by cargo-deny and the rules in `deny.toml`. The licences
//! alone are checked by every run of the tests.

use std::process::Command;

use anyhow::bail;

use crate::tools;
use crate::workspace;

/// Checks everything. Advisories come from a database on the network: where it cannot be had, that is an error unless `offline`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Leave the advisories out, whose database is on the network
    #[arg(long)]
    offline: bool,
}

/// Checks what may be depended on.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let check = || -> anyhow::Result<Command> {
        let mut check = tools::DENY.command()?;
        check.arg("check");
        Ok(check)
    };
    workspace::run(check()?.args(["licenses", "bans", "sources"]))?;
    if arguments.offline {
        eprintln!("\nAdvisories were NOT checked: their database is on the network.");
        return Ok(());
    }
    if workspace::run(check()?.arg("advisories")).is_err() {
        bail!("the advisories name a dependency, or their database cannot be reached; --offline leaves them out");
    }
    Ok(())
}
