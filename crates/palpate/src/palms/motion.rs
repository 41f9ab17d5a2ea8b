//! Palm motions: how the two palms turn over time, as piecewise schedules or as smooth courses.
//!
//! The paper moves its palms through "squeeze-and-rotate motions and motions where one of the palms stays put and the other
//! palm opens up", back and forth "in order to cover the shape several times" (Moll & Erdmann 2001, sections 4 and 5).

use std::f64::consts::{PI, TAU};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use thiserror::Error;

use super::{Palm, PalmPair};

/// Smallest opening φ₂ (and smallest π − φ₂) of a motion, radians: 1°. Palms closer to parallel do not hold an object.
pub const SMALLEST_OPENING_RAD: f64 = PI / 180.0;

/// Most samples a motion is sampled to.
const MOST_SAMPLES: f64 = 5e6;

/// Deepest nesting and most moves of a schedule, so that a huge `times` cannot fill the memory.
const MOST_LEGS: usize = 1_000_000;

/// One piece of a palm motion. Angles in radians, durations in seconds (not negative).
#[derive(Clone, Debug, PartialEq)]
pub enum PalmMove {
    /// Both palms turn by `angle_rad` (counter-clockwise); the opening φ₂ stays.
    Rotate {
        /// By how much.
        angle_rad: f64,
        /// How long it takes.
        duration_s: f64,
    },
    /// The opening φ₂ grows by `angle_rad` (shrinks when negative: a squeeze); the bisector of the palms stays.
    Open {
        /// By how much.
        angle_rad: f64,
        /// How long it takes.
        duration_s: f64,
    },
    /// One palm opens by `angle_rad` (closes when negative); the other stays put.
    OpenOne {
        /// The palm that moves.
        palm: Palm,
        /// By how much.
        angle_rad: f64,
        /// How long it takes.
        duration_s: f64,
    },
    /// Both palms turn and open at the same time: a squeeze-and-rotate.
    OpenAndRotate {
        /// By how much φ₂ grows.
        open_rad: f64,
        /// By how much the bisector turns.
        rotate_rad: f64,
        /// How long it takes.
        duration_s: f64,
    },
    /// Both palms stay put.
    Wait {
        /// How long.
        duration_s: f64,
    },
    /// The moves in order and then each undone in reverse order, all `times` times over.
    BackAndForth {
        /// How many times there and back.
        times: u32,
        /// The moves of the way there.
        moves: Vec<PalmMove>,
    },
}

/// How the palms turn over time. Velocity and acceleration are continuous.
#[derive(Clone, Debug, PartialEq)]
pub struct PalmMotion {
    base1_m: [f64; 2],
    base2_m: [f64; 2],
    course: Course,
}

#[derive(Clone, Debug, PartialEq)]
enum Course {
    /// (end time, φ₁, φ₁₂) of each leg; the first is the start. Each leg has a smooth start and end.
    Legs(Vec<Knot>),
    /// Knots of a smooth curve.
    Curve(Vec<Knot>),
    Waves(Waves),
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    time_s: f64,
    phi1: f64,
    phi12: f64,
}

/// Sums of sines, squashed into the range of the bisector and of the opening.
#[derive(Clone, Debug, PartialEq)]
struct Waves {
    duration_s: f64,
    bisector: Vec<Wave>,
    opening: Vec<Wave>,
    scale: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    amplitude: f64,
    cycles: f64,
    phase: f64,
}

/// Why a palm motion was refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MotionError {
    /// The palms would be parallel or crossed.
    #[error(
        "at {time_s:.3} s the palms would be parallel or crossed (opening {:.2} degrees): keep the opening between 1 and 179 degrees",
        phi2_rad.to_degrees()
    )]
    Parallel {
        /// When, seconds.
        time_s: f64,
        /// Opening φ₂ then, radians.
        phi2_rad: f64,
    },
    /// An angle, duration or rate is not finite, or negative where it may not be.
    #[error("{what} must be {range}")]
    OutOfRange {
        /// Which.
        what: &'static str,
        /// What it must be.
        range: &'static str,
    },
    /// Duration times rate is too large.
    #[error("the motion would have {samples:.0} samples, more than 5 million: lower the rate or the duration")]
    TooLong {
        /// How many samples.
        samples: f64,
    },
}

