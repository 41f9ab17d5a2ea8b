//! The online estimator: the same bytes on every replay, the batch estimator's answer at the end, a wrong beginning corrected, and garbage.

use palpate::live::{Estimate, Live, Stage};
use palpate::palms::{PalmMotion, PalmPair};
use palpate::reconstruct::{ReconstructError, Reconstructor};
use palpate::sensor::{Rig, Touchpad};
use palpate::shape::{NamedShape, RandomShape, random_shape};
use palpate::simulate::{SimulateOptions, Simulation, simulate};
use palpate::{Log, Sample};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A random object, felt with 0.1 mm of noise while the palms make a random motion.
fn felt(seed: u64, duration_s: f64, rate_hz: f64) -> Simulation {
    let shape = random_shape(&RandomShape::default(), seed).expect("possible");
    let motion = PalmMotion::random(seed, duration_s, 1.0).and_then(|motion| motion.sample(rate_hz)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 1e-4, ..Touchpad::ideal() };
    simulate(&shape, &motion, &SimulateOptions { touchpad, seed, ..SimulateOptions::default() }).expect("possible")
}

fn without_refused(estimate: &Estimate) -> String {
    let mut estimate = estimate.clone();
    estimate.refused = 0;
    format!("{estimate:?}")
}

fn run(samples: &[Sample]) -> (Vec<Estimate>, Live) {
    let mut live = Live::default();
    let estimates = samples.iter().map(|sample| live.push(sample).clone()).collect();
    (estimates, live)
}

#[test]
fn a_replay_gives_the_same_bytes_and_the_end_is_that_of_the_batch_estimator() {
    let samples = felt(1, 12.0, 50.0).log.samples;
    let (estimates, live) = run(&samples);
    let told = |estimates: &[Estimate]| format!("{estimates:?}");
    assert!(told(&estimates) == told(&run(&samples).0), "two runs differ");
    let stages: Vec<Stage> = estimates.iter().map(|estimate| estimate.stage).collect();
    assert!(stages.is_sorted() && stages[0] == Stage::Gathering && stages[599] == Stage::Following);
    assert!(estimates[78].verdict.is_none() && !estimates[78].is_certified());
    assert_eq!(estimates[78].reason(), "too few samples for a first search");
    let last = estimates.last().expect("an estimate");
    assert_eq!((last.samples, last.refused, last.time_s), (601, 0, samples[600].time_s));
    assert!(last.is_certified(), "{}", last.reason());

    assert_eq!(live.kept_every(), 1);
    let found = live.finish().expect("solvable");
    let batch = palpate::reconstruct(&Log { samples }).expect("solvable");
    assert!(format!("{found:?}") == format!("{batch:?}"), "the end is not that of `reconstruct`");
    let distance = last.distance_sds(&batch).expect("a shape");
    assert!(distance < 0.5, "{distance} standard deviations");
    let (pose, end) = (last.pose.expect("a pose"), batch.motion[600]);
    assert!((pose.com_x_m - end.com_x_m).hypot(pose.com_y_m - end.com_y_m) < 5.0 * end.com_sd_m);
    assert!(pose.psi_sd_rad > 0.2 * end.psi_sd_rad && pose.psi_sd_rad < 5.0 * end.psi_sd_rad);
    assert!(last.r_sd_m() > 0.0 && (last.coverage - batch.coverage).abs() < 0.05);
}

/// The pose at the end is that of the truth. In the frames of truth and estimate ψ differs by a constant; the centre of mass does not.
fn assert_right_at_the_end(last: &Estimate, run_of: &Simulation) {
    assert!(last.is_certified(), "{}", last.reason());
    let truth = run_of.truth.motion.last().expect("a pose");
    let pose = last.pose.expect("a pose");
    let off_m = (pose.com_x_m - truth.com_x_m).hypot(pose.com_y_m - truth.com_y_m);
    assert!(off_m < 5e-4, "{off_m} m");
    assert!(pose.piece > 0, "this motion has jumps");
}

#[test]
fn jumps_are_followed_without_another_search() {
    let run_of = felt(1, 12.0, 100.0);
    assert!(run_of.jumps.len() > 2);
    let (estimates, _) = run(&run_of.log.samples);
    assert!(!estimates.iter().any(|estimate| estimate.contradicted));
    assert_right_at_the_end(estimates.last().expect("an estimate"), &run_of);
}

#[test]
fn a_pose_on_boundary_that_is_not_known_is_not_certified_before_a_search_has_found_it() {
    let seed = 16;
    let run_of = felt(seed, 12.0, 100.0);
    let shape = random_shape(&RandomShape::default(), seed).expect("possible");
    let (estimates, _) = run(&run_of.log.samples);
    let psi = |index: usize| run_of.truth.motion[index].psi_rad;
    let wrong = |index: usize, estimate: &Estimate| {
        let off = estimate.psi_error_rad(&shape, [psi(0), psi(index)]).expect("a pose");
        off > f64::max(0.035, 5.0 * estimate.pose.expect("a pose").psi_sd_rad)
    };
    let is_wrong = |(index, estimate): &(usize, &Estimate)| estimate.pose.is_some() && wrong(*index, estimate);
    let doubted = estimates.iter().enumerate().filter(is_wrong).filter(|(_, estimate)| estimate.ambiguous).count();
    assert!(doubted > 10, "where it lands, the shape is hardly known: {doubted}");
    let ambiguous = estimates.iter().find(|estimate| estimate.ambiguous && !estimate.is_certified());
    assert!(ambiguous.is_some_and(|estimate| estimate.reason().contains("ambiguous")));
    let certified = estimates.iter().enumerate().filter(|(_, estimate)| estimate.is_certified());
    assert_eq!(certified.filter(is_wrong).map(|(index, _)| index).collect::<Vec<_>>(), Vec::<usize>::new());
    assert_right_at_the_end(estimates.last().expect("an estimate"), &run_of);
}

