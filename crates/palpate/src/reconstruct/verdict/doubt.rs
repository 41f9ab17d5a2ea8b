//! Doubts, the reasons why a result is not certified, as data (`docs/theory.md`, the certificate): each with the numbers that
//! raised it, a sentence for the user, its cause, and what to do about it.

use std::fmt;

use crate::reconstruct::mistake::Mistake;
use crate::reconstruct::options::method::Method;
use crate::sensor::CalibrationConstant;

/// Where a doubt comes from. What stands first spoils what stands after it, and is to be mended first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Cause {
    /// How the log is written.
    Input,
    /// What lies between readings and truth: zeros, angles, scales, surfaces, clock.
    Rig,
    /// Single readings.
    Sensor,
    /// Forces that are not those of a smooth convex object at rest: friction, fast palms, jumps that statics does not make.
    Forces,
    /// What was felt, which does not tell all.
    Felt,
    /// How it was reconstructed.
    Method,
    /// Not known: a reason in words.
    Unknown,
}

/// The page of the documentation that has a section on each kind of doubt.
const PAGE: &str = "docs/verdict.md";

/// A reason why a result, or its centre of mass alone, is not certified. `Display` gives one sentence for the user,
/// [`next_step`](Doubt::next_step) what to do about it, and [`docs`](Doubt::docs) where more is said.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "kind", rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum Doubt {
    /// The mean radius came out negative.
    NegativeRadius,
    /// Jumps that the object found would not make.
    UnphysicalJumps {
        /// When the first of them happens, seconds.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        time_s: f64,
        /// By how much the object would turn there, radians.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        turn_rad: f64,
        /// How many there are.
        jumps: usize,
    },
    /// The contact positions are missed by more than their noise explains.
    Misfit {
        /// Root mean square of what the fit leaves, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        left_m: f64,
        /// What the noise explains, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        expected_m: f64,
        /// Whether log or user stated the noise; else it was estimated from the scatter of neighbouring samples.
        stated: bool,
    },
    /// The shape is not convex.
    NotConvex,
    /// Poses at rest that are no minimum of the potential energy.
    UnstablePoses {
        /// How many.
        samples: usize,
        /// Of so many.
        of: usize,
    },
    /// Too little of the boundary was felt to tell an object by.
    LittleFelt {
        /// Fraction of the boundary that was felt, 0 to 1.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        coverage: f64,
    },
    /// Samples whose pose could be another.
    AmbiguousPoses {
        /// How many.
        samples: usize,
        /// By how much the motion would be wrong if they were elsewhere, but for a few single ones: root mean square over all samples, radians.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        ambiguity_rad: f64,
    },
    /// The motion alternates between equilibria that next to no energy barrier separates.
    JumpReversals {
        /// How often.
        reversals: usize,
    },
    /// The orientation is hardly known.
    UncertainOrientation {
        /// Standard deviation over all samples, radians.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        sd_rad: f64,
        /// The largest of them, radians.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        largest_sd_rad: f64,
    },
    /// Parts of the felt boundary are hardly known.
    UncertainBoundary {
        /// Largest standard deviation of the felt boundary, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        sd_m: f64,
    },
    /// Contact readings far from those before and after them, or from where all others have the contact, which were left out.
    Outliers {
        /// How many.
        outliers: usize,
        /// Of so many.
        readings: usize,
    },
    /// Most contact readings fit, and a few are far off.
    StrayReadings {
        /// Standard deviation that most of them have, metres: from the median.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        typical_m: f64,
        /// Root mean square over all of them, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        all_m: f64,
    },
    /// The object found is symmetric, but the log hardly tells it from one that is not.
    UncertainSymmetry {
        /// Probability of the symmetry, 0 to 1.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        probability: f64,
        /// Standard deviation of the difference between felt copies of the same boundary, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        deviation_sd_m: f64,
    },
    /// A constant of the rig came out far from what the rig was stated to have.
    UnlikelyRig {
        /// Which, with its unit.
        constant: String,
        /// How far, in standard deviations of the statement.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        off_sds: f64,
    },
    /// The constants of the rig did not come to an optimum.
    UnsettledRig {
        /// By how much they would still move, in standard deviations.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        sds: f64,
    },
    /// Friction explains the log. Nothing certifies such a result.
    Friction {
        /// Coefficients of friction of both palms.
        coefficients: [f64; 2],
        /// Their standard deviations.
        sds: [f64; 2],
    },
    /// The log is explained if a mistake in how it is written is undone.
    Mistaken {
        /// Which, with its numbers.
        #[cfg_attr(feature = "serde", serde(flatten))]
        mistake: Mistake,
    },
    /// Several objects explain the log equally well.
    Alternatives {
        /// How many.
        objects: usize,
    },
    /// Force/torque balance does not hold within the noise: the centre of mass is only a best guess, shape and motion are
    /// certified.
    Unbalanced {
        /// Standard deviation of the balance, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        balance_sd_m: f64,
    },
    /// The log hardly tells where the centre of mass is in the form: it is only a best guess, shape and motion are certified.
    UncertainCenter {
        /// Its standard deviation, metres.
        #[cfg_attr(feature = "serde", serde(with = "crate::number_or_null"))]
        sd_m: f64,
    },
    /// The method has no certificate.
    UncertifiedMethod {
        /// Which.
        method: Method,
    },
    /// A reason that a file gives in words.
    Reported {
        /// The words.
        text: String,
    },
    /// A reason that a file gives in words why the centre of mass alone is not certified.
    ReportedOfCenterOfMass {
        /// The words.
        text: String,
    },
}

