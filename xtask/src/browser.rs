//! A headless browser for the test that opens the report: found, or installed where that is a matter of one command.

use std::path::PathBuf;
use std::process::Command;

use crate::workspace;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Whether a browser is there, after having tried to install one from Debian where we may.
pub fn provide(install: bool) -> bool {
    if let Some(path) = find(&NAMES) {
        eprintln!("browser: {}", path.display());
        return true;
    }
    if !install || !is_root() || find(&["apt-get"]).is_none() {
        return false;
    }
    eprintln!("browser: none found, installing Debian's chromium");
    let apt_get = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments);
        workspace::run(&mut command)
    };
    let installed = apt_get(&["update", "-qq"])
        .and_then(|()| apt_get(&["install", "-y", "-qq", "--no-install-recommends", "chromium"]));
    if let Err(error) = installed {
        eprintln!("browser: {error:#}");
    }
    find(&NAMES).is_some()
}

/// The first of the programs that is on the search path.
fn find(names: &[&str]) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    names.iter().find_map(|name| std::env::split_paths(&folders).map(|folder| folder.join(name)).find(|p| p.is_file()))
}

/// Whether we may install packages: the root user owns what is ours.
#[cfg(unix)]
fn is_root() -> bool {
    use std::os::unix::fs::MetadataExt;
    std::path::Path::new("/proc/self").metadata().is_ok_and(|metadata| metadata.uid() == 0)
}

#[cfg(not(unix))]
fn is_root() -> bool {
    false
}
