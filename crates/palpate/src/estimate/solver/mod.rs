//! Maximum likelihood over all samples at once.

pub(crate) mod chord;
pub(crate) mod error_bars;
pub(crate) mod gauss_newton;
pub(crate) mod normal_equations;
pub(crate) mod outer_products;
pub(crate) mod posterior;
