//! Sensors of one's own in simulations.

use palpate::palms::{Palm, PalmPair};
use palpate::sensor::{ContactReading, ContactSensor, PalmContact, Touchpad};
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::{SimulateError, SimulateOptions, simulate, simulate_with};
use rand::{Rng, RngExt};

fn egg() -> SupportFunction {
    NamedShape::Egg.shape(0.03).expect("a positive size")
}

fn motion() -> Vec<(f64, PalmPair)> {
    (0..50).map(|index| (0.1 * f64::from(index), PalmPair::hinged(0.5 + 0.01 * f64::from(index), 1.5))).collect()
}

#[test]
fn a_touchpad_is_read_alike_either_way() {
    let touchpad =
        Touchpad { length_m: 1.0, noise_sd_m: 1e-4, dropout: 0.2, angle_noise_sd_rad: 1e-3, ..Touchpad::interlink() };
    let options =
        SimulateOptions { touchpad, seed: 3, with_forces: true, with_stated_noise: true, ..Default::default() };
    let other = SimulateOptions { touchpad: Touchpad::ideal(), ..options.clone() };
    let mut pad = touchpad;
    let with = simulate_with(&egg(), &motion(), &mut pad, &other).expect("possible");
    assert_eq!(simulate(&egg(), &motion(), &options).expect("possible"), with);
    // A pad states its noise at readings that dropped out as well.
    assert!(with.log.samples.iter().any(|sample| sample.s1_m.is_none() && sample.s1_sd_m.is_some()));
}

/// A bias that grows with the position and with each reading, seen by palm 1 alone, with angles that are off.
struct Worn {
    readings: u32,
}

impl ContactSensor for Worn {
    fn read_contact(&mut self, contact: &PalmContact, rng: &mut dyn Rng) -> Option<ContactReading> {
        self.readings += 1;
        let noise_m = rng.random_range(-1e-6..1e-6);
        let position_m = contact.position_m * 1.01 + 1e-4 * f64::from(self.readings) + noise_m;
        let reading = ContactReading { position_sd_m: Some(1e-5 * contact.time_s), ..ContactReading::at(position_m) };
        (contact.palm == Palm::One).then_some(reading)
    }

    fn read_angles_rad(&mut self, time_s: f64, palms: &PalmPair, _rng: &mut dyn Rng) -> (f64, f64) {
        (palms.phi1_rad + 0.01 * time_s, palms.phi2_rad)
    }

    fn length_m(&self, palm: Palm) -> f64 {
        if palm == Palm::One { 1.0 } else { 0.2 }
    }
}

#[test]
fn a_sensor_of_ones_own_remembers_states_and_errs_as_it_will() {
    let exact = simulate(&egg(), &motion(), &SimulateOptions::default()).expect("possible");
    let options = SimulateOptions { with_stated_noise: true, with_forces: true, ..SimulateOptions::default() };
    let mut worn = Worn { readings: 0 };
    let felt = simulate_with(&egg(), &motion(), &mut worn, &options).expect("possible");
    assert_eq!((felt.truth.clone(), worn.readings), (exact.truth.clone(), 100));
    for (index, (felt, exact)) in felt.log.samples.iter().zip(&exact.log.samples).enumerate() {
        let (felt_m, exact_m) = (felt.s1_m.expect("seen"), exact.s1_m.expect("seen"));
        let bias_m = 0.01 * exact_m + 1e-4 * (2 * index + 1) as f64;
        assert!((felt_m - exact_m - bias_m).abs() < 1.1e-6);
        assert_eq!((felt.s2_m, felt.s2_sd_m, felt.force1_n), (None, None, None));
        // A standard deviation of 0 is none.
        assert_eq!(felt.s1_sd_m, (index > 0).then_some(1e-5 * felt.time_s));
        assert!((felt.palms.phi1_rad - exact.palms.phi1_rad - 0.01 * felt.time_s).abs() < 1e-12);
    }
    let again = simulate_with(&egg(), &motion(), &mut Worn { readings: 0 }, &options).expect("possible");
    assert_eq!(again, felt);
}

#[test]
fn an_object_runs_off_the_palm_that_ends() {
    struct Short;
    impl ContactSensor for Short {
        fn read_contact(&mut self, contact: &PalmContact, _rng: &mut dyn Rng) -> Option<ContactReading> {
            Some(ContactReading::at(contact.position_m))
        }
        fn length_m(&self, palm: Palm) -> f64 {
            if palm == Palm::Two { 0.01 } else { f64::INFINITY }
        }
    }
    let result = simulate_with(&egg(), &motion(), &mut Short, &SimulateOptions::default());
    assert!(matches!(result, Err(SimulateError::RunsOff { palm: Palm::Two, .. })), "{result:?}");
}