impl Doubt {
    /// Which kind it is, as files have it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::NegativeRadius => "negative-radius",
            Self::UnphysicalJumps { .. } => "unphysical-jumps",
            Self::Misfit { .. } => "misfit",
            Self::NotConvex => "not-convex",
            Self::UnstablePoses { .. } => "unstable-poses",
            Self::LittleFelt { .. } => "little-felt",
            Self::AmbiguousPoses { .. } => "ambiguous-poses",
            Self::JumpReversals { .. } => "jump-reversals",
            Self::UncertainOrientation { .. } => "uncertain-orientation",
            Self::UncertainBoundary { .. } => "uncertain-boundary",
            Self::Outliers { .. } => "outliers",
            Self::StrayReadings { .. } => "stray-readings",
            Self::UncertainSymmetry { .. } => "uncertain-symmetry",
            Self::UnlikelyRig { .. } => "unlikely-rig",
            Self::UnsettledRig { .. } => "unsettled-rig",
            Self::Friction { .. } => "friction",
            Self::Mistaken { .. } => "mistaken",
            Self::Alternatives { .. } => "alternatives",
            Self::Unbalanced { .. } => "unbalanced",
            Self::UncertainCenter { .. } => "uncertain-center",
            Self::UncertifiedMethod { .. } => "uncertified-method",
            Self::Reported { .. } => "reported",
            Self::ReportedOfCenterOfMass { .. } => "reported-of-center-of-mass",
        }
    }

    /// Where it comes from.
    pub fn cause(&self) -> Cause {
        match self {
            Self::Mistaken { .. } | Self::NegativeRadius => Cause::Input,
            Self::UnlikelyRig { .. } | Self::UnsettledRig { .. } => Cause::Rig,
            Self::Outliers { .. } | Self::StrayReadings { .. } => Cause::Sensor,
            Self::UnphysicalJumps { .. }
            | Self::Misfit { .. }
            | Self::NotConvex
            | Self::UnstablePoses { .. }
            | Self::Friction { .. }
            | Self::Unbalanced { .. } => Cause::Forces,
            Self::Alternatives { .. }
            | Self::LittleFelt { .. }
            | Self::AmbiguousPoses { .. }
            | Self::JumpReversals { .. }
            | Self::UncertainOrientation { .. }
            | Self::UncertainBoundary { .. }
            | Self::UncertainSymmetry { .. }
            | Self::UncertainCenter { .. } => Cause::Felt,
            Self::UncertifiedMethod { .. } => Cause::Method,
            Self::Reported { .. } | Self::ReportedOfCenterOfMass { .. } => Cause::Unknown,
        }
    }

    /// What to do about it; empty where only words are known.
    pub fn next_step(&self) -> String {
        match self {
            Self::Mistaken { mistake } => mistake.remedy(),
            Self::NegativeRadius => {
                "check the signs of the palm angles, and the end that the pads count from".to_owned()
            }
            Self::UnlikelyRig { constant, .. } => match CalibrationConstant::named(constant) {
                Some(CalibrationConstant { label, tolerance, .. }) => {
                    format!("measure the {label}, or state a larger {tolerance} in the rig file")
                }
                None => format!("measure {constant}, or state a larger tolerance in the rig file"),
            },
            Self::UnsettledRig { .. } => "state the constants of the rig better, or record longer".to_owned(),
            Self::Outliers { .. } => "look for a loose cable, a second touch or lost counts".to_owned(),
            Self::StrayReadings { .. } => {
                "look for a loose cable, a second touch or lost counts, and record again".to_owned()
            }
            Self::UnphysicalJumps { .. } => {
                "reduce friction and speed, and move the palms so that there are fewer jumps".to_owned()
            }
            Self::Misfit { .. } => {
                "look for friction, fast palms or lost contact, and for base points that are not where the log says"
                    .to_owned()
            }
            Self::NotConvex => "look for a second touch: only convex objects are reconstructed".to_owned(),
            Self::UnstablePoses { .. } | Self::Unbalanced { .. } => {
                "reduce friction, or move the palms more slowly".to_owned()
            }
            Self::Friction { .. } => "reduce friction, or measure the normal forces".to_owned(),
            Self::Alternatives { .. } => {
                "move so that more of the boundary is felt, or the same boundary twice: that tells them apart"
                    .to_owned()
            }
            Self::LittleFelt { .. } => "move the palms further, so that the object rolls".to_owned(),
            Self::AmbiguousPoses { .. } => "sample faster, or move more slowly there".to_owned(),
            Self::JumpReversals { .. } => {
                "use a less noisy sensor, or move so that the object rolls further".to_owned()
            }
            Self::UncertainOrientation { .. } => "move the palms further, over parts that are less round".to_owned(),
            Self::UncertainBoundary { .. } => "move over them again".to_owned(),
            Self::UncertainSymmetry { .. } => "feel more of the boundary twice".to_owned(),
            Self::UncertainCenter { .. } => "open the palms wider, or measure the normal forces".to_owned(),
            Self::UncertifiedMethod { .. } => {
                format!("reconstruct with the method {}, which has both", Method::Likelihood)
            }
            Self::Reported { .. } | Self::ReportedOfCenterOfMass { .. } => String::new(),
        }
    }

    /// Where the documentation says more of it: page and section.
    pub fn docs(&self) -> String {
        format!("{PAGE}#{}", self.kind())
    }

    /// Whether it contradicts the answer. (Else the answer may be right, though the log does not tell all.)
    pub fn is_contradiction(&self) -> bool {
        matches!(
            self,
            Self::NegativeRadius
                | Self::UnphysicalJumps { .. }
                | Self::Misfit { .. }
                | Self::NotConvex
                | Self::UnstablePoses { .. }
                | Self::Mistaken { .. }
        )
    }

    /// Whether it concerns the centre of mass alone.
    pub fn concerns_center_of_mass_only(&self) -> bool {
        matches!(self, Self::Unbalanced { .. } | Self::UncertainCenter { .. } | Self::ReportedOfCenterOfMass { .. })
    }
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NegativeRadius => f.write_str("no object explains the log (the mean radius comes out negative)"),
            Self::UnphysicalJumps { time_s, turn_rad, jumps } => {
                let others = if *jumps > 1 { format!(" and {} more", jumps - 1) } else { String::new() };
                write!(
                    f,
                    "the object found would not turn by {:.0} deg at {time_s:.3} s{others}: a jump goes downhill to the next pose",
                    turn_rad.to_degrees()
                )
            }
            Self::Misfit { left_m, expected_m, stated } => write!(
                f,
                "the fit leaves {:.3} mm in the contact positions, the noise {} explains {:.3} mm",
                1e3 * left_m,
                if *stated { "stated" } else { "seen between neighbouring samples" },
                1e3 * expected_m
            ),
            Self::NotConvex => f.write_str("the shape is not convex"),
            Self::UnstablePoses { samples, of } => {
                write!(f, "{samples} of {of} poses would not be at rest (their potential energy is not at a minimum)")
            }
            Self::LittleFelt { coverage } => {
                write!(f, "only {:.0} % of the boundary was felt, too little to tell an object by", 100.0 * coverage)
            }
            Self::AmbiguousPoses { samples, .. } => {
                let (noun, them, their) =
                    if *samples == 1 { ("sample", "it", "its") } else { ("samples", "them", "their") };
                write!(
                    f,
                    "the pose of {samples} {noun} cannot be told: another orientation explains {them} about as well ({their} \
                     psi_sd_rad says so)"
                )
            }
            Self::JumpReversals { reversals } => write!(
                f,
                "the object found goes to and fro between neighbouring poses ({reversals} times): it is too round, or the sensors \
                 too noisy, to tell them apart"
            ),
            Self::UncertainOrientation { sd_rad, largest_sd_rad } => write!(
                f,
                "the orientation is known only to {:.1} deg (one standard deviation over all samples, {:.1} deg at the worst of \
                 them): the felt boundary is too round, or too little of it was felt",
                sd_rad.to_degrees(),
                largest_sd_rad.to_degrees()
            ),
            Self::UncertainBoundary { sd_m } => {
                write!(f, "parts of the felt boundary are known only to {:.2} mm (one standard deviation)", 1e3 * sd_m)
            }
            Self::Outliers { outliers, readings } => write!(
                f,
                "{outliers} of {readings} contact readings ({:.1} %) are outliers, far from all others, and were left \
                 out; there may be more",
                100.0 * *outliers as f64 / (*readings).max(1) as f64
            ),
            Self::StrayReadings { typical_m, all_m } => write!(
                f,
                "most contact readings fit to {:.3} mm, but a few are so far off that all of them fit to {:.3} mm only",
                1e3 * typical_m,
                1e3 * all_m
            ),
            Self::UncertainSymmetry { probability, deviation_sd_m } => write!(
                f,
                "the object found is symmetric with a probability of {:.0} %, and copies of the same boundary are compared to {:.2} mm \
                 only (one standard deviation)",
                100.0 * probability,
                1e3 * deviation_sd_m
            ),
            Self::UnlikelyRig { constant, off_sds } => {
                let label = CalibrationConstant::named(constant).map_or(constant.as_str(), |about| about.label);
                write!(
                    f,
                    "by the log, the {label} is {off_sds:.1} standard deviations from what the rig is said to have"
                )
            }
            Self::UnsettledRig { sds } => write!(
                f,
                "the constants of the rig did not come to an optimum (they still move by {sds:.1} standard deviations)"
            ),
            Self::Friction { coefficients: [first, second], sds: [first_sd, second_sd] } => write!(
                f,
                "friction: coefficients of {first:.3} ± {first_sd:.3} on palm 1 and {second:.3} ± {second_sd:.3} on palm 2 explain the log; form, motion \
                 and centre of mass are the best guess with them, which nothing certifies"
            ),
            Self::Mistaken { mistake } => f.write_str(&mistake.told()),
            Self::Alternatives { objects } => write!(f, "{objects} different objects explain the log equally well"),
            Self::Unbalanced { balance_sd_m } => write!(
                f,
                "shape and motion are certified, the centre of mass is not: force/torque balance is missed by {:.2} mm \
                 (friction, or fast palms)",
                1e3 * balance_sd_m
            ),
            Self::UncertainCenter { sd_m } => write!(
                f,
                "shape and motion are certified, the centre of mass is not: it is known to {:.1} mm only, for the object hardly slides",
                1e3 * sd_m
            ),
            Self::UncertifiedMethod { method } => {
                write!(f, "the method {method} integrates and has neither error bars nor a certificate")
            }
            Self::Reported { text } | Self::ReportedOfCenterOfMass { text } => f.write_str(text),
        }
    }
}

