//! What feels: two palms, their frames and their contact angles.

mod pair;

pub use pair::{Palm, PalmPair};
