//! Log in, shape, motion and centre of mass out.
//!
//! [`reconstruct`] runs: starts from nothing (`start`, on the closed forms of `quadrature`), maximum likelihood over all
//! samples (`smooth`), what the data say of noise and number of harmonics (`evidence`), error bars (`posterior`) and the
//! verdict (`certificate`).

mod assemble;
mod certificate;
mod evidence;
mod felt;
mod jumps;
mod noise;
mod options;
mod posterior;
mod problem;
mod quadrature;
mod reconstruction;
mod residuals;
mod smooth;
mod start;

pub use options::{Progress, ReconstructError, ReconstructOptions};
pub use reconstruction::{OutlinePoint, Pose, Reconstruction};

use crate::log::Log;
use assemble::{Expected, assemble};
use evidence::{Fit, Freedom, choose_order, fit};
use problem::Problem;
use smooth::{Effort, Estimate, Noise, Prior, Smoother};

/// Fewest samples with both contacts seen that are tried.
pub const FEWEST_SAMPLES: usize = 12;

/// Most harmonics that a user may ask for.
pub const MOST_HARMONICS: usize = 64;

/// Samples that the search for a start works on; a longer log is thinned to about this many.
const SEARCH_SAMPLES: usize = 250;

/// Samples that the choice of the number of harmonics works on.
const ORDER_SAMPLES: usize = 450;

/// Harmonics of the search for a start.
const SEARCH_ORDER: usize = 8;

/// Reconstructs shape, motion and centre of mass from a palm log and nothing else.
///
/// `progress` is called now and then from any thread. The result does not depend on the number of threads.
///
/// # Errors
/// When the log cannot be solved at all (see [`ReconstructError`]). A doubtful answer is not an error: it comes back as a
/// [`Reconstruction`] that is not certified.
pub fn reconstruct(
    log: &Log,
    options: &ReconstructOptions,
    progress: &(dyn Fn(Progress) + Sync),
) -> Result<Reconstruction, ReconstructError> {
    let tell = |stage, fraction| progress(Progress { stage, fraction });
    check(log, options)?;
    let stated_m = options.sensor_sd_m.or_else(|| stated_noise_m(log));
    let problem = Problem::new(log, stated_m);
    let scatter_m = noise::contact_scatter_m(&problem);
    let size_m = problem.size_m();
    let prior = Prior { size_m, scale_m: 0.5 * size_m };

    tell("searching for a start", 0.0);
    let thin = problem.thinned(SEARCH_SAMPLES);
    let candidates = candidates(&thin, scatter_m, prior);
    let best = candidates.first().ok_or_else(|| ReconstructError::NoStart {
        advice: "check the units and signs of the palm angles and contact positions".to_owned(),
    })?;

    tell("choosing the number of harmonics", 0.4);
    let freedom = Freedom { sensor: true, floor_m: 1e-6 * size_m };
    let medium = problem.thinned(ORDER_SAMPLES);
    let start = Estimate {
        coefficients: best.coefficients.clone(),
        psi: interpolate(&thin, &best.psi, &medium),
        cost: f64::INFINITY,
    };
    let noise = Noise { sensor_m: scatter_m.max(1e-3 * size_m), balance_m: scatter_m.max(1e-3 * size_m) };
    let coarse = match options.harmonics {
        Some(order) => fit(&medium, order, start, noise, prior, freedom, 4),
        None => choose_order(&medium, start, noise, prior, freedom),
    }
    .ok_or(ReconstructError::NotSolvable)?;

    tell("smoothing all samples", 0.7);
    let start = Estimate {
        coefficients: coarse.estimate.coefficients.clone(),
        psi: interpolate(&medium, &coarse.estimate.psi, &problem),
        cost: f64::INFINITY,
    };
    let noise = Noise { sensor_m: stated_m.unwrap_or(coarse.noise.sensor_m), ..coarse.noise };
    let freedom = Freedom { sensor: stated_m.is_none(), ..freedom };
    let fine =
        fit(&problem, coarse.order, start, noise, coarse.prior, freedom, 4).ok_or(ReconstructError::NotSolvable)?;

    tell("weighing alternatives", 0.9);
    let alternatives = count_alternatives(&thin, &candidates, &coarse);
    let expected = Expected { stated_m, scatter_m };
    let result = assemble(log, &problem, fine, expected, alternatives).ok_or(ReconstructError::NotSolvable)?;
    tell("done", 1.0);
    Ok(result)
}

