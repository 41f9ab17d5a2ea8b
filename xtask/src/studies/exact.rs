//! `cargo xtask methods --exact`: the methods that integrate on exact logs, where nothing but the method itself makes errors.

use palpate::compare::compare;
use palpate::palms::{PalmMotion, PalmPair};
use palpate::reconstruct::{Method, Reconstructor, Start};
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use rayon::prelude::*;

use crate::studies::methods::digits;

/// The methods that integrate.
const METHODS: [Method; 2] = [Method::Ode, Method::Quadrature];
/// Mean radius of the objects, metres.
const SIZE_M: f64 = 0.03;
/// Steps over the smooth motion.
const STEPS: [u32; 3] = [200, 400, 800];
/// Squeezes and rotations on which the normals meet in the centre of mass again and again: objects, and samples a second.
const CROSSINGS: [(NamedShape, &str, f64); 3] =
    [(NamedShape::Egg, "egg", 100.0), (NamedShape::Egg, "egg", 20.0), (NamedShape::Pebble, "pebble", 20.0)];

fn given(shape: &SupportFunction, run: &Simulation) -> Start {
    Start::Motion { shape: shape.clone(), psi_rad: run.truth.motion.iter().map(|pose| pose.psi_rad).collect() }
}

/// The largest error of ψ from true initial values, by the number of steps over a smooth motion of 10 s; and the order that the last two
/// of them tell.
pub fn steps() -> anyhow::Result<String> {
    let shape = NamedShape::Pebble.shape(SIZE_M)?;
    let errors = |steps: u32| -> anyhow::Result<[f64; 2]> {
        let palms = |step: u32| {
            let time_s = 10.0 * f64::from(step) / f64::from(steps);
            (time_s, PalmPair::hinged(1.05 + 0.15 * (0.3 * time_s).cos(), 1.3 - 0.1 * (0.25 * time_s).cos()))
        };
        let options = SimulateOptions { start_psi_rad: 4.0, ..SimulateOptions::default() };
        let run = simulate(&shape, &(0..=steps).map(palms).collect::<Vec<_>>(), &options)?;
        let mut worst = [0.0; 2];
        for (method, worst) in METHODS.into_iter().zip(&mut worst) {
            let found = Reconstructor::new().method(method).start(given(&shape, &run)).run(&run.log)?;
            let off = found.motion.iter().zip(&run.truth.motion).map(|(pose, truth)| pose.psi_rad - truth.psi_rad);
            let off: Vec<f64> = off.collect();
            *worst = off.iter().fold(0.0, |most, one| f64::max(most, (one - off[0]).abs()));
        }
        Ok(worst)
    };
    let errors: Vec<[f64; 2]> = STEPS.into_par_iter().map(errors).collect::<anyhow::Result<_>>()?;
    let mut lines = vec![
        "| steps | ψ by the differential equations (rad) | ψ by quadrature (rad) |".to_owned(),
        "|---:|---:|---:|".to_owned(),
    ];
    lines.extend(
        STEPS
            .iter()
            .zip(&errors)
            .map(|(steps, [ode, quadrature])| format!("| {steps} | {ode:.1e} | {quadrature:.1e} |")),
    );
    let [.., coarse, fine] = errors.as_slice() else { return Ok(lines.join("\n")) };
    let order = |method: usize| (coarse[method] / fine[method]).log2();
    lines.push(format!("| order | {:.2} | {:.2} |", order(0), order(1)));
    Ok(lines.join("\n"))
}

/// The errors on motions that lead over the places where the normals meet in the centre of mass, from nothing but the log.
pub fn crossings() -> anyhow::Result<String> {
    let mut lines = vec![
        "| object | samples a second | method | RMS shape (mm) | RMS orientation (deg) | jumps that are not there |"
            .to_owned(),
        "|---|---:|---|---:|---:|---:|".to_owned(),
    ];
    for (shape, name, rate_hz) in CROSSINGS {
        let motion = PalmMotion::squeeze_and_rotate(100.0, 2)?.sample(rate_hz)?;
        let run = simulate(&shape.shape(SIZE_M)?, &motion, &SimulateOptions::default())?;
        let rows = METHODS.into_par_iter().map(|method| {
            let found = Reconstructor::new().method(method).run(&run.log)?;
            let errors = compare(&found, &run.truth)?;
            let (shape_mm, psi_deg) = (digits(1e3 * errors.rms_r_m), digits(errors.rms_psi_rad.to_degrees()));
            let jumps = found.jumps.len() - run.jumps.len().min(found.jumps.len());
            Ok(format!("| {name} | {rate_hz} | {method} | {shape_mm} | {psi_deg} | {jumps} |"))
        });
        lines.extend(rows.collect::<anyhow::Result<Vec<_>>>()?);
    }
    Ok(lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::studies::tables::{METHODS_CROSSINGS, METHODS_STEPS, assert_documented};

    #[test]
    fn the_documented_tables_are_those_of_today() {
        // Of the order, the second decimal depends on rounding.
        assert_documented(METHODS_STEPS, &steps().expect("a table"), 0.1);
        assert_documented(METHODS_CROSSINGS, &crossings().expect("a table"), 0.1);
    }
}
