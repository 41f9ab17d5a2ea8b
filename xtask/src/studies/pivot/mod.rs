//! `cargo xtask monte-carlo-pivot`: strokes of a pivoting grasp from nothing, many objects, as a Markdown table.
//!
//! With `--mujoco` the strokes are those of another engine, with friction of 0.1 to 0.6. Objects of the mixture, each held at a point of its own, five to eight strokes to and fro with friction of 0.3 to 0.6. *Right* is a felt boundary
//! within 0.5 % of the radius and a motion within 2 degrees; *wrong* is what is certified, not right, and beyond five of its own error bars.

mod mujoco;

use std::f64::consts::TAU;
use std::num::NonZero;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use anyhow::Context as _;
use palpate::pivot::{
    PadPose, PivotCalibration, PivotOptions, PivotReconstruction, PivotRig, PivotSimulateOptions, PivotSimulation,
    PivotTolerances, PivotTruthError, Stroke, compare_strokes, observability, reconstruct_strokes, simulate_strokes,
};
use palpate::sensor::Touchpad;
use palpate::shape::SupportFunction;
use palpate_sweep::{BAND_95_SDS, Object};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::studies::monte_carlo::quantile;
use crate::studies::tables::{self, Place, Table, Write};

/// Options of `cargo xtask monte-carlo-pivot`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Trials
    #[arg(long, default_value_t = 500)]
    trials: u64,
    /// Seed of the first trial
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Rigs that nobody calibrated, drawn from the default tolerances
    #[arg(long)]
    rig: bool,
    /// Strokes in MuJoCo, which is installed for it
    #[arg(long, conflicts_with = "rig")]
    mujoco: bool,
    /// Print a line for each trial that was not right or not certified
    #[arg(long)]
    verbose: bool,
    /// Keep the logs (and truths) of such trials, or of the only one, in this folder
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    #[command(flatten)]
    write: Write,
}

impl Arguments {
    fn command(&self) -> String {
        let option = match (self.rig, self.mujoco) {
            (true, _) => " --rig",
            (_, true) => " --mujoco",
            _ => "",
        };
        format!("cargo xtask monte-carlo-pivot{option} --trials {} --seed {}", self.trials, self.seed)
    }

    /// The documentation has no table of rigs that nobody calibrated.
    fn places(&self) -> &'static [Place] {
        match (self.rig, self.mujoco) {
            (true, _) => &[],
            (_, true) => &[tables::MONTE_CARLO_PIVOT_MUJOCO],
            _ => &[tables::MONTE_CARLO_PIVOT],
        }
    }
}

/// Noise of pad and arm, standard deviations in metres.
const NOISE_M: [f64; 2] = [1e-4, 2e-5];
/// Right is an error of the boundary within this share of the mean radius, and of the motion within so many radians.
const RIGHT_R: f64 = 0.005;
const RIGHT_PSI_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Friction of the strokes, and of those in another engine.
const FRICTION: std::ops::Range<f64> = 0.3..0.6;
const FRICTION_IN_MUJOCO: std::ops::Range<f64> = 0.1..0.6;
/// Wrong is beyond so many error bars as well.
const WRONG_SDS: f64 = 5.0;

/// Half the widths of the bands that are looked at, in error bars.
const BANDS_SDS: [f64; 2] = [BAND_95_SDS, 3.0];
/// A minute at 15 Hz: what is asked to be fast.
const SHORT_SAMPLES: usize = 900;

/// A trial that gave a log.
struct Trial {
    seed: u64,
    name: String,
    radius_m: f64,
    samples: usize,
    leaps: usize,
    /// Cramér–Rao bound of the felt boundary, root mean square, metres.
    bound_m: Option<f64>,
    seconds: f64,
    found: Result<(PivotReconstruction, PivotTruthError), String>,
    /// Shares of the felt boundary within its 95 % band, and within three error bars.
    inside: [f64; 2],
    panicked: bool,
}

/// What a seed draws.
struct Drawn {
    name: String,
    /// About the pivot.
    shape: SupportFunction,
    strokes: Vec<Stroke>,
    rig: PivotRig,
    options: PivotSimulateOptions,
}

