//! From an optimum to a certified result (`docs/theory.md`, error bars and the certificate).

pub(crate) mod assemble;
pub(crate) mod at_rest;
pub(crate) mod bent_poses;
pub(crate) mod certificate;
pub(crate) mod doubt;
pub(crate) mod joint_error_bars;
pub(crate) mod left_out;
pub(crate) mod mixture;
pub(crate) mod open_poses;
pub(crate) mod uncertainty;
