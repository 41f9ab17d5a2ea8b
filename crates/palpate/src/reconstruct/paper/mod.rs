//! The method of Moll & Erdmann 2001 (`docs/theory.md`, the paper's method): equations 19 to 21 integrated from initial
//! conditions that are searched for, and the closed forms by quadrature in their place.

pub(crate) mod adams;
pub(crate) mod equations;
pub(crate) mod given_start;
pub(crate) mod initial_conditions;
pub(crate) mod outline_equations;
pub(crate) mod piece;

#[cfg(test)]
mod tests;
