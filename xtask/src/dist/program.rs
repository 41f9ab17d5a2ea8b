//! The program for those without Rust: an archive with it and what belongs to it, and a Debian package.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::Context;
use flate2::Compression;
use flate2::write::GzEncoder;

use super::notices::{self, NOTICES};
use crate::{tools, workspace};

/// The folder of the package.
pub const PACKAGE: &str = "crates/palpate-cli";
/// The profile that it is built with; what is built lies in the folder of that name.
pub const PROFILE: &str = "dist";
/// What is packed beside the program.
const DOCUMENTS: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Builds the program and what is said of the libraries in it.
pub fn build(version: &str, out: &Path) -> anyhow::Result<PathBuf> {
    let mut build = workspace::cargo();
    build.args(["build", "--locked", "--profile", PROFILE, "--package", "palpate-cli"]);
    workspace::run(super::without_paths(&mut build))?;
    let built = workspace::target().join(PROFILE);
    notices::licences(PACKAGE, &built.join(NOTICES))?;
    notices::components(PACKAGE, &out.join(format!("palpate-{version}.cdx.json")))?;
    Ok(built.join(format!("palpate{}", std::env::consts::EXE_SUFFIX)))
}

/// The archive.
pub fn archive(program: &Path, name: &str, out: &Path) -> anyhow::Result<PathBuf> {
    let path = out.join(format!("{name}.tar.gz"));
    let file = File::create(&path).with_context(|| path.display().to_string())?;
    let mut archive = tar::Builder::new(GzEncoder::new(file, Compression::best()));
    archive.mode(tar::HeaderMode::Deterministic);
    let notices = workspace::target().join(PROFILE).join(NOTICES);
    let documents = DOCUMENTS.iter().map(|name| workspace::root().join(name));
    for file in documents.chain([program.to_path_buf(), notices]) {
        let inside = Path::new(name).join(file.file_name().context("a file has a name")?);
        archive.append_path_with_name(&file, inside)?;
    }
    archive.into_inner()?.finish()?;
    Ok(path)
}

/// The Debian package, from what is built already.
pub fn debian_package(out: &Path) -> anyhow::Result<()> {
    let mut deb = tools::DEB.command()?;
    deb.args(["--no-build", "--no-strip", "--locked", "--profile", PROFILE, "--package", "palpate-cli", "--output"]);
    workspace::run(deb.arg(out))
}
