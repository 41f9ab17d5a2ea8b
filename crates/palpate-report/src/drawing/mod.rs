//! What the figures are drawn with: colours, SVG sheets, plots, and pictures of them.

pub(crate) mod colors;
pub(crate) mod plot;
#[cfg(feature = "png")]
pub(crate) mod png;
pub(crate) mod svg;
