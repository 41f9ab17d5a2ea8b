//! A stretch of the log at its optimum with friction, and what that tells of friction by itself.

use super::Settled;
use crate::estimate::friction::smoother::Optimum;
use crate::estimate::solver::gauss_newton::Fit;
use std::ops::Range;

/// Friction acts on a stretch with a coefficient of more than this (without any, stretches have up to 0.007, and with 0.02 at least 0.018). Where the
/// object rolls for this share of the samples, the coefficient is the least that holds it, however little is known of how much more it may be.
const ACTS: f64 = 0.012;
const ROLLS: f64 = 0.5;

/// A stretch is explained where the standard deviations of slip and of the forces come down to these shares of the mean radius: right ones leave half of
/// it at most, and wrong ones three times as much.
const EXPLAINED: [f64; 2] = [5e-4, 1.5e-3];

/// A stretch tells that there is friction, or none, where so many standard deviations less, or more, would still be on the same side of that.
const TOLD_SDS: f64 = 2.0;

/// Motions that differ by more are not the same, radians.
pub(super) const SAME_RAD: f64 = 0.05;

/// A stretch with what is known there.
pub(super) struct Stretch {
    pub range: Range<usize>,
    pub fit: Fit,
    pub settled: Settled,
}

impl Stretch {
    pub fn is_explained(&self) -> bool {
        let Optimum { noise, unknowns, .. } = &self.settled.optimum;
        let size_m = unknowns.coefficients[0];
        noise.slip_m < EXPLAINED[0] * size_m && noise.forces_m < EXPLAINED[1] * size_m
    }

    /// Samples of the log at which a jump has just ended.
    pub fn starts(&self) -> Vec<usize> {
        self.settled.starts.iter().map(|start| self.range.start + start).collect()
    }

    /// Where both slip and forces come down, mechanics holds.
    pub fn missed_m2(&self) -> f64 {
        self.settled.optimum.noise.forces_m * self.settled.optimum.noise.slip_m
    }

    /// Whether it is another with the same motion.
    pub fn is_same(&self, other: &Self) -> bool {
        let [psi, of_other] = [self, other].map(|stretch| &stretch.settled.optimum.unknowns.psi);
        let turned = |(a, b): (&f64, &f64)| (a - psi[0]) - (b - of_other[0]);
        self.range == other.range && psi.iter().zip(of_other).all(|pair| turned(pair).abs() < SAME_RAD)
    }

    /// Standard deviations of the coefficients of friction.
    fn friction_sds(&self) -> [f64; 2] {
        let optimum = &self.settled.optimum;
        let (covariance, friction) = (optimum.eliminated.covariance(), optimum.unknowns.coefficients.len());
        [friction, friction + 1].map(|unknown| optimum.sd(&covariance, unknown))
    }

    /// What it tells of friction.
    pub fn told(&self) -> Told {
        let Settled { optimum, regimes, .. } = &self.settled;
        let rolls = regimes.iter().filter(|regime| regime.sticks().is_some()).count() as f64;
        told(optimum.unknowns.friction, self.friction_sds(), rolls / regimes.len() as f64)
    }
}

/// What a stretch tells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Told {
    Friction,
    None,
    Nothing,
}

/// What a stretch with these coefficients and their standard deviations tells, of which the object rolls for some share.
fn told(friction: [f64; 2], sds: [f64; 2], rolls: f64) -> Told {
    let at = |palm: usize, sds_more: f64| friction[palm] + sds_more * sds[palm];
    let least_sds = if rolls > ROLLS { 0.0 } else { -TOLD_SDS };
    if (0..2).any(|palm| at(palm, least_sds) > ACTS) {
        Told::Friction
    } else if (0..2).all(|palm| at(palm, TOLD_SDS) < ACTS) {
        Told::None
    } else {
        Told::Nothing
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_tells_of_friction_beyond_the_least_coefficient() {
        let sds = [0.001, 0.002];
        assert_eq!(told([0.001, 0.0161], sds, 0.0), Told::Friction);
        assert_eq!(told([0.001, 0.0159], sds, 0.0), Told::Nothing);
        assert_eq!(told([0.0099, 0.0079], sds, 0.0), Told::None);
        assert_eq!(told([0.0099, 0.0081], sds, 0.0), Told::Nothing);
    }

    #[test]
    fn what_rolls_is_held_by_the_least_coefficient_that_it_needs() {
        let sds = [0.1, 0.2];
        assert_eq!(told([0.001, 0.0121], sds, 0.51), Told::Friction);
        assert_eq!(told([0.001, 0.0121], sds, 0.49), Told::Nothing);
        assert_eq!(told([0.001, 0.0119], sds, 0.51), Told::Nothing);
    }
}
