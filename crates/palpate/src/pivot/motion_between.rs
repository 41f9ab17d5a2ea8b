//! What is believed of the motion between samples: the contact angle changes at a rate that hardly changes. Second differences of θ within a segment are
//! independent and of Student's t: where the object begins to slide, tips over or is dragged the other way they are large. Weights and scale by
//! iteration (Lange, Little & Taylor, *Journal of the American Statistical Association* 84, 1989).
//!
//! It decides where readings alone hardly tell an angle, as around d = 0: there the sides of the crossing could be shifted against each other.

use std::ops::Range;

use crate::math::banded::{Banded, BandedCholesky};

/// Degrees of freedom.
const DEGREES: f64 = 2.0;

/// Samples that are further apart than this many of the usual spacing tell nothing of each other.
const FURTHEST: usize = 3;

/// Least scale, radians: no motion is smoother.
pub(super) const LEAST_SD_RAD: f64 = 1e-3;

/// Scale that a fit begins with, radians.
pub(super) const FIRST_SD_RAD: f64 = 0.02;

/// Readings of a second difference, which is as far as the angles depend on each other.
pub(super) const SPAN: usize = 3;

/// Second differences of the angles of three readings one after another: shares of each.
#[derive(Clone, Copy, Debug)]
struct Triple {
    first: usize,
    shares: [f64; SPAN],
}

/// The second differences of a log.
#[derive(Clone, Debug, Default)]
pub(super) struct MotionBetween {
    triples: Vec<Triple>,
    readings: usize,
}

impl MotionBetween {
    /// Of the readings of segments, which are the samples of these numbers; at some of them the object may well leap.
    pub fn new(ranges: &[Range<usize>], numbers: &[usize], leaps_there: &[bool]) -> Self {
        let triple = |first: usize| {
            let [before, after] = [1, 2].map(|next| numbers[first + next] - numbers[first + next - 1]);
            let near = before.max(after) <= FURTHEST && !leaps_there[first + 1] && !leaps_there[first + 2];
            let (before, after) = (before as f64, after as f64);
            let half = 0.5 * (before + after);
            near.then(|| Triple {
                first,
                shares: [1.0 / (before * half), -(1.0 / before + 1.0 / after) / half, 1.0 / (after * half)],
            })
        };
        let within = ranges.iter().flat_map(|range| range.start..range.end.saturating_sub(2).max(range.start));
        let readings = numbers.len();
        Self { triples: if readings >= SPAN { within.filter_map(triple).collect() } else { Vec::new() }, readings }
    }

    fn second_difference(&self, triple: &Triple, theta_rad: &[f64]) -> f64 {
        triple.shares.iter().zip(&theta_rad[triple.first..]).map(|(share, theta)| share * theta).sum()
    }

    /// −ln of the prior of a motion, up to a constant.
    pub fn cost(&self, theta_rad: &[f64], sd_rad: f64) -> f64 {
        let of = |triple: &Triple| (self.second_difference(triple, theta_rad) / sd_rad).powi(2);
        let sum: f64 = self.triples.iter().map(|triple| (of(triple) / DEGREES).ln_1p()).sum();
        0.5 * (DEGREES + 1.0) * sum + self.triples.len() as f64 * sd_rad.ln()
    }

    /// The weight of a second difference, over the square of the scale.
    fn weight(difference: f64, sd_rad: f64) -> f64 {
        (DEGREES + 1.0) / (DEGREES * sd_rad * sd_rad + difference * difference)
    }

    /// The information on the angles, of their own readings and of each other, and the gradient of the cost by them: to what readings alone say this adds
    /// the prior. `None` where it is no minimum of either.
    pub fn joined(
        &self,
        own: impl Iterator<Item = f64>,
        theta_rad: &[f64],
        sd_rad: f64,
        gradient: &mut [f64],
    ) -> Option<BandedCholesky<SPAN>> {
        let mut information = Banded::zeros(self.readings);
        information.add_diagonal(own);
        for triple in &self.triples {
            let difference = self.second_difference(triple, theta_rad);
            let weight = Self::weight(difference, sd_rad);
            information.add_outer_product(triple.first, &triple.shares, weight);
            let places = gradient[triple.first..].iter_mut();
            places.zip(triple.shares).for_each(|(place, share)| *place += weight * difference * share);
        }
        information.cholesky()
    }