fn drawn(seed: u64, uncalibrated: bool, friction: std::ops::Range<f64>) -> anyhow::Result<Drawn> {
    let (name, about_mass) = Object::Mixed.of_seed(seed)?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x7069_766f_7400);
    let radius_m = about_mass.mean_radius_m();
    // The pivot is not in the middle: about a circle's no angle is told.
    let (towards, away_m) = (rng.random_range(0.0..TAU), radius_m * rng.random_range(0.1..0.45));
    let pivot_m = [away_m * towards.cos(), away_m * towards.sin()];
    let shape = about_mass.translated(-pivot_m[0], -pivot_m[1]);
    let count = rng.random_range(5..=8);
    let strokes = (0..count).map(|index| {
        let side = if index % 2 == 0 { 1.0 } else { -1.0 };
        let from_m = 0.5 + radius_m * rng.random_range(-1.0..1.0);
        let there_m = from_m + side * radius_m * rng.random_range(2.5..5.0);
        let back_m = there_m - side * radius_m * rng.random_range(0.5..2.5);
        Stroke { along_m: vec![from_m, there_m, back_m], press: rng.random_range(2.0..4.0) }
    });
    let strokes: Vec<Stroke> = strokes.collect();
    let pad = PadPose { tilt_rad: rng.random_range(-0.2..0.2), ..PadPose::default() };
    let mut within = |sd: f64| sd * rng.random_range(-1.7..1.7);
    let tolerances = PivotTolerances::UNCALIBRATED;
    let errors = PivotCalibration {
        zero_m: within(tolerances.zero_sd_m),
        scale: within(tolerances.scale_sd),
        tilt_rad: within(tolerances.tilt_sd_rad),
        height_m: 0.0,
    };
    let (calibration, rig) = if uncalibrated {
        (errors, PivotRig::uncalibrated(pad))
    } else {
        (PivotCalibration::default(), PivotRig::exact(pad))
    };
    let options = PivotSimulateOptions {
        rig: PivotRig { calibration, ..PivotRig::exact(pad) },
        touchpad: Touchpad { length_m: 1.0, noise_sd_m: NOISE_M[0], ..Touchpad::ideal() },
        arm_noise_sd_m: NOISE_M[1],
        center_of_mass_m: [-pivot_m[0], -pivot_m[1]],
        friction: rng.random_range(friction),
        rate_hz: rng.random_range(15.0..30.0),
        seed,
        ..PivotSimulateOptions::default()
    };
    Ok(Drawn { name, shape, strokes, rig, options })
}

/// Share of the felt boundary that the truth, turned as the errors say, is within so many error bars of.
fn inside(found: &PivotReconstruction, truth: &SupportFunction, errors: &PivotTruthError, sds: f64) -> f64 {
    let turned = truth.rotated(errors.rotation_rad);
    let felt = found.outline.iter().filter(|point| point.touches > 0);
    let off = |theta_rad: f64, r_m: f64| (turned.radius_m(theta_rad) - r_m).abs();
    let (all, within) = felt.fold((0, 0), |(all, within), point| {
        let is_within = off(point.theta_rad, point.r_m) <= sds * point.r_sd_m;
        (all + 1, within + usize::from(is_within))
    });
    f64::from(within as u32) / f64::from(all.max(1) as u32)
}

fn bound_m(drawn: &Drawn, simulation: &PivotSimulation) -> Option<f64> {
    let pad = drawn.options.rig.pad;
    let samples = &simulation.log.samples;
    let along: Vec<f64> =
        samples.iter().map(|sample| pad.along_and_above(sample.pivot_x_m, sample.pivot_y_m)[0]).collect();
    let told = observability(&drawn.shape, &simulation.theta_rad, &along, &drawn.rig, NOISE_M).ok()?;
    told.bound.map(|bound| bound.rms_r_sd_m())
}

fn trial(drawn: Drawn, simulation: &PivotSimulation) -> Trial {
    let started = Instant::now();
    let solved = catch_unwind(|| reconstruct_strokes(&simulation.log, &PivotOptions::new(drawn.rig)));
    let seconds = started.elapsed().as_secs_f64();
    let panicked = solved.is_err();
    let solved = solved.unwrap_or(Err(palpate::pivot::PivotReconstructError::NotSolvable));
    let found = solved.map_err(|error| error.to_string()).and_then(|found| {
        let errors = compare_strokes(&found, &simulation.truth).map_err(|error| error.to_string())?;
        Ok((found, errors))
    });
    Trial {
        seed: drawn.options.seed,
        radius_m: drawn.shape.mean_radius_m(),
        samples: simulation.log.samples.iter().filter(|sample| sample.s_m.is_some()).count(),
        leaps: simulation.leaps.len(),
        bound_m: bound_m(&drawn, simulation),
        seconds,
        inside: BANDS_SDS
            .map(|sds| found.as_ref().map_or(f64::NAN, |(found, errors)| inside(found, &drawn.shape, errors, sds))),
        found,
        panicked,
        name: drawn.name,
    }
}

impl Trial {
    fn is_right(&self) -> bool {
        self.found
            .as_ref()
            .is_ok_and(|(_, errors)| errors.rms_r_m < RIGHT_R * self.radius_m && errors.rms_psi_rad < RIGHT_PSI_RAD)
    }

