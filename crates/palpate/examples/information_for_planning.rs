//! How much a motion will tell, before it is made; and how much it has told, afterwards.
//!
//! cargo run --release -p palpate --example information_for_planning
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use palpate::information::{Information, posterior};
use palpate::palms::PalmMotion;
use palpate::sensor::Touchpad;
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateOptions, Simulation, simulate};

const NOISE_M: f64 = 1e-4;

/// One of many random motions of 20 s, felt 20 times a second.
fn moved(shape: &SupportFunction, motion: u64) -> Result<Simulation, Box<dyn Error>> {
    let motion = PalmMotion::random(motion, 20.0, 1.0)?.sample(20.0)?;
    let touchpad = Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() };
    Ok(simulate(shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() })?)
}

/// Plans by what motions would tell, makes one, and asks what it has told.
pub fn main() -> Result<(), Box<dyn Error>> {
    // What is believed of the object: enough to plan by.
    let believed = NamedShape::Pebble.shape(0.030)?;
    println!("motion   felt   r known to   centre of mass to   least known change");
    let mut best: Option<(u64, f64)> = None;
    for motion in 1..=6 {
        let planned = moved(&believed, motion)?;
        let psi_rad: Vec<f64> = planned.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let information = Information::of(&planned.log, &believed, &psi_rad, NOISE_M)?;
        let (rms_m, com_m) = (information.rms_r_sd_m(), information.center_of_mass_sd_m());
        let weakest_m = information.weakest_direction().sd_m;
        let felt = 100.0 * information.felt_rad().len() as f64 / 720.0;
        println!(
            "{motion:6} {felt:4.0} %   {:7.4} mm   {:14.4} mm   {:15.4} mm",
            1e3 * rms_m,
            1e3 * com_m,
            1e3 * weakest_m
        );
        if best.is_none_or(|(_, least_m)| com_m < least_m) {
            best = Some((motion, com_m));
        }
    }
    let (motion, _) = best.ok_or("no motion tells anything")?;

    // The one that tells most of the centre of mass is made; then the log itself says what was learnt.
    let felt = moved(&believed, motion)?;
    let found = palpate::reconstruct(&felt.log)?;
    let learnt = posterior(&felt.log, &found)?;
    let com_m = learnt.center_of_mass_sd_m();
    println!(
        "motion {motion} made: r known to {:.4} mm, centre of mass to {:.4} mm",
        1e3 * learnt.rms_r_sd_m(),
        1e3 * com_m
    );
    Ok(())
}
