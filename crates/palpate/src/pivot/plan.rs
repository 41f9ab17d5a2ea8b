//! Strokes that feel as much of an object as they can, with as few of them as it takes, for a shape that is known as a posterior.
//!
//! Each candidate stroke is simulated on shapes drawn from the posterior; what most of them feel counts. Strokes are chosen greedily by
//! what they add, which is within 1 − 1/e of the best choice of as many (Nemhauser, Wolsey & Fisher, *Mathematical Programming* 14, 1978).

use crate::estimate::coverage::{LONGEST_SLIDE, NODES, touches};
use crate::pivot::error::PivotSimulateError;
use crate::pivot::posterior::PivotPosterior;
use crate::pivot::result::PivotReconstruction;
use crate::pivot::simulate::{PivotSimulateOptions, Stroke, simulate_strokes};
use crate::shape::SupportFunction;

/// Shapes drawn from the posterior, besides its mean.
const DRAWS: u64 = 6;

/// A part of the boundary counts as felt where at least this share of the shapes feels it.
const FELT_SHARE: f64 = 0.7;

/// A stroke is worth its while where it adds at least this share of the boundary.
const WORTHWHILE: f64 = 0.01;

/// Samples that are simulated per mean radius of way.
const SAMPLES_PER_RADIUS: f64 = 25.0;

/// What the arm and the pad allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokeLimits {
    /// Part of the pad over which the foot of the pivot may move, metres along it from its base.
    pub along_m: [f64; 2],
    /// Longest way of one stroke along the pad, metres.
    pub longest_m: f64,
    /// Force with which the arm presses, in weights of the object.
    pub press: f64,
    /// Most strokes.
    pub most_strokes: usize,
}

impl Default for StrokeLimits {
    /// A pad of 0.2 m, ways of 0.3 m, three weights, 12 strokes.
    fn default() -> Self {
        Self { along_m: [0.4, 0.6], longest_m: 0.3, press: 3.0, most_strokes: 12 }
    }
}

/// Planned strokes.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedStrokes {
    /// The strokes, the one that feels most first.
    pub strokes: Vec<Stroke>,
    /// Fraction of the boundary that they are expected to feel after each stroke, 0 to 1.
    pub coverage: Vec<f64>,
}

/// Strokes for an object of which `posterior` is known, with the centre of mass, friction and pad of `options` (noise does not matter).
/// Shapes drawn from the posterior that are no objects are left out.
///
/// # Errors
/// When the mean of the posterior is no convex object around its pivot, or a number is out of range.
pub fn plan_strokes(
    posterior: &PivotPosterior,
    options: &PivotSimulateOptions,
    limits: &StrokeLimits,
) -> Result<PlannedStrokes, PivotSimulateError> {
    let [low_m, high_m] = limits.along_m;
    if !(low_m < high_m
        && limits.longest_m > 0.0
        && low_m.is_finite()
        && high_m.is_finite()
        && limits.longest_m.is_finite())
    {
        return Err(PivotSimulateError::OutOfRange { what: "the limits of the strokes must be in order, and finite" });
    }
    let mean = posterior.mean();
    let exact = PivotSimulateOptions {
        arm_noise_sd_m: 0.0,
        touchpad: crate::sensor::Touchpad { noise_sd_m: 0.0, dropout: 0.0, counts_per_inch: None, ..options.touchpad },
        rate_hz: SAMPLES_PER_RADIUS * options.drag_m_per_s / mean.mean_radius_m().max(1e-9),
        lift_m_per_s: options.drag_m_per_s,
        ..options.clone()
    };
    let candidates = candidates(limits);
    let mut shapes = vec![mean];
    shapes.extend((0..DRAWS).map(|seed| posterior.draw(seed)));
    // The mean must do; a drawn shape that is hollow somewhere tells nothing.
    let mut felt: Vec<Vec<Vec<bool>>> = Vec::new();
    for (index, shape) in shapes.iter().enumerate() {
        let all: Result<Vec<Vec<bool>>, _> = candidates.iter().map(|stroke| felt_by(shape, stroke, &exact)).collect();
        match all {
            Ok(all) => felt.push(all),
            Err(error) if index == 0 => return Err(error),
            Err(_) => {}
        }
    }
    let needed = (FELT_SHARE * felt.len() as f64).ceil() as usize;
    let robust = |candidate: usize, node: usize| felt.iter().filter(|all| all[candidate][node]).count() >= needed;
    let reached: Vec<Vec<bool>> =
        (0..candidates.len()).map(|candidate| (0..NODES).map(|node| robust(candidate, node)).collect()).collect();
    let mut covered = vec![false; NODES];
    let (mut strokes, mut coverage) = (Vec::new(), Vec::new());
    while strokes.len() < limits.most_strokes {
        let adds = |candidate: usize| (0..NODES).filter(|&node| reached[candidate][node] && !covered[node]).count();
        // Of equals the first, which goes the shortest way.
        let Some((best, added)) =
            (0..candidates.len()).map(|candidate| (candidate, adds(candidate))).rev().max_by_key(|(_, added)| *added)
        else {
            break;
        };
        if (added as f64) < WORTHWHILE * NODES as f64 {
            break;
        }
        covered.iter_mut().zip(&reached[best]).for_each(|(covered, reached)| *covered |= reached);
        strokes.push(candidates[best].clone());
        coverage.push(covered.iter().filter(|covered| **covered).count() as f64 / NODES as f64);
    }
    Ok(PlannedStrokes { strokes, coverage })
}

