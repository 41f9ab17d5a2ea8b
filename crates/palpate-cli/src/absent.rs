//! A command that this build of the program leaves out: it is listed, and says how to get it.

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
    Err(Failure::Other(
        "this palpate was built without that command; build it without --no-default-features".to_owned(),
    ))
}
