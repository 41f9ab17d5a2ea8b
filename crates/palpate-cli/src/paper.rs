//! `palpate paper`: the simulations and the experiment of Moll & Erdmann (2001), and the figures of their paper, reproduced.

use std::path::PathBuf;

use palpate::compare::RigidMotion;
use palpate::palms::{Palm, PalmMotion, PalmMove, PalmPair};
use palpate::pivot::{PivotOptions, reconstruct_strokes};
use palpate::reconstruct::{Method, Progress, Reconstructor};
use palpate::sensor::{Touchpad, VisionSystem};
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use palpate::{Reconstruction, Truth};
use palpate_report::paper::{
    FIGURE_NAMES, PaperInput, PngError, StrokesTrial, Trial, errors_csv, figures, paper_page, png,
};
use rayon::prelude::*;

use crate::strokes;
use crate::terminal::{Ending, Failure, Terminal};

/// Measurements of the simulations, as in figure 6.
const MEASUREMENTS: usize = 270;
/// Mean radius of the object in the simulations, metres.
const RADIUS_M: f64 = 0.03;
/// Noise of the contact positions in the simulations, metres.
const NOISE_SD_M: f64 = 5e-5;
/// How fast the palms turn in the simulations, degrees per second on average.
const PACE_DEG_PER_S: f64 = 40.0;
/// Half the distance of the base points of the two fingers, metres.
const HALF_GAP_M: f64 = 0.008;

/// Mean radius of the object of the experiment: its pads are short. Metres.
const EXPERIMENT_RADIUS_M: f64 = 0.014;
/// Duration of the experiment, seconds.
const EXPERIMENT_S: f64 = 40.0;
/// Boundary felt fewer times is left out of figure 8(b).
const MIN_TOUCHES: u32 = 2;
/// Noise of the camera on each marker, metres.
const CAMERA_SD_M: f64 = 1e-4;

/// Noise of the pad under the pivoting grasp, metres, and its samples a second.
const STROKES_SD_M: f64 = 1e-4;
const STROKES_HZ: f64 = 20.0;

/// The logs that the figures are made from; the truth of each lies beside it.
const LOGS: [&str; 5] = ["palms", "exact", "fingers", "experiment", "strokes"];
/// The errors of both methods on all logs.
const ERRORS_FILE: &str = "errors.csv";
const PAGE_FILE: &str = "index.html";

const AFTER_HELP: &str = "\
DIR receives index.html (open it first), each figure as SVG and PNG, the logs that they were made from with the truth beside each, and
the errors of both methods, errors.csv.

M. Moll and M. A. Erdmann, Reconstructing Shape from Motion Using Tactile Sensors, IROS 2001: figures 1 to 8, with two palms and
with two fingers, by the differential equations of the paper and by maximum likelihood, side by side, and a table of the errors of both; and
figure 9, the pivoting grasp, with the reconstruction that the paper left open.

Example:
  palpate paper -o figures";

