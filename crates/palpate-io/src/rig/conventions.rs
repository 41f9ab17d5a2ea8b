//! How a log is written where it is not as palpate has it: the signs of the angles, the end a pad counts from, the base points.

use palpate::palms::PalmPair;
use palpate::{Log, Sample};

/// What turns a log as it was written into a log as palpate has it. The default changes nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conventions {
    /// Palm 1 and palm 2.
    pub palms: [PalmConventions; 2],
    /// What φ₁ and φ₂ are multiplied by: 1, or −1 for an encoder that counts clockwise.
    pub angle_signs: [f64; 2],
}

/// Conventions of one palm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PalmConventions {
    /// The end the pad counts from.
    pub direction: Direction,
    /// Coordinates x and y of the base point in the global frame, metres; `None` = as the log says.
    pub base_m: [Option<f64>; 2],
}

/// The end a pad counts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// A reading is the distance from the base.
    FromBase {
        /// Length of the pad, metres, if it is known.
        length_m: Option<f64>,
    },
    /// A reading is the distance from the tip: the position is the length less the reading.
    ToBase {
        /// Length of the pad, metres.
        length_m: f64,
    },
}

impl Default for Direction {
    fn default() -> Self {
        Self::FromBase { length_m: None }
    }
}

impl Direction {
    /// Length of the pad, metres, if it is known.
    pub fn length_m(self) -> Option<f64> {
        match self {
            Self::FromBase { length_m } => length_m,
            Self::ToBase { length_m } => Some(length_m),
        }
    }

    /// The distance from the base, metres.
    fn position_m(self, reading_m: f64) -> f64 {
        match self {
            Self::FromBase { .. } => reading_m,
            Self::ToBase { length_m } => length_m - reading_m,
        }
    }
}

impl PalmConventions {
    fn base_m(&self, logged_m: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.base_m[axis].unwrap_or(logged_m[axis]))
    }
}

impl Default for Conventions {
    fn default() -> Self {
        Self { palms: [PalmConventions::default(); 2], angle_signs: [1.0; 2] }
    }
}

impl Conventions {
    /// The log as palpate has it; the calibration constants of the rig are still in it.
    pub fn apply(&self, log: &Log) -> Log {
        let ([palm1, palm2], [sign1, sign2]) = (&self.palms, self.angle_signs);
        let apply = |sample: &Sample| Sample {
            palms: PalmPair {
                phi1_rad: sign1 * sample.palms.phi1_rad,
                phi2_rad: sign2 * sample.palms.phi2_rad,
                base1_m: palm1.base_m(sample.palms.base1_m),
                base2_m: palm2.base_m(sample.palms.base2_m),
            },
            s1_m: sample.s1_m.map(|reading_m| palm1.direction.position_m(reading_m)),
            s2_m: sample.s2_m.map(|reading_m| palm2.direction.position_m(reading_m)),
            ..*sample
        };
        Log { samples: log.samples.iter().map(apply).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log() -> Log {
        let palms = PalmPair { base1_m: [1e-3, 2e-3], ..PalmPair::hinged(0.5, 1.25) };
        let first = Sample { s1_sd_m: Some(1e-4), force2_n: Some(2.0), ..Sample::new(0.1, palms, 0.015625, 0.03) };
        Log { samples: vec![first, Sample { time_s: 0.2, s2_m: None, ..first }] }
    }

    #[test]
    fn the_default_changes_nothing() {
        assert_eq!(Conventions::default().apply(&log()), log());
        let known =
            PalmConventions { direction: Direction::FromBase { length_m: Some(0.05) }, ..PalmConventions::default() };
        assert_eq!(Conventions { palms: [known; 2], ..Conventions::default() }.apply(&log()), log());
    }

    #[test]
    fn angles_positions_and_base_points_are_turned_and_nothing_else() {
        let palm1 = PalmConventions { base_m: [Some(7e-3), None], ..PalmConventions::default() };
        let palm2 =
            PalmConventions { direction: Direction::ToBase { length_m: 0.05 }, base_m: [Some(-4e-3), Some(3e-3)] };
        let found = Conventions { palms: [palm1, palm2], angle_signs: [-1.0, 1.0] }.apply(&log());
        let palms = PalmPair { phi1_rad: -0.5, phi2_rad: 1.25, base1_m: [7e-3, 2e-3], base2_m: [-4e-3, 3e-3] };
        let first = Sample { palms, s2_m: Some(0.05 - 0.03), ..log().samples[0] };
        assert_eq!(found.samples, [first, Sample { palms, ..log().samples[1] }]);
    }

    #[test]
    fn what_is_turned_twice_is_as_before() {
        let to_base =
            PalmConventions { direction: Direction::ToBase { length_m: 0.0625 }, ..PalmConventions::default() };
        let conventions = Conventions { palms: [to_base; 2], angle_signs: [-1.0; 2] };
        let mut exact = log();
        exact.samples[0].s2_m = Some(0.03125);
        assert_eq!(conventions.apply(&conventions.apply(&exact)), exact);
    }
}