/// The verdict on a result: certified when there is no doubt.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Verdict {
    /// All doubts, by their [`Cause`].
    pub doubts: Vec<Doubt>,
}

impl Verdict {
    /// With these doubts, whatever their order.
    pub fn new(mut doubts: Vec<Doubt>) -> Self {
        doubts.sort_by_key(Doubt::cause);
        Self { doubts }
    }

    /// Shape and motion are statistically consistent with the log, unique and convex.
    pub fn is_certified(&self) -> bool {
        self.doubts.iter().all(Doubt::concerns_center_of_mass_only)
    }

    /// Certified, and force/torque balance holds within the noise, so that the centre of mass is certified as well.
    pub fn is_com_certified(&self) -> bool {
        self.doubts.is_empty()
    }

    /// Nothing contradicts the answer, though the log may not tell all.
    pub fn is_explained(&self) -> bool {
        !self.doubts.iter().any(Doubt::is_contradiction)
    }

    /// Why not all is certified: the doubts in one line, empty where there are none.
    pub fn reason(&self) -> String {
        self.doubts.iter().map(Doubt::to_string).collect::<Vec<_>>().join("; ")
    }

    /// Whether single readings are all that contradicts the answer: jumps and poses are those that statics makes, but for `jumps_of_readings`: where all
    /// that are not there and back again, as single readings have it.
    pub(crate) fn doubts_stray_readings(&self, jumps_of_readings: bool) -> bool {
        let is_stray = |doubt: &Doubt| match doubt {
            Doubt::StrayReadings { .. } => true,
            Doubt::UnphysicalJumps { .. } => jumps_of_readings,
            _ => false,
        };
        let is_of_readings = |doubt: &Doubt| matches!(doubt, Doubt::Outliers { .. } | Doubt::Misfit { .. });
        self.doubts.iter().any(is_stray)
            && self.doubts.iter().all(|doubt| is_stray(doubt) || is_of_readings(doubt) || !doubt.is_contradiction())
    }

