//! What the figures are drawn with: colours, SVG sheets, plots, and pictures of them.

pub(super) mod colors;
pub(super) mod plot;
#[cfg(feature = "png")]
pub(super) mod png;
pub(super) mod svg;
