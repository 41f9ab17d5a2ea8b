use super::*;
use crate::estimate::motion::{ELSEWHERE, common_rotation, moved};
use crate::palms::PalmMotion;
use crate::reconstruct::search::windows::windows;
use crate::shape::SupportFunction;
use crate::simulate::{SimulateOptions, simulate};
use std::f64::consts::TAU;

const SIZE_M: f64 = 0.03;
const ORDER: usize = 3;
const TOLERANCE: Tolerance = Tolerance { scatter_m: 1e-5, scale_m: SIZE_M, balance: [1.0, 1.0] };
const PRIOR: Prior = Prior::new(SIZE_M, 0.5 * SIZE_M);

fn shape() -> SupportFunction {
    SupportFunction::new(SIZE_M, vec![[2e-3, -1e-3], [1.8e-3, 6e-4], [-5e-4, 7e-4]])
}

/// A motion without a jump and without noise, its true orientations, and four windows of it, each joined to the one before.
fn setting() -> (Measurements, Vec<f64>, Vec<Window>) {
    let points = [(0.0, 0.5, 1.9), (3.0, 0.9, 1.2), (6.0, 0.4, 1.5), (9.0, 1.2, 1.4), (12.0, 0.8, 1.9)];
    let motion = PalmMotion::through(&points).and_then(|motion| motion.sample(95.0 / 12.0)).expect("a possible motion");
    let options = SimulateOptions { start_psi_rad: 1.0, ..SimulateOptions::default() };
    let run = simulate(&shape(), &motion, &options).expect("possible");
    assert!(run.jumps.is_empty());
    let measurements = Measurements::new(&run.log, None);
    let windows = windows(&measurements, std::slice::from_ref(&(0..96)), 0.0, 96);
    assert!(windows.len() == 4 && windows.iter().all(|window| window.thin.len() == 24));
    (measurements, run.truth.motion.iter().map(|pose| pose.psi_rad).collect(), windows)
}

fn estimate(psi: &[f64]) -> Estimate {
    Estimate { coefficients: shape().coefficients(), psi: psi.to_vec(), cost: 0.0 }
}

fn problem<'a>(measurements: &'a Measurements, windows: &[Window]) -> Problem<'a> {
    Problem {
        calibration: Calibration::default(),
        measurements: Cow::Borrowed(measurements),
        windows: windows.to_vec(),
        tolerance: TOLERANCE,
        prior: PRIOR,
    }
}

/// A beam search with these windows placed at their true poses, limited to a normalized misfit of 1.
fn beam_search<'a>(
    measurements: &'a Measurements,
    windows: &[Window],
    psi: &[f64],
    placed: Range<usize>,
) -> BeamSearch<'a> {
    let seeds = [estimate(&psi[24 * placed.start..24 * placed.end])];
    let mut beam_search = BeamSearch::new(problem(measurements, windows), (placed, &seeds, ORDER));
    beam_search.largest_misfit = 1.0;
    beam_search
}

/// A beam search without any hypothesis.
fn empty<'a>(measurements: &'a Measurements, windows: &[Window]) -> BeamSearch<'a> {
    BeamSearch::new(problem(measurements, windows), (0..0, &[], ORDER))
}

/// The estimate in a frame that is turned, which is the same object in the same motion.
fn turned(of: &Estimate, angle: f64) -> Estimate {
    let coefficients = SupportFunction::from_coefficients(&of.coefficients).rotated(-angle).coefficients();
    Estimate { coefficients, psi: of.psi.iter().map(|psi| psi + angle).collect(), cost: 0.0 }
}

/// Offsets the readings by alternating signs, which no motion explains.
fn contradict(window: &mut Window, off_m: f64) {
    for (index, instant) in window.thin.instants.iter_mut().enumerate() {
        instant.s1 += if index % 2 == 0 { off_m } else { -off_m };
    }
}

fn score_alone(beam_search: &BeamSearch, placed: &Measurements, proposal: &Estimate) -> Option<(f64, Vec<f64>)> {
    let ranked = beam_search.ranked(placed, vec![proposal.clone()]);
    ranked.first().map(|hypothesis| (hypothesis.score, hypothesis.estimate.psi.clone()))
}

