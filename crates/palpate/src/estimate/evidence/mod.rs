//! What the data say of everything that is not shape or motion.

pub(crate) mod fit;
pub(crate) mod laplace;
pub(crate) mod motion_prior;
pub(crate) mod order;
pub(crate) mod variance_components;

#[cfg(test)]
mod tests;
