use super::*;
use crate::estimate::association::transitions::PALMS_AT_REST_RAD;
use crate::estimate::evidence::motion_prior::{EXCLUDED, PER_HALF_TURN, PREDICTED_JUMP, UNPREDICTED_JUMP};
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::motion::LONGEST_STEP;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::log::{Log, Sample};
use crate::mechanics::EnergyLandscape;
use crate::mechanics::frictionless::followed;
use crate::mechanics::passage::SAME_POSE_RAD;
use crate::palms::{PalmMotion, PalmPair};
use crate::shape::NamedShape;
use crate::simulate::{SimulateOptions, simulate};
use std::f64::consts::{PI, TAU};

const SIZE_M: f64 = 0.03;

const FLOOR_M: f64 = 1e-4;

/// Part of a motion of an egg with a jump, without noise.
struct Scene {
    shape: SupportFunction,
    measurements: Measurements,
    psi: Vec<f64>,
    /// First sample after the jump.
    jump: usize,
}

/// A sample far from the jump of a scene, where the object hardly moves.
const SLOW: usize = 90;

fn scene() -> Scene {
    let shape = NamedShape::Egg.shape(SIZE_M).expect("a positive size");
    let motion = PalmMotion::random(3, 20.0, 0.5).and_then(|motion| motion.sample(25.0)).expect("possible");
    let run = simulate(&shape, &motion, &SimulateOptions::default()).expect("possible");
    let [jump] = &run.jumps[..] else { panic!("one jump: {:?}", run.jumps) };
    let first = run.log.samples.iter().position(|sample| sample.time_s > jump.time_s).expect("samples after the jump");
    let range = first - 40..first + 80;
    let log = Log { samples: run.log.samples[range.clone()].to_vec() };
    let psi = run.truth.motion[range].iter().map(|pose| pose.psi_rad).collect();
    Scene { shape, measurements: Measurements::new(&log, None), psi, jump: 40 }
}

/// An ellipse, which looks the same after half a turn, between palms that turn slowly; its poses differ by `off` from those of
/// rest.
fn ellipse(off: f64) -> Scene {
    let shape = SupportFunction::new(SIZE_M, vec![[0.0; 2], [0.1 * SIZE_M, 0.0]]);
    let palms: Vec<PalmPair> = (0..20).map(|index| PalmPair::hinged(0.6 + 0.002 * f64::from(index), 1.7)).collect();
    let mut psi = vec![EnergyLandscape::new(&shape, &palms[0]).stable_poses()[0].psi_rad];
    for pair in palms.windows(2) {
        psi.push(followed(&shape, &pair[0], &pair[1], psi[psi.len() - 1]).0);
    }
    psi.iter_mut().for_each(|psi| *psi += off);
    let measurements = problem_of(&shape, &palms, &psi);
    Scene { shape, measurements, psi, jump: 0 }
}

fn problem_of(shape: &SupportFunction, palms: &[PalmPair], psi: &[f64]) -> Measurements {
    let sample = |(palms, psi): (&PalmPair, &f64)| {
        let (s1, s2) = palms.contact_positions_m(shape, *psi);
        Sample::new(0.0, *palms, s1, s2)
    };
    Measurements::new(&Log { samples: palms.iter().zip(psi).map(sample).collect() }, None)
}

impl Scene {
    fn fit(&self, psi: &[f64]) -> Fit {
        let coefficients = self.shape.coefficients();
        let order = coefficients.len() / 2;
        let noise = Noise { sensor_m: FLOOR_M, balance_m: 0.1 * FLOOR_M };
        let prior = Prior::new(SIZE_M, 0.5 * SIZE_M);
        Fit {
            estimate: Estimate { coefficients, psi: psi.to_vec(), cost: 0.0 },
            order,
            noise,
            prior,
            evidence: Evidence::NONE,
        }
    }

    fn palms(&self, sample: usize) -> PalmPair {
        PalmPair::hinged(self.measurements.instants[sample].phi1, self.measurements.instants[sample].phi2)
    }

    fn table(&self) -> SupportTable {
        SupportTable::new(&self.shape.coefficients())
    }