    fn is_certified(&self) -> bool {
        self.found.as_ref().is_ok_and(|(found, _)| found.is_certified())
    }

    fn is_wrong(&self) -> bool {
        let beyond = self.found.as_ref().is_ok_and(|(found, errors)| {
            errors.rms_r_m > WRONG_SDS * found.r_sd_m() || errors.rms_psi_rad > WRONG_SDS * found.psi_sd_rad()
        });
        self.is_certified() && !self.is_right() && beyond
    }

    /// Writes the log and its truth into a folder, which is made where it is not there.
    fn keep(&self, folder: &Path, rig: &PivotRig, simulation: &PivotSimulation) -> anyhow::Result<()> {
        std::fs::create_dir_all(folder)?;
        let path = folder.join(format!("{}.csv", self.seed));
        let metadata = [("object", self.name.clone()), ("rig", palpate_io::pivot_rig_comment(rig))];
        palpate_io::write_strokes(&path, &simulation.log, &metadata)?;
        palpate_io::write_truth(&palpate_io::truth_dir_of(&path), &simulation.truth)?;
        Ok(())
    }

    fn tell(&self) {
        let (r_mm, psi_deg, felt, why) = match &self.found {
            Ok((found, errors)) => {
                let doubts: Vec<String> = found.doubts.iter().map(ToString::to_string).collect();
                (1e3 * errors.rms_r_m, errors.rms_psi_rad.to_degrees(), found.coverage, doubts.join("; "))
            }
            Err(error) => (f64::NAN, f64::NAN, f64::NAN, error.clone()),
        };
        println!(
            "seed {} {}: samples {} leaps {} felt {felt:.2} right {} certified {} wrong {} r {r_mm:.4} mm (bound {:.4}) psi {psi_deg:.2} deg {:.2} s; {why}",
            self.seed,
            self.name,
            self.samples,
            self.leaps,
            self.is_right(),
            self.is_certified(),
            self.is_wrong(),
            1e3 * self.bound_m.unwrap_or(f64::NAN),
            self.seconds,
        );
    }
}

/// Runs the study, prints its table, and writes it where that is asked for.
pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    arguments.write.check(arguments.places())?;
    let table = table(arguments)?;
    println!("{table}");
    let tables: Vec<Table> = arguments.places().iter().map(|place| (*place, table.clone())).collect();
    arguments.write.tables(&tables, &arguments.command())
}

/// The table, with the command that made it above.
fn table(arguments: &Arguments) -> anyhow::Result<String> {
    let seeds: Vec<u64> = (arguments.seed..).take(arguments.trials as usize).collect();
    let started = Instant::now();
    let done = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build()?;
    let (simulated, remark) = if arguments.mujoco {
        let mut engine = mujoco::Engine::start()?;
        let mut simulated = Vec::new();
        for &seed in &seeds {
            let drawn = drawn(seed, false, FRICTION_IN_MUJOCO)?;
            let simulation = engine.simulation(&drawn).with_context(|| format!("seed {seed}"))?;
            simulated.push((drawn, simulation));
        }
        (simulated, format!("\n\n{}", engine.geometry.told()))
    } else {
        let one = |&seed: &u64| {
            let drawn = drawn(seed, arguments.rig, FRICTION).ok()?;
            let simulation = simulate_strokes(&drawn.shape, &drawn.strokes, &drawn.options).ok()?;
            Some((drawn, simulation))
        };
        (pool.install(|| seeds.par_iter().filter_map(one).collect()), String::new())
    };
    let trials: Vec<Trial> = pool.install(|| {
        let one = |(drawn, simulation): (Drawn, PivotSimulation)| {
            let rig = drawn.rig;
            // Each trial on one thread, so that its seconds are its own.
            let trial = trial(drawn, &simulation);
            if let Some(folder) = &arguments.keep
                && (seeds.len() == 1 || !(trial.is_right() && trial.is_certified()))
            {
                trial.keep(folder, &rig, &simulation)?;
            }
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            if done.is_multiple_of(50) {
                eprintln!("{done} of {} trials", seeds.len());
            }
            Ok(trial)
        };
        simulated.into_par_iter().map(one).collect::<anyhow::Result<_>>()
    })?;
    anyhow::ensure!(!trials.is_empty(), "no trial could be simulated");
    for trial in trials.iter().filter(|trial| {
        trial.panicked || trial.is_wrong() || (arguments.verbose && !(trial.is_right() && trial.is_certified()))
    }) {
        trial.tell();
    }
    let mut rows = String::new();
    let felt = |trial: &Trial| trial.found.as_ref().map_or(0.0, |(found, _)| found.coverage);
    let groups: [(&str, Vec<&Trial>); 5] = [
        ("all", trials.iter().collect()),
        ("no leaps", trials.iter().filter(|trial| trial.leaps == 0).collect()),
        ("leaps between contacts", trials.iter().filter(|trial| trial.leaps > 0).collect()),
        ("at least 60 % felt", trials.iter().filter(|trial| felt(trial) >= 0.6).collect()),
        ("at most 900 contacts", trials.iter().filter(|trial| trial.samples <= SHORT_SAMPLES).collect()),
    ];
    for (name, group) in groups {
        rows += &row(name, &group);
    }
    let panics = trials.iter().filter(|trial| trial.panicked).count();
    Ok(format!(
        "    {}\n\n{HEAD}{rows}\n{} trials in {:.0} s; {} gave a usable log; {panics} panics.{remark}",
        arguments.command(),
        seeds.len(),
        started.elapsed().as_secs_f64(),
        trials.len(),
    ))
}