#[test]
fn another_object_contradicts_the_shape() {
    let samples = felt(1, 6.0, 100.0).log.samples;
    let others = felt(2, 6.0, 100.0).log.samples;
    let mut live = Live::default();
    samples.iter().for_each(|sample| drop(live.push(sample).clone()));
    assert!(live.estimate().is_certified(), "{}", live.estimate().reason());
    let after = |sample: &Sample| Sample { time_s: sample.time_s + 7.0, ..*sample };
    let reasons = others.iter().map(|sample| live.push(&after(sample)).clone()).find(|estimate| estimate.contradicted);
    let contradicted = reasons.expect("no pose of the first explains the second");
    assert!(!contradicted.is_certified() && contradicted.reason().contains("another search"));
}

#[test]
fn constants_of_the_rig_are_estimated_on_the_way() {
    let log = Rig::uncalibrated().drawn(7).distorted(&felt(3, 20.0, 30.0).log);
    let options = palpate::reconstruct::ReconstructOptions::default().with_rig(Rig::uncalibrated());
    let mut live = Live::new(options.clone());
    for sample in &log.samples {
        live.push(sample);
    }
    let estimate = live.estimate();
    let of_rig = estimate.calibration.as_ref().expect("constants were open");
    assert!(of_rig.constants.iter().any(|constant| constant.sd < 0.5 * constant.prior_sd), "{of_rig:?}");
    assert!(!estimate.contradicted && estimate.r_sd_m() < 1e-3, "{}", estimate.r_sd_m());
    let found = Reconstructor::from(options).run(&log).expect("solvable");
    assert!(estimate.distance_sds(&found).expect("a shape") < 1.5);
}

#[test]
fn samples_that_no_log_can_have_are_counted_and_change_nothing() {
    let good = felt(2, 3.0, 50.0).log.samples;
    let mut live = Live::default();
    for (index, sample) in good.iter().enumerate() {
        let before = without_refused(live.push(sample));
        let bad = match index % 5 {
            0 => Sample { s1_m: Some(f64::NAN), ..*sample },
            1 => Sample { time_s: sample.time_s - 1.0, ..*sample },
            2 => Sample { palms: PalmPair::hinged(1.0, 0.0), ..*sample },
            3 => Sample { s2_sd_m: Some(0.0), ..*sample },
            _ => Sample { palms: PalmPair::hinged(f64::INFINITY, 1.0), ..*sample },
        };
        let after = live.push(&bad).clone();
        assert_eq!(after.refused, index as u64 + 1);
        assert!(without_refused(&after) == before);
    }
    assert_eq!(live.log().samples, good);
}

#[test]
fn garbage_gives_finite_estimates_or_none() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let shape = NamedShape::Egg.shape(0.03).expect("a positive size");
    let good = felt(2, 6.0, 50.0).log.samples;
    let mut live = Live::default();
    let mut followed = 0;
    for (index, sample) in good.iter().enumerate() {
        // First a log, then positions and angles from anywhere, then no contact, then another object.
        let mut sample = *sample;
        match index {
            0..200 => {}
            200..230 => {
                sample.palms = PalmPair::hinged(rng.random_range(-9.0..9.0), rng.random_range(0.1..3.0));
                (sample.s1_m, sample.s2_m) = (Some(rng.random_range(-1e9..1e9)), Some(rng.random_range(0.0..1e-9)));
            }
            230..260 => (sample.s1_m, sample.s2_m) = (None, None),
            _ => {
                let (s1, s2) = sample.palms.contact_positions_m(&shape, 0.3);
                (sample.s1_m, sample.s2_m) = (Some(s1), Some(s2));
            }
        }
        let estimate = live.push(&sample);
        if let Some(pose) = &estimate.pose {
            followed += 1;
            let numbers = [pose.psi_rad, pose.psi_sd_rad, pose.com_x_m, pose.com_y_m, pose.com_sd_m, estimate.r_sd_m()];
            assert!(numbers.iter().all(|number| number.is_finite()), "{index}: {pose:?}");
            assert!(estimate.shape.as_ref().is_some_and(|shape| !shape.has_nonfinite()));
        }
        if (215..260).contains(&index) {
            assert!(!estimate.is_certified(), "{index}");
        }
    }
    assert!(followed > 0);
}

#[test]
fn without_samples_there_is_no_answer() {
    assert!(matches!(Live::default().finish(), Err(ReconstructError::TooFewSamples { .. })));
    let live = Live::default();
    assert!(live.estimate().time_s.is_nan() && live.estimate().r_sd_m().is_nan() && live.log().samples.is_empty());
}
