//! Which of its possible poses each sample has (data association), and how sure that is.

pub(crate) mod alternatives;
pub(crate) mod candidates;
pub(crate) mod decode;
pub(crate) mod predictive;
pub(crate) mod short_segments;
pub(crate) mod transitions;
pub(crate) mod viterbi;
