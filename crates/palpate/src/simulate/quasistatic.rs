//! The exact quasistatic simulation: at every instant the object rests in a minimum of its potential energy, and what the
//! palms feel follows from eq. (3) of Moll & Erdmann 2001.

use std::f64::consts::{PI, TAU};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::SimulateError;
use crate::log::{Log, Sample};
use crate::mechanics::frictionless::{Pursuit, forces_between_n};
use crate::mechanics::{Jump, contact_forces_n};
use crate::palms::{Palm, PalmPair, Stance};
use crate::sensor::{ContactReading, ContactSensor, PalmContact, Touchpad};
use crate::shape::SupportFunction;
use crate::truth::{TruePose, Truth};

/// Points of the true support function that a [`Truth`] gets.
const TRUTH_POINTS: usize = 1440;

/// What a simulation needs besides shape and motion. All have a default: an [ideal](Touchpad::ideal) touchpad, seed 0, the
/// rest pose reached from ψ = 0, 0.1 kg, no forces.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulateOptions {
    /// The touchpads. Their rate plays no part here: the motion is sampled already. [`simulate_with`] has a sensor instead.
    pub touchpad: Touchpad,
    /// Seed of noise and drop-outs. The same seed gives the same log.
    pub seed: u64,
    /// The object is let go at this orientation (radians) before the palms begin to move.
    pub start_psi_rad: f64,
    /// Mass in kilograms, positive; of consequence for the forces only.
    pub mass_kg: f64,
    /// Whether to report the normal forces.
    pub with_forces: bool,
    /// Whether the log states the standard deviation of its readings, where the sensor tells one.
    pub with_stated_noise: bool,
}

impl Default for SimulateOptions {
    fn default() -> Self {
        Self {
            touchpad: Touchpad::ideal(),
            seed: 0,
            start_psi_rad: 0.0,
            mass_kg: 0.1,
            with_forces: false,
            with_stated_noise: false,
        }
    }
}

/// What the robot would know, what is true, and where the object jumped.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// The palm log.
    pub log: Log,
    /// True shape and motion, one pose per sample of the log; ψ is unwrapped.
    pub truth: Truth,
    /// The jumps in order of time.
    pub jumps: Vec<Jump>,
}

/// Simulates the palm log of `shape` while the palms run through `motion`, given as (time in seconds, palms).
///
/// Between two samples the palms move evenly. Poses are exact to about 10⁻¹² of the size of the object; a pose is followed
/// as long as it exists, and a jump ends in the next minimum of the energy downhill (see [`follow`](crate::mechanics::follow)).
///
/// # Errors
/// When the shape is not convex, the motion is faulty or closes or crosses the palms, or the object leaves a palm. The
/// error names the time at which it happens.
pub fn simulate(
    shape: &SupportFunction,
    motion: &[(f64, PalmPair)],
    options: &SimulateOptions,
) -> Result<Simulation, SimulateError> {
    if let Some(what) = options.touchpad.fault() {
        return Err(SimulateError::OutOfRange { what });
    }
    simulate_with(shape, motion, &mut options.touchpad.clone(), options)
}

/// The same with a sensor of one's own, or a closure, in place of the touchpads of the options: for noise with heavy tails, drift, a bias
/// that depends on the position. See [`ContactSensor`].
///
/// # Errors
/// As [`simulate`].
pub fn simulate_with(
    shape: &SupportFunction,
    motion: &[(f64, PalmPair)],
    sensor: &mut impl ContactSensor,
    options: &SimulateOptions,
) -> Result<Simulation, SimulateError> {
    check(shape, motion, options)?;
    let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
    let mut simulation = Simulation { log: Log::default(), truth: Truth::default(), jumps: Vec::new() };
    simulation.truth.support = (0..TRUTH_POINTS)
        .map(|point| TAU * point as f64 / TRUTH_POINTS as f64)
        .map(|theta| (theta, shape.radius_m(theta)))
        .collect();
    let Some(&first) = motion.first() else { return Err(SimulateError::NoMotion) };
    let mut pursuit = Pursuit::new(shape, first, options.start_psi_rad);
    for &(time_s, palms) in motion {
        let mut stance = Stance::default();
        let mut forces_n = (0.0, 0.0);
        let jumps = pursuit.go_on((time_s, palms), &mut |time_s, palms, angles, psi| {
            stance = palms.stance(angles, shape, psi);
            forces_n = forces_between_n(angles, options.mass_kg);
            check_contact(&stance, time_s, sensor)
        })?;
        simulation.jumps.extend(jumps);
        simulation.log.samples.push(sample(time_s, &palms, &stance, forces_n, sensor, options, &mut rng));
        let [com_x_m, com_y_m] = stance.center_of_mass_m;
        simulation.truth.motion.push(TruePose { time_s, psi_rad: pursuit.psi_rad(), com_x_m, com_y_m });
    }
    Ok(simulation)
}

