//! `cargo bench -p palpate-bench`: seconds for a whole reconstruction, for smoothing alone and for the forward model, on one
//! thread.

use divan::{Bencher, black_box};
use palpate::palms::PalmPair;
use palpate::shape::NamedShape;
use palpate::statics::EnergyLandscape;
use palpate_bench::{Failure, Scene, from_nothing, from_truth, on_one_thread};

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
}
