//! Simulation: the exact quasistatic simulator against physics engines, at the accuracy that the engines reach.
//!
//! An engine has no statics; it is made quasistatic by slow palms, short steps, stiff contacts and fine polygons. Each walks up a
//! ladder of such settings until the contact positions are within the target of the exact ones (palpate's are exact to 10⁻¹² of
//! the object: `crates/palpate/tests/simulate.rs`), and that rung is timed. Both give the same samples, on one thread;
//! the start of processes and the compilation of models are not counted. The contact positions of an engine are worked out
//! from its ψ and the smooth outline, in its favour.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context as _, bail};
use palpate::palms::PalmPair;
use palpate::plan::{PalmLimits, plan_turn};
use palpate::shape::{NamedShape, SupportFunction, ellipse};
use palpate::simulate::{SimulateOptions, Simulation, simulate};

use super::Context;
use super::Worker;
use super::row::{Agreement, Row};
use super::turns::{Turns, timed};
use crate::workspace;

const JOB: &str = "simulation";

/// Mean radius of the objects, metres.
const SIZE_M: f64 = 0.03;

/// How long the palms move, seconds, and the samples of it.
const DURATION_S: f64 = 90.0;
const SAMPLES: usize = 900;

/// An engine that needs longer than this for one run is given up, seconds.
const PATIENCE_S: f64 = 300.0;

/// The engine, driven from the root of the workspace.
const MUJOCO: &str = "bench/peers/mujoco_palms.py";
const RAPIER: &str = "bench/peers/rapier/Cargo.toml";

/// How an engine is driven.
#[derive(Clone, Copy, Debug)]
struct Rung {
    /// Of the polygon; 0 for an outline that the engine knows.
    vertices: usize,
    /// What the engine stretches the motion to, seconds: the longer, the nearer to rest.
    duration_s: f64,
    step_s: f64,
    /// Damping of the rotation, in units of √(g/R).
    damping: f64,
}

const fn rung(vertices: usize, duration_s: f64, step_s: f64, damping: f64) -> Rung {
    Rung { vertices, duration_s, step_s, damping }
}

/// An engine, what it is asked for, and the rungs that it climbs, from fast to exact.
struct Peer {
    name: &'static str,
    scene: fn() -> anyhow::Result<Scene>,
    start: fn(&Context, &Path) -> anyhow::Result<Worker>,
    target_m: f64,
    ladder: &'static [Rung],
    /// Whether a quick run leaves it out.
    long: bool,
}

const PEERS: [Peer; 5] = [
    Peer {
        name: "MuJoCo, mesh",
        scene: Scene::pebble,
        start: mujoco,
        target_m: 1e-4,
        ladder: &[
            rung(1000, 150.0, 0.01, 0.1),
            rung(2000, 300.0, 0.007, 0.1),
            rung(2000, 400.0, 0.005, 0.1),
            rung(4000, 600.0, 0.005, 0.1),
        ],
        long: false,
    },
    Peer {
        name: "MuJoCo, mesh",
        scene: Scene::pebble,
        start: mujoco,
        target_m: 4e-5,
        ladder: &[rung(4000, 600.0, 0.003, 0.1), rung(8000, 500.0, 0.001, 0.1), rung(8000, 900.0, 0.001, 0.1)],
        long: true,
    },
    Peer {
        name: "MuJoCo, ellipsoid",
        scene: Scene::ellipse,
        start: mujoco,
        target_m: 1e-5,
        ladder: &[
            rung(0, 90.0, 0.01, 0.1),
            rung(0, 150.0, 0.004, 0.1),
            rung(0, 200.0, 0.004, 0.1),
            rung(0, 250.0, 0.004, 0.1),
            rung(0, 300.0, 0.002, 0.1),
        ],
        long: false,
    },
    Peer {
        name: "MuJoCo, ellipsoid",
        scene: Scene::ellipse,
        start: mujoco,
        target_m: 2e-6,
        ladder: &[rung(0, 600.0, 0.002, 0.1), rung(0, 900.0, 0.001, 0.1), rung(0, 1500.0, 0.001, 0.1)],
        long: true,
    },
    Peer {
        name: "rapier2d",
        scene: Scene::pebble,
        start: rapier,
        target_m: 2e-4,
        ladder: &[
            rung(1000, 90.0, 0.005, 0.3),
            rung(2000, 300.0, 0.002, 0.1),
            rung(3000, 300.0, 0.002, 0.1),
            rung(4000, 300.0, 0.002, 0.1),
        ],
        long: false,
    },
];

