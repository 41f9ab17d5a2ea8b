//! The result of a reconstruction: plain data, shared by files, the report and Python.

use crate::estimate::coverage::{LONGEST_SLIDE, nodes_between};
use crate::mechanics::{ContactMode, Jump};
use crate::reconstruct::result::calibration::CalibrationEstimate;
use crate::reconstruct::result::friction::FrictionEstimate;
use crate::reconstruct::result::inertia::InertiaEstimate;
use crate::reconstruct::verdict::certificate::Findings;
use crate::reconstruct::verdict::doubt::Verdict;
use crate::shape::{SupportFunction, Symmetry};
use std::fmt;

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
    /// What the log told of the rig; `None` where every constant of it is exact.
    #[cfg_attr(feature = "serde", serde(default))]
    pub calibration: Option<CalibrationEstimate>,
    /// Coefficients of friction, where friction explains what balance without it does not; the centre of mass is then that of
    /// Coulomb's law.
    #[cfg_attr(feature = "serde", serde(default))]
    pub friction: Option<FrictionEstimate>,
    /// How the object resists being turned, where its inertia explains what balance does not; jumps are then motions like any other.
    #[cfg_attr(feature = "serde", serde(default))]
    pub inertia: Option<InertiaEstimate>,
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

    /// Root mean square of the standard deviation of the centre of mass over the motion, metres.
    pub fn com_sd_m(&self) -> f64 {
        com_sd_m(&self.motion)
    }

    /// Which points of the outline a contact itself passed over: the others of those that count as felt are known by symmetry.
    pub fn felt_itself(&self) -> Vec<bool> {
        if !self.symmetry.symmetry.is_any() || self.outline.is_empty() {
            return self.outline.iter().map(|point| point.touches > 0).collect();
        }
        let mut itself = vec![false; self.outline.len()];
        let contact1 = |pose: &Pose| pose.residual1_m.map(|_| pose.theta1_rad);
        let contact2 = |pose: &Pose| pose.residual2_m.map(|_| pose.theta2_rad);
        self.mark_felt(&mut itself, contact1);
        self.mark_felt(&mut itself, contact2);
        itself
    }

    fn mark_felt(&self, felt: &mut [bool], contact: impl Fn(&Pose) -> Option<f64>) {
        let mut before: Option<(u32, f64)> = None;
        for pose in &self.motion {
            let Some(to) = contact(pose).filter(|theta| theta.is_finite()) else { continue };
            // Of a step this long, or to another piece, only the end was felt.
            let slid = before.filter(|(piece, from)| *piece == pose.piece && (to - from).abs() < LONGEST_SLIDE);
            let from = slid.map_or(to, |(_, from)| from);
            for node in nodes_between(from.min(to), from.max(to), felt.len()) {
                felt[node] = self.outline[node].touches > 0;
            }
            before = Some((pose.piece, to));
        }
    }
}

/// The symmetry of an object as the log has it, or that it has none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FoundSymmetry {
    /// The most likely one.
    pub symmetry: Symmetry,
    /// Its probability, or that of no symmetry where there is none, 0 to 1; `None` where this was not asked.
    pub probability: Option<f64>,
    /// How well the log tells a deviation from it: the standard deviation of the difference of r between copies that were both felt,
    /// metres (root mean square); `None` where there is no symmetry.
    pub deviation_sd_m: Option<f64>,
}

impl fmt::Display for FoundSymmetry {
    /// In words, as in "the object is …".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { symmetry, probability, deviation_sd_m } = self;
        write!(f, "{symmetry}")?;
        if !symmetry.is_any() {
            return Ok(());
        }
        let limits = [
            probability.map(|p| format!("probability {:.2}", (100.0 * p).floor() / 100.0)),
            deviation_sd_m.map(|sd_m| {
                format!("differences up to {:.3} mm between felt copies are not excluded", 2.0 * MM_PER_M * sd_m)
            }),
        ];
        let limits: Vec<String> = limits.into_iter().flatten().collect();
        if !limits.is_empty() {
            write!(f, " ({})", limits.join("; "))?;
        }
        if symmetry.order > 1 {
            let period = symmetry.period_rad().to_degrees();
            write!(f, "; after a jump ψ is known up to turns of {}°", (10.0 * period).round() / 10.0)?;
        }
        Ok(())
    }
}

const MM_PER_M: f64 = 1e3;

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
    /// Whether the object sticks to palm 1 and to palm 2, or slides along them; `None` where friction does not say.
    #[cfg_attr(feature = "serde", serde(default))]
    pub modes: Option<[ContactMode; 2]>,
}

/// Standard deviation of ψ from which on a pose is open, radians: a certificate allows it for a few samples only.
const OPEN_RAD: f64 = 0.3;

impl Pose {
    /// Whether the log leaves open where the object is: it may be at another pose. Not a number is not known.
    pub fn is_open(&self) -> bool {
        self.psi_sd_rad.is_nan() || self.psi_sd_rad >= OPEN_RAD
    }
}

/// Root mean square of the standard deviation of the centre of mass, metres.
pub(crate) fn com_sd_m(motion: &[Pose]) -> f64 {
    let squares = motion.iter().map(|pose| pose.com_sd_m.powi(2)).sum::<f64>();
    (squares / motion.len().max(1) as f64).sqrt()
}

#[cfg(test)]
impl Pose {
    /// The pose of a test: exact, about the origin.
    pub(crate) fn of_test(time_s: f64, psi_rad: f64) -> Self {
        Self {
            time_s,
            psi_rad,
            psi_sd_rad: 0.0,
            com_x_m: 0.0,
            com_y_m: 0.0,
            com_sd_m: 0.0,
            theta1_rad: 0.0,
            theta2_rad: 0.0,
            piece: 0,
            residual1_m: None,
            residual2_m: None,
            modes: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symmetry_reads_as_words() {
        let symmetry = Symmetry { order: 3, mirror: true };
        let found = FoundSymmetry { symmetry, probability: Some(0.998), deviation_sd_m: Some(2.1e-5) };
        let words = "the same after 1/3 of a turn and in a mirror (probability 0.99; differences up to 0.042 mm between felt copies are not \
                     excluded); after a jump ψ is known up to turns of 120°";
        assert_eq!(found.to_string(), words);
        assert_eq!(FoundSymmetry::default().to_string(), "not symmetric");
        let mirror = Symmetry { order: 1, mirror: true };
        assert_eq!(FoundSymmetry { symmetry: mirror, ..FoundSymmetry::default() }.to_string(), "its own mirror image");
    }
}
