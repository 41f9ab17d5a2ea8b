//! The crates as they are published, and their tests as whoever unpacks one would run them.

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
    let mut patches = "[workspace]\nresolver = \"3\"\nmembers = [\"palpate*\"]\n\n[patch.crates-io]\n".to_owned();
    for archive in archives {
        let file = File::open(archive).with_context(|| archive.display().to_string())?;
        tar::Archive::new(GzDecoder::new(file)).unpack(&folder)?;
        let inside = archive.file_stem().unwrap_or_default().to_string_lossy();
        let name = inside.rsplit_once('-').map_or(inside.as_ref(), |(name, _)| name);
        patches.push_str(&format!("{name} = {{ path = \"{inside}\" }}\n"));
    }
    fs::write(folder.join("Cargo.toml"), patches)?;
    workspace::copy(&workspace::root().join("Cargo.lock"), &folder.join("Cargo.lock"))?;
    // Optimised like the tests of the workspace, without which they would take long.
    let mut test = workspace::cargo();
    test.args(["test", "--workspace", "--no-fail-fast"]).current_dir(&folder);
    workspace::run(test.env("CARGO_TARGET_DIR", folder.join("target")).env("CARGO_PROFILE_DEV_OPT_LEVEL", "2"))
}
