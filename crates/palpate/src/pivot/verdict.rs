//! Whether a result is certified: consistent with the noise, unique, convex, and known well. Shares are of the mean radius.

use std::fmt;

/// χ² per degree of freedom may exceed 1 by so many of its own standard deviations, √(2/dof) …
pub(super) const CHI2_SDS: f64 = 6.0;

/// … and in any case by this where the noise is stated,
pub(super) const CHI2_EXCESS_STATED: f64 = 0.2;

/// and by this where it is estimated from the scatter of neighbouring samples.
pub(super) const CHI2_EXCESS_ESTIMATED: f64 = 0.5;

/// Systematic errors up to this share are forgiven: the noise that the fit is held against is never less.
pub(super) const MODEL_ALLOWANCE: f64 = 3e-4;

/// Least fraction of the boundary that tells an object.
pub(super) const LEAST_COVERAGE: f64 = 0.1;

/// Largest standard deviation of the felt boundary, root mean square.
pub(super) const MOST_R_SD: f64 = 0.02;

/// Largest standard deviation of the contact angle, root mean square, radians.
pub(super) const MOST_THETA_SD_RAD: f64 = 0.03;

/// Largest standard deviation of the contact angle at any sample, radians: P stands over a contact whose radius of curvature is its height.
pub(super) const MOST_BLIND_RAD: f64 = 0.6;

/// The felt boundary is not convex where its radius of curvature is below 0 by so many standard deviations.
pub(super) const CONCAVE_SDS: f64 = 5.0;

/// A rival arrangement is clearly worse by so many nats.
pub(super) const RIVAL_NATS: f64 = 12.0;

/// A constant of the rig may be off what was stated by so many standard deviations.
pub(super) const RIG_OFF_SDS: f64 = 3.0;

/// Share of the samples with a contact that may be left out of the fit.
pub(super) const MOST_LEFT_OUT: f64 = 0.1;

/// A reason why a result is not certified. `Display` gives one sentence for the user, [`next_step`](PivotDoubt::next_step) what to do about it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum PivotDoubt {
    /// The mean radius, or the support function somewhere on the felt boundary, came out negative.
    NegativeRadius,
    /// The readings are missed by more than their noise explains.
    Misfit {
        /// Root mean square of what the fit leaves over what the noise explains.
        times_noise: f64,
        /// Whether the noise was stated; else it was estimated from the scatter of neighbouring samples.
        stated: bool,
    },
    /// The readings ask for as many harmonics as there are, and might ask for more.
    NotSmooth {
        /// Harmonics of the result.
        harmonics: usize,
    },
    /// The felt boundary is not convex.
    NotConvex,
    /// Too little of the boundary was felt to tell an object by.
    LittleFelt {
        /// Fraction of the boundary that was felt, 0 to 1.
        coverage: f64,
    },
    /// Other arrangements of the segments fit as well.
    Ambiguous {
        /// How many in all, this one among them.
        alternatives: usize,
    },
    /// The contact leaps within segments, where nothing says how far.
    Leaps {
        /// How often.
        leaps: usize,
    },
    /// Some strokes begin at another angle than most, though the object hung free before each.
    OtherStarts {
        /// How many.
        strokes: usize,
    },
    /// The boundary is not known well enough.
    WideErrorBars {
        /// Standard deviation of r over the felt boundary, root mean square, metres.
        r_sd_m: f64,
    },
    /// The motion is not known well enough.
    UncertainMotion {
        /// Standard deviation of the contact angle, root mean square, radians.
        theta_sd_rad: f64,
        /// The largest of any sample, radians.
        largest_sd_rad: f64,
    },
    /// A constant of the rig is far from what was stated.
    RigOff {
        /// How far, in standard deviations.
        sds: f64,
    },
    /// Many samples could not be used.
    LeftOut {
        /// Their share, 0 to 1.
        share: f64,
    },
}

