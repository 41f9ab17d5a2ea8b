//! Golden results: a digest of everything that the estimator says of 25 logs, held against `golden/results.csv`.
//!
//! A change of the code that is not meant to change results leaves every digest as it is, to rounding. After a change that is meant to,
//! write the table anew (`PALPATE_WRITE_GOLDEN=1 cargo test -p palpate-sweep --test golden`) and say in the commit which log changed and why.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use palpate::reconstruct::Pose;
use palpate::{Log, Reconstruction};
use palpate_sweep::{MotionKind, Object, SimulateJob, Touchpads};
use rayon::prelude::*;

/// Results that agree to this are the same: rounding that adds up in another order. Of the radius, or of a radian.
const ROUNDING: f64 = 1e-9;

/// The same for standard deviations and other figures that hang on second derivatives, relative.
const ROUNDING_OF_SPREADS: f64 = 1e-7;

/// The logs in `examples/logs`, made by other people's physics.
const EXAMPLES: [&str; 5] = [
    "egg_full_turn_oracle_n0.1mm",
    "ellipse_friction_0.10_mujoco",
    "ellipse_full_turn_pymunk",
    "pebble_full_turn_mujoco_sensor",
    "stone_zigzag_oracle",
];

/// Seeds of the studies, with their motion: each noise of the studies in turn, and some on which a mechanism was seen at work.
const SEEDS: [(u64, MotionKind); 20] = [
    (1, MotionKind::Random),
    (2, MotionKind::Random),
    (3, MotionKind::Random),
    (4, MotionKind::Random),
    (5, MotionKind::Random),
    (6, MotionKind::Random),
    (7, MotionKind::Random),
    (8, MotionKind::Random),
    (250, MotionKind::Random),
    (10383, MotionKind::Random),
    (60018, MotionKind::Random),
    (60071, MotionKind::Random),
    (70086, MotionKind::Random),
    (30044, MotionKind::RandomJumpFree),
    (30002, MotionKind::RandomJumpFree),
    (30003, MotionKind::RandomJumpFree),
    (30042, MotionKind::RandomJumpFree),
    (11, MotionKind::Turn),
    (12, MotionKind::Turn),
    (13, MotionKind::Zigzag),
];

fn table() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/results.csv")
}

fn example(name: &str) -> Log {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/examples/logs").join(format!("{name}.csv"));
    palpate_io::read_log(&path).expect("an example").log
}

fn simulated(seed: u64, motion: MotionKind) -> Log {
    let touchpads = match (seed + 3) % 4 {
        3 => Touchpads { counts_per_inch: Some(200.0), ..Touchpads::default() },
        index => Touchpads { noise_sd_m: [0.03e-3, 0.1e-3, 0.3e-3][index as usize], ..Touchpads::default() },
    };
    let job = SimulateJob { seed, object: Object::Mixed, motion, samples: None, touchpads, rig: None };
    job.simulate().unwrap_or_else(|error| panic!("seed {seed}: {error}")).simulation.log
}

/// A sum over all entries that changes when any of them does.
fn digest(values: impl IntoIterator<Item = f64>) -> f64 {
    let weighted = values.into_iter().enumerate().map(|(index, value)| value * (1.7 * index as f64 + 0.3).cos());
    let (sum, count) = weighted.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1)).sqrt()
}

