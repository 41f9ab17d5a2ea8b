//! The calibration constants that a log may tell: their names, units, and what a user can do about each.

/// A calibration constant that a log may tell, in words.
///
/// ```
/// use palpate::sensor::CalibrationConstant;
///
/// let zero = CalibrationConstant::named("s1_zero_m").expect("one of them");
/// assert_eq!(zero.label, "zero of pad 1");
/// assert_eq!((3e-4 * zero.units_per_si, zero.unit), (0.3, "mm"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CalibrationConstant {
    /// As in results and files, with its SI unit.
    pub name: &'static str,
    /// What people call it.
    pub label: &'static str,
    /// The unit in which it is shown: `mm`, `deg`, `ms` or `%`.
    pub unit: &'static str,
    /// How many of these make one of the SI unit.
    pub units_per_si: f64,
    /// Where a rig file states how well it is known.
    pub tolerance: &'static str,
    /// A motion of the palms that tells it.
    pub motion: &'static str,
    /// A measurement that shows a mistake in it.
    pub check: &'static str,
}

const TRAVEL: &str =
    "let the contacts travel over more of both pads: open and close the palms wider, roll the object further around";
const OPEN_WIDER: &str = "open and close the palms wider";

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

impl CalibrationConstant {
    /// All of them, in the order of [`CalibrationEstimate::constants`](crate::reconstruct::CalibrationEstimate::constants).
    pub const ALL: [Self; 7] = [
        Self {
            name: "s1_zero_m",
            label: "zero of pad 1",
            unit: "mm",
            units_per_si: 1e3,
            tolerance: "zero_sd_mm of [palm1]",
            motion: TRAVEL,
            check: "check pad 1: touched at a known distance from the base, it reads that distance plus its zero. Does it count from \
                    that end?",
        },
        Self {
            name: "s2_zero_m",
            label: "zero of pad 2",
            unit: "mm",
            units_per_si: 1e3,
            tolerance: "zero_sd_mm of [palm2]",
            motion: TRAVEL,
            check: "check pad 2: touched at a known distance from the base, it reads that distance plus its zero. Does it count from \
                    that end?",
        },
        Self {
            name: "scale_ratio",
            label: "scale of pad 1 less that of pad 2",
            unit: "%",
            units_per_si: 1e2,
            tolerance: "scale_ratio_sd of [pads]",
            motion: TRAVEL,
            check: "check both pads: touch two marks on each; difference of the readings over their distance is its scale. Same unit \
                    and counts per inch?",
        },
        Self {
            name: "phi1_zero_rad",
            label: "zero of phi1 (against gravity)",
            unit: "deg",
            units_per_si: DEGREES,
            tolerance: "phi1_zero_sd_deg of [angles]",
            motion: "turn both palms together, far to either side, and slowly (gravity is the level)",
            check: "check the encoder of palm 1: with the palm level it reads its zero. Does y point up, against gravity?",
        },
        Self {
            name: "phi2_zero_rad",
            label: "zero of phi2 (between the palms)",
            unit: "deg",
            units_per_si: DEGREES,
            tolerance: "phi2_zero_sd_deg of [angles]",
            motion: OPEN_WIDER,
            check: "check the encoder between the palms: with a square between them it reads 90 degrees plus its zero",
        },
        Self {
            name: "surface_difference_m",
            label: "surface of pad 1 less pad 2",
            unit: "mm",
            units_per_si: 1e3,
            tolerance: "surface_difference_sd_mm of [pads]",
            motion: OPEN_WIDER,
            check: "check with a calliper how far each sensing surface, pad and cover mounted, lies in front of the hinge axis",
        },
        Self {
            name: "clock_offset_s",
            label: "clock of angles against pads",
            unit: "ms",
            units_per_si: 1e3,
            tolerance: "offset_sd_ms of [clock]",
            motion: "let the palms speed up, slow down and turn back more often",
            check: "check the clocks: tap a palm; the angle follows the position by the offset",
        },
    ];

    /// That of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        const ALL: &[CalibrationConstant] = &CalibrationConstant::ALL;
        ALL.iter().find(|constant| constant.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_in_their_units() {
        for constant in CalibrationConstant::ALL {
            let ending = constant.name.rsplit('_').next();
            let unit = match ending {
                Some("m") => "mm",
                Some("rad") => "deg",
                Some("s") => "ms",
                _ => "%",
            };
            assert_eq!(constant.unit, unit, "{}", constant.name);
            assert_eq!(CalibrationConstant::named(constant.name), Some(&constant));
            assert!(constant.label.chars().count() <= 33, "fits a column: {}", constant.label);
        }
        assert_eq!(CalibrationConstant::named("s3_zero_m"), None);
    }
}
