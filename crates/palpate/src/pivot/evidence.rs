//! Noise, spread of the harmonics and their number by the evidence: variance components (noise by what the residuals leave over their
//! redundancy, after Förstner, *Zur Schätzung von Varianzkomponenten*, 1979) and Laplace's approximation.

use crate::pivot::harmonic_prior::HarmonicPrior;
use crate::pivot::motion_between::LEAST_SD_RAD;
use crate::pivot::smoother::{Noise, Optimum, Problem, State, across};

/// Numbers of harmonics that are tried, in this order.
const ORDERS: [usize; 12] = [4, 6, 8, 10, 12, 14, 16, 20, 24, 32, 40, 48];

/// The largest of them.
pub(super) const MOST_HARMONICS: usize = ORDERS[ORDERS.len() - 1];

/// Numbers tried beyond the best one.
const BEYOND: usize = 1;

/// A number of harmonics is left when its evidence would be less by so many nats were the noise as its residuals are: rounds of variance
/// components change the optimum too, and the spread of the harmonics.
const OUT_OF_REACH_NATS: f64 = 40.0;

/// So many numbers beyond those that the evidence asks for: of a rounded polygon that shows its corners, the next multiple of them.
const UNRESOLVED: usize = 2;

/// Rounds of variance components at most.
const ROUNDS: usize = 6;

/// Noise has settled when it changes by less than this share.
const SETTLED: f64 = 0.01;

/// Until then an optimum is sought to where a step lowers the cost by so little, in units of half a χ²: a fifth of a standard deviation, which moves the
/// noise by far less than a round does.
pub(super) const ROUGHLY_SETTLED: f64 = 0.02;

/// Rounds of the scale of the motion between readings, ...
const SCALE_ROUNDS: usize = 20;

/// ... which has settled when it would change by less than this share: the evidence is within a few nats of its best there.
const SETTLED_SCALE: f64 = 0.02;

/// Steps of the scale in one direction are stretched, twice as much each, up to this.
const MOST_STRETCH: f64 = 4.0;

/// No reading is more exact than this share of the object's size: rounding of what is measured.
pub(super) const LEAST_NOISE: f64 = 1e-9;

/// An optimum with the noise and the prior that go with it.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub optimum: Optimum,
    pub noise: Noise,
    pub order: usize,
    pub harmonics: HarmonicPrior,
    /// Scale of the motion between the readings, radians, where it is believed to be smooth.
    pub between_rad: Option<f64>,
    pub log_evidence: f64,
}

impl Fit {
    /// A problem with the noise, number of harmonics, spread and scale of this fit.
    pub fn like<'a>(&self, problem: Problem<'a>) -> Problem<'a> {
        let between = problem.between.zip(self.between_rad).map(|((between, _), sd_rad)| (between, sd_rad));
        Problem { noise: self.noise, order: self.order, harmonics: self.harmonics, between, ..problem }
    }
}

/// Noise that is stated, metres, and is not estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stated {
    pub r_m: Option<f64>,
    pub d_m: Option<f64>,
}

/// The optimum of one number of harmonics, with noise and spread at their most likely.
pub(super) fn fit(problem: Problem, start: State, stated: Stated) -> Option<Fit> {
    fit_above(problem, start, stated, f64::NEG_INFINITY)
}

