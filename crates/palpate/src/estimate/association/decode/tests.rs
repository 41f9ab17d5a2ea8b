use super::*;
use crate::estimate::association::transitions::LONGEST_STEP;
use crate::estimate::evidence::motion_prior::{EXCLUDED, PER_HALF_TURN, PREDICTED_JUMP, UNPREDICTED_JUMP};
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::log::{Log, Sample};
use crate::mechanics::EnergyLandscape;
use crate::mechanics::frictionless::followed;
use crate::mechanics::passage::SAME_POSE_RAD;
use crate::palms::{PalmMotion, PalmPair};
use crate::shape::NamedShape;
use crate::simulate::{SimulateOptions, simulate};
use std::f64::consts::PI;

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
const CALM: usize = 90;

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

/// An ellipse, which looks the same after half a turn, between palms that turn slowly; its poses lie `off` beside those of rest.
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
        let prior = Prior { size_m: SIZE_M, scale_m: 0.5 * SIZE_M };
        Fit {
            estimate: Estimate { coefficients, psi: psi.to_vec(), cost: 0.0 },
            order,
            noise,
            prior,
            log_evidence: 0.0,
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
        let ahead = Transition { shape, table, instant, barrier_sd_m, still_m };
        let choice = |&psi: &f64| Choice { psi, misfit: 0.0 };
        let (from, ends) = ([choice(&self.psi[to - 1])], ends.iter().map(choice).collect::<Vec<_>>());
        steps(&ahead, &self.measurements.instants[to - 1], &from, &ends, blind)
    }
}

/// A standard deviation of feigned hills with which every hill is too high, and one with which none is.
const STEEP: f64 = 1e-12;

const FLAT: f64 = f64::INFINITY;

#[test]
fn a_step_costs_nothing_up_to_the_longest_that_needs_no_reason() {
    let scene = scene();
    let from = scene.psi[CALM - 1];
    for sign in [-1.0, 1.0] {
        let ends = [from + sign * 0.999 * LONGEST_STEP, from + sign * 1.001 * LONGEST_STEP, from + 1000.0 * PI];
        let costs = scene.steps_to(CALM, STEEP, 0.0, false, &ends);
        assert!(costs[0] == 0.0 && costs[1] > UNPREDICTED_JUMP.deviance() && costs[2] == 0.0, "{costs:?}");
    }
}

#[test]
fn a_leap_that_statics_does_not_foretell_costs_more_the_further_it_turns() {
    let scene = scene();
    let from = scene.psi[CALM - 1];
    for turn in [0.5, -2.0, 3.0] {
        let [cost] = scene.steps_to(CALM, STEEP, 0.0, false, &[from + turn])[..] else { panic!("one step") };
        assert!(
            (cost - (UNPREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn.abs() / PI)).abs() < 1e-9,
            "{cost} for {turn}"
        );
    }
}

#[test]
fn a_fall_that_statics_foretells_costs_less_than_any_leap() {
    let scene = scene();
    let rest = scene.psi[scene.jump];
    // However still the contacts were.
    for still_m in [0.0, f64::INFINITY] {
        assert_eq!(scene.steps_to(scene.jump, STEEP, still_m, false, &[rest]), [PREDICTED_JUMP.deviance()]);
    }
    assert!(scene.steps_to(scene.jump, STEEP, 0.0, false, &[rest + 3.0])[0] > UNPREDICTED_JUMP.deviance());
}