/// Compares with each engine.
#[expect(clippy::unnecessary_wraps, reason = "other jobs may fail")]
pub fn run(context: &Context, rows: &mut Vec<Row>) -> anyhow::Result<()> {
    for peer in PEERS.iter().filter(|peer| !(context.quick && peer.long)) {
        rows.push(compare(context, peer).unwrap_or_else(|error| Row::remark(JOB, peer.name, format!("{error:#}"))));
    }
    Ok(())
}

fn compare(context: &Context, peer: &Peer) -> anyhow::Result<Row> {
    let scene = (peer.scene)()?;
    let exact = scene.simulate()?;
    let path = context.folder.join(format!("{}.json", scene.name));
    fs::write(&path, scene.json(&exact)?).with_context(|| path.display().to_string())?;
    let mut worker = (peer.start)(context, &path)?;
    let mut climbed = None;
    for rung in peer.ladder {
        let (_, psi) = answer(&mut worker, rung)?;
        let error_m = scene.error_m(&exact, &psi);
        climbed = Some((rung, error_m));
        if error_m <= peer.target_m {
            break;
        }
    }
    let (rung, error_m) = climbed.context("no settings to try")?;
    let turns = Turns { most: if context.quick { 7 } else { 15 }, budget_s: if context.quick { 20.0 } else { 60.0 } };
    let medians = turns.take(
        || {
            let (seconds, simulation) = timed(|| scene.simulate());
            simulation.map(|_| seconds)
        },
        || Ok(answer(&mut worker, rung)?.0),
    )?;
    let outline = match rung.vertices {
        0 => "its own outline".to_owned(),
        vertices => format!("{vertices} vertices"),
    };
    let steps = (rung.duration_s / rung.step_s).round();
    let text =
        format!("s1, s2 of the peer off by {error_m:.1e} m RMS, with {outline} and {steps} steps; palpate is exact");
    let agreement = Agreement { holds: error_m <= peer.target_m, text };
    let harmonics = scene.shape.harmonics_m().len();
    Ok(Row::compared(JOB, (Some(scene.motion.len()), Some(harmonics)), peer.name, medians, agreement))
}

/// Seconds that the engine took, and ψ at each sample.
fn answer(worker: &mut Worker, rung: &Rung) -> anyhow::Result<(f64, Vec<f64>)> {
    let Rung { vertices, duration_s, step_s, damping } = rung;
    let words = worker.ask(&format!("{vertices} {duration_s} {step_s} {damping}"))?;
    let numbers: Vec<f64> = words.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
    let (seconds, psi) = numbers.split_first().context("an empty answer")?;
    Ok((*seconds, psi.to_vec()))
}

/// An object, the palms that turn it all the way around without a jump, and the outline as an engine may know it.
struct Scene {
    name: &'static str,
    shape: SupportFunction,
    motion: Vec<(f64, PalmPair)>,
    start_psi_rad: f64,
    /// Half the axes and the centre of an ellipse, metres.
    ellipsoid: Option<([f64; 2], [f64; 2])>,
}

impl Scene {
    fn new(name: &'static str, shape: SupportFunction) -> anyhow::Result<Self> {
        let plan = plan_turn(&shape, &PalmLimits::default(), DURATION_S)?;
        let mut motion = plan.motion.sample(SAMPLES as f64 / DURATION_S)?;
        motion.truncate(SAMPLES);
        Ok(Self { name, shape, motion, start_psi_rad: plan.start_psi_rad, ellipsoid: None })
    }

