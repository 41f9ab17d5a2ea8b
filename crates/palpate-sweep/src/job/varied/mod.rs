//! A job of the world as it is: object, motion of the palms, sensors and log all drawn from one seed, each factor by itself. The kinds
//! and their shares are those of the accuracy study over varied conditions (`docs/monte-carlo.md`).

mod motion;
mod object;
mod sensor;

use std::f64::consts::TAU;

use palpate::sensor::Calibration;
use palpate::simulate::{SimulateOptions, Simulation, simulate_with};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::job::simulate_job::{NoLog, Simulated};

pub use motion::{MotionConditions, MotionShape};
pub use sensor::{NoiseShape, SensorConditions};

/// Tries to find a motion under which the object stays between the palms.
const ATTEMPTS: u32 = 8;

/// Share of the logs that are cut at both ends, and the least part that is kept.
const CUT_SHARE: f64 = 0.2;
const LEAST_KEPT: f64 = 0.3;

/// Samples of the shortest log.
const LEAST_SAMPLES: usize = 50;

/// Everything is drawn from this seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VariedJob {
    /// The seed.
    pub seed: u64,
}

/// What was drawn for a [`VariedJob`], besides the noise itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// How the palms move, and how often they are read.
    pub motion: MotionConditions,
    /// How the pads err.
    pub sensor: SensorConditions,
    /// The part of the log that is kept, from and to, as shares of its length.
    pub kept: (f64, f64),
}

impl Conditions {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let motion = MotionConditions::draw(rng);
        let sensor = SensorConditions::draw(rng);
        let length = rng.random_range(LEAST_KEPT..1.0);
        let from = rng.random_range(0.0..1.0 - length);
        let cut = rng.random_bool(CUT_SHARE);
        Self { motion, sensor, kept: if cut { (from, from + length) } else { (0.0, 1.0) } }
    }

    /// Whether the estimator's own assumptions about the noise hold: independent from sample to sample, alike everywhere, Gaussian or from
    /// rounding.
    pub fn as_assumed(&self) -> bool {
        self.sensor.as_assumed()
    }

    /// In a few words: motion, sensor and cut.
    pub fn words(&self) -> (String, String) {
        let cut = if self.kept == (0.0, 1.0) { "" } else { ", cut" };
        (format!("{}{cut}", self.motion.words()), self.sensor.words())
    }
}

impl VariedJob {
    /// What is drawn for it.
    pub fn conditions(self) -> Conditions {
        Conditions::draw(&mut ChaCha8Rng::seed_from_u64(self.seed))
    }

    /// Simulates.
    ///
    /// # Errors
    /// There is no such object, or no motion under which it stays between the palms.
    pub fn simulate(self) -> Result<Simulated, NoLog> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let conditions = Conditions::draw(&mut rng);
        let (object, shape) = object::draw(&mut rng)?;
        let mut last = String::new();
        for _ in 0..ATTEMPTS {
            let motion = conditions.motion.course(&mut rng)?;
            let options = SimulateOptions {
                seed: rng.random(),
                start_psi_rad: rng.random_range(0.0..TAU),
                ..SimulateOptions::default()
            };
            let mut sensor = conditions.sensor.start(motion.len(), shape.mean_radius_m());
            match simulate_with(&shape, &motion, &mut sensor, &options) {
                Ok(simulation) => {
                    return Ok(Simulated {
                        object,
                        shape,
                        simulation: cut(simulation, conditions.kept),
                        calibration: Calibration::default(),
                    });
                }
                Err(error) => last = error.to_string(),
            }
        }
        Err(NoLog::Attempts { attempts: ATTEMPTS, last })
    }
}

/// The part of a simulation from one share of its length to another.
fn cut(mut simulation: Simulation, (from, to): (f64, f64)) -> Simulation {
    let samples = simulation.log.samples.len();
    let place = |share: f64| (share * samples as f64).round() as usize;
    let (first, last) = (place(from), place(to).min(samples));
    if last - first >= LEAST_SAMPLES && last - first < samples {
        simulation.log.samples = simulation.log.samples[first..last].to_vec();
        simulation.truth.motion = simulation.truth.motion[first..last].to_vec();
        let times = simulation.log.samples.first().zip(simulation.log.samples.last());
        if let Some((first, last)) = times.map(|(first, last)| (first.time_s, last.time_s)) {
            simulation.jumps.retain(|jump| (first..=last).contains(&jump.time_s));
        }
    }
    simulation
}

#[cfg(test)]
mod tests;
