//! Sensors in a simulation: a [`Touchpad`](super::Touchpad), or one of one's own.

use rand::Rng;

use crate::palms::{Palm, PalmPair};

/// What a palm touches at one sample, as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PalmContact {
    /// Time of the sample, seconds.
    pub time_s: f64,
    /// Which palm.
    pub palm: Palm,
    /// Distance of the contact from the base of the palm, metres.
    pub position_m: f64,
    /// Normal force, newtons.
    pub force_n: f64,
}

/// What a sensor reports of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactReading {
    /// Distance of the contact from the base of the palm, metres.
    pub position_m: f64,
    /// Standard deviation of this position, metres, positive; `None` for that of the [sensor](ContactSensor::position_sd_m), if it has one.
    pub position_sd_m: Option<f64>,
    /// Normal force, newtons; `None` where it feels no forces.
    pub force_n: Option<f64>,
}

impl ContactReading {
    /// A position (metres from the base) and nothing else.
    pub fn at(position_m: f64) -> Self {
        Self { position_m, position_sd_m: None, force_n: None }
    }
}

/// A contact sensor on each palm, as [`simulate_with`](crate::simulate::simulate_with) asks it: at each sample first for the contact on
/// palm 1, then for that on palm 2, then for the palm angles. What is between two samples it may remember (drift, hysteresis).
///
/// Where only the contacts matter, a closure will do:
///
/// ```
/// use palpate::sensor::{ContactReading, PalmContact};
/// use palpate::simulate::{SimulateOptions, simulate_with};
/// use rand::{Rng, RngExt};
/// # use palpate::{palms::PalmPair, shape::NamedShape};
/// # let egg = NamedShape::Egg.shape(0.03)?;
/// # let motion: Vec<_> = (0..20).map(|i| (f64::from(i), PalmPair::hinged(0.5 + 0.01 * f64::from(i), 1.5))).collect();
/// // 0.2 mm of evenly spread noise, and a scale that is 1 % off.
/// let mut sensor = |contact: &PalmContact, rng: &mut dyn Rng| {
///     Some(ContactReading::at(1.01 * contact.position_m + rng.random_range(-1e-4..1e-4)))
/// };
/// let felt = simulate_with(&egg, &motion, &mut sensor, &SimulateOptions::default())?;
/// # assert_eq!(felt.log.samples.len(), 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait ContactSensor {
    /// What is reported of a contact; `None` when it goes unseen. All chance comes from `rng`, so that a seed tells the whole log; a sensor
    /// that draws equally often whatever it sees keeps the rest of the log as it is when one sample changes.
    fn read_contact(&mut self, contact: &PalmContact, rng: &mut dyn Rng) -> Option<ContactReading>;

    /// The palm angles (φ₁ of palm 1 against the horizontal, φ₂ from palm 1 to palm 2), radians, as the robot reports them; exact if not
    /// said otherwise.
    fn read_angles_rad(&mut self, _time_s: f64, palms: &PalmPair, _rng: &mut dyn Rng) -> (f64, f64) {
        (palms.phi1_rad, palms.phi2_rad)
    }

    /// Standard deviation of the positions that it reports, metres, where it is the same for all; `None` if not said otherwise. A log states
    /// it with [`with_stated_noise`](crate::simulate::SimulateOptions::with_stated_noise).
    fn position_sd_m(&self) -> Option<f64> {
        None
    }

    /// Length of a palm from its base, metres; an object beyond it has run off. Endless if not said otherwise.
    fn length_m(&self, _palm: Palm) -> f64 {
        f64::INFINITY
    }
}

impl<F> ContactSensor for F
where
    F: FnMut(&PalmContact, &mut dyn Rng) -> Option<ContactReading>,
{
    fn read_contact(&mut self, contact: &PalmContact, rng: &mut dyn Rng) -> Option<ContactReading> {
        self(contact, rng)
    }
}
