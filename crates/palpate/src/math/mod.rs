//! Mathematics that knows nothing of palms or objects.

pub(crate) mod angle;
pub(crate) mod banded;
pub(crate) mod lanes;
pub(crate) mod local_polynomial;
pub(crate) mod procrustes;
pub(crate) mod spline;
pub(crate) mod statistics;