#[test]
fn a_fall_by_more_than_half_a_turn_is_foretold_though_the_shorter_way_leads_over_a_hill() {
    // One minimum and one maximum of the potential energy that do not lie opposite each other.
    let shape = SupportFunction::new(SIZE_M, vec![[0.1 * SIZE_M, 0.0], [0.028 * SIZE_M, -0.028 * SIZE_M]]);
    let palms = [PalmPair::hinged(0.7, 1.6); 2];
    let landscape = EnergyLandscape::new(&shape, &palms[0]);
    let [pose] = landscape.stable_poses()[..] else { panic!("one pose") };
    let heights = (0..10_000).map(|i| 2.0 * PI * f64::from(i) / 10_000.0).map(|psi| (landscape.height_m(psi), psi));
    let top = heights.max_by(|a, b| a.0.total_cmp(&b.0)).expect("trials").1;
    let way = turn(top, pose.psi_rad);
    let start = top - way.signum() * 0.12;
    assert!(turn(start, pose.psi_rad) * way > 0.0, "the shorter way leads back over the top");
    assert!(is_same_pose(landscape.descend(start), pose.psi_rad), "downhill it is the longer way");
    let scene = Scene { measurements: problem_of(&shape, &palms, &[start; 2]), psi: vec![start; 2], shape, jump: 1 };
    for (off, predicted) in [(0.0, true), (0.99 * SAME_POSE_RAD, true), (1.01 * SAME_POSE_RAD, false)] {
        let end = pose.psi_rad - way.signum() * off;
        let [cost] = scene.steps_to(1, STEEP, 0.0, false, &[end])[..] else { panic!("one step") };
        assert!(
            if predicted { cost == PREDICTED_JUMP.deviance() } else { cost > UNPREDICTED_JUMP.deviance() },
            "{cost} at {off}"
        );
    }
}

#[test]
fn a_fall_over_a_hill_that_errors_of_the_shape_feign_costs_its_squared_height_more() {
    let scene = scene();
    let (from, end) = (scene.psi[CALM - 1], scene.psi[CALM - 1] + 1.0);
    let table = scene.table();
    let height = |psi: f64| table.height_m(&scene.measurements.instants[CALM], psi);
    let highest = (0..=10_000).map(|i| height(from + f64::from(i) / 10_000.0)).fold(0.0, f64::max);
    let barrier_m = highest - height(from);
    assert!(barrier_m > 1e-4, "{barrier_m}");
    let unforeseen = UNPREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() / PI;
    assert_eq!(scene.steps_to(CALM, FLAT, 0.0, false, &[end]), [PREDICTED_JUMP.deviance()]);
    for (deviations, expected) in [
        (2.0, PREDICTED_JUMP.deviance() + 4.0),
        (4.0, PREDICTED_JUMP.deviance() + 16.0),
        (5.0, unforeseen),
        (50.0, unforeseen),
    ] {
        let [cost] = scene.steps_to(CALM, barrier_m / deviations, 0.0, false, &[end])[..] else { panic!("one step") };
        assert!((cost - expected).abs() < 0.05, "{cost} {expected}");
    }
    // No hill is too high for statics to be preferred to a miracle, up to its cost.
    let [cost] = scene.steps_to(CALM, barrier_m / 20.0, f64::INFINITY, false, &[end])[..] else { panic!("one step") };
    assert!((cost - (PREDICTED_JUMP.deviance() + 400.0)).abs() < 1.0, "{cost}");
}

#[test]
fn a_leap_is_a_miracle_where_both_contacts_were_seen_to_stay_where_they_were() {
    let mut scene = scene();
    let end = [scene.psi[CALM - 1] + 1.0];
    let unforeseen = scene.steps_to(CALM, STEEP, 0.0, false, &end);
    let [before, after] = [scene.measurements.instants[CALM - 1], scene.measurements.instants[CALM]];
    let moved_m = (after.s1 - before.s1).abs().max((after.s2 - before.s2).abs());
    assert_eq!(scene.steps_to(CALM, STEEP, 1.001 * moved_m, false, &end), [EXCLUDED.deviance()]);
    assert_eq!(scene.steps_to(CALM, STEEP, 0.999 * moved_m, false, &end), unforeseen);
    for (sample, contact) in [(CALM - 1, 1), (CALM - 1, 2), (CALM, 1), (CALM, 2)] {
        let seen = scene.measurements.instants[sample];
        let instant = &mut scene.measurements.instants[sample];
        if contact == 1 {
            instant.weight1 = 0.0
        } else {
            instant.weight2 = 0.0
        }
        assert_eq!(
            scene.steps_to(CALM, STEEP, 1.001 * moved_m, false, &end),
            unforeseen,
            "contact {contact} at {sample}"
        );
        scene.measurements.instants[sample] = seen;
    }
}