/// The same; `None` as soon as its evidence is out of reach of `least`.
fn fit_above(mut problem: Problem, start: State, stated: Stated, least: f64) -> Option<Fit> {
    let least_m = LEAST_NOISE * problem.size_m;
    if let Some(r_m) = stated.r_m {
        problem.noise.r_m = r_m.max(least_m);
    }
    if let Some(d_m) = stated.d_m {
        problem.noise.d_m = d_m.max(least_m);
    }
    let mut optimum = problem.solve_to(start, ROUGHLY_SETTLED)?;
    for round in 1..=ROUNDS {
        let told = squares_and_redundancies(&optimum)?;
        if round == 1 && attainable(&problem, &optimum, told, stated)? < least - OUT_OF_REACH_NATS {
            return None;
        }
        let noise = components(&problem, told, stated);
        let covariance = optimum.linear.factorised(&optimum.state.coefficients, 0.0)?.inverse();
        let harmonics = problem.harmonics.rescaled(&optimum.state.coefficients, &covariance, problem.size_m);
        let change = |new: f64, old: f64| (new / old).ln().abs();
        let settled = change(noise.r_m, problem.noise.r_m).max(change(noise.d_m, problem.noise.d_m)) < SETTLED
            && change(harmonics.scale_m, problem.harmonics.scale_m) < 0.1;
        if settled {
            break;
        }
        problem.noise = noise;
        problem.harmonics = harmonics;
        if let (Some((between, sd_rad)), Some((factor, _))) = (problem.between, &optimum.linear.joined) {
            let sd_rad = between.scale_rad(&optimum.state.theta_rad, sd_rad, &factor.inverse_in_band());
            problem.between = Some((between, sd_rad));
        }
        optimum = problem.solve_to(optimum.state, ROUGHLY_SETTLED)?;
    }
    let log_evidence = log_evidence(&problem, &optimum)?;
    let between_rad = problem.between.map(|(_, sd_rad)| sd_rad);
    Some(Fit {
        noise: problem.noise,
        order: problem.order,
        harmonics: problem.harmonics,
        between_rad,
        optimum,
        log_evidence,
    })
}

/// The optimum where what is believed of the motion between readings has its most likely scale, from a fit whose noise, spread and number of harmonics
/// stay: motions are held against each other by what each can be, and not by how far its scale has come.
pub(super) fn at_likeliest_scale(problem: Problem, fit: Fit) -> Option<Fit> {
    let mut problem = fit.like(problem);
    let mut optimum = problem.solve_to(fit.optimum.state, ROUGHLY_SETTLED)?;
    for _ in 0..SCALE_ROUNDS {
        let Some(state) = rescale(&mut problem, &optimum) else { break };
        optimum = problem.solve_to(state, ROUGHLY_SETTLED)?;
    }
    let optimum = problem.solve(optimum.state)?;
    let log_evidence = log_evidence(&problem, &optimum)?;
    Some(Fit { optimum, log_evidence, between_rad: problem.between.map(|(_, sd_rad)| sd_rad), ..fit })
}

/// The likeliest scale where shape and constants stay, and the state whose angles follow it; `None` where it is that of the problem already.
fn rescale(problem: &mut Problem, optimum: &Optimum) -> Option<State> {
    let mut state = optimum.state.clone();
    let mut inverse = optimum.linear.joined.as_ref()?.0.inverse_in_band();
    let (mut stretch, mut last_step) = (1.0, 0.0);
    for round in 0..SCALE_ROUNDS {
        let (between, sd_rad) = problem.between?;
        let step = (between.scale_rad(&state.theta_rad, sd_rad, &inverse) / sd_rad).ln();
        if step.abs() < SETTLED_SCALE {
            return (round > 0).then_some(state);
        }
        // Angles that readings hardly tell follow the scale, which comes to its place slowly then.
        stretch = if step * last_step > 0.0 { f64::min(2.0 * stretch, MOST_STRETCH) } else { 1.0 };
        last_step = step;
        problem.between = Some((between, (sd_rad * (stretch * step).exp()).max(LEAST_SD_RAD)));
        problem.settle(&mut state);
        inverse = problem.settle(&mut state).1?.inverse_in_band();
    }
    Some(state)
}

