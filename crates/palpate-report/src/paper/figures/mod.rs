//! The figures and the table of the paper, one file each, and what they share.

pub(super) mod errors;
pub(super) mod figure;
pub(super) mod frames;
pub(super) mod geometry;
pub(super) mod pivot;
pub(super) mod results;
pub(super) mod scene;
