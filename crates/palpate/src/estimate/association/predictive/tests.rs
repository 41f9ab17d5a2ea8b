use super::*;
use crate::estimate::model::evidence::Evidence;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, StoppingCriteria};
use crate::estimate::solver::posterior::Posterior;
use crate::log::{Log, Sample};
use crate::palms::PalmPair;
use crate::shape::SupportFunction;
use std::f64::consts::TAU;

const SIZE_M: f64 = 0.03;
const NOISE: Noise = Noise { sensor_m: 2e-4, balance_m: 5e-5 };
/// Of the two harmonics (a0, a1, a2, b1, b2).
const COEFFICIENTS: [f64; 5] = [SIZE_M, 2e-3, 3e-3, -1e-3, 1.5e-3];

/// The spread of the shape is linear between entries of its table: a cosine of K waves to (2πK/1024)²/8, its variance to twice that, 4e-5.
const INTERPOLATED: f64 = 4e-5;

/// A covariance of correlated coefficients.
fn covariance() -> DMatrix<f64> {
    let root = DMatrix::from_fn(5, 5, |i, j| 1e-4 * ((3 * i + 5 * j + i * j) % 7) as f64 - 2e-4);
    &root * root.transpose() + DMatrix::identity(5, 5) * 1e-9
}

fn predictive() -> PredictiveShape {
    PredictiveShape::new(&COEFFICIENTS, &covariance(), NOISE)
}

fn palms() -> PalmPair {
    PalmPair { phi1_rad: 0.5, phi2_rad: 1.3, base1_m: [0.01, -0.02], base2_m: [-0.03, 0.005] }
}

fn instant_of(sample: Sample) -> Instant {
    Measurements::new(&Log { samples: vec![sample] }, None).instants[0]
}

/// What the forward model says of contacts and balance.
fn forward(coefficients: &[f64], psi: f64) -> Vector3<f64> {
    let (shape, palms) = (SupportFunction::from_coefficients(coefficients), palms());
    let (s1, s2) = palms.contact_positions_m(&shape, psi);
    let (theta1, theta2) = palms.contact_angles(psi);
    let balance = shape.at(theta1).d * palms.phi12_rad().sin() + shape.at(theta2).d * palms.phi1_rad.sin();
    Vector3::new(s1, s2, balance)
}

/// −2 ln of the density of what is seen (the contacts that were, then the balance given these) less that of the noise alone.
fn dense_neg_log_predictive(seen: [Option<f64>; 2], weights: [f64; 2], psi: f64) -> f64 {
    let (step, count) = (1e-3, COEFFICIENTS.len());
    let here = forward(&COEFFICIENTS, psi);
    let mut jacobian = DMatrix::zeros(3, count);
    for coefficient in 0..count {
        let mut moved = COEFFICIENTS;
        moved[coefficient] += step;
        jacobian.set_column(coefficient, &((forward(&moved, psi) - here) / step));
    }
    let sds = [NOISE.sensor_m / weights[0], NOISE.sensor_m / weights[1], NOISE.balance_m];
    let noise = DMatrix::from_fn(3, 3, |i, j| if i == j { sds[i] * sds[i] } else { 0.0 });
    let all = &jacobian * covariance() * jacobian.transpose() + noise;
    let rows: Vec<usize> = (0..2).filter(|&contact| seen[contact].is_some()).collect();
    let missed = |contact: usize| here[contact] - seen[contact].expect("seen");
    let contacts = DMatrix::from_fn(rows.len(), rows.len(), |i, j| all[(rows[i], rows[j])]);
    let off = DMatrix::from_fn(rows.len(), 1, |i, _| missed(rows[i]));
    let with_balance = DMatrix::from_fn(rows.len(), 1, |i, _| all[(rows[i], 2)]);
    let inverse = contacts.clone().try_inverse().expect("positive definite");
    let mean = (with_balance.transpose() * &inverse * &off)[(0, 0)];
    let variance = all[(2, 2)] - (with_balance.transpose() * &inverse * &with_balance)[(0, 0)];
    let gaussian = (off.transpose() * &inverse * &off)[(0, 0)] + contacts.determinant().ln();
    let student = 4.0 * (1.0 + (here[2] - mean).powi(2) / (3.0 * variance)).ln() + variance.ln();
    let of_noise: f64 = rows.iter().chain(&[2]).map(|&row| 2.0 * sds[row].ln()).sum();
    gaussian + student - of_noise
}

#[test]
fn the_predictive_density_is_gaussian_in_the_contacts_and_students_t_in_the_balance() {
    let predictive = predictive();
    let (s1, s2) = palms().contact_positions_m(&SupportFunction::from_coefficients(&COEFFICIENTS), 0.7);
    let (s1, s2) = (s1 + 3e-4, s2 - 5e-4);
    let mut instant = instant_of(Sample::new(0.0, palms(), s1, s2));
    (instant.weight1, instant.weight2) = (0.5, 1.5);
    for psi in [0.5, 0.7, 1.1, 4.0] {
        let expected = dense_neg_log_predictive([Some(s1), Some(s2)], [0.5, 1.5], psi);
        let found = predictive.neg_log_predictive(&instant, psi);
        assert!((found - expected).abs() < INTERPOLATED * expected.abs().max(1.0), "{found} {expected} at {psi}");
    }
}

