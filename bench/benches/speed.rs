//! `cargo bench -p palpate-bench`: seconds for a whole reconstruction, for smoothing alone, for the forward model, for what they
//! are made of, and for reading and writing logs, on one thread.

use divan::{Bencher, black_box};
use palpate::mechanics::EnergyLandscape;
use palpate::palms::PalmPair;
use palpate::shape::NamedShape;
use palpate_bench::{
    Failure, Scene, equations, from_nothing, from_truth, normal_equations, on_one_thread, with_harmonics,
};
use palpate_io::{log_csv, parse_log};

fn main() -> Result<(), Failure> {
    on_one_thread(divan::main)
}

/// The whole reconstruction, from nothing; without jumps the aim is well under a second.
mod reconstruct {
    use super::*;

    #[divan::bench(sample_count = 5, sample_size = 1)]
    fn without_jumps_900_samples(bencher: Bencher) {
        let felt = Scene::without_jumps(900).and_then(|scene| scene.felt()).expect("the scene is sound");
        bencher.bench_local(|| from_nothing(black_box(&felt)).expect("the log can be solved"));
    }

    #[divan::bench(sample_count = 2, sample_size = 1)]
    fn with_jumps_900_samples(bencher: Bencher) {
        let felt = Scene::with_jumps(900).and_then(|scene| scene.felt()).expect("the scene is sound");
        bencher.bench_local(|| from_nothing(black_box(&felt)).expect("the log can be solved"));
    }
}

/// Smoothing alone, from the truth, and all that makes a result of it.
#[divan::bench(args = [300, 1_000, 10_000, 100_000], sample_count = 3, sample_size = 1)]
fn smooth(bencher: Bencher, samples: usize) {
    let scene = Scene::without_jumps(samples).expect("the scene is sound");
    let felt = scene.felt().expect("the scene is sound");
    bencher.bench_local(|| from_truth(black_box(&scene), black_box(&felt)).expect("the log can be solved"));
}

/// The normal equations of 10 000 samples by the number of harmonics: set up, and solved once.
#[divan::bench(args = [8, 16, 32], sample_count = 10, sample_size = 1)]
fn normal_equations_10_000_samples(bencher: Bencher, harmonics: usize) {
    let scene = Scene::without_jumps(10_000).expect("the scene is sound");
    let felt = scene.felt().expect("the scene is sound");
    let shape = with_harmonics(&scene.shape, harmonics);
    bencher
        .bench_local(|| normal_equations(black_box(&shape), black_box(&felt)).expect("the log determines the shape"));
}

/// The paper's equations, from given initial values, after smoothing.
#[divan::bench]
fn paper_equations_900_samples(bencher: Bencher) {
    let scene = Scene::without_jumps(900).expect("the scene is sound");
    let felt = scene.felt().expect("the scene is sound");
    let (equations, (r1_m, r2_m)) = equations(&scene, &felt).expect("the log can be integrated");
    bencher.bench_local(|| equations.integrate(black_box(r1_m), black_box(r2_m)));
}

/// The forward model.
mod forward {
    use super::*;

    #[divan::bench(args = [900, 10_000], sample_count = 5)]
    fn simulate(bencher: Bencher, samples: usize) {
        let scene = Scene::without_jumps(samples).expect("the scene is sound");
        bencher.bench_local(|| black_box(&scene).felt().expect("the scene is sound"));
    }

    #[divan::bench]
    fn stable_poses(bencher: Bencher) {
        let shape = NamedShape::Pebble.shape(0.03).expect("the pebble has a shape");
        let palms = PalmPair::hinged(0.7, 1.6);
        bencher.bench_local(|| EnergyLandscape::new(black_box(&shape), black_box(&palms)).stable_poses());
    }

    #[divan::bench(args = [8, 16, 32])]
    fn landscape(bencher: Bencher, harmonics: usize) {
        let shape = with_harmonics(&NamedShape::Pebble.shape(0.03).expect("the pebble has a shape"), harmonics);
        let palms = PalmPair::hinged(0.7, 1.6);
        bencher.bench_local(|| EnergyLandscape::new(black_box(&shape), black_box(&palms)));
    }

    #[divan::bench(args = [8, 16, 32])]
    fn support_function(bencher: Bencher, harmonics: usize) {
        let shape = with_harmonics(&NamedShape::Pebble.shape(0.03).expect("the pebble has a shape"), harmonics);
        bencher.bench_local(|| black_box(&shape).at(black_box(1.234)));
    }
}

/// Logs of 10 000 samples as text.
mod text {
    use super::*;

    #[divan::bench(sample_count = 10)]
    fn parse(bencher: Bencher) {
        let log = Scene::without_jumps(10_000).and_then(|scene| scene.felt()).expect("the scene is sound").log;
        let text = log_csv(&log);
        bencher.bench_local(|| parse_log("bench.csv", black_box(text.as_bytes())).expect("it was written well"));
    }

    #[divan::bench(sample_count = 10)]
    fn write(bencher: Bencher) {
        let log = Scene::without_jumps(10_000).and_then(|scene| scene.felt()).expect("the scene is sound").log;
        bencher.bench_local(|| log_csv(black_box(&log)));
    }
}
