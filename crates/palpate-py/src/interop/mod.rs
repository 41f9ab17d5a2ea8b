//! Between Rust and Python: arrays, exceptions, whole numbers, pickles, pictures, and long calls.

pub(crate) mod arrays;
pub(crate) mod errors;
pub(crate) mod pickled;
pub(crate) mod svg;
pub(crate) mod whole;
pub(crate) mod work;
