//! What the data say of everything that is not shape or motion: the number of harmonics, the noise of the sensors and of
//! the balance, and the size of the prior. All of it maximises the evidence, the probability of the log with shape and
//! motion integrated out (Laplace's approximation); MacKay, *Bayesian interpolation*, 1992.

use nalgebra::{Cholesky, Dyn};

use super::jumps::{standing_out, unwrap};
use super::problem::Problem;
use super::residuals::residuals;
use super::smooth::{Effort, Estimate, Noise, Normal, Prior, Smoother};

/// The optimum for one number of harmonics, with the noise and the prior that go with it.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub estimate: Estimate,
    pub order: usize,
    pub noise: Noise,
    pub prior: Prior,
    pub log_evidence: f64,
}

/// Which standard deviations the data may change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Freedom {
    /// The sensor noise is estimated (not stated by log or user).
    pub sensor: bool,
    /// Smallest standard deviation of a sensor that makes sense, metres.
    pub floor_m: f64,
}

/// Numbers of harmonics that are tried, in turn.
pub(super) const ORDERS: [usize; 12] = [3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48];

/// Times that noise and prior follow the data in one fit.
pub(super) const ROUNDS: usize = 4;

/// Numbers of harmonics without gain after which no further ones are tried.
const PATIENCE: usize = 2;

/// The balance is never believed to be more exact than this share of the sensor noise.
const STRICTEST_BALANCE: f64 = 0.1;

/// Runs the smoother, lets noise and prior follow the data, and runs it again, `rounds` times.
pub(super) fn fit(
    problem: &mut Problem,
    order: usize,
    start: Estimate,
    mut noise: Noise,
    mut prior: Prior,
    freedom: Freedom,
    rounds: usize,
) -> Option<Fit> {
    let mut estimate = start;
    let mut best: Option<Fit> = None;
    for round in 0..=rounds {
        let smoother = Smoother::new(problem, order, noise, prior).strictly_convex();
        let effort = Effort { iterations: if round == 0 { 40 } else { 12 }, tolerance: 1e-7 };
        estimate = smoother.run(estimate.coefficients, estimate.psi, effort);
        if !estimate.cost.is_finite() {
            return best;
        }
        let normal = smoother.linearise(&estimate.coefficients, &estimate.psi);
        let factor = smoother.factor(&normal)?;
        let log_evidence =
            log_evidence(&smoother, &estimate, &normal, &factor) - wonder(problem, &estimate, noise.balance_m);
        let variance: Vec<f64> = factor.inverse().diagonal().iter().copied().collect();
        best = Some(Fit { estimate: estimate.clone(), order, noise, prior, log_evidence });
        let next = updated_noise(&smoother, &estimate, &variance, freedom);
        prior.scale_m = updated_scale(&estimate.coefficients, &variance, prior);
        let settled =
            (next.sensor_m / noise.sensor_m).ln().abs() < 0.01 && (next.balance_m / noise.balance_m).ln().abs() < 0.05;
        noise = next;
        weigh_balance(problem, &estimate, noise.balance_m);
        if settled {
            break;
        }
    }
    best
}

/// The number of harmonics with the largest evidence: up from the number of the start while the evidence grows, then down
/// from it. Every fit begins at the optimum of its neighbour, never at a shape with too few harmonics to hold the motion.
pub(super) fn choose_order(
    problem: &mut Problem,
    start: Estimate,
    noise: Noise,
    prior: Prior,
    freedom: Freedom,
) -> Option<Fit> {
    let here = start.coefficients.len() / 2;
    let middle = ORDERS.iter().position(|&order| order >= here).unwrap_or(ORDERS.len() - 1);
    let first = fit(problem, ORDERS[middle], start, noise, prior, freedom, ROUNDS)?;
    let mut best = first.clone();
    let climbs: [&mut dyn Iterator<Item = usize>; 2] =
        [&mut ORDERS[middle + 1..].iter().copied(), &mut ORDERS[..middle].iter().rev().copied()];
    for orders in climbs {
        let mut from = first.clone();
        let mut worse = 0;
        for order in orders {
            let Some(next) = fit(problem, order, from.estimate, from.noise, from.prior, freedom, ROUNDS) else { break };
            from = next.clone();
            if next.log_evidence > best.log_evidence {
                best = next;
                worse = 0;
            } else {
                worse += 1;
                if worse == PATIENCE {
                    break;
                }
            }
        }
    }
    // One step more than the evidence asks for: what was not resolved belongs into the error bars.
    let richer = ORDERS.iter().copied().find(|&order| order > best.order).unwrap_or(best.order);
    fit(problem, richer, best.estimate.clone(), best.noise, best.prior, freedom, ROUNDS).or(Some(best))
}

