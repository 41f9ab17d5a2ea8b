use super::*;
use crate::palms::PalmMotion;
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;
use crate::simulate::{ObjectInertia, SimulateOptions, Simulation, simulate};

const NOISE_M: f64 = 1e-4;

fn shape() -> SupportFunction {
    SupportFunction::new(0.03, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
}

/// Between palms so fast that it swings.
fn swinging() -> Simulation {
    let motion = PalmMotion::random(3, 8.0, 0.5).and_then(|motion| motion.sample(50.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: NOISE_M, ..Touchpad::ideal() };
    let inertia = Some(ObjectInertia { gyration_radius_m: None, damping_per_s: 0.5 });
    let options = SimulateOptions { touchpad, inertia, ..SimulateOptions::default() };
    simulate(&shape(), &motion, &options).expect("possible")
}

fn searched(run: &Simulation) -> Option<Found> {
    let measurements = Measurements::new(&run.log, None);
    let size_m = measurements.size_m();
    search_in_motion(&Readings {
        log: &run.log,
        calibration: Calibration::default(),
        measurements: &measurements,
        scatter_m: NOISE_M,
        prior: Prior::new(size_m, 0.3 * size_m),
    })
}

#[test]
fn the_whole_motion_of_a_swinging_object_is_found_from_nothing() {
    let run = swinging();
    let found = searched(&run).expect("inertia explains it");
    assert_eq!(found.ranges, vec![0..run.log.samples.len()]);
    let off: Vec<f64> =
        found.estimates[0].psi.iter().zip(&run.truth.motion).map(|(psi, truth)| psi - truth.psi_rad).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let largest = off.iter().map(|off| (off - mean).abs()).fold(0.0, f64::max);
    assert!(largest < 0.05, "{largest}");
    let psi = || run.truth.motion.iter().map(|truth| truth.psi_rad);
    let turned = psi().fold(f64::MIN, f64::max) - psi().fold(f64::MAX, f64::min);
    assert!(turned > 1.0, "the object must turn: {turned}");
    // And the size, of which not all was felt.
    let mean_m = found.estimates[0].coefficients[0];
    assert!((mean_m - 0.03).abs() < 5e-4, "{mean_m}");
}

#[test]
fn it_is_found_through_gaps_and_where_one_pad_saw_nothing() {
    let mut run = swinging();
    for (index, sample) in run.log.samples.iter_mut().enumerate() {
        match index % 60 {
            30..34 => sample.s1_m = None,
            45..48 => (sample.s1_m, sample.s2_m) = (None, None),
            _ => {}
        }
    }
    assert!(searched(&run).is_some());
}

#[test]
fn contacts_that_no_object_in_motion_has_lead_to_none() {
    // Both palms as if exchanged in the middle: a half is right.
    let mut run = swinging();
    let middle = run.log.samples.len() / 2;
    run.log.samples[middle..].iter_mut().for_each(|sample| std::mem::swap(&mut sample.s1_m, &mut sample.s2_m));
    assert!(searched(&run).is_none());
}

#[test]
fn too_few_samples_and_times_that_stand_still_lead_to_none() {
    let mut short = swinging();
    short.log.samples.truncate(5);
    short.truth.motion.truncate(5);
    assert!(searched(&short).is_none());
    let mut still = swinging();
    still.log.samples[7].time_s = still.log.samples[6].time_s;
    assert!(searched(&still).is_none());
}
