//! palpate
#![forbid(unsafe_code)]

pub mod compare;
pub mod log;
pub mod palms;
pub mod reconstruct;
pub mod sensor;
pub mod shape;
pub mod simulate;
pub mod statics;
pub mod truth;

pub use log::{Log, Sample};
pub use reconstruct::Reconstruction;
pub use truth::Truth;