impl fmt::Display for PivotDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NegativeRadius => write!(f, "the object found does not surround its pivot"),
            Self::Misfit { times_noise, stated } => write!(
                f,
                "the readings are missed by {times_noise:.1} times {}",
                if *stated { "the stated noise" } else { "the noise that neighbouring samples show" }
            ),
            Self::NotSmooth { harmonics } => write!(
                f,
                "{harmonics} harmonics explain the readings better than fewer: edges are seldom so sharp, and strokes that are laid together wrongly look like it"
            ),
            Self::NotConvex => write!(f, "the felt boundary is not convex"),
            Self::LittleFelt { coverage } => {
                write!(f, "only {:.0} % of the boundary was felt", 100.0 * coverage)
            }
            Self::Ambiguous { alternatives } => {
                write!(
                    f,
                    "{alternatives} arrangements of the segments fit equally well: it is not told which side each of them felt"
                )
            }
            Self::Leaps { leaps } => {
                write!(f, "the object leaps {leaps} times from one sample to the next, and nothing says how far")
            }
            Self::OtherStarts { strokes } => write!(
                f,
                "{strokes} of the strokes begin with the object turned otherwise than most, though it hung free before each of them"
            ),
            Self::WideErrorBars { r_sd_m } => {
                write!(f, "the felt boundary is known to {:.3} mm only", 1e3 * r_sd_m)
            }
            Self::UncertainMotion { theta_sd_rad, largest_sd_rad } => write!(
                f,
                "the orientation is known to {:.1}\u{b0} only ({:.1}\u{b0} where it is known least): height and offset hardly change as the \
                 object turns there",
                theta_sd_rad.to_degrees(),
                largest_sd_rad.to_degrees()
            ),
            Self::RigOff { sds } => {
                write!(f, "a constant of the rig is {sds:.1} standard deviations from what was stated")
            }
            Self::LeftOut { share } => {
                write!(
                    f,
                    "{:.0} % of the samples with a contact have no pose: they are in stretches too short to use, or beside a leap",
                    100.0 * share
                )
            }
        }
    }
}

impl PivotDoubt {
    /// What to do about it, one sentence.
    pub fn next_step(&self) -> &'static str {
        match self {
            Self::NegativeRadius => "Check the height of the pad and the direction in which the pad counts.",
            Self::Misfit { .. } => {
                "Check the pose of the pad, the pivot's place in the gripper and the zero of the pad; or state larger tolerances."
            }
            Self::NotSmooth { .. } => {
                "Make strokes longer, so that each feels boundary of others; sample faster where the object tips over an edge."
            }
            Self::NotConvex => "Check zero and scale of the pad; a hollow side is bridged and cannot be felt.",
            Self::LittleFelt { .. } => "Drag further, in both directions, or press harder so that the object rolls.",
            Self::Ambiguous { .. } => "Make strokes longer, so that they feel boundary in common.",
            Self::OtherStarts { .. } => "Let the object swing to rest before it is set down, and its axis turn freely.",
            Self::WideErrorBars { .. } => "Make more strokes over the same boundary.",
            Self::UncertainMotion { .. } => "Hold the object at another place, further from the middle.",
            Self::RigOff { .. } => "Measure the rig again, or state what is known of it.",
            Self::Leaps { .. } | Self::LeftOut { .. } => "Drag more slowly, or sample faster.",
        }
    }
}

/// What a verdict rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Findings {
    pub size_m: f64,
    pub least_r_m: f64,
    pub chi2_per_dof: f64,
    pub dof: f64,
    pub noise_stated: bool,
    pub coverage: f64,
    pub r_sd_m: f64,
    pub theta_sd_rad: f64,
    pub largest_theta_sd_rad: f64,
    /// Harmonics of the result, where the evidence chose them and had no more to choose.
    pub most_harmonics: Option<usize>,
    /// How far the radius of curvature is below 0 on the felt boundary, in standard deviations.
    pub concave_sds: f64,
    pub alternatives: usize,
    pub leaps: usize,
    pub other_starts: usize,
    pub rig_off_sds: f64,
    pub left_out: f64,
}

