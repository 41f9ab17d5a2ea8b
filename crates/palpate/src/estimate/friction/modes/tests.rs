use super::*;
use crate::log::{Log, Sample};
use crate::mechanics::ContactMode;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use crate::simulate::{SimulateOptions, simulate};

const FRICTION: [f64; 2] = [0.3, 0.3];
const SDS: Sds = Sds { sensor_m: 1e-6, slip_m: 3e-7, forces_m: 1e-5 };

fn shape() -> SupportFunction {
    SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
}

/// What is decoded of a log, about some motion.
fn decoded(log: &Log, psi: &[f64], friction: [f64; 2]) -> Decoded {
    let coefficients = shape().coefficients();
    let object = Object { coefficients: &coefficients, friction, covariance: None };
    decode(&Measurements::new(log, None), &vec![[0.0; 2]; psi.len()], object, SDS, psi, &[])
}

#[test]
fn between_palms_that_stand_still_against_each_other_the_object_sticks_on_both() {
    // Palm 2 opens, rests against palm 1 while both turn, and opens again.
    let opening = |t: f64| if t < 4.0 { 0.1 * t } else { (0.1 * (t - 4.0)).max(0.4) };
    let at = |index: u32| {
        let t = 0.05 * f64::from(index);
        (t, PalmPair::hinged(0.9 + 0.05 * t, 1.1 + opening(t)))
    };
    let motion: Vec<(f64, PalmPair)> = (0..200).map(at).collect();
    let options = SimulateOptions { friction: FRICTION, start_psi_rad: 0.4, ..SimulateOptions::default() };
    let run = simulate(&shape(), &motion, &options).expect("possible");
    let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let found = decoded(&run.log, &psi, FRICTION);
    let measurements = Measurements::new(&run.log, None);
    for index in 1..200 {
        let (from, to) = (motion[index - 1].1.phi2_rad, motion[index].1.phi2_rad);
        let rests = to - from == 0.0;
        let regime = &found.regimes[index];
        assert_eq!(regime.sticks_on_both, rests, "{index}: {regime:?}");
        if rests {
            let at = BoundaryTable::new(&shape().coefficients()).contacts(&measurements.instants[index], psi[index]);
            let modes = regime.modes(&measurements.instants[index], &at);
            assert_eq!(modes, Some([ContactMode::Stick; 2]), "{index}");
        }
    }
}

/// Two samples between which palm 2 opens, and the step of an object that rolls from one to the other.
fn stepped(slip_m: f64) -> (Measurements, Step) {
    let (coefficients, shape) = (shape().coefficients(), shape());
    let sample = |phi2: f64| {
        let palms = PalmPair::hinged(0.9, phi2);
        let (s1, s2) = palms.contact_positions_m(&shape, 0.4);
        Sample::new(0.0, palms, s1, s2)
    };
    let measurements = Measurements::new(&Log { samples: vec![sample(1.1), sample(1.1001)] }, None);
    let decoder = Decoder {
        measurements: &measurements,
        base_shifts_m: &[[0.0; 2]; 2],
        object: Object { coefficients: &coefficients, friction: FRICTION, covariance: None },
        table: BoundaryTable::new(&coefficients),
        sds: Sds { slip_m, ..SDS },
    };
    let step = decoder.step(1, Belief { psi: 0.4, variance: 1e-14 }, 0.4).expect("possible");
    (measurements, step)
}

#[test]
fn slip_between_the_rates_of_rolling_is_told_from_three_standard_deviations_on() {
    // What slides on the other palm meanwhile: u = s₁ s₂ sin φ₂ φ₂'/|s₂ − s₁ cos φ₂| and its mirror image.
    let Instant { s1, s2, palms, .. } = stepped(1e-9).0.instants[0];
    let product = 1e-4 * s1 * s2 * palms.sin2;
    let slip_m = (product / (s2 - s1 * palms.cos2)).abs().max((product / (s1 - s2 * palms.cos2)).abs());
    assert!(stepped(slip_m / (0.98 * ON_BOTH_SDS)).1.sticks_on_both);
    assert!(!stepped(slip_m / (1.02 * ON_BOTH_SDS)).1.sticks_on_both);
}

#[test]
fn a_contact_that_sticks_creeps_by_a_share_of_what_slides_meanwhile() {
    let (_, Step { rolled: [first, second], .. }) = stepped(1e-9);
    // As a share of the way from one rate to the other, the other contact slides as much less.
    let way = second.psi - first.psi;
    for (belief, towards) in [(first, 1.0), (second, -1.0)] {
        let sds = |share: f64| (towards * share * way).abs() / belief.variance.sqrt();
        assert!(sds(0.8 * CREEP) < 1.0 && sds(1.2 * CREEP) > 1.0, "{} {}", sds(0.8 * CREEP), sds(1.2 * CREEP));
    }
}
