//! Colours of the figures: of lines and text, of what is known, of grids, of the object; and of what is pointed at.

pub(in crate::paper) const INK: &str = "#1d2733";
pub(in crate::paper) const GREY: &str = "#8a94a0";
pub(in crate::paper) const RULE: &str = "#dfe3e8";
pub(in crate::paper) const OBJECT: &str = "#eef1f4";
pub(in crate::paper) const RED: &str = "#c8102e";
pub(in crate::paper) const GREEN: &str = "#1a7f37";
pub(in crate::paper) const BLUE: &str = "#1f5fbf";
pub(in crate::paper) const ORANGE: &str = "#c05a00";
