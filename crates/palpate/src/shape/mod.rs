//! What is felt: smooth convex planar objects, described by their support function about the centre of mass.

mod fit;
mod named;
mod outline;
mod random;
mod support_function;
mod symmetry;

pub use fit::ShapeError;
pub use named::{NamedShape, UnknownShape, ellipse, rounded_polygon};
pub use outline::{OutlineFit, rounded_rectangle};
pub use random::{RandomShape, random_shape};
pub use support_function::{BoundaryPoint, ContactSupport, SupportFunction};
pub use symmetry::Symmetry;