/// What two results must agree in: numbers, each with the difference that is rounding.
fn figures(found: &Reconstruction) -> Vec<(&'static str, f64, f64)> {
    let metres = ROUNDING * found.shape.mean_radius_m();
    let spread = |value: f64| ROUNDING_OF_SPREADS * value.abs();
    let outline = |value: fn(&palpate::reconstruct::OutlinePoint) -> f64| digest(found.outline.iter().map(value));
    let motion = |value: fn(&Pose) -> f64| digest(found.motion.iter().map(value));
    let (r_sd, psi_sd, com_sd) = (outline(|p| p.r_sd_m), motion(|p| p.psi_sd_rad), motion(|p| p.com_sd_m));
    let mean_sd = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let r_spread = spread(mean_sd(found.outline.iter().map(|p| p.r_sd_m).collect())) * 30.0;
    let psi_spread = spread(mean_sd(found.motion.iter().map(|p| p.psi_sd_rad).collect())) * 30.0;
    let com_spread = spread(mean_sd(found.motion.iter().map(|p| p.com_sd_m).collect())) * 30.0;
    vec![
        ("certified", f64::from(found.is_certified()), 0.0),
        ("com_certified", f64::from(found.is_com_certified()), 0.0),
        ("alternatives", found.alternatives as f64, 0.0),
        ("jumps", found.jumps.len() as f64, 0.0),
        ("harmonics", found.shape.harmonics_m().len() as f64, 0.0),
        ("coverage", found.coverage, 0.0),
        ("touches", outline(|p| f64::from(p.touches)), 1e-12),
        ("mean_radius_m", found.shape.mean_radius_m(), metres),
        ("chi2_per_dof", found.chi2_per_dof, spread(found.chi2_per_dof)),
        ("sensor_sd_m", found.sensor_sd_m, spread(found.sensor_sd_m)),
        ("balance_sd_m", found.balance_sd_m, spread(found.balance_sd_m)),
        ("r_m", outline(|p| p.r_m), metres),
        ("curvature_radius_m", outline(|p| p.curvature_radius_m), 100.0 * metres),
        ("r_sd_m", r_sd, r_spread),
        ("psi_rad", motion(|p| p.psi_rad), 10.0 * ROUNDING),
        ("psi_sd_rad", psi_sd, psi_spread),
        ("com_x_m", motion(|p| p.com_x_m), metres),
        ("com_y_m", motion(|p| p.com_y_m), metres),
        ("com_sd_m", com_sd, com_spread),
        ("residuals_m", motion(|p| p.residual1_m.unwrap_or(1.0) + 2.0 * p.residual2_m.unwrap_or(1.0)), metres),
        ("jump_psi_rad", digest(found.jumps.iter().flat_map(|j| [j.psi_before_rad, j.psi_after_rad])), 10.0 * ROUNDING),
        ("jump_height_m", digest(found.jumps.iter().flat_map(|j| [j.height_before_m, j.height_after_m])), metres),
        ("jump_time_s", digest(found.jumps.iter().map(|j| j.time_s)), 1e-12),
    ]
}

/// A line of the table: the log, its figures, and the reason in words.
fn line(name: &str, found: &Reconstruction) -> String {
    let mut line = name.to_owned();
    for (_, value, _) in figures(found) {
        write!(line, ",{value:e}").expect("room");
    }
    write!(line, ",{}", found.verdict.reason().replace(',', ";")).expect("room");
    line
}

fn differences(name: &str, expected: &str, found: &Reconstruction) -> Vec<String> {
    let cells: Vec<&str> = expected.split(',').collect();
    let figures = figures(found);
    assert_eq!(cells.len(), figures.len() + 2, "{name}: another table");
    let mut differences = Vec::new();
    for ((what, value, rounding), cell) in figures.into_iter().zip(&cells[1..]) {
        let expected: f64 = cell.parse().expect("a number");
        if (value - expected).is_nan() || (value - expected).abs() > rounding {
            differences.push(format!("{name}: {what} is {value:e}, was {expected:e}"));
        }
    }
    let reason = found.verdict.reason().replace(',', ";");
    if cells[cells.len() - 1] != reason {
        differences.push(format!("{name}: the reason is \"{reason}\", was \"{}\"", cells[cells.len() - 1]));
    }
    differences
}

#[test]
fn results_are_what_they_were() {
    let mut logs: Vec<(String, Log)> = EXAMPLES.iter().map(|name| ((*name).to_owned(), example(name))).collect();
    logs.extend(SEEDS.iter().map(|&(seed, motion)| (format!("{} {seed}", motion.name()), simulated(seed, motion))));
    let found: Vec<(String, Reconstruction)> = logs
        .into_par_iter()
        .map(|(name, log)| {
            let found = palpate::reconstruct(&log).expect("an answer");
            (name, found)
        })
        .collect();
    if std::env::var_os("PALPATE_WRITE_GOLDEN").is_some() {
        let names: Vec<&str> = figures(&found[0].1).iter().map(|(what, ..)| *what).collect();
        let mut text = format!("log,{},reason\n", names.join(","));
        found.iter().for_each(|(name, found)| writeln!(text, "{}", line(name, found)).expect("room"));
        std::fs::write(table(), text).expect("the table can be written");
        return;
    }
    let text = std::fs::read_to_string(table()).expect("the table");
    let lines: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(lines.len(), found.len());
    let differences: Vec<String> = found
        .iter()
        .zip(lines)
        .flat_map(|((name, found), line)| {
            assert!(line.starts_with(&format!("{name},")), "the order of the table");
            differences(name, line, found)
        })
        .collect();
    assert!(differences.is_empty(), "{}", differences.join("\n"));
}
