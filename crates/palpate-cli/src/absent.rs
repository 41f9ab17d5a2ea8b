//! What this build of the program leaves out: a command of these arguments is listed, and says how to get it.

use std::ffi::OsString;

use crate::terminal::{Ending, Failure};

/// Not in this build: build palpate without `--no-default-features`
#[derive(clap::Args)]
pub struct Arguments {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _all: Vec<OsString>,
}

/// Says so.
pub fn run(_: &Arguments) -> Result<Ending, Failure> {
    Err(failure("this command"))
}

/// Says so of `what` was asked for.
pub fn failure(what: &str) -> Failure {
    Failure::Input(format!("this palpate was built without {what}; build it without --no-default-features"))
}
