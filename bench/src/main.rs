//! Runs one piece of work once, on one thread, for a tool that counts its instructions (`docs/performance.md`).
#![forbid(unsafe_code)]

use palpate::Reconstruction;
use palpate_bench::{Failure, Scene, from_nothing, from_truth, on_one_thread};

const USAGE: &str = "usage: palpate-bench without-jumps|with-jumps|smooth|prepare SAMPLES";

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, samples] = arguments.as_slice() else { return Err(USAGE.into()) };
    let samples = samples.parse()?;
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

/// Enough digits to see whether a change for speed changed the result.
fn tell(found: &Reconstruction) {
    println!("certified: {}; {}", found.certified, found.reason);
    println!("chi2 {:.9}, sensor {:.12} m, {} jumps", found.chi2_per_dof, found.sensor_sd_m, found.jumps.len());
    let turned: f64 = found.motion.iter().map(|pose| pose.psi_rad).sum::<f64>() / found.motion.len() as f64;
    println!("mean orientation {turned:.12} rad, {} harmonics", found.shape.harmonics_m().len());
    println!("area {:.12e} m2, perimeter {:.12e} m", found.shape.area_m2(), found.shape.perimeter_m());
}