/// The same by a result and the posterior that came with it ([`reconstruct_with_posterior`](crate::pivot::reconstruct_with_posterior)). Where the
/// mean of that is hollow, which it may be where nothing was felt, the convex shape closest to what was felt takes its place.
///
/// # Errors
/// As [`plan_strokes`]; also when what was felt determines no convex shape.
pub fn plan_next_strokes(
    found: &PivotReconstruction,
    posterior: &PivotPosterior,
    options: &PivotSimulateOptions,
    limits: &StrokeLimits,
) -> Result<PlannedStrokes, PivotSimulateError> {
    if posterior.mean().is_convex() {
        return plan_strokes(posterior, options, limits);
    }
    let felt = found.outline.iter().filter(|point| point.touches > 0);
    let felt: Vec<(f64, f64)> = felt.map(|point| (point.theta_rad, point.r_m)).collect();
    let hollow = PivotSimulateError::NotConvex { smallest_m: found.shape.min_curvature_radius_m() };
    let fit = SupportFunction::from_support(&felt).map_err(|_| hollow)?;
    plan_strokes(&PivotPosterior::known(&fit.shape), options, limits)
}

/// Strokes that go one way, or one way and then the other, from either end or the middle of what is allowed; the shortest first.
fn candidates(limits: &StrokeLimits) -> Vec<Stroke> {
    let [low_m, high_m] = limits.along_m;
    let middle_m = 0.5 * (low_m + high_m);
    let ways = [
        vec![middle_m, high_m],
        vec![middle_m, low_m],
        vec![low_m, high_m],
        vec![high_m, low_m],
        vec![middle_m, high_m, low_m],
        vec![middle_m, low_m, high_m],
        vec![low_m, high_m, low_m],
        vec![high_m, low_m, high_m],
    ];
    ways.into_iter()
        .map(|mut along_m| {
            let mut left_m = limits.longest_m;
            for place in 1..along_m.len() {
                let way = along_m[place] - along_m[place - 1];
                along_m[place] = along_m[place - 1] + way.clamp(-left_m, left_m);
                left_m = (left_m - way.abs()).max(0.0);
            }
            Stroke { along_m, press: limits.press }
        })
        .collect()
}

