//! The exact simulation: between slow palms without friction the object rests at every instant in a minimum of its potential energy, with friction
//! it rolls and slides as Coulomb's law has it, and with inertia it moves as Newton's and Euler's laws have it; what the palms feel follows from
//! eq. (3) of Moll & Erdmann 2001.

use std::f64::consts::{PI, TAU};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::SimulateError;
use crate::log::{Log, Sample};
use crate::mechanics::coulomb::{FrictionPursuit, normal_forces};
use crate::mechanics::frictionless::{Pursuit, forces_between_n};
use crate::mechanics::inertial::{Inertia, InertialPursuit, LostContact};
use crate::mechanics::{ContactMode, Jump, STANDARD_GRAVITY_M_PER_S2, contact_forces_n};
use crate::palms::{Palm, PalmAngles, PalmPair, Stance};
use crate::sensor::{ContactReading, ContactSensor, PalmContact, Touchpad};
use crate::shape::SupportFunction;
use crate::truth::{TruePose, Truth};

/// Points of the true support function that a [`Truth`] gets.
const TRUTH_POINTS: usize = 1440;

/// What a simulation needs besides shape and motion. All have a default: an [ideal](Touchpad::ideal) touchpad, seed 0, the
/// rest pose reached from ψ = 0, no friction, palms so slow that inertia plays no part, 0.1 kg, no forces.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulateOptions {
    /// The touchpads. Their rate plays no part here: the motion is sampled already. [`simulate_with`] has a sensor instead.
    pub touchpad: Touchpad,
    /// Seed of noise and drop-outs. The same seed gives the same log.
    pub seed: u64,
    /// The object is let go at this orientation (radians) before the palms begin to move.
    pub start_psi_rad: f64,
    /// Coefficients of friction of palm 1 and palm 2, not negative.
    pub friction: [f64; 2],
    /// How the object resists being turned; `None` for palms so slow that it does not matter.
    pub inertia: Option<ObjectInertia>,
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
            friction: [0.0; 2],
            inertia: None,
            mass_kg: 0.1,
            with_forces: false,
            with_stated_noise: false,
        }
    }
}

/// How an object resists being turned.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectInertia {
    /// Radius of gyration about the centre of mass, metres, positive; `None` for that of an even mass over the area of the shape.
    pub gyration_radius_m: Option<f64>,
    /// Drag on the rotation over the moment of inertia, 1/s, not negative.
    pub damping_per_s: f64,
}

/// What the robot would know, what is true, and where the object jumped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Simulation {
    /// The palm log.
    pub log: Log,
    /// True shape and motion, one pose per sample of the log; ψ is unwrapped.
    pub truth: Truth,
    /// The jumps in order of time.
    pub jumps: Vec<Jump>,
    /// What both contacts did up to each sample of the log; empty without friction.
    pub modes: Vec<[ContactMode; 2]>,
}

/// Simulates the palm log of `shape` while the palms run through `motion`, given as (time in seconds, palms).
///
/// Between two samples the palms move evenly. Poses are exact to about 10⁻¹² of the size of the object; a pose is followed
/// as long as it exists, and a jump ends in the next minimum of the energy downhill (see [`follow`](crate::mechanics::follow)). With
/// friction the object rolls on a palm or slides on both, to 10⁻⁹ rad; where no forces within the friction cones hold it, it slides until they
/// do. With inertia the palms move along a smooth curve through the samples, which must be at times of their own, and the object begins at rest
/// and moving along with them; its path is exact to about 10⁻⁹ rad, and no jump is told from the rest of it.
///
/// # Errors
/// When the shape is not convex, the motion is faulty or closes or crosses the palms, or the object leaves a palm or jams between them. The
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
    let mut simulation = Simulation::default();
    simulation.truth.support = (0..TRUTH_POINTS)
        .map(|point| TAU * point as f64 / TRUTH_POINTS as f64)
        .map(|theta| (theta, shape.radius_m(theta)))
        .collect();
    if motion.is_empty() {
        return Err(SimulateError::NoMotion);
    }
    let mut pursuit = Carried::new(shape, motion, options);
    for &(time_s, palms) in motion {
        let mut stance = Stance::default();
        let mut forces_n = (0.0, 0.0);
        let (jumps, modes) = pursuit.go_on((time_s, palms), options, &mut |time_s, palms, angles, psi, forces| {
            stance = palms.stance(angles, shape, psi);
            forces_n = forces;
            check_contact(&stance, time_s, sensor)
        })?;
        simulation.jumps.extend(jumps);
        simulation.modes.extend(modes);
        simulation.log.samples.push(sample(time_s, &palms, &stance, forces_n, sensor, options, &mut rng));
        let [com_x_m, com_y_m] = stance.center_of_mass_m;
        simulation.truth.motion.push(TruePose { time_s, psi_rad: pursuit.psi_rad(), com_x_m, com_y_m });
    }
    Ok(simulation)
}

