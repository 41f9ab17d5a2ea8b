//! Runs one piece of work once, on one thread, for a tool that counts its instructions; and sets the sums of the smoother beside what
//! the processor can do (`docs/performance.md`).
#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "what it does is to print")]

use std::hint::black_box;
use std::time::Instant;

use nalgebra::DMatrix;
use palpate::Reconstruction;
use palpate_bench::{Failure, Scene, from_nothing, from_truth, normal_equations, on_one_thread, with_harmonics};

const USAGE: &str = "usage: palpate-bench without-jumps|with-jumps|smooth|prepare|dense SAMPLES";

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, samples] = arguments.as_slice() else { return Err(USAGE.into()) };
    let samples = samples.parse()?;
    if what == "dense" {
        return on_one_thread(|| dense(samples).map_err(|error| error.to_string()))?.map_err(Into::into);
    }
    let scene = if what == "with-jumps" { Scene::with_jumps(samples)? } else { Scene::without_jumps(samples)? };
    let felt = scene.felt()?;
    println!("{samples} samples, {} jumps", felt.jumps.len());
    let work = || match what.as_str() {
        "without-jumps" | "with-jumps" => from_nothing(&felt).map(Some).map_err(|error| error.to_string()),
        "smooth" => from_truth(&scene, &felt).map(Some).map_err(|error| error.to_string()),
        "prepare" => Ok(None),
        _ => Err(USAGE.to_owned()),
    };
    if let Some(found) = on_one_thread(work)?? {
        tell(&found);
    }
    Ok(())
}

/// Operations per second in a multiplication of large matrices, and in the normal equations, where the sums of outer products alone
/// are counted: three rows per sample, each with its residual, into one triangle.
fn dense(samples: usize) -> Result<(), Failure> {
    const SIZE: usize = 768;
    let (a, b) = (DMatrix::from_fn(SIZE, SIZE, |i, j| (i + 2 * j) as f64), DMatrix::from_element(SIZE, SIZE, 0.5));
    let seconds = fastest(|| black_box(black_box(&a) * black_box(&b)).nrows());
    println!(
        "product of {SIZE} x {SIZE} matrices: {:.2e} operations per second",
        2.0 * (SIZE as f64).powi(3) / seconds
    );
    let scene = Scene::without_jumps(samples)?;
    let felt = scene.felt()?;
    for harmonics in [8, 16, 32] {
        let shape = with_harmonics(&scene.shape, harmonics);
        normal_equations(&shape, &felt)?;
        let seconds = fastest(|| normal_equations(black_box(&shape), black_box(&felt)).is_ok());
        let width = (2 * harmonics + 2) as f64;
        let operations = samples as f64 * 3.0 * width * (width + 1.0);
        println!(
            "{harmonics} harmonics: {:.0} ns per sample, {:.2e} operations of its sums per second",
            1e9 * seconds / samples as f64,
            operations / seconds
        );
    }
    Ok(())
}

/// Seconds of the fastest of ten runs.
fn fastest<T>(mut work: impl FnMut() -> T) -> f64 {
    let times = (0..10).map(|_| {
        let began = Instant::now();
        black_box(work());
        began.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Enough digits to see whether a change for speed changed the result.
fn tell(found: &Reconstruction) {
    println!("certified: {}; {}", found.is_certified(), found.verdict);
    println!("chi2 {:.9}, sensor {:.12} m, {} jumps", found.chi2_per_dof, found.sensor_sd_m, found.jumps.len());
    let turned: f64 = found.motion.iter().map(|pose| pose.psi_rad).sum::<f64>() / found.motion.len() as f64;
    println!("mean orientation {turned:.12} rad, {} harmonics", found.shape.harmonics_m().len());
    println!("area {:.12e} m2, perimeter {:.12e} m", found.shape.area_m2(), found.shape.perimeter_m());
}