/// Balance is missed in bursts (ringing after a jump, a stick and a slip), so its errors follow Student's t, not a Gaussian:
/// each sample weighs (ν + 1)/(ν + (g/σ_b)²).
fn weigh_balance(problem: &mut Problem, estimate: &Estimate, balance_m: f64) {
    let counted = problem.instants.iter_mut().zip(&estimate.psi).filter(|(instant, _)| instant.balance_weight > 0.0);
    for (instant, &psi) in counted {
        let g = residuals(instant, &estimate.coefficients, psi).value[2];
        instant.balance_weight = ((STUDENT + 1.0) / (STUDENT + (g / balance_m).powi(2))).sqrt();
    }
}

/// Degrees of freedom ν of the errors of the balance.
const STUDENT: f64 = 3.0;

/// ln of the probability of the log, shape and motion integrated out. An object at rest has the orientation that balances it,
/// to within σ_b/g': the balance is what is known of ψ beforehand, with the density |g'|/σ_b at its peak, and not a
/// measurement. (Were it one, round shapes would be favoured, which leave ψ free.) `factor` is that of `normal`.
pub(super) fn log_evidence(
    smoother: &Smoother,
    estimate: &Estimate,
    normal: &Normal,
    factor: &Cholesky<f64, Dyn>,
) -> f64 {
    let half_log_determinant: f64 = factor.l_dirty().diagonal().iter().map(|value| value.ln()).sum();
    let mut sum = -0.5 * estimate.cost - half_log_determinant;
    sum -= smoother.prior.standard_deviations(smoother.order).iter().map(|sd| sd.ln()).sum::<f64>();
    for (index, (instant, &psi)) in smoother.problem.instants.iter().zip(&estimate.psi).enumerate() {
        let seen = f64::from(instant.weight1 > 0.0) + f64::from(instant.weight2 > 0.0);
        sum -= seen * smoother.noise.sensor_m.ln();
        let stiffness = residuals(instant, &estimate.coefficients, psi).by_psi[2];
        let density = stiffness * smoother.noise.weights(instant)[2];
        sum += 0.5 * (density * density).ln_1p() - 0.5 * normal.psi_information(index).ln_1p();
    }
    sum
}

/// What is against a motion beforehand, in ln of the odds: leaps are rare, and poses that would not be at rest rarer. Without
/// this, more harmonics than the object has would be paid for by poses to choose from: each sample takes the one that suits
/// its noise.
fn wonder(problem: &Problem, estimate: &Estimate, balance_m: f64) -> f64 {
    let mut psi = estimate.psi.clone();
    unwrap(&mut psi);
    let leaps = standing_out(&psi).len();
    let restless = problem
        .instants
        .iter()
        .zip(&estimate.psi)
        .filter(|(instant, psi)| residuals(instant, &estimate.coefficients, **psi).is_restless(balance_m))
        .count();
    LEAP * leaps as f64 + RESTLESS * restless as f64
}

/// ln of the odds against a leap from one sample to the next: some five of a thousand samples have one.
const LEAP: f64 = 5.0;

/// ln of the odds against a pose that is no minimum of the potential energy.
const RESTLESS: f64 = 5.0;

