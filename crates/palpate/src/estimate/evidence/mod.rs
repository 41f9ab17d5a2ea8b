//! Hyperparameters by the evidence (`docs/theory.md`, what the log says of itself): noise, scale of the prior and number of
//! harmonics.

pub(crate) mod fit;
pub(crate) mod form_symmetry;
pub(crate) mod jump_prior;
pub(crate) mod laplace;
pub(crate) mod motion_prior;
pub(crate) mod order;
pub(crate) mod other_models;
pub(crate) mod profile;
pub(crate) mod symmetry;
pub(crate) mod variance_components;

#[cfg(test)]
mod tests;
