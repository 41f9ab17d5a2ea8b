//! `cargo xtask doc`: the documentation of the crates with formulas rendered, complete in one folder and without a network.

use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::Command;

use clap::Args;

use crate::workspace;

/// What renders formulas.
const KATEX: &str = "crates/palpate/katex";
/// What of it belongs beside the pages.
const FILES: [&str; 3] = ["katex.min.js", "katex.min.css", "LICENSE"];

/// Which documentation.
#[derive(Args)]
pub struct Arguments {
    /// The crate to document.
    #[arg(long, short, default_value = "palpate")]
    package: String,
    /// Show it in a browser.
    #[arg(long)]
    open: bool,
}

/// The crates that others build on.
pub const LIBRARIES: [&str; 5] = ["palpate", "palpate-io", "palpate-live", "palpate-report", "palpate-sweep"];

/// Makes the pages of one crate, and says where they are.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let pages = make(&[&arguments.package])?.join(arguments.package.replace('-', "_")).join("index.html");
    if arguments.open {
        let mut command = workspace::cargo();
        documenting(&mut command, &[&arguments.package]);
        workspace::run(command.arg("--open"))?;
    }
    println!("{}", pages.display());
    Ok(())
}

/// Where pages are.
pub fn folder() -> PathBuf {
    workspace::target().join("doc")
}

/// Makes the pages of crates, copies what they need to render formulas, and gives the folder.
pub fn make(packages: &[&str]) -> anyhow::Result<PathBuf> {
    let pages = folder();
    let katex = pages.join("katex");
    workspace::copy_all(&workspace::root().join(KATEX).join("fonts"), &katex.join("fonts"))?;
    for file in FILES {
        workspace::copy(&workspace::root().join(KATEX).join(file), &katex.join(file))?;
    }
    let mut command = workspace::cargo();
    documenting(&mut command, packages);
    workspace::run(&mut command)?;
    Ok(pages)
}

fn documenting(command: &mut Command, packages: &[&str]) {
    command.args(["doc", "--no-deps"]).args(packages.iter().flat_map(|package| ["--package", package]));
    // Flags in this form may hold paths with blanks.
    let header = workspace::root().join(KATEX).join("header.html").into_os_string();
    let flags = ["--html-in-header".into(), header].join(OsStr::new("\u{1f}"));
    command.env("CARGO_ENCODED_RUSTDOCFLAGS", flags);
}
