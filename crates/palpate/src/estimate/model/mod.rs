//! Residuals of one instant and what is believed of their errors and of the shape.

pub(crate) mod balance_tolerance;
pub(crate) mod contact;
pub(crate) mod contact_lanes;
pub(crate) mod layout;
pub(crate) mod noise;
pub(crate) mod noise_from_log;
pub(crate) mod prior;
pub(crate) mod table;
