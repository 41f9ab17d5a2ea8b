//! Starts for the smoother from the log alone: a search over the height h0 of the centre of mass at the first sample, the one
//! unknown that the closed forms leave (`estimate/closed_form.rs`), and the closed forms of rolling, which leave none
//! (`estimate/friction/rolling.rs`).

use crate::estimate::closed_form::{RATE_SD, feasible_heights, integrate, relative_height};
use crate::estimate::friction::rolling::rolling_motion;
use crate::estimate::measurements::{Instant, Measurements};
use crate::estimate::model::noise::Noise;
use crate::estimate::model::prior::Prior;
use crate::estimate::solver::gauss_newton::{Estimate, Smoother, StoppingCriteria};
use rayon::prelude::*;

/// Trial heights of the centre of mass at the first sample: fine enough that the minimum next to the truth is among the trials.
const HEIGHTS: usize = 160;

/// Effort of the smoother at each trial height, after which the least along the heights are followed: one step gives the shape, and more rank the heights.
/// After two the right one was not among the least of a superellipse; after three it was, as after eight.
const FIRST: StoppingCriteria = StoppingCriteria { iterations: 3, tolerance: 1e-3 };

/// Trial heights that are followed: three times as many as the search refines, since those after so few steps are not in their final order.
const MOST_FOLLOWED: usize = 24;

/// Effort of the smoother for those: they are only ranked, and refined later.
const TRIAL: StoppingCriteria = StoppingCriteria { iterations: 8, tolerance: 1e-3 };

/// Candidates of an object that rolls on one palm all the time.
pub(crate) fn from_rolling(thin: &Measurements, noise: Noise, prior: Prior, order: usize) -> Vec<Estimate> {
    let radii_m = thin.instants.iter().flat_map(Instant::disc_radii_m);
    let mean_r_m = 0.5 * radii_m.sum::<f64>() / thin.len().max(1) as f64;
    let smoother = Smoother::new(thin, order, noise, prior);
    let rolls = [0, 1].map(|palm| smoother.run(vec![mean_r_m], rolling_motion(thin, palm), TRIAL));
    rolls.into_iter().filter(|estimate| estimate.cost.is_finite()).collect()
}

/// Candidates from the search over h0, best first: the local minima of the cost along h0, on a thinned log.
pub(crate) fn from_initial_heights(thin: &Measurements, noise: Noise, prior: Prior, order: usize) -> Vec<Estimate> {
    let relative = relative_height(thin);
    let Some((low, high)) = feasible_heights(thin, &relative, prior.size_m) else { return Vec::new() };
    let smoother = Smoother::new(thin, order, noise, prior);
    let first: Vec<Option<Estimate>> = (0..HEIGHTS)
        .into_par_iter()
        .map(|index| {
            let h0 = low + (high - low) * (index as f64 + 0.5) / HEIGHTS as f64;
            let guess = integrate(thin, &relative, h0, noise.sensor_m, RATE_SD);
            let estimate = smoother.run(vec![guess.mean_r_m], guess.psi, FIRST);
            estimate.cost.is_finite().then_some(estimate)
        })
        .collect();
    let cost = |index: usize| first.get(index).and_then(Option::as_ref).map_or(f64::INFINITY, |first| first.cost);
    let is_least = |index: &usize| cost(*index) <= cost(index.wrapping_sub(1)) && cost(*index) <= cost(index + 1);
    let mut least: Vec<&Estimate> = (0..HEIGHTS).filter(is_least).filter_map(|index| first[index].as_ref()).collect();
    least.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    least.truncate(MOST_FOLLOWED);
    let follow = |first: &Estimate| smoother.run(first.coefficients.clone(), first.psi.clone(), TRIAL);
    let mut minima: Vec<Estimate> = least.into_par_iter().map(follow).collect();
    minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    minima
}
