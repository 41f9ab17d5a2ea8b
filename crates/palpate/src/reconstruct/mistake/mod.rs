//! Mistakes in how a log is written, such as swapped pads or an angle from the wrong line: what each is, what mends it, and the log without
//! it. `by_readings` recognises those that the readings show, `recognition` the others by undoing them: readings of an object are explained
//! by one only if they are taken right.

pub(super) mod by_readings;
mod recognition;

use std::f64::consts::FRAC_PI_2;
use std::fmt;

use crate::log::{Log, Sample};
use crate::palms::PalmPair;

/// A common mistake in how a log is written. `Display` says what it is, [`remedy`](Mistake::remedy) what mends it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(tag = "mistake", rename_all = "kebab-case")
)]
#[non_exhaustive]
pub enum Mistake {
    /// φ₁ is counted clockwise.
    Phi1Clockwise,
    /// φ₂ is counted clockwise.
    Phi2Clockwise,
    /// Both angles are counted clockwise.
    BothClockwise,
    /// φ₁ is counted from the vertical, counter-clockwise.
    Phi1FromVertical,
    /// φ₁ is counted from the vertical, clockwise.
    Phi1FromVerticalClockwise,
    /// φ₂ is counted from the horizontal, as φ₁ is.
    Phi2FromHorizontal,
    /// φ₁ and φ₂ are exchanged.
    AnglesSwapped,
    /// The positions of both palms are exchanged.
    PadsSwapped,
    /// All of palm 1 stands under the names of palm 2, and the reverse.
    PalmsSwapped,
    /// A pad is read from its far end.
    ReadFromTip {
        /// Position of that end of pad 1, metres from the base of its palm; `None` where that pad is read from the base.
        length1_m: Option<f64>,
        /// The same of pad 2.
        length2_m: Option<f64>,
    },
    /// The zero of a pad is many tolerances from where the rig has it.
    ZeroOff {
        /// What pad 1 adds to every position, metres; `None` where that is as stated.
        zero1_m: Option<f64>,
        /// The same of pad 2.
        zero2_m: Option<f64>,
    },
    /// Readings are taken as exact, and have the errors of an ordinary rig.
    RigNotExact,
    /// Angles in radians were read as degrees.
    RadiansAsDegrees,
    /// Positions in metres were read as millimetres.
    MetersAsMillimeters,
    /// Positions in millimetres were read as metres.
    MillimetersAsMeters,
    /// Exact zeros stand where there was no contact.
    ZerosForNoContact {
        /// Readings that are zero.
        readings: usize,
    },
    /// Positions are rounded too coarsely.
    CoarsePositions {
        /// The step that they are rounded to, metres.
        step_m: f64,
    },
    /// Angles are rounded too coarsely.
    CoarseAngles {
        /// The step that they are rounded to, radians.
        step_rad: f64,
    },
}

/// Millimetres in a metre.
const MILLI: f64 = 1e3;

impl Mistake {
    /// What to do about it.
    pub fn remedy(&self) -> String {
        let of_palms = |key: &str, values: [Option<f64>; 2], beside: &str| {
            let of_palm = |(palm, value): (usize, &Option<f64>)| {
                value.map(|value_m| format!("{beside}`{key} = {:.1}` below `[palm{}]`", MILLI * value_m, palm + 1))
            };
            let told: Vec<String> = values.iter().enumerate().filter_map(of_palm).collect();
            format!("write {} into the rig file (the log says so to a tenth of a millimetre or so)", told.join(" and "))
        };
        let fixed = match *self {
            Self::ReadFromTip { length1_m, length2_m } => {
                return of_palms("length_mm", [length1_m, length2_m], "`direction = \"to_base\"` and ");
            }
            Self::ZeroOff { zero1_m, zero2_m } => return of_palms("zero_mm", [zero1_m, zero2_m], ""),
            Self::Phi1Clockwise => "write `sign1 = -1` below `[angles]` into the rig file",
            Self::Phi2Clockwise => "write `sign2 = -1` below `[angles]` into the rig file",
            Self::BothClockwise => "write `sign1 = -1` and `sign2 = -1` below `[angles]` into the rig file",
            Self::Phi1FromVertical => "write `phi1_zero_deg = -90` below `[angles]` into the rig file",
            Self::Phi1FromVerticalClockwise => {
                "write `sign1 = -1` and `phi1_zero_deg = -90` below `[angles]` into the rig file"
            }
            Self::Phi2FromHorizontal => "write phi2 - phi1 into the column of phi2",
            Self::AnglesSwapped => "exchange the names of phi1 and phi2 in the header of the log",
            Self::PadsSwapped => "exchange the names of s1 and s2 in the header of the log",
            Self::PalmsSwapped => {
                "exchange the names of s1 and s2 (and of base points and forces), and write phi1 + phi2 for phi1 and -phi2 for phi2"
            }
            Self::RigNotExact => {
                "give a rig file with tolerances (`palpate rig --template` prints one), and not `--calibrated`; in Python `rig=palpate.Rig()`"
            }
            Self::RadiansAsDegrees => "name a column in radians `phi1_rad` or `phi2_rad`",
            Self::MetersAsMillimeters => "name a column in metres `s1_m` or `s2_m`",
            Self::MillimetersAsMeters => "name a column in millimetres `s1_mm` or `s2_mm`",
            Self::ZerosForNoContact { .. } => "leave the cell empty where there was no contact",
            Self::CoarsePositions { .. } | Self::CoarseAngles { .. } => {
                "write every digit that the sensor gives: round nothing on the way into the log"
            }
        };
        fixed.to_owned()
    }

