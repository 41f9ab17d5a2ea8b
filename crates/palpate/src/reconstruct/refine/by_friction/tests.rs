use super::growth::Strided;
use super::stretch::Stretch;
use super::*;
use crate::estimate::model::evidence::Evidence;
use crate::math::angle::wrapped;
use crate::palms::PalmPair;
use crate::reconstruct::ReconstructOptions;
use crate::sensor::Touchpad;
use crate::simulate::{Jump, SimulateOptions, Simulation, simulate};
use std::f64::consts::TAU;
use std::ops::Range;

const RADIUS_M: f64 = 0.03;
const FRICTION: [f64; 2] = [0.15, 0.1];

/// An object of three harmonics, carried along and sliding.
fn felt(with_forces: bool) -> (SupportFunction, Simulation) {
    felt_with_noise(with_forces, NOISE_SD_M)
}

fn felt_with_noise(with_forces: bool, noise_sd_m: f64) -> (SupportFunction, Simulation) {
    let shape = SupportFunction::new(RADIUS_M, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]]);
    let options = SimulateOptions { with_forces, start_psi_rad: 0.4, ..SimulateOptions::default() };
    let run = carried(&shape, options, noise_sd_m);
    (shape, run)
}

fn carried(shape: &SupportFunction, options: SimulateOptions, noise_sd_m: f64) -> Simulation {
    let at = |index: u32| {
        let t = 0.08 * f64::from(index);
        (t, PalmPair::hinged(0.9 + 0.3 * (0.7 * t).sin(), 1.2 + 0.4 * (0.9 * t + 0.5).sin()))
    };
    let motion: Vec<(f64, PalmPair)> = (0..900).map(at).collect();
    let touchpad = Touchpad { noise_sd_m, ..Touchpad::ideal() };
    let options = SimulateOptions { friction: FRICTION, touchpad, mass_kg: MASS_KG, ..options };
    simulate(shape, &motion, &options).expect("possible")
}

const MASS_KG: f64 = 0.05;
const NOISE_SD_M: f64 = 1e-5;

/// The truth as an optimum by contact alone.
fn fit(job: &Job, shape: &SupportFunction, run: &Simulation) -> Fit {
    let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let estimate = Estimate { coefficients: shape.coefficients(), psi, cost: 0.0 };
    let noise = Noise { sensor_m: 1e-5, balance_m: 1e-3 };
    Fit { estimate, order: 3, noise, prior: job.prior, evidence: Evidence::NONE }
}

/// Shape and motion as they are, with these coefficients of friction.
fn unknowns(fit: &Fit, friction: [f64; 2]) -> Unknowns {
    let Estimate { coefficients, psi, .. } = fit.estimate.clone();
    Unknowns { coefficients, friction, weight_n: 1.0, calibration: crate::sensor::Calibration::default(), psi }
}

/// What comes of an optimum that begins at the truth.
fn from_truth<T>(then: impl Fn(&Setting, Settled) -> T) -> T {
    from_truth_of(felt(false), then)
}

fn from_truth_of<T>((shape, run): (SupportFunction, Simulation), then: impl Fn(&Setting, Settled) -> T) -> T {
    let options = ReconstructOptions::default();
    let job = Job::new(&run.log, &options);
    let fit = fit(&job, &shape, &run);
    let setting = Setting::new(&job, job.raw, &job.measurements, &fit, &[]);
    let start = unknowns(&fit, FRICTION);
    let regimes = setting.modes_of(&start, CLOSE);
    let settled = setting.settled((start, regimes), CLOSE, (ROUNDS, UPDATES)).expect("an optimum");
    friction_is_right(&settled);
    then(&setting, settled)
}

const CLOSE: FrictionNoise =
    FrictionNoise { sensor_m: 1e-5, slip_m: 1e-3 * RADIUS_M, forces_m: 3e-3 * RADIUS_M, pads_n: 1.0 };

