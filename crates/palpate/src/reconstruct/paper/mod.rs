//! The method of the paper: equations 19 to 21 integrated, and their closed forms by quadrature.

pub(crate) mod adams;
pub(crate) mod equations;
pub(crate) mod given_start;
pub(crate) mod initial_conditions;
pub(crate) mod piece;
pub(crate) mod piece_normal_equations;

#[cfg(test)]
mod tests;