    /// The costs of the steps from the pose of the sample before `to` to these poses.
    fn steps_to(&self, to: usize, barrier_sd_m: f64, still_m: f64, blind: bool, ends: &[f64]) -> Vec<f64> {
        let (shape, table, instant) = (&self.shape, &self.table(), &self.measurements.instants[to]);
        let work = &self.measurements.work;
        let still_between_turning = true;
        let ahead =
            Transition { shape, table, instant, barrier_sd_m, still_m, still_between_turning, period: TAU, work };
        let choice = |&psi: &f64| Choice { psi, misfit: 0.0 };
        let (from, ends) = ([choice(&self.psi[to - 1])], ends.iter().map(choice).collect::<Vec<_>>());
        steps(&ahead, &self.measurements.instants[to - 1], &from, &ends, blind)
    }
}

/// Standard deviations of a barrier: one at which every barrier is too high, and one at which none is.
const STEEP: f64 = 1e-12;

const FLAT: f64 = f64::INFINITY;

#[test]
fn a_step_up_to_the_longest_without_a_jump_costs_nothing() {
    let scene = scene();
    let from = scene.psi[SLOW - 1];
    for sign in [-1.0, 1.0] {
        let ends = [from + sign * 0.999 * LONGEST_STEP, from + sign * 1.001 * LONGEST_STEP, from + 1000.0 * PI];
        let costs = scene.steps_to(SLOW, STEEP, 0.0, false, &ends);
        assert!(costs[0] == 0.0 && costs[1] > UNPREDICTED_JUMP.deviance() && costs[2] == 0.0, "{costs:?}");
    }
}

#[test]
fn a_jump_that_statics_does_not_predict_costs_more_the_further_it_turns() {
    let scene = scene();
    let from = scene.psi[SLOW - 1];
    for turn in [0.5, -2.0, 3.0] {
        let [cost] = scene.steps_to(SLOW, STEEP, 0.0, false, &[from + turn])[..] else { panic!("one step") };
        assert!(
            (cost - (UNPREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn.abs() / PI)).abs() < 1e-9,
            "{cost} for {turn}"
        );
    }
}

#[test]
fn a_jump_that_statics_predicts_costs_less_than_any_other() {
    let scene = scene();
    let rest = scene.psi[scene.jump];
    // Whether or not the contacts moved.
    for still_m in [0.0, f64::INFINITY] {
        assert_eq!(scene.steps_to(scene.jump, STEEP, still_m, false, &[rest]), [PREDICTED_JUMP.deviance()]);
    }
    assert!(scene.steps_to(scene.jump, STEEP, 0.0, false, &[rest + 3.0])[0] > UNPREDICTED_JUMP.deviance());
}

#[test]
fn a_jump_by_more_than_half_a_turn_is_predicted_though_the_shorter_path_leads_over_a_barrier() {
    // One minimum and one maximum of the potential energy that do not lie opposite each other.
    let shape = SupportFunction::new(SIZE_M, vec![[0.1 * SIZE_M, 0.0], [0.028 * SIZE_M, -0.028 * SIZE_M]]);
    let palms = [PalmPair::hinged(0.7, 1.6); 2];
    let landscape = EnergyLandscape::new(&shape, &palms[0]);
    let [pose] = landscape.stable_poses()[..] else { panic!("one pose") };
    let heights = (0..10_000).map(|i| 2.0 * PI * f64::from(i) / 10_000.0).map(|psi| (landscape.height_m(psi), psi));
    let top = heights.max_by(|a, b| a.0.total_cmp(&b.0)).expect("trials").1;
    let direction = turn(top, pose.psi_rad, TAU);
    let start = top - direction.signum() * 0.12;
    assert!(turn(start, pose.psi_rad, TAU) * direction > 0.0, "the shorter path leads back over the top");
    assert!(is_same_pose(landscape.descend(start), pose.psi_rad, TAU), "the descent is the longer path");
    let scene = Scene { measurements: problem_of(&shape, &palms, &[start; 2]), psi: vec![start; 2], shape, jump: 1 };
    for (off, predicted) in [(0.0, true), (0.99 * SAME_POSE_RAD, true), (1.01 * SAME_POSE_RAD, false)] {
        let end = pose.psi_rad - direction.signum() * off;
        let [cost] = scene.steps_to(1, STEEP, 0.0, false, &[end])[..] else { panic!("one step") };
        assert!(
            if predicted { cost == PREDICTED_JUMP.deviance() } else { cost > UNPREDICTED_JUMP.deviance() },
            "{cost} at {off}"
        );
    }
}

