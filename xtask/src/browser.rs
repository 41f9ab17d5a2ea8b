//! A headless browser for the test that opens the report: found, or installed where that is a matter of one command.

use crate::debian;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Whether a browser is there, after having tried to install one from Debian where we may.
pub fn provide(install: bool) -> bool {
    if let Some(path) = debian::find(&NAMES) {
        eprintln!("browser: {}", path.display());
        return true;
    }
    if !install {
        return false;
    }
    eprintln!("browser: none found, installing Debian's chromium");
    if let Err(error) = debian::install(&["chromium"]) {
        eprintln!("browser: {error:#}");
    }
    debian::find(&NAMES).is_some()
}
