//! Studies: each measures something and writes the table that the documentation quotes.

mod acting_forces;
pub(crate) mod bench_live;
mod exact;
pub(crate) mod limits;
pub(crate) mod methods;
pub(crate) mod monte_carlo;
pub(crate) mod paper;
pub(crate) mod pivot;
pub(crate) mod python_cost;
pub(crate) mod ray_cost;
pub(crate) mod rows;
pub(crate) mod slips;
pub(crate) mod tables;