/// Which nodes of the boundary a stroke feels.
fn felt_by(
    shape: &SupportFunction,
    stroke: &Stroke,
    options: &PivotSimulateOptions,
) -> Result<Vec<bool>, PivotSimulateError> {
    let simulation = simulate_strokes(shape, std::slice::from_ref(stroke), options)?;
    // Only what the pad reports counts.
    let seen = simulation.theta_rad.iter().zip(&simulation.log.samples);
    let contacts: Vec<Option<f64>> = seen.map(|(theta, sample)| theta.filter(|_| sample.s_m.is_some())).collect();
    let paths: Vec<Vec<f64>> = contacts
        .chunk_by(|a, b| a.zip(*b).is_some_and(|(a, b)| (b - a).abs() <= LONGEST_SLIDE))
        .map(|path| path.iter().flatten().copied().collect())
        .collect();
    Ok(touches(&paths).into_iter().map(|count| count > 0).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pivot::reconstruct::{PivotOptions, reconstruct_with_posterior};

    fn pebble() -> SupportFunction {
        SupportFunction::new(0.03, vec![[0.003, 0.002], [0.002, -0.001], [0.0004, 0.0006]])
    }

    #[test]
    fn a_rough_object_is_felt_all_around_with_one_or_two_strokes() {
        let options = PivotSimulateOptions { friction: 0.8, ..PivotSimulateOptions::default() };
        let plan = plan_strokes(&PivotPosterior::known(&pebble()), &options, &StrokeLimits::default()).expect("a plan");
        assert!(plan.strokes.len() <= 2, "{plan:?}");
        assert!(plan.coverage.last().is_some_and(|coverage| *coverage > 0.99), "{plan:?}");
        // What is planned is felt.
        let felt = simulate_strokes(&pebble(), &plan.strokes, &options).expect("it runs");
        let touched = felt.theta_rad.iter().flatten().map(|theta| (theta.to_degrees() / 4.0).floor() as i32);
        let mut arcs: Vec<i32> = touched.map(|arc| arc.rem_euclid(90)).collect();
        arcs.sort_unstable();
        arcs.dedup();
        assert!(arcs.len() >= 89, "{}", arcs.len());
    }

    #[test]
    fn short_ways_need_more_strokes_and_limits_are_kept() {
        let options = PivotSimulateOptions { friction: 0.8, ..PivotSimulateOptions::default() };
        let limits = StrokeLimits { along_m: [0.45, 0.53], longest_m: 0.08, ..StrokeLimits::default() };
        let plan = plan_strokes(&PivotPosterior::known(&pebble()), &options, &limits).expect("a plan");
        assert!(plan.strokes.len() >= 2, "{plan:?}");
        for stroke in &plan.strokes {
            let way: f64 = stroke.along_m.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
            assert!(way <= 0.08 + 1e-12 && stroke.along_m.iter().all(|along| (0.45..=0.53).contains(along)));
        }
        assert!(plan.coverage.windows(2).all(|pair| pair[1] >= pair[0] + WORTHWHILE - 1e-12));
        let one =
            plan_strokes(&PivotPosterior::known(&pebble()), &options, &StrokeLimits { most_strokes: 1, ..limits });
        assert_eq!(one.expect("a plan").strokes.len(), 1);
    }

    #[test]
    fn a_result_that_is_hollow_where_nothing_was_felt_plans_by_what_was() {
        let options = PivotSimulateOptions { friction: 0.8, ..PivotSimulateOptions::default() };
        let stroke = Stroke { along_m: vec![0.5, 0.6], press: 3.0 };
        let felt = simulate_strokes(&pebble(), &[stroke], &options).expect("it runs");
        let (found, posterior) = reconstruct_with_posterior(&felt.log, &PivotOptions::default()).expect("a result");
        assert!(found.coverage < 0.9);
        // A dent on the far side of what was felt.
        let unfelt = found.outline.iter().position(|point| point.touches == 0).expect("some") as f64;
        let theta = std::f64::consts::TAU * (unfelt + 20.0) / 720.0;
        let mut harmonics = found.shape.harmonics_m().to_vec();
        harmonics.resize(30, [0.0; 2]);
        for (index, [cos, sin]) in harmonics.iter_mut().enumerate() {
            let angle = (index + 1) as f64 * theta;
            (*cos, *sin) = (*cos + 2e-4 * angle.cos(), *sin + 2e-4 * angle.sin());
        }
        let hollow = PivotPosterior::known(&SupportFunction::new(found.shape.mean_radius_m(), harmonics));
        let limits = StrokeLimits::default();
        assert!(plan_strokes(&hollow, &options, &limits).is_err());
        let plan = plan_next_strokes(&found, &hollow, &options, &limits).expect("a plan");
        assert!(plan.coverage.last().is_some_and(|coverage| *coverage > 0.9), "{plan:?}");
        let plan = plan_next_strokes(&found, &posterior, &options, &limits).expect("a plan");
        assert!(plan.coverage.last().is_some_and(|coverage| *coverage > 0.9), "{plan:?}");
        let nothing = PivotReconstruction { outline: Vec::new(), ..found };
        assert!(plan_next_strokes(&nothing, &hollow, &options, &limits).is_err());
    }

    #[test]
    fn limits_out_of_order_are_an_error() {
        let limits = StrokeLimits { along_m: [0.6, 0.4], ..StrokeLimits::default() };
        assert!(plan_strokes(&PivotPosterior::known(&pebble()), &PivotSimulateOptions::default(), &limits).is_err());
    }
}
