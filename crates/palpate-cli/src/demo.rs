//! `palpate demo`: from an object to the report about it, without any input.

use std::path::PathBuf;

use palpate::plan::plan_turn;
use palpate::reconstruct::Reconstructor;
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};
use palpate_io::{LogFile, RigFile};

use crate::reconstruct::{Job, solve, told};
use crate::simulate::limits;
use crate::terminal::{Ending, Failure, Terminal};

/// Mean radius of the object, metres.
const RADIUS_M: f64 = 0.02;
/// Duration of the palm motion, seconds.
const DURATION_S: f64 = 90.0;
/// Samples per second.
const RATE_HZ: f64 = 20.0;
/// Seed of the noise and of the errors of a rig.
const SEED: u64 = 1;

const AFTER_HELP: &str = "\
A pebble of 20 mm mean radius lies between two palms that carry it round once. Their touchpads are those of Moll & Erdmann (2001):
55.5 mm long, with readings in steps of 0.127 mm; 0.1 mm of noise comes on top. The log is reconstructed from nothing, and compared
with the truth afterwards. With --rig, the log is written by a rig that nobody calibrated: its errors are drawn from the standard deviations
of the file, and the report shows which of them the log told.

Examples:
  palpate demo -o my-demo
  palpate rig --template > rig.toml && palpate demo --rig rig.toml -o my-rig";

/// Simulate an object, reconstruct it from its palm log, and write the report; no input needed
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Folder for the result, made if missing
    #[arg(short, long = "out", value_name = "DIR", default_value = "palpate-demo")]
    out: PathBuf,
    /// A rig whose errors nobody knows, a file as `palpate rig --template` prints it [default: a rig without errors]
    #[arg(long, value_name = "RIG.toml")]
    rig: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Simulates, reconstructs, and says where the report is.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    palpate_io::check_result_target(&arguments.out)?;
    let rig = arguments.rig.as_deref().map(palpate_io::read_rig).transpose()?.unwrap_or_else(RigFile::exact).rig;
    let shape = NamedShape::Pebble.shape(RADIUS_M)?;
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::interlink() };
    let planned = plan_turn(&shape, &limits(&touchpad), DURATION_S)?;
    let options = SimulateOptions {
        touchpad,
        seed: SEED,
        start_psi_rad: planned.start_psi_rad,
        with_stated_noise: true,
        ..SimulateOptions::default()
    };
    let simulation = simulate(&shape, &planned.motion.sample(RATE_HZ)?, &options)?;
    terminal.say(&format!(
        "simulated: a pebble between two palms, {} samples in {DURATION_S:.0} s, contacts felt to {:.2} mm",
        simulation.log.samples.len(),
        1e3 * touchpad.position_sd_m()
    ))?;
    // No log tells the size, so it is as stated.
    let log = rig.at_stated_size(&rig.drawn(SEED)).distorted(&simulation.log);
    let file = LogFile { log, ..LogFile::default() };
    let job = Job {
        file: &file,
        name: None,
        title: "Demo: a pebble between two palms",
        truth: Some(&simulation.truth),
        reconstructor: Reconstructor::new().rig(rig),
        min_touches: 1,
        diagnostics: false,
        animation: None,
        out: &arguments.out,
    };
    let summary = solve(&job, &terminal)?;
    terminal.say(&told(&summary, &arguments.out))?;
    Ok(Ending::Success)
}
