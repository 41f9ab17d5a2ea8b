//! Strokes of a pivoting grasp in MuJoCo, which knows nothing of palpate: `bench/peers/mujoco_pivot.py`.

use anyhow::Context as _;
use palpate::pivot::{PivotLog, PivotSample, PivotSimulation};
use palpate::sensor::PadContact;
use palpate::truth::{TruePose, Truth};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde_json::json;

use crate::bench_peers::{VERSIONS, Worker};
use crate::python::Environment;
use crate::studies::monte_carlo::quantile;
use crate::studies::pivot::Drawn;
use crate::workspace;

const PROGRAM: &str = "bench/peers/mujoco_pivot.py";
/// Simulated minutes take seconds.
const PATIENCE_S: f64 = 600.0;
/// Numbers of a sample in an answer.
const NUMBERS: usize = 5;
/// Samples of the true support function.
const TRUTH_SAMPLES: u32 = 720;

/// How far contacts are from where the support function has them, metres.
#[derive(Clone, Debug, Default)]
pub struct Geometry {
    height_m: Vec<f64>,
    offset_m: Vec<f64>,
}

impl Geometry {
    /// The two distances that nine in ten and 99 in 100 contacts keep, in words.
    pub fn told(&self) -> String {
        let within = |distances_m: &[f64]| {
            let mut sorted = distances_m.to_vec();
            sorted.sort_by(f64::total_cmp);
            let [usual, most] = [0.9, 0.99].map(|share| 1e3 * quantile(&sorted, share).unwrap_or(f64::NAN));
            format!("{usual:.4} mm for 90 % and {most:.4} mm for 99 %")
        };
        format!(
            "Of {} contacts, the height of the pivot is within {} of the support function, the offset within {} of its derivative.",
            self.height_m.len(),
            within(&self.height_m),
            within(&self.offset_m),
        )
    }
}

/// MuJoCo, ready for scenes.
pub struct Engine {
    worker: Worker,
    pub geometry: Geometry,
}

impl Engine {
    pub fn start() -> anyhow::Result<Self> {
        let folder = workspace::target().join("peers");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let environment = Environment::provide_in(folder)?;
        environment.install(&["numpy", "mujoco"], VERSIONS)?;
        let worker = Worker::start(environment.python().arg(PROGRAM), PATIENCE_S)?;
        Ok(Self { worker, geometry: Geometry::default() })
    }

    /// What pad and arm read of the strokes of a scene, and what is behind it.
    pub fn simulation(&mut self, drawn: &Drawn) -> anyhow::Result<PivotSimulation> {
        let Drawn { shape, strokes, options, .. } = drawn;
        let pad = options.rig.pad;
        let scene = json!({
            "harmonics_m": shape.harmonics_m(),
            "mean_radius_m": shape.mean_radius_m(),
            "center_of_mass_m": options.center_of_mass_m,
            "tilt_rad": pad.tilt_rad,
            "friction": options.friction,
            "strokes": strokes,
            "drag_m_per_s": options.drag_m_per_s,
            "lift_m_per_s": options.lift_m_per_s,
            "rate_hz": options.rate_hz,
        });
        let words = self.worker.ask(&scene.to_string())?;
        let numbers: Vec<f64> = words.iter().map(|word| word.parse()).collect::<Result<_, _>>()?;
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        let mut simulation = PivotSimulation {
            log: PivotLog::default(),
            truth: Truth::default(),
            theta_rad: Vec::new(),
            leaps: Vec::new(),
        };
        let angle = |node: u32| std::f64::consts::TAU * f64::from(node) / f64::from(TRUTH_SAMPLES);
        simulation.truth.support = (0..TRUTH_SAMPLES).map(|node| (angle(node), shape.radius_m(angle(node)))).collect();
        let mut before: Option<[f64; 2]> = None;
        for row in numbers.chunks_exact(NUMBERS) {
            let [time_s, along_m, above_m, position_m, turned_rad]: [f64; NUMBERS] = row.try_into()?;
            let touches = position_m.is_finite();
            let psi_rad = pad.tilt_rad + turned_rad;
            // ψ of a contact angle is its own inverse.
            let theta_rad = pad.psi_rad(psi_rad);
            if touches {
                let contact = shape.at(theta_rad);
                self.geometry.height_m.push((contact.r - above_m).abs());
                self.geometry.offset_m.push((contact.d - (along_m - position_m)).abs());
                if let Some([theta_before, along_before]) = before {
                    let rolled = (along_m - along_before).abs() / contact.r;
                    if (theta_rad - theta_before).abs() > 2.0 * rolled + 0.02 {
                        simulation.leaps.push(simulation.log.samples.len());
                    }
                }
            }
            before = touches.then_some([theta_rad, along_m]);
            let contact = PadContact { position_m, force_n: 1.0 };
            let reading = options.touchpad.read(if touches { std::slice::from_ref(&contact) } else { &[] }, &mut rng);
            let [x_m, y_m] = pad.point(along_m, above_m);
            let mut noise = || options.arm_noise_sd_m * rng.sample::<f64, _>(StandardNormal);
            simulation.log.samples.push(PivotSample {
                time_s,
                pivot_x_m: x_m + noise(),
                pivot_y_m: y_m + noise(),
                s_m: reading.map(|reading| reading.position_m),
            });
            let ([cx, cy], (sin, cos)) = (options.center_of_mass_m, psi_rad.sin_cos());
            simulation.truth.motion.push(TruePose {
                time_s,
                psi_rad,
                com_x_m: x_m + cx * cos - cy * sin,
                com_y_m: y_m + cx * sin + cy * cos,
            });
            simulation.theta_rad.push(touches.then_some(theta_rad));
        }
        Ok(simulation)
    }
}