/// The optimum with as many harmonics as the evidence likes best, and one step more, so that the error bars include harmonics that were not resolved:
/// from those of the start up, then down. Too few of them would spoil the angles of the start.
pub(super) fn choose_order(problem: &Problem, start: State, stated: Stated) -> Option<Fit> {
    let first = ORDERS.iter().position(|order| *order >= problem.order).unwrap_or(ORDERS.len() - 1);
    let mut best = fit(Problem { order: ORDERS[first], ..problem.clone() }, start, stated)?;
    let is_checked = |order: &usize| problem.checks(*order);
    let up: Vec<usize> = ORDERS[first + 1..].to_vec();
    let down: Vec<usize> = ORDERS[..first].iter().rev().copied().collect();
    // The optimum of one step more than the best, where it is known.
    let mut richer = None;
    for orders in [up, down] {
        let mut worse = 0;
        for order in orders.into_iter().take_while(is_checked) {
            let tried = Problem { order, ..best.like(problem.clone()) };
            match fit_above(tried, best.optimum.state.clone(), stated, best.log_evidence) {
                Some(fit) if fit.log_evidence > best.log_evidence => {
                    // What it is better than has more harmonics, on the way down.
                    let before = std::mem::replace(&mut best, fit);
                    richer = (before.order > best.order).then_some(before);
                    worse = 0;
                }
                fit => {
                    richer = richer.or(fit.filter(|fit| fit.order > best.order));
                    worse += 1;
                }
            }
            if worse >= BEYOND {
                break;
            }
        }
    }
    let next = ORDERS.into_iter().find(|order| *order > best.order).filter(is_checked);
    let fitted = |order| {
        let tried = Problem { order, ..best.like(problem.clone()) };
        fit(tried, best.optimum.state.clone(), stated)
    };
    richer.or_else(|| next.and_then(fitted)).or(Some(best))
}

/// The problem with harmonics that no reading resolves as well, which fall as those do that are told near this state: the error bars include them.
pub(super) fn with_unresolved<'a>(problem: &Problem<'a>, state: &State) -> Option<Problem<'a>> {
    let more = ORDERS.into_iter().filter(|order| *order > problem.order).take_while(|order| problem.checks(*order));
    let order = more.take(UNRESOLVED).last().unwrap_or(problem.order);
    let wide = Problem { order, between: None, ..problem.clone() };
    let harmonics = HarmonicPrior::likeliest(&wide.normal_equations(state), order, problem.size_m)?;
    Some(Problem { harmonics, between: problem.between, ..wide })
}

/// Squares of the residuals of r and of d over their noise, and how many of each are redundant.
pub(super) fn squares_and_redundancies(optimum: &Optimum) -> Option<[[f64; 2]; 2]> {
    let linear = &optimum.linear;
    let leverages = linear.leverages(&linear.factorised(&optimum.state.coefficients, 0.0)?);
    let (mut squares, mut redundancies) = ([0.0; 2], [0.0; 2]);
    // Of what is measured along the curve the angle takes all, or what it is believed to be leaves it.
    let taken = linear
        .told
        .slopes
        .iter()
        .zip(linear.angle_variances())
        .map(|(slope, variance)| ((slope[0] * slope[0] + slope[1] * slope[1]) * variance).min(1.0));
    let samples = linear.told.residuals.iter().zip(&linear.told.slopes).zip(leverages).zip(taken);
    for (((residual, slope), leverage), taken) in samples {
        let share = across(*slope);
        for which in 0..2 {
            let (across, along) = (share[which] * share[which], share[1 - which] * share[1 - which]);
            squares[which] += residual[which] * residual[which];
            redundancies[which] += across * (1.0 - leverage) + along * (1.0 - taken);
        }
    }
    Some([squares, redundancies])
}

/// The evidence of an optimum, were its noise what its residuals leave over their redundancy: ln of a normal density with n degrees of freedom
/// and squares S gains (S − n − n ln(S/n))/2.
fn attainable(
    problem: &Problem,
    optimum: &Optimum,
    [squares, redundancies]: [[f64; 2]; 2],
    stated: Stated,
) -> Option<f64> {
    let gain = |which: usize, stated: Option<f64>| {
        let (square, count) = (squares[which], redundancies[which]);
        let gain = 0.5 * (square - count - count * (square / count).ln());
        if stated.is_none() && gain.is_finite() { gain } else { 0.0 }
    };
    Some(log_evidence(problem, optimum)? + gain(0, stated.r_m) + gain(1, stated.d_m))
}

/// Noise by what its residuals leave over their redundancy.
fn components(problem: &Problem, [squares, redundancies]: [[f64; 2]; 2], stated: Stated) -> Noise {
    let least_m = LEAST_NOISE * problem.size_m;
    let most_m = problem.size_m;
    let new = |which: usize, old: f64, stated: Option<f64>| {
        let estimated =
            if redundancies[which] > 3.0 { old * (squares[which] / redundancies[which]).sqrt() } else { old };
        stated.unwrap_or(estimated).clamp(least_m, most_m)
    };
    Noise { r_m: new(0, problem.noise.r_m, stated.r_m), d_m: new(1, problem.noise.d_m, stated.d_m) }
}

