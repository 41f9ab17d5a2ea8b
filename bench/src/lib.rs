//! The work that is timed by `cargo bench -p palpate-bench` and counted, once each, by the program of this crate
//! (`docs/performance.md`).
#![forbid(unsafe_code)]

use std::error::Error;

use palpate::information::cramer_rao_bound_m;
use palpate::palms::{PalmMotion, PalmPair};
use palpate::plan::{PalmLimits, plan_turn};
use palpate::reconstruct::{PaperEquations, Reconstruction, Reconstructor, Start};
use palpate::sensor::Touchpad;
use palpate::shape::{NamedShape, RandomShape, SupportFunction, random_shape};
use palpate::simulate::{SimulateOptions, Simulation, simulate};

/// What goes wrong here stops the benchmark; nobody tells kinds of it apart.
pub type Failure = Box<dyn Error>;

/// Standard deviation of the simulated contact positions, metres.
const NOISE_M: f64 = 0.1e-3;

/// Seed of the random object and the random motion; with this one, it jumps six times.
const JUMPY: u64 = 4;

/// How long the palms move, seconds.
const DURATION_S: f64 = 90.0;

/// An object, the motion of the palms that hold it, and how it begins.
pub struct Scene {
    /// The object.
    pub shape: SupportFunction,
    /// Times in seconds and palms.
    pub motion: Vec<(f64, PalmPair)>,
    /// Orientation that the object is let go at, radians.
    pub start_psi_rad: f64,
}

impl Scene {
    /// A pebble that is turned all the way around without a jump.
    ///
    /// # Errors
    /// Never, as long as the pebble can be turned.
    pub fn without_jumps(samples: usize) -> Result<Self, Failure> {
        let shape = NamedShape::Pebble.shape(0.03)?;
        let plan = plan_turn(&shape, &PalmLimits::default(), DURATION_S)?;
        Ok(Self { motion: sampled(&plan.motion, samples)?, shape, start_psi_rad: plan.start_psi_rad })
    }

    /// A random shape, and palms that know nothing of it: the object jumps.
    ///
    /// # Errors
    /// Never: shape and motion come from fixed seeds.
    pub fn with_jumps(samples: usize) -> Result<Self, Failure> {
        let shape = random_shape(&RandomShape::default(), JUMPY)?;
        let motion = PalmMotion::random(JUMPY, DURATION_S, 1.0)?;
        Ok(Self { shape, motion: sampled(&motion, samples)?, start_psi_rad: 0.0 })
    }

    /// What the palms feel.
    ///
    /// # Errors
    /// When the object leaves a palm; it does not.
    pub fn felt(&self) -> Result<Simulation, Failure> {
        let options = SimulateOptions {
            touchpad: Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() },
            seed: 1,
            start_psi_rad: self.start_psi_rad,
            ..SimulateOptions::default()
        };
        Ok(simulate(&self.shape, &self.motion, &options)?)
    }
}

/// The motion at this many samples, evenly spread.
fn sampled(motion: &PalmMotion, samples: usize) -> Result<Vec<(f64, PalmPair)>, Failure> {
    let mut sampled = motion.sample(samples as f64 / motion.duration_s())?;
    sampled.truncate(samples);
    Ok(sampled)
}

/// The whole reconstruction, from nothing.
///
/// # Errors
/// When the log cannot be solved; it can.
pub fn from_nothing(felt: &Simulation) -> Result<Reconstruction, Failure> {
    Ok(palpate::reconstruct(&felt.log)?)
}

/// Smoothing alone, from the truth, with 8 harmonics.
///
/// # Errors
/// When the log cannot be solved; it can.
pub fn from_truth(scene: &Scene, felt: &Simulation) -> Result<Reconstruction, Failure> {
    let psi: Vec<f64> = felt.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let start = Start::Motion { shape: scene.shape.clone(), psi_rad: psi };
    Ok(Reconstructor::new().harmonics(8).start(start).run(&felt.log)?)
}

/// The shape with so many harmonics that count, the last of them next to nothing.
pub fn with_harmonics(shape: &SupportFunction, harmonics: usize) -> SupportFunction {
    let mut values = shape.harmonics_m().to_vec();
    values.resize(harmonics, [0.0; 2]);
    if let Some(last) = values.last_mut() {
        last[0] += 0.02 * NOISE_M;
    }
    SupportFunction::new(shape.mean_radius_m(), values)
}

/// The normal equations of all samples, set up and solved once, with as many harmonics as `shape` has (see
/// [`with_harmonics`]).
///
/// # Errors
/// When the log does not determine the shape; it does.
pub fn normal_equations(shape: &SupportFunction, felt: &Simulation) -> Result<f64, Failure> {
    let psi: Vec<f64> = felt.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    cramer_rao_bound_m(&felt.log, shape, &psi, NOISE_M).ok_or_else(|| "the log does not determine the shape".into())
}

/// The paper's equations over the whole log, and r₁ and r₂ at its first sample.
///
/// # Errors
/// When the log cannot be integrated; it can.
pub fn equations(scene: &Scene, felt: &Simulation) -> Result<(PaperEquations, (f64, f64)), Failure> {
    let (sample, pose) = felt.log.samples.first().zip(felt.truth.motion.first()).ok_or("an empty log")?;
    let (theta1, theta2) = sample.palms.contact_angles(pose.psi_rad);
    Ok((PaperEquations::new(&felt.log)?, (scene.shape.radius_m(theta1), scene.shape.radius_m(theta2))))
}

/// Runs `work` on one thread.
///
/// # Errors
/// When there is no thread to be had.
pub fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    Ok(rayon::ThreadPoolBuilder::new().num_threads(1).build()?.install(work))
}
