//! Palm motions of many kinds: smooth, with pauses, with one palm still, in stairs, to and fro; slow and fast readings.

use palpate::palms::{MotionError, PalmMotion, PalmPair};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Kinds of palm motions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionShape {
    /// Random and smooth.
    Smooth,
    /// The same with pauses.
    Pauses,
    /// Each palm moves while the other is still.
    OnePalm,
    /// In steps, as of a motor that is told a new place now and then.
    Stairs,
    /// A short motion to and fro.
    ToAndFro,
}

impl MotionShape {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Smooth, Self::Pauses, Self::OnePalm, Self::Stairs, Self::ToAndFro];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Smooth => "smooth motion",
            Self::Pauses => "pauses",
            Self::OnePalm => "one palm at a time",
            Self::Stairs => "stairs",
            Self::ToAndFro => "to and fro",
        }
    }
}

/// Samples of a log: fewer do not hold a motion of six swings, more take too long for a study of thousands.
const SAMPLES: std::ops::Range<f64> = 60.0..4000.0;

/// How the palms move, and how often they are read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionConditions {
    /// The kind.
    pub shape: MotionShape,
    /// Share of the largest swings, 0 to 1.
    pub amplitude: f64,
    /// Seconds from the first sample to the last: 20 s to 10 min.
    pub duration_s: f64,
    /// Samples per second: 3 Hz to 1 kHz.
    pub rate_hz: f64,
}

impl MotionConditions {
    pub(super) fn draw(rng: &mut ChaCha8Rng) -> Self {
        let shape = MotionShape::ALL[rng.random_range(0..MotionShape::ALL.len() + 1) % MotionShape::ALL.len()];
        let amplitude = rng.random_range(0.4..1.0);
        let duration_s = 20.0 * 30.0_f64.powf(rng.random_range(0.0..1.0));
        // Evenly spread in the logarithm, within both ranges.
        let (least, most) = ((SAMPLES.start / duration_s).max(3.0), (SAMPLES.end / duration_s).min(1000.0));
        let rate_hz = least * (most / least).powf(rng.random_range(0.0..1.0));
        Self { shape, amplitude, duration_s, rate_hz }
    }

    pub(super) fn words(&self) -> String {
        let name = self.shape.name();
        format!("{name} {:.0} s {:.3} Hz", self.duration_s, self.rate_hz)
    }

    /// Times and palms at the samples.
    pub(super) fn course(&self, rng: &mut ChaCha8Rng) -> Result<Vec<(f64, PalmPair)>, MotionError> {
        let motion = PalmMotion::random(rng.random(), self.duration_s, self.amplitude)?;
        let times: Vec<f64> =
            (0..).map(|index| f64::from(index) / self.rate_hz).take_while(|time| *time <= self.duration_s).collect();
        let palms = |time_s: f64| motion.at(time_s);
        Ok(match self.shape {
            MotionShape::Smooth => times.iter().map(|&time| (time, palms(time))).collect(),
            MotionShape::Pauses => {
                let pauses = Pauses::draw(rng, self.duration_s);
                times.iter().map(|&time| (time, palms(pauses.moved_s(time)))).collect()
            }
            MotionShape::OnePalm => {
                // Both courses run at half speed in turn, each for a part of the time.
                let turn_s = self.duration_s / f64::from(rng.random_range(8..=24));
                let one = |time: f64| moved_in_turns(time, turn_s, 0);
                let two = |time: f64| moved_in_turns(time, turn_s, 1);
                let pair = |time: f64| {
                    let (phi1_rad, other) = (palms(one(time)).phi1_rad, palms(two(time)));
                    PalmPair::hinged(phi1_rad, other.phi12_rad() - phi1_rad)
                };
                times.iter().map(|&time| (time, pair(time))).collect()
            }
            MotionShape::Stairs => {
                let step_s = self.duration_s / f64::from(rng.random_range(80..=300));
                times.iter().map(|&time| (time, palms((time / step_s).floor() * step_s))).collect()
            }
            MotionShape::ToAndFro => {
                let leg_s = self.duration_s / f64::from(rng.random_range(2..=6));
                let there = |time: f64| {
                    let phase = (time / leg_s).rem_euclid(2.0);
                    if phase < 1.0 { phase } else { 2.0 - phase }
                };
                times.iter().map(|&time| (time, palms(self.duration_s * there(time)))).collect()
            }
        })
    }
}

/// Time that has been moved in, of turns of `turn_s` each, by the one of two whose turn it is.
fn moved_in_turns(time_s: f64, turn_s: f64, which: u32) -> f64 {
    let pairs = (time_s / (2.0 * turn_s)).floor();
    let into = time_s - 2.0 * turn_s * pairs - f64::from(which) * turn_s;
    2.0 * (pairs * turn_s + into.clamp(0.0, turn_s))
}

/// Stretches of time in which nothing moves.
struct Pauses {
    /// Beginning and end of each, seconds, in order.
    still: Vec<(f64, f64)>,
    moving_s: f64,
    duration_s: f64,
}

impl Pauses {
    fn draw(rng: &mut ChaCha8Rng, duration_s: f64) -> Self {
        let count = rng.random_range(2..=8);
        let slot_s = duration_s / f64::from(count);
        let still: Vec<(f64, f64)> = (0..count)
            .map(|slot| {
                let start = slot_s * (f64::from(slot) + rng.random_range(0.0..0.5));
                (start, start + slot_s * rng.random_range(0.05..0.5))
            })
            .collect();
        let moving_s = duration_s - still.iter().map(|(start, end)| end - start).sum::<f64>();
        Self { still, moving_s, duration_s }
    }

    /// Place on a course of the whole duration.
    fn moved_s(&self, time_s: f64) -> f64 {
        let rested: f64 = self.still.iter().map(|(start, end)| (time_s.min(*end) - start).max(0.0)).sum();
        (time_s - rested) * self.duration_s / self.moving_s
    }
}
