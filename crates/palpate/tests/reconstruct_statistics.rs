//! Error bars against the scatter over repeated noise, and the Cramér-Rao bound against its laws.
#![allow(clippy::print_stdout, reason = "shown where a test fails")]

mod reconstruct_support;

use std::f64::consts::TAU;

use palpate::Log;
use palpate::information::cramer_rao_bound_m;
use palpate::mechanics::EnergyLandscape;
use palpate::reconstruct::{Reconstruction, Reconstructor, Start};
use palpate::shape::{RandomShape, SupportFunction, random_shape};
use palpate::simulate::Simulation;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use reconstruct_support::{SIZE_M, noisy, turned};

const NOISE_M: f64 = 1e-4;
const DRAWS: u64 = 40;

fn pebble() -> SupportFunction {
    random_shape(&RandomShape { mean_radius_m: SIZE_M, order: 5, ..RandomShape::default() }, 4).expect("a valid kind")
}

fn true_psi(run: &Simulation) -> Vec<f64> {
    run.truth.motion.iter().map(|pose| pose.psi_rad).collect()
}

/// Reconstructed from the true shape and motion.
fn from_truth(run: &Simulation, shape: &SupportFunction, harmonics: usize) -> Reconstruction {
    let start = Start::Motion { shape: shape.clone(), psi_rad: true_psi(run) };
    let reconstructor = Reconstructor::new().harmonics(harmonics).sensor_sd_m(NOISE_M).start(start);
    reconstructor.run(&run.log).expect("solvable")
}

/// The run with noise in the contact positions, and with the object a little off its balance, `balance_m` in g.
fn with_noise(run: &Simulation, shape: &SupportFunction, balance_m: f64, seed: u64) -> Simulation {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let mut run = run.clone();
    for (sample, pose) in run.log.samples.iter_mut().zip(&mut run.truth.motion) {
        let slope = EnergyLandscape::new(shape, &sample.palms).balance_slope_m(pose.psi_rad);
        pose.psi_rad += draw(balance_m) / slope;
        let (s1, s2) = sample.palms.contact_positions_m(shape, pose.psi_rad);
        let (theta1, theta2) = sample.palms.contact_angles(pose.psi_rad);
        [pose.com_x_m, pose.com_y_m] = sample.palms.center_of_mass_m(shape.at(theta1), shape.at(theta2));
        (sample.s1_m, sample.s2_m) = (Some(s1 + draw(NOISE_M)), Some(s2 + draw(NOISE_M)));
    }
    run
}

/// Errors of r at the outline, of ψ and of the centre of mass, after the best rotation of the shape over the felt outline.
struct Errors {
    r: Vec<f64>,
    psi: Vec<f64>,
    com: Vec<f64>,
}

