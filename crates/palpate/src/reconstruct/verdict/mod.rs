//! What an optimum is worth: error bars, jumps, and whether it is right.

pub(crate) mod assemble;
pub(crate) mod certificate;
pub(crate) mod doubt;
pub(crate) mod limits;
