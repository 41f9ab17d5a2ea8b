//! The information that a log carries: covariance, weakest direction, errors, and what a reconstruction has learnt.
#![allow(clippy::print_stdout, reason = "shown where a test fails")]

mod reconstruct_support;

use palpate::information::{Information, InformationError, cramer_rao_bound_m, posterior};
use palpate::reconstruct::{Method, Reconstructor, Start};
use palpate::sensor::Rig;
use palpate::shape::{NamedShape, SupportFunction};
use palpate::simulate::Simulation;
use reconstruct_support::{SIZE_M, noisy, turned};

const NOISE_M: f64 = 1e-4;

fn pebble() -> SupportFunction {
    NamedShape::Pebble.shape(SIZE_M).expect("a positive size")
}

fn true_psi(run: &Simulation) -> Vec<f64> {
    run.truth.motion.iter().map(|pose| pose.psi_rad).collect()
}

/// (1, cos θ …, sin θ …)
fn row(order: usize, theta_rad: f64) -> Vec<f64> {
    let angles = (1..=order).map(|k| theta_rad * k as f64);
    std::iter::once(1.0).chain(angles.clone().map(f64::cos)).chain(angles.map(f64::sin)).collect()
}

fn quadratic(covariance: &[f64], row: &[f64]) -> f64 {
    covariance.chunks(row.len()).zip(row).map(|(c, r)| r * c.iter().zip(row).map(|(c, r)| c * r).sum::<f64>()).sum()
}

#[test]
fn the_standard_deviations_are_those_of_the_covariance() {
    let run = turned(&pebble(), 200, noisy(0.0));
    let information = Information::of(&run.log, &pebble(), &true_psi(&run), NOISE_M).expect("determined");
    let (order, covariance) = (information.order(), information.covariance_m2());
    assert_eq!(covariance.len(), (2 * order + 1).pow(2));
    for theta_rad in [0.0, 1.0, 4.0] {
        let sd_m = quadratic(&covariance, &row(order, theta_rad)).sqrt();
        assert!((sd_m / information.r_sd_m(theta_rad) - 1.0).abs() < 1e-9);
    }
    let bound_m = cramer_rao_bound_m(&run.log, &pebble(), &true_psi(&run), NOISE_M);
    assert_eq!(bound_m, Some(information.rms_r_sd_m()));
    let squares: f64 = information.felt_rad().iter().map(|&theta| information.r_sd_m(theta).powi(2)).sum();
    assert!(((squares / information.felt_rad().len() as f64).sqrt() / information.rms_r_sd_m() - 1.0).abs() < 1e-12);
    let first = [covariance[2 * order + 2], covariance[(order + 1) * (2 * order + 2)]];
    let com_m = (0.5 * (first[0] + first[1])).sqrt();
    assert!((com_m / information.center_of_mass_sd_m() - 1.0).abs() < 1e-12);
}

#[test]
fn no_direction_is_known_less_than_the_weakest() {
    let run = turned(&pebble(), 200, noisy(0.0));
    let information = Information::of(&run.log, &pebble(), &true_psi(&run), NOISE_M).expect("determined");
    let covariance = information.covariance_m2();
    let weakest = information.weakest_direction();
    let change = &weakest.change;
    let of = |index: usize| change.harmonics_m().iter().map(move |pair| pair[index]);
    let direction: Vec<f64> = std::iter::once(change.mean_radius_m()).chain(of(0)).chain(of(1)).collect();
    let length_m = direction.iter().map(|value| value * value).sum::<f64>().sqrt();
    assert!((length_m / weakest.sd_m - 1.0).abs() < 1e-9);
    let along = quadratic(&covariance, &direction) / (length_m * length_m);
    assert!((along.sqrt() / weakest.sd_m - 1.0).abs() < 1e-9);
    for index in 0..direction.len() {
        assert!(covariance[index * (direction.len() + 1)].sqrt() <= weakest.sd_m * (1.0 + 1e-9));
    }
}

