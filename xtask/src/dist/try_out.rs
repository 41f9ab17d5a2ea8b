//! What is handed out, tried as by someone without Rust: nothing of this project or of its tools is on the search path.

use std::fs::{self, File};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, bail};
use flate2::read::GzDecoder;

use crate::python::Environment;
use crate::workspace;

/// From an object to a figure.
const PLOT: &str = "
import palpate
pebble = palpate.SupportFunction.named('pebble', mean_radius_m=0.03)
simulation = palpate.simulate(pebble, palpate.plan_turn(pebble, 60.0), touchpad=palpate.Touchpad(noise_sd_m=1e-4), rate_hz=10)
result = palpate.reconstruct(simulation.log)
assert result.certified, result.reason
result.plot().figure.savefig('pebble.png')
";

/// Unpacks the archive and runs the demo from it.
pub fn program(archive: &Path) -> anyhow::Result<()> {
    let folder = workspace::empty(&workspace::target().join("tried/program"))?;
    let file = File::open(archive).with_context(|| archive.display().to_string())?;
    tar::Archive::new(GzDecoder::new(file)).unpack(&folder)?;
    let inside = folder.join(archive.file_name().unwrap_or_default()).with_extension("").with_extension("");
    let program = inside.join(format!("palpate{}", std::env::consts::EXE_SUFFIX));
    let begun = Instant::now();
    workspace::run(Command::new(program).arg("demo").current_dir(&folder).env_clear())?;
    if !folder.join("palpate-demo/report.html").is_file() {
        bail!("the demo has written no report");
    }
    eprintln!("the program: from unpacked to a report in {:.1} s", begun.elapsed().as_secs_f64());
    Ok(())
}

/// Installs the wheel into an environment of its own and draws a figure.
pub fn wheel(wheel: &Path) -> anyhow::Result<()> {
    let folder = workspace::empty(&workspace::target().join("tried/python"))?;
    let environment = Environment::provide_in(folder.clone())?;
    let begun = Instant::now();
    let wheel = format!("{}[plot]", wheel.display());
    workspace::run(&mut environment.alone(&[
        "-m",
        "pip",
        "--quiet",
        "--disable-pip-version-check",
        "install",
        &wheel,
    ]))?;
    let installed = begun.elapsed().as_secs_f64();
    workspace::run(environment.alone(&["-c", PLOT]).current_dir(&folder))?;
    if fs::metadata(folder.join("pebble.png")).map_or(0, |picture| picture.len()) < 10_000 {
        bail!("there is no picture");
    }
    let plotted = begun.elapsed().as_secs_f64();
    eprintln!("the wheel: installed in {installed:.1} s, the first plot {:.1} s later", plotted - installed);
    Ok(())
}
