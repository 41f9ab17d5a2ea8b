//! A touchpad on each palm: resolution, noise, pressure levels, rate, length, drop-outs, and the centroid that it reports
//! when it feels several contacts (section 5 of Moll & Erdmann 2001).

use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::contact_sensor::{ContactReading, ContactSensor, PalmContact};
use crate::palms::{Palm, PalmPair};

/// Metres per inch.
const INCH_M: f64 = 0.0254;

/// The properties of the touchpads, the same on both palms. Build from a preset with struct update:
///
/// ```
/// use palpate::sensor::Touchpad;
/// let pad = Touchpad { length_m: 0.15, noise_sd_m: 0.1e-3, ..Touchpad::interlink() };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Touchpad {
    /// Length along the palm, from its base, metres; an object beyond it has run off the palm. May be infinite.
    #[cfg_attr(feature = "serde", serde(with = "endless_or_null"))]
    pub length_m: f64,
    /// Width across the palm, metres. Of no effect on a planar object; kept for the record.
    #[cfg_attr(feature = "serde", serde(with = "endless_or_null"))]
    pub width_m: f64,
    /// Position steps per inch; `None` for no rounding.
    pub counts_per_inch: Option<f64>,
    /// Standard deviation of Gaussian noise on the position before rounding, metres.
    pub noise_sd_m: f64,
    /// Number of pressure levels from 0 to `full_scale_n`; `None` for no rounding.
    pub pressure_levels: Option<u32>,
    /// Force that gives the highest pressure level, newtons. Forces below half a level go unseen as forces, not as contacts.
    pub full_scale_n: f64,
    /// Samples per second.
    pub rate_hz: f64,
    /// Probability that a reading of one pad is missing, 0 to 1.
    pub dropout: f64,
    /// Standard deviation of Gaussian noise on each palm angle (φ₁ and φ₁₂) as the robot reports them, radians.
    pub angle_noise_sd_rad: f64,
}

/// Text formats such as JSON have no infinity: there null is endless.
#[cfg(feature = "serde")]
mod endless_or_null {
    use crate::number_or_null;
    use serde::{Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        number_or_null::serialize(value, serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        number_or_null::deserialize(deserializer).map(|value| if value.is_nan() { f64::INFINITY } else { value })
    }
}

/// One contact on a pad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadContact {
    /// Distance from the base of the palm, metres.
    pub position_m: f64,
    /// Normal force, newtons.
    pub force_n: f64,
}

/// What a pad reports of all its contacts together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadReading {
    /// Force-weighted centroid of the contacts, metres from the base.
    pub position_m: f64,
    /// Sum of the forces, newtons, rounded to the pressure levels.
    pub force_n: f64,
}

impl Default for Touchpad {
    fn default() -> Self {
        Self::ideal()
    }
}

impl Touchpad {
    /// A pad without any fault: no rounding, no noise, endless; 100 samples per second.
    pub fn ideal() -> Self {
        Self {
            length_m: f64::INFINITY,
            width_m: f64::INFINITY,
            counts_per_inch: None,
            noise_sd_m: 0.0,
            pressure_levels: None,
            full_scale_n: 10.0,
            rate_hz: 100.0,
            dropout: 0.0,
            angle_noise_sd_rad: 0.0,
        }
    }

    /// The pad of the paper's experiment, by Interlink Electronics: 55.5 × 39.5 mm, 200 counts per inch, 128 pressure
    /// levels, about 100 Hz. It is short: the object should have a mean radius below about 12 mm, or `length_m` be raised.
    pub fn interlink() -> Self {
        Self {
            length_m: 55.5e-3,
            width_m: 39.5e-3,
            counts_per_inch: Some(200.0),
            pressure_levels: Some(128),
            ..Self::ideal()
        }
    }

    /// Position step in metres; 0 for no rounding.
    pub fn resolution_m(&self) -> f64 {
        self.counts_per_inch.map_or(0.0, |counts| INCH_M / counts)
    }

