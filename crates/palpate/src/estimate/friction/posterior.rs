//! The posterior of centre of mass and friction, given form and motion, as a sample (slice sampling, Neal 2003).
//!
//! Where a contact sticks the moment W − D (c_x cos ψ − c_y sin ψ) of [`strips`](super::strips) vanishes *somewhere* between the edges of its cone.
//! Many such intervals confine what no equation tells: centre of mass and friction lie in a polytope, of which normal equations know nothing. Those
//! beside a change of the modes tell nothing ([`is_beside_a_change`]).

use super::regimes::{Regime, is_beside_a_change};
use super::strips::{CENTER_SD, FORM_ALLOWANCE, LEAST_FRICTION, ends, prior_of_friction, runs};
use crate::estimate::measurements::Measurements;
use crate::estimate::model::contact::contacts;
use crate::mechanics::coulomb::{at_the_edges, moment, moment_by_psi, opening};
use nalgebra::{Matrix4, Vector4};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Draws of each round that only finds out how wide the posterior is, how many of these there are, and draws of the last one.
const EXPLORING: (usize, usize) = (300, 6);
const DRAWN: usize = 6000;

/// Length of the bracket of a slice, in standard deviations of the round before.
const BRACKET: f64 = 8.0;

/// Shrinkings of a bracket at most.
const SHRINKS: usize = 60;

/// Least variance of a round over that of the round before, along any direction: a bracket never collapses.
const LEAST_SHRINK: f64 = 1e-4;

/// Form, motion and contact modes, with an estimate of the rest.
pub(crate) struct Given<'a> {
    pub measurements: &'a Measurements,
    /// Of the support function about the centre of mass.
    pub coefficients: &'a [f64],
    pub friction: [f64; 2],
    pub psi: &'a [f64],
    pub psi_sd: &'a [f64],
    pub regimes: &'a [Regime],
}

/// A function that is linear in each of two ratios: coefficients of 1, τ₁, τ₂ and τ₁τ₂.
#[derive(Clone, Copy)]
struct Bilinear([f64; 4]);

impl Bilinear {
    fn of(function: impl Fn([f64; 2]) -> f64) -> Self {
        let [none, first, second, both] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(function);
        Self([none, first - none, second - none, both - first - second + none])
    }

    fn at(&self, [first, second]: [f64; 2]) -> f64 {
        let [none, of_first, of_second, of_both] = self.0;
        none + of_first * first + (of_second + of_both * first) * second
    }
}

/// One sample.
struct Interval {
    moment: Bilinear,
    opening: Bilinear,
    /// Cosine and sine of ψ.
    direction: [f64; 2],
    /// Signs of the slips at the ends between which the moment vanishes.
    ends: [[f64; 2]; 2],
    /// Standard deviation of the moment, metres.
    sd_m: f64,
}

impl Interval {
    /// What the sample misses, in standard deviations, with such a shift of the centre of mass and such friction.
    fn missed(&self, [x, y, first, second]: [f64; 4]) -> f64 {
        let across = x * self.direction[0] - y * self.direction[1];
        let [one, other] = self.ends.map(|signs| {
            let tau = at_the_edges([first, second], signs);
            self.moment.at(tau) - self.opening.at(tau) * across
        });
        if one * other < 0.0 { 0.0 } else { one.abs().min(other.abs()) / self.sd_m }
    }
}

/// −ln of the posterior, up to a constant.
struct Posterior {
    intervals: Vec<Interval>,
    runs: [usize; 2],
    size_m: f64,
}

impl Posterior {
    fn of(given: &Given) -> Self {
        let Given { measurements, coefficients, friction, psi, psi_sd, regimes } = given;
        let size_m = coefficients[0];
        let samples = measurements.instants.iter().zip(*psi).zip(psi_sd.iter().zip(*regimes));
        let steady = samples.enumerate().filter(|(index, _)| !is_beside_a_change(regimes, *index));
        let steady = steady.map(|(_, sample)| sample);
        let seen = steady.filter(|((instant, _), _)| instant.both_seen());
        let interval = |((instant, psi), (psi_sd, regime)): ((&_, &f64), (&f64, &Regime))| {
            let at = contacts(instant, coefficients, *psi);
            let ends = ends(instant, &at, regime)?;
            let moment = Bilinear::of(|tau| moment(&instant.palms, &at, tau));
            let opening = Bilinear::of(|tau| opening(&instant.palms, tau));
            let by_psi = moment_by_psi(&instant.palms, &at, at_the_edges(*friction, ends[0]));
            let sd_m = (by_psi * psi_sd).hypot(FORM_ALLOWANCE * size_m);
            Some(Interval { moment, opening, direction: [psi.cos(), psi.sin()], ends, sd_m })
        };
        Self { intervals: seen.filter_map(interval).collect(), runs: runs(regimes), size_m }
    }

