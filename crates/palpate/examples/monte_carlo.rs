//! A study of one's own: object, motion and sensor, ten trials, and the error against the Cramér-Rao bound.
//!
//! cargo run --release -p palpate --example monte_carlo
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use palpate::compare::compare;
use palpate::information::cramer_rao_bound_m;
use palpate::palms::PalmPair;
use palpate::reconstruct::Reconstructor;
use palpate::sensor::{ContactReading, PalmContact};
use palpate::shape::SupportFunction;
use palpate::simulate::{SimulateOptions, simulate_with};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

const TRIALS: u64 = 10;
const NOISE_M: f64 = 1e-4;

/// Ten trials.
pub fn main() -> Result<(), Box<dyn Error>> {
    // r(θ) = 30 + 1.5 cos θ + 1.8 cos 2θ + 0.6 sin 2θ − 0.5 cos 3θ + 0.7 sin 3θ, in millimetres.
    let object = SupportFunction::new(0.030, vec![[1.5e-3, 0.0], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
    // Both palms rock from side to side for 40 s, opening and closing meanwhile.
    let palms = |t: f64| PalmPair::hinged(0.8 + 0.7 * (0.31 * t).sin(), 1.3 - 0.2 * (0.9 * t).cos());
    let motion: Vec<(f64, PalmPair)> = (0..200).map(|index| f64::from(index) / 5.0).map(|t| (t, palms(t))).collect();
    let mut sensor = |contact: &PalmContact, rng: &mut dyn Rng| {
        Some(ContactReading::at(contact.position_m + NOISE_M * rng.sample::<f64, _>(StandardNormal)))
    };

    let (mut squares, mut bounds, mut certified, mut counted) = (0.0, 0.0, 0, 0);
    for seed in 0..TRIALS {
        let options = SimulateOptions { seed, ..SimulateOptions::default() };
        let felt = simulate_with(&object, &motion, &mut sensor, &options)?;
        let found = Reconstructor::new().sensor_sd_m(NOISE_M).run(&felt.log)?;
        if !found.is_certified() {
            continue;
        }
        certified += 1;
        let psi_rad: Vec<f64> = felt.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        if let Some(bound_m) = cramer_rao_bound_m(&felt.log, &object, &psi_rad, NOISE_M) {
            squares += compare(&found, &felt.truth)?.rms_r_m.powi(2);
            bounds += bound_m * bound_m;
            counted += 1;
        }
    }
    println!("{certified} of {TRIALS} certified");
    let (rms_m, bound_m) = ((squares / f64::from(counted)).sqrt(), (bounds / f64::from(counted)).sqrt());
    println!(
        "RMS error of r {:.5} mm, Cramér-Rao bound {:.5} mm, ratio {:.2}",
        1e3 * rms_m,
        1e3 * bound_m,
        rms_m / bound_m
    );
    Ok(())
}