#[test]
fn of_two_hypotheses_equal_up_to_a_rotation_only_one_is_kept() {
    let (measurements, psi, windows) = setting();
    let beam_search = empty(&measurements, &windows);
    let truth = estimate(&psi[..24]);
    for angle in [0.5, 3.0, 7.0] {
        let there = turned(&truth, angle);
        for (instant, (here, there)) in windows[0].thin.instants.iter().zip(
            truth
                .psi
                .iter()
                .map(|psi| (psi, &truth.coefficients))
                .zip(there.psi.iter().map(|psi| (psi, &there.coefficients))),
        ) {
            let [one, other] = [here, there].map(|(psi, coefficients)| residuals(instant, coefficients, *psi).value);
            assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-12), "the same object in the same motion");
        }
        assert_eq!(beam_search.ranked(&windows[0].thin, vec![truth.clone(), there]).len(), 1, "{angle}");
    }
}

#[test]
fn hypotheses_far_behind_the_best_are_dropped() {
    let (measurements, psi, windows) = setting();
    let together = measurements.of(measurements.instants[..48].to_vec());
    let truth = estimate(&psi[..48]);
    let mut wrong = truth.clone();
    wrong.psi[24..].iter_mut().for_each(|psi| *psi += 1.5);
    // The noisier the log, the less a wrong arrangement is behind.
    let with_scatter = |scatter_m: f64| BeamSearch {
        tolerance: Tolerance { scatter_m, ..TOLERANCE },
        ..empty(&measurements, &windows)
    };
    let behind = |scatter_m: f64| {
        let beam_search = with_scatter(scatter_m);
        let [best, other] = [&truth, &wrong].map(|e| score_alone(&beam_search, &together, e).expect("a score").0);
        other - best
    };
    for (worth, kept) in [(0.98 * MOST_BEHIND, 2), (1.02 * MOST_BEHIND, 1)] {
        let (mut exact, mut noisy) = (1e-4, 3e-3);
        assert!(behind(exact) > worth && behind(noisy) < worth);
        for _ in 0..30 {
            let middle = f64::sqrt(exact * noisy);
            if behind(middle) > worth { exact = middle } else { noisy = middle }
        }
        assert!((behind(noisy) - worth).abs() < 0.5, "{}", behind(noisy));
        let ranked = with_scatter(noisy).ranked(&together, vec![wrong.clone(), truth.clone()]);
        assert_eq!(ranked.len(), kept, "{worth}");
        assert!(same_motion(&ranked[0].estimate.psi, &truth.psi, TAU), "the best first");
    }
}

#[test]
fn of_many_distinct_hypotheses_the_best_are_kept() {
    let (measurements, _, windows) = setting();
    let tolerance = Tolerance { scatter_m: 1e-3, ..TOLERANCE };
    let beam_search = BeamSearch { tolerance, ..empty(&measurements, &windows) };
    // Three noisy instants are explained by many motions.
    let few = measurements.of([0, 40, 80].map(|index| measurements.instants[index]).to_vec());
    let angle = |eighths: usize| 1.0 + TAU * eighths as f64 / 8.0;
    let proposals: Vec<Estimate> = (0..64).map(|trial| estimate(&[1.0, angle(trial % 8), angle(trial / 8)])).collect();
    let mut alone: Vec<(f64, Vec<f64>, Estimate)> = proposals
        .into_iter()
        .filter_map(|proposal| score_alone(&beam_search, &few, &proposal).map(|(score, psi)| (score, psi, proposal)))
        .collect();
    alone.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut distinct: Vec<(f64, Vec<f64>)> = Vec::new();
    let mut contenders: Vec<Estimate> = Vec::new();
    for (score, psi, proposal) in alone {
        if !distinct.iter().any(|(_, other)| same_motion(other, &psi, TAU)) && contenders.len() < CONTENDERS {
            distinct.push((score, psi));
            contenders.push(proposal);
        }
    }
    assert!(distinct.len() > BEAM && distinct[BEAM].0 < distinct[0].0 + MOST_BEHIND, "{distinct:?}");
    let ranked = beam_search.ranked(&few, contenders);
    let kept: Vec<(f64, Vec<f64>)> = ranked.into_iter().map(|kept| (kept.score, kept.estimate.psi)).collect();
    assert_eq!(kept, distinct[..BEAM]);
}

