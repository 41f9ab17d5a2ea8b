//! What the harmonics that were left out of a shape may do to it. Where the penalty on v < 0 holds a shape (`docs/theory.md`, maximum likelihood), its
//! harmonics are too few for how flat or bent the object is, and the penalty passes that off as knowledge: a stadium, whose flat sides no
//! series of 16 harmonics has, came out 25 of its error bars off. The same log with twice as many harmonics says how far that may be.

use std::f64::consts::TAU;

use super::uncertainty::{FoundRig, PoseErrorBars, Uncertainty};
use crate::estimate::coverage::NODES;
use crate::estimate::jumps::DetectedJump;
use crate::estimate::measurements::Instant;
use crate::estimate::solver::gauss_newton::Estimate;
use crate::math::angle::{mean_direction, wrapped};
use crate::mechanics::ContactMode;
use crate::palms::PalmPair;
use crate::reconstruct::result::friction::FrictionEstimate;
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::shape::SupportFunction;

/// A shape is held convex where its least radius of curvature is below this share of its size: twice the margin of the penalty.
const HELD_SHARE: f64 = 0.016;

/// Whether the penalty on v < 0 holds a shape somewhere.
pub(crate) fn is_held_convex(coefficients: &[f64]) -> bool {
    let shape = SupportFunction::from_coefficients(coefficients);
    let least_m = (0..NODES).map(|node| shape.at(TAU * node as f64 / NODES as f64).v).fold(f64::INFINITY, f64::min);
    least_m < HELD_SHARE * coefficients[0].abs()
}

/// The error bars of an optimum, and how far it is from that with more harmonics; in the frame of the optimum.
pub(crate) struct WithLeftOut<'a> {
    of: &'a dyn Uncertainty,
    /// Both shapes, and the rotation that brings the second to the first.
    shapes: [SupportFunction; 2],
    turned_rad: f64,
    /// How far ψ and the centre of mass are from each other at each sample, radians and metres.
    psi_rad: Vec<f64>,
    center_m: Vec<f64>,
}

impl<'a> WithLeftOut<'a> {
    /// Of an optimum and that with more harmonics, for the palms at each sample.
    pub fn new(of: &'a dyn Uncertainty, [optimum, richer]: [&Estimate; 2], palms: &[PalmPair]) -> Self {
        let apart = || richer.psi.iter().zip(&optimum.psi).map(|(richer, psi)| richer - psi);
        let turned_rad = mean_direction(apart());
        let shapes = [optimum, richer].map(|estimate| SupportFunction::from_coefficients(&estimate.coefficients));
        let center = |which: usize, psi: f64, palms: &PalmPair| {
            let (theta1, theta2) = palms.contact_angles(psi);
            palms.center_of_mass_m(shapes[which].at(theta1), shapes[which].at(theta2))
        };
        let samples = optimum.psi.iter().zip(&richer.psi).zip(palms);
        let center_m = samples
            .map(|((psi, richer), palms)| {
                let ([x, y], [richer_x, richer_y]) = (center(0, *psi, palms), center(1, *richer, palms));
                (richer_x - x).hypot(richer_y - y) / 2_f64.sqrt()
            })
            .collect();
        let psi_rad = apart().map(|apart| wrapped(apart - turned_rad).abs()).collect();
        Self { of, turned_rad, psi_rad, center_m, shapes }
    }
}

struct ErrorBarsWithLeftOut<'a> {
    bars: Box<dyn PoseErrorBars + 'a>,
    of: &'a WithLeftOut<'a>,
}

impl Uncertainty for WithLeftOut<'_> {
    fn error_bars(&self, felt: &[f64], inflation: f64) -> Option<Box<dyn PoseErrorBars + '_>> {
        let bars = self.of.error_bars(felt, inflation)?;
        Some(Box::new(ErrorBarsWithLeftOut { bars, of: self }))
    }

    fn of_rig(&self, inflation: f64) -> Option<FoundRig> {
        self.of.of_rig(inflation)
    }

    fn inertia(&self) -> Option<InertiaEstimate> {
        self.of.inertia()
    }

    fn friction(&self) -> Option<FrictionEstimate> {
        self.of.friction()
    }

    fn modes(&self, index: usize) -> Option<[ContactMode; 2]> {
        self.of.modes(index)
    }

    fn jumps(&self, shape: &SupportFunction, palms: &[PalmPair], psi: &[f64]) -> Vec<DetectedJump> {
        self.of.jumps(shape, palms, psi)
    }
}

impl ErrorBarsWithLeftOut<'_> {
    fn apart_m(&self, theta: f64) -> f64 {
        let [shape, richer] = &self.of.shapes;
        richer.at(theta - self.of.turned_rad).r - shape.at(theta).r
    }
}

impl PoseErrorBars for ErrorBarsWithLeftOut<'_> {
    fn r_sd_m(&self, theta: f64) -> f64 {
        self.bars.r_sd_m(theta).hypot(self.apart_m(theta))
    }

    fn form_sd_m(&self, theta: f64) -> f64 {
        self.bars.form_sd_m(theta).hypot(self.apart_m(theta))
    }

    fn pose_sd(&self, index: usize, instant: &Instant) -> (f64, f64) {
        let (psi_rad, center_m) = self.bars.pose_sd(index, instant);
        (psi_rad.hypot(self.of.psi_rad[index]), center_m.hypot(self.of.center_m[index]))
    }

    fn deviance_of(&self, jumps: &[DetectedJump]) -> Option<f64> {
        self.bars.deviance_of(jumps)
    }
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
