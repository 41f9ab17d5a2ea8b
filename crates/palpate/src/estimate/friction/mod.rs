//! Friction and centre of mass from form and motion (`docs/theory.md`, friction).
//!
//! Contact alone gives the form and the motion of an object, but not the place of its centre of mass in the form. Every sample confines that to a
//! vertical strip: the forces within the friction cones meet on the vertical through it. The strip is a line where both contacts slide. Seen
//! from the object the strips turn, so that they leave little of the plane: centre of mass and coefficients of friction follow together.
//!
//! 1. [`rolling`]: how the object turns if it rolls on a palm, from the readings alone;
//! 2. [`regimes`]: which contact sticks at each sample, from the motion against these;
//! 3. [`strips`]: centre of mass and friction, from what the balance of forces then asks;
//! 4. [`problem`] and [`smoother`]: all of it together, with what rolling tells of the motion and pads that measure forces ([`normal_forces`]);
//!    [`modes`]: which contact sticks, by mechanics;
//! 5. [`falls`]: whether it may have fallen as it jumps.

pub(crate) mod falls;
pub(crate) mod modes;
pub(crate) mod normal_forces;
pub(crate) mod posterior;
pub(crate) mod problem;
pub(crate) mod regimes;
pub(crate) mod rolling;
pub(crate) mod smoother;
pub(crate) mod strips;