#[test]
fn the_window_after_a_placed_one_is_next_before_all_others() {
    let (measurements, _, mut windows) = setting();
    windows[0].path_length_m = 10.0;
    windows[3].joined = false;
    let mut beam_search = empty(&measurements, &windows);
    beam_search.admit(1);
    assert_eq!(beam_search.next(), Some((2, Some(1))));
    beam_search.admit(2);
    assert_eq!(
        beam_search.next(),
        Some((0, Some(1))),
        "then the one before a placed one, though the last one is not joined"
    );
    beam_search.admit(0);
    assert_eq!(beam_search.next(), Some((3, None)));
    beam_search.admit(3);
    assert_eq!(beam_search.next(), None);
}

#[test]
fn of_windows_joined_to_no_placed_one_the_one_with_the_longest_path_is_next() {
    let (measurements, _, mut windows) = setting();
    for (window, path_length_m) in windows.iter_mut().zip([0.1, 0.4, 0.2, 0.3]) {
        (window.joined, window.path_length_m) = (false, path_length_m);
    }
    let mut beam_search = empty(&measurements, &windows);
    assert_eq!(beam_search.next(), Some((1, None)));
    beam_search.deferred[1] = true;
    assert_eq!(beam_search.next(), Some((3, None)), "a deferred window waits");
    beam_search.admit(3);
    assert_eq!(beam_search.next(), Some((2, None)), "a jump separates it from the placed one");
    beam_search.windows[1].joined = true;
    beam_search.admit(0);
    assert_eq!(beam_search.next(), Some((2, None)), "joined, but deferred");
}

#[test]
fn deferred_windows_are_cut_in_two_and_the_others_stay() {
    let (measurements, _, windows) = setting();
    let mut beam_search = empty(&measurements, &windows);
    assert!(!beam_search.split(), "nothing was deferred");
    beam_search.admit(2);
    (beam_search.deferred[1], beam_search.deferred[3]) = (true, true);
    assert!(beam_search.split());
    let ranges: Vec<Range<usize>> = beam_search.windows.iter().map(|window| window.range.clone()).collect();
    assert_eq!(ranges, [0..24, 24..36, 36..48, 48..72, 72..84, 84..96]);
    assert_eq!(beam_search.offset, [None, None, None, Some(0), None, None]);
    assert_eq!(beam_search.deferred, [false; 6], "both halves are tried again");
    assert!(beam_search.windows[2].joined);
}

#[test]
fn windows_too_short_to_cut_are_dropped() {
    let (measurements, _, windows) = setting();
    let mut beam_search = empty(&measurements, &windows);
    for left in [true, true, false] {
        beam_search.deferred.fill(true);
        assert_eq!(beam_search.split(), left, "24, 12 and 6 samples");
    }
    assert!(beam_search.windows.is_empty() && beam_search.offset.is_empty());
}

#[test]
fn windows_are_cut_a_limited_number_of_times() {
    let (measurements, _, _) = setting();
    // One window over all samples, and no hypothesis that could explain any part of it.
    let whole = windows(&measurements, std::slice::from_ref(&(0..96)), 0.0, 24);
    assert_eq!(whole.len(), 1);
    let mut beam_search = empty(&measurements, &whole);
    let mut advances = 0;
    while beam_search.advance(&mut Budget::default()) {
        advances += 1;
    }
    assert_eq!(beam_search.windows.len(), 1 << SPLITS);
    assert_eq!(advances, (1 << (SPLITS + 1)) - 1);
    assert_eq!(beam_search.deferred, [true; 1 << SPLITS]);
}