#[test]
fn a_blind_step_asks_nothing_of_statics() {
    let scene = scene();
    let (rest, from) = (scene.psi[scene.jump], scene.psi[scene.jump - 1]);
    let ends = [from + 0.1, rest, rest + 1.0];
    let expected = [
        0.0,
        PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn(from, rest).abs() / PI,
        PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() * turn(from, rest + 1.0).abs() / PI,
    ];
    assert_eq!(scene.steps_to(scene.jump, STEEP, f64::INFINITY, true, &ends), expected);
}

#[test]
fn the_costs_of_steps_go_from_pose_to_pose_in_order() {
    let scene = scene();
    let (shape, table, instant) = (&scene.shape, &scene.table(), &scene.measurements.instants[CALM]);
    let ahead = Transition { shape, table, instant, barrier_sd_m: STEEP, still_m: 0.0 };
    let choice = |psi: f64| Choice { psi, misfit: 0.0 };
    let psi = scene.psi[CALM];
    let costs = steps(
        &ahead,
        &scene.measurements.instants[CALM - 1],
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
        Transition { shape, table, instant, barrier_sd_m: FLAT, still_m: 0.0 }.rest(before, scene.psi[scene.jump - 1])
    };
    assert!(is_same_pose(rest(&before, &instant), scene.psi[scene.jump]));
    assert_eq!(rest(&before, &crossed(&instant)), scene.psi[scene.jump - 1]);
    assert_eq!(rest(&crossed(&before), &instant), scene.psi[scene.jump - 1]);
}

#[test]
fn the_anchor_is_the_middle_of_the_longest_run_without_a_leap() {
    assert_eq!(anchor(&[0.0, 0.0, 0.0, 1.0, 1.1, 1.2, 1.3, 1.4, 2.0, 2.0]), 5);
    assert_eq!(anchor(&[0.0; 9]), 4);
    assert_eq!(anchor(&[0.0, 0.0, 0.0, 1.0, 2.0]), 1);
    assert_eq!(anchor(&[0.0, 1.0, 2.0, 2.0, 2.0, 2.0 + 1.01 * LONGEST_STEP]), 3);
    assert_eq!(anchor(&[]), 0);
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
            |(index, psi): (usize, &f64)| psi + if (CALM..CALM + burst).contains(&index) { 0.3 } else { off(index) };
        scene.psi.iter().enumerate().map(of).collect()
    };
    let balance = |psi: &[f64]| -> Vec<f64> {
        let instants = scene.measurements.instants.iter();
        instants.zip(psi).map(|(instant, psi)| table.residuals(instant, *psi).value[2]).collect()
    };
    let (calm, burst) = (beside(0), beside(5));
    let [without, with] = [&calm, &burst].map(|psi| spread(&scene.measurements, &table, psi, 1e-7));
    let mut squares: Vec<f64> = balance(&calm).iter().map(|balance| balance * balance).collect();
    assert!((without.balance_m2 * 0.455 / median(&mut squares) - 1.0).abs() < 1e-9);
    assert!(with.balance_m2 < 1.5 * without.balance_m2, "{with:?} {without:?}");
    assert!(correlation_time(&balance(&burst)) > 3.0, "the burst is one");
    assert!(with.balance_memory < 2.0, "{with:?}");
}

#[test]
fn a_restless_pose_is_penalised_and_a_pose_of_rest_is_not() {
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
    assert_eq!(instability_cost(&table, instant, low + 0.1, 1e-6), 0.0, "on its way down");
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
    let track = decode(&unstable.measurements, &unstable.fit(&unstable.psi), FLOOR_M, None);
    for (misfit, sample) in track.misfit.iter().zip(0..) {
        assert!((misfit - UNSTABLE_POSE.deviance()).abs() < 1.0 && track.doubts(sample), "{misfit} at {sample}");
    }
}

#[test]
fn nothing_is_moved_where_every_sample_is_at_its_pose() {
    let scene = scene();
    let track = decode(&scene.measurements, &scene.fit(&scene.psi), FLOOR_M, None);
    assert_eq!((track.moved, &track.psi), (0, &scene.psi));
    assert!(track.misfit.iter().all(|misfit| *misfit < 1.0), "{:?}", track.misfit);
    assert!(track.margin.iter().all(|margin| *margin > 0.0));
    assert!(!track.doubts(CALM));
}

