//! The program `palpate`: the object between two tactile palms, from their log.
//!
//! One file per command, [`log_source`] and [`source`] for what is named on the command line, and [`terminal`] for what is printed and how the
//! program ends.
#![forbid(unsafe_code)]

#[cfg(not(all(feature = "live", feature = "paper", feature = "sweep")))]
mod absent;
mod calibrate;
#[cfg(feature = "sweep")]
mod counted_progress;
mod demo;
#[cfg(feature = "live")]
mod live_rig;
mod log_source;
#[cfg(feature = "paper")]
mod paper;
mod plan;
mod reconstruct;
#[cfg(feature = "live")]
mod record;
mod rig;
mod simulate;
mod source;
mod strokes;
#[cfg(feature = "sweep")]
mod sweep;
mod terminal;
mod values;
#[cfg(feature = "live")]
mod watch;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

#[cfg(not(feature = "live"))]
use crate::absent as record;
#[cfg(not(feature = "live"))]
use crate::absent as watch;
#[cfg(not(feature = "paper"))]
use crate::absent as paper;
#[cfg(not(feature = "sweep"))]
use crate::absent as sweep;
use crate::terminal::Terminal;

const AFTER_HELP: &str = "\
Examples:
  palpate demo                                     see it work: simulate, reconstruct, report
  palpate reconstruct trial.csv -o trial           your own log -> trial/report.html, shape.csv, motion.csv, summary.json
  palpate simulate --shape egg -o egg.csv          a log to try things on, with the truth beside it
  palpate reconstruct egg.csv -o egg --truth egg.truth
  palpate record serial:/dev/ttyUSB0 -o trial.csv  what a rig feels, into a log
  palpate watch serial:/dev/ttyUSB0                what it is that the rig feels, while it feels it
  palpate rig --template > rig.toml                what is known of pads and encoders, for reconstruct --rig
  palpate calibrate day/*.csv -o rig.toml          pads and encoders, calibrated by logs of any objects
  palpate plan stone -o motion.csv                 palms that carry a known object round; or strokes over one pad
  palpate simulate --rig pivot -o strokes.csv      the other rig of the paper: an arm drags the object over one pad
  palpate paper                                    the figures of Moll & Erdmann (2001), reproduced
  palpate sweep plan.toml -o study                 thousands of logs, simulated or recorded, in one table

Exit codes: 0 success, for `reconstruct`: certified;  3 a result that is not certified;  2 bad input or usage;  1 anything else.";

/// Shape, motion and centre of mass of an unknown object from what two tactile palms feel.
///
/// The object lies between two straight palms and slides as they turn. From the palm angles and the contact positions alone,
/// palpate finds its shape, its motion and its centre of mass, with error bars and a verdict.
#[derive(Parser)]
#[command(name = "palpate", version, after_help = AFTER_HELP)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Arguments),
    Simulate(Box<simulate::Arguments>),
    Reconstruct(reconstruct::Arguments),
    Record(record::Arguments),
    Watch(watch::Arguments),
    Rig(rig::Arguments),
    Calibrate(calibrate::Arguments),
    Plan(plan::Arguments),
    Paper(paper::Arguments),
    Sweep(sweep::Arguments),
}

fn main() -> ExitCode {
    let ending = match Arguments::parse().command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Reconstruct(arguments) => reconstruct::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::Watch(arguments) => watch::run(&arguments),
        Command::Rig(arguments) => rig::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Paper(arguments) => paper::run(&arguments),
        Command::Sweep(arguments) => sweep::run(&arguments),
    };
    Terminal::end(ending)
}
