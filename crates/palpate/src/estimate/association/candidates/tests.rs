use super::*;
use crate::estimate::measurements::Measurements;
use crate::log::{Log, Sample};
use crate::mechanics::EnergyLandscape;
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::TAU;

const SIZE_M: f64 = 0.03;
const COEFFICIENTS: [f64; 7] = [SIZE_M, 2e-3, 3e-3, 1e-3, -1e-3, 1.5e-3, -5e-4];

/// Resolution of the ternary search for a minimum, radians.
fn resolution() -> f64 {
    TAU / TRIALS as f64 * (2.0f64 / 3.0).powi(REFINEMENTS as i32)
}

fn palms() -> PalmPair {
    PalmPair::hinged(0.6, 1.7)
}

fn instant_at(s1: f64, s2: f64) -> Instant {
    Measurements::new(&Log { samples: vec![Sample::new(0.0, palms(), s1, s2)] }, None).instants[0]
}

/// A sample of a shape at an orientation.
fn sample_of(coefficients: &[f64], psi: f64) -> Instant {
    let (s1, s2) = palms().contact_positions_m(&SupportFunction::from_coefficients(coefficients), psi);
    instant_at(s1, s2)
}

fn apart(a: f64, b: f64) -> f64 {
    (0.5 * (a - b)).sin().abs() * 2.0
}

/// Coefficients of a shape with so many equal sides.
fn regular(sides: usize) -> Vec<f64> {
    let mut harmonics = vec![[0.0; 2]; sides];
    harmonics[sides - 1] = [0.5 * SIZE_M / (sides * sides) as f64, 0.0];
    SupportFunction::new(SIZE_M, harmonics).coefficients()
}

#[test]
fn all_minima_of_a_harmonic_are_found_with_their_values_wherever_the_grid_begins() {
    for (waves, start) in [(1, 0.0), (3, 0.0), (3, -2.3), (7, 1e3), (20, 0.77)] {
        let function = |psi: f64| (f64::from(waves) * psi + 0.4).cos();
        let found = minima(start, TAU, &function);
        assert_eq!(found.len(), waves as usize, "{waves} from {start}");
        for (psi, value) in found {
            // At the minima the phase is an odd multiple of π.
            let off = apart(f64::from(waves) * psi + 0.4, std::f64::consts::PI) / f64::from(waves);
            assert!(off < resolution(), "{psi}: {off}");
            assert_eq!(value, function(psi));
        }
    }
}

#[test]
fn a_minimum_at_the_seam_of_the_grid_is_found_once() {
    let found = minima(0.0, TAU, &|psi: f64| -psi.cos());
    assert_eq!(found.len(), 1);
    assert!(apart(found[0].0, 0.0) < resolution(), "{found:?}");
}

#[test]
fn minima_of_different_depth_are_all_found() {
    // The derivative 2 sin 2ψ + 0.6 sin ψ vanishes with a minimum at 0 and one at π.
    let found = minima(0.1, TAU, &|psi: f64| -(2.0 * psi).cos() - 0.6 * psi.cos());
    assert_eq!(found.len(), 2);
    for (minimum, depth) in [(std::f64::consts::PI, -0.4), (0.0, -1.6)] {
        let near = found.iter().find(|(psi, _)| apart(*psi, minimum) < resolution()).expect("found");
        assert!((near.1 - depth).abs() < 1e-6, "{near:?}");
    }
}

#[test]
fn the_misfit_is_quadratic_in_the_contacts_and_logarithmic_in_the_balance() {
    let table = SupportTable::new(&COEFFICIENTS);
    let shape = SupportFunction::from_coefficients(&COEFFICIENTS);
    let psi = 0.8;
    let ((s1, s2), (theta1, theta2)) = (palms().contact_positions_m(&shape, psi), palms().contact_angles(psi));
    let mut instant = instant_at(s1 + 2e-4, s2 - 3e-4);
    (instant.weight1, instant.weight2) = (0.5, 2.0);
    let balance_m = shape.at(theta1).d * palms().phi12_rad().sin() + shape.at(theta2).d * palms().phi1_rad.sin();
    for balance_memory in [1.0, 4.0] {
        let spread = Spread { contact_m2: 1e-8, balance_m2: 4e-8, balance_memory };
        // Contacts: (0.5 · 2e-4)² + (2 · 3e-4)², over 1e-8.
        let expected = 37.0 + 4.0 / balance_memory * (1.0 + balance_m * balance_m / (3.0 * 4e-8)).ln();
        let found = spread.misfit(&table, &instant, psi);
        assert!((found - expected).abs() < 1e-2, "{found} {expected}");
    }
}