#[test]
fn a_jump_over_a_barrier_costs_its_squared_height_in_units_of_the_shape_error() {
    let scene = scene();
    let (from, end) = (scene.psi[SLOW - 1], scene.psi[SLOW - 1] + 1.0);
    let table = scene.table();
    let height = |psi: f64| table.height_m(&scene.measurements.instants[SLOW], psi);
    let highest = (0..=10_000).map(|i| height(from + f64::from(i) / 10_000.0)).fold(0.0, f64::max);
    let barrier_m = highest - height(from);
    assert!(barrier_m > 1e-4, "{barrier_m}");
    let unpredicted = UNPREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() / PI;
    assert_eq!(scene.steps_to(SLOW, FLAT, 0.0, false, &[end]), [PREDICTED_JUMP.deviance()]);
    for (deviations, expected) in [
        (2.0, PREDICTED_JUMP.deviance() + 4.0),
        (4.0, PREDICTED_JUMP.deviance() + 16.0),
        (5.0, unpredicted),
        (50.0, unpredicted),
    ] {
        let [cost] = scene.steps_to(SLOW, barrier_m / deviations, 0.0, false, &[end])[..] else { panic!("one step") };
        assert!((cost - expected).abs() < 0.05, "{cost} {expected}");
    }
    // Where contacts did not move, a jump over a barrier is preferred to an excluded one up to the cost of that.
    let [cost] = scene.steps_to(SLOW, barrier_m / 20.0, f64::INFINITY, false, &[end])[..] else { panic!("one step") };
    assert!((cost - (PREDICTED_JUMP.deviance() + 400.0)).abs() < 1.0, "{cost}");
}

#[test]
fn a_jump_is_excluded_where_both_contacts_were_seen_not_to_move() {
    let mut scene = scene();
    let end = [scene.psi[SLOW - 1] + 1.0];
    let unpredicted = scene.steps_to(SLOW, STEEP, 0.0, false, &end);
    let [before, after] = [scene.measurements.instants[SLOW - 1], scene.measurements.instants[SLOW]];
    let moved_m = (after.s1 - before.s1).abs().max((after.s2 - before.s2).abs());
    assert_eq!(scene.steps_to(SLOW, STEEP, 1.001 * moved_m, false, &end), [EXCLUDED.deviance()]);
    assert_eq!(scene.steps_to(SLOW, STEEP, 0.999 * moved_m, false, &end), unpredicted);
    for (sample, contact) in [(SLOW - 1, 1), (SLOW - 1, 2), (SLOW, 1), (SLOW, 2)] {
        let seen = scene.measurements.instants[sample];
        let instant = &mut scene.measurements.instants[sample];
        if contact == 1 {
            instant.weight1 = 0.0;
        } else {
            instant.weight2 = 0.0;
        }
        assert_eq!(
            scene.steps_to(SLOW, STEEP, 1.001 * moved_m, false, &end),
            unpredicted,
            "contact {contact} at {sample}"
        );
        scene.measurements.instants[sample] = seen;
    }
}

#[test]
fn a_blind_step_costs_the_same_whatever_statics_predicts() {
    let scene = scene();
    let (rest, from) = (scene.psi[scene.jump], scene.psi[scene.jump - 1]);
    let ends = [from + 0.1, rest, rest + 1.0];
    let expected = [
        0.0,
        PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn(from, rest, TAU).abs() / PI,
        PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn(from, rest + 1.0, TAU).abs() / PI,
    ];
    assert_eq!(scene.steps_to(scene.jump, STEEP, f64::INFINITY, true, &ends), expected);
}

#[test]
fn the_costs_of_steps_go_from_pose_to_pose_in_order() {
    let scene = scene();
    let (shape, table, instant) = (&scene.shape, &scene.table(), &scene.measurements.instants[SLOW]);
    let ahead = Transition {
        shape,
        table,
        instant,
        barrier_sd_m: STEEP,
        still_m: 0.0,
        still_between_turning: false,
        period: TAU,
        work: &scene.measurements.work,
    };
    let choice = |psi: f64| Choice { psi, misfit: 0.0 };
    let psi = scene.psi[SLOW];
    let costs = steps(
        &ahead,
        &scene.measurements.instants[SLOW - 1],
        &[choice(psi), choice(psi + 1.0)],
        &[choice(psi), choice(psi + 1.0), choice(psi + 2.5)],
        true,
    );
    let of = |turn: f64| PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn / PI;
    let expected = [0.0, of(1.0), of(2.5), of(1.0), 0.0, of(1.5)];
    assert!(costs.iter().zip(expected).all(|(cost, expected)| (cost - expected).abs() < 1e-9), "{costs:?}");
}