    fn cost(&self, at: &Vector4<f64>) -> f64 {
        let unknowns = [at[0], at[1], at[2], at[3]];
        if at[2].min(at[3]) < LEAST_FRICTION {
            return f64::INFINITY;
        }
        // Soft L1, as the fit of the strips has it.
        let of_interval = |interval: &Interval| {
            let missed = interval.missed(unknowns);
            (1.0 + missed * missed).sqrt() - 1.0
        };
        let of_center = 0.5 * (at[0] * at[0] + at[1] * at[1]) / (CENTER_SD * self.size_m).powi(2);
        let of_friction = |palm: usize| prior_of_friction(at[2 + palm], self.runs[palm]).cost;
        self.intervals.iter().map(of_interval).sum::<f64>() + of_center + of_friction(0) + of_friction(1)
    }

    /// The next of a chain: another place on the slice below the cost of this one, along a direction that is drawn.
    fn next(
        &self,
        (at, cost): (Vector4<f64>, f64),
        spread: &Matrix4<f64>,
        rng: &mut ChaCha8Rng,
    ) -> (Vector4<f64>, f64) {
        let direction = spread * Vector4::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal));
        let level = cost - (1.0 - rng.random::<f64>()).ln();
        let mut low = -BRACKET * rng.random::<f64>();
        let mut high = low + BRACKET;
        for _ in 0..SHRINKS {
            let along = low + (high - low) * rng.random::<f64>();
            let there = at + along * direction;
            let cost = self.cost(&there);
            if cost < level {
                return (there, cost);
            }
            if along < 0.0 { low = along } else { high = along }
        }
        (at, cost)
    }
}

/// Second moments of centre of mass (metres, in the frame of the form) and both coefficients of friction about the estimate. `covariance` is what is
/// believed of them before, where the search for how wide the posterior is begins. `None` where it is not positive definite.
pub(crate) fn second_moments(given: &Given, covariance: &Matrix4<f64>) -> Option<Matrix4<f64>> {
    let [first, second] = given.friction.map(|friction| friction.max(LEAST_FRICTION));
    Posterior::of(given).second_moments(&Vector4::new(0.0, 0.0, first, second), covariance)
}

impl Posterior {
    fn second_moments(&self, estimate: &Vector4<f64>, covariance: &Matrix4<f64>) -> Option<Matrix4<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut chain = (*estimate, self.cost(estimate));
        let mut spread = covariance.cholesky()?.l();
        let mut drawn = Vec::with_capacity(DRAWN);
        for _ in 0..EXPLORING.1 {
            drawn.clear();
            for _ in 0..EXPLORING.0 {
                chain = self.next(chain, &spread, &mut rng);
                drawn.push(chain.0);
            }
            let mean = drawn.iter().sum::<Vector4<f64>>() / drawn.len() as f64;
            let found = moments_about(&drawn, &mean) + LEAST_SHRINK * spread * spread.transpose();
            spread = found.cholesky()?.l();
        }
        drawn.clear();
        for _ in 0..DRAWN {
            chain = self.next(chain, &spread, &mut rng);
            drawn.push(chain.0);
        }
        Some(moments_about(&drawn, estimate))
    }
}

