//! What the tests of the estimator share: logs to reconstruct, and what makes an answer right.
#![allow(dead_code, reason = "each test binary uses a part of it")]
#![allow(clippy::print_stdout, reason = "shown where a test fails")]

use std::f64::consts::TAU;
use std::time::Instant;

use palpate::compare::{TruthError, compare};
use palpate::palms::PalmPair;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::reconstruct::{ReconstructError, Reconstruction, reconstruct};
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use palpate::{Log, Truth};

/// Mean radius of most objects here, metres.
pub const SIZE_M: f64 = 0.03;

/// A pad with Gaussian noise and nothing else.
pub fn noisy(noise_sd_m: f64) -> Touchpad {
    Touchpad { noise_sd_m, ..Touchpad::ideal() }
}

/// The palms carry the object around without a jump, as far as it can be turned; `samples` samples.
pub fn turned(shape: &SupportFunction, samples: usize, touchpad: Touchpad) -> Simulation {
    let plan = plan_turn(shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
    let motion: Vec<(f64, PalmPair)> = plan.motion.sample((samples - 1) as f64 / 40.0).expect("a possible motion");
    let options =
        SimulateOptions { start_psi_rad: plan.start_psi_rad, touchpad, seed: 1, ..SimulateOptions::default() };
    simulate(shape, &motion, &options).expect("a possible motion")
}

/// Reconstructs, and prints what came of it. How long it took is told and not judged.
pub fn solve(log: &Log) -> Result<Reconstruction, ReconstructError> {
    let started = Instant::now();
    let result = reconstruct(log);
    let taken = started.elapsed();
    match &result {
        Ok(found) => println!(
            "{:.1} s, certified {} {}, chi2 {:.2}, K {}, sd {:.4} mm, balance {:.4} mm, jumps {}, coverage {:.2}, alternatives {}: {}",
            taken.as_secs_f64(),
            found.is_certified(),
            found.is_com_certified(),
            found.chi2_per_dof,
            found.shape.harmonics_m().len(),
            1e3 * found.sensor_sd_m,
            1e3 * found.balance_sd_m,
            found.jumps.len(),
            found.coverage,
            found.alternatives,
            found.verdict
        ),
        Err(error) => println!("{:.1} s, {error}", taken.as_secs_f64()),
    }
    result
}

/// Errors against the truth, printed.
pub fn errors(found: &Reconstruction, truth: &Truth) -> TruthError {
    let error = compare(found, truth).expect("of the same log");
    println!(
        "  r {:.5} mm, form {:.5} mm, hausdorff {:.5} mm, psi {:.4} deg, com {:.5} mm",
        1e3 * error.rms_r_m,
        1e3 * error.rms_form_m,
        1e3 * error.hausdorff_m,
        error.rms_psi_rad.to_degrees(),
        1e3 * error.rms_com_m
    );
    error
}

/// RMS over the felt outline and over the motion of the standard deviations that the result states.
pub fn stated_sds(found: &Reconstruction) -> (f64, f64) {
    let rms = |values: Vec<f64>| (values.iter().map(|sd| sd * sd).sum::<f64>() / values.len().max(1) as f64).sqrt();
    (
        rms(found.outline.iter().filter(|point| point.touches > 0).map(|point| point.r_sd_m).collect()),
        rms(found.motion.iter().map(|pose| pose.psi_sd_rad).collect()),
    )
}

/// The accuracy that is aimed at, or three of the standard deviations that the result itself states where these are larger.
/// `fold` is the symmetry of the object: turned by 2π/fold it is the same object, and ψ is known up to that.
pub fn assert_right(found: &Reconstruction, truth: &Truth, noise_m: f64, fold: u32) {
    let error = errors(found, truth);
    let (r_sd, psi_sd) = stated_sds(found);
    let r_limit = f64::max(2e-5, 0.1 * noise_m).max(3.0 * r_sd);
    let psi_limit = 0.5f64.to_radians().max(3.0 * psi_sd);
    assert!(error.rms_r_m <= r_limit, "r is off by {:.4} mm, limit {:.4} mm", 1e3 * error.rms_r_m, 1e3 * r_limit);
    let psi = rms_psi_rad(found, truth, fold);
    assert!(psi <= psi_limit, "psi is off by {:.3} deg, limit {:.3}", psi.to_degrees(), psi_limit.to_degrees());
}

/// The contract of the certificate: a certified answer is right, and where there is none the reason says something.
pub fn assert_honest(result: &Result<Reconstruction, ReconstructError>, truth: &Truth, noise_m: f64, fold: u32) {
    match result {
        Ok(found) if found.is_certified() => assert_right(found, truth, noise_m, fold),
        Ok(found) => {
            errors(found, truth);
            assert!(found.verdict.reason().len() > 20, "a reason that helps, not {}", found.verdict);
            assert!(!found.is_com_certified(), "no centre of mass without a shape");
        }
        Err(error) => assert!(error.to_string().len() > 20, "a reason that helps, not {error}"),
    }
}

/// RMS error of ψ after the best constant offset, up to the symmetry of the object.
pub fn rms_psi_rad(found: &Reconstruction, truth: &Truth, fold: u32) -> f64 {
    let fold = f64::from(fold);
    let apart: Vec<f64> = found.motion.iter().zip(&truth.motion).map(|(f, t)| fold * (f.psi_rad - t.psi_rad)).collect();
    let (sin, cos) = apart.iter().fold((0.0, 0.0), |(s, c), a| (s + a.sin(), c + a.cos()));
    let mean = f64::atan2(sin, cos);
    let off = |angle: &f64| ((angle - mean + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0) / fold;
    (apart.iter().map(|angle| off(angle).powi(2)).sum::<f64>() / apart.len() as f64).sqrt()
}
