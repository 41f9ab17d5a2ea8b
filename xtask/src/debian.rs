//! Programs and libraries that Debian has: looked for on the search path, and installed where that is a matter of one command.

use std::path::PathBuf;
use std::process::Command;

use anyhow::bail;

use crate::workspace;

/// Installs packages from Debian where we may.
pub fn install(packages: &[&str]) -> anyhow::Result<()> {
    if !is_root() || find(&["apt-get"]).is_none() {
        bail!("{} can be installed by root on Debian only", packages.join(", "));
    }
    let apt_get = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.env("DEBIAN_FRONTEND", "noninteractive").args(arguments);
        workspace::run(&mut command)
    };
    apt_get(&["update", "-qq"])?;
    apt_get(&[&["install", "-y", "-qq", "--no-install-recommends"], packages].concat())
}

/// The first of the programs that is on the search path.
pub fn find(names: &[&str]) -> Option<PathBuf> {
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
