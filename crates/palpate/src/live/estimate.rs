//! What is known after a sample: plain data.

use crate::math::angle::wrapped;
use crate::reconstruct::{
    CalibrationEstimate, FoundSymmetry, FrictionEstimate, OutlinePoint, Pose, ReconstructError, Reconstruction, Verdict,
};
use crate::shape::SupportFunction;

/// How far an online estimate has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Stage {
    /// Too few samples for a first search.
    #[default]
    Gathering,
    /// Nothing has been found that determines a shape.
    Searching,
    /// Shape and pose are known to the error bars given, as far as the verdict goes.
    Following,
}

/// Shape, pose and centre of mass after the newest sample, with error bars, and what the answer is worth.
///
/// The object frame is that of the [`Reconstruction`](crate::Reconstruction) of the same samples: its origin is the centre of mass, and ψ of the
/// first sample is 0. Before [`Stage::Following`] there is no shape and no pose.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Estimate {
    /// Time of the newest sample, seconds; NaN before the first.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub time_s: f64,
    /// Samples that were taken.
    pub samples: u64,
    /// Samples that were not: no palm log can have them.
    pub refused: u64,
    /// How far it has come.
    pub stage: Stage,
    /// The pose at the newest sample.
    pub pose: Option<Pose>,
    /// Support function about the centre of mass.
    pub shape: Option<SupportFunction>,
    /// The boundary at 720 normal angles with error bars, renewed every [`OUTLINE_EVERY`](super::OUTLINE_EVERY) samples; empty without a shape. `touches` are those of the last search, and
    /// 1 where the boundary was felt for the first time since.
    pub outline: Vec<OutlinePoint>,
    /// Fraction of the boundary (in normal angle) that was felt, 0 to 1.
    pub coverage: f64,
    /// Poses that the newest samples may have; 1 when there is no doubt, 0 without a shape.
    pub hypotheses: usize,
    /// Objects that explain the samples equally well, by the last search; 1 when the answer is unique, 0 before there is one.
    pub alternatives: usize,
    /// What the last search found the answer to be worth; `None` before there is an answer.
    pub verdict: Option<Verdict>,
    /// Whether the newest samples contradict the shape, so that the verdict no longer holds.
    pub contradicted: bool,
    /// Whether the pose of the newest sample is hardly known: several poses explain it, the last few samples are further off than noise allows, the
    /// object was on boundary that is not known since the last search, or the standard deviation of ψ is above that of the certificate
    /// ([`CertificateLimits::largest_psi_sd_rad`](crate::reconstruct::CertificateLimits::largest_psi_sd_rad)).
    pub ambiguous: bool,
    /// Samples that the last search knew of; 0 before the first.
    pub searched: u64,
    /// Why the last search found nothing at all.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub failure: Option<ReconstructError>,
    /// Standard deviation of the contact positions, metres; NaN before there is an answer.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub sensor_sd_m: f64,
    /// How the object is symmetric.
    pub symmetry: FoundSymmetry,
    /// What is known of the rig; `None` where every constant of it is exact, or nothing is known yet.
    pub calibration: Option<CalibrationEstimate>,
    /// Coefficients of friction, where friction explains what balance without it does not.
    pub friction: Option<FrictionEstimate>,
}

impl Default for Estimate {
    fn default() -> Self {
        Self {
            time_s: f64::NAN,
            samples: 0,
            refused: 0,
            stage: Stage::Gathering,
            pose: None,
            shape: None,
            outline: Vec::new(),
            coverage: 0.0,
            hypotheses: 0,
            alternatives: 0,
            verdict: None,
            contradicted: false,
            ambiguous: false,
            searched: 0,
            failure: None,
            sensor_sd_m: f64::NAN,
            symmetry: FoundSymmetry::default(),
            calibration: None,
            friction: None,
        }
    }
}

impl Estimate {
    /// The last search certified shape and motion, nothing since contradicts them, and the pose of the newest sample is not in doubt.
    pub fn is_certified(&self) -> bool {
        !self.ambiguous && self.is_still_certified()
    }

    /// The last search certified shape and motion, and nothing since contradicts them.
    pub(super) fn is_still_certified(&self) -> bool {
        !self.contradicted && self.verdict.as_ref().is_some_and(Verdict::is_certified)
    }

    /// The same of the centre of mass as well.
    pub fn is_com_certified(&self) -> bool {
        self.is_certified() && self.verdict.as_ref().is_some_and(Verdict::is_com_certified)
    }

    /// Why it is not certified, in a sentence; empty where it is, with its centre of mass.
    pub fn reason(&self) -> String {
        if self.contradicted {
            return "the newest samples contradict the shape; another search corrects it".to_owned();
        }
        match (&self.verdict, &self.failure) {
            (Some(verdict), _) if self.ambiguous && verdict.is_certified() => {
                "the pose of the newest sample is ambiguous".to_owned()
            }
            (Some(verdict), _) => verdict.reason(),
            (None, Some(failure)) => failure.to_string(),
            (None, None) if self.stage == Stage::Gathering => "too few samples for a first search".to_owned(),
            (None, None) => "the first search is under way".to_owned(),
        }
    }

    /// Distance of the shape from a reconstruction, after the best rotation over the boundary that both felt: root mean square, in standard deviations of the
    /// latter. `None` without a shape, NaN where they felt nothing in common.
    pub fn distance_sds(&self, found: &Reconstruction) -> Option<f64> {
        let shape = self.shape.as_ref()?;
        let felt = found.outline.iter().zip(&self.outline).filter(|(a, b)| a.touches > 0 && b.touches > 0);
        let rows: Vec<[f64; 3]> = felt
            .map(|(point, _)| {
                [shape.at(point.theta_rad).r - point.r_m, -found.shape.at(point.theta_rad).d, point.r_sd_m]
            })
            .collect();
        let turn = rows.iter().map(|[off, slope, _]| off * slope).sum::<f64>()
            / rows.iter().map(|[_, slope, _]| slope * slope).sum::<f64>();
        let squares = rows.iter().map(|[off, slope, sd]| ((off - turn * slope) / sd).powi(2));
        Some((squares.sum::<f64>() / rows.len() as f64).sqrt())
    }

    /// How far the orientation is from that of a known object, after the best rotation over the felt boundary: radians, 0 to π. `shape` is the support
    /// function of that object, and its orientations those at the first sample and at the newest. `None` without a shape, NaN where nothing was felt.
    pub fn psi_error_rad(&self, shape: &SupportFunction, [psi_first_rad, psi_rad]: [f64; 2]) -> Option<f64> {
        /// Gauss-Newton steps to the best rotation.
        const STEPS: usize = 4;
        let (psi_found, found) = (self.pose.as_ref()?.psi_rad, self.shape.as_ref()?);
        let felt = || self.outline.iter().filter(|point| point.touches > 0);
        let mut turn = psi_first_rad;
        for _ in 0..STEPS {
            let (mut off, mut slope) = (0.0, 0.0);
            for point in felt() {
                let known = shape.at(point.theta_rad - turn);
                off += (found.at(point.theta_rad).r - known.r) * known.d;
                slope += known.d * known.d;
            }
            turn += off / slope;
        }
        Some(wrapped(psi_found + turn - psi_rad).abs())
    }

    /// Standard deviation of r over the felt boundary, root mean square, metres; NaN without a shape.
    pub fn r_sd_m(&self) -> f64 {
        let felt = || self.outline.iter().filter(|point| point.touches > 0);
        (felt().map(|point| point.r_sd_m.powi(2)).sum::<f64>() / felt().count() as f64).sqrt()
    }
}