    /// Whether friction may explain the log and does not quite.
    pub(crate) fn doubts_friction(&self) -> bool {
        self.doubts.iter().any(|doubt| matches!(doubt, Doubt::Friction { .. }))
    }
}

impl fmt::Display for Verdict {
    /// What is certified, and why not the rest.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.is_com_certified(), self.is_certified()) {
            (true, _) => f.write_str("certified"),
            (_, true) => write!(f, "certified but for the centre of mass: {}", self.reason()),
            _ => write!(f, "not certified: {}", self.reason()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stray_readings_are_what_contradicts_an_answer_where_nothing_of_the_motion_does() {
        let stray = Doubt::StrayReadings { typical_m: 1e-4, all_m: 3e-4 };
        let misfit = Doubt::Misfit { left_m: 3e-4, expected_m: 1e-4, stated: false };
        let ambiguous = Doubt::AmbiguousPoses { samples: 1, ambiguity_rad: 0.1 };
        let doubts = |doubts: &[Doubt]| Verdict::new(doubts.to_vec()).doubts_stray_readings(false);
        assert!(doubts(std::slice::from_ref(&stray)) && doubts(&[stray.clone(), misfit.clone(), ambiguous]));
        assert!(!doubts(&[]) && !doubts(&[misfit]));
        let unstable = Doubt::UnstablePoses { samples: 5, of: 100 };
        let jumps = Doubt::UnphysicalJumps { time_s: 1.0, turn_rad: 1.0, jumps: 1 };
        assert!(!doubts(&[stray.clone(), unstable]) && !doubts(&[stray.clone(), jumps.clone()]));
        assert!(Verdict::new(vec![stray, jumps.clone()]).doubts_stray_readings(true));
        assert!(Verdict::new(vec![jumps]).doubts_stray_readings(true));
    }

    #[test]
    fn a_reported_doubt_about_the_centre_of_mass_leaves_shape_and_motion_certified() {
        let text = "force/torque balance does not hold".to_owned();
        let verdict = Verdict::new(vec![Doubt::ReportedOfCenterOfMass { text: text.clone() }]);
        assert!(verdict.is_certified() && !verdict.is_com_certified() && verdict.is_explained());
        assert_eq!(verdict.reason(), text);
        assert_eq!(verdict.to_string(), format!("certified but for the centre of mass: {text}"));
        assert_eq!(Verdict::default().to_string(), "certified");
        let verdict = Verdict::new(vec![Doubt::Reported { text }]);
        assert!(!verdict.is_certified() && !verdict.is_com_certified() && verdict.is_explained());
    }
}
