use super::*;
use crate::estimate::model::evidence::Evidence;
use crate::mechanics::Jump;
use crate::palms::PalmMotion;
use crate::reconstruct::ReconstructOptions;
use crate::reconstruct::result::friction::FrictionEstimate;
use crate::reconstruct::result::reconstruction::OutlinePoint;
use crate::reconstruct::start::arrangement_of;
use crate::sensor::Touchpad;
use crate::shape::{NamedShape, SupportFunction};
use crate::simulate::{SimulateOptions, simulate};

const RADIUS_M: f64 = 0.03;

const FRICTION: FrictionEstimate = FrictionEstimate {
    coefficients: [0.2, 0.1],
    coefficient_sds: [0.01; 2],
    center_m: [0.0; 2],
    center_sd_m: [1e-5; 2],
    misfit: 1.0,
    slides: 100,
    rolls: [3, 4],
};

/// A result of a circle with the fields that the comparison of results reads.
fn candidate(explained: bool, log_posterior: f64, chi2_per_dof: f64, physical: &[bool]) -> Candidate {
    let jump = |&physical: &bool| Jump { physical, ..Jump::default() };
    let result = Reconstruction {
        shape: SupportFunction::new(RADIUS_M, Vec::new()),
        outline: Vec::new(),
        motion: Vec::new(),
        verdict: Verdict::new(vec![if explained { Doubt::LittleFelt { coverage: 0.0 } } else { Doubt::NotConvex }]),
        findings: None,
        chi2_per_dof,
        jumps: physical.iter().map(jump).collect(),
        coverage: 0.0,
        symmetry: crate::reconstruct::FoundSymmetry::default(),
        alternatives: 1,
        others: Vec::new(),
        sensor_sd_m: 1e-6,
        balance_sd_m: 1e-7,
        calibration: None,
        friction: None,
        inertia: None,
    };
    Candidate { result, posterior: Evidence::of_samples(log_posterior) }
}

#[test]
fn an_explained_result_is_likelier_than_an_unexplained_one_whatever_else_they_say() {
    let explained = candidate(true, -1e6, 900.0, &[false, false]);
    let unexplained = candidate(false, 1e6, 0.1, &[]);
    assert!(explained.is_likelier_than(&unexplained));
    assert!(!unexplained.is_likelier_than(&explained));
}

#[test]
fn a_wrong_arrangement_alone_misses_neither_contacts_nor_balance() {
    let unphysical = Doubt::UnphysicalJumps { time_s: 1.0, turn_rad: 2.0, jumps: 1 };
    let misses_readings = |balance_share: f64, also: Option<Doubt>| {
        let Candidate { result, posterior } = candidate(false, 0.0, 1.0, &[false]);
        let verdict = Verdict::new([unphysical.clone()].into_iter().chain(also).collect());
        let balance_sd_m = balance_share * result.sensor_sd_m;
        Candidate { result: Reconstruction { verdict, balance_sd_m, ..result }, posterior }.misses_readings()
    };
    assert!(!misses_readings(0.99 * INEXACT_BALANCE, None) && misses_readings(1.01 * INEXACT_BALANCE, None));
    let misfit = Doubt::Misfit { left_m: 3e-4, expected_m: 1e-4, stated: false };
    let stray = Doubt::StrayReadings { typical_m: 1e-4, all_m: 4e-4 };
    assert!(misses_readings(0.1, Some(misfit)) && misses_readings(0.1, Some(stray)));
}

#[test]
fn of_two_explained_results_the_one_with_more_evidence_is_likelier() {
    let more = candidate(true, 101.0, 2.0, &[false]);
    let less = candidate(true, 100.0, 1.0, &[]);
    assert!(more.is_likelier_than(&less));
    assert!(!less.is_likelier_than(&more));
    assert!(!more.is_likelier_than(&more), "a result does not replace itself");
}

#[test]
fn of_two_contradicted_results_the_one_with_fewer_unphysical_jumps_is_likelier_and_then_the_better_fit() {
    let one_unphysical = candidate(false, 0.0, 900.0, &[true, false]);
    let two_unphysical = candidate(false, 10.0, 1.0, &[false, false]);
    assert!(one_unphysical.is_likelier_than(&two_unphysical));
    assert!(!two_unphysical.is_likelier_than(&one_unphysical));
    // Jumps that statics predicts do not count; then the smaller chi squared decides, not the evidence.
    let better = candidate(false, 0.0, 5.0, &[true, true, true, false]);
    let worse = candidate(false, 10.0, 6.0, &[false]);
    assert!(better.is_likelier_than(&worse));
    assert!(!worse.is_likelier_than(&better));
}

