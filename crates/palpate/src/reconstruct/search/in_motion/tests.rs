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
fn what_no_object_in_motion_does_may_be_a_little_of_a_log_and_not_half() {
    // The readings exchanged from some sample on.
    let exchanged_from = |share: f64| {
        let mut run = swinging();
        let from = (share * run.log.samples.len() as f64) as usize;
        run.log.samples[from..].iter_mut().for_each(|sample| std::mem::swap(&mut sample.s1_m, &mut sample.s2_m));
        (from, searched(&run))
    };
    let (from, found) = exchanged_from(0.85);
    let range = &found.expect("most of it is explained").ranges[0];
    assert!(range.start == 0 && range.end.abs_diff(from) < 8, "{range:?} {from}");
    assert!(exchanged_from(0.65).1.is_none());
}

#[test]
fn samples_too_far_apart_for_a_swing_tell_none() {
    let run = swinging();
    let told = |every: usize| {
        let thinned = Log { samples: run.log.samples.iter().step_by(every).copied().collect() };
        let measurements = Measurements::new(&thinned, None);
        let prior = Prior::new(0.03, 0.01);
        let calibration = Calibration::default();
        let readings = Readings { log: &thinned, calibration, measurements: &measurements, scatter_m: NOISE_M, prior };
        readings.tells_swings()
    };
    // The unit of time is 55 ms, and samples are 20 ms apart.
    assert!(told(1) && told(4) && !told(5));
    let none = Measurements::new(&Log { samples: Vec::new() }, None);
    let readings = Readings {
        log: &Log { samples: Vec::new() },
        calibration: Calibration::default(),
        measurements: &none,
        scatter_m: f64::NAN,
        prior: Prior::new(f64::NAN, f64::NAN),
    };
    assert!(search_in_motion(&readings).is_none());
}

#[test]
fn seeds_of_a_motion_are_explained_and_those_of_none_are_not() {
    let mut run = swinging();
    let seeds = |run: &Simulation| {
        let measurements = Measurements::new(&run.log, None);
        let size_m = measurements.size_m();
        let readings = Readings {
            log: &run.log,
            calibration: Calibration::default(),
            measurements: &measurements,
            scatter_m: NOISE_M,
            prior: Prior::new(size_m, 0.3 * size_m),
        };
        let path = ContactPath::new(&run.log, &measurements).expect("long enough");
        let windows = Window::liveliest(&readings, WINDOWS);
        assert!((WINDOWS / 2..=WINDOWS).contains(&windows.len()));
        (windows.iter().filter_map(|window| Seed::new(&readings, &path, window)).count(), windows.len())
    };
    let (explained, all) = seeds(&run);
    assert_eq!(explained, all);
    // The second contact as if the time ran backwards there.
    let backwards: Vec<_> = run.log.samples.iter().rev().map(|sample| sample.s2_m).collect();
    run.log.samples.iter_mut().zip(backwards).for_each(|(sample, s2_m)| sample.s2_m = s2_m);
    let (explained, all) = seeds(&run);
    assert!(explained <= all / 4, "{explained} of {all}");
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