#[test]
fn an_object_between_crossed_palms_stays_where_it_was() {
    let scene = scene();
    let (before, instant) = (scene.measurements.instants[scene.jump - 1], scene.measurements.instants[scene.jump]);
    let crossed = |instant: &Instant| instant.turned(0.0, -instant.phi2 - 0.1);
    let (shape, table) = (&scene.shape, &scene.table());
    let rest = |before: &Instant, instant: &Instant| {
        Transition {
            shape,
            table,
            instant,
            barrier_sd_m: FLAT,
            still_m: 0.0,
            still_between_turning: false,
            period: TAU,
            work: &scene.measurements.work,
        }
        .rest(before, scene.psi[scene.jump - 1])
    };
    assert!(is_same_pose(rest(&before, &instant), scene.psi[scene.jump], TAU));
    assert_eq!(rest(&before, &crossed(&instant)), scene.psi[scene.jump - 1]);
    assert_eq!(rest(&crossed(&before), &instant), scene.psi[scene.jump - 1]);
}

#[test]
fn the_anchor_is_the_middle_of_the_longest_run_without_a_jump() {
    assert_eq!(anchor(&[0.0, 0.0, 0.0, 1.0, 1.1, 1.2, 1.3, 1.4, 2.0, 2.0], TAU), 5);
    assert_eq!(anchor(&[0.0; 9], TAU), 4);
    assert_eq!(anchor(&[0.0, 0.0, 0.0, 1.0, 2.0], TAU), 1);
    assert_eq!(anchor(&[0.0, 1.0, 2.0, 2.0, 2.0, 2.0 + 1.01 * LONGEST_STEP], TAU), 3);
    assert_eq!(anchor(&[], TAU), 0);
}

#[test]
fn the_spread_of_an_exact_log_is_the_floor() {
    let scene = scene();
    let spread = spread(&scene.measurements, &scene.table(), &scene.psi, FLOOR_M);
    assert_eq!((spread.contact_m2, spread.balance_m2), (FLOOR_M * FLOOR_M, 0.01 * FLOOR_M * FLOOR_M));
    assert!(spread.balance_memory >= 1.0);
}

#[test]
fn the_spread_of_the_contacts_is_the_median_of_those_samples_that_saw_both() {
    let mut scene = scene();
    for (index, instant) in scene.measurements.instants.iter_mut().enumerate() {
        instant.s1 += if index % 2 == 0 { 3e-3 } else { -3e-3 };
        instant.s2 += 8e-3;
        instant.weight2 = 0.5;
    }
    // Fewer than half are far worse; of as many more one contact was not seen.
    scene.measurements.instants[..50].iter_mut().for_each(|instant| instant.s1 += 0.1);
    scene.measurements.instants[50..60].iter_mut().for_each(|instant| (instant.s1, instant.weight2) = (1.0, 0.0));
    let spread = spread(&scene.measurements, &scene.table(), &scene.psi, FLOOR_M);
    // 3 mm and half of 8 mm; the median of χ² with two degrees of freedom is 2 ln 2.
    let expected = 25e-6 / (2.0 * 2f64.ln());
    assert!((spread.contact_m2 / expected - 1.0).abs() < 1e-3, "{} {expected}", spread.contact_m2);
}