fn sample(
    time_s: f64,
    palms: &PalmPair,
    stance: &Stance,
    (force1, force2): (f64, f64),
    sensor: &mut impl ContactSensor,
    options: &SimulateOptions,
    rng: &mut ChaCha8Rng,
) -> Sample {
    let contact = |palm: Palm, position_m: f64, force_n: f64| PalmContact { time_s, palm, position_m, force_n };
    let reading1 = sensor.read_contact(&contact(Palm::One, stance.s1_m, force1), rng);
    let reading2 = sensor.read_contact(&contact(Palm::Two, stance.s2_m, force2), rng);
    let (phi1_rad, phi2_rad) = sensor.read_angles_rad(time_s, palms, rng);
    let stated = |reading: Option<ContactReading>| {
        let sd_m = reading.and_then(|reading| reading.position_sd_m).or_else(|| sensor.position_sd_m());
        sd_m.filter(|sd| options.with_stated_noise && *sd > 0.0)
    };
    let force = |reading: ContactReading| reading.force_n.filter(|_| options.with_forces);
    Sample {
        time_s,
        palms: PalmPair { phi1_rad, phi2_rad, ..*palms },
        s1_m: reading1.map(|reading| reading.position_m),
        s2_m: reading2.map(|reading| reading.position_m),
        s1_sd_m: stated(reading1),
        s2_sd_m: stated(reading2),
        force1_n: reading1.and_then(force),
        force2_n: reading2.and_then(force),
    }
}

fn check(shape: &SupportFunction, motion: &[(f64, PalmPair)], options: &SimulateOptions) -> Result<(), SimulateError> {
    let finite = |palms: &PalmPair| {
        let numbers = [[palms.phi1_rad, palms.phi2_rad], palms.base1_m, palms.base2_m];
        numbers.iter().flatten().all(|value| value.is_finite()) && palms.phi1_rad.abs() <= 2.0 * TAU
    };
    let smallest_m = shape.min_curvature_radius_m();
    if shape.has_nonfinite() || shape.mean_radius_m() <= 0.0 || smallest_m < 0.0 {
        return Err(SimulateError::NotConvex { smallest_m: if shape.has_nonfinite() { f64::NAN } else { smallest_m } });
    }
    if !(options.mass_kg > 0.0 && options.mass_kg.is_finite()) {
        return Err(SimulateError::OutOfRange { what: "mass (kg), must be positive" });
    }
    if !options.start_psi_rad.is_finite() {
        return Err(SimulateError::OutOfRange { what: "starting orientation (rad), must be finite" });
    }
    let mut last_s = f64::NEG_INFINITY;
    for (sample, (time_s, palms)) in motion.iter().enumerate() {
        if !time_s.is_finite() || *time_s < last_s || !finite(palms) {
            return Err(SimulateError::FaultyMotion { sample });
        }
        last_s = *time_s;
        check_palms(palms, *time_s)?;
    }
    Ok(())
}

/// Palms between which an object can rest: neither parallel nor crossed, and both pushing (f₁, f₂ ≥ 0).
fn check_palms(palms: &PalmPair, time_s: f64) -> Result<(), SimulateError> {
    let phi2_rad = palms.phi2_rad;
    if phi2_rad <= crate::palms::SMALLEST_OPENING_RAD || phi2_rad >= PI - crate::palms::SMALLEST_OPENING_RAD {
        return Err(SimulateError::Parallel { time_s, phi2_rad });
    }
    // Both lean against the object from below: nothing to compute.
    if palms.phi1_rad >= 0.0 && palms.phi12_rad() <= PI {
        return Ok(());
    }
    let (force1, force2) = contact_forces_n(palms, 1.0);
    if force1 < 0.0 || force2 < 0.0 {
        let palm = if force1 < 0.0 { Palm::One } else { Palm::Two };
        return Err(SimulateError::LeavesPalm { time_s, palm });
    }
    Ok(())
}

fn check_contact(stance: &Stance, time_s: f64, sensor: &impl ContactSensor) -> Result<(), SimulateError> {
    for (palm, position_m) in [(Palm::One, stance.s1_m), (Palm::Two, stance.s2_m)] {
        let length_m = sensor.length_m(palm);
        if !(0.0..=length_m).contains(&position_m) {
            return Err(SimulateError::RunsOff { time_s, palm, position_m, length_m });
        }
    }
    Ok(())
}