/// Variance components: squared residuals of each kind over the redundancy that the fit leaves them.
fn updated_noise(smoother: &Smoother, estimate: &Estimate, variance: &[f64], freedom: Freedom) -> Noise {
    let Noise { sensor_m, balance_m } = smoother.noise;
    let (mut squares, mut redundancy) = ([0.0; 2], [0.0; 2]);
    for (instant, &psi) in smoother.problem.instants.iter().zip(&estimate.psi) {
        let at = residuals(instant, &estimate.coefficients, psi);
        let weights = smoother.noise.weights(instant);
        let information: f64 = (0..3).map(|j| (weights[j] * at.by_psi[j]).powi(2)).sum();
        for (kind, weight, value, by_psi) in [
            (0, weights[0], at.value[0], at.by_psi[0]),
            (0, weights[1], at.value[1], at.by_psi[1]),
            (1, weights[2], at.value[2], at.by_psi[2]),
        ] {
            if weight > 0.0 {
                squares[kind] += (weight * value).powi(2);
                redundancy[kind] += 1.0 - (weight * by_psi).powi(2) / information.max(1e-300);
            }
        }
    }
    let priors = smoother.prior.standard_deviations(smoother.order);
    let free: f64 = variance.iter().zip(&priors).map(|(variance, sd)| 1.0 - variance / (sd * sd)).sum();
    let total = redundancy[0] + redundancy[1];
    let share = ((total - free) / total).max(0.05);
    let step = |kind: usize| {
        let ratio: f64 = squares[kind] / (redundancy[kind] * share).max(1e-9);
        ratio.sqrt().clamp(0.2, 5.0)
    };
    let sensor = if freedom.sensor { (sensor_m * step(0)).max(freedom.floor_m) } else { sensor_m };
    Noise { sensor_m: sensor, balance_m: (balance_m * step(1)).max(STRICTEST_BALANCE * sensor) }
}

