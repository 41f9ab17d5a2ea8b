//! The model of one instant: residuals and their derivatives, the distributions of their errors, and the prior of the shape.

pub(crate) mod balance_tolerance;
pub(crate) mod boundary;
pub(crate) mod contact;
pub(crate) mod contact_lanes;
pub(crate) mod evidence;
pub(crate) mod layout;
pub(crate) mod noise;
pub(crate) mod noise_from_log;
pub(crate) mod outliers;
pub(crate) mod prior;
pub(crate) mod sensor_memory;
pub(crate) mod table;