fn friction_is_right(settled: &Settled) {
    for (found, truth) in settled.optimum.unknowns.friction.iter().zip(FRICTION) {
        assert!((found - truth).abs() < 0.03 * truth, "{found} {truth}");
    }
}

#[test]
fn rolling_leads_to_form_friction_and_centre_of_mass() {
    let (_, run) = felt(false);
    let options = ReconstructOptions::default();
    let found = Job::new(&run.log, &options).explained_by_rolling().expect("friction explains it").result;
    assert!(!found.verdict.doubts_friction(), "{}", found.verdict);
    let friction = found.friction.expect("friction acts");
    for (found, truth) in friction.coefficients.iter().zip(FRICTION) {
        assert!((found - truth).abs() < 0.05 * truth, "{found} {truth}");
    }
    let errors = crate::compare::compare(&found, &run.truth).expect("of one log");
    assert!(
        errors.rms_form_m < 1e-3 * RADIUS_M && errors.rms_com_m < 5e-3 * RADIUS_M,
        "{errors:?} {} {:?} {:?}",
        found.verdict,
        found.jumps,
        run.jumps
    );
}

/// A log of an object whose contacts do not tell in which of three poses it is, thrown to another in the middle; its motion, and the first sample after it.
struct Thrown {
    trefoil: SupportFunction,
    log: Log,
    psi: Vec<f64>,
    at: usize,
}

impl Thrown {
    const COUNT: usize = 600;
    const AT: usize = 400;

    fn new(lobes_m: f64, friction: f64, by_rad: f64) -> Self {
        let trefoil = SupportFunction::new(RADIUS_M, vec![[1.5e-3, 0.7e-3], [0.0; 2], [lobes_m, 0.0]]);
        let at = |index: usize| {
            let t = 0.08 * index as f64;
            (t, PalmPair::hinged(0.9 + 0.3 * (0.7 * t).sin(), 1.2 + 0.4 * (0.9 * t + 0.5).sin()))
        };
        let motion: Vec<(f64, PalmPair)> = (0..Self::COUNT).map(at).collect();
        let touchpad = Touchpad { noise_sd_m: NOISE_SD_M, ..Touchpad::ideal() };
        let carried = |range: Range<usize>, start_psi_rad: f64| {
            let friction = [friction; 2];
            let options = SimulateOptions { friction, touchpad, start_psi_rad, ..SimulateOptions::default() };
            simulate(&trefoil, &motion[range], &options).expect("possible")
        };
        let psi_of = |run: &Simulation| run.truth.motion.iter().map(|pose| pose.psi_rad).collect::<Vec<f64>>();
        let before = carried(0..Self::AT, 3.0);
        let mut psi = psi_of(&before);
        let after = carried(Self::AT..Self::COUNT, psi[Self::AT - 1] + by_rad);
        psi.extend(psi_of(&after));
        let log = Log { samples: [before.log.samples, after.log.samples].concat() };
        Self { trefoil, log, psi, at: Self::AT }
    }

    /// Where some motion of its part comes to from the truth, and how it is begun.
    fn settled(&self, job: &Job, strided: &Strided, psi: Vec<f64>, friction: f64) -> (Fit, Settled) {
        let (log, measurements) = strided.part(&(0..psi.len()));
        let estimate = Estimate { coefficients: self.trefoil.coefficients(), psi, cost: 0.0 };
        let noise = Noise { sensor_m: NOISE_SD_M, balance_m: 1e-3 };
        let fit = Fit { estimate, order: 3, noise, prior: job.prior, evidence: Evidence::NONE };
        let setting = Setting::new(job, &log, &measurements, &fit, &[]);
        let start = unknowns(&fit, [friction; 2]);
        let regimes = setting.modes_of(&start, CLOSE);
        let settled = setting.settled((start, regimes), CLOSE, (ROUNDS, UPDATES)).expect("an optimum");
        (fit, settled)
    }

