//! Shape, motion and inertia together, for palms so fast that balance does not hold (`docs/theory.md`, inertia).
//!
//! The motion ψ(t) is a spline, so that its rates are known at any time and the moment of the forces W is asked for between the samples too. One
//! step solves an arrow: a band for the spline, and the shape, the radius of gyration and the damping that all samples share.
//!
//! 1. [`palm_path`]: angles of the palms, their rates and accelerations at any time;
//! 2. [`contact_driven`]: the motion that follows from the contacts alone, with which a search begins;
//! 3. [`problem`]: residuals of contacts and forces, and their normal equations;
//! 4. [`smoother`]: the optimum, with the standard deviations of contacts and forces estimated.

pub(crate) mod contact_driven;
pub(crate) mod palm_path;
pub(crate) mod problem;
pub(crate) mod smoother;
