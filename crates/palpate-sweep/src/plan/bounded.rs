//! Numbers of a plan that are checked as they are read, so that the message can say where they stand.

use palpate::reconstruct::{FEWEST_SAMPLES, MOST_HARMONICS};
use serde::{Deserialize, Deserializer, de::Error};

/// Most samples that a log of a sweep may have: a plan is not the place to find out how much memory there is.
const MOST_SAMPLES: u32 = 1_000_000;
/// Largest seed: every reader of the table knows it exactly, also one that knows no numbers but floating ones.
const LARGEST_SEED: u64 = 1 << 53;
/// Most harmonics of a random object.
const MOST_ORDER: usize = 512;
/// Most corners of a polygon.
const MOST_CORNERS: u32 = 64;

/// A number above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Positive(pub(crate) f64);

/// A number not below 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NotNegative(pub(crate) f64);

/// A number from 0 up to, but not including, 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Share(pub(crate) f64);

/// A ratio of axes, 0.1 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AxisRatio(pub(crate) f64);

/// A number of harmonics that an object may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Order(pub(crate) usize);

/// A number of harmonics that the estimator takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Harmonics(pub(crate) usize);

/// A number of corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corners(pub(crate) u32);

/// A number of samples that can be solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Samples(pub(crate) u32);

/// A number of trials.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Trials(pub(crate) u64);

/// A first seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seed(pub(crate) u64);

/// Implements `Deserialize` for a number that is only taken when it passes.
macro_rules! taken_if {
    ($name:ident($inner:ty), $passes:expr, $otherwise:expr) => {
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let value = <$inner>::deserialize(deserializer)?;
                let passes: fn($inner) -> bool = $passes;
                if passes(value) { Ok(Self(value)) } else { Err(D::Error::custom($otherwise)) }
            }
        }
    };
}

taken_if!(Positive(f64), |value| value > 0.0 && value.is_finite(), "it must be above 0");
taken_if!(NotNegative(f64), |value| value >= 0.0 && value.is_finite(), "it must not be below 0");
taken_if!(Share(f64), |value| (0.0..1.0).contains(&value), "it must be at least 0 and below 1");
taken_if!(AxisRatio(f64), |value| (0.1..=1.0).contains(&value), "it must be from 0.1 to 1");
taken_if!(
    Order(usize),
    |value| (1..=MOST_ORDER).contains(&value),
    format!("a whole number from 1 to {MOST_ORDER} is needed")
);
taken_if!(
    Harmonics(usize),
    |value| (2..=MOST_HARMONICS).contains(&value),
    format!("a whole number from 2 to {MOST_HARMONICS} is needed")
);
taken_if!(
    Corners(u32),
    |value| (2..=MOST_CORNERS).contains(&value),
    format!("a whole number from 2 to {MOST_CORNERS} is needed")
);
taken_if!(
    Samples(u32),
    |value| (FEWEST_SAMPLES as u32..=MOST_SAMPLES).contains(&value),
    format!("a whole number from {FEWEST_SAMPLES} to {MOST_SAMPLES} is needed")
);
taken_if!(Trials(u64), |value| value > 0, "at least one is needed");
taken_if!(Seed(u64), |value| value <= LARGEST_SEED, format!("a whole number up to {LARGEST_SEED} is needed"));
