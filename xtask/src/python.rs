//! The Python package, tested as its users meet it: the wheel is built, installed into a virtual environment of its own, and there
//! used, type-checked and documented. All of it lies in the target folder.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Context;

use crate::{guide, workspace};

/// Where the package is, from the root of the workspace.
pub const PACKAGE: &str = "crates/palpate-py";
/// What it is tested with, from the folder of the package.
const REQUIREMENTS: &str = "requirements-dev.txt";
/// The notebook that is executed.
const NOTEBOOK: &str = "docs/python-tutorial.ipynb";

/// Builds, installs and tests the package.
pub fn test() -> anyhow::Result<()> {
    let environment = Environment::provide()?;
    environment.install_wheel("dev")?;
    let settings = format!("{PACKAGE}/pyproject.toml");
    let (python, tests, guide) = (format!("{PACKAGE}/python"), format!("{PACKAGE}/tests"), "docs/guide".to_owned());
    environment.run(&["ruff", "check", "--quiet", "--no-cache", "--config", &settings, &python, &tests, &guide])?;
    environment.run(&["ruff", "format", "--check", "--no-cache", "--config", &settings, &python, &tests, &guide])?;
    let cache = environment.path("mypy");
    environment.run(&["mypy", "--config-file", &settings, "--cache-dir", &cache, "--package", "palpate"])?;
    environment.run(&["mypy", "--config-file", &settings, "--cache-dir", &cache, &tests])?;
    environment.run(&["mypy.stubtest", "--mypy-config-file", &settings, "palpate"])?;
    environment.run(&["pytest", "--quiet", "-p", "no:cacheprovider", "--config-file", &settings, &tests])?;
    environment.run(&["pytest", "--quiet", "-p", "no:cacheprovider", "--nbmake", NOTEBOOK])?;
    guide::pages(&environment)?;
    environment.check_source_distribution()
}

/// A virtual environment: one with what the package is tested with, or one of its own for another purpose.
pub struct Environment {
    folder: PathBuf,
    python: PathBuf,
}

impl Environment {
    /// The environment, made anew where what is to be in it has changed.
    pub fn provide() -> anyhow::Result<Self> {
        let environment = Self::at(workspace::target().join("python"));
        let list = workspace::root().join(PACKAGE).join(REQUIREMENTS);
        let wanted = fs::read_to_string(&list).with_context(|| list.display().to_string())?;
        let stamp = environment.folder.join("installed.txt");
        if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) && environment.python.exists() {
            return Ok(environment);
        }
        environment.create().context("the Python package is tested with Python 3.10 or later and its venv module")?;
        environment.pip(&["install", "--requirement", &list.to_string_lossy()])?;
        fs::write(&stamp, wanted)?;
        Ok(environment)
    }

    /// An environment in this folder with nothing in it yet, or what was installed before.
    pub fn provide_in(folder: PathBuf) -> anyhow::Result<Self> {
        let environment = Self::at(folder);
        if !environment.python.exists() {
            environment.create().context("Python 3.10 or later and its venv module are needed")?;
        }
        Ok(environment)
    }

    /// Installs packages in the versions that the list of `constraints` (from the root of the workspace) names.
    pub fn install(&self, packages: &[&str], constraints: &str) -> anyhow::Result<()> {
        self.pip(&[&["install", "--constraint", constraints], packages].concat())
    }

    /// Installs what a list (from the root of the workspace) names, and nothing that it would ask for.
    pub fn install_alone(&self, list: &str) -> anyhow::Result<()> {
        self.pip(&["install", "--no-deps", "--requirement", list])
    }

    fn at(folder: PathBuf) -> Self {
        let programs = if cfg!(windows) { "Scripts" } else { "bin" };
        Self { python: folder.join("environment").join(programs).join("python"), folder }
    }

    fn create(&self) -> anyhow::Result<()> {
        let python = if cfg!(windows) { "python" } else { "python3" };
        workspace::run(Command::new(python).args(["-m", "venv", "--clear"]).arg(self.folder.join("environment")))
    }

    /// The interpreter of this environment, started at the root of the workspace.
    pub fn python(&self) -> Command {
        let mut command = Command::new(&self.python);
        command.current_dir(workspace::root()).env("CARGO_TARGET_DIR", workspace::target());
        command
    }

    /// The interpreter alone: nothing of this machine is on its search path.
    pub fn alone(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.python);
        let nothing = self.folder.join("nothing");
        command.args(arguments).env("PATH", nothing).env("MPLBACKEND", "agg");
        command
    }

    /// A module of this environment as a command.
    pub fn module(&self, arguments: &[&str]) -> Command {
        let mut command = self.python();
        command.arg("-m").args(arguments);
        // So that what is run finds its fellows.
        if let Some(programs) = self.python.parent() {
            let before = std::env::var_os("PATH").unwrap_or_default();
            let folders = std::iter::once(programs.to_path_buf()).chain(std::env::split_paths(&before));
            if let Ok(path) = std::env::join_paths(folders) {
                command.env("PATH", path);
            }
        }
        command
    }

    /// A file or folder beside the environment, as text.
    pub fn path(&self, name: &str) -> String {
        self.folder.join(name).to_string_lossy().into_owned()
    }

    /// Runs a module.
    pub fn run(&self, arguments: &[&str]) -> anyhow::Result<()> {
        workspace::run(&mut self.module(arguments))
    }

    fn pip(&self, arguments: &[&str]) -> anyhow::Result<()> {
        workspace::run(self.module(&["pip", "--quiet", "--disable-pip-version-check"]).args(arguments))
    }

    /// Builds the wheel and installs it.
    pub fn install_wheel(&self, profile: &str) -> anyhow::Result<()> {
        let wheels = workspace::empty(&self.folder.join("wheels"))?;
        let python = self.python.to_string_lossy();
        let manifest = format!("{PACKAGE}/Cargo.toml");
        let build = ["maturin", "build", "--locked", "--quiet", "--profile", profile, "--auditwheel", "skip"];
        workspace::run(
            self.module(&build).args(["--manifest-path", &manifest, "--interpreter", &python, "--out"]).arg(&wheels),
        )?;
        self.pip(&["install", "--force-reinstall", "--no-deps", &workspace::only_file(&wheels)?.to_string_lossy()])
    }

    /// Builds the source distribution and checks that what is in it compiles by itself. Nothing but its compiler is asked of the machine.
    fn check_source_distribution(&self) -> anyhow::Result<()> {
        let folder = workspace::empty(&self.folder.join("source"))?;
        let manifest = format!("{PACKAGE}/Cargo.toml");
        let build = ["maturin", "sdist", "--manifest-path", &manifest, "--out"];
        // The files in it are dated now: cargo takes older ones for those of the workspace, which it has checked already.
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        workspace::run(self.module(&build).arg(&folder).env("SOURCE_DATE_EPOCH", now.to_string()))?;
        let archive = workspace::only_file(&folder)?;
        let unpacked = workspace::empty(&self.folder.join("unpacked"))?;
        workspace::run(self.module(&["tarfile", "--extract"]).arg(archive).arg(&unpacked))?;
        let manifest = workspace::only_file(&unpacked)?.join(&manifest);
        // What it stands on has been checked before, with the same options.
        let mut check = workspace::cargo();
        check.args(["check", "--quiet", "--lib", "--manifest-path"]).arg(manifest);
        workspace::run(check.env("CARGO_TARGET_DIR", workspace::target()))
    }
}
