//! Noise, spread of the harmonics and their number by the evidence: variance components (noise by what the residuals leave over their
//! redundancy, after Förstner, *Zur Schätzung von Varianzkomponenten*, 1979) and Laplace's approximation.

use crate::pivot::smoother::{Noise, Optimum, Problem, State, across, prior_sds};

/// Numbers of harmonics that are tried, in this order.
const ORDERS: [usize; 12] = [4, 6, 8, 10, 12, 14, 16, 20, 24, 32, 40, 48];

/// Numbers tried beyond the best one.
const BEYOND: usize = 1;

/// Rounds of variance components at most.
const ROUNDS: usize = 6;

/// Noise has settled when it changes by less than this share.
const SETTLED: f64 = 0.01;

/// No reading is more exact than this share of the object's size: rounding of what is measured.
pub(super) const LEAST_NOISE: f64 = 1e-9;

/// Limits of the spread of the harmonics, as shares of the size.
const SPREAD: [f64; 2] = [0.02, 2.0];

/// An optimum with the noise and the prior that go with it.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub optimum: Optimum,
    pub noise: Noise,
    pub order: usize,
    pub spread_m: f64,
    pub log_evidence: f64,
}

/// Noise that is stated, metres, and is not estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stated {
    pub r_m: Option<f64>,
    pub d_m: Option<f64>,
}

/// The optimum of one number of harmonics, with noise and spread at their most likely.
pub(super) fn fit(mut problem: Problem, start: State, stated: Stated) -> Option<Fit> {
    let least_m = LEAST_NOISE * problem.size_m;
    if let Some(r_m) = stated.r_m {
        problem.noise.r_m = r_m.max(least_m);
    }
    if let Some(d_m) = stated.d_m {
        problem.noise.d_m = d_m.max(least_m);
    }
    let mut optimum = problem.solve(start)?;
    for _ in 0..ROUNDS {
        let noise = components(&problem, &optimum, stated)?;
        let spread_m = spread(&problem, &optimum)?;
        let change = |new: f64, old: f64| (new / old).ln().abs();
        let settled = change(noise.r_m, problem.noise.r_m).max(change(noise.d_m, problem.noise.d_m)) < SETTLED
            && change(spread_m, problem.spread_m) < 0.1;
        problem.noise = noise;
        problem.spread_m = spread_m;
        optimum = problem.solve(optimum.state)?;
        if settled {
            break;
        }
    }
    let log_evidence = log_evidence(&problem, &optimum)?;
    Some(Fit { noise: problem.noise, order: problem.order, spread_m: problem.spread_m, optimum, log_evidence })
}

/// The optimum with as many harmonics as the evidence likes best: from those of the start up, then down. Too few of them would spoil the
/// angles of the start.
pub(super) fn choose_order(problem: &Problem, start: State, stated: Stated) -> Option<Fit> {
    let first = ORDERS.iter().position(|order| *order >= problem.order).unwrap_or(ORDERS.len() - 1);
    let mut best = fit(Problem { order: ORDERS[first], ..problem.clone() }, start, stated)?;
    let up: Vec<usize> = ORDERS[first + 1..].to_vec();
    let down: Vec<usize> = ORDERS[..first].iter().rev().copied().collect();
    for orders in [up, down] {
        let mut worse = 0;
        for order in orders {
            // Half as many unknowns as readings leave little to check them by.
            if 2 * (2 * order + 1) > problem.readings.len() {
                break;
            }
            let tried = Problem { order, noise: best.noise, spread_m: best.spread_m, ..problem.clone() };
            match fit(tried, best.optimum.state.clone(), stated) {
                Some(fit) if fit.log_evidence > best.log_evidence => {
                    best = fit;
                    worse = 0;
                }
                _ => worse += 1,
            }
            if worse >= BEYOND {
                break;
            }
        }
    }
    Some(best)
}

/// Noise by what its residuals leave over their redundancy.
fn components(problem: &Problem, optimum: &Optimum, stated: Stated) -> Option<Noise> {
    let linear = &optimum.linear;
    let leverages = linear.leverages(&linear.factorised(&optimum.state.coefficients, 0.0)?);
    let (mut squares, mut redundancies) = ([0.0; 2], [0.0; 2]);
    for ((residual, slope), leverage) in linear.residuals.iter().zip(&linear.slopes).zip(leverages) {
        let share = across(*slope);
        for which in 0..2 {
            squares[which] += residual[which] * residual[which];
            redundancies[which] += share[which] * share[which] * (1.0 - leverage);
        }
    }
    let least_m = LEAST_NOISE * problem.size_m;
    let most_m = problem.size_m;
    let new = |which: usize, old: f64, stated: Option<f64>| {
        let estimated =
            if redundancies[which] > 3.0 { old * (squares[which] / redundancies[which]).sqrt() } else { old };
        stated.unwrap_or(estimated).clamp(least_m, most_m)
    };
    Some(Noise { r_m: new(0, problem.noise.r_m, stated.r_m), d_m: new(1, problem.noise.d_m, stated.d_m) })
}

/// The spread of the harmonics from the second on: their mean square times k⁴, with what is not known of them.
fn spread(problem: &Problem, optimum: &Optimum) -> Option<f64> {
    let order = problem.order;
    let [low, high] = SPREAD.map(|share| share * problem.size_m);
    if order < 2 {
        return Some(problem.spread_m);
    }
    let covariance = optimum.linear.factorised(&optimum.state.coefficients, 0.0)?.inverse();
    let sum: f64 = (2..=order)
        .flat_map(|k| [(k, k), (k, order + k)])
        .map(|(k, index)| {
            let value = optimum.state.coefficients[index];
            (k as f64).powi(4) * (value * value + covariance[(index, index)])
        })
        .sum();
    Some((sum / (2 * (order - 1)) as f64).sqrt().clamp(low, high))
}

/// The logarithm of the evidence after Laplace, every θ and the unknowns marginalised, up to a constant of the readings.
pub(super) fn log_evidence(problem: &Problem, optimum: &Optimum) -> Option<f64> {
    let linear = &optimum.linear;
    let factor = linear.factorised(&optimum.state.coefficients, 0.0)?;
    // The rotation is held by the largest stiffness, which is no information.
    let held = linear.information.diagonal().max().ln();
    let log_determinant = 2.0 * factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum::<f64>() - held;
    let prior: f64 = prior_sds(problem.order, problem.size_m, problem.spread_m).iter().map(|sd| sd.ln()).sum();
    let angles: f64 =
        linear.slopes.iter().map(|slope| 0.5 * (slope[0] * slope[0] + slope[1] * slope[1] + 1e-3).ln()).sum();
    let readings = problem.readings.len() as f64 * (problem.noise.r_m.ln() + problem.noise.d_m.ln());
    let value = -optimum.cost - 0.5 * log_determinant - prior - angles - readings;
    value.is_finite().then_some(value)
}
