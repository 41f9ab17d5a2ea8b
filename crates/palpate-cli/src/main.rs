//! The palpate program.
fn main() {}