fn moments_about(drawn: &[Vector4<f64>], center: &Vector4<f64>) -> Matrix4<f64> {
    let squares = |sum: Matrix4<f64>, at: &Vector4<f64>| sum + (at - center) * (at - center).transpose();
    drawn.iter().fold(Matrix4::zeros(), squares) / drawn.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::palms::{Contacts, PalmPair};

    const SIZE_M: f64 = 0.03;

    fn posterior(intervals: Vec<Interval>, runs: [usize; 2]) -> Posterior {
        Posterior { intervals, runs, size_m: SIZE_M }
    }

    /// What confines x alone: 0 lies between edge μ₁ − x and −edge μ₁ − x.
    fn across(edge_m: f64, sd_m: f64) -> Interval {
        Interval {
            moment: Bilinear([0.0, edge_m, 0.0, 0.0]),
            opening: Bilinear([1.0, 0.0, 0.0, 0.0]),
            direction: [1.0, 0.0],
            ends: [[1.0, 0.0], [-1.0, 0.0]],
            sd_m,
        }
    }

    fn moments(posterior: &Posterior) -> Matrix4<f64> {
        let covariance = Matrix4::from_diagonal(&Vector4::new(1e-4, 1e-4, 0.1, 0.1));
        posterior.second_moments(&Vector4::new(0.0, 0.0, 0.2, 0.2), &covariance).expect("positive definite")
    }

    /// Mean over the prior of friction of one function, weighted by another.
    fn mean(of: impl Fn(f64) -> f64, weight: impl Fn(f64) -> f64) -> f64 {
        let places = (0..40_000).map(|index| 1e-4 * (f64::from(index) + 0.5));
        let (sum, mass) = places.fold((0.0, 0.0), |(sum, mass), mu| {
            let density = weight(mu) * (-prior_of_friction(mu, 0).cost).exp();
            (sum + density * of(mu), mass + density)
        });
        sum / mass
    }

    #[test]
    fn what_is_linear_in_both_ratios_is_known_by_four_values() {
        let instant = PalmPair::hinged(0.8, 1.3).angles();
        let at = Contacts { r: [0.03, 0.031], d: [2e-3, -3e-3], v: [0.03, 0.02] };
        let (of_moment, of_opening) =
            (Bilinear::of(|tau| moment(&instant, &at, tau)), Bilinear::of(|tau| opening(&instant, tau)));
        for tau in [[0.3, -0.2], [-0.1, 0.4], [0.0, 0.7]] {
            assert!((of_moment.at(tau) - moment(&instant, &at, tau)).abs() < 1e-12);
            assert!((of_opening.at(tau) - opening(&instant, tau)).abs() < 1e-12);
        }
    }

    #[test]
    fn without_a_sample_the_prior_is_left() {
        let found = moments(&posterior(Vec::new(), [0; 2]));
        let expected = [(CENTER_SD * SIZE_M).powi(2); 2].into_iter().chain([mean(|mu| (mu - 0.2).powi(2), |_| 1.0); 2]);
        for (index, expected) in expected.enumerate() {
            assert!((found[(index, index)] / expected - 1.0).abs() < 0.15, "{} {expected}", found[(index, index)]);
        }
    }

    #[test]
    fn an_interval_confines_to_an_even_distribution_within_it() {
        // x lies within ±edge μ₁, so that the density of μ₁ grows with μ₁.
        const EDGE_M: f64 = 1e-3;
        let found = moments(&posterior(vec![across(EDGE_M, 1e-7)], [0; 2]));
        let expected = EDGE_M * EDGE_M / 3.0 * mean(|mu| mu * mu, |mu| mu);
        assert!((found[(0, 0)] / expected - 1.0).abs() < 0.15, "{} {expected}", found[(0, 0)]);
        assert!((found[(1, 1)] / (CENTER_SD * SIZE_M).powi(2) - 1.0).abs() < 0.2);
    }

    #[test]
    fn an_equation_is_missed_as_soft_l1_has_it() {
        // A variance of K₂(1)/K₁(1) = 2.6995 over that of the sample (the hyperbolic distribution).
        let found = moments(&posterior(vec![across(0.0, 1e-5)], [0; 2]));
        assert!((found[(0, 0)] / (2.6995 * 1e-10) - 1.0).abs() < 0.15, "{}", found[(0, 0)]);
    }

    #[test]
    fn runs_that_stick_ask_for_little_friction() {
        // One such run takes away what the interval adds.
        const EDGE_M: f64 = 1e-3;
        let found = moments(&posterior(vec![across(EDGE_M, 1e-7)], [1, 0]));
        let expected = EDGE_M * EDGE_M / 3.0 * mean(|mu| mu * mu, |_| 1.0);
        assert!((found[(0, 0)] / expected - 1.0).abs() < 0.15, "{} {expected}", found[(0, 0)]);
        assert!(expected < 0.7 * EDGE_M * EDGE_M / 3.0 * mean(|mu| mu * mu, |mu| mu));
    }
}