#[test]
fn a_sample_at_a_wrong_pose_is_moved_back_and_its_margin_told() {
    let scene = scene();
    let mut wrong = scene.psi.clone();
    wrong[CALM] += 1.5;
    let track = decode(&scene.measurements, &scene.fit(&wrong), FLOOR_M, None);
    assert_eq!(track.moved, 1);
    for (sample, (found, truth)) in track.psi.iter().zip(&scene.psi).enumerate() {
        assert!(turn(*found, *truth).abs() < 1e-3, "{found} {truth} at {sample}");
    }
    // No other pose of it is cheaper than a leap there and another back.
    assert!(track.margin[CALM] > 2.0 * PREDICTED_JUMP.deviance() && !track.doubts(CALM), "{}", track.margin[CALM]);
    assert!(track.misfit[CALM] < 1.0);
}

#[test]
fn a_sample_a_little_beside_its_pose_is_placed_more_exactly_without_being_moved() {
    let scene = scene();
    for (off, moved) in [(0.9 * SAME_POSE_RAD, 0), (1.1 * SAME_POSE_RAD, 1)] {
        let mut beside = scene.psi.clone();
        beside[CALM] += off;
        let track = decode(&scene.measurements, &scene.fit(&beside), FLOOR_M, None);
        assert_eq!(track.moved, moved, "{off}");
        assert!(turn(track.psi[CALM], scene.psi[CALM]).abs() < 1e-3, "{}", track.psi[CALM]);
    }
}

#[test]
fn a_way_is_changed_only_for_what_is_worth_it() {
    let scene = scene();
    let (table, instant) = (scene.table(), &scene.measurements.instants[CALM]);
    let mut beside = scene.psi.clone();
    // Far enough to be another pose, near enough to need no leap: the misfit alone decides.
    beside[CALM] += 0.5 * (SAME_POSE_RAD + LONGEST_STEP);
    let gain = |floor_m: f64| {
        let spread = spread(&scene.measurements, &table, &beside, floor_m);
        let best = candidates(&table, instant, spread, beside[CALM])[0];
        assert!(is_same_pose(best.0, scene.psi[CALM]));
        spread.misfit(&table, instant, beside[CALM]) - best.1
    };
    for (worth, moved) in [(1.02 * WORTH_CHANGING, 1), (0.98 * WORTH_CHANGING, 0)] {
        let (mut exact, mut rough) = (1e-5, 0.1);
        for _ in 0..60 {
            let middle = f64::sqrt(exact * rough);
            if gain(middle) > worth { exact = middle } else { rough = middle }
        }
        assert!((gain(exact) - worth).abs() < 1e-3);
        let track = decode(&scene.measurements, &scene.fit(&beside), exact, None);
        assert_eq!(track.moved, moved, "{worth}");
        assert_eq!(track.psi[CALM] == beside[CALM], moved == 0);
    }
}

#[test]
fn the_margin_of_a_pose_of_a_symmetric_object_is_what_one_leap_costs() {
    let scene = ellipse(0.0);
    let fit = scene.fit(&scene.psi);
    let margins = decode(&scene.measurements, &fit, FLOOR_M, None).margin;
    let anchor = anchor(&scene.psi);
    for (sample, margin) in margins.iter().enumerate() {
        // All samples on that side of the anchor, which stays where it is, may be turned around together.
        let expected =
            if sample == anchor { f64::INFINITY } else { UNPREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance() };
        assert!(*margin == expected || (margin - expected).abs() < 0.1, "{margin} at {sample}");
    }
    // Where statics is not asked, a leap is cheaper.
    let known = PredictiveShape::from(&scene.measurements, &fit).expect("a shape");
    let aside = Aside { samples: &[], doubtful: &|_| true, known: &known };
    let margins = decode(&scene.measurements, &fit, FLOOR_M, Some(aside)).margin;
    assert!((margins[0] - (PREDICTED_JUMP.deviance() + PER_HALF_TURN.deviance())).abs() < 0.1, "{}", margins[0]);
}

