//! `OutlineFit`: a shape made from an outline, and how far it is from it.

use std::path::PathBuf;

use palpate::shape::{BoundaryPoint, OutlineFit, SupportFunction};
use pyo3::prelude::*;

use crate::interop::arrays::{self, Table};
use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::object::shape::Shape;

/// A shape made from an outline, and how far it is from it.
///
/// Few harmonics round corners off and let flat sides bulge. `SupportFunction.from_outline` makes one.
#[pyclass(frozen, eq, module = "palpate", name = "OutlineFit")]
#[derive(Clone, PartialEq)]
pub struct Fit {
    fit: OutlineFit,
    /// list of str: what there is to say about a file, such as which path of a drawing was taken.
    #[pyo3(get)]
    notes: Vec<String>,
}

/// An outline as Python gives it: points, or a file.
#[derive(FromPyObject)]
pub enum OutlineGiven<'py> {
    Points(Table<'py>),
    File(PathBuf),
}

impl Fit {
    /// The fit to an outline, its centre of mass moved by an offset.
    pub fn of(py: Python<'_>, outline: OutlineGiven, offset_m: (f64, f64)) -> PyResult<Self> {
        let (fit, notes) = match outline {
            OutlineGiven::Points(points) => {
                let rows = arrays::rows("outline", &points)?;
                let points: Vec<BoundaryPoint> =
                    rows.into_iter().map(|[x_m, y_m]| BoundaryPoint { x_m, y_m }).collect();
                (py.detach(|| SupportFunction::from_outline(&points)).or_raise()?, Vec::new())
            }
            OutlineGiven::File(path) => {
                let file = py.detach(|| palpate_io::read_outline(&path)).or_raise()?;
                (py.detach(|| file.fit()).or_raise()?, file.notes)
            }
        };
        let (x_m, y_m) = offset_m;
        if !(x_m.is_finite() && y_m.is_finite()) {
            return Err(errors::input("center_of_mass_offset_m must be finite".to_owned()));
        }
        Ok(Self { fit: fit.about(x_m, y_m), notes })
    }
}

#[pymethods]
impl Fit {
    /// SupportFunction: the shape, about its centre of mass.
    #[getter]
    fn shape(&self) -> Shape {
        Shape(self.fit.shape.clone())
    }

    /// float: how far the outline stands out of the shape at most, metres: what its corners lose.
    #[getter]
    fn cut_m(&self) -> f64 {
        self.fit.cut_m
    }

    /// float: how far the shape stands out of the convex hull of the outline at most, metres: what its sides gain.
    #[getter]
    fn bulge_m(&self) -> f64 {
        self.fit.bulge_m
    }

    /// float: depth of the deepest dent of the outline, metres; palms feel the convex hull, which closes it.
    #[getter]
    fn dent_m(&self) -> f64 {
        self.fit.dent_m
    }

    /// float: largest distance between the shape and the convex hull, metres.
    #[getter]
    fn residual_m(&self) -> f64 {
        self.fit.residual_m()
    }

    fn __repr__(&self) -> String {
        let OutlineFit { shape, cut_m, bulge_m, dent_m } = &self.fit;
        format!(
            "<OutlineFit: {} harmonics, corners cut by {:.3} mm, sides bulge by {:.3} mm, dents of {:.3} mm closed>",
            shape.harmonics_m().len(),
            1e3 * cut_m,
            1e3 * bulge_m,
            1e3 * dent_m
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let OutlineFit { shape, cut_m, bulge_m, dent_m } = self.fit.clone();
        pickled::by_method::<Self>(py, "_made", (Shape(shape), cut_m, bulge_m, dent_m, self.notes.clone()))
    }

    #[staticmethod]
    fn _made(shape: &Shape, cut_m: f64, bulge_m: f64, dent_m: f64, notes: Vec<String>) -> Self {
        Self { fit: OutlineFit { shape: shape.0.clone(), cut_m, bulge_m, dent_m }, notes }
    }
}
