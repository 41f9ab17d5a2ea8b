//! What is felt: smooth convex planar objects, described by their support function about the centre of mass.

mod support_function;

pub use support_function::{BoundaryPoint, ContactSupport, SupportFunction};