#[test]
fn a_window_joined_to_a_placed_one_is_followed_without_a_search() {
    let (measurements, psi, windows) = setting();
    for (seed, window, neighbour) in [(0..3, 3, 2), (1..4, 0, 1)] {
        let mut beam_search = beam_search(&measurements, &windows, &psi, seed.clone());
        let mut budget = Budget::default();
        beam_search.place(window, Some(neighbour), &mut budget);
        assert_eq!(budget.left, Budget::default().left);
        assert_eq!((beam_search.offset[window], beam_search.thin.len()), (Some(72), 96));
        let placed = &beam_search.beam[0].estimate.psi;
        let truth = [&psi[24 * seed.start..24 * seed.end], &psi[24 * window..24 * (window + 1)]].concat();
        let turn = common_rotation(placed, &truth, TAU);
        assert!(placed.iter().zip(&truth).all(|(a, b)| (a - b - turn).abs() < 0.01), "{placed:?} {truth:?}");
    }
}

#[test]
fn a_window_joined_to_nothing_is_searched_and_that_is_charged() {
    let (measurements, psi, windows) = setting();
    let mut beam_search = beam_search(&measurements, &windows, &psi, 0..3);
    let mut budget = Budget::default();
    beam_search.place(3, None, &mut budget);
    let mut one_search = Budget::default();
    one_search.charge(1, ORDER);
    assert_eq!(budget.left, one_search.left);
    assert_eq!(beam_search.offset[3], Some(72));
    assert!(same_motion(&beam_search.beam[0].estimate.psi, &psi, TAU));
}

#[test]
fn a_search_returns_a_few_distinct_placements_best_first() {
    let (measurements, psi, windows) = setting();
    let beam_search = beam_search(&measurements, &windows, &psi, 0..3);
    let hypothesis = &beam_search.beam[0].estimate;
    let belief = beam_search.belief(&beam_search.thin, hypothesis).expect("a shape");
    let placements = beam_search.search(&windows[3], hypothesis, &belief);
    assert!((1..=BRANCHES).contains(&placements.len()));
    assert!(placements.windows(2).all(|pair| pair[0].cost <= pair[1].cost));
    for (index, placement) in placements.iter().enumerate() {
        let apart = |other: &Estimate| {
            other.psi.iter().zip(&placement.psi).map(|(a, b)| 1.0 - (a - b).cos()).sum::<f64>() / 24.0
        };
        assert!(placements[..index].iter().all(|other| apart(other) > 1e-3), "the same placement twice");
    }
    let turn = common_rotation(&hypothesis.psi, &psi[..72], TAU);
    assert!(placements[0].psi.iter().zip(&psi[72..]).all(|(a, b)| (0.5 * (a - b - turn)).sin().abs() < 0.02));
}

#[test]
fn a_window_that_nothing_explains_is_deferred_and_changes_nothing_else() {
    let (measurements, psi, mut windows) = setting();
    contradict(&mut windows[3], 5e-3);
    let mut beam_search = beam_search(&measurements, &windows, &psi, 0..3);
    let before = beam_search.beam[0].estimate.clone();
    let mut budget = Budget::default();
    beam_search.place(3, Some(2), &mut budget);
    assert!(beam_search.deferred[3] && beam_search.offset[3].is_none());
    assert_eq!((beam_search.thin.len(), &beam_search.beam[0].estimate.psi), (72, &before.psi));
    assert_eq!(beam_search.beam[0].estimate.coefficients, before.coefficients);
    assert!(budget.left < Budget::default().left, "it was followed and then searched");
}

#[test]
fn a_window_counts_as_explained_up_to_its_share_of_the_largest_misfit() {
    let (measurements, psi, mut windows) = setting();
    contradict(&mut windows[3], 5e-5);
    let placed_at = |largest_misfit: f64| {
        let mut beam_search = beam_search(&measurements, &windows, &psi, 0..3);
        beam_search.largest_misfit = largest_misfit;
        beam_search.place(3, Some(2), &mut Budget::default());
        beam_search
    };
    let placed = placed_at(1e9);
    let best = &placed.beam[0].estimate;
    let there = Estimate { psi: best.psi[72..].to_vec(), ..best.clone() };
    let each = misfit(&windows[3].thin, &there, TOLERANCE.sharp()) / 24.0;
    let normalized_misfit = each / (WINDOW * TOLERANCE.noise_misfit(24, 24));
    assert!(each > 0.0 && each < 2.0 * EXPLAINED, "{each}");
    assert!(placed_at(1.01 * normalized_misfit).offset[3].is_some());
    assert!(placed_at(0.99 * normalized_misfit).deferred[3]);
}

