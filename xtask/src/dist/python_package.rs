//! The Python package: a wheel for every Python from 3.10 on, and its source.

use std::fs;
use std::path::{Path, PathBuf};

use super::notices::{self, NOTICES};
use super::program::PROFILE;
use crate::python::{Environment, PACKAGE};
use crate::workspace;

/// Makes both and gives the wheel.
pub fn make(out: &Path) -> anyhow::Result<PathBuf> {
    let environment = Environment::provide()?;
    let notices = workspace::root().join(PACKAGE).join(NOTICES);
    notices::licences(PACKAGE, &notices)?;
    let wheels = workspace::empty(&workspace::target().join("python/distribution"))?;
    let components = workspace::target().join("palpate-py.cdx.json");
    notices::components(PACKAGE, &components)?;
    let manifest = format!("{PACKAGE}/Cargo.toml");
    let folder = wheels.to_string_lossy();
    // The wheel is made for the oldest Linux that its symbols allow; with one that no index takes it fails.
    let build = ["maturin", "build", "--locked", "--profile", PROFILE, "--strip", "--compatibility", "pypi"];
    let mut build = environment.module(&build);
    build.args(["--manifest-path", &manifest, "--out", &folder, "--sbom-include"]).arg(&components);
    let built = workspace::run(super::without_paths(&mut build));
    // Part of what is handed out, not of the source.
    fs::remove_file(&notices)?;
    built?;
    let made = workspace::only_file(&wheels)?;
    let wheel = out.join(made.file_name().unwrap_or_default());
    workspace::copy(&made, &wheel)?;
    environment.run(&["maturin", "sdist", "--manifest-path", &manifest, "--out", &out.to_string_lossy()])?;
    Ok(wheel)
}