    fn pebble() -> anyhow::Result<Self> {
        Self::new("pebble", NamedShape::Pebble.shape(SIZE_M)?)
    }

    /// The engine's best case: an outline that it knows exactly.
    fn ellipse() -> anyhow::Result<Self> {
        let scale_m = SIZE_M / ellipse(1.4, 1.0)?.mean_radius_m();
        let (half_axes_m, center_m) = ([1.4 * scale_m, scale_m], [0.15 * scale_m, 0.1 * scale_m]);
        let shape = ellipse(half_axes_m[0], half_axes_m[1])?.translated(center_m[0], center_m[1]);
        Ok(Self { ellipsoid: Some((half_axes_m, center_m)), ..Self::new("ellipse", shape)? })
    }

    fn simulate(&self) -> anyhow::Result<Simulation> {
        let options = SimulateOptions { start_psi_rad: self.start_psi_rad, ..SimulateOptions::default() };
        Ok(simulate(&self.shape, &self.motion, &options)?)
    }

    /// What the engines read.
    fn json(&self, exact: &Simulation) -> anyhow::Result<String> {
        let start = exact.truth.motion.first().context("no samples")?;
        let palms =
            |angle: fn(&PalmPair) -> f64| -> Vec<f64> { self.motion.iter().map(|(_, pair)| angle(pair)).collect() };
        let scene = serde_json::json!({
            "mean_radius_m": self.shape.mean_radius_m(),
            "harmonics_m": self.shape.harmonics_m(),
            "time_s": self.motion.iter().map(|(time_s, _)| *time_s).collect::<Vec<f64>>(),
            "phi1_rad": palms(|pair| pair.phi1_rad),
            "phi12_rad": palms(PalmPair::phi12_rad),
            "start_psi_rad": start.psi_rad,
            "start_center_m": [start.com_x_m, start.com_y_m],
            "ellipsoid": self.ellipsoid.map(|(half_axes_m, center_m)| {
                serde_json::json!({ "half_axes_m": half_axes_m, "center_m": center_m })
            }),
        });
        Ok(scene.to_string())
    }

    /// Root mean square of how far the contacts of an engine's poses are from the exact ones, metres; infinite when poses lack.
    fn error_m(&self, exact: &Simulation, psi_rad: &[f64]) -> f64 {
        if psi_rad.len() != self.motion.len() {
            return f64::INFINITY;
        }
        let both = self.motion.iter().zip(psi_rad).zip(&exact.truth.motion);
        let squares = both.map(|(((_, palms), psi_rad), truth)| {
            let (s1, s2) = palms.contact_positions_m(&self.shape, *psi_rad);
            let (exact1, exact2) = palms.contact_positions_m(&self.shape, truth.psi_rad);
            (s1 - exact1).powi(2) + (s2 - exact2).powi(2)
        });
        (squares.sum::<f64>() / (2 * psi_rad.len()) as f64).sqrt()
    }
}

fn mujoco(context: &Context, scene: &Path) -> anyhow::Result<Worker> {
    let environment = context.python_with(&["numpy", "scipy", "mujoco"])?;
    Worker::start(environment.python().arg(MUJOCO).arg(scene), PATIENCE_S)
}

fn rapier(context: &Context, scene: &Path) -> anyhow::Result<Worker> {
    let built: PathBuf = context.folder.join("rapier");
    let mut build = workspace::cargo();
    workspace::run(
        build
            .args(["build", "--quiet", "--release", "--locked", "--manifest-path", RAPIER])
            .env("CARGO_TARGET_DIR", &built),
    )?;
    let program = built.join("release").join(format!("palpate-peer-rapier{}", std::env::consts::EXE_SUFFIX));
    if !program.exists() {
        bail!("{} was not built", program.display());
    }
    Worker::start(Command::new(program).arg(scene), PATIENCE_S)
}
