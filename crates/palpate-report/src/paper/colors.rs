//! Colours of the figures: of lines and text, of what is known, of grids, of the object; and of what is pointed at.

pub(super) const INK: &str = "#1d2733";
pub(super) const GREY: &str = "#8a94a0";
pub(super) const RULE: &str = "#dfe3e8";
pub(super) const OBJECT: &str = "#eef1f4";
pub(super) const RED: &str = "#c8102e";
pub(super) const GREEN: &str = "#1a7f37";
pub(super) const BLUE: &str = "#1f5fbf";
pub(super) const ORANGE: &str = "#c05a00";