fn check(log: &Log, options: &ReconstructOptions) -> Result<(), ReconstructError> {
    if let Some(order) = options.harmonics
        && !(2..=MOST_HARMONICS).contains(&order)
    {
        let text = format!("the number of harmonics must be from 2 to {MOST_HARMONICS}, not {order}");
        return Err(ReconstructError::BadOption(text));
    }
    if let Some(sd) = options.sensor_sd_m
        && !(sd > 0.0 && sd.is_finite())
    {
        let text = format!("the standard deviation of the sensors must be a positive number of metres, not {sd}");
        return Err(ReconstructError::BadOption(text));
    }
    for (index, sample) in log.samples.iter().enumerate() {
        let palms = &sample.palms;
        let numbers = [sample.time_s, palms.phi1_rad, palms.phi2_rad]
            .into_iter()
            .chain(palms.base1_m)
            .chain(palms.base2_m)
            .chain([sample.s1_m, sample.s2_m, sample.s1_sd_m, sample.s2_sd_m].into_iter().flatten());
        let bad = |what: &str| Err(ReconstructError::BadSample { sample: index + 1, what: what.to_owned() });
        if numbers.into_iter().any(|value| !(value.abs() <= LARGEST_VALUE)) {
            return bad("a value is not a finite number, or is far too large");
        }
        if palms.phi2_rad.sin().abs() < SMALLEST_OPENING {
            return bad("the palms are parallel");
        }
        if [sample.s1_sd_m, sample.s2_sd_m].into_iter().flatten().any(|sd| sd <= 0.0) {
            return bad("a standard deviation is not positive");
        }
        if index > 0 && log.samples[index - 1].time_s > sample.time_s {
            return bad("time runs backwards");
        }
    }
    let seen = log.samples.iter().filter(|sample| sample.s1_m.is_some() && sample.s2_m.is_some()).count();
    if seen < FEWEST_SAMPLES {
        return Err(ReconstructError::TooFewSamples { seen, needed: FEWEST_SAMPLES });
    }
    Ok(())
}

/// Palms closer to parallel than this (sine of the angle between them) cannot be used.
const SMALLEST_OPENING: f64 = 1e-3;

/// No time, angle or length of a palm log is larger than this.
const LARGEST_VALUE: f64 = 1e12;

/// The median of the standard deviations that the log states, if it states any.
fn stated_noise_m(log: &Log) -> Option<f64> {
    let mut stated: Vec<f64> =
        log.samples.iter().flat_map(|sample| [sample.s1_sd_m, sample.s2_sd_m]).flatten().collect();
    (!stated.is_empty()).then(|| noise::median(&mut stated))
}

/// Optima on the thinned log, best first: each start is smoothed while the noise that is believed in shrinks, so that
/// no start is trapped by the sharp valley of the exact problem.
fn candidates(thin: &Problem, scatter_m: f64, prior: Prior) -> Vec<Estimate> {
    use rayon::prelude::*;
    let loose = |share: f64| {
        let sd = (share * prior.size_m).max(scatter_m);
        Noise { sensor_m: sd, balance_m: sd }
    };
    let starts = start::from_heights(thin, loose(0.01), prior, SEARCH_ORDER);
    let mut polished: Vec<Estimate> = starts
        .into_iter()
        .take(8)
        .collect::<Vec<_>>()
        .into_par_iter()
        .map(|mut estimate| {
            for share in [0.01, 0.003, 0.001] {
                let smoother = Smoother::new(thin, SEARCH_ORDER + 2, loose(share), prior);
                let effort = Effort { iterations: 30, tolerance: 1e-4 };
                estimate = smoother.run(estimate.coefficients, estimate.psi, effort);
            }
            estimate
        })
        .filter(|estimate| estimate.cost.is_finite())
        .collect();
    polished.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    polished
}

/// Orientations at the instants of `to` from those at the instants of `from`, by linear interpolation over the log.
fn interpolate(from: &Problem, psi: &[f64], to: &Problem) -> Vec<f64> {
    let places: Vec<f64> = from.instants.iter().map(|instant| instant.position).collect();
    to.instants
        .iter()
        .map(|instant| {
            let after = places.partition_point(|place| *place < instant.position);
            if after == 0 || places.len() < 2 {
                psi[0]
            } else if after == places.len() {
                psi[after - 1]
            } else {
                let share = (instant.position - places[after - 1]) / (places[after] - places[after - 1]);
                psi[after - 1] + share * (psi[after] - psi[after - 1])
            }
        })
        .collect()
}

/// How many distinct objects explain the thinned log as well as the chosen one (which counts too).
fn count_alternatives(thin: &Problem, candidates: &[Estimate], chosen: &Fit) -> usize {
    let smoother = Smoother::new(thin, chosen.order, chosen.noise, chosen.prior);
    let effort = Effort { iterations: 20, tolerance: 1e-5 };
    let polished: Vec<Estimate> = candidates
        .iter()
        .map(|estimate| smoother.run(estimate.coefficients.clone(), estimate.psi.clone(), effort))
        .collect();
    let Some(best) = polished.iter().map(|estimate| estimate.cost).min_by(f64::total_cmp) else { return 1 };
    let mut distinct: Vec<&Estimate> = Vec::new();
    for estimate in polished.iter().filter(|estimate| estimate.cost < best + NEAR_EQUAL) {
        let same = |other: &&Estimate| {
            let turned = estimate.psi[0] - other.psi[0];
            let apart = |(a, b): (&f64, &f64)| (a - b - turned).sin().abs();
            estimate.psi.iter().zip(&other.psi).map(apart).fold(0.0, f64::max) < 0.1
        };
        if !distinct.iter().any(same) {
            distinct.push(estimate);
        }
    }
    distinct.len().max(1)
}

/// Two arrangements whose sums of squares differ by less than this explain the log equally well.
const NEAR_EQUAL: f64 = 40.0;
