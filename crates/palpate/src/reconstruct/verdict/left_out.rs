//! What the harmonics that were left out of a shape may do to it. Where the penalty on v < 0 holds a shape (`docs/theory.md`, maximum likelihood), its
//! harmonics are too few for how flat or bent the object is, and the penalty passes that off as knowledge: a stadium, whose flat sides no
//! series of 16 harmonics has, came out 25 of its error bars off. The same log with twice as many harmonics says how far that may be
//! (`verdict/mixture.rs`).

use std::f64::consts::TAU;

use crate::estimate::coverage::NODES;
use crate::shape::SupportFunction;

/// A shape is held convex where its least radius of curvature is below this share of its size: twice the margin of the penalty.
const HELD_SHARE: f64 = 0.016;

/// Whether the penalty on v < 0 holds a shape somewhere.
pub(crate) fn is_held_convex(coefficients: &[f64]) -> bool {
    let shape = SupportFunction::from_coefficients(coefficients);
    let least_m = (0..NODES).map(|node| shape.at(TAU * node as f64 / NODES as f64).v).fold(f64::INFINITY, f64::min);
    least_m < HELD_SHARE * coefficients[0].abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shape_with_a_corner_is_held_and_a_round_one_is_not() {
        // v = a0 - 3 a2 cos 2θ at the least.
        let of_least = |share: f64| vec![0.03, 0.0, 0.03 * (1.0 - share) / 3.0, 0.0, 0.0];
        assert!(!is_held_convex(&of_least(1.01 * HELD_SHARE)) && is_held_convex(&of_least(0.99 * HELD_SHARE)));
    }
}