#[test]
fn a_window_missed_by_twice_the_limit_is_deferred_whatever_misfit_is_allowed() {
    let (measurements, psi, mut windows) = setting();
    contradict(&mut windows[3], 1e-3);
    let mut beam_search = beam_search(&measurements, &windows, &psi, 0..3);
    beam_search.largest_misfit = f64::INFINITY;
    beam_search.place(3, Some(2), &mut Budget::default());
    assert!(beam_search.deferred[3]);
}

#[test]
fn the_normalized_misfit_is_the_misfit_per_instant_over_that_of_the_noise() {
    let (measurements, psi, windows) = setting();
    assert!(empty(&measurements, &windows).normalized_misfit().is_infinite());
    let mut beam_search = beam_search(&measurements, &windows, &psi, 1..3);
    assert!(beam_search.normalized_misfit() < 0.1, "{}", beam_search.normalized_misfit());
    beam_search.beam[0].estimate.psi[7] += 0.1;
    let misfit = misfit(&beam_search.thin, &beam_search.beam[0].estimate, TOLERANCE.sharp());
    let expected = misfit / 48.0 / TOLERANCE.noise_misfit(48, 48);
    assert!((beam_search.normalized_misfit() / expected - 1.0).abs() < 1e-12 && expected > 0.1, "{expected}");
}

#[test]
fn growing_stops_above_the_largest_misfit() {
    let (measurements, psi, windows) = setting();
    let mut beam_search = beam_search(&measurements, &windows, &psi, 0..2);
    beam_search.beam[0].estimate.psi[7] += 0.1;
    let normalized_misfit = beam_search.normalized_misfit();
    assert!(!beam_search.grow(&mut Budget::default(), 0.99 * normalized_misfit));
    assert_eq!(beam_search.thin.len(), 48);
    assert!(beam_search.grow(&mut Budget::default(), 1.01 * normalized_misfit.max(1.0)));
    assert_eq!(beam_search.thin.len(), 96);
}

#[test]
fn growing_ends_when_the_budget_is_spent() {
    let (measurements, psi, windows) = setting();
    let mut beam_search = beam_search(&measurements, &windows, &psi, 0..1);
    assert!(beam_search.grow(&mut Budget { left: 0.0 }, 1.0));
    assert_eq!(beam_search.thin.len(), 48, "one window more");
    assert!(beam_search.grow(&mut Budget::default(), 1.0));
    assert_eq!(beam_search.thin.len(), 96);
}

#[test]
fn deferred_windows_are_tried_again_only_when_more_misfit_is_allowed() {
    let (measurements, _, windows) = setting();
    let mut beam_search = empty(&measurements, &windows);
    beam_search.deferred.fill(true);
    assert!(!beam_search.grow(&mut Budget::default(), 1.0), "there is no hypothesis");
    assert_eq!(beam_search.deferred, [false; 4]);
    beam_search.deferred.fill(true);
    assert!(!beam_search.grow(&mut Budget::default(), 1.0));
    assert_eq!(beam_search.deferred, [true; 4]);
}

#[test]
fn placed_windows_are_returned_in_order_of_time() {
    let (measurements, psi, windows) = setting();
    let mut beam_search = empty(&measurements, &windows);
    beam_search.admit(3);
    beam_search.admit(1);
    let placed = [&psi[72..], &psi[24..48]].concat();
    beam_search.beam = vec![Hypothesis { estimate: estimate(&placed), score: 1.0 }];
    let arranged = beam_search.in_order_of_time();
    assert_eq!(arranged.windows.iter().map(|window| window.range.clone()).collect::<Vec<_>>(), [24..48, 72..96]);
    let positions: Vec<usize> = arranged.thin.instants.iter().map(|instant| instant.position as usize).collect();
    assert_eq!(positions, (24..48).chain(72..96).collect::<Vec<_>>());
    assert_eq!(arranged.hypotheses[0].estimate.psi, [&psi[24..48], &psi[72..]].concat());
}