    fn off_rad(&self, psi: &[f64]) -> f64 {
        psi.iter().zip(&self.psi).map(|(found, truth)| wrapped(found - truth).abs()).fold(0.0, f64::max)
    }
}

#[test]
fn growth_goes_over_a_jump_to_the_pose_that_mechanics_goes_on_from() {
    const SLIPPERY: f64 = 0.06;
    for third in 1..3 {
        let thrown = Thrown::new(1e-3, SLIPPERY, 0.3 + f64::from(third) * TAU / 3.0);
        let options = ReconstructOptions::default();
        let job = Job::new(&thrown.log, &options);
        let strided = Strided::new(&job);
        let range = 0..thrown.at;
        let (fit, settled) = thrown.settled(&job, &strided, thrown.psi[range.clone()].to_vec(), SLIPPERY);
        let stretch = Stretch { range, fit, settled };
        let followed = |over_jumps: bool| strided.followed(&stretch, &(0..thrown.psi.len()), over_jumps);
        let (psi, starts) = followed(true);
        assert_eq!(starts, [thrown.at]);
        assert!(thrown.off_rad(&psi) < 0.01, "{third}: {}", thrown.off_rad(&psi));
        assert!(thrown.off_rad(&followed(false).0) > 1.0);
    }
}

#[test]
fn a_jump_that_no_contact_shows_is_found() {
    const FRICTION: f64 = 0.1;
    // Nearly round, so that it may fall from copy to copy.
    let thrown = Thrown::new(2e-4, FRICTION, TAU / 3.0);
    let options = ReconstructOptions::default();
    let job = Job::new(&thrown.log, &options);
    let as_if_still = |(index, psi): (usize, &f64)| if index < thrown.at { *psi } else { psi - TAU / 3.0 };
    let still = thrown.psi.iter().enumerate().map(as_if_still).collect();
    let (fit, settled) = thrown.settled(&job, &Strided::new(&job), still, FRICTION);
    assert!(settled.starts.is_empty(), "{:?}", settled.starts);
    let setting = Setting::new(&job, job.raw, &job.measurements, &fit, &[]);
    let (found, _) = rotations::likeliest(&setting, settled).expect("all are known");
    // When it fell, within a few samples, nothing tells.
    let [start] = found.starts[..] else { panic!("{:?}", found.starts) };
    assert!(start.abs_diff(thrown.at) < 8, "{start}");
    let psi = &found.optimum.unknowns.psi;
    let off = |part: Range<usize>| part.map(|index| wrapped(psi[index] - thrown.psi[index]).abs()).fold(0.0, f64::max);
    let apart = [off(0..thrown.at), off(start..psi.len())];
    assert!(apart.iter().all(|off| *off < 0.03), "{apart:?}");
}

#[test]
fn contacts_may_be_missed_by_what_neighbouring_samples_scatter() {
    let (shape, run) = felt_with_noise(false, 10.0 * NOISE_SD_M);
    let options = ReconstructOptions::default();
    let job = Job::new(&run.log, &options);
    let most_m = |noise_m: f64| {
        let mut fit = fit(&job, &shape, &run);
        fit.noise.sensor_m = noise_m;
        Setting::new(&job, job.raw, &job.measurements, &fit, &[]).bounds.sensor_m[1]
    };
    assert_eq!(most_m(0.5 * job.scatter_m), CONTACTS_ALLOWANCE * job.scatter_m);
    assert_eq!(most_m(2.0 * job.scatter_m), CONTACTS_ALLOWANCE * 2.0 * job.scatter_m);
}

#[test]
fn contacts_are_believed_to_a_ten_thousandth_of_the_radius() {
    let least_m = SENSOR_FLOOR * RADIUS_M;
    let believed = |noise_sd_m: f64| {
        from_truth_of(felt_with_noise(false, noise_sd_m), |_, settled| settled.optimum.noise.sensor_m / least_m)
    };
    let (exact, noisy) = (believed(0.5 * least_m), believed(2.0 * least_m));
    assert!((exact - 1.0).abs() < 0.01 && (noisy - 2.0).abs() < 0.2, "{exact} {noisy}");
}

