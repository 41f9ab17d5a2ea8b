//! Pads that err in many ways.

use palpate::palms::{Palm, PalmPair};
use palpate::sensor::{ContactReading, ContactSensor, PalmContact};
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use rand_distr::{StandardNormal, StudentT};

/// Samples over which correlated noise is averaged.
const CORRELATED_OVER: usize = 5;

/// Degrees of freedom of heavy tails.
const TAILS: f64 = 4.0;

/// Farthest outlier, over the mean radius.
const FARTHEST: f64 = 1.0;

/// Kinds of noise on the contact positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseShape {
    /// Independent and Gaussian.
    Gaussian,
    /// Rounded to steps; the standard deviation is that of the rounding.
    Rounded,
    /// Averaged over five samples.
    Correlated,
    /// Up to three times as large where the palm is level as where it is upright.
    GrowingWithTilt,
    /// Gaussian, and a slow drift by two standard deviations.
    Drifting,
    /// Student's t with four degrees of freedom.
    HeavyTailed,
}

impl NoiseShape {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Gaussian, Self::Rounded, Self::Correlated, Self::GrowingWithTilt, Self::Drifting, Self::HeavyTailed];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "Gaussian",
            Self::Rounded => "rounded",
            Self::Correlated => "correlated over 5 samples",
            Self::GrowingWithTilt => "growing with tilt",
            Self::Drifting => "drifting by 2 sd",
            Self::HeavyTailed => "heavy-tailed",
        }
    }
}

/// How the pads err.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorConditions {
    /// The kind of noise.
    pub noise: NoiseShape,
    /// Its standard deviation, metres.
    pub sd_m: f64,
    /// Share of readings that are anywhere.
    pub outliers: f64,
    /// Share of readings that are missing, in bursts.
    pub missing: f64,
}

impl SensorConditions {
    pub(super) fn draw(rng: &mut ChaCha8Rng) -> Self {
        // As often Gaussian or rounded as otherwise.
        let kind = rng.random_range(0..12);
        let noise = NoiseShape::ALL[match kind {
            0..=3 => 0,
            4 | 5 => 1,
            other => 2 + (other - 6) % 4,
        }];
        let sd_m = 2e-5 * 15.0_f64.powf(rng.random_range(0.0..1.0));
        let outliers = 1e-3 * 50.0_f64.powf(rng.random_range(0.0..1.0));
        let missing = rng.random_range(0.01..0.15);
        let (has_outliers, has_gaps) = (rng.random_bool(0.15), rng.random_bool(0.25));
        Self {
            noise,
            sd_m,
            outliers: if has_outliers { outliers } else { 0.0 },
            missing: if has_gaps { missing } else { 0.0 },
        }
    }

    pub(super) fn as_assumed(&self) -> bool {
        matches!(self.noise, NoiseShape::Gaussian | NoiseShape::Rounded) && self.outliers == 0.0
    }

    pub(super) fn words(&self) -> String {
        let name = self.noise.name();
        let mut words = format!("{name} {:.3} mm", 1e3 * self.sd_m);
        if self.outliers > 0.0 {
            words += &format!(", {:.1} % outliers", 100.0 * self.outliers);
        }
        if self.missing > 0.0 {
            words += &format!(", {:.0} % missing", 100.0 * self.missing);
        }
        words
    }

    /// A pair of pads at the beginning of a log of so many samples.
    pub(super) fn start(&self, samples: usize, mean_radius_m: f64) -> VariedSensor {
        let pad = || Pad { recent: Vec::new(), seen: 0, missing: 0 };
        VariedSensor { conditions: *self, samples, mean_radius_m, palms: [0.0; 2], pads: [pad(), pad()] }
    }
}

/// What a pad remembers.
struct Pad {
    /// The last draws, for correlated noise.
    recent: Vec<f64>,
    seen: usize,
    /// Readings that are still to go missing.
    missing: usize,
}

/// Pads in a simulation.
pub(super) struct VariedSensor {
    conditions: SensorConditions,
    samples: usize,
    mean_radius_m: f64,
    /// Tilt of both palms against the vertical at the sample before: 1 for a level palm.
    palms: [f64; 2],
    pads: [Pad; 2],
}

impl ContactSensor for VariedSensor {
    fn read_contact(&mut self, contact: &PalmContact, rng: &mut dyn Rng) -> Option<ContactReading> {
        let SensorConditions { noise, sd_m, outliers, missing } = self.conditions;
        let which = usize::from(contact.palm == Palm::Two);
        let pad = &mut self.pads[which];
        let normal: f64 = rng.sample(StandardNormal);
        pad.recent.push(normal);
        if pad.recent.len() > CORRELATED_OVER {
            pad.recent.remove(0);
        }
        let share = pad.seen as f64 / self.samples.max(1) as f64;
        pad.seen += 1;
        let deviation = match noise {
            NoiseShape::Gaussian | NoiseShape::Rounded => normal,
            NoiseShape::Correlated => pad.recent.iter().sum::<f64>() / (CORRELATED_OVER as f64).sqrt(),
            NoiseShape::GrowingWithTilt => normal * (1.0 + 2.0 * self.palms[which]) / 2.0,
            NoiseShape::Drifting => normal + 2.0 * (2.0 * share - 1.0),
            NoiseShape::HeavyTailed => {
                let spread = (TAILS / (TAILS - 2.0)).sqrt();
                StudentT::new(TAILS).map_or(normal, |tails| rng.sample(tails) / spread)
            }
        };
        let anywhere = rng.random_range(-FARTHEST..FARTHEST) * self.mean_radius_m;
        let (is_outlier, begins_gap) = (rng.random_bool(outliers), rng.random_bool(missing / LENGTH_OF_GAP));
        let length: usize = rng.random_range(1..=2 * LENGTH_OF_GAP as usize - 1);
        if begins_gap {
            pad.missing = pad.missing.max(length);
        }
        if pad.missing > 0 {
            pad.missing -= 1;
            return None;
        }
        let position_m = contact.position_m;
        let position_m = match noise {
            _ if is_outlier => (position_m + anywhere).max(0.0),
            NoiseShape::Rounded => {
                let step = sd_m * 12.0_f64.sqrt();
                (position_m / step).round() * step
            }
            _ => position_m + sd_m * deviation,
        };
        Some(ContactReading::at(position_m))
    }

    fn read_angles_rad(&mut self, _time_s: f64, palms: &PalmPair, _rng: &mut dyn Rng) -> (f64, f64) {
        self.palms = [palms.phi1_rad.cos().abs(), palms.phi12_rad().cos().abs()];
        (palms.phi1_rad, palms.phi2_rad)
    }
}

/// Mean number of readings in a burst of missing ones.
const LENGTH_OF_GAP: f64 = 15.0;
