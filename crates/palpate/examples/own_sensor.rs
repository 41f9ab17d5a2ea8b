//! A sensor of one's own in a simulation: heavy tails, a drift, and a standard deviation that each reading states.
//!
//! cargo run --release -p palpate --example own_sensor
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use palpate::compare::compare;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::sensor::{ContactReading, ContactSensor, PalmContact};
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate_with};
use rand::{Rng, RngExt};
use rand_distr::StudentT;

/// Less exact far from the base, with Student's t of four degrees of freedom; its zero wanders while it gets warm.
struct Skin {
    tails: StudentT<f64>,
    drift_m: f64,
}

impl ContactSensor for Skin {
    fn read_contact(&mut self, contact: &PalmContact, rng: &mut dyn Rng) -> Option<ContactReading> {
        let scale_m = 2e-5 + 5e-4 * contact.position_m;
        let noise_m = scale_m * rng.sample(self.tails);
        let drift_m = self.drift_m * (1.0 - (-contact.time_s / 10.0).exp());
        Some(ContactReading {
            position_m: contact.position_m + noise_m + drift_m,
            // The variance of Student's t with ν degrees of freedom is ν / (ν − 2).
            position_sd_m: Some(2f64.sqrt() * scale_m),
            force_n: None,
        })
    }
}

/// The same motion with three drifts.
pub fn main() -> Result<(), Box<dyn Error>> {
    let egg = NamedShape::Egg.shape(0.030)?;
    let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
    let motion = plan.motion.sample(4.0)?;
    for drift_m in [0.0, 2e-5, 1e-4] {
        let mut skin = Skin { tails: StudentT::new(4.0)?, drift_m };
        let start_psi_rad = plan.start_psi_rad;
        let options = SimulateOptions { start_psi_rad, with_stated_noise: true, seed: 7, ..SimulateOptions::default() };
        let felt = simulate_with(&egg, &motion, &mut skin, &options)?;
        let found = palpate::reconstruct(&felt.log)?;
        let error = compare(&found, &felt.truth)?;
        println!("drift {:.2} mm: boundary to {:.4} mm, {}", 1e3 * drift_m, 1e3 * error.rms_form_m, found.verdict);
    }
    Ok(())
}
