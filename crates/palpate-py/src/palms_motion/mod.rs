//! The palms and how they move.

pub(crate) mod motion;
pub(crate) mod moves;
pub(crate) mod palms;
pub(crate) mod plan;
