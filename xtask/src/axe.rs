//! axe-core for the test that looks at how accessible the report is: one file of JavaScript, out of a package of PyPI.

use std::path::PathBuf;

use anyhow::Context;

use crate::python::Environment;
use crate::workspace;

/// What carries it, from the root of the workspace.
const REQUIREMENTS: &str = "crates/palpate-report/tests/axe/requirements.txt";
/// Prints where it is, without what the package is otherwise for.
const WHERE: &str = "import importlib.util, pathlib; \
    print(pathlib.Path(importlib.util.find_spec('axe_playwright_python').submodule_search_locations[0]) / 'axe.min.js')";

/// Where it is, after having installed it into an environment of its own.
pub fn provide() -> anyhow::Result<PathBuf> {
    let environment = Environment::provide_in(workspace::target().join("axe"))?;
    environment.install_alone(REQUIREMENTS)?;
    let output = environment.python().args(["-c", WHERE]).output().context("Python does not start")?;
    let path = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    anyhow::ensure!(path.is_file(), "axe-core is not where it should be: {}", path.display());
    Ok(path)
}
