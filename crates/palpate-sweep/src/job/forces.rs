//! A job in which more than gravity acts: palms with friction, or palms so fast that the inertia of the object counts. Everything is drawn from one
//! seed, as the accuracy study has it (`docs/monte-carlo.md`). Where the palms lose the object, the log ends.

use std::f64::consts::TAU;

use palpate::palms::{PalmMotion, PalmPair};
use palpate::sensor::{Calibration, Touchpad};
use palpate::shape::SupportFunction;
use palpate::simulate::{ObjectInertia, SimulateError, SimulateOptions, Simulation, simulate};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};

use crate::job::object::Object;
use crate::job::simulate_job::{NoLog, Simulated};

/// Tries to find a motion under which the object stays between the palms for long enough.
const ATTEMPTS: u32 = 12;

/// Samples of the shortest log.
const LEAST_SAMPLES: usize = 200;

/// Share of logs without friction, and of equal coefficients on both palms; the least and the largest that is drawn.
const WITHOUT_FRICTION: f64 = 0.1;
const EQUAL: f64 = 0.5;
const FRICTION: (f64, f64) = (0.02, 0.4);

/// With friction: seconds and rate of the readings.
const SLOW_S: (f64, f64) = (60.0, 110.0);
const SLOW_HZ: f64 = 15.0;

/// Without: the speed of the palms against palms that take so many seconds, from 1 to this as evenly on a logarithmic scale; and the rate.
const FASTEST: f64 = 50.0;
const UNHURRIED_S: (f64, f64) = (30.0, 80.0);
const SAMPLES: (f64, f64) = (300.0, 1200.0);
const RATES_HZ: (f64, f64) = (20.0, 1000.0);

/// Radius of gyration over that of an even mass, and damping, 1/s.
const GYRATION: (f64, f64) = (0.7, 1.1);
const DAMPING_PER_S: (f64, f64) = (0.0, 2.0);

/// Share of logs with measured forces, and of these that of logs in which only one palm measures them; their noise, as a share of each.
const MEASURED: f64 = 1.0 / 3.0;
const BY_ONE_PALM: f64 = 0.25;
const FORCE_NOISE: f64 = 0.02;

/// Standard deviations of the contact positions, metres.
const NOISES_M: [f64; 3] = [0.03e-3, 0.05e-3, 0.1e-3];

/// Streams of random numbers for what forces are measured, apart from all else.
const FORCES_STREAM: u64 = 1;

/// Which forces act besides gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ActingForces {
    /// Friction on slow palms.
    Friction,
    /// The inertia of the object between fast palms.
    Inertia,
}

/// Everything is drawn from this seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ForcesJob {
    /// The seed.
    pub seed: u64,
    /// The forces.
    pub forces: ActingForces,
}

/// What was drawn for a [`ForcesJob`], besides object, motion and noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnForces {
    /// Standard deviation of the contact positions, metres.
    pub noise_sd_m: f64,
    /// Coefficients of friction of both palms.
    pub friction: [f64; 2],
    /// How many times faster than unhurried palms.
    pub speed: f64,
    /// Radius of gyration over that of an even mass, and damping in 1/s.
    pub inertia: Option<(f64, f64)>,
    /// Which palms measure their normal forces.
    pub measured: [bool; 2],
}

impl DrawnForces {
    fn draw(forces: ActingForces, rng: &mut ChaCha8Rng) -> Self {
        let measured = Self::draw_measured(rng.clone());
        let noise_sd_m = NOISES_M[rng.random_range(0..NOISES_M.len())];
        match forces {
            ActingForces::Friction => {
                let first = rng.random_range(FRICTION.0..FRICTION.1);
                let second = rng.random_range(FRICTION.0..FRICTION.1);
                let friction = if rng.random_bool(EQUAL) { [first; 2] } else { [first, second] };
                let friction = if rng.random_bool(WITHOUT_FRICTION) { [0.0; 2] } else { friction };
                Self { noise_sd_m, friction, speed: 1.0, inertia: None, measured }
            }
            ActingForces::Inertia => {
                let speed = FASTEST.powf(rng.random_range(0.0..1.0));
                let gyration = rng.random_range(GYRATION.0..GYRATION.1);
                let damping = rng.random_range(DAMPING_PER_S.0..DAMPING_PER_S.1);
                Self { noise_sd_m, friction: [0.0; 2], speed, inertia: Some((gyration, damping)), measured }
            }
        }
    }

    /// From a stream of their own.
    fn draw_measured(mut rng: ChaCha8Rng) -> [bool; 2] {
        rng.set_stream(FORCES_STREAM);
        if !rng.random_bool(MEASURED) {
            return [false; 2];
        }
        let first = rng.random_bool(0.5);
        if rng.random_bool(BY_ONE_PALM) { [first, !first] } else { [true; 2] }
    }