/// What comes of an optimum whose coefficients of friction are held at wrong ones, so many times the true ones.
fn from_wrong_friction<T>(factor: f64, then: impl Fn(&Setting, Settled) -> T) -> T {
    let (shape, run) = felt(false);
    let options = ReconstructOptions::default();
    let job = Job::new(&run.log, &options);
    let fit = fit(&job, &shape, &run);
    let setting = Setting::new(&job, job.raw, &job.measurements, &fit, &[]);
    let wrong = unknowns(&fit, FRICTION.map(|friction| factor * friction));
    let regimes = setting.modes_of(&wrong, CLOSE);
    let held = setting.settled_holding(Some(wrong.friction), (wrong.clone(), regimes), CLOSE, (ROUNDS, UPDATES));
    let held = held.expect("an optimum");
    for (found, wrong) in held.optimum.unknowns.friction.iter().zip(wrong.friction) {
        assert!((found - wrong).abs() < 0.05 * wrong, "{found} is held at {wrong}");
    }
    then(&setting, held)
}

#[test]
fn wrong_coefficients_of_friction_are_left() {
    for factor in [0.7, 1.4] {
        from_wrong_friction(factor, |setting, held| {
            assert!(!held.is_exact(setting.bounds));
            friction_is_right(&setting.with_other_friction(held));
        });
    }
}

#[test]
fn other_coefficients_of_friction_are_tried_near_what_is_plausible() {
    let missing = |forces: f64| {
        from_wrong_friction(0.7, |setting, mut held| {
            held.optimum.noise.forces_m = forces * PLAUSIBLE[1] * held.optimum.unknowns.coefficients[0];
            let wrong = held.optimum.unknowns.friction;
            (setting.with_other_friction(held).optimum.unknowns.friction, wrong)
        })
    };
    let (found, wrong) = missing(1.01 * NEARLY_PLAUSIBLE);
    assert_eq!(found, wrong);
    let (found, wrong) = missing(0.99 * NEARLY_PLAUSIBLE);
    assert_ne!(found, wrong);
}

#[test]
fn a_result_is_certified_up_to_what_slip_and_forces_may_miss() {
    let result_with = |shares: [f64; 2], missed: f64| {
        from_truth(|setting, mut settled| {
            let Optimum { unknowns, noise, misfit, settled: is_settled, .. } = &mut settled.optimum;
            let size_m = unknowns.coefficients[0];
            (noise.slip_m, noise.forces_m) = (shares[0] * size_m, shares[1] * size_m);
            (*misfit, *is_settled) = (1.0, true);
            settled.optimum.missed = (missed * settled.optimum.unknowns.psi.len() as f64).round() as usize;
            setting.judged(settled).map(|candidate| candidate.result.verdict.doubts_friction())
        })
    };
    let (below, above) = (0.99 * EXPLAINED, 1.01 * EXPLAINED);
    assert_eq!(result_with([below; 2], 1.0), Some(false));
    assert_eq!(result_with([above, below], 1.0), Some(true));
    assert_eq!(result_with([below, above], 1.0), Some(true));
    // A few samples may miss the forces by more: a ninth of them by three times as much.
    assert_eq!(result_with([below, 3.0 * 0.98 * EXPLAINED], 1.0 / 9.0), Some(false));
    assert_eq!(result_with([below, 3.0 * 1.02 * EXPLAINED], 1.0 / 9.0), Some(true));
    let times = |factor: f64, shares: [f64; 2]| shares.map(|share| factor * share);
    assert_eq!(result_with(times(0.99, PLAUSIBLE), 1.0), Some(true));
    assert_eq!(result_with([1.01 * PLAUSIBLE[0], 0.5 * PLAUSIBLE[1]], 1.0), None);
    assert_eq!(result_with([0.5 * PLAUSIBLE[0], 1.01 * PLAUSIBLE[1]], 1.0), None);
}