#[test]
fn a_contact_that_was_not_seen_contributes_nothing() {
    let predictive = predictive();
    let (s1, s2) = (0.05, 0.06);
    let one = instant_of(Sample { s2_m: None, ..Sample::new(0.0, palms(), s1, s2) });
    let other = instant_of(Sample { s1_m: None, ..Sample::new(0.0, palms(), s1, s2) });
    for psi in [0.5, 1.1, 4.0] {
        for (instant, seen) in [(one, [Some(s1), None]), (other, [None, Some(s2)])] {
            let expected = dense_neg_log_predictive(seen, [1.0, 1.0], psi);
            let found = predictive.neg_log_predictive(&instant, psi);
            assert!((found - expected).abs() < INTERPOLATED * expected.abs().max(1.0), "{found} {expected} at {psi}");
        }
        // Wherever it may have been.
        assert_eq!(
            predictive.neg_log_predictive(&one, psi),
            predictive.neg_log_predictive(&Instant { s2: 0.01, ..one }, psi)
        );
    }
}

#[test]
fn the_balance_counts_in_full_whatever_its_weight_in_the_fit() {
    let instant = instant_of(Sample::new(0.0, palms(), 0.05, 0.06));
    let without = Instant { balance_weight: 0.0, ..instant };
    assert_eq!(predictive().neg_log_predictive(&instant, 0.7), predictive().neg_log_predictive(&without, 0.7));
}

/// A regular shape with so many sides and a small covariance, and a sample at rest on it.
fn regular(sides: usize) -> (PredictiveShape, Instant, f64) {
    nearly_regular(sides, [0.0; 2])
}

/// The same with these coefficients of its second harmonic added.
fn nearly_regular(sides: usize, second: [f64; 2]) -> (PredictiveShape, Instant, f64) {
    let mut harmonics = vec![[0.0; 2]; sides];
    harmonics[sides - 1] = [0.5 * SIZE_M / (sides * sides) as f64, 0.0];
    let shape = SupportFunction::new(SIZE_M, harmonics);
    let palms = PalmPair::hinged(0.6, 1.7);
    let rest = crate::mechanics::EnergyLandscape::new(&shape, &palms).stable_poses()[0].psi_rad;
    let (s1, s2) = palms.contact_positions_m(&shape, rest);
    let mut coefficients = shape.coefficients();
    coefficients[2] += second[0];
    coefficients[sides + 2] += second[1];
    let covariance = DMatrix::identity(coefficients.len(), coefficients.len()) * 1e-10;
    (PredictiveShape::new(&coefficients, &covariance, NOISE), instant_of(Sample::new(0.0, palms, s1, s2)), rest)
}

#[test]
fn a_symmetric_shape_is_as_likely_after_half_a_turn() {
    let (predictive, instant, rest) = regular(2);
    let (margin, others) = predictive.elsewhere(&instant, rest, TAU);
    assert!(margin.abs() < 1e-3, "{margin}");
    let turned = others.first().copied().expect("another orientation");
    assert!((0.5 * (turned - rest)).cos().abs() < 1e-4, "{turned} {rest}");
}

#[test]
fn the_margin_is_the_difference_between_the_likeliest_other_orientation_and_the_nearest() {
    // Not quite regular, so that the three poses differ.
    let (predictive, instant, rest) = nearly_regular(3, [3e-4, 1e-4]);
    let near_rest = rest + 0.05;
    let (margin, others) = predictive.elsewhere(&instant, near_rest, TAU);
    let neg_log_predictive = |psi: f64| predictive.neg_log_predictive(&instant, psi);
    let scanned = |from: f64, to: f64| {
        let trials =
            (0..=1000).map(|i| from + (to - from) * f64::from(i) / 1000.0).map(|psi| (neg_log_predictive(psi), psi));
        trials.min_by(|a, b| a.0.total_cmp(&b.0)).expect("trials")
    };
    let scan = |from: f64, to: f64| {
        let (coarse, step) = (scanned(from, to).1, (to - from) / 1000.0);
        scanned(coarse - step, coarse + step).0
    };
    let here = scan(rest - 0.1, rest + 0.1);
    let third = std::f64::consts::TAU / 3.0;
    let elsewhere = scan(rest + 0.5 * third, rest + 2.5 * third);
    assert!((margin - (elsewhere - here)).abs() < 1e-3 * margin.abs(), "{margin} {elsewhere} {here}");
    assert!(
        others.windows(2).all(|pair| neg_log_predictive(pair[0]) <= neg_log_predictive(pair[1])),
        "the likeliest first"
    );
    assert!(others.iter().all(|other| !near(*other, near_rest, TAU)));
}