#[test]
fn a_burst_in_the_balance_changes_neither_its_spread_nor_its_memory() {
    let scene = scene();
    let table = scene.table();
    let beside = |burst: usize| -> Vec<f64> {
        let off = |index: usize| if index.is_multiple_of(2) { 1e-3 } else { -1e-3 };
        let of =
            |(index, psi): (usize, &f64)| psi + if (SLOW..SLOW + burst).contains(&index) { 0.3 } else { off(index) };
        scene.psi.iter().enumerate().map(of).collect()
    };
    let balance = |psi: &[f64]| -> Vec<f64> {
        let instants = scene.measurements.instants.iter();
        instants.zip(psi).map(|(instant, psi)| table.residuals(instant, *psi).value[2]).collect()
    };
    let (even, burst) = (beside(0), beside(5));
    let [without, with] = [&even, &burst].map(|psi| spread(&scene.measurements, &table, psi, 1e-7));
    let mut squares: Vec<f64> = balance(&even).iter().map(|balance| balance * balance).collect();
    assert!((without.balance_m2 * 0.455 / median(&mut squares) - 1.0).abs() < 1e-9);
    assert!(with.balance_m2 < 1.5 * without.balance_m2, "{with:?} {without:?}");
    assert!(correlation_time(&balance(&burst)) > 3.0, "without clipping the burst counts as correlated");
    assert!(with.balance_memory < 2.0, "{with:?}");
}

