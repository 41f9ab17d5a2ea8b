//! The result of a reconstruction: plain data, shared by files, the report and Python.

use crate::mechanics::Jump;
use crate::reconstruct::verdict::certificate::Findings;
use crate::reconstruct::verdict::doubt::Verdict;
use crate::shape::{SupportFunction, Symmetry};

/// Shape, motion and centre of mass of the object behind a log, with error bars and a verdict.
///
/// The object frame has its origin at the centre of mass and is turned so that ψ of the first sample is 0. The
/// [methods](crate::reconstruct::Method) that integrate have no error bars: their standard deviations of r, ψ and the centre of mass are
/// NaN, which a CSV file has as `NaN` and JSON as `null`. They are never certified.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reconstruction {
    /// Support function about the centre of mass.
    pub shape: SupportFunction,
    /// The boundary at 720 equally spaced normal angles over [0, 2π), with error bars.
    pub outline: Vec<OutlinePoint>,
    /// One pose per sample of the log, in the same order.
    pub motion: Vec<Pose>,
    /// How the object is symmetric. The boundary is completed by it: what was felt once is known on every copy, and `touches`
    /// counts all of them. ψ is then defined up to multiples of its period between pieces; the motion given is one that statics
    /// allows.
    #[cfg_attr(feature = "serde", serde(default))]
    pub symmetry: FoundSymmetry,
    /// What it is worth, with every doubt.
    pub verdict: Verdict,
    /// What the verdict rests on; `None` where there is no certificate, or where a result was read from files.
    pub findings: Option<Findings>,
    /// Weighted squared residuals per degree of freedom; near 1 for a fit that is consistent with the noise.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub chi2_per_dof: f64,
    /// The jumps to other poses, in order of time.
    pub jumps: Vec<Jump>,
    /// Fraction of the boundary (in normal angle) that was felt, 0 to 1.
    pub coverage: f64,
    /// Number of distinct arrangements that fit equally well; 1 when the answer is unique.
    pub alternatives: usize,
    /// The arrangements besides this one that fit equally well (`alternatives` − 1 of them, at most four).
    pub others: Vec<Reconstruction>,
    /// Standard deviation of the contact positions, metres: stated by the log, or estimated from it.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub sensor_sd_m: f64,
    /// Standard deviation of the balance equation, metres.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub balance_sd_m: f64,
}

impl Reconstruction {
    /// Shape and motion are statistically consistent with the log, unique and convex.
    pub fn is_certified(&self) -> bool {
        self.verdict.is_certified()
    }

    /// Certified, and force/torque balance holds within the noise, so that the centre of mass is certified as well.
    pub fn is_com_certified(&self) -> bool {
        self.verdict.is_com_certified()
    }
}

/// The symmetry of an object as the log has it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoundSymmetry {
    /// The most likely one.
    pub symmetry: Symmetry,
    /// Its probability, or that of no symmetry where there is none, 0 to 1; NaN where this was not asked.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub probability: f64,
}

impl Default for FoundSymmetry {
    /// Not asked.
    fn default() -> Self {
        Self { symmetry: Symmetry::NONE, probability: f64::NAN }
    }
}

/// One point of the reconstructed boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OutlinePoint {
    /// Outward normal angle θ in the object frame, radians.
    pub theta_rad: f64,
    /// Support function r(θ), metres.
    pub r_m: f64,
    /// Posterior standard deviation of r(θ) after the best rotation, metres.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub r_sd_m: f64,
    /// Boundary point, x in the object frame, metres.
    pub x_m: f64,
    /// Boundary point, y in the object frame, metres.
    pub y_m: f64,
    /// Radius of curvature v(θ), metres.
    pub curvature_radius_m: f64,
    /// How many separate passes of a contact went over this angle; 0 = never felt.
    pub touches: u32,
}

/// The reconstructed pose at one sample, with what is left of its measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Pose {
    /// Time in seconds.
    pub time_s: f64,
    /// Orientation ψ in radians, unwrapped within a piece.
    pub psi_rad: f64,
    /// Posterior standard deviation of ψ, radians.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub psi_sd_rad: f64,
    /// Centre of mass, X in the global frame, metres.
    pub com_x_m: f64,
    /// Centre of mass, Y in the global frame, metres.
    pub com_y_m: f64,
    /// Posterior standard deviation of the centre of mass (root of the mean of both variances), metres.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub com_sd_m: f64,
    /// Normal angle of the object at contact 1, radians.
    pub theta1_rad: f64,
    /// Normal angle of the object at contact 2, radians.
    pub theta2_rad: f64,
    /// Counts up at each jump, from 0.
    pub piece: u32,
    /// Measured minus predicted s1, metres; `None` where contact 1 was not seen.
    pub residual1_m: Option<f64>,
    /// Measured minus predicted s2, metres; `None` where contact 2 was not seen.
    pub residual2_m: Option<f64>,
}
