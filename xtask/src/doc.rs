//! `cargo xtask doc`: the documentation of the crates with formulas rendered, complete in one folder and without a network.

use std::path::Path;

use anyhow::Context;
use clap::Args;

use crate::workspace;

/// What belongs beside the pages, in `crates/palpate/katex`.
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

/// Makes the pages and copies what they need to render formulas.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let katex = workspace::root().join("crates/palpate/katex");
    let target = workspace::target().join("doc/katex");
    copy(&katex, &target)?;
    let mut command = workspace::cargo();
    command.args(["doc", "--no-deps", "--package", &arguments.package]);
    if arguments.open {
        command.arg("--open");
    }
    // Flags in this form may hold paths with blanks.
    let flags = ["--html-in-header".into(), katex.join("header.html").into_os_string()];
    command.env("CARGO_ENCODED_RUSTDOCFLAGS", flags.join(std::ffi::OsStr::new("\u{1f}")));
    workspace::run(&mut command)?;
    println!(
        "{}",
        workspace::target().join("doc").join(arguments.package.replace('-', "_")).join("index.html").display()
    );
    Ok(())
}

fn copy(katex: &Path, target: &Path) -> anyhow::Result<()> {
    let fonts = target.join("fonts");
    std::fs::create_dir_all(&fonts).with_context(|| format!("could not make {}", fonts.display()))?;
    let copied = |from: &Path, to: &Path| {
        std::fs::copy(from, to).map(drop).with_context(|| format!("could not copy {}", from.display()))
    };
    for file in FILES {
        copied(&katex.join(file), &target.join(file))?;
    }
    for font in std::fs::read_dir(katex.join("fonts"))? {
        let font = font?;
        copied(&font.path(), &fonts.join(font.file_name()))?;
    }
    Ok(())
}