    /// What a doubt says of it.
    pub(super) fn told(&self) -> String {
        if self.is_borne_out() { format!("{self}: read so, the log is explained") } else { self.to_string() }
    }

    /// Whether it was recognised because the log is explained without it, and not by the readings alone.
    fn is_borne_out(&self) -> bool {
        match self {
            Self::RadiansAsDegrees
            | Self::MetersAsMillimeters
            | Self::MillimetersAsMeters
            | Self::ZerosForNoContact { .. }
            | Self::CoarsePositions { .. }
            | Self::CoarseAngles { .. } => false,
            Self::Phi1Clockwise
            | Self::Phi2Clockwise
            | Self::BothClockwise
            | Self::Phi1FromVertical
            | Self::Phi1FromVerticalClockwise
            | Self::Phi2FromHorizontal
            | Self::AnglesSwapped
            | Self::PadsSwapped
            | Self::PalmsSwapped
            | Self::ReadFromTip { .. }
            | Self::ZeroOff { .. }
            | Self::RigNotExact => true,
        }
    }

    /// The log without this mistake, for a rig with these stated zeros of its pads (metres); `None` where nothing brings back what was written
    /// off, or where the log is as it should be.
    fn undone_for(&self, log: &Log, zeros_m: [f64; 2]) -> Option<Log> {
        let angles = |change: &dyn Fn(f64, f64) -> (f64, f64)| {
            let turned = |sample: &Sample| {
                let (phi1_rad, phi2_rad) = change(sample.palms.phi1_rad, sample.palms.phi2_rad);
                Sample { palms: PalmPair { phi1_rad, phi2_rad, ..sample.palms }, ..*sample }
            };
            Log { samples: log.samples.iter().map(turned).collect() }
        };
        let positions = |change: [&dyn Fn(f64) -> f64; 2]| {
            let moved = |sample: &Sample| Sample {
                s1_m: sample.s1_m.map(change[0]),
                s2_m: sample.s2_m.map(change[1]),
                ..*sample
            };
            Log { samples: log.samples.iter().map(moved).collect() }
        };
        Some(match *self {
            Self::Phi1Clockwise => angles(&|phi1, phi2| (-phi1, phi2)),
            Self::Phi2Clockwise => angles(&|phi1, phi2| (phi1, -phi2)),
            Self::BothClockwise => angles(&|phi1, phi2| (-phi1, -phi2)),
            Self::Phi1FromVertical => angles(&|phi1, phi2| (phi1 + FRAC_PI_2, phi2)),
            Self::Phi1FromVerticalClockwise => angles(&|phi1, phi2| (FRAC_PI_2 - phi1, phi2)),
            Self::Phi2FromHorizontal => angles(&|phi1, phi2| (phi1, phi2 - phi1)),
            Self::AnglesSwapped => angles(&|phi1, phi2| (phi2, phi1)),
            Self::PadsSwapped => with_pads_exchanged(log),
            Self::PalmsSwapped => {
                let palms = |palms: PalmPair| PalmPair {
                    phi1_rad: palms.phi12_rad(),
                    phi2_rad: -palms.phi2_rad,
                    base1_m: palms.base2_m,
                    base2_m: palms.base1_m,
                };
                let exchanged = with_pads_exchanged(log);
                let turned = |sample: &Sample| Sample {
                    palms: palms(sample.palms),
                    force1_n: sample.force2_n,
                    force2_n: sample.force1_n,
                    ..*sample
                };
                Log { samples: exchanged.samples.iter().map(turned).collect() }
            }
            Self::ReadFromTip { length1_m, length2_m } => {
                let from_base = |length_m: Option<f64>| move |s: f64| length_m.map_or(s, |length_m| length_m - s);
                positions([&from_base(length1_m), &from_base(length2_m)])
            }
            Self::ZeroOff { zero1_m, zero2_m } => {
                let moved = |palm: usize, zero_m: Option<f64>| {
                    move |s: f64| zero_m.map_or(s, |zero_m| s - (zero_m - zeros_m[palm]))
                };
                positions([&moved(0, zero1_m), &moved(1, zero2_m)])
            }
            Self::RadiansAsDegrees => {
                let is_small = by_readings::angles_that_look_like_radians_in_degrees(log);
                let scale = is_small.map(|small| if small { 1f64.to_degrees() } else { 1.0 });
                angles(&|phi1, phi2| (scale[0] * phi1, scale[1] * phi2))
            }
            Self::MetersAsMillimeters | Self::MillimetersAsMeters => {
                let scale = by_readings::scales(log);
                positions([&|s| scale[0] * s, &|s| scale[1] * s])
            }
            Self::ZerosForNoContact { .. } => {
                let seen = |s: Option<f64>| s.filter(|s| *s != 0.0);
                let without = |sample: &Sample| Sample { s1_m: seen(sample.s1_m), s2_m: seen(sample.s2_m), ..*sample };
                Log { samples: log.samples.iter().map(without).collect() }
            }
            Self::RigNotExact | Self::CoarsePositions { .. } | Self::CoarseAngles { .. } => return None,
        })
    }
}