/// The logarithm of the evidence after Laplace, every θ and the unknowns marginalised, up to a constant of the readings.
pub(super) fn log_evidence(problem: &Problem, optimum: &Optimum) -> Option<f64> {
    let linear = &optimum.linear;
    let factor = linear.factorised(&optimum.state.coefficients, 0.0)?;
    // The rotation is held by the largest stiffness, which is no information.
    let held = linear.information.diagonal().max().ln();
    let log_determinant = 2.0 * factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum::<f64>() - held;
    let prior: f64 = problem.harmonics.sds(problem.order, problem.size_m).iter().map(|sd| sd.ln()).sum();
    let angles = linear.half_ln_angles();
    let readings = problem.readings.len() as f64 * (problem.noise.r_m.ln() + problem.noise.d_m.ln());
    let value = -optimum.cost - 0.5 * log_determinant - prior - angles - readings;
    value.is_finite().then_some(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::model::contact::support;
    use crate::pivot::calibration::{PivotCalibration, Reading, TOLD};
    use crate::pivot::motion_between::{FIRST_SD_RAD, MotionBetween};
    use crate::pivot::verdict::RIVAL_NATS;
    use crate::shape::ContactSupport;

    /// A motion whose second differences are 4 mrad, through crossings of d = 0.
    #[test]
    fn a_scale_that_is_far_off_comes_to_its_place() {
        let coefficients = vec![0.03, 0.002, -0.001, 0.0005, 0.003, 0.0012, -0.0004];
        let theta_rad: Vec<f64> = (0..300).map(|i| 0.02 * f64::from(i) + 2e-3 * f64::from(i % 2)).collect();
        let reading = |theta: &f64| {
            let ContactSupport { r, d, .. } = support(&coefficients, *theta);
            Reading { along_m: 0.1 + 0.03 * theta, above_m: r, s_m: 0.1 + 0.03 * theta - d }
        };
        let readings: Vec<Reading> = theta_rad.iter().map(reading).collect();
        let numbers: Vec<usize> = (0..300).collect();
        let between = MotionBetween::new(std::slice::from_ref(&(0..300)), &numbers, &[false; 300]);
        let problem = |sd_rad: f64| Problem {
            readings: &readings,
            noise: Noise { r_m: 2e-6, d_m: 1e-5 },
            order: 3,
            size_m: 0.03,
            harmonics: HarmonicPrior::of_scale(0.03),
            stated: PivotCalibration::default(),
            open: Vec::new(),
            between: Some((&between, sd_rad)),
        };
        let state = State { coefficients: coefficients.clone(), told: [0.0; TOLD], theta_rad: theta_rad.clone() };
        let found = |from_rad: f64| {
            let optimum = problem(from_rad).solve(state.clone()).expect("solvable");
            let fit = Fit {
                optimum,
                noise: problem(from_rad).noise,
                order: 3,
                harmonics: HarmonicPrior::of_scale(0.03),
                between_rad: Some(from_rad),
                log_evidence: f64::NEG_INFINITY,
            };
            at_likeliest_scale(problem(from_rad), fit).expect("solvable")
        };
        let [from_above, from_below] = [found(5.0 * FIRST_SD_RAD), found(1.5e-3)];
        let scales = [&from_above, &from_below].map(|fit| fit.between_rad.expect("there is one"));
        assert!((scales[0] / scales[1]).ln().abs() < 0.3, "{scales:?}");
        let nats = from_above.log_evidence - from_below.log_evidence;
        assert!(nats.abs() < 0.3 * RIVAL_NATS, "{nats}");
        // At the first scale the motion would seem clearly less likely than another.
        let first = problem(5.0 * FIRST_SD_RAD);
        let optimum = first.solve(state.clone()).expect("solvable");
        let at_first = log_evidence(&first, &optimum).expect("finite");
        assert!(at_first < from_above.log_evidence - 10.0 * RIVAL_NATS, "{at_first} {}", from_above.log_evidence);
    }
}