    /// The scale by what the second differences leave over their redundancy; `inverse` is that of [`joined`](Self::joined).
    pub fn scale_rad(&self, theta_rad: &[f64], sd_rad: f64, inverse: &Banded<SPAN>) -> f64 {
        let (mut squares, mut redundancy) = (0.0, 0.0);
        for triple in &self.triples {
            let difference = self.second_difference(triple, theta_rad);
            let weight = Self::weight(difference, sd_rad) * sd_rad * sd_rad;
            squares += weight * difference * difference;
            redundancy += 1.0 - (weight * inverse.quadratic(triple.first, &triple.shares) / (sd_rad * sd_rad)).min(1.0);
        }
        if redundancy > 3.0 { (squares / redundancy).sqrt().max(LEAST_SD_RAD) } else { sd_rad }
    }

    /// Whether there is anything to believe.
    pub fn is_empty(&self) -> bool {
        self.triples.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SD_RAD: f64 = 0.01;

    fn motion() -> (MotionBetween, Vec<f64>) {
        let numbers: Vec<usize> = (0..12).chain([14, 15, 16, 30, 31, 32]).collect();
        let theta = (0..18).map(|i| 0.05 * f64::from(i) + 0.02 * (1.7 * f64::from(i)).sin()).collect();
        (MotionBetween::new(&[0..9, 9..18], &numbers, &[false; 18]), theta)
    }

    #[test]
    fn gradient_and_information_are_those_of_finite_differences() {
        let (between, theta) = motion();
        let mut gradient = vec![0.0; 18];
        between.joined([1.0; 18].into_iter(), &theta, SD_RAD, &mut gradient).expect("positive definite");
        for (index, exact) in gradient.iter().enumerate() {
            let cost = |by: f64| {
                let mut moved = theta.clone();
                moved[index] += by;
                between.cost(&moved, SD_RAD)
            };
            let slope = (cost(1e-6) - cost(-1e-6)) / 2e-6;
            assert!((slope - exact).abs() < 1e-4 * exact.abs().max(1.0), "{index}: {slope} {exact}");
        }
    }

    #[test]
    fn a_steady_turn_costs_nothing_wherever_samples_are_missing() {
        let (between, _) = motion();
        let numbers: Vec<f64> = (0..12).chain([14, 15, 16, 30, 31, 32]).map(f64::from).collect();
        let steady: Vec<f64> = numbers.iter().map(|number| 0.3 - 0.04 * number).collect();
        let still = between.cost(&[0.0; 18], SD_RAD);
        assert!((between.cost(&steady, SD_RAD) - still).abs() < 1e-9);
    }

    #[test]
    fn segments_gaps_and_leaps_are_not_bridged() {
        let numbers: Vec<usize> = (0..18).collect();
        let whole = MotionBetween::new(std::slice::from_ref(&(0..18)), &numbers, &[false; 18]);
        assert_eq!(whole.triples.len(), 16);
        let apart = |gap: usize| {
            let numbers: Vec<usize> = (0..9).chain(8 + gap..17 + gap).collect();
            MotionBetween::new(std::slice::from_ref(&(0..18)), &numbers, &[false; 18]).triples.len()
        };
        assert_eq!((apart(FURTHEST), apart(FURTHEST + 1)), (16, 14));
        let mut leaps = [false; 18];
        leaps[9] = true;
        assert_eq!(MotionBetween::new(std::slice::from_ref(&(0..18)), &numbers, &leaps).triples.len(), 14);
        let first = |readings: usize| {
            MotionBetween::new(std::slice::from_ref(&(0..readings)), &numbers[..readings], &vec![false; readings])
        };
        assert!(first(SPAN - 1).is_empty() && !first(SPAN).is_empty());
    }

    #[test]
    fn the_scale_is_found_again() {
        let numbers: Vec<usize> = (0..4000).collect();
        let between = MotionBetween::new(std::slice::from_ref(&(0..4000)), &numbers, &vec![false; 4000]);
        // Second differences of Student's t with two degrees of freedom, in closed form from the uniform ones.
        let (mut theta, mut rate, mut state) = (vec![0.0], 0.0, 1_u64);
        for _ in 1..4000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let uniform = ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
            rate += 0.004 * (2.0 * uniform - 1.0) / (2.0 * uniform * (1.0 - uniform)).sqrt();
            theta.push(theta.last().expect("there is one") + rate);
        }
        // Readings that tell every angle exactly.
        let mut sd_rad = FIRST_SD_RAD;
        for _ in 0..50 {
            let mut gradient = vec![0.0; 4000];
            let factor = between.joined((0..4000).map(|_| 1e12), &theta, sd_rad, &mut gradient).expect("definite");
            sd_rad = between.scale_rad(&theta, sd_rad, &factor.inverse_in_band());
        }
        assert!((sd_rad / 0.004 - 1.0).abs() < 0.1, "{sd_rad}");
    }
}