#[test]
fn where_friction_is_doubted_nothing_says_that_all_but_the_centre_of_mass_is_certified() {
    let verdict = |slip: f64, inflation: f64| {
        from_truth(|setting, mut settled| {
            settled.optimum.noise.slip_m = slip * EXPLAINED * settled.optimum.unknowns.coefficients[0];
            settled.optimum.settled = true;
            settled.optimum.inflation = inflation;
            setting.judged(settled).expect("a result").result.verdict
        })
    };
    // Error bars so wide that the centre of mass is not known, and the form is.
    let inflation =
        (0..8).map(|power| 10.0f64.powi(power)).find(|inflation| !verdict(0.5, *inflation).is_com_certified());
    let inflation = inflation.expect("wide enough");
    assert!(matches!(verdict(0.5, inflation).doubts[..], [Doubt::UncertainCenter { .. }]));
    assert!(matches!(verdict(1.01, inflation).doubts[..], [Doubt::Friction { .. }]));
}

#[test]
fn standard_deviations_that_have_not_settled_must_be_far_below_what_is_asked() {
    let doubts_with = |share: f64| {
        from_truth(|setting, mut settled| {
            let size_m = settled.optimum.unknowns.coefficients[0];
            settled.optimum.noise.slip_m = share * EXPLAINED * size_m;
            settled.optimum.settled = false;
            setting.judged(settled).expect("a result").result.verdict.doubts_friction()
        })
    };
    assert!(!doubts_with(0.99 * FAR_BELOW) && doubts_with(1.01 * FAR_BELOW));
}

#[test]
fn what_another_rotation_explains_as_well_is_told() {
    // Both halves of this log feel the same boundary: as if it jumped between them, only one rotation explains it.
    from_truth(|setting, mut settled| {
        settled.starts = vec![450];
        let (found, others) = rotations::likeliest(setting, settled).expect("all are known");
        assert!(others.is_empty(), "{}", others.len());
        friction_is_right(&found);
        // No contact leaps there, and without the jump the same motion is likelier.
        assert!(found.starts.is_empty(), "{:?}", found.starts);
    });
}

#[test]
fn what_is_far_from_plausible_and_gets_no_better_is_hopeless() {
    let hopeless = |left: f64, better: f64| {
        from_truth(|setting, mut settled| {
            let forces_m = PLAUSIBLE[1] * settled.optimum.unknowns.coefficients[0];
            settled.optimum.noise.forces_m = left * forces_m;
            let regimes = settled.regimes.clone();
            let start = (settled.optimum.unknowns.clone(), regimes);
            let mut before = setting.settled(start, CLOSE, (1, 1)).expect("an optimum");
            before.optimum.noise.forces_m = left * forces_m / better;
            settled.is_hopeless_after(&before)
        })
    };
    assert!(hopeless(1.01 * NEARLY_PLAUSIBLE, 1.01 * HOPELESS) && !hopeless(1.01 * NEARLY_PLAUSIBLE, 0.99 * HOPELESS));
    assert!(!hopeless(0.99 * NEARLY_PLAUSIBLE, 1.01 * HOPELESS));
}

#[test]
fn rotations_that_are_not_all_known_tell_nothing() {
    let known = |share: f64| {
        from_truth(|setting, mut settled| {
            settled.starts = vec![450];
            setting.worth(share, |setting| {
                setting.job.measurements.work.add_decoding(1);
                rotations::likeliest(setting, settled).is_some()
            })
        })
    };
    assert!(known(ROTATIONS_WORTH_UNTOLD) && !known(0.0));
}

