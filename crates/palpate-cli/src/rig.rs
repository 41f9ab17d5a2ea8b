//! `palpate rig`: the file that says what is known of palms and pads.

use crate::terminal::{Ending, Failure, print};
use std::path::PathBuf;

const AFTER_HELP: &str = "\
A rig file says what is known of palms and pads before a log is read: zeros, scales, surfaces and clocks, each with its standard
deviation, and how the rig counts (signs of the angles, end of the pads). `palpate reconstruct LOG --rig rig.toml` estimates what is not
exact together with the shape.

Examples:
  palpate rig --template > rig.toml       a commented file to fill in; every key may be left out
  palpate rig rig.toml                    reads it, says what is wrong with it, and prints it with every value in SI units

Exit codes: 0 fine;  2 the file cannot be read, or is wrong.";

/// Print a commented rig file, or check one
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
#[group(required = true)]
pub struct Arguments {
    /// The rig file to check
    #[arg(value_name = "RIG.toml")]
    file: Option<PathBuf>,
    /// Print a commented file with the default tolerances
    #[arg(long, conflicts_with = "file")]
    template: bool,
}

/// Prints.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    match &arguments.file {
        Some(path) => print(palpate_io::rig_to_toml(&palpate_io::read_rig(path)?).trim_end())?,
        None => print(palpate_io::rig_template().trim_end())?,
    }
    Ok(Ending::Success)
}
