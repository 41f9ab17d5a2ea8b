//! `cargo xtask test`: everything that can be tested, with one command. With `--quick` what is worth testing after every change.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use anyhow::Context;

use crate::{axe, browser, python, workspace};

/// The report's browser test must not skip itself when this is set.
const REQUIRE_CHROMIUM: &str = "PALPATE_REQUIRE_CHROMIUM";

/// Where that test finds axe-core.
const AXE: &str = "PALPATE_AXE";

/// Options of `cargo xtask test`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Do not install a browser where none is found (the browser test is then skipped)
    #[arg(long)]
    no_install: bool,
    /// Test the Python package alone
    #[arg(long)]
    only_python: bool,
    /// Leave the Python package out
    #[arg(long, conflicts_with = "only_python")]
    no_python: bool,
    /// In a minute or two, units and whatever else is fast: no whole studies, no browser, no documentation, no Python
    #[arg(long, conflicts_with_all = ["only_python", "no_python", "no_install"])]
    quick: bool,
}

/// The folder of the crates.
const CRATES: &str = "crates";

/// Tested in Python.
const PYTHON: &str = "palpate-py";

/// Integration tests that `--quick` leaves out: they reconstruct many logs, or start the program or a browser again and again. Those
/// of a name that begins with [`ESTIMATOR`] are left out too.
const SLOW: [&str; 10] =
    ["browser", "golden", "guide", "paper", "record", "study", "sweep", "watch", "watch_browser", "whole_path"];

/// The estimator as a whole, on logs of all kinds.
const ESTIMATOR: &str = "reconstruct_";

/// Units and fast integration tests.
fn quick() -> anyhow::Result<()> {
    let mut test = workspace::cargo();
    test.args(["test", "--workspace", "--exclude", PYTHON, "--no-fail-fast", "--quiet", "--lib", "--bins"]);
    for name in integration_tests()?.iter().filter(|name| !is_slow(name)) {
        test.args(["--test", name]);
    }
    workspace::run(&mut test)?;
    eprintln!("\nThe quick tests passed; `cargo xtask test` runs all.");
    Ok(())
}

fn is_slow(name: &str) -> bool {
    name.starts_with(ESTIMATOR) || SLOW.contains(&name)
}

/// Names of the integration tests of all crates.
fn integration_tests() -> anyhow::Result<BTreeSet<String>> {
    let mut names = BTreeSet::new();
    for package in files(&workspace::root().join(CRATES))? {
        let tests = package.join("tests");
        if !tests.is_dir() {
            continue;
        }
        let sources = files(&tests)?.into_iter().filter(|path| path.extension() == Some(OsStr::new("rs")));
        names.extend(sources.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())));
    }
    Ok(names)
}

/// What is in a folder.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    Ok(entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?)
}

/// Runs all tests of the workspace, doctests and the Python package included.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.quick {
        return quick();
    }
    if arguments.only_python {
        return python::test();
    }
    // Neither uses all of a machine all the time.
    let python = (!arguments.no_python).then(|| thread::spawn(python::test));
    let browser = browser::provide(!arguments.no_install);
    let mut test = workspace::cargo();
    test.args(["test", "--workspace", "--no-fail-fast"]);
    if browser {
        test.env(REQUIRE_CHROMIUM, "1");
        if !arguments.no_install {
            test.env(AXE, axe::provide()?);
        }
    }
    let rust = workspace::run(&mut test);
    if let Some(python) = python {
        let told = python.join().unwrap_or_else(|_| Err(anyhow::anyhow!("the tests in Python panicked")));
        if let Err(error) = told {
            eprintln!("\nThe Python package: {error:#}");
            return rust.and(Err(error));
        }
    }
    rust?;
    if browser {
        eprintln!("\nAll tests passed.");
    } else {
        eprintln!(
            "\n******************************************************************************\n\
             All other tests passed, but the report was NOT opened in a browser:\n\
             install chromium and run `cargo xtask test` again to test that too.\n\
             ******************************************************************************"
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quick_tests_leave_the_estimator_as_a_whole_out() {
        let names = integration_tests().expect("the crates have tests");
        let (slow, fast): (Vec<&String>, Vec<&String>) = names.iter().partition(|name| is_slow(name));
        assert!(fast.iter().any(|name| *name == "statics") && fast.iter().any(|name| *name == "log_files"), "{fast:?}");
        assert!(slow.iter().any(|name| *name == "study") && slow.iter().any(|name| *name == "reconstruct_logs"));
    }
}