/// The object on its way, with friction or without.
enum Carried<'a> {
    Frictionless(Pursuit<'a>),
    Coulomb(FrictionPursuit<'a>),
    Inertial(InertialPursuit<'a>),
}

impl<'a> Carried<'a> {
    /// Between the first palms of a motion, which is not empty.
    fn new(shape: &'a SupportFunction, motion: &[(f64, PalmPair)], options: &SimulateOptions) -> Self {
        let (first, start_rad) = (motion[0], options.start_psi_rad);
        if let Some(ObjectInertia { gyration_radius_m, damping_per_s }) = options.inertia {
            let gyration_m = gyration_radius_m.unwrap_or_else(|| shape.uniform_gyration_radius_m());
            let inertia = Inertia { gyration_m2: gyration_m * gyration_m, damping_per_s };
            Self::Inertial(InertialPursuit::new(shape, inertia, motion, start_rad))
        } else if options.friction == [0.0; 2] {
            Self::Frictionless(Pursuit::new(shape, first, start_rad))
        } else {
            Self::Coulomb(FrictionPursuit::new(shape, options.friction, first, start_rad))
        }
    }

    fn psi_rad(&self) -> f64 {
        match self {
            Self::Frictionless(pursuit) => pursuit.psi_rad(),
            Self::Coulomb(pursuit) => pursuit.psi_rad(),
            Self::Inertial(pursuit) => pursuit.psi_rad(),
        }
    }

    /// Goes on to the next pair of palms. `visit` is given time, palms, their angles, ψ and the normal forces (newtons). Returns the jumps on the
    /// way and, with friction, what both contacts did last.
    fn go_on(
        &mut self,
        to: (f64, PalmPair),
        options: &SimulateOptions,
        visit: &mut impl FnMut(f64, &PalmPair, &PalmAngles, f64, (f64, f64)) -> Result<(), SimulateError>,
    ) -> Result<(Vec<Jump>, Option<[ContactMode; 2]>), SimulateError> {
        match self {
            Self::Frictionless(pursuit) => {
                let jumps = pursuit.go_on(to, &mut |time_s, palms, angles, psi| {
                    visit(time_s, palms, angles, psi, forces_between_n(angles, options.mass_kg))
                })?;
                Ok((jumps, None))
            }
            Self::Coulomb(pursuit) => {
                let mut modes = None;
                let jumps = pursuit.go_on(to, &mut |seen| {
                    modes = Some(seen.modes);
                    let weight_n = options.mass_kg * STANDARD_GRAVITY_M_PER_S2;
                    let [force1, force2] = normal_forces(&seen.angles, seen.tau)
                        .ok_or(SimulateError::Jams { time_s: seen.time_s, phi2_rad: seen.palms.phi2_rad })?;
                    if force1 < 0.0 || force2 < 0.0 {
                        let palm = if force1 < 0.0 { Palm::One } else { Palm::Two };
                        return Err(SimulateError::LeavesPalm { time_s: seen.time_s, palm });
                    }
                    visit(seen.time_s, seen.palms, &seen.angles, seen.psi_rad, (weight_n * force1, weight_n * force2))
                })?;
                Ok((jumps, modes))
            }
            Self::Inertial(pursuit) => {
                let (time_s, palms) = to;
                let lost = |LostContact { time_s, palm }| SimulateError::LosesContact { time_s, palm };
                let forces = pursuit.go_on(time_s).map_err(lost)?;
                let [force1, force2] = forces.map(|force| options.mass_kg * STANDARD_GRAVITY_M_PER_S2 * force);
                visit(time_s, &palms, &palms.angles(), pursuit.psi_rad(), (force1, force2))?;
                Ok((Vec::new(), None))
            }
        }
    }
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
    if !options.friction.iter().all(|friction| *friction >= 0.0 && friction.is_finite()) {
        return Err(SimulateError::OutOfRange { what: "coefficients of friction, must be finite and not negative" });
    }
    check_inertia(motion, options)?;
    if !options.start_psi_rad.is_finite() {
        return Err(SimulateError::OutOfRange { what: "starting orientation (rad), must be finite" });
    }
    let mut last_s = f64::NEG_INFINITY;
    for (sample, (time_s, palms)) in motion.iter().enumerate() {
        if !time_s.is_finite() || *time_s < last_s || !finite(palms) {
            return Err(SimulateError::FaultyMotion { sample });
        }
        last_s = *time_s;
        check_palms(palms, *time_s, options.friction)?;
    }
    Ok(())
}

fn check_inertia(motion: &[(f64, PalmPair)], options: &SimulateOptions) -> Result<(), SimulateError> {
    let Some(ObjectInertia { gyration_radius_m, damping_per_s }) = options.inertia else { return Ok(()) };
    let wrong = |what| Err(SimulateError::OutOfRange { what });
    if !gyration_radius_m.is_none_or(|radius_m| radius_m > 0.0 && radius_m.is_finite()) {
        return wrong("radius of gyration (m), must be positive");
    }
    if !(damping_per_s >= 0.0 && damping_per_s.is_finite()) {
        return wrong("damping (1/s), must be finite and not negative");
    }
    if options.friction != [0.0; 2] {
        return wrong("friction and inertia are not simulated together: leave one of them out");
    }
    let moves = |pair: &[(f64, PalmPair)]| {
        let [one, other] = [pair[0].1, pair[1].1].map(|palms| [palms.base1_m, palms.base2_m]);
        one != other
    };
    if motion.windows(2).any(moves) {
        return wrong("base points of palms, must stay where the object has inertia");
    }
    match motion.windows(2).position(|pair| pair[1].0 <= pair[0].0) {
        Some(before) => Err(SimulateError::FaultyMotion { sample: before + 1 }),
        None => Ok(()),
    }
}

/// Palms between which an object can rest: neither parallel nor crossed, and both pushing (f₁, f₂ ≥ 0).
fn check_palms(palms: &PalmPair, time_s: f64, friction: [f64; 2]) -> Result<(), SimulateError> {
    let phi2_rad = palms.phi2_rad;
    if phi2_rad <= crate::palms::SMALLEST_OPENING_RAD || phi2_rad >= PI - crate::palms::SMALLEST_OPENING_RAD {
        return Err(SimulateError::Parallel { time_s, phi2_rad });
    }
    // Both lean against the object from below, or friction decides: nothing to compute.
    if friction != [0.0; 2] || palms.phi1_rad >= 0.0 && palms.phi12_rad() <= PI {
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
