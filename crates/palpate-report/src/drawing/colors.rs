//! Colours of the figures: of lines and text, of what is known, of grids, of the object; and of what is pointed at.

pub(crate) const INK: &str = "#1d2733";
pub(crate) const GREY: &str = "#8a94a0";
pub(crate) const RULE: &str = "#dfe3e8";
pub(crate) const OBJECT: &str = "#eef1f4";
pub(crate) const RED: &str = "#c8102e";
pub(crate) const GREEN: &str = "#1a7f37";
pub(crate) const BLUE: &str = "#1f5fbf";
pub(crate) const ORANGE: &str = "#c05a00";