#[test]
fn no_chi_squared_outweighs_an_unphysical_jump() {
    let physical = candidate(false, 0.0, f64::INFINITY, &[]);
    let unphysical = candidate(false, 0.0, 0.0, &[false]);
    assert!(physical.is_likelier_than(&unphysical));
    assert!(!unphysical.is_likelier_than(&physical));
}

#[test]
fn one_explanation_is_enough_where_the_balance_holds() {
    let sound = candidate(true, 0.0, 1.0, &[]);
    assert!(!sound.is_enough(0));
    assert!(sound.is_enough(1));
}

#[test]
fn a_result_with_nothing_but_noise_against_it_ends_the_search() {
    let misfit = Doubt::Misfit { left_m: 3e-4, expected_m: 1e-4, stated: false };
    let with = |chi2_per_dof, doubts: &[Doubt]| {
        let mut candidate = candidate(false, 0.0, chi2_per_dof, &[true]);
        candidate.result.verdict = Verdict::new(doubts.to_vec());
        candidate.is_enough(0)
    };
    assert!(with(9.9, std::slice::from_ref(&misfit)));
    assert!(!with(10.1, std::slice::from_ref(&misfit)));
    assert!(!with(9.9, &[misfit, Doubt::UnstablePoses { samples: 3, of: 9 }]));
    assert!(!with(9.9, &[Doubt::NotConvex]));
}

#[test]
fn the_search_ends_after_so_many_motions_for_each_trust_in_the_calibration() {
    let mut explored = Explored::default();
    for motions in 1..=2 * MOST_EXPLORED {
        explored.add(&candidate(false, 0.0, 1.0, &[]));
        assert_eq!(explored.is_enough(1), motions >= MOST_EXPLORED);
        assert_eq!(explored.is_enough(2), motions == 2 * MOST_EXPLORED);
    }
}

#[test]
fn further_explanations_are_required_where_noisy_contacts_miss_the_balance() {
    let mut unbalanced = candidate(true, 0.0, 1.0, &[]);
    unbalanced.result.sensor_sd_m = 0.01 * RADIUS_M;
    unbalanced.result.balance_sd_m = unbalanced.result.sensor_sd_m;
    assert!(balance_is_missed(unbalanced.result.sensor_sd_m, unbalanced.result.balance_sd_m, RADIUS_M));
    assert!(!unbalanced.is_enough(FURTHER_EXPLANATIONS));
    assert!(unbalanced.is_enough(FURTHER_EXPLANATIONS + 1));
}

#[test]
fn a_rival_that_is_as_likely_takes_the_certificate_whatever_speaks_against_it() {
    let turning = |explained: bool, log_posterior: f64, turn_rad: f64| {
        let mut candidate = candidate(explained, log_posterior, 1.0, &[]);
        let pose = |sample: usize| Pose { psi_sd_rad: 1e-3, ..Pose::of_test(sample as f64, turn_rad * sample as f64) };
        candidate.result.motion = (0..100).map(pose).collect();
        candidate
    };
    let answer = |certified: bool, others: &[Candidate]| {
        let mut explored = Explored::default();
        others.iter().for_each(|other| explored.add(other));
        let mut answer = turning(true, 0.0, 0.01);
        if certified {
            answer.result.verdict = Verdict::new(Vec::new());
        }
        let result = explored.against_others(answer);
        (result.is_certified(), result.alternatives)
    };
    let margin = CERTAIN.0;
    assert_eq!(answer(true, &[turning(false, 0.1 - margin, 0.03)]), (false, 2));
    assert_eq!(answer(true, &[turning(false, 50.0, 0.03), turning(true, 0.0, -0.02)]), (false, 3));
    assert_eq!(answer(true, &[turning(false, -0.1 - margin, 0.03)]), (true, 1), "less likely");
    assert_eq!(answer(true, &[turning(false, 50.0, 0.01)]), (true, 1), "the same motion");
    assert_eq!(answer(false, &[turning(false, 50.0, 0.03)]), (false, 1), "not certified anyway");
}