impl Findings {
    /// All doubts.
    pub fn doubts(&self) -> Vec<PivotDoubt> {
        let mut doubts = Vec::new();
        if !(self.size_m > 0.0 && self.least_r_m > 0.0) {
            doubts.push(PivotDoubt::NegativeRadius);
        }
        let least = if self.noise_stated { CHI2_EXCESS_STATED } else { CHI2_EXCESS_ESTIMATED };
        let excess = (CHI2_SDS * (2.0 / self.dof.max(1.0)).sqrt()).max(least);
        if !(self.chi2_per_dof <= 1.0 + excess) {
            doubts.push(PivotDoubt::Misfit { times_noise: self.chi2_per_dof.sqrt(), stated: self.noise_stated });
        }
        if let Some(harmonics) = self.most_harmonics {
            doubts.push(PivotDoubt::NotSmooth { harmonics });
        }
        if !(self.concave_sds <= CONCAVE_SDS) {
            doubts.push(PivotDoubt::NotConvex);
        }
        if !(self.coverage >= LEAST_COVERAGE) {
            doubts.push(PivotDoubt::LittleFelt { coverage: self.coverage });
        }
        if self.alternatives > 1 {
            doubts.push(PivotDoubt::Ambiguous { alternatives: self.alternatives });
        }
        if self.leaps > 0 {
            doubts.push(PivotDoubt::Leaps { leaps: self.leaps });
        }
        if self.other_starts > 0 {
            doubts.push(PivotDoubt::OtherStarts { strokes: self.other_starts });
        }
        if !(self.r_sd_m <= MOST_R_SD * self.size_m) {
            doubts.push(PivotDoubt::WideErrorBars { r_sd_m: self.r_sd_m });
        }
        if !(self.theta_sd_rad <= MOST_THETA_SD_RAD && self.largest_theta_sd_rad <= MOST_BLIND_RAD) {
            doubts.push(PivotDoubt::UncertainMotion {
                theta_sd_rad: self.theta_sd_rad,
                largest_sd_rad: self.largest_theta_sd_rad,
            });
        }
        if !(self.rig_off_sds <= RIG_OFF_SDS) {
            doubts.push(PivotDoubt::RigOff { sds: self.rig_off_sds });
        }
        if !(self.left_out <= MOST_LEFT_OUT) {
            doubts.push(PivotDoubt::LeftOut { share: self.left_out });
        }
        doubts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: Findings = Findings {
        size_m: 0.03,
        least_r_m: 0.02,
        chi2_per_dof: 1.0,
        dof: 900.0,
        noise_stated: false,
        coverage: 0.8,
        r_sd_m: 1e-5,
        theta_sd_rad: 3e-3,
        largest_theta_sd_rad: 0.02,
        most_harmonics: None,
        concave_sds: 0.0,
        alternatives: 1,
        leaps: 0,
        other_starts: 0,
        rig_off_sds: 0.0,
        left_out: 0.0,
    };

    /// On one side of each limit there is no doubt, on the other the one that is meant.
    #[test]
    fn every_limit_decides() {
        assert!(GOOD.doubts().is_empty());
        let chi2 =
            |dof: f64, noise_stated: bool, chi2_per_dof: f64| Findings { dof, noise_stated, chi2_per_dof, ..GOOD };
        let few = CHI2_SDS * 0.2_f64.sqrt();
        let pairs: [(Findings, Findings); 15] = [
            (chi2(900.0, true, 1.0 + 0.99 * CHI2_SDS * (2.0_f64 / 900.0).sqrt()), chi2(900.0, true, 1.3)),
            (chi2(1e6, true, 0.99 + CHI2_EXCESS_STATED), chi2(1e6, true, 1.01 + CHI2_EXCESS_STATED)),
            (chi2(1e6, false, 0.99 + CHI2_EXCESS_ESTIMATED), chi2(1e6, false, 1.01 + CHI2_EXCESS_ESTIMATED)),
            (chi2(10.0, false, 0.99 + few), chi2(10.0, false, 1.01 + few)),
            (
                Findings { coverage: 1.01 * LEAST_COVERAGE, ..GOOD },
                Findings { coverage: 0.99 * LEAST_COVERAGE, ..GOOD },
            ),
            (
                Findings { r_sd_m: 0.99 * MOST_R_SD * 0.03, ..GOOD },
                Findings { r_sd_m: 1.01 * MOST_R_SD * 0.03, ..GOOD },
            ),
            (
                Findings { theta_sd_rad: 0.99 * MOST_THETA_SD_RAD, ..GOOD },
                Findings { theta_sd_rad: 1.01 * MOST_THETA_SD_RAD, ..GOOD },
            ),
            (
                Findings { largest_theta_sd_rad: 0.99 * MOST_BLIND_RAD, ..GOOD },
                Findings { largest_theta_sd_rad: 1.01 * MOST_BLIND_RAD, ..GOOD },
            ),
            (
                Findings { concave_sds: 0.99 * CONCAVE_SDS, ..GOOD },
                Findings { concave_sds: 1.01 * CONCAVE_SDS, ..GOOD },
            ),
            (
                Findings { rig_off_sds: 0.99 * RIG_OFF_SDS, ..GOOD },
                Findings { rig_off_sds: 1.01 * RIG_OFF_SDS, ..GOOD },
            ),
            (Findings { left_out: 0.99 * MOST_LEFT_OUT, ..GOOD }, Findings { left_out: 1.01 * MOST_LEFT_OUT, ..GOOD }),
            (GOOD, Findings { alternatives: 2, ..GOOD }),
            (GOOD, Findings { most_harmonics: Some(48), ..GOOD }),
            (GOOD, Findings { leaps: 1, ..GOOD }),
            (GOOD, Findings { other_starts: 1, ..GOOD }),
        ];
        for (within, beyond) in pairs {
            assert_eq!(within.doubts(), [], "{within:?}");
            assert_eq!(beyond.doubts().len(), 1, "{beyond:?}");
        }
        assert_eq!(Findings { least_r_m: -1.0, ..GOOD }.doubts(), [PivotDoubt::NegativeRadius]);
    }

    #[test]
    fn what_is_not_a_number_is_a_doubt() {
        let lost = Findings { chi2_per_dof: f64::NAN, r_sd_m: f64::NAN, theta_sd_rad: f64::NAN, ..GOOD };
        assert_eq!(lost.doubts().len(), 3);
        assert!(lost.doubts().iter().all(|doubt| !doubt.to_string().is_empty() && !doubt.next_step().is_empty()));
    }
}
