//! A log in three lines: columns in, shape, motion and verdict out.
//!
//! cargo run --release -p palpate --example reconstruct_a_log
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use palpate::palms::PalmPair;
use palpate::{Log, Sample};

/// Makes a log of columns, and prints what is found.
pub fn main() -> Result<(), Box<dyn Error>> {
    // Time, angle of palm 1, angle from palm 1 to palm 2, contact on palm 1, contact on palm 2.
    let columns: Vec<[f64; 5]> = measured()?;

    let sample =
        |[time_s, phi1, phi2, s1_m, s2_m]: [f64; 5]| Sample::new(time_s, PalmPair::hinged(phi1, phi2), s1_m, s2_m);
    let log = Log { samples: columns.into_iter().map(sample).collect() };
    let found = palpate::reconstruct(&log)?;

    println!("perimeter {:.2} mm, {:.0} % felt", 1e3 * found.shape.perimeter_m(), 100.0 * found.coverage);
    println!("{}", found.verdict);
    for point in found.outline.iter().step_by(180) {
        println!("boundary at ({:+.3}, {:+.3}) mm, to {:.3} mm", 1e3 * point.x_m, 1e3 * point.y_m, 1e3 * point.r_sd_m);
    }
    for pose in found.motion.iter().step_by(100) {
        let (degrees, sd) = (pose.psi_rad.to_degrees(), pose.psi_sd_rad.to_degrees());
        println!("{:5.1} s: turned by {degrees:7.2} ± {sd:.2} degrees", pose.time_s);
    }
    Ok(())
}

/// In place of a robot: an egg of 30 mm mean radius that the palms carry round.
fn measured() -> Result<Vec<[f64; 5]>, Box<dyn Error>> {
    use palpate::plan::{PalmLimits, plan_turn};
    use palpate::sensor::Touchpad;
    use palpate::simulate::{SimulateOptions, simulate};
    let egg = palpate::shape::NamedShape::Egg.shape(0.030)?;
    let plan = plan_turn(&egg, &PalmLimits::default(), 40.0)?;
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let options = SimulateOptions { touchpad, start_psi_rad: plan.start_psi_rad, ..SimulateOptions::default() };
    let felt = simulate(&egg, &plan.motion.sample(10.0)?, &options)?;
    let row = |sample: &Sample| {
        Some([sample.time_s, sample.palms.phi1_rad, sample.palms.phi2_rad, sample.s1_m?, sample.s2_m?])
    };
    Ok(felt.log.samples.iter().filter_map(row).collect())
}
