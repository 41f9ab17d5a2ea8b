//! Arrangements of a log, with no start given.

pub(crate) mod beam;
pub(crate) mod initial_height;
pub(crate) mod schedule;
pub(crate) mod seed;
pub(crate) mod segments;
pub(crate) mod windows;