fn errors(found: &Reconstruction, shape: &SupportFunction, run: &Simulation) -> Errors {
    // Found in a frame turned by ψ of the first sample, but for a little rotation that least squares takes out.
    let mut turned = run.truth.motion[0].psi_rad;
    for _ in 0..5 {
        let (mut product, mut square) = (0.0, 0.0);
        for point in found.outline.iter().filter(|point| point.touches > 0) {
            let truth = shape.at(point.theta_rad - turned);
            // r' = −d, and a larger `turned` is a smaller angle.
            product += (point.r_m - truth.r) * truth.d;
            square += truth.d * truth.d;
        }
        turned += product / square;
    }
    let wrapped = |angle: f64| (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
    let poses = || found.motion.iter().zip(&run.truth.motion);
    Errors {
        r: found.outline.iter().map(|point| point.r_m - shape.at(point.theta_rad - turned).r).collect(),
        psi: poses().map(|(found, truth)| wrapped(found.psi_rad + turned - truth.psi_rad)).collect(),
        com: poses().map(|(f, t)| (f.com_x_m - t.com_x_m).hypot(f.com_y_m - t.com_y_m) / 2f64.sqrt()).collect(),
    }
}

#[test]
fn error_bars_are_the_scatter_over_repeated_noise() {
    let shape = pebble();
    let run = turned(&shape, 600, noisy(0.0));
    let (mut r, mut psi, mut com) = (Vec::new(), Vec::new(), Vec::new());
    for draw in 0..DRAWS {
        let run = with_noise(&run, &shape, 0.3 * NOISE_M, draw);
        let found = from_truth(&run, &shape, 6);
        let errors = errors(&found, &shape, &run);
        let mean_square = |pairs: Vec<(f64, f64)>| {
            pairs.iter().map(|(error, sd)| (error / sd).powi(2)).sum::<f64>() / pairs.len() as f64
        };
        let outline = found.outline.iter().zip(&errors.r).filter(|(point, _)| point.touches > 0);
        r.push(mean_square(outline.map(|(point, error)| (*error, point.r_sd_m)).collect()));
        psi.push(mean_square(found.motion.iter().zip(&errors.psi).map(|(pose, e)| (*e, pose.psi_sd_rad)).collect()));
        com.push(mean_square(found.motion.iter().zip(&errors.com).map(|(pose, e)| (*e, pose.com_sd_m)).collect()));
    }
    for (what, ratios) in [("r", &r), ("psi", &psi), ("com", &com)] {
        let mean = ratios.iter().sum::<f64>() / DRAWS as f64;
        let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
        let sd_of_mean = (variance / DRAWS as f64).sqrt();
        println!("{what}: mean square of error / stated sd {mean:.3} +- {sd_of_mean:.3}");
    }
    for (what, ratios) in [("r", r), ("psi", psi), ("com", com)] {
        let mean = ratios.iter().sum::<f64>() / DRAWS as f64;
        let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (DRAWS - 1) as f64;
        let sd_of_mean = (variance / DRAWS as f64).sqrt();
        // Draws are independent: their mean is 1 to within 3.5 of its own standard deviations, and that is a sharp test.
        assert!(sd_of_mean < 0.12, "{what}: {sd_of_mean}");
        assert!((mean - 1.0).abs() < 3.5 * sd_of_mean + 0.05, "{what}: {mean} +- {sd_of_mean}");
    }
}

fn repeated(run: &Simulation, times: usize) -> (Log, Vec<f64>) {
    // There and back, so that nothing leaps where the copies meet.
    let there_and_back = |index: usize| {
        let mut samples = run.log.samples.clone();
        let mut psi = true_psi(run);
        if index % 2 == 1 {
            samples.reverse();
            psi.reverse();
        }
        (samples, psi)
    };
    let (mut log, mut psi) = (Log::default(), Vec::new());
    for index in 0..times {
        let (samples, orientations) = there_and_back(index);
        log.samples.extend(samples);
        psi.extend(orientations);
    }
    (log, psi)
}

#[test]
fn the_cramer_rao_bound_halves_with_the_noise_and_with_four_times_the_samples() {
    for samples in [160, 40] {
        let run = turned(&pebble(), samples, noisy(0.0));
        let bound = |log: &Log, psi: &[f64], sd: f64| cramer_rao_bound_m(log, &pebble(), psi, sd).expect("determined");
        let one = bound(&run.log, &true_psi(&run), NOISE_M);
        assert!(one < NOISE_M, "{one}");
        let half = bound(&run.log, &true_psi(&run), 0.5 * NOISE_M);
        assert!((one / half - 2.0).abs() < 1e-3, "{one} {half}");
        let (log, psi) = repeated(&run, 4);
        let four = bound(&log, &psi, NOISE_M);
        assert!((one / four - 2.0).abs() < 1e-3, "{one} {four}");
    }
}

#[test]
fn the_cramer_rao_bound_is_the_datas_own_where_little_was_felt() {
    // A sixth of the motion: parts of the shape are known badly. No belief about shapes may mend that.
    let mut run = turned(&pebble(), 240, noisy(0.0));
    run.log.samples.truncate(40);
    run.truth.motion.truncate(40);
    let bound = |sd: f64| cramer_rao_bound_m(&run.log, &pebble(), &true_psi(&run), sd).expect("determined");
    let (one, half) = (bound(NOISE_M), bound(0.5 * NOISE_M));
    println!("{one} {half}");
    assert!((one / half - 2.0).abs() < 1e-3, "{one} {half}");
}

#[test]
fn no_estimate_beats_the_cramer_rao_bound() {
    let shape = pebble();
    let run = turned(&shape, 160, noisy(0.0));
    let bound = cramer_rao_bound_m(&run.log, &shape, &true_psi(&run), NOISE_M).expect("determined");
    let squares: Vec<f64> = (0..DRAWS)
        .map(|draw| {
            let run = with_noise(&run, &shape, 0.0, 1000 + draw);
            let found = from_truth(&run, &shape, 5);
            let felt: Vec<bool> = found.outline.iter().map(|point| point.touches > 0).collect();
            let errors = errors(&found, &shape, &run).r;
            let felt = errors.iter().zip(felt).filter(|(_, felt)| *felt).map(|(error, _)| error * error);
            let felt: Vec<f64> = felt.collect();
            felt.iter().sum::<f64>() / felt.len() as f64
        })
        .collect();
    let rms = (squares.iter().sum::<f64>() / DRAWS as f64).sqrt();
    println!("rms {rms}, bound {bound}");
    // About 10 unknowns and 40 draws: the RMS scatters by some 4 %.
    assert!((0.85..1.15).contains(&(rms / bound)), "{rms} {bound}");
}

#[test]
fn a_motion_of_another_length_or_no_noise_has_no_bound() {
    let run = turned(&pebble(), 40, noisy(0.0));
    let psi = true_psi(&run);
    assert_eq!(cramer_rao_bound_m(&run.log, &pebble(), &psi[1..], NOISE_M), None);
    for sd in [0.0, -1.0, f64::NAN] {
        assert_eq!(cramer_rao_bound_m(&run.log, &pebble(), &psi, sd), None);
    }
}
