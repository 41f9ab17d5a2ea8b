//! What is known beforehand: an object from a drawing whose motion is not known, then the motion of an earlier answer.
//!
//! cargo run --release -p palpate --example own_start
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use palpate::compare::compare;
use palpate::palms::PalmMotion;
use palpate::reconstruct::{Reconstructor, Start};
use palpate::sensor::Touchpad;
use palpate::shape::NamedShape;
use palpate::simulate::{SimulateOptions, simulate};

/// From a drawing, and from an earlier answer.
pub fn main() -> Result<(), Box<dyn Error>> {
    // The object as it was made, felt through jumps.
    let made = NamedShape::Stone.shape(0.0305)?;
    let motion = PalmMotion::random(4, 12.0, 1.0)?.sample(30.0)?;
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    let felt = simulate(&made, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() })?;

    // The drawing has it 0.5 mm smaller, with its front elsewhere.
    let drawn = NamedShape::Stone.shape(0.0300)?.rotated(2.0);
    let placed = Reconstructor::new().start(Start::Shape(drawn)).run(&felt.log)?;
    let error = compare(&placed, &felt.truth)?;
    println!("{} jumps, from the drawing: boundary to {:.4} mm", felt.jumps.len(), 1e3 * error.rms_form_m);

    // The same log once more, with a number of harmonics of one's own, from that answer.
    let psi_rad = placed.motion.iter().map(|pose| pose.psi_rad).collect();
    let start = Start::Motion { shape: placed.shape, psi_rad };
    for harmonics in [4, 6, 12] {
        let found = Reconstructor::new().harmonics(harmonics).start(start.clone()).run(&felt.log)?;
        let error = compare(&found, &felt.truth)?;
        println!("{harmonics:2} harmonics: boundary to {:.4} mm, {}", 1e3 * error.rms_form_m, found.verdict);
    }
    Ok(())
}
