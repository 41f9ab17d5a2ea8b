//! Maximum likelihood over all samples at once (`docs/theory.md`, maximum likelihood): Gauss-Newton with variable projection, its
//! normal equations, chord steps, and the posterior at the optimum.

pub(crate) mod arrow;
pub(crate) mod chord;
pub(crate) mod convex_step;
pub(crate) mod error_bars;
pub(crate) mod gauss_newton;
pub(crate) mod levenberg_marquardt;
pub(crate) mod normal_equations;
pub(crate) mod outer_products;
pub(crate) mod posterior;
pub(crate) mod shape_given_motion;
