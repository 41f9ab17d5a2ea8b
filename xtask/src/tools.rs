//! Programs for packaging and checking that cargo builds from source: in the target folder, installed there on first use.

use std::path::PathBuf;
use std::process::Command;

use crate::workspace;

/// A subcommand of cargo: its package, the version that is used, and a feature that it needs.
pub struct Tool {
    package: &'static str,
    version: &'static str,
    feature: Option<&'static str>,
}

/// Notices of licences.
pub const ABOUT: Tool = Tool { package: "cargo-about", version: "0.9.3", feature: Some("cli") };
/// Lists of components.
pub const CYCLONEDX: Tool = Tool { package: "cargo-cyclonedx", version: "0.5.9", feature: None };
/// Debian packages.
pub const DEB: Tool = Tool { package: "cargo-deb", version: "3.8.0", feature: None };
/// Licences, sources and advisories of dependencies.
pub const DENY: Tool = Tool { package: "cargo-deny", version: "0.20.2", feature: None };

impl Tool {
    /// The tool as a command at the root of the workspace, installed first where it is missing.
    pub fn command(&self) -> anyhow::Result<Command> {
        if !self.program().is_file() {
            self.install()?;
        }
        let mut command = Command::new(self.program());
        // Its first argument is its own name, as cargo would give it.
        command.arg(self.package.trim_start_matches("cargo-")).current_dir(workspace::root());
        Ok(command)
    }

    fn folder(&self) -> PathBuf {
        workspace::target().join("tools").join(format!("{}-{}", self.package, self.version))
    }

    fn program(&self) -> PathBuf {
        self.folder().join("bin").join(format!("{}{}", self.package, std::env::consts::EXE_SUFFIX))
    }

    fn install(&self) -> anyhow::Result<()> {
        let mut install = workspace::cargo();
        install.args(["install", "--locked", "--version", self.version, "--root"]).arg(self.folder());
        install.args(self.feature.into_iter().flat_map(|feature| ["--features", feature])).arg(self.package);
        workspace::run(install.env("CARGO_TARGET_DIR", workspace::target().join("tools/build")))
    }
}