/// Reproduce the figures of Moll & Erdmann (2001) from data made here; no input needed
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Arguments {
    /// Folder for the figures, made if missing
    #[arg(short, long = "out", value_name = "DIR", default_value = "palpate-paper")]
    out: PathBuf,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Simulates, reconstructs, draws, and says where the page is.
pub fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let terminal = Terminal::new(arguments.quiet);
    let log_files = LOGS.map(|name| format!("{name}.csv"));
    let truth_folders = LOGS.map(|name| format!("{name}.truth"));
    let names: Vec<String> = FIGURE_NAMES
        .iter()
        .flat_map(|name| [format!("{name}.svg"), format!("{name}.png")])
        .chain(log_files)
        .chain([ERRORS_FILE, PAGE_FILE].map(str::to_owned))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    palpate_io::check_figures_target(&arguments.out, &names, &truth_folders.each_ref().map(String::as_str))?;

    let progress = terminal.progress();
    let done = |stage, fraction| progress.update(Progress { stage, fraction });
    done("two palms", 0.0);
    let palms = Made::new(self::palms(NOISE_SD_M)?)?;
    done("exact readings", 0.2);
    let exact = Made::new(self::palms(0.0)?)?;
    done("two fingers", 0.4);
    let fingers = Made::new(fingers()?)?;
    done("the experiment", 0.6);
    let vision = vision();
    let experiment = Made::new(experiment(&vision)?)?;
    done("the pivoting grasp", 0.8);
    let pebble = NamedShape::Pebble.shape(RADIUS_M)?;
    let pad = Touchpad { noise_sd_m: STROKES_SD_M, ..Touchpad::ideal() };
    let (about_pivot, felt) = strokes::simulated(&pebble, pad, STROKES_HZ, 1)?;
    let dragged = reconstruct_strokes(&felt.log, &PivotOptions::default())?;
    done("drawing", 0.9);
    let made = [&palms, &exact, &fingers, &experiment];
    let input = PaperInput {
        palms: palms.trial("two palms", LOGS[0]),
        exact: exact.trial("two palms, exact", LOGS[1]),
        fingers: fingers.trial("two fingers", LOGS[2]),
        experiment: experiment.trial("experiment", LOGS[3]),
        strokes: StrokesTrial { log: &felt.log, truth: &felt.truth, shape: &about_pivot, found: &dragged },
        vision: &vision,
        min_touches: MIN_TOUCHES,
        simulation_sd_m: NOISE_SD_M,
        version: env!("CARGO_PKG_VERSION"),
    };
    let figures = figures(&input);
    let pictures: Vec<Vec<u8>> = figures.par_iter().map(|figure| png(&figure.svg)).collect::<Result<_, PngError>>()?;
    let tables = [errors_csv(&input), paper_page(&input, &figures)];
    let of_palms = made.into_iter().map(|made| palpate_io::log_csv(&made.run.simulation.log));
    let logs: Vec<String> = of_palms.chain([palpate_io::strokes_csv(&felt.log, &[])]).collect();
    drop(progress);

    let drawn = figures.iter().zip(&pictures).flat_map(|(figure, picture)| [figure.svg.as_bytes(), picture]);
    let contents = drawn.chain(logs.iter().chain(&tables).map(String::as_bytes));
    let files: Vec<(&str, &[u8])> = names.iter().copied().zip(contents).collect();
    let all_truths = made.into_iter().map(|made| &made.run.simulation.truth).chain([&felt.truth]);
    let truths: Vec<(&str, &Truth)> = truth_folders.iter().map(String::as_str).zip(all_truths).collect();
    palpate_io::write_figures(&arguments.out, &files, &truths)?;
    terminal.say(&format!("{} figures\n  page    {}", figures.len(), arguments.out.join(PAGE_FILE).display()))?;
    Ok(Ending::Success)
}

impl From<PngError> for Failure {
    fn from(error: PngError) -> Self {
        Self::Other(error.to_string())
    }
}

/// A simulation and what it was made with.
struct Run {
    shape: SupportFunction,
    simulation: Simulation,
    pad_length_m: f64,
}

/// A simulation, reconstructed by both methods from nothing but its log.
struct Made {
    run: Run,
    ode: Reconstruction,
    likelihood: Reconstruction,
}

impl Made {
    fn new(run: Run) -> Result<Self, Failure> {
        let by = |method| Reconstructor::new().method(method).run(&run.simulation.log);
        let (ode, likelihood) = (by(Method::Ode)?, by(Method::Likelihood)?);
        Ok(Self { run, ode, likelihood })
    }

    fn trial<'a>(&'a self, name: &'a str, file: &'a str) -> Trial<'a> {
        Trial {
            name,
            file,
            log: &self.run.simulation.log,
            truth: &self.run.simulation.truth,
            shape: &self.run.shape,
            pad_length_m: self.run.pad_length_m,
            ode: &self.ode,
            likelihood: &self.likelihood,
        }
    }
}

/// A squeeze-and-rotate: the opening changes by one angle while the bisector turns by the other (degrees).
fn squeeze(open: f64, rotate: f64) -> PalmMove {
    let duration_s = (0.5 * open.abs() + rotate.abs()) / PACE_DEG_PER_S;
    PalmMove::OpenAndRotate { open_rad: open.to_radians(), rotate_rad: rotate.to_radians(), duration_s }
}

/// One palm opens by an angle (degrees) while the other stays put.
fn open(palm: Palm, angle: f64) -> PalmMove {
    PalmMove::OpenOne { palm, angle_rad: angle.to_radians(), duration_s: angle.abs() / PACE_DEG_PER_S }
}

/// Nearly flat palms.
fn flat(base1_m: [f64; 2], base2_m: [f64; 2]) -> PalmPair {
    PalmPair { base1_m, base2_m, ..PalmPair::hinged(14f64.to_radians(), 152f64.to_radians()) }
}