    /// Standard deviation of one position reading, metres: noise, and rounding as evenly spread over one step.
    pub fn position_sd_m(&self) -> f64 {
        let step = self.resolution_m();
        (self.noise_sd_m * self.noise_sd_m + step * step / 12.0).sqrt()
    }

    /// The name of the first property that is out of range, for error messages.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let not_negative = |value: f64| value >= 0.0 && value.is_finite();
        let checks = [
            ("palm length (m), must be positive", self.length_m > 0.0),
            ("counts per inch, must be positive", self.counts_per_inch.is_none_or(|c| c > 0.0 && c.is_finite())),
            ("position noise (m), must not be negative", not_negative(self.noise_sd_m)),
            ("number of pressure levels, must be at least 2", self.pressure_levels.is_none_or(|levels| levels >= 2)),
            ("full-scale force (N), must be positive", self.full_scale_n > 0.0 && self.full_scale_n.is_finite()),
            ("rate (Hz), must be positive", self.rate_hz > 0.0 && self.rate_hz.is_finite()),
            ("drop-out probability, must be 0 to 1", (0.0..=1.0).contains(&self.dropout)),
            ("palm angle noise (rad), must not be negative", not_negative(self.angle_noise_sd_rad)),
        ];
        checks.into_iter().find_map(|(name, good)| (!good).then_some(name))
    }

    /// What the pad reports of its contacts: `None` without a contact or on a drop-out.
    ///
    /// Several contacts give their force-weighted centroid. Forces that are all zero count alike.
    pub fn read(&self, contacts: &[PadContact], rng: &mut (impl Rng + ?Sized)) -> Option<PadReading> {
        // The same draws whatever happens, so that one sample more or less does not change the rest of a log.
        let noise: f64 = rng.sample(StandardNormal);
        let missing = rng.random::<f64>() < self.dropout;
        if contacts.is_empty() || missing {
            return None;
        }
        let force_n: f64 = contacts.iter().map(|contact| contact.force_n.max(0.0)).sum();
        let position = if force_n > 0.0 {
            contacts.iter().map(|contact| contact.position_m * contact.force_n.max(0.0) / force_n).sum::<f64>()
        } else {
            contacts.iter().map(|contact| contact.position_m).sum::<f64>() / contacts.len() as f64
        };
        let noisy = position + self.noise_sd_m * noise;
        // An endless pad has no edge to stop at.
        let position_m = rounded(noisy, self.resolution_m()).clamp(0.0, self.length_m.max(0.0));
        let force_n = match self.pressure_levels {
            Some(levels) if levels >= 2 => {
                rounded(force_n.min(self.full_scale_n), self.full_scale_n / f64::from(levels - 1))
            }
            _ => force_n,
        };
        Some(PadReading { position_m, force_n })
    }
}

impl ContactSensor for Touchpad {
    fn read_contact(&mut self, contact: &PalmContact, rng: &mut dyn Rng) -> Option<ContactReading> {
        let contact = PadContact { position_m: contact.position_m, force_n: contact.force_n };
        let PadReading { position_m, force_n } = self.read(&[contact], rng)?;
        Some(ContactReading { position_m, position_sd_m: None, force_n: Some(force_n) })
    }

    fn read_angles_rad(&mut self, _time_s: f64, palms: &PalmPair, rng: &mut dyn Rng) -> (f64, f64) {
        let noise1: f64 = rng.sample(StandardNormal);
        let noise12: f64 = rng.sample(StandardNormal);
        let sd = self.angle_noise_sd_rad;
        (palms.phi1_rad + sd * noise1, palms.phi2_rad + sd * (noise12 - noise1))
    }

    fn position_sd_m(&self) -> Option<f64> {
        Some(Self::position_sd_m(self))
    }

    fn length_m(&self, _palm: Palm) -> f64 {
        self.length_m
    }
}

fn rounded(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}
