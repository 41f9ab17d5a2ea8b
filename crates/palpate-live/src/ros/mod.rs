//! Messages of ROS 2, and which of them hold what.

pub(crate) mod field;
pub(crate) mod message;
pub(crate) mod topics;
