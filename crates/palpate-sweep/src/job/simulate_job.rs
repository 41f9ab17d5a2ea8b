//! A job that begins with a simulation: seed, object, motion and touchpads → log and truth.

use std::f64::consts::TAU;

use palpate::palms::{MotionError, PalmMotion, PalmPair};
use palpate::plan::{PalmLimits, PlanError, plan_turn};
use palpate::sensor::{Calibration, Rig, Touchpad};
use palpate::shape::{ShapeError, SupportFunction};
use palpate::simulate::{SimulateError, SimulateOptions, Simulation, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::job::object::Object;
use crate::job::touchpad::Touchpads;

/// Samples per second.
const RATE_HZ: f64 = 100.0;
/// Seconds between two of them.
const STEP_S: f64 = 1.0 / RATE_HZ;
/// Tries to find a motion under which the object stays between the palms.
const ATTEMPTS: u32 = 5;
/// The same where it must not jump either, and how many of them ask for more of the boundary.
const JUMP_FREE_ATTEMPTS: u32 = 60;
const CHOOSY_ATTEMPTS: u32 = 40;
/// Share of a palm that a planned motion uses.
const USED_LENGTH: f64 = 0.97;

/// What to simulate. The same job gives the same log: to the bit on one kind of processor and one platform, to rounding elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulateJob {
    /// Of all that is drawn: object, motion and noise.
    pub seed: u64,
    /// What is felt.
    pub object: Object,
    /// How the palms move.
    pub motion: MotionKind,
    /// Samples in the log, 100 per second; `None` for 600 to 1200, as the seed has it.
    pub samples: Option<u32>,
    /// What feels.
    pub touchpads: Touchpads,
    /// What is known of the rig: the seed draws its constants from it, the common size as stated, and the log is as such a rig writes it.
    /// `None` for a rig without errors.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rig: Option<Box<Rig>>,
}

/// How the palms move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MotionKind {
    /// Random and smooth; independent of the object, with any number of jumps.
    Random,
    /// Random and smooth; drawn again until the object does not jump and half of its boundary is felt (40 %, after 40 tries).
    RandomJumpFree,
    /// Planned for the object: a full turn without a jump; where there is none, there and back over what can be felt.
    Turn,
    /// Squeezes, rotations and openings of one palm, there and back, as in the paper; independent of the object.
    Zigzag,
}

impl MotionKind {
    /// Its name, as in a plan.
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::RandomJumpFree => "random-jump-free",
            Self::Turn => "turn",
            Self::Zigzag => "zigzag",
        }
    }
}

/// What came of a simulation.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// What the object is called in the table.
    pub object: String,
    /// The object.
    pub shape: SupportFunction,
    /// Log, truth and jumps.
    pub simulation: Simulation,
    /// The constants of the rig that wrote the log.
    pub calibration: Calibration,
}

impl Simulated {
    /// Share of the boundary (0 to 1) that the contacts of the log went over.
    pub fn felt(&self) -> f64 {
        let samples = &self.simulation.log.samples;
        let motion: Vec<(f64, PalmPair)> = samples.iter().map(|sample| (sample.time_s, sample.palms)).collect();
        palpate::simulate::coverage(&self.simulation, &motion)
    }
}

