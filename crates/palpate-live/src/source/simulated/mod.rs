//! A simulated rig in real time, from a small plan.

pub(crate) mod palms;
pub(crate) mod strokes;

use std::path::Path;
use std::time::{Duration, Instant};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::error::SourceError;
use crate::losses::Losses;
use crate::rigs::{RigKind, RigSample};
use crate::source::{Arrival, Overflow, Source};

/// Longest time without an answer, while the next sample is not due.
const PATIENCE: Duration = Duration::from_millis(100);

/// A rig that is not there.
pub(crate) struct Simulated<S: RigSample> {
    samples: std::vec::IntoIter<S>,
    /// The next sample, until it is due.
    next: Option<S>,
    /// So many times faster than the clock; 0 = as fast as possible.
    speed: f64,
    rig: S::Rig,
    /// When the first sample was given, and its time.
    begun: Option<(Instant, f64)>,
}

impl<S: RigSample> Simulated<S> {
    pub(crate) fn open(path: &Path) -> Result<Self, SourceError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| SourceError::io(path.display().to_string(), "the plan cannot be read", &error))?;
        let (samples, speed, rig) = S::simulated(path, &text)?;
        let mut samples = samples.into_iter();
        Ok(Self { next: samples.next(), samples, speed, rig, begun: None })
    }
}

/// Of which rig a plan is: `motion = "strokes"` of the pivoting grasp.
pub(crate) fn rig_kind(path: &Path) -> RigKind {
    #[derive(Deserialize)]
    struct Motion {
        motion: String,
    }
    let plan = std::fs::read_to_string(path).ok().and_then(|text| toml::from_str::<Motion>(&text).ok());
    if plan.is_some_and(|plan| plan.motion == strokes::MOTION) { RigKind::Pivot } else { RigKind::Palms }
}

/// The plan in a file.
fn parse<P: DeserializeOwned>(path: &Path, text: &str) -> Result<P, SourceError> {
    toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        SourceError::settings(path, format!("line {line}: {}", error.message()))
    })
}

fn require_speed(speed: f64) -> Result<(), String> {
    if speed >= 0.0 && speed.is_finite() {
        Ok(())
    } else {
        Err("speed must not be negative; 1 is real time, 0 as fast as possible".to_owned())
    }
}

impl<S: RigSample> Source<S> for Simulated<S> {
    fn next(&mut self) -> Result<Arrival<S>, SourceError> {
        let Some(sample) = self.next else { return Ok(Arrival::End) };
        let (begun, first_s) = *self.begun.get_or_insert((Instant::now(), sample.time_s()));
        if self.speed > 0.0 {
            let due = Duration::try_from_secs_f64((sample.time_s() - first_s) / self.speed).unwrap_or_default();
            let left = due.saturating_sub(begun.elapsed());
            std::thread::sleep(left.min(PATIENCE));
            if left > PATIENCE {
                return Ok(Arrival::Nothing);
            }
        }
        self.next = self.samples.next();
        Ok(Arrival::Sample(sample))
    }

    fn losses(&self) -> Losses {
        Losses::default()
    }

    fn rig(&self) -> Option<S::Rig> {
        Some(self.rig)
    }

    fn overflow(&self) -> Overflow {
        if self.speed > 0.0 { Overflow::DropsOldest } else { Overflow::Waits }
    }
}
