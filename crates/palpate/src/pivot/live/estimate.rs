//! What is known after a sample of strokes: plain data.

use crate::live::Stage;
use crate::pivot::error::PivotReconstructError;
use crate::pivot::live::follower::Followed;
use crate::pivot::result::{CenterOfMassEstimate, PivotReconstruction};
use crate::pivot::verdict::PivotDoubt;
use crate::reconstruct::OutlinePoint;
use crate::shape::SupportFunction;

/// Shape and orientation after the newest sample, with error bars, and what the answer is worth.
///
/// The object frame is that of the [`PivotReconstruction`] of the samples of the last search: its origin is the pivot, and ψ of the first contact is 0.
/// Before [`Stage::Following`] there is neither shape nor orientation.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct StrokesEstimate {
    /// Time of the newest sample, seconds; NaN before the first.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub time_s: f64,
    /// Samples that were taken.
    pub samples: u64,
    /// Samples that were not: no log of strokes can have them.
    pub refused: u64,
    /// How far it has come.
    pub stage: Stage,
    /// Body angle of the contact at the newest sample, radians, 0 to 2π; `None` without a shape, without a contact, or on boundary that was not felt before.
    pub theta_rad: Option<f64>,
    /// Orientation ψ of the object at the newest sample, radians, −π to π; `None` as above.
    pub psi_rad: Option<f64>,
    /// Standard deviation of both, radians: by noise, by the shape, and by other angles that explain the newest samples. Of certified
    /// estimates 96 % lie within two of it, and one in some thousand is far off (`docs/live.md`).
    pub psi_sd_rad: Option<f64>,
    /// Whether the newest contact is on boundary that the last search did not know, so that no angle is given.
    pub is_on_unfelt: bool,
    /// Support function about the pivot, by the last search.
    pub shape: Option<SupportFunction>,
    /// The boundary at 720 normal angles with error bars, by the last search; empty without a shape.
    pub outline: Vec<OutlinePoint>,
    /// Standard deviation of the felt boundary, root mean square, metres, by the last search; NaN without a shape.
    #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
    pub r_sd_m: f64,
    /// Fraction of the boundary (in normal angle) that the last search knew to be felt, 0 to 1.
    pub coverage: f64,
    /// Arrangements of the segments that fit equally well, by the last search; 1 when the answer is unique, 0 before there is one.
    pub alternatives: usize,
    /// Why the answer of the last search is not certified: empty where it is, `None` before there is an answer.
    pub doubts: Option<Vec<PivotDoubt>>,
    /// Whether the newest samples contradict the shape, so that the certificate no longer holds.
    pub is_contradicted: bool,
    /// Samples that the last search knew of; 0 before the first.
    pub searched: u64,
    /// Why the last search found nothing at all.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub failure: Option<PivotReconstructError>,
    /// Where the centre of mass is, where strokes tell it.
    pub center_of_mass: Option<CenterOfMassEstimate>,
}

impl Default for StrokesEstimate {
    fn default() -> Self {
        Self {
            time_s: f64::NAN,
            samples: 0,
            refused: 0,
            stage: Stage::Gathering,
            theta_rad: None,
            psi_rad: None,
            psi_sd_rad: None,
            is_on_unfelt: false,
            shape: None,
            outline: Vec::new(),
            r_sd_m: f64::NAN,
            coverage: 0.0,
            alternatives: 0,
            doubts: None,
            is_contradicted: false,
            searched: 0,
            failure: None,
            center_of_mass: None,
        }
    }
}

impl StrokesEstimate {
    /// The last search certified shape and motion, and no sample since contradicts them.
    pub fn is_certified(&self) -> bool {
        !self.is_contradicted && self.doubts.as_ref().is_some_and(Vec::is_empty)
    }

    /// Why it is not certified, in a sentence; empty where it is.
    pub fn reason(&self) -> String {
        if self.is_contradicted {
            return "the newest samples contradict the shape; another search corrects it".to_owned();
        }
        match (&self.doubts, &self.failure) {
            (Some(doubts), _) => doubts.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
            (None, Some(failure)) => failure.to_string(),
            (None, None) if self.stage == Stage::Gathering => "too few samples for a first search".to_owned(),
            (None, None) => "the first search is under way".to_owned(),
        }
    }

    /// Takes over what a search found.
    pub(super) fn renew(&mut self, found: PivotReconstruction) {
        self.stage = Stage::Following;
        self.r_sd_m = found.r_sd_m();
        self.coverage = found.coverage;
        self.alternatives = found.alternatives;
        self.center_of_mass = found.center_of_mass;
        self.shape = Some(found.shape);
        self.outline = found.outline;
        self.doubts = Some(found.doubts);
        self.failure = None;
    }

    /// Takes in where the newest contact is.
    pub(super) fn take(&mut self, followed: Followed) {
        let Followed { angle, is_on_unfelt, is_contradicted } = followed;
        (self.is_on_unfelt, self.is_contradicted) = (is_on_unfelt, is_contradicted);
        self.theta_rad = angle.map(|angle| angle.theta_rad);
        self.psi_rad = angle.map(|angle| angle.psi_rad);
        self.psi_sd_rad = angle.map(|angle| angle.sd_rad);
    }
}