#[test]
fn the_budget_is_charged_by_a_power_of_the_number_of_unknowns_and_spent_at_nothing() {
    let mut budget = Budget { left: 10.0 };
    budget.charge(3, 8);
    assert_eq!(budget.left, 7.0);
    budget.charge(0, 28);
    assert_eq!(budget.left, 7.0);
    // 68 unknowns would be four times as many, and cost eight times as much; 51 are three times as many.
    budget.charge(1, 25);
    assert!((budget.left - (7.0 - 27_f64.sqrt())).abs() < 1e-12, "{}", budget.left);
    budget.charge(2, 8);
    assert!(budget.is_spent() && Budget { left: 0.0 }.is_spent() && !Budget { left: 1e-9 }.is_spent());
    assert!(!Budget::default().is_spent());
    let share = |left: f64| Budget { left }.share_spent();
    assert_eq!((share(BUDGET), share(0.75 * BUDGET), share(-5.0)), (0.0, 0.25, 1.0));
}

#[test]
fn the_misfit_is_the_sum_of_squares_of_contacts_and_balance_alone() {
    let (mut measurements, psi, _) = setting();
    measurements.instants.truncate(2);
    let noise = Noise { sensor_m: 1e-3, balance_m: 1e-4 };
    let truth = estimate(&psi[..2]);
    assert!(misfit(&measurements, &truth, noise) < 1e-12);
    measurements.instants[0].s1 += 2e-3;
    measurements.instants[1].s2 -= 3e-3;
    assert!((misfit(&measurements, &truth, noise) - 13.0).abs() < 1e-6);
    // At another orientation the readings still match, but not the balance.
    let mut other = truth;
    other.psi[1] += 0.7;
    let at = measurements.instants[1];
    let (theta1, theta2) = at.contact_angles(other.psi[1]);
    let balance_m = shape().at(theta1).d * at.palms.sin12 + shape().at(theta2).d * at.palms.sin1;
    let value = residuals(&at, &other.coefficients, other.psi[1]).value;
    let contacts = (value[0] / 1e-3).powi(2) + (value[1] / 1e-3).powi(2);
    let expected = 4.0 + contacts + (balance_m / 1e-4).powi(2);
    assert!((misfit(&measurements, &other, noise) / expected - 1.0).abs() < 1e-9);
    assert!(balance_m.abs() > 1e-4, "{balance_m}");
}

#[test]
fn an_instant_is_explained_within_three_standard_deviations_of_all_its_residuals() {
    let (mut measurements, psi, _) = setting();
    measurements.instants.truncate(3);
    let (noise, truth) = (Noise { sensor_m: 1e-3, balance_m: 1e-4 }, estimate(&psi[..3]));
    assert_eq!(explained(&measurements, &truth, noise), 3);
    measurements.instants[1].s2 += 2.99e-3;
    assert_eq!(explained(&measurements, &truth, noise), 3);
    measurements.instants[1].s1 += 0.3e-3;
    assert_eq!(explained(&measurements, &truth, noise), 2);
}

#[test]
fn the_common_rotation_carries_one_motion_to_the_other_up_to_whole_turns() {
    let a: Vec<f64> = (0..20).map(|index| 0.3 * f64::from(index)).collect();
    for turn in [0.7, -3.0, 3.0] {
        let b: Vec<f64> = a.iter().zip(0..).map(|(a, index)| a - turn + TAU * f64::from(index % 3)).collect();
        assert!((common_rotation(&a, &b, TAU) - turn).abs() < 1e-12, "{turn}");
        assert!(same_motion(&a, &b, TAU) && moved(&a, &b, TAU) == 0);
    }
    // Where the differences are spread, their mean.
    assert!((common_rotation(&[0.1, 0.2, 0.3], &[0.0; 3], TAU) - 0.2).abs() < 1e-12);
}