#[test]
fn of_many_other_orientations_the_likeliest_few_are_reported() {
    let (predictive, instant, rest) = regular(7);
    let (margin, others) = predictive.elsewhere(&instant, rest, TAU);
    assert_eq!(others.len(), OTHER_ORIENTATIONS);
    assert!(margin.abs() < 1e-3, "{margin}");
}

#[test]
fn the_predictive_shape_is_the_posterior_of_the_samples() {
    let sample = |index: usize| {
        let palms = PalmPair::hinged(0.5 + 0.05 * index as f64, 1.3);
        let (s1, s2) = palms.contact_positions_m(&SupportFunction::from_coefficients(&COEFFICIENTS), 0.7);
        Sample::new(index as f64, palms, s1, s2)
    };
    let measurements = Measurements::new(&Log { samples: (0..12).map(sample).collect() }, None);
    let estimate = Estimate { coefficients: COEFFICIENTS.to_vec(), psi: vec![0.7; 12], cost: 0.0 };
    let prior = Prior::new(SIZE_M, 0.5 * SIZE_M);
    let mut fit = Fit { estimate, order: 2, noise: NOISE, prior, evidence: Evidence::NONE };
    let predictive = PredictiveShape::from(&measurements, &fit).expect("a shape");
    let information = Smoother::new(&measurements, 2, NOISE, prior).belief(&fit.estimate).expect("finite").information;
    let inverse = information.try_inverse().expect("definite");
    let expected = PredictiveShape::new(&COEFFICIENTS, &inverse, NOISE);
    for psi in [0.5, 1.1, 4.0] {
        let difference = predictive.neg_log_predictive(&measurements.instants[3], psi)
            / expected.neg_log_predictive(&measurements.instants[3], psi)
            - 1.0;
        assert!(difference.abs() < 1e-6, "{difference} at {psi}");
    }
    fit.estimate.coefficients[0] = f64::NAN;
    assert!(PredictiveShape::from(&measurements, &fit).is_none());
}

#[test]
fn a_truncated_root_leaves_out_less_than_allowed_and_no_more_columns_than_it_takes() {
    let effect = |index: usize| index.max(1) as f64;
    let rest = |root: &DMatrix<f64>| {
        let left = covariance() - root * root.transpose();
        (0..5).map(|index| effect(index).powi(2) * left[(index, index)]).sum::<f64>()
    };
    let all = truncated_root(&covariance(), effect, 0.0);
    assert!(rest(&all) < 1e-12 * covariance().trace());
    let least = 0.5 * rest(&all.columns(0, 2).into_owned());
    let some = truncated_root(&covariance(), effect, least);
    assert!(some.ncols() > 2 && some.ncols() < 5 && rest(&some) <= least);
    assert_eq!(some, all.columns(0, some.ncols()).into_owned());
}

#[test]
fn the_misfit_of_a_motion_is_the_cost_of_the_smoother_with_the_shape_as_its_prior() {
    let belief = |information: DMatrix<f64>| Posterior {
        layout: Layout::of_shape(2),
        mean: DVector::from_row_slice(&COEFFICIENTS),
        information,
    };
    let information = covariance().try_inverse().expect("definite");
    // Three instants of another object, and one at which a contact was not seen.
    let other = SupportFunction::from_coefficients(&[1.001 * SIZE_M, 2.02e-3, 2.97e-3, -0.98e-3, 1.51e-3]);
    let (samples, mut psi): (Vec<Sample>, Vec<f64>) = (0..4)
        .map(|index| {
            let palms = PalmPair::hinged(0.5 + 0.1 * f64::from(index), 1.3);
            let rest = crate::mechanics::EnergyLandscape::new(&other, &palms).stable_poses()[0].psi_rad;
            let (s1, s2) = palms.contact_positions_m(&other, rest);
            let sample = Sample::new(f64::from(index), palms, s1, s2);
            (if index == 2 { Sample { s1_m: None, ..sample } } else { sample }, rest + 0.02)
        })
        .unzip();
    let few = Measurements::new(&Log { samples }, None);
    let prior = Prior::new(SIZE_M, 0.5 * SIZE_M);
    let belief = belief(information);
    let smoother = Smoother::with_belief(&few, 2, NOISE, prior, &belief);
    let effort = StoppingCriteria { iterations: 50, tolerance: 0.0 };
    let expected = smoother.run(COEFFICIENTS.to_vec(), psi.clone(), effort);
    let found = predictive().misfit_of_motion(&few.instants, &mut psi, 5).misfit;
    // To second order in the change of the shape.
    assert!((found / expected.cost - 1.0).abs() < 0.02, "{found} {}", expected.cost);
    for (found, expected) in psi.iter().zip(&expected.psi) {
        assert!((found - expected).abs() < 2e-3, "{found} {expected}");
    }
}
