//! `cargo xtask test`: everything that can be tested, with one command.

use crate::{browser, python, workspace};

/// The report's browser test must not skip itself when this is set.
const REQUIRE_CHROMIUM: &str = "PALPATE_REQUIRE_CHROMIUM";

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
}

/// Runs all tests of the workspace, doctests and the Python package included.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.only_python {
        return python::test();
    }
    let browser = browser::provide(!arguments.no_install);
    let mut test = workspace::cargo();
    test.args(["test", "--workspace", "--no-fail-fast"]);
    if browser {
        test.env(REQUIRE_CHROMIUM, "1");
    }
    workspace::run(&mut test)?;
    if !arguments.no_python {
        python::test()?;
    }
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