#[test]
fn samples_count_as_moved_beyond_the_limit() {
    let here = vec![0.4; 1000];
    let angle = ELSEWHERE;
    for (off, count) in [(0.98 * angle, 0), (1.02 * angle, 3), (-0.98 * angle, 0), (-1.02 * angle, 3)] {
        let mut there = here.clone();
        for sample in [10, 20, 900] {
            there[sample] += off;
        }
        assert_eq!(moved(&here, &there, TAU), count, "{off}");
        // Whatever both are turned by.
        there.iter_mut().for_each(|psi| *psi += 2.0);
        assert_eq!(moved(&here, &there, TAU), count, "{off}");
    }
}

#[test]
fn two_motions_are_the_same_up_to_three_degrees() {
    let here = vec![0.0; 100];
    let beside = |off: f64| -> Vec<f64> { (0..100).map(|index| if index % 2 == 0 { off } else { -off }).collect() };
    assert!(same_motion(&here, &beside(3.0f64.to_radians()), TAU));
    assert!(!same_motion(&here, &beside(3.1f64.to_radians()), TAU));
    assert!(same_motion(&[], &[], TAU));
}

#[test]
fn two_trials_are_one_up_to_a_mean_of_one_less_the_cosine() {
    // Of 0.02 and 0 rad it is 1e-4, of 0.06 and 0 rad 9e-4.
    let is_same = differ_by_less_than(1.1e-4);
    assert!(is_same(&[0.0, 1.0], &[0.02, 1.0]) && is_same(&[0.0, 1.0], &[0.02 + TAU, 1.0]));
    assert!(!is_same(&[0.0, 1.0], &[0.06, 1.0]) && !differ_by_less_than(0.9e-4)(&[0.0, 1.0], &[0.02, 1.0]));
}

/// How many instants of the window between two placed ones are explained in steps from the one before it, and from the one after it, where those from the
/// `first` wrong one on (counted from the placed one) are contradicted.
fn reached(first: usize) -> [Option<usize>; 2] {
    let (measurements, psi, windows) = setting();
    [0, 2].map(|placed| {
        let mut windows = windows.clone();
        let mut contradicted = windows[1].clone();
        contradict(&mut contradicted, 0.01);
        for instant in first..24 {
            let instant = if placed == 0 { instant } else { 23 - instant };
            windows[1].thin.instants[instant] = contradicted.thin.instants[instant];
        }
        let beam_search = beam_search(&measurements, &windows, &psi, placed..placed + 1);
        let followed = beam_search.followed(1, Some(placed));
        let best = followed[0].as_ref().expect("a shape");
        assert_eq!(best.explained, first == 24, "{first}");
        best.reached
    })
}

#[test]
fn a_window_is_followed_in_steps_as_far_as_it_is_explained() {
    assert_eq!(reached(24), [None; 2], "explained as a whole");
    // In steps of six, and of two where six are not explained.
    assert_eq!([reached(12), reached(14), reached(15)], [[Some(12); 2], [Some(14); 2], [Some(14); 2]]);
    assert_eq!(reached(1), [None; 2], "not one step");
}

#[test]
fn a_window_is_cut_where_it_is_no_longer_explained_and_its_near_part_is_placed() {
    let (measurements, psi, windows) = setting();
    let placed_part = |placed: usize, wrong: Range<usize>| {
        let mut measurements = measurements.clone();
        let offset = windows[1].range.start;
        for (index, instant) in measurements.instants[offset..][wrong].iter_mut().enumerate() {
            instant.s1 += if index % 2 == 0 { 0.01 } else { -0.01 };
        }
        let windows: Vec<Window> = windows.iter().map(|window| window.of(&measurements)).collect();
        let mut beam_search = beam_search(&measurements, &windows, &psi, placed..placed + 1);
        beam_search.place(1, Some(placed), &mut Budget::default());
        let ranges: Vec<Range<usize>> = beam_search.windows.iter().map(|window| window.range.clone()).collect();
        assert_eq!((ranges.len(), beam_search.offset.len(), beam_search.deferred.len()), (5, 5, 5));
        let placed = (0..5).filter(|&window| beam_search.offset[window].is_some());
        placed.map(|window| ranges[window].clone()).collect::<Vec<_>>()
    };
    assert_eq!(placed_part(0, 14..24), [0..24, 24..38]);
    assert_eq!(placed_part(2, 0..10), [34..48, 48..72]);
}
