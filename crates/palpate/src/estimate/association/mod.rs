//! Data association: which of its possible poses each sample has, and how ambiguous that is (Viterbi decoding, predictive
//! likelihood and evidence; `docs/theory.md`, section on the decoded motion).

pub(crate) mod alternatives;
pub(crate) mod candidates;
pub(crate) mod copies;
pub(crate) mod decode;
pub(crate) mod form_copies;
pub(crate) mod hidden_jumps;
pub(crate) mod landings;
pub(crate) mod motion_grid;
pub(crate) mod part;
pub(crate) mod predictive;
pub(crate) mod relative_rotation;
pub(crate) mod rival_pieces;
pub(crate) mod shared_boundary;
pub(crate) mod short_segments;
#[cfg(test)]
mod simulated;
pub(crate) mod transitions;
pub(crate) mod viterbi;