#[test]
fn of_two_results_with_friction_the_certified_then_the_explained_then_the_likelier_is_better() {
    let with_friction = |verdict: Verdict, log_posterior: f64| {
        let mut of = candidate(true, log_posterior, 1.0, &[]);
        (of.result.friction, of.result.verdict) = (Some(FRICTION), verdict);
        of
    };
    let perhaps = Doubt::Friction { coefficients: [0.2, 0.1], sds: [0.01; 2] };
    let perhaps = |log_posterior: f64| with_friction(Verdict::new(vec![perhaps.clone()]), log_posterior);
    let explained =
        |log_posterior: f64| with_friction(Verdict::new(vec![Doubt::LittleFelt { coverage: 0.0 }]), log_posterior);
    let certified = with_friction(Verdict::default(), 0.0);
    assert!(
        certified.explains_forces_better_than(&explained(9.0))
            && explained(0.0).explains_forces_better_than(&perhaps(9.0))
    );
    assert!(
        !explained(9.0).explains_forces_better_than(&certified)
            && !perhaps(9.0).explains_forces_better_than(&explained(0.0))
    );
    assert!(perhaps(1.0).explains_forces_better_than(&perhaps(0.0)));
    assert!(
        !perhaps(0.0).explains_forces_better_than(&perhaps(0.0))
            && !perhaps(0.0).explains_forces_better_than(&perhaps(1.0))
    );
    let known_to = |r_sd_m: f64| {
        let mut of = explained(0.0);
        of.result.outline = crate::reconstruct::verdict::assemble::outline(&of.result.shape, &[1; 8], |_| r_sd_m);
        of
    };
    assert!(
        known_to(1e-5).explains_forces_better_than(&known_to(1e-3))
            && !known_to(1e-3).explains_forces_better_than(&known_to(1e-5))
    );
    // A pose that is open counts more than how well the boundary is known.
    let open_by = |psi_sd_rad: f64, r_sd_m: f64| {
        let mut of = known_to(r_sd_m);
        of.result.verdict = Verdict::default();
        of.result.motion = vec![Pose { psi_sd_rad, ..Pose::of_test(0.0, 0.0) }];
        of
    };
    let (open, closed) = (open_by(0.301, 1e-5), open_by(0.299, 1e-3));
    assert!(!open.is_certified_throughout() && closed.is_certified_throughout());
    assert!(closed.explains_forces_better_than(&open) && !open.explains_forces_better_than(&closed));
    // The likelihoods of different laws do not compare.
    let mut with_inertia = explained(1.0);
    with_inertia.result.friction = None;
    assert!(!with_inertia.explains_forces_better_than(&explained(0.0)));
}

#[test]
fn a_log_checks_what_it_tells_where_enough_was_felt_again() {
    let is_checked = |coverage: f64, touches: u32| {
        let mut result = candidate(true, 0.0, 1.0, &[]).result;
        let point = |theta_rad: f64, touches: u32| OutlinePoint {
            theta_rad,
            r_m: RADIUS_M,
            r_sd_m: 0.0,
            x_m: 0.0,
            y_m: 0.0,
            curvature_radius_m: RADIUS_M,
            touches,
        };
        // What was never felt need not be felt again.
        result.outline = (1..10).map(|node| point(f64::from(node), touches)).collect();
        result.outline.push(point(0.0, 0));
        super::is_checked(&Reconstruction { coverage, ..result })
    };
    assert!(is_checked(LITTLE_FELT, 2) && !is_checked(0.99 * LITTLE_FELT, 2) && !is_checked(1.0, 1));
}

#[test]
fn a_reading_far_from_its_neighbours_is_judged_with_a_sample_that_is_out_of_balance() {
    let shape = NamedShape::Stone.shape(RADIUS_M).expect("a valid size");
    let motion = PalmMotion::random(3, 20.0, 0.6).and_then(|motion| motion.sample(10.0)).expect("possible");
    let touchpad = Touchpad { noise_sd_m: 2e-6, ..Touchpad::ideal() };
    let run = simulate(&shape, &motion, &SimulateOptions { touchpad, ..SimulateOptions::default() }).expect("possible");
    let psi: Vec<f64> = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
    let options = ReconstructOptions::default();
    let far = 70;
    // Contact 1 is far off, and contact 2 as far as an object goes that is not at rest and has hardly moved.
    let left_out = |off2_m: f64| {
        let mut log = run.log.clone();
        log.samples[far].s1_m = log.samples[far].s1_m.map(|s1_m| s1_m + 0.02);
        log.samples[far].s2_m = log.samples[far].s2_m.map(|s2_m| s2_m + off2_m);
        let job = Job::new(&log, &options);
        assert_eq!(job.outliers, [far]);
        let found = arrangement_of(&job, job.measurements.clone(), &shape, psi.clone());
        let Reconstruction { motion, findings, .. } =
            job.judge(&found, &mut Explored::default()).expect("a result").result;
        (motion[far].residual1_m.is_some(), findings.expect("findings").outliers)
    };
    assert_eq!(left_out(0.0), (false, 1));
    assert_eq!(left_out(5e-4), (true, 0));
}
