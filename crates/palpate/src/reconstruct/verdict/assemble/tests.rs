use super::*;
use crate::estimate::coverage::LONGEST_SLIDE;
use crate::log::Sample;
use crate::palms::PalmPair;

/// So many samples that saw both contacts, the palms at rest.
fn measurements(count: usize) -> Measurements {
    let palms = PalmPair::hinged(0.5, 1.9);
    let samples = (0..count).map(|index| Sample::new(index as f64, palms, 0.03, 0.04)).collect();
    Measurements::new(&Log { samples }, None)
}

fn set(instant: &mut Instant, weight1: f64, weight2: f64) {
    (instant.weight1, instant.weight2) = (weight1, weight2);
}

#[test]
fn chi_squared_is_the_weighted_sum_of_squares_per_degree_of_freedom() {
    let mut measurements = measurements(3);
    set(&mut measurements.instants[1], 0.5, 2.0);
    let left = [(Some(2e-4), Some(-1e-4)), (Some(4e-4), Some(5e-5)), (Some(3e-4), Some(0.0))];
    let (chi2, dof) = chi2(&measurements, &left, 1e-4, 2);
    // Squares in units of 1e-4 m: 4 + 1, (0.5·4)² + (2·0.5)², 9 + 0; six readings less two unknowns.
    assert_eq!(dof, 4.0);
    assert!((chi2 - 19.0 / 4.0).abs() < 1e-12, "{chi2}");
}

#[test]
fn a_contact_that_was_not_seen_is_no_degree_of_freedom() {
    let left = [(Some(2e-4), None), (None, Some(1e-4)), (None, None), (Some(1e-4), Some(1e-4))];
    let (chi2, dof) = chi2(&measurements(4), &left, 1e-4, 1);
    assert_eq!(dof, 3.0);
    assert!((chi2 - 7.0 / 3.0).abs() < 1e-12, "{chi2}");
}

#[test]
fn there_is_at_least_one_degree_of_freedom() {
    let left = [(Some(2e-4), Some(0.0))];
    for unknowns in [1, 2, 9] {
        let (chi2, dof) = chi2(&measurements(1), &left, 1e-4, unknowns);
        assert_eq!(dof, 1.0, "{unknowns} unknowns");
        assert!((chi2 - 4.0).abs() < 1e-12, "{chi2}");
    }
}

/// Contact angles of a motion along which both contacts slide evenly by this much per sample, and the second one the other way.
fn sliding(count: usize, step: f64) -> Vec<(f64, f64)> {
    (0..count).map(|index| (step * index as f64, 10.0 - step * index as f64)).collect()
}

#[test]
fn a_path_continues_over_slides_up_to_the_longest_and_breaks_at_longer_ones() {
    let measurements = measurements(8);
    let unbroken = contact_paths(&measurements, &sliding(8, 0.999 * LONGEST_SLIDE), &[]);
    assert_eq!(unbroken.iter().map(Vec::len).collect::<Vec<_>>(), [8, 8]);
    let broken = contact_paths(&measurements, &sliding(8, 1.001 * LONGEST_SLIDE), &[]);
    assert_eq!(broken.iter().map(Vec::len).collect::<Vec<_>>(), [1; 16]);
}

#[test]
fn a_path_ends_where_a_segment_begins() {
    let paths = contact_paths(&measurements(20), &sliding(20, 0.01), &[8]);
    let angles = sliding(20, 0.01);
    let (first, second): (Vec<f64>, Vec<f64>) = angles.into_iter().unzip();
    assert_eq!(paths, [&first[..8], &first[8..], &second[..8], &second[8..]]);
}

#[test]
fn short_segments_feel_nothing() {
    // Five samples between two jumps are too few, six are not.
    for (starts, felt) in [([8, 13], 15), ([8, 14], 20)] {
        let paths = contact_paths(&measurements(20), &sliding(20, 0.01), &starts);
        assert_eq!(paths.iter().map(Vec::len).sum::<usize>(), 2 * felt, "{starts:?}");
    }
}

#[test]
fn a_contact_that_was_not_seen_feels_nothing_and_the_other_one_goes_on() {
    let mut measurements = measurements(10);
    set(&mut measurements.instants[4], 0.0, 1.0);
    let paths = contact_paths(&measurements, &sliding(10, 0.01), &[]);
    assert_eq!(paths.iter().map(Vec::len).collect::<Vec<_>>(), [9, 10]);
    assert!(!paths[0].contains(&sliding(10, 0.01)[4].0));
}

#[test]
fn the_centre_of_mass_of_another_orientation_is_elsewhere() {
    let instant = measurements(1).instants[0];
    let disc = SupportFunction::new(0.03, Vec::new());
    assert!(center_elsewhere_m(&instant, &disc, 0.3, 1.0) < 1e-12, "of a disc about its middle it stays");
    let shape = crate::shape::ellipse(0.03, 0.024).expect("possible");
    assert_eq!(center_elsewhere_m(&instant, &shape, 0.3, 0.0), 0.0);
    let center_m = |psi: f64| {
        let palms = PalmPair::hinged(0.5, 1.9);
        let (theta1, theta2) = palms.contact_angles(psi);
        palms.center_of_mass_m(shape.at(theta1), shape.at(theta2))
    };
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let expected = apart(center_m(0.3), center_m(-0.2)).max(apart(center_m(0.3), center_m(0.8)));
    assert!((center_elsewhere_m(&instant, &shape, 0.3, 0.5) - expected).abs() < 1e-12);
}
