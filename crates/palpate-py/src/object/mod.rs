//! An object: its shape, what gravity does to it, and how far two results lie apart.

pub(crate) mod compare;
pub(crate) mod mechanics;
pub(crate) mod outline;
pub(crate) mod shape;
