//! Writes the page of a made-up reconstruction, to look at while working on it:
//! `cargo run -p palpate-report --example synthetic -- [FILE.html [SAMPLES]]`
#![allow(clippy::print_stdout, reason = "it says where the page is")]

#[path = "../tests/fixture/mod.rs"]
mod fixture;

use palpate::compare::TruthError;
use palpate_report::{ReportInput, TruthOverlay, page};

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "synthetic.html".to_owned());
    let samples = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(800);
    let mut egg = fixture::fixture(samples, 12.0, 1.4);
    egg.reconstruction.calibration = Some(fixture::calibration());
    let overlay = TruthOverlay {
        truth: &egg.truth,
        errors: TruthError {
            rms_r_m: 7.4e-6,
            rms_form_m: 5.1e-6,
            hausdorff_m: 2.3e-5,
            rms_psi_rad: 0.0016,
            rms_com_m: 4.2e-6,
        },
    };
    let html = page(&ReportInput {
        title: "A made-up egg",
        log: &egg.log,
        reconstruction: &egg.reconstruction,
        truth: Some(overlay),
        seconds: 0.0,
        command: None,
        version: env!("CARGO_PKG_VERSION"),
    });
    std::fs::write(&file, html)?;
    println!("{file}");
    Ok(())
}
