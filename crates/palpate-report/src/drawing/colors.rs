//! Colours of the figures: of lines and text, of what is known, of grids, of the object; and of what is pointed at.

pub(crate) const INK: &str = "#1d2733";
pub(crate) const GREY: &str = "#8a94a0";
pub(crate) const RULE: &str = "#dfe3e8";
pub(crate) const OBJECT: &str = "#eef1f4";
pub(crate) const RED: &str = "#c8102e";
pub(crate) const GREEN: &str = "#1a7f37";
pub(crate) const BLUE: &str = "#1f5fbf";
pub(crate) const ORANGE: &str = "#c05a00";

// Those of the report's page in its light theme.
pub(crate) const ESTIMATE: &str = "#0072b2";
pub(crate) const CONTACT1: &str = "#b0478c";
pub(crate) const CONTACT2: &str = "#d55e00";
pub(crate) const PALM: &str = "#c3c8d0";