    /// Palms that move at that speed, and the rate at which they are read.
    fn motion(&self, rng: &mut ChaCha8Rng) -> Result<(f64, Vec<(f64, PalmPair)>), NoLog> {
        let amplitude = rng.random_range(0.4..1.0);
        let (duration_s, rate_hz) = match self.inertia {
            None => (rng.random_range(SLOW_S.0..SLOW_S.1), SLOW_HZ),
            Some(_) => {
                let duration_s = rng.random_range(UNHURRIED_S.0..UNHURRIED_S.1) / self.speed;
                let samples = rng.random_range(SAMPLES.0..SAMPLES.1);
                (duration_s, (samples / duration_s).clamp(RATES_HZ.0, RATES_HZ.1))
            }
        };
        let motion = PalmMotion::random(rng.random(), duration_s, amplitude)?;
        Ok((rate_hz, motion.sample(rate_hz)?))
    }
}

impl ForcesJob {
    /// What is drawn for it.
    pub fn drawn(self) -> DrawnForces {
        DrawnForces::draw(self.forces, &mut ChaCha8Rng::seed_from_u64(self.seed))
    }

    /// Leaves the forces of the palms that measure them, with their noise.
    fn measure_forces(self, measured: [bool; 2], simulation: &mut Simulation) {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(FORCES_STREAM + 1);
        for sample in &mut simulation.log.samples {
            for (palm, force) in [&mut sample.force1_n, &mut sample.force2_n].into_iter().enumerate() {
                let noise: f64 = rng.sample(StandardNormal);
                *force = force.filter(|_| measured[palm]).map(|force| (force * (1.0 + FORCE_NOISE * noise)).max(0.0));
            }
        }
    }

    /// Simulates.
    ///
    /// # Errors
    /// There is no such object, or no motion under which it stays between the palms.
    pub fn simulate(self) -> Result<Simulated, NoLog> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let drawn = DrawnForces::draw(self.forces, &mut rng);
        let (object, shape) = Object::Mixed.draw(&mut rng)?;
        let inertia = drawn.inertia.map(|(gyration, damping_per_s)| ObjectInertia {
            gyration_radius_m: Some(gyration * shape.uniform_gyration_radius_m()),
            damping_per_s,
        });
        let mut last = String::new();
        for _ in 0..ATTEMPTS {
            let (rate_hz, motion) = drawn.motion(&mut rng)?;
            let options = SimulateOptions {
                touchpad: Touchpad { noise_sd_m: drawn.noise_sd_m, ..Touchpad::ideal() },
                seed: rng.random(),
                start_psi_rad: rng.random_range(0.0..TAU),
                friction: drawn.friction,
                inertia,
                with_forces: drawn.measured != [false; 2],
                ..SimulateOptions::default()
            };
            match until_lost(&shape, motion, 1.0 / rate_hz, &options) {
                Ok(mut simulation) => {
                    self.measure_forces(drawn.measured, &mut simulation);
                    return Ok(Simulated { object, shape, simulation, calibration: Calibration::default() });
                }
                Err(error) => last = error.to_string(),
            }
        }
        Err(NoLog::Attempts { attempts: ATTEMPTS, last })
    }
}

/// The simulation up to where the palms lose the object, where that is long enough.
fn until_lost(
    shape: &SupportFunction,
    mut motion: Vec<(f64, PalmPair)>,
    step_s: f64,
    options: &SimulateOptions,
) -> Result<Simulation, SimulateError> {
    loop {
        match simulate(shape, &motion, options) {
            Err(SimulateError::LosesContact { time_s, .. } | SimulateError::RunsOff { time_s, .. })
                if motion.iter().filter(|(time, _)| *time < time_s - step_s).count() >= LEAST_SAMPLES =>
            {
                motion.retain(|(time, _)| *time < time_s - step_s);
            }
            result => return result,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_seed_gives_one_log() {
        for forces in [ActingForces::Friction, ActingForces::Inertia] {
            let job = ForcesJob { seed: 7_100_000, forces };
            let (once, again) = (job.simulate().expect("a log"), job.simulate().expect("a log"));
            assert_eq!(once.simulation.log, again.simulation.log);
            assert!(once.simulation.log.samples.len() >= LEAST_SAMPLES);
            assert_eq!(job.drawn().inertia.is_some(), forces == ActingForces::Inertia);
        }
    }

    #[test]
    fn coefficients_are_equal_different_and_none() {
        let drawn: Vec<[f64; 2]> =
            (0..300).map(|seed| ForcesJob { seed, forces: ActingForces::Friction }.drawn().friction).collect();
        let count = |of: &dyn Fn(&[f64; 2]) -> bool| drawn.iter().filter(|friction| of(friction)).count();
        assert!((15..50).contains(&count(&|friction| *friction == [0.0; 2])));
        assert!((100..170).contains(&count(&|friction| friction[0] == friction[1] && friction[0] > 0.0)));
        assert!(drawn.iter().flatten().all(|friction| *friction == 0.0 || (FRICTION.0..FRICTION.1).contains(friction)));
    }
}