fn with_pads_exchanged(log: &Log) -> Log {
    let exchanged = |sample: &Sample| Sample {
        s1_m: sample.s2_m,
        s2_m: sample.s1_m,
        s1_sd_m: sample.s2_sd_m,
        s2_sd_m: sample.s1_sd_m,
        ..*sample
    };
    Log { samples: log.samples.iter().map(exchanged).collect() }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        /// What is true of pad 1, of pad 2, or of both.
        fn pads(values: [Option<f64>; 2]) -> &'static str {
            match values {
                [Some(_), Some(_)] => "both pads",
                [None, Some(_)] => "pad 2",
                _ => "pad 1",
            }
        }
        let what = match *self {
            Self::Phi1Clockwise => "phi1 is counted clockwise",
            Self::Phi2Clockwise => "phi2 is counted clockwise",
            Self::BothClockwise => "phi1 and phi2 are counted clockwise",
            Self::Phi1FromVertical => "phi1 is counted from the vertical",
            Self::Phi1FromVerticalClockwise => "phi1 is counted from the vertical, clockwise",
            Self::Phi2FromHorizontal => "phi2 is counted from the horizontal, not from palm 1",
            Self::AnglesSwapped => "phi1 and phi2 are swapped",
            Self::PadsSwapped => "s1 and s2 are swapped",
            Self::PalmsSwapped => "the palms are swapped: palm 1 must be the one that palm 2 is counter-clockwise of",
            Self::ReadFromTip { length1_m, length2_m } => {
                let pads = pads([length1_m, length2_m]);
                let verb = if pads == "both pads" { "are" } else { "is" };
                return write!(f, "{pads} {verb} read from the far end, not from the base");
            }
            Self::ZeroOff { zero1_m, zero2_m } => {
                let told = |zero_m: f64| format!("{:.1} mm", MILLI * zero_m);
                let zeros: Vec<String> = [zero1_m, zero2_m].into_iter().flatten().map(told).collect();
                let pads = pads([zero1_m, zero2_m]);
                let add = if pads == "both pads" { "add" } else { "adds" };
                return write!(f, "{pads} {add} {} to every position", zeros.join(" and "));
            }
            Self::RigNotExact => "the readings have the errors of an ordinary rig, and are taken as exact",
            Self::RadiansAsDegrees => "the palms open by no more than pi degrees: the angles are radians",
            Self::MetersAsMillimeters => {
                "no contact is a millimetre from the base of its palm: the positions are metres"
            }
            Self::MillimetersAsMeters => {
                "contacts are many metres from the base of their palm: the positions are millimetres"
            }
            Self::ZerosForNoContact { readings } => {
                return write!(f, "{readings} positions are exactly 0, as if there was no contact");
            }
            Self::CoarsePositions { step_m } => {
                return write!(f, "the positions are rounded to {} mm", rounded(MILLI * step_m));
            }
            Self::CoarseAngles { step_rad } => {
                return write!(f, "the palm angles are rounded to {} deg", rounded(step_rad.to_degrees()));
            }
        };
        f.write_str(what)
    }
}

/// A step with the digits that it has.
fn rounded(step: f64) -> f64 {
    (1e3 * step).round() / 1e3
}
