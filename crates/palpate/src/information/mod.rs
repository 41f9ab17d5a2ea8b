//! How much a log can tell at best, and how much one has told: information and its inverse, the covariance of the shape.
//!
//! [`Information::of`] a shape and a motion is what a log *could* tell, before it is felt: to plan by, or to hold an estimator against (the
//! Cramér-Rao bound, [`cramer_rao_bound_m`]). [`posterior`] is what a reconstruction *has* learnt.

mod cramer_rao;
mod error;
mod posterior;
mod shape_covariance;

pub use cramer_rao::cramer_rao_bound_m;
pub use error::InformationError;
pub use posterior::posterior;
pub use shape_covariance::{Information, WeakestDirection};
