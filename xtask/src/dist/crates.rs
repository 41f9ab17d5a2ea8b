//! The crates as they are published, and their tests as whoever unpacks one would run them.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::Context;
use flate2::read::GzDecoder;

use crate::workspace;

/// Packages of the workspace that are for others.
pub const PUBLISHED: [&str; 6] =
    ["palpate", "palpate-io", "palpate-live", "palpate-report", "palpate-sweep", "palpate-cli"];

/// Packs them, and gives the archives.
pub fn pack(out: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut package = workspace::cargo();
    package.args(["package", "--locked", "--no-verify"]);
    workspace::run(package.args(PUBLISHED.iter().flat_map(|name| ["--package", name])))?;
    let version = workspace::version()?;
    let name = |package: &&str| format!("{package}-{version}.crate");
    let copied = PUBLISHED.iter().map(name).map(|name| {
        let to = out.join(&name);
        workspace::copy(&workspace::target().join("package").join(&name), &to)?;
        Ok(to)
    });
    copied.collect()
}

/// Unpacks them side by side, where each finds its fellows, and runs their tests and the code in their documentation.
pub fn test(archives: &[PathBuf]) -> anyhow::Result<()> {
    let folder = workspace::empty(&workspace::target().join("crates"))?;
    // Built like the workspace, so that what it depends on is built already.
    let mut manifest =
        format!("[workspace]\nresolver = \"3\"\nmembers = [\"palpate*\"]\n\n{}\n[patch.crates-io]\n", profile()?);
    for archive in archives {
        let file = File::open(archive).with_context(|| archive.display().to_string())?;
        tar::Archive::new(GzDecoder::new(file)).unpack(&folder)?;
        let inside = archive.file_stem().unwrap_or_default().to_string_lossy();
        let name = inside.rsplit_once('-').map_or(inside.as_ref(), |(name, _)| name);
        writeln!(manifest, "{name} = {{ path = \"{inside}\" }}")?;
    }
    fs::write(folder.join("Cargo.toml"), manifest)?;
    workspace::copy(&workspace::root().join("Cargo.lock"), &folder.join("Cargo.lock"))?;
    let mut test = workspace::cargo();
    test.args(["test", "--workspace", "--no-fail-fast"]).current_dir(&folder);
    workspace::run(test.env("CARGO_TARGET_DIR", workspace::target()))
}

/// How the workspace builds its tests, as it says in its manifest.
fn profile() -> anyhow::Result<String> {
    let manifest = fs::read_to_string(workspace::root().join("Cargo.toml"))?;
    let profile = manifest.split_once("[profile.dev]").context("the workspace has a profile for tests")?.1;
    Ok(format!("[profile.dev]{}\n", profile.split("\n[").next().unwrap_or_default()))
}
