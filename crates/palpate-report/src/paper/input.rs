//! What the figures are drawn from: logs with their truth, reconstructed by both methods.

use palpate::pivot::{PivotLog, PivotReconstruction};
use palpate::sensor::VisionSystem;
use palpate::shape::SupportFunction;
use palpate::{Log, Reconstruction, Truth};

use crate::drawing::colors::{BLUE, ORANGE};

/// A way to reconstruct that the figures show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's differential equations.
    Ode,
    /// Maximum likelihood.
    Likelihood,
}

impl Method {
    pub(super) const BOTH: [Self; 2] = [Self::Ode, Self::Likelihood];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ode => "differential equations",
            Self::Likelihood => "maximum likelihood",
        }
    }

    /// As `palpate reconstruct --method` calls it.
    pub(super) fn option(self) -> &'static str {
        match self {
            Self::Ode => "ode",
            Self::Likelihood => "likelihood",
        }
    }

    pub(super) fn color(self) -> &'static str {
        match self {
            Self::Ode => ORANGE,
            Self::Likelihood => BLUE,
        }
    }
}

/// A simulated log with its truth, reconstructed by both methods.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// In a few words, such as "two palms".
    pub name: &'a str,
    /// Name of its log, without extension.
    pub file: &'a str,
    /// What the palms felt.
    pub log: &'a Log,
    /// What is true, or what a camera says is.
    pub truth: &'a Truth,
    /// The true shape, in the frame that the true motion belongs to.
    pub shape: &'a SupportFunction,
    /// Length of the touchpads, metres; of use in figure 8.
    pub pad_length_m: f64,
    /// By the differential equations.
    pub ode: &'a Reconstruction,
    /// By maximum likelihood.
    pub likelihood: &'a Reconstruction,
}

/// Strokes of the pivoting grasp, simulated on a level pad whose base is the origin, and reconstructed.
#[derive(Clone, Copy, Debug)]
pub struct StrokesTrial<'a> {
    /// What pad and arm read.
    pub log: &'a PivotLog,
    /// What is true.
    pub truth: &'a Truth,
    /// The true shape about the pivot.
    pub shape: &'a SupportFunction,
    /// By maximum likelihood.
    pub found: &'a PivotReconstruction,
}

impl<'a> PaperInput<'a> {
    /// All trials, in the order of the table of errors.
    pub(super) fn trials(&self) -> [&Trial<'a>; 4] {
        [&self.palms, &self.exact, &self.fingers, &self.experiment]
    }
}

impl<'a> Trial<'a> {
    pub(super) fn found(&self, method: Method) -> &'a Reconstruction {
        match method {
            Method::Ode => self.ode,
            Method::Likelihood => self.likelihood,
        }
    }
}

/// Everything that the figures show.
#[derive(Clone, Copy, Debug)]
pub struct PaperInput<'a> {
    /// The simulation of figures 6 and 7, palms with a common hinge.
    pub palms: Trial<'a>,
    /// The same without noise, as the paper had it.
    pub exact: Trial<'a>,
    /// The same with two fingers.
    pub fingers: Trial<'a>,
    /// The experiment of figure 8.
    pub experiment: Trial<'a>,
    /// The pivoting grasp of figure 9.
    pub strokes: StrokesTrial<'a>,
    /// The camera of the experiment.
    pub vision: &'a VisionSystem,
    /// Boundary that was felt fewer times is left out of figure 8(b).
    pub min_touches: u32,
    /// Standard deviation of the contact positions in the simulations, metres.
    pub simulation_sd_m: f64,
    /// Version of the program, for the footer.
    pub version: &'a str,
}
