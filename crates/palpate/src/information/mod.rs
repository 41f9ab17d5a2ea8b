//! How much a log can tell at best.

mod cramer_rao;

pub use cramer_rao::cramer_rao_bound_m;
