//! `cargo xtask test`: everything that can be tested, with one command.

use crate::{browser, workspace};

/// The report's browser test must not skip itself when this is set.
const REQUIRE_CHROMIUM: &str = "PALPATE_REQUIRE_CHROMIUM";

/// Options of `cargo xtask test`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Do not install a browser where none is found (the browser test is then skipped)
    #[arg(long)]
    no_install: bool,
}

/// Runs all tests of the workspace, doctests included.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let browser = browser::provide(!arguments.no_install);
    let mut test = workspace::cargo();
    test.args(["test", "--workspace", "--no-fail-fast"]);
    if browser {
        test.env(REQUIRE_CHROMIUM, "1");
    }
    workspace::run(&mut test)?;
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