#[test]
fn an_unstable_pose_is_penalised_and_a_stable_one_is_not() {
    let scene = ellipse(0.0);
    let (instant, table) = (&scene.measurements.instants[0], scene.table());
    let rest = scene.psi[0];
    // A quarter of a turn on the ellipse is balanced again, at a maximum of the potential energy, for palms that are symmetric.
    let balance = |psi: f64| table.residuals(instant, psi).value[2];
    let (mut low, mut high) = (rest + 0.3, rest + PI - 0.3);
    assert!(balance(low) * balance(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if balance(low) * balance(middle) > 0.0 { low = middle } else { high = middle }
    }
    assert_eq!(instability_cost(&table, instant, low, 1e-6), UNSTABLE_POSE.deviance());
    assert_eq!(instability_cost(&table, instant, rest, 1e-6), 0.0);
    assert_eq!(instability_cost(&table, instant, low + 0.1, 1e-6), 0.0, "out of balance, on its way down");
}

#[test]
fn an_object_that_seems_to_rest_on_a_maximum_is_not_explained() {
    let scene = ellipse(0.0);
    let palms: Vec<PalmPair> = (0..scene.psi.len()).map(|sample| scene.palms(sample)).collect();
    let psi: Vec<f64> = scene
        .psi
        .iter()
        .zip(&palms)
        .map(|(rest, palms)| {
            let landscape = EnergyLandscape::new(&scene.shape, palms);
            let heights =
                (0..20_000).map(|i| rest + PI * f64::from(i) / 20_000.0).map(|psi| (landscape.height_m(psi), psi));
            heights.max_by(|a, b| a.0.total_cmp(&b.0)).expect("trials").1
        })
        .collect();
    let unstable = Scene { measurements: problem_of(&scene.shape, &palms, &psi), psi, ..scene };
    let decoded = decode(&unstable.measurements, &unstable.fit(&unstable.psi), FLOOR_M, None);
    for (misfit, sample) in decoded.misfit.iter().zip(0..) {
        assert!(
            (misfit - UNSTABLE_POSE.deviance()).abs() < 1.0 && decoded.is_ambiguous(sample),
            "{misfit} at {sample}"
        );
    }
}

#[test]
fn no_sample_is_relocated_where_all_are_at_their_true_poses() {
    let scene = scene();
    let decoded = decode(&scene.measurements, &scene.fit(&scene.psi), FLOOR_M, None);
    assert_eq!((decoded.relocated, &decoded.psi), (0, &scene.psi));
    assert!(decoded.misfit.iter().all(|misfit| *misfit < 1.0), "{:?}", decoded.misfit);
    assert!(decoded.margin.iter().all(|margin| *margin > 0.0));
    assert!(!decoded.is_ambiguous(SLOW));
}

#[test]
fn a_sample_at_a_wrong_pose_is_relocated_and_its_margin_is_large() {
    let scene = scene();
    let mut wrong = scene.psi.clone();
    wrong[SLOW] += 1.5;
    let decoded = decode(&scene.measurements, &scene.fit(&wrong), FLOOR_M, None);
    assert_eq!(decoded.relocated, 1);
    for (sample, (found, truth)) in decoded.psi.iter().zip(&scene.psi).enumerate() {
        assert!(turn(*found, *truth, TAU).abs() < 1e-3, "{found} {truth} at {sample}");
    }
    // Any other pose of it costs a jump there and another back.
    assert!(
        decoded.margin[SLOW] > 2.0 * PREDICTED_JUMP.deviance() && !decoded.is_ambiguous(SLOW),
        "{}",
        decoded.margin[SLOW]
    );
    assert!(decoded.misfit[SLOW] < 1.0);
}

#[test]
fn a_sample_near_its_true_pose_is_refined_without_being_relocated() {
    let scene = scene();
    for (off, relocated) in [(0.9 * SAME_POSE_RAD, 0), (1.1 * SAME_POSE_RAD, 1)] {
        let mut beside = scene.psi.clone();
        beside[SLOW] += off;
        let decoded = decode(&scene.measurements, &scene.fit(&beside), FLOOR_M, None);
        assert_eq!(decoded.relocated, relocated, "{off}");
        assert!(turn(decoded.psi[SLOW], scene.psi[SLOW], TAU).abs() < 1e-3, "{}", decoded.psi[SLOW]);
    }
}

#[test]
fn the_motion_is_changed_only_for_a_sufficient_gain() {
    let scene = scene();
    let (table, instant) = (scene.table(), &scene.measurements.instants[SLOW]);
    let mut beside = scene.psi.clone();
    // Far enough to be another pose, near enough to need no jump: the misfit alone decides.
    beside[SLOW] += 0.5 * (SAME_POSE_RAD + LONGEST_STEP);
    let gain = |floor_m: f64| {
        let spread = spread(&scene.measurements, &table, &beside, floor_m);
        let best = candidates(&table, instant, spread, beside[SLOW], TAU)[0];
        assert!(is_same_pose(best.0, scene.psi[SLOW], TAU));
        spread.misfit(&table, instant, beside[SLOW]) - best.1
    };
    for (worth, relocated) in [(1.02 * WORTH_CHANGING, 1), (0.98 * WORTH_CHANGING, 0)] {
        let (mut exact, mut rough) = (1e-5, 0.1);
        for _ in 0..60 {
            let middle = f64::sqrt(exact * rough);
            if gain(middle) > worth { exact = middle } else { rough = middle }
        }
        assert!((gain(exact) - worth).abs() < 1e-3);
        let decoded = decode(&scene.measurements, &scene.fit(&beside), exact, None);
        assert_eq!(decoded.relocated, relocated, "{worth}");
        assert_eq!(decoded.psi[SLOW] == beside[SLOW], relocated == 0);
    }
}

#[test]
fn the_margin_of_a_pose_of_a_symmetric_object_is_the_cost_of_one_jump() {
    let mut scene = ellipse(0.0);
    // Contacts that were seen from sample to sample would exclude the jump.
    scene.measurements.instants.iter_mut().skip(1).step_by(2).for_each(Instant::set_aside);
    let fit = scene.fit(&scene.psi);
    let margins = decode(&scene.measurements, &fit, FLOOR_M, None).margin;
    let anchor = anchor(&scene.psi, TAU);
    for (sample, margin) in margins.iter().enumerate() {
        // All samples on that side of the anchor, which stays where it is, may be turned around together.
        let expected =
            if sample == anchor { f64::INFINITY } else { UNPREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() };
        assert!(*margin == expected || (margin - expected).abs() < 0.1, "{margin} at {sample}");
    }
    // Where transitions are blind to statics, a jump is cheaper.
    let predictive = PredictiveShape::from(&scene.measurements, &fit).expect("a shape");
    let aside = Aside { samples: &[], blind: &|_| true, predictive: &predictive };
    let margins = decode(&scene.measurements, &fit, FLOOR_M, Some(aside)).margin;
    assert!((margins[0] - (PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance())).abs() < 0.1, "{}", margins[0]);
}

#[test]
fn contacts_that_do_not_move_exclude_a_jump_between_palms_at_rest() {
    let scene = scene();
    let (shape, table) = (&scene.shape, &scene.table());
    let before = scene.measurements.instants[SLOW];
    let excluded = |turn_rad: f64, still_between_turning: bool| {
        let after = Instant { phi1: before.phi1 + turn_rad, ..before };
        let ahead = Transition {
            shape,
            table,
            instant: &after,
            barrier_sd_m: STEEP,
            still_m: 1e-6,
            still_between_turning,
            period: TAU,
            work: &scene.measurements.work,
        };
        ahead.still_since(&before)
    };
    // Turning palm 1 by some angle turns palm 2 as well.
    assert!(excluded(0.499 * PALMS_AT_REST_RAD, false) && !excluded(0.501 * PALMS_AT_REST_RAD, false));
    assert!(excluded(2.0 * PALMS_AT_REST_RAD, true));
}

#[test]
fn contacts_that_do_not_move_exclude_a_jump_whatever_the_balance() {
    for off in [0.0, 0.1] {
        let still = ellipse(off);
        let margins = decode(&still.measurements, &still.fit(&still.psi), FLOOR_M, None).margin;
        assert!((margins[0] - EXCLUDED.deviance()).abs() < 1.0, "{} {off}", margins[0]);
    }
}

#[test]
fn a_sample_before_a_jump_that_was_not_seen_may_as_well_be_after_it() {
    let mut scene = scene();
    let at = scene.jump - 1;
    (scene.measurements.instants[at].weight1, scene.measurements.instants[at].weight2) = (0.0, 0.0);
    let decoded = decode(&scene.measurements, &scene.fit(&scene.psi), FLOOR_M, None);
    assert!(
        (0.0..CERTAIN.deviance()).contains(&decoded.margin[at]) && decoded.is_ambiguous(at),
        "{}",
        decoded.margin[at]
    );
    let alternative =
        decoded.alternatives.iter().find(|alternative| alternative.samples.contains(&at)).expect("another motion");
    let other = followed(&scene.shape, &scene.palms(at + 1), &scene.palms(at), scene.psi[at + 1]).0;
    assert!(
        turn(alternative.psi[at], other, TAU).abs() < 1e-2 && !near(alternative.psi[at], scene.psi[at], TAU),
        "{} {other}",
        alternative.psi[at]
    );
    for sample in (0..scene.psi.len()).filter(|&sample| sample != at) {
        assert!(near(alternative.psi[sample], scene.psi[sample], TAU), "the other samples stay: {sample}");
    }
    // A jump as well, but over a small barrier.
    let motion_cost = alternative.motion_cost.expect("that of the decoding");
    assert!(
        (0.0..CERTAIN.deviance()).contains(&motion_cost) && (motion_cost - decoded.margin[at]).abs() < 0.5,
        "{motion_cost}"
    );
}

#[test]
fn a_pose_is_ambiguous_below_a_safe_margin_or_where_nothing_explains_it() {
    let decoded = |margin: f64, misfit: f64| Decoded {
        psi: vec![0.0],
        relocated: 0,
        margin: vec![margin],
        misfit: vec![misfit],
        alternatives: Vec::new(),
    };
    assert!(!decoded(SAFETY * CERTAIN.deviance(), UNEXPLAINED).is_ambiguous(0));
    assert!(decoded(0.99 * SAFETY * CERTAIN.deviance(), UNEXPLAINED).is_ambiguous(0));
    assert!(decoded(SAFETY * CERTAIN.deviance(), 1.01 * UNEXPLAINED).is_ambiguous(0));
}

#[test]
fn samples_set_aside_may_be_wherever_the_predictive_shape_explains_them() {
    let scene = ellipse(0.0);
    let (table, fit) = (scene.table(), scene.fit(&scene.psi));
    let predictive = PredictiveShape::from(&scene.measurements, &fit).expect("a shape");
    let given = |off: f64| vec![Choice { psi: scene.psi[5] + off, misfit: -777.0 }];
    for off in [0.0, 0.5 * SAME_POSE_RAD] {
        let mut choices = vec![given(off); scene.measurements.len()];
        reassociate(
            &mut choices,
            &scene.measurements,
            &table,
            (FLOOR_M, TAU),
            Aside { samples: &[5], blind: &|_| true, predictive: &predictive },
        );
        assert!(choices.iter().enumerate().all(|(index, choices)| index == 5 || choices[0].misfit == -777.0));
        let of = |psi: f64| {
            let instant = &scene.measurements.instants[5];
            predictive.neg_log_predictive(instant, psi) + instability_cost(&table, instant, psi, FLOOR_M)
        };
        assert!(choices[5].iter().all(|choice| (choice.misfit - of(choice.psi)).abs() < 1e-9), "{:?}", choices[5]);
        assert!(turn(choices[5][0].psi, scene.psi[5], TAU).abs() < 0.01, "the given pose is refined");
        let turned =
            choices[5].iter().find(|choice| is_same_pose(choice.psi, scene.psi[5] + PI, TAU)).expect("turned around");
        assert!(turned.misfit > 0.0);
    }
}