/// Moves that carry the object nearly once round on two palms without a jump, and the orientation that it starts from.
fn round() -> ([PalmMove; 8], f64) {
    let moves = [
        squeeze(-70.0, 20.0),
        squeeze(-10.0, -30.0),
        squeeze(-15.0, -35.0),
        open(Palm::Two, 75.0),
        squeeze(-50.0, -25.0),
        open(Palm::Two, 60.0),
        squeeze(-80.0, 0.0),
        squeeze(-20.0, -15.0),
    ];
    (moves, 5.262_694)
}

/// The motion sampled evenly, so many times.
fn sampled(motion: &PalmMotion, count: usize) -> Vec<(f64, PalmPair)> {
    let step_s = motion.duration_s() / (count - 1) as f64;
    (0..count).map(|index| step_s * index as f64).map(|time_s| (time_s, motion.at(time_s))).collect()
}

/// The simulation of figures 6 and 7, with this noise of the contact positions, metres.
fn palms(noise_sd_m: f64) -> Result<Run, Failure> {
    let (moves, start_psi_rad) = round();
    let motion = PalmMotion::schedule(flat([0.0; 2], [0.0; 2]), &moves)?;
    simulated(&motion, start_psi_rad, noise_sd_m, 1)
}

/// The same with two fingers, which need moves of their own.
fn fingers() -> Result<Run, Failure> {
    let moves = [
        squeeze(-45.0, -15.0),
        squeeze(-45.0, 25.0),
        squeeze(-15.0, 35.0),
        open(Palm::One, 75.0),
        squeeze(-15.0, 10.0),
        open(Palm::One, 40.0),
        squeeze(-80.0, 0.0),
        open(Palm::Two, 50.0),
        squeeze(-75.0, 35.0),
    ];
    let motion = PalmMotion::schedule(flat([HALF_GAP_M, 0.0], [-HALF_GAP_M, 0.0]), &moves)?;
    simulated(&motion, 2.243_967, NOISE_SD_M, 2)
}

fn simulated(motion: &PalmMotion, start_psi_rad: f64, noise_sd_m: f64, seed: u64) -> Result<Run, Failure> {
    let shape = NamedShape::Pebble.shape(RADIUS_M)?;
    let touchpad = Touchpad { noise_sd_m, ..Touchpad::ideal() };
    let options = SimulateOptions { touchpad, seed, start_psi_rad, ..SimulateOptions::default() };
    let simulation = simulate(&shape, &sampled(motion, MEASUREMENTS), &options)?;
    Ok(Run { shape, simulation, pad_length_m: 4.0 * RADIUS_M })
}

/// The camera of the experiment: an arrow and two dots on the object, two markers on each palm beyond its pad.
fn vision() -> VisionSystem {
    let pad_m = Touchpad::interlink().length_m;
    VisionSystem {
        noise_sd_m: CAMERA_SD_M,
        object_markers_m: [[-0.5, 0.0], [0.6, 0.0], [0.0, 0.5], [0.0, -0.5]]
            .map(|[x, y]| [x * EXPERIMENT_RADIUS_M, y * EXPERIMENT_RADIUS_M])
            .to_vec(),
        palm_markers_m: vec![1.08 * pad_m, 1.2 * pad_m],
        camera: RigidMotion { angle_rad: 0.04, offset_m: [0.35, 0.2] },
    }
}

/// The experiment of figure 8: the pads of the paper, part of the way there and back, and a camera for the truth.
fn experiment(vision: &VisionSystem) -> Result<Run, Failure> {
    let shape = NamedShape::Pebble.shape(EXPERIMENT_RADIUS_M)?;
    let (moves, start_psi_rad) = round();
    let (once, again) = moves.split_at(2);
    let mut schedule = once.to_vec();
    schedule.push(PalmMove::BackAndForth { times: 1, moves: again.to_vec() });
    let motion = PalmMotion::schedule(flat([0.0; 2], [0.0; 2]), &schedule)?;
    let touchpad = Touchpad::interlink();
    let count = (EXPERIMENT_S * touchpad.rate_hz) as usize + 1;
    let pace = EXPERIMENT_S / motion.duration_s();
    let path: Vec<(f64, PalmPair)> =
        sampled(&motion, count).into_iter().map(|(time_s, palms)| (pace * time_s, palms)).collect();
    let options = SimulateOptions { touchpad, seed: 3, start_psi_rad, with_forces: true, ..SimulateOptions::default() };
    let mut simulation = simulate(&shape, &path, &options)?;
    let palms: Vec<PalmPair> = path.iter().map(|(_, palms)| *palms).collect();
    let motion = vision.track(&palms, &simulation.truth.motion, 4);
    simulation.truth = Truth { motion, ..simulation.truth };
    Ok(Run { shape, simulation, pad_length_m: touchpad.length_m })
}
