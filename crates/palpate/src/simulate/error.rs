//! Why a simulation was refused.

use thiserror::Error;

use crate::palms::Palm;

/// Why a simulation was refused. Times are seconds of the motion, lengths metres, angles radians.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SimulateError {
    /// The motion has no samples.
    #[error("the palm motion has no samples")]
    NoMotion,
    /// A time or palm angle is not a number or beyond all reason, or time runs backwards.
    #[error(
        "the palm motion is faulty at its sample {sample}: time and angles must be finite, angles no more than two turns, and \
         time must not decrease (with inertia: must increase)"
    )]
    FaultyMotion {
        /// Index of the sample, from 0.
        sample: usize,
    },
    /// The shape is not an object.
    #[error("the shape is not a convex object: its smallest radius of curvature is {smallest_m} m")]
    NotConvex {
        /// Smallest radius of curvature, metres, or NaN.
        smallest_m: f64,
    },
    /// A property of the touchpad, the mass or the starting orientation is out of range.
    #[error("{what}")]
    OutOfRange {
        /// What, with its range.
        what: &'static str,
    },
    /// The palms became parallel or crossed.
    #[error("at {time_s:.3} s the palms are parallel or crossed (opening {phi2_rad:.4} rad): keep it between 0 and pi")]
    Parallel {
        /// When.
        time_s: f64,
        /// Opening angle φ₂ then.
        phi2_rad: f64,
    },
    /// The object would need to be pulled by a palm to stay in place.
    #[error(
        "at {time_s:.3} s the object would leave palm {palm}: a palm must lean against it from below or from the side \
         (0 < phi1 and phi1 + phi2 < pi)"
    )]
    LeavesPalm {
        /// When.
        time_s: f64,
        /// Which palm.
        palm: Palm,
    },
    /// Gravity does not hold the object on both palms: they move too fast, or it swings too much.
    #[error(
        "at {time_s:.3} s the object loses contact with palm {palm}: it moves too fast for gravity to hold it there; slow the palms down, let \
         them start and stop more gently, or open them less far"
    )]
    LosesContact {
        /// When.
        time_s: f64,
        /// Which palm.
        palm: Palm,
    },
    /// The friction cones squeeze the object, with forces of any size.
    #[error(
        "at {time_s:.3} s the object jams between the palms (opening {phi2_rad:.3} rad): open them further than the friction cones \
         reach, or lower the friction"
    )]
    Jams {
        /// When.
        time_s: f64,
        /// Opening angle φ₂ then.
        phi2_rad: f64,
    },
    /// The contact ran off the end of a palm.
    #[error(
        "at {time_s:.3} s the contact runs off palm {palm}: {position_m:.4} m from its base, the palm reaches from 0 to \
         {length_m:.4} m"
    )]
    RunsOff {
        /// When.
        time_s: f64,
        /// Which palm.
        palm: Palm,
        /// Contact position.
        position_m: f64,
        /// Length of the palm.
        length_m: f64,
    },
}