/// Why there is no log.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoLog {
    /// No such object.
    #[error("the object is not possible: {0}")]
    Shape(#[from] ShapeError),
    /// No such motion.
    #[error("the motion of the palms is not possible: {0}")]
    Motion(#[from] MotionError),
    /// No turn without a jump.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The object left the palms, or jumped where it must not, in every attempt.
    #[error("no motion out of {attempts} gave a usable log; the last one: {last}")]
    Attempts {
        /// How often it was tried.
        attempts: u32,
        /// What happened at last.
        last: String,
    },
}

impl SimulateJob {
    /// Simulates.
    ///
    /// # Errors
    /// There is no such object, or no motion that it follows.
    pub fn simulate(&self) -> Result<Simulated, NoLog> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let (object, shape) = self.object.draw(&mut rng)?;
        // Drawn in any case, so that the number of samples changes nothing else.
        let drawn: i32 = rng.random_range(600..=1200);
        let duration_s = STEP_S * (self.samples.map_or(f64::from(drawn), f64::from) - 1.0);
        let simulation = match self.motion {
            MotionKind::Random => self.random(&shape, duration_s, &mut rng),
            MotionKind::RandomJumpFree => self.random_jump_free(&shape, duration_s, &mut rng),
            MotionKind::Turn => self.turn(&shape, duration_s, &mut rng),
            MotionKind::Zigzag => self.zigzag(&shape, duration_s, &mut rng),
        }?;
        let rig = self.rig.as_deref().copied().unwrap_or_default();
        let calibration = rig.at_stated_size(&rig.drawn(self.seed));
        let log = calibration.distorted(&simulation.log);
        Ok(Simulated { object, shape, simulation: Simulation { log, ..simulation }, calibration })
    }

    fn random(&self, shape: &SupportFunction, duration_s: f64, rng: &mut ChaCha8Rng) -> Result<Simulation, NoLog> {
        let mut last = String::new();
        for _ in 0..ATTEMPTS {
            let motion = PalmMotion::random(rng.random(), duration_s, 1.0)?;
            match self.felt(shape, &motion.sample(RATE_HZ)?, rng) {
                Ok(simulation) => return Ok(simulation),
                Err(error) => last = error.to_string(),
            }
        }
        Err(NoLog::Attempts { attempts: ATTEMPTS, last })
    }

    fn random_jump_free(
        &self,
        shape: &SupportFunction,
        duration_s: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Simulation, NoLog> {
        let mut last = String::new();
        for attempt in 0..JUMP_FREE_ATTEMPTS {
            let amplitude = rng.random_range(0.3..1.0);
            let motion = PalmMotion::random(rng.random(), duration_s, amplitude)?;
            let enough = if attempt < CHOOSY_ATTEMPTS { 0.5 } else { 0.4 };
            match self.felt(shape, &motion.sample(RATE_HZ)?, rng) {
                Ok(simulation) if !simulation.jumps.is_empty() => last = "the object jumped".to_owned(),
                Ok(simulation) if coverage(&simulation) <= enough => last = "too little was felt".to_owned(),
                Ok(simulation) => return Ok(simulation),
                Err(error) => last = error.to_string(),
            }
        }
        Err(NoLog::Attempts { attempts: JUMP_FREE_ATTEMPTS, last })
    }

    fn turn(&self, shape: &SupportFunction, duration_s: f64, rng: &mut ChaCha8Rng) -> Result<Simulation, NoLog> {
        let palm_length_m = USED_LENGTH * Touchpad::from(self.touchpads).length_m;
        let planned = plan_turn(shape, &PalmLimits { palm_length_m, ..PalmLimits::default() }, duration_s)?;
        let options = SimulateOptions { start_psi_rad: planned.start_psi_rad, ..self.options(rng) };
        once(simulate(shape, &planned.motion.sample(RATE_HZ)?, &options))
    }

    fn zigzag(&self, shape: &SupportFunction, duration_s: f64, rng: &mut ChaCha8Rng) -> Result<Simulation, NoLog> {
        let motion = PalmMotion::squeeze_and_rotate(duration_s, 2)?;
        once(self.felt(shape, &motion.sample(RATE_HZ)?, rng))
    }

    fn felt(
        &self,
        shape: &SupportFunction,
        motion: &[(f64, PalmPair)],
        rng: &mut ChaCha8Rng,
    ) -> Result<Simulation, SimulateError> {
        simulate(shape, motion, &self.options(rng))
    }

    /// Draws the seed of the noise, then where the object is let go.
    fn options(&self, rng: &mut ChaCha8Rng) -> SimulateOptions {
        SimulateOptions {
            touchpad: self.touchpads.into(),
            seed: rng.random(),
            start_psi_rad: rng.random_range(0.0..TAU),
            ..SimulateOptions::default()
        }
    }
}

/// The result of a motion that is tried once.
fn once(simulated: Result<Simulation, SimulateError>) -> Result<Simulation, NoLog> {
    simulated.map_err(|error| NoLog::Attempts { attempts: 1, last: error.to_string() })
}

/// Share of the boundary that a contact went over, in steps of a degree.
fn coverage(simulation: &Simulation) -> f64 {
    let mut seen = [false; 360];
    for (sample, pose) in simulation.log.samples.iter().zip(&simulation.truth.motion) {
        let (one, two) = sample.palms.contact_angles(pose.psi_rad);
        for theta in [one, two] {
            seen[(theta.rem_euclid(TAU) / TAU * 360.0) as usize % 360] = true;
        }
    }
    seen.iter().filter(|seen| **seen).count() as f64 / 360.0
}