impl PalmMotion {
    /// A schedule of `moves` from the pair `start`, whose base points stay where they are.
    ///
    /// # Errors
    /// When the palms become parallel or cross on the way, or a number is out of range.
    pub fn schedule(start: PalmPair, moves: &[PalmMove]) -> Result<Self, MotionError> {
        let mut knots = vec![Knot { time_s: 0.0, phi1: start.phi1_rad, phi12: start.phi12_rad() }];
        append(&mut knots, moves, 0)?;
        for pair in knots.windows(2) {
            check_leg(pair[0], pair[1])?;
        }
        if let Some(only) = knots.first() {
            check_leg(*only, *only)?;
        }
        Ok(Self { base1_m: start.base1_m, base2_m: start.base2_m, course: Course::Legs(knots) })
    }

    /// The kind of motion of figure 6 of the paper: from nearly flat palms through squeezes with rotations and openings of
    /// one palm, `times` times there and back. It knows nothing of the object; most objects jump now and then.
    ///
    /// # Errors
    /// When `duration_s` is not positive and finite.
    pub fn squeeze_and_rotate(duration_s: f64, times: u32) -> Result<Self, MotionError> {
        positive("the duration", duration_s)?;
        let each = duration_s / (14.0 * f64::from(times.max(1)));
        let degrees = |angle: f64| angle.to_radians();
        let both = |open: f64, rotate: f64| PalmMove::OpenAndRotate {
            open_rad: degrees(open),
            rotate_rad: degrees(rotate),
            duration_s: each,
        };
        let one = |palm: Palm, open: f64| PalmMove::OpenOne { palm, angle_rad: degrees(open), duration_s: each };
        let moves = vec![
            both(-70.0, -15.0),
            both(-10.0, 30.0),
            one(Palm::One, 40.0),
            both(-35.0, -35.0),
            one(Palm::Two, 30.0),
            both(-30.0, 20.0),
            one(Palm::Two, 25.0),
        ];
        let start = PalmPair::hinged(degrees(15.0), degrees(150.0));
        Self::schedule(start, &[PalmMove::BackAndForth { times: times.max(1), moves }])
    }

    /// A random smooth motion of hinged palms: bisector within 90° ± 35° · `amplitude`, opening 40° to 150° (less where a
    /// palm would else turn below the horizontal), with up to six swings of each; `amplitude` 0 to 1.
    ///
    /// # Errors
    /// When `duration_s` is not positive and finite or `amplitude` is out of range.
    pub fn random(seed: u64, duration_s: f64, amplitude: f64) -> Result<Self, MotionError> {
        positive("the duration", duration_s)?;
        if !(0.0..=1.0).contains(&amplitude) {
            return Err(MotionError::OutOfRange { what: "the amplitude of a random motion", range: "0 to 1" });
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut waves = || -> Vec<Wave> {
            (1..=6)
                .map(|cycles| Wave {
                    amplitude: rng.sample(StandardNormal),
                    cycles: f64::from(cycles),
                    phase: rng.random_range(0.0..TAU),
                })
                .collect()
        };
        let (bisector, opening) = (waves(), waves());
        let waves = Waves { duration_s, bisector, opening, scale: amplitude };
        Ok(Self { base1_m: [0.0; 2], base2_m: [0.0; 2], course: Course::Waves(waves) })
    }

    /// A smooth curve through given palm angles: (time in seconds, φ₁, φ₂), times increasing. Velocity is continuous.
    ///
    /// # Errors
    /// With fewer than two points, times that do not increase, or palms that become parallel.
    pub fn through(points: &[(f64, f64, f64)]) -> Result<Self, MotionError> {
        let increasing = points.windows(2).all(|pair| pair[1].0 > pair[0].0);
        let finite = points.iter().all(|(time, phi1, phi2)| time.is_finite() && phi1.is_finite() && phi2.is_finite());
        if points.len() < 2 || !increasing || !finite {
            return Err(MotionError::OutOfRange {
                what: "the points of a motion",
                range: "finite, at least two, with times that increase",
            });
        }
        let start_s = points[0].0;
        let knots: Vec<Knot> = points
            .iter()
            .map(|&(time_s, phi1, phi2)| Knot { time_s: time_s - start_s, phi1, phi12: phi1 + phi2 })
            .collect();
        for knot in &knots {
            check_leg(*knot, *knot)?;
        }
        Ok(Self { base1_m: [0.0; 2], base2_m: [0.0; 2], course: Course::Curve(knots) })
    }

    /// The same motion with the base points of the palms at these places (metres, global frame).
    pub fn with_bases(mut self, base1_m: [f64; 2], base2_m: [f64; 2]) -> Self {
        (self.base1_m, self.base2_m) = (base1_m, base2_m);
        self
    }

    /// How long the motion takes, seconds.
    pub fn duration_s(&self) -> f64 {
        match &self.course {
            Course::Legs(knots) | Course::Curve(knots) => knots.last().map_or(0.0, |knot| knot.time_s),
            Course::Waves(waves) => waves.duration_s,
        }
    }

    /// The palms at `time_s` seconds; before the start and after the end they stay put.
    pub fn at(&self, time_s: f64) -> PalmPair {
        let time_s = time_s.clamp(0.0, self.duration_s());
        let (phi1, phi12) = match &self.course {
            Course::Legs(knots) => on_legs(knots, time_s),
            Course::Curve(knots) => on_curve(knots, time_s),
            Course::Waves(waves) => waves.at(time_s),
        };
        PalmPair { phi1_rad: phi1, phi2_rad: phi12 - phi1, base1_m: self.base1_m, base2_m: self.base2_m }
    }

    /// The palms at `rate_hz` samples per second, from the start to the end of the motion.
    ///
    /// # Errors
    /// When the rate is not positive, there would be too many samples, or the palms are parallel or crossed at one of them.
    pub fn sample(&self, rate_hz: f64) -> Result<Vec<(f64, PalmPair)>, MotionError> {
        positive("the rate", rate_hz)?;
        let samples = self.duration_s() * rate_hz;
        if samples > MOST_SAMPLES {
            return Err(MotionError::TooLong { samples });
        }
        // A hair more, so that a whole number of steps is not lost to rounding.
        let last = (samples + 1e-6).floor() as usize;
        (0..=last)
            .map(|index| {
                let time_s = index as f64 / rate_hz;
                let palms = self.at(time_s);
                check_opening(time_s, palms.phi2_rad)?;
                Ok((time_s, palms))
            })
            .collect()
    }
}

impl PalmMove {
    /// The move that undoes this one.
    fn undone(&self) -> Self {
        let mut undone = self.clone();
        match &mut undone {
            Self::Rotate { angle_rad, .. } | Self::Open { angle_rad, .. } | Self::OpenOne { angle_rad, .. } => {
                *angle_rad = -*angle_rad;
            }
            Self::OpenAndRotate { open_rad, rotate_rad, .. } => {
                (*open_rad, *rotate_rad) = (-*open_rad, -*rotate_rad);
            }
            // There and back is its own reverse.
            Self::Wait { .. } | Self::BackAndForth { .. } => {}
        }
        undone
    }