#[test]
fn a_few_samples_that_jump_away_and_back_are_no_rival_but_a_mistake() {
    from_truth(|setting, mut settled| {
        let truth = settled.optimum.unknowns.psi.clone();
        settled.starts = vec![440, 450];
        settled.optimum.unknowns.psi[440..450].iter_mut().for_each(|psi| *psi += 0.5);
        let (found, others) = rotations::likeliest(setting, settled).expect("all are known");
        assert!(found.starts.is_empty() && others.is_empty(), "{:?} {}", found.starts, others.len());
        // The frame of the object may be any.
        let turned = found.optimum.unknowns.psi[0] - truth[0];
        let off = truth.iter().zip(&found.optimum.unknowns.psi).map(|(truth, found)| (found - truth - turned).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-2, "{off}");
    });
}

/// Standard deviations of both coefficients of friction, before and after the intervals confine them.
fn confined(mut settled: Settled, sliding: usize) -> [[f64; 2]; 2] {
    let first = settled.optimum.unknowns.coefficients.len();
    let sds = |settled: &Settled| {
        let covariance = settled.optimum.eliminated.covariance();
        [first, first + 1].map(|unknown| settled.optimum.sd(&covariance, unknown))
    };
    // What slides beyond so many samples tells nothing.
    let mut left = sliding;
    for index in 0..settled.regimes.len() {
        let slides = settled.regimes[index].place == Place::Between;
        settled.regimes[index].place = match settled.regimes[index].place {
            Place::Between if left == 0 => Place::Anywhere,
            place => place,
        };
        left -= usize::from(slides && left > 0);
    }
    // Nor do the equations tell much.
    settled.optimum.inflation = 1e6;
    let before = sds(&settled);
    settled.confine();
    [before, sds(&settled)]
}

#[test]
fn intervals_confine_friction_that_equations_do_not_tell() {
    from_truth(|_, settled| {
        let off = [0, 1].map(|palm| (settled.optimum.unknowns.friction[palm] - FRICTION[palm]).abs());
        let [before, after] = confined(settled, 2);
        for palm in 0..2 {
            assert!(before[palm] > 0.1 && after[palm] < 0.1, "{before:?} {after:?}");
            assert!(off[palm] < 4.0 * after[palm], "{off:?} {after:?}");
        }
    });
}

#[test]
fn friction_is_told_without_the_intervals_beside_changes_where_it_slides() {
    from_truth(|setting, mut settled| {
        let friction = |candidate: Option<Candidate>| candidate.and_then(|found| found.result.friction);
        let steady = friction(setting.judged_by_steady_intervals(&settled)).expect("told");
        for ((found, sd), truth) in steady.coefficients.iter().zip(steady.coefficient_sds).zip(FRICTION) {
            assert!((found - truth).abs() < 3.0 * sd, "{steady:?}");
        }
        settled.regimes.iter_mut().filter(|regime| regime.place == Place::Between).for_each(|regime| {
            regime.place = Place::Anywhere;
        });
        assert!(setting.judged_by_steady_intervals(&settled).is_none());
    });
    from_truth(|setting, settled| {
        let steady = setting.judged_by_steady_intervals(&settled).and_then(|found| found.result.friction);
        let found = setting.candidate(settled).and_then(|found| found.result.friction);
        assert!(steady.is_some() && found.map(|of| of.coefficients) == steady.map(|of| of.coefficients));
    });
}

#[test]
fn where_nothing_slides_on_both_palms_intervals_tell_nothing_more() {
    from_truth(|_, settled| {
        let [before, after] = confined(settled, 0);
        assert_eq!(before, after);
    });
}