#[test]
fn no_object_with_still_contacts_leaps_where_the_balance_is_spoilt() {
    let spoilt = ellipse(0.1);
    let margins = decode(&spoilt.measurements, &spoilt.fit(&spoilt.psi), FLOOR_M, None).margin;
    assert!((margins[0] - EXCLUDED.deviance()).abs() < 1.0, "{}", margins[0]);
}

#[test]
fn a_sample_before_a_jump_that_was_not_seen_may_as_well_lie_behind_it() {
    let mut scene = scene();
    let at = scene.jump - 1;
    (scene.measurements.instants[at].weight1, scene.measurements.instants[at].weight2) = (0.0, 0.0);
    let track = decode(&scene.measurements, &scene.fit(&scene.psi), FLOOR_M, None);
    assert!((0.0..CERTAIN.deviance()).contains(&track.margin[at]) && track.doubts(at), "{}", track.margin[at]);
    let alternative =
        track.alternatives.iter().find(|alternative| alternative.samples.contains(&at)).expect("another way");
    let other = followed(&scene.shape, &scene.palms(at + 1), &scene.palms(at), scene.psi[at + 1]).0;
    assert!(
        turn(alternative.psi[at], other).abs() < 1e-2 && !near(alternative.psi[at], scene.psi[at]),
        "{} {other}",
        alternative.psi[at]
    );
    for sample in (0..scene.psi.len()).filter(|&sample| sample != at) {
        assert!(near(alternative.psi[sample], scene.psi[sample]), "the other samples stay: {sample}");
    }
    // A fall as well, but over a little hill.
    assert!(
        (0.0..CERTAIN.deviance()).contains(&alternative.motion_cost)
            && (alternative.motion_cost - track.margin[at]).abs() < 0.5,
        "{}",
        alternative.motion_cost
    );
}

#[test]
fn a_pose_is_doubted_below_twice_the_margin_of_certainty_or_where_nothing_explains_it() {
    let decoded = |margin: f64, misfit: f64| Decoded {
        psi: vec![0.0],
        moved: 0,
        margin: vec![margin],
        misfit: vec![misfit],
        alternatives: Vec::new(),
    };
    assert!(!decoded(2.0 * CERTAIN.deviance(), UNEXPLAINED).doubts(0));
    assert!(decoded(1.99 * CERTAIN.deviance(), UNEXPLAINED).doubts(0));
    assert!(decoded(2.0 * CERTAIN.deviance(), 1.01 * UNEXPLAINED).doubts(0));
}

#[test]
fn samples_set_aside_may_be_wherever_the_known_shape_has_them() {
    let scene = ellipse(0.0);
    let (table, fit) = (scene.table(), scene.fit(&scene.psi));
    let known = PredictiveShape::from(&scene.measurements, &fit).expect("a shape");
    let given = |off: f64| vec![Choice { psi: scene.psi[5] + off, misfit: -777.0 }];
    for off in [0.0, 0.5 * SAME_POSE_RAD] {
        let mut choices = vec![given(off); scene.measurements.len()];
        reassociate(
            &mut choices,
            &scene.measurements,
            &table,
            FLOOR_M,
            Aside { samples: &[5], doubtful: &|_| true, known: &known },
        );
        assert!(choices.iter().enumerate().all(|(index, choices)| index == 5 || choices[0].misfit == -777.0));
        let of = |psi: f64| {
            let instant = &scene.measurements.instants[5];
            known.neg_log_predictive(instant, psi) + instability_cost(&table, instant, psi, FLOOR_M)
        };
        assert!(choices[5].iter().all(|choice| (choice.misfit - of(choice.psi)).abs() < 1e-9), "{:?}", choices[5]);
        assert!(turn(choices[5][0].psi, scene.psi[5]).abs() < 0.01, "the given pose is placed more exactly");
        let turned =
            choices[5].iter().find(|choice| is_same_pose(choice.psi, scene.psi[5] + PI)).expect("turned around");
        assert!(turned.misfit > 0.0);
    }
}