    /// Change of (φ₁, φ₁₂) and duration of a simple move.
    fn turn(&self) -> Option<(f64, f64, f64)> {
        match *self {
            Self::Rotate { angle_rad, duration_s } => Some((angle_rad, angle_rad, duration_s)),
            Self::Open { angle_rad, duration_s } => Some((-0.5 * angle_rad, 0.5 * angle_rad, duration_s)),
            Self::OpenOne { palm: Palm::One, angle_rad, duration_s } => Some((-angle_rad, 0.0, duration_s)),
            Self::OpenOne { palm: Palm::Two, angle_rad, duration_s } => Some((0.0, angle_rad, duration_s)),
            Self::OpenAndRotate { open_rad, rotate_rad, duration_s } => {
                Some((rotate_rad - 0.5 * open_rad, rotate_rad + 0.5 * open_rad, duration_s))
            }
            Self::Wait { duration_s } => Some((0.0, 0.0, duration_s)),
            Self::BackAndForth { .. } => None,
        }
    }
}

fn append(knots: &mut Vec<Knot>, moves: &[PalmMove], depth: usize) -> Result<(), MotionError> {
    for palm_move in moves {
        if knots.len() > MOST_LEGS || depth > 32 {
            return Err(MotionError::OutOfRange { what: "the number of moves", range: "at most a million, 32 deep" });
        }
        if let PalmMove::BackAndForth { times, moves } = palm_move {
            let back: Vec<PalmMove> = moves.iter().rev().map(PalmMove::undone).collect();
            for _ in 0..*times {
                let before = knots.len();
                append(knots, moves, depth + 1)?;
                append(knots, &back, depth + 1)?;
                if knots.len() == before {
                    break;
                }
            }
            continue;
        }
        let (Some((turn1, turn12, duration_s)), Some(&last)) = (palm_move.turn(), knots.last()) else { continue };
        if !(turn1.is_finite() && turn12.is_finite()) {
            return Err(MotionError::OutOfRange { what: "the angle of a move", range: "finite" });
        }
        if !(duration_s >= 0.0 && duration_s.is_finite()) {
            return Err(MotionError::OutOfRange { what: "the duration of a move", range: "finite and not negative" });
        }
        knots.push(Knot { time_s: last.time_s + duration_s, phi1: last.phi1 + turn1, phi12: last.phi12 + turn12 });
    }
    Ok(())
}

/// Whether the opening stays in its range on a leg; it changes monotonously there.
fn check_leg(from: Knot, to: Knot) -> Result<(), MotionError> {
    let (opening0, opening1) = (from.phi12 - from.phi1, to.phi12 - to.phi1);
    if check_opening(from.time_s, opening0).is_ok() && check_opening(to.time_s, opening1).is_ok() {
        return Ok(());
    }
    check_opening(from.time_s, opening0)?;
    // When the limit is reached, by bisection on the profile.
    let (mut good, mut bad) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (good + bad);
        let opening = opening0 + (opening1 - opening0) * smooth_step(middle);
        if check_opening(0.0, opening).is_ok() { good = middle } else { bad = middle }
    }
    let opening = opening0 + (opening1 - opening0) * smooth_step(bad);
    check_opening(from.time_s + (to.time_s - from.time_s) * bad, opening)?;
    check_opening(to.time_s, opening1)
}

