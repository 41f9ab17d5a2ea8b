//! How much a motion will tell, before it is made; and how much it has told, afterwards.
//!
//! cargo run --release -p palpate --example information_for_planning
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use palpate::information::{Information, posterior};
use palpate::palms::PalmPair;
use palpate::sensor::Touchpad;
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateOptions, Simulation, simulate};

const NOISE_M: f64 = 1e-4;

/// Both palms rock by `swing_rad` to both sides, for 30 s at 10 samples a second.
fn rocked(shape: &SupportFunction, swing_rad: f64) -> Result<Simulation, Box<dyn Error>> {
    let palms = |t: f64| PalmPair::hinged(0.8 + swing_rad * (0.4 * t).sin(), 1.5 - 0.2 * (0.9 * t).cos());
    let motion: Vec<(f64, PalmPair)> = (0..300).map(|index| f64::from(index) / 10.0).map(|t| (t, palms(t))).collect();
    let touchpad = Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() };
    Ok(simulate(shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() })?)
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let believed = NamedShape::Pebble.shape(0.030)?;
    println!("swing   felt   r known to   centre of mass   least known");
    let mut best: Option<(f64, f64)> = None;
    for swing_rad in [0.1, 0.3, 0.5, 0.7] {
        let planned = rocked(&believed, swing_rad)?;
        let psi_rad: Vec<f64> = planned.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        let information = Information::of(&planned.log, &believed, &psi_rad, NOISE_M)?;
        let (rms_m, weakest) = (information.rms_r_sd_m(), information.weakest_direction());
        println!(
            "{swing_rad:.1} rad {:4.0} %   {:7.4} mm   {:11.4} mm   {:8.4} mm",
            information.felt_rad().len() as f64 / 7.2,
            1e3 * rms_m,
            1e3 * information.center_of_mass_sd_m(),
            1e3 * weakest.sd_m
        );
        if best.is_none_or(|(_, least)| weakest.sd_m < least) {
            best = Some((swing_rad, weakest.sd_m));
        }
    }
    let (swing_rad, _) = best.ok_or("no motion tells anything")?;

    // The motion that leaves the weakest direction best known is made; then the log itself says what was learnt.
    let felt = rocked(&believed, swing_rad)?;
    let found = palpate::reconstruct(&felt.log)?;
    let learnt = posterior(&felt.log, &found)?;
    println!(
        "made with {swing_rad} rad: r known to {:.4} mm ({} harmonics)",
        1e3 * learnt.rms_r_sd_m(),
        learnt.order()
    );
    Ok(())
}