#[test]
fn candidates_come_best_first_and_are_limited_in_number() {
    let coefficients = regular(8);
    let (table, spread) =
        (SupportTable::new(&coefficients), Spread { contact_m2: 1e-8, balance_m2: 1e-8, balance_memory: 1.0 });
    let instant = sample_of(&coefficients, 0.3);
    let misfit = |psi: f64| spread.misfit(&table, &instant, psi);
    assert!(minima(0.3, TAU, &misfit).len() > MOST_CANDIDATES);
    let found = candidates(&table, &instant, spread, 0.3, TAU);
    assert_eq!(found.len(), MOST_CANDIDATES);
    assert!(found.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{found:?}");
    assert!(found.iter().all(|(psi, value)| *value == misfit(*psi)));
    // The best of all are among them.
    let mut all: Vec<f64> = minima(0.3, TAU, &misfit).iter().map(|(_, value)| *value).collect();
    all.sort_by(f64::total_cmp);
    assert!(found.iter().zip(&all).all(|(kept, best)| kept.1 == *best));
}

#[test]
fn orientations_missed_by_much_more_than_the_best_are_no_candidates() {
    let (table, instant) = (SupportTable::new(&COEFFICIENTS), sample_of(&COEFFICIENTS, 0.8));
    // Only the contacts count, so that all misfits are inversely proportional to their variance.
    let spread = |contact_m2: f64| Spread { contact_m2, balance_m2: 1e9, balance_memory: 1.0 };
    let mut found = minima(0.8, TAU, &|psi| spread(1.0).misfit(&table, &instant, psi));
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (best, second) = (found[0].1, found[1]);
    let beyond_m2 = second.1 - best;
    for (excess, kept) in [(0.99 * IMPLAUSIBLE, true), (1.01 * IMPLAUSIBLE, false)] {
        let all = candidates(&table, &instant, spread(beyond_m2 / excess), 0.8, TAU);
        assert_eq!(all.iter().any(|(psi, _)| apart(*psi, second.0) < 1e-3), kept, "{excess}: {all:?}");
        assert!(apart(all[0].0, 0.8) < 1e-3);
    }
}

#[test]
fn the_contacts_choose_the_orientation_where_they_determine_it() {
    let instant = sample_of(&COEFFICIENTS, 0.8);
    for nearest in [0.8, 2.5, 4.0, 5.5] {
        let found = best_orientation(&instant, &COEFFICIENTS, nearest, 1e-12);
        assert!(apart(found, 0.8) < 1e-3, "{found} from {nearest}");
    }
}

#[test]
fn of_orientations_that_explain_the_contacts_equally_the_nearest_is_chosen() {
    let coefficients = regular(3);
    let rest = EnergyLandscape::new(&SupportFunction::from_coefficients(&coefficients), &palms()).stable_poses()[0];
    let instant = sample_of(&coefficients, rest.psi_rad);
    for turn in 0..3 {
        let same = rest.psi_rad + TAU / 3.0 * f64::from(turn);
        let found = best_orientation(&instant, &coefficients, same + 0.4, 1e-8);
        assert!(apart(found, same) < 1e-3, "{found} {same}");
    }
}

#[test]
fn of_orientations_that_explain_the_contacts_well_enough_the_balanced_one_is_chosen() {
    let shape = SupportFunction::from_coefficients(&COEFFICIENTS);
    let rest = EnergyLandscape::new(&shape, &palms()).stable_poses()[0].psi_rad;
    let instant = sample_of(&COEFFICIENTS, rest);
    let contacts = |psi: f64| {
        let value = residuals(&instant, &COEFFICIENTS, psi).value;
        value[0] * value[0] + value[1] * value[1]
    };
    let others = minima(rest, TAU, &contacts);
    let (other, _) = others.iter().copied().find(|(psi, _)| apart(*psi, rest) > 0.1).expect("another minimum");
    // Any contact is as good, and the other one is nearer; but it is not balanced.
    let found = best_orientation(&instant, &COEFFICIENTS, other, 1e9);
    assert!(apart(found, rest) < 1e-3, "{found} {rest} {other}");
}