#[test]
fn what_a_reconstruction_has_learnt_is_what_its_error_bars_say() {
    // An egg is its own mirror image, with its axis anywhere.
    let egg = NamedShape::Egg.shape(SIZE_M).expect("a positive size").rotated(0.6);
    for (shape, mirror) in [(pebble(), false), (egg, true)] {
        let run = turned(&shape, 400, noisy(NOISE_M));
        let found = palpate::reconstruct(&run.log).expect("solvable");
        assert_eq!(found.symmetry.symmetry.mirror, mirror);
        let learnt = posterior(&run.log, &found).expect("determined");
        assert_eq!(learnt.order(), found.shape.harmonics_m().len());
        for point in found.outline.iter().filter(|point| point.touches > 0) {
            let ratio = learnt.r_sd_m(point.theta_rad) / point.r_sd_m;
            assert!((ratio - 1.0).abs() < 0.05, "{} rad: {ratio}", point.theta_rad);
        }
    }
}

#[test]
fn what_the_rig_leaves_open_takes_from_the_information() {
    let run = turned(&pebble(), 400, noisy(NOISE_M));
    let psi = true_psi(&run);
    let rig = Rig::uncalibrated();
    let known = Information::of(&run.log, &pebble(), &psi, NOISE_M).expect("determined");
    let of = |log, rig: &Rig| Information::of_rig(log, &pebble(), &psi, NOISE_M, rig).expect("determined");
    let open = of(&run.log, &rig);
    for degree in 0..360 {
        let theta_rad = f64::from(degree).to_radians();
        assert!(open.r_sd_m(theta_rad) >= known.r_sd_m(theta_rad) * (1.0 - 1e-9), "{degree}");
    }
    assert!(open.rms_r_sd_m() > 1.1 * known.rms_r_sd_m());
    assert_eq!(of(&run.log, &Rig::default()), known);
    // A log is as its rig reads it.
    let drawn = rig.at_stated_size(&rig.drawn(3));
    let other = of(&drawn.distorted(&run.log), &Rig::new(drawn, rig.tolerances));
    let ratio = other.rms_r_sd_m() / open.rms_r_sd_m();
    // Sensitivities are those at constants a hundredth away.
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    // So does what has been learnt with them.
    let read = drawn.distorted(&run.log);
    let found = Reconstructor::new().rig(rig).run(&read).expect("solvable");
    let learnt = posterior(&read, &found).expect("determined");
    for point in found.outline.iter().filter(|point| point.touches > 0) {
        let ratio = learnt.r_sd_m(point.theta_rad) / point.r_sd_m;
        assert!((ratio - 1.0).abs() < 0.05, "{} rad: {ratio}", point.theta_rad);
    }
}

#[test]
fn what_has_no_information_says_why() {
    let run = turned(&pebble(), 40, noisy(0.0));
    let (psi, shape) = (true_psi(&run), pebble());
    let of = |shape: &SupportFunction, psi: &[f64], sd: f64| Information::of(&run.log, shape, psi, sd).map(|_| ());
    assert_eq!(of(&shape, &psi[1..], NOISE_M), Err(InformationError::LengthsDiffer { orientations: 39, samples: 40 }));
    for sd in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(of(&shape, &psi, sd), Err(InformationError::BadNumber { .. })));
    }
    assert!(matches!(of(&shape, &[f64::NAN; 40], NOISE_M), Err(InformationError::BadNumber { .. })));
    let nothing = SupportFunction::new(0.0, Vec::new());
    assert!(matches!(of(&nothing, &psi, NOISE_M), Err(InformationError::BadNumber { .. })));
    let mut blind = run.log.clone();
    blind.samples.iter_mut().for_each(|sample| (sample.s1_m, sample.s2_m) = (None, None));
    assert_eq!(Information::of(&blind, &shape, &psi, NOISE_M).map(|_| ()), Err(InformationError::NotDetermined));
    assert_eq!(
        Information::of(&palpate::Log::default(), &shape, &[], NOISE_M).map(|_| ()),
        Err(InformationError::NotDetermined)
    );
    // Integrated: no noise that anything could be made of, or an answer; never a panic.
    let start = Start::Motion { shape, psi_rad: psi };
    if let Ok(found) = Reconstructor::new().method(Method::Quadrature).start(start).run(&run.log) {
        println!("{:?}", posterior(&run.log, &found).map(|learnt| learnt.rms_r_sd_m()));
    }
}