const HEAD: &str = "\
| trials with | logs | right | certified | right and certified | certified, wrong | RMS r / bound (median) | RMS r (median, mm) | inside 95 % band: certified | within three error bars | seconds (median) | (95 %) |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

fn row(name: &str, trials: &[&Trial]) -> String {
    if trials.is_empty() {
        return String::new();
    }
    let share = |of: &dyn Fn(&Trial) -> bool| {
        100.0 * trials.iter().filter(|trial| of(trial)).count() as f64 / trials.len() as f64
    };
    let certified: Vec<&&Trial> = trials.iter().filter(|trial| trial.is_certified()).collect();
    let errors = |trial: &&&Trial| trial.found.as_ref().ok().map(|(_, errors)| errors.rms_r_m);
    let over_bound: Vec<f64> = certified.iter().filter_map(|trial| Some(errors(trial)? / trial.bound_m?)).collect();
    let of_r: Vec<f64> = certified.iter().filter_map(|trial| Some(1e3 * errors(trial)?)).collect();
    let seconds: Vec<f64> = trials.iter().map(|trial| trial.seconds).collect();
    let inside =
        |band: usize| certified.iter().map(|trial| trial.inside[band]).sum::<f64>() / certified.len().max(1) as f64;
    format!(
        "| {name} | {} | {:.1} % | {:.1} % | {:.1} % | {} | {:.2} | {:.4} | {:.1} % | {:.1} % | {:.3} | {:.2} |\n",
        trials.len(),
        share(&Trial::is_right),
        share(&Trial::is_certified),
        share(&|trial| trial.is_right() && trial.is_certified()),
        trials.iter().filter(|trial| trial.is_wrong()).count(),
        sorted_quantile(over_bound, 0.5),
        sorted_quantile(of_r, 0.5),
        100.0 * inside(0),
        100.0 * inside(1),
        sorted_quantile(seconds.clone(), 0.5),
        sorted_quantile(seconds, 0.95),
    )
}

fn sorted_quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile(&values, share).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Logs that were certified wrongly, or refused, each for a cause of its own (`docs/monte-carlo.md`, the pivoting grasp).
    #[test]
    fn strokes_that_went_wrong_once_are_right_and_certified() {
        let causes = [
            (10_001, "what was turned by a tip-over among long steps"),
            (8_221, "a motion whose scale had come further"),
            (8_719, "closed forms that go wrong in some segments"),
            (7_962, "one sample on the wrong side of a tip-over"),
            (10_449, "a third closed form"),
            (11_619, "a first stage that explains nothing"),
            (12_241, "strokes of one kind that lie elsewhere together"),
            (13_131, "two kinds of strokes that share no boundary"),
        ];
        for (seed, cause) in causes {
            let drawn = drawn(seed, false, FRICTION).expect("an object");
            let simulation = simulate_strokes(&drawn.shape, &drawn.strokes, &drawn.options).expect("possible");
            let trial = trial(drawn, &simulation);
            assert!(trial.is_right() && trial.is_certified(), "{seed}: {cause}");
        }
    }

    /// The right arrangement of these is not found: of a triangle with rounded corners and of an ellipse, of which one wrong one alone seems to explain the
    /// log, with many harmonics.
    #[test]
    fn what_only_many_harmonics_explain_is_not_certified() {
        for seed in [11_147, 12_632] {
            let drawn = drawn(seed, false, FRICTION).expect("an object");
            let simulation = simulate_strokes(&drawn.shape, &drawn.strokes, &drawn.options).expect("possible");
            let trial = trial(drawn, &simulation);
            assert!(trial.is_right() || !trial.is_certified(), "{seed}");
        }
    }
}
