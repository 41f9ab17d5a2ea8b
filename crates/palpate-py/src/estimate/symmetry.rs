//! `Symmetry`: how the object behind a log is symmetric.

use palpate::reconstruct::FoundSymmetry;
use palpate::shape::Symmetry;
use pyo3::prelude::*;

use crate::interop::pickled::{self, Pickled};

/// How an object is symmetric, shape and centre of mass, as far as a log can tell.
///
/// Order 2 and more is its own image when turned by 2 pi / order; psi is then defined up to multiples of that between pieces.
#[pyclass(frozen, eq, module = "palpate", name = "Symmetry")]
#[derive(Clone, PartialEq)]
pub struct SymmetryData(pub FoundSymmetry);

#[pymethods]
impl SymmetryData {
    /// int: how many turns of 2 pi / order make a full one; 1 = no symmetry of rotation.
    #[getter]
    fn order(&self) -> u32 {
        self.0.symmetry.order
    }

    /// bool: whether the object is its own mirror image.
    #[getter]
    fn mirror(&self) -> bool {
        self.0.symmetry.mirror
    }

    /// float or None: the probability of this symmetry, or of none where there is none, 0 to 1; None where it was not asked.
    #[getter]
    fn probability(&self) -> Option<f64> {
        self.0.probability
    }

    /// float or None: standard deviation of the difference of r between copies that were both felt, metres.
    #[getter]
    fn deviation_sd_m(&self) -> Option<f64> {
        self.0.deviation_sd_m
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __repr__(&self) -> String {
        format!("<Symmetry: {}>", self.0)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (self.order(), self.mirror(), self.probability(), self.deviation_sd_m());
        pickled::by_method::<Self>(py, "_made", arguments)
    }

    #[staticmethod]
    fn _made(order: u32, mirror: bool, probability: Option<f64>, deviation_sd_m: Option<f64>) -> Self {
        Self(FoundSymmetry { symmetry: Symmetry { order, mirror }, probability, deviation_sd_m })
    }
}