fn check_opening(time_s: f64, phi2_rad: f64) -> Result<(), MotionError> {
    if phi2_rad > SMALLEST_OPENING_RAD && phi2_rad < PI - SMALLEST_OPENING_RAD {
        Ok(())
    } else {
        Err(MotionError::Parallel { time_s, phi2_rad })
    }
}

fn positive(what: &'static str, value: f64) -> Result<(), MotionError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(MotionError::OutOfRange { what, range: "positive and finite" })
    }
}

/// From 0 to 1 with velocity and acceleration 0 at both ends: 10 u³ − 15 u⁴ + 6 u⁵.
fn smooth_step(u: f64) -> f64 {
    u * u * u * (10.0 + u * (6.0 * u - 15.0))
}

/// The pair of knots around `time_s` and how far between them it is, 0 to 1.
fn between(knots: &[Knot], time_s: f64) -> Option<(usize, f64)> {
    let after = knots.partition_point(|knot| knot.time_s <= time_s).clamp(1, knots.len().checked_sub(1)?.max(1));
    let (from, to) = (knots.get(after - 1)?, knots.get(after)?);
    let span = to.time_s - from.time_s;
    Some((after - 1, if span > 0.0 { ((time_s - from.time_s) / span).clamp(0.0, 1.0) } else { 1.0 }))
}

fn on_legs(knots: &[Knot], time_s: f64) -> (f64, f64) {
    let Some((index, u)) = between(knots, time_s) else {
        return knots.first().map_or((0.0, 0.0), |only| (only.phi1, only.phi12));
    };
    let (from, to, part) = (knots[index], knots[index + 1], smooth_step(u));
    (from.phi1 + (to.phi1 - from.phi1) * part, from.phi12 + (to.phi12 - from.phi12) * part)
}

/// Cubic Hermite interpolation with slopes from the neighbours (0 at both ends).
fn on_curve(knots: &[Knot], time_s: f64) -> (f64, f64) {
    let Some((index, u)) = between(knots, time_s) else {
        return knots.first().map_or((0.0, 0.0), |only| (only.phi1, only.phi12));
    };
    let (from, to) = (knots[index], knots[index + 1]);
    let span = to.time_s - from.time_s;
    let slope = |at: usize, value: fn(&Knot) -> f64| {
        if at == 0 || at + 1 == knots.len() {
            return 0.0;
        }
        let (before, after) = (&knots[at - 1], &knots[at + 1]);
        (value(after) - value(before)) / (after.time_s - before.time_s)
    };
    let hermite = |value: fn(&Knot) -> f64| {
        let (u2, u3) = (u * u, u * u * u);
        (2.0 * u3 - 3.0 * u2 + 1.0) * value(&from)
            + (u3 - 2.0 * u2 + u) * span * slope(index, value)
            + (3.0 * u2 - 2.0 * u3) * value(&to)
            + (u3 - u2) * span * slope(index + 1, value)
    };
    (hermite(|knot| knot.phi1), hermite(|knot| knot.phi12))
}

impl Waves {
    fn at(&self, time_s: f64) -> (f64, f64) {
        let u = time_s / self.duration_s;
        let sum = |waves: &[Wave]| -> f64 {
            let sum: f64 = waves.iter().map(|wave| wave.amplitude * (TAU * wave.cycles * u + wave.phase).sin()).sum();
            (sum / 1.2).tanh()
        };
        let tilt = 35.0 * self.scale * sum(&self.bisector);
        // Wide open where the bisector is upright; both palms stay 5° above the horizontal.
        let widest = 150.0 - 62.0 * (tilt / 35.0) * (tilt / 35.0);
        let opening = 40.0 + (widest - 40.0) * 0.5 * (1.0 + self.scale * sum(&self.opening));
        let (bisector, half) = ((90.0 + tilt).to_radians(), 0.5 * opening.to_radians());
        (bisector - half, bisector + half)
    }
}