/// Expectation-maximisation step for the prior's c: the mean of k⁴(a² + b²), with what is uncertain of each added.
fn updated_scale(coefficients: &[f64], variance: &[f64], prior: Prior) -> f64 {
    let order = coefficients.len() / 2;
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 2..=order {
        for index in [k, order + k] {
            sum += (k as f64).powi(4) * (coefficients[index].powi(2) + variance[index]);
            count += 1.0;
        }
    }
    if count == 0.0 { prior.scale_m } else { (sum / count).sqrt().clamp(0.02 * prior.size_m, 2.0 * prior.size_m) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::PalmPair;
    use crate::sensor::Touchpad;
    use crate::shape::{RandomShape, SupportFunction, random_shape, rounded_polygon};
    use crate::simulate::{PalmLimits, SimulateOptions, plan_turn, simulate};

    const SIZE_M: f64 = 0.03;
    const NOISE_M: f64 = 5e-5;

    fn pebble() -> SupportFunction {
        random_shape(&RandomShape { mean_radius_m: SIZE_M, order: 6, ..RandomShape::default() }, 4)
            .expect("a valid kind")
    }

    /// Carried around without a jump; with the start that a perfect search would give.
    fn setting(shape: &SupportFunction, samples: usize, noise_sd_m: f64) -> (Problem, Estimate) {
        let plan = plan_turn(shape, &PalmLimits::default(), 40.0).expect("a motion without a jump");
        let motion: Vec<(f64, PalmPair)> = plan.motion.sample(samples as f64 / 40.0).expect("possible");
        let options = SimulateOptions {
            start_psi_rad: plan.start_psi_rad,
            touchpad: Touchpad { noise_sd_m, ..Touchpad::ideal() },
            ..SimulateOptions::default()
        };
        let run = simulate(shape, &motion, &options).expect("possible");
        let mut coefficients = shape.coefficients();
        crate::reconstruct::smooth::coefficients_to_order(&mut coefficients, 8);
        let psi = run.truth.motion.iter().map(|pose| pose.psi_rad).collect();
        (Problem::new(&run.log, None), Estimate { coefficients, psi, cost: f64::INFINITY })
    }

    fn free() -> Freedom {
        Freedom { sensor: true, floor_m: 1e-6 * SIZE_M }
    }

    const PRIOR: Prior = Prior { size_m: SIZE_M, scale_m: 0.5 * SIZE_M };

    fn flat_sided() -> SupportFunction {
        let unit = rounded_polygon(3, 0.3, 0.22).expect("in range");
        let scaled = unit.harmonics_m().iter().map(|[a, b]| [a * SIZE_M, b * SIZE_M]).collect();
        SupportFunction::new(SIZE_M, scaled).translated(0.1 * SIZE_M, 0.0)
    }

    #[test]
    fn as_many_harmonics_as_the_object_has_and_more_for_flat_sides() {
        let noise = Noise { sensor_m: NOISE_M, balance_m: NOISE_M };
        let (mut problem, start) = setting(&pebble(), 400, NOISE_M);
        let smooth = choose_order(&mut problem, start, noise, PRIOR, free()).expect("solvable").order;
        // Six, and a step of reserve.
        assert!((6..=8).contains(&smooth), "{smooth}");
        let (mut problem, start) = setting(&flat_sided(), 400, NOISE_M);
        let flat = choose_order(&mut problem, start, noise, PRIOR, free()).expect("solvable").order;
        assert!(flat >= 12, "{flat}");
    }

    #[test]
    fn the_noise_of_the_sensors_is_estimated_to_a_tenth() {
        for noise_m in [2e-5, 1e-4, 4e-4] {
            let (mut problem, start) = setting(&pebble(), 500, noise_m);
            // From a guess that is wrong by a factor of three.
            let noise = Noise { sensor_m: 3.0 * noise_m, balance_m: noise_m };
            let fit = fit(&mut problem, 6, start, noise, PRIOR, free(), 8).expect("solvable");
            assert!((fit.noise.sensor_m / noise_m - 1.0).abs() < 0.1, "{} for {noise_m}", fit.noise.sensor_m);
            // The simulated balance is exact; it is never believed to be more so than this.
            assert!(fit.noise.balance_m < 0.2 * noise_m, "{} for {noise_m}", fit.noise.balance_m);
        }
    }

    #[test]
    fn stated_noise_stays() {
        let (mut problem, start) = setting(&pebble(), 200, NOISE_M);
        let stated = Noise { sensor_m: 3e-4, balance_m: 3e-4 };
        let freedom = Freedom { sensor: false, ..free() };
        let fit = fit(&mut problem, 6, start, stated, PRIOR, freedom, ROUNDS).expect("solvable");
        assert_eq!(fit.noise.sensor_m, 3e-4);
    }

    #[test]
    fn leaps_and_restless_poses_are_counted_against_a_motion() {
        let (problem, start) = setting(&pebble(), 200, NOISE_M);
        // A fast slide may look like a leap.
        let before = wonder(&problem, &start, NOISE_M);
        assert!(before <= LEAP, "{before}");
        let mut leaping = start.clone();
        leaping.psi[50] += 0.5;
        assert_eq!(wonder(&problem, &leaping, NOISE_M) - before, 2.0 * LEAP, "there and back");
        // With the centre of mass mirrored in the centre of the shape, the same poses are highest where they were lowest.
        let mut turned = start;
        turned.coefficients.iter_mut().skip(1).for_each(|a| *a = -*a);
        let restless = wonder(&problem, &turned, NOISE_M) / RESTLESS;
        assert!(restless > 150.0, "{restless}");
    }

    #[test]
    fn samples_out_of_balance_lose_their_weight_in_it() {
        let (mut problem, start) = setting(&pebble(), 200, NOISE_M);
        let mut fitted = start.clone();
        fitted.psi[50] += 0.5;
        weigh_balance(&mut problem, &fitted, NOISE_M);
        assert!(problem.instants[50].balance_weight < 0.1, "{}", problem.instants[50].balance_weight);
        assert!(problem.instants[20].balance_weight > 1.0, "{}", problem.instants[20].balance_weight);
    }
}
