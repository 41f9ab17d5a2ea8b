//! An object that hangs from its pivot over a pad, as it is simulated and planned for where nothing else is said, and the usual strokes over it.

use crate::pivot::simulate::{PivotSimulateOptions, Stroke};
use crate::sensor::Touchpad;
use crate::shape::SupportFunction;

/// Noise of the arm, a fifth of that of the pad.
const ARM_NOISE_SHARE: f64 = 0.2;

/// Places of the strokes, as multiples of the mean radius from the middle of the pad: down, there, and back.
const STROKES: [[f64; 3]; 6] =
    [[0.0, 4.5, 3.0], [0.3, -4.0, -2.5], [-0.5, 4.0, 2.0], [0.5, -4.5, -3.0], [0.0, 3.5, 1.5], [-0.3, -3.5, -2.0]];

/// Length of the pad where none is stated, in mean radii: for the longest of the strokes, either way.
const PAD_LENGTH: f64 = 20.0;

/// An object that hangs from its pivot over a pad.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldObject {
    /// Support function about the pivot.
    pub about_pivot: SupportFunction,
    /// Pad, friction and centre of mass.
    pub options: PivotSimulateOptions,
}

impl HeldObject {
    /// Force with which the arm presses, in weights of the object.
    pub const PRESS: f64 = 3.0;
    /// Friction where none is asked for.
    pub const USUAL_FRICTION: f64 = 0.4;
    /// Where the pivot is if nothing is said: so many mean radii from the centre of mass. About the middle of a round object no angle is told.
    pub const PIVOT_SHARE: f64 = 0.3;

    /// By its shape about the centre of mass, and where the pivot is from there, metres.
    pub fn new(shape: &SupportFunction, pivot_m: Option<[f64; 2]>, touchpad: Touchpad, friction: Option<f64>) -> Self {
        let radius_m = shape.mean_radius_m();
        let pivot_m = pivot_m.unwrap_or([0.0, Self::PIVOT_SHARE * radius_m]);
        let length_m = if touchpad.length_m.is_finite() { touchpad.length_m } else { PAD_LENGTH * radius_m };
        let options = PivotSimulateOptions {
            touchpad: Touchpad { length_m, ..touchpad },
            arm_noise_sd_m: ARM_NOISE_SHARE * touchpad.noise_sd_m,
            center_of_mass_m: pivot_m.map(|m| -m),
            friction: friction.unwrap_or(Self::USUAL_FRICTION),
            ..PivotSimulateOptions::default()
        };
        Self { about_pivot: shape.translated(-pivot_m[0], -pivot_m[1]), options }
    }

    /// Six strokes there and back, by turns to either side of the middle of the pad.
    pub fn usual_strokes(&self) -> Vec<Stroke> {
        let (radius_m, middle_m) = (self.about_pivot.mean_radius_m(), 0.5 * self.options.touchpad.length_m);
        let place = |way: f64| middle_m + way * radius_m;
        STROKES.iter().map(|ways| Stroke { along_m: ways.map(place).to_vec(), press: Self::PRESS }).collect()
    }

    /// Part of the pad that these strokes go over, metres.
    pub fn usual_along_m(&self) -> [f64; 2] {
        let all: Vec<f64> = self.usual_strokes().into_iter().flat_map(|stroke| stroke.along_m).collect();
        [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::NamedShape;

    #[test]
    fn the_usual_strokes_stay_on_the_pad_that_is_long_enough_for_them() {
        let egg = NamedShape::Egg.shape(0.03).expect("an egg");
        let held = HeldObject::new(&egg, None, Touchpad::ideal(), None);
        let [from_m, to_m] = held.usual_along_m();
        assert!(from_m > 0.0 && to_m < held.options.touchpad.length_m, "{from_m} to {to_m}");
        assert_eq!(held.options.center_of_mass_m, [0.0, -HeldObject::PIVOT_SHARE * egg.mean_radius_m()]);
        let stated =
            HeldObject::new(&egg, Some([0.01, 0.0]), Touchpad { length_m: 0.4, ..Touchpad::ideal() }, Some(0.2));
        assert_eq!((stated.options.touchpad.length_m, stated.options.friction), (0.4, 0.2));
    }
}