#[test]
fn a_few_samples_between_jumps_may_be_elsewhere() {
    from_truth(|_, mut settled| {
        settled.starts = vec![5, 300, 306, 311];
        let ambiguous = settled.ambiguity_rad().iter().filter(|ambiguity_rad| **ambiguity_rad > 0.0).count();
        assert_eq!(ambiguous, 5 + 5);
        // More of them are, where no others felt what they do.
        let open = |mut settled: Settled, samples: usize, turned: f64| {
            settled.starts = vec![samples];
            settled.optimum.unknowns.psi[..samples].iter_mut().for_each(|psi| *psi += turned);
            (settled.ambiguity_rad().iter().filter(|ambiguity_rad| **ambiguity_rad > 0.0).count(), settled)
        };
        let (there, settled) = open(settled, SHORT_AND_ALONE - 1, 0.0);
        let (away, settled) = open(settled, SHORT_AND_ALONE - 1, PI);
        let (long, _) = open(settled, SHORT_AND_ALONE, 0.0);
        assert_eq!([there, away, long], [0, SHORT_AND_ALONE - 1, 0]);
    });
}

#[test]
fn one_palm_that_measures_forces_tells_the_weight_and_more_of_the_centre_of_mass() {
    let center_sd_m = |_: &Setting, settled: Settled| {
        let Optimum { unknowns, eliminated, .. } = settled.optimum;
        (unknowns.weight_n, eliminated.covariance()[(1, 1)].sqrt())
    };
    let (_, without_m) = from_truth_of(felt(false), center_sd_m);
    let (shape, mut run) = felt(true);
    let noise = |index: usize| 1.0 + 0.02 * (12.9898 * index as f64).sin();
    for (index, sample) in run.log.samples.iter_mut().enumerate() {
        sample.force1_n = None;
        sample.force2_n = sample.force2_n.map(|force_n| force_n * noise(index));
    }
    let (weight_n, with_m) = from_truth_of((shape, run), center_sd_m);
    let true_n = MASS_KG * crate::mechanics::STANDARD_GRAVITY_M_PER_S2;
    assert!((weight_n / true_n - 1.0).abs() < 3e-3, "{weight_n} {true_n}");
    assert!(with_m < without_m, "{with_m} {without_m}");
}

#[test]
fn a_fall_that_a_fit_draws_out_is_found() {
    let shape = SupportFunction::new(RADIUS_M, vec![[1.5e-3, 5e-3], [5e-3, 1e-3], [-5e-4, 7e-4]]);
    let run = carried(&shape, SimulateOptions { start_psi_rad: 0.0, ..SimulateOptions::default() }, NOISE_SD_M);
    let time_s = |index: usize| run.log.samples[index].time_s;
    let ends = |jump: &Jump| (0..900).find(|&index| time_s(index) >= jump.time_s).expect("within the log");
    let jumps: Vec<usize> = run.jumps.iter().map(ends).collect();
    let jump = *jumps.iter().find(|jump| (100..800).contains(*jump)).expect("it falls");
    let options = ReconstructOptions::default();
    let job = Job::new(&run.log, &options);
    let mut fit = fit(&job, &shape, &run);
    // As if it had fallen in two steps.
    let psi = &mut fit.estimate.psi;
    let halfway = 0.5 * (psi[jump - 1] + psi[jump]);
    psi[jump - 2..=jump + 1].fill(halfway);
    let others: Vec<usize> = jumps.into_iter().filter(|other| *other != jump).collect();
    let setting = Setting::new(&job, job.raw, &job.measurements, &fit, &others);
    let start = unknowns(&fit, FRICTION);
    let regimes = setting.modes_of(&start, CLOSE);
    let settled = setting.settled((start, regimes), CLOSE, (ROUNDS, UPDATES)).expect("an optimum");
    assert!(settled.starts.contains(&jump), "{:?} without {}", settled.starts, jump);
    friction_is_right(&settled);
    let truth = run.truth.motion.iter().map(|pose| pose.psi_rad);
    let worst =
        settled.optimum.unknowns.psi.iter().zip(truth).map(|(found, truth)| (found - truth).abs()).fold(0.0, f64::max);
    assert!(worst < 0.02, "{worst}");
}
