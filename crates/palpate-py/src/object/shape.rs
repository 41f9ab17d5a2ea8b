//! `SupportFunction`: what is felt.

use std::f64::consts::TAU;

use numpy::{PyArray1, PyArray2};
use palpate::palms::GeneralizedContactSupport;
use palpate::shape::{BoundaryPoint, NamedShape, RandomShape, ShapeError, SupportFunction};
use pyo3::prelude::*;

use crate::interop::arrays::{self, Column, Numbers, Table, four};
use crate::interop::errors::{self, OrRaise};
use crate::interop::pickled::{self, Pickled};
use crate::interop::svg;
use crate::interop::whole::Whole;
use crate::object::outline::{Fit, OutlineGiven};

/// Most harmonics of a shape that is made from data.
const MOST_HARMONICS: usize = 512;

/// Support function of a convex planar object about its centre of mass.
///
/// r(theta) = a_0 + sum over k of a_k cos(k theta) + b_k sin(k theta): the distance from the centre of mass to the tangent
/// whose outward normal points along theta. A notebook shows its outline.
///
/// Parameters
/// ----------
/// mean_radius_m : float
///     Mean radius a_0 (perimeter / 2 pi), metres, positive.
/// harmonics_m : array_like of float, shape (K, 2), optional
///     The pairs (a_k, b_k) for k = 1 ... K, metres. The first moves the centre of mass. Default: a circle.
///
/// Raises
/// ------
/// ShapeError
///     If the mean radius is not positive and finite, or a harmonic is not finite.
///
/// Examples
/// --------
/// >>> import palpate
/// >>> egg = palpate.SupportFunction.named("egg", 0.03)
/// >>> round(egg.perimeter_m, 4)
/// 0.1885
#[pyclass(frozen, eq, module = "palpate", name = "SupportFunction")]
#[derive(Clone, PartialEq)]
pub struct Shape(pub SupportFunction);

#[pymethods]
impl Shape {
    #[new]
    #[pyo3(signature = (mean_radius_m, harmonics_m=None))]
    fn new(mean_radius_m: f64, harmonics_m: Option<Table>) -> PyResult<Self> {
        if !(mean_radius_m > 0.0 && mean_radius_m.is_finite()) {
            return Err(ShapeError::OutOfRange { what: "the mean radius" }).or_raise();
        }
        let harmonics = harmonics_m.as_ref().map_or(Ok(Vec::new()), |table| arrays::rows("harmonics_m", table))?;
        if let Some(index) = harmonics.iter().position(|pair: &[f64; 2]| !(pair[0].is_finite() && pair[1].is_finite()))
        {
            return Err(errors::ShapeError::new_err(format!("harmonic {} is not finite", index + 1)));
        }
        Ok(Self(SupportFunction::new(mean_radius_m, harmonics)))
    }

    /// A shape known by its name.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     circle, disc, ellipse, egg, triangle, square, pebble, stone, random:SEED, or with sizes in millimetres rectangle:60x40,
    ///     rectangle:60x40x5 (with a corner radius) or stadium:60x40.
    /// mean_radius_m : float, optional
    ///     Mean radius, metres. Default: by the size in the name, or else 0.03.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The shape in that size.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     If no shape has that name, or the radius is not positive and finite.
    #[staticmethod]
    #[pyo3(signature = (name, mean_radius_m=None))]
    fn named(name: &str, mean_radius_m: Option<f64>) -> PyResult<Self> {
        let fit = name.parse::<NamedShape>().or_raise()?.fitted(mean_radius_m).or_raise()?;
        Ok(Self(fit.shape))
    }

    /// The shape of an outline, with as many harmonics as it asks for, and how far it is from it.
    ///
    /// A support function describes what is convex, with smooth corners: the convex hull takes the place of a concave outline, corners are
    /// rounded and flat sides bulge, by no more than a thousandth of the mean radius where 256 harmonics or fewer come so close.
    ///
    /// Parameters
    /// ----------
    /// outline : array_like of float, shape (n, 2), or str or os.PathLike
    ///     Points in order round the object, metres; or a file: a CSV table of points (x_m, y_m) or of a support function (theta_rad, r_m), or a
    ///     drawing in SVG, of which the path with the largest area is taken, with user units as millimetres unless it says otherwise.
    /// center_of_mass_offset_m : tuple of float, default (0, 0)
    ///     Centre of mass from the centroid of the outline, or from the origin of a support function, metres.
    ///
    /// Returns
    /// -------
    /// OutlineFit
    ///     The shape, and what its corners lose and its sides gain.
    ///
    /// Raises
    /// ------
    /// ReadError
    ///     If the file cannot be read, or holds no outline.
    /// ShapeError
    ///     With fewer than three points, points on a line, or coordinates that are not finite.
    ///
    /// Examples
    /// --------
    /// >>> import palpate
    /// >>> fit = palpate.SupportFunction.from_outline([(0, 0), (0.06, 0), (0.06, 0.04), (0, 0.04)])
    /// >>> fit.residual_m < 3e-4
    /// True
    #[staticmethod]
    #[pyo3(signature = (outline, *, center_of_mass_offset_m=(0.0, 0.0)),
        text_signature = "(outline, *, center_of_mass_offset_m=(0.0, 0.0))")]
    fn from_outline(py: Python<'_>, outline: OutlineGiven, center_of_mass_offset_m: (f64, f64)) -> PyResult<Fit> {
        Fit::of(py, outline, center_of_mass_offset_m)
    }

    /// A random smooth convex shape; the same seed gives the same shape.
    ///
    /// Parameters
    /// ----------
    /// seed : int
    ///     From 0 on.
    /// mean_radius_m : float, default 0.03
    ///     Mean radius, metres.
    /// order : int, default 6
    ///     Number of harmonics, 1 to 512.
    /// amplitude : float, default 0.5
    ///     Harmonic k has the standard deviation amplitude * mean_radius_m / (1 + k**2).
    /// mass_offset : float, default 0.1
    ///     Standard deviation of each coordinate of the centre of mass, as a fraction of the mean radius.
    /// smallest_curvature : float, default 0.15
    ///     Smallest radius of curvature allowed, as a fraction of the mean radius, 0 to below 1.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The shape.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     If a number is out of range.
    #[staticmethod]
    #[pyo3(signature = (seed, *, mean_radius_m=0.03, order=Whole(6), amplitude=0.5, mass_offset=0.1, smallest_curvature=0.15),
        text_signature = "(seed, *, mean_radius_m=0.03, order=6, amplitude=0.5, mass_offset=0.1, smallest_curvature=0.15)")]
    fn random(
        seed: Whole,
        mean_radius_m: f64,
        order: Whole,
        amplitude: f64,
        mass_offset: f64,
        smallest_curvature: f64,
    ) -> PyResult<Self> {
        let kind = RandomShape { mean_radius_m, order: order.count(), amplitude, mass_offset, smallest_curvature };
        palpate::shape::random_shape(&kind, seed.0).or_raise().map(Self)
    }

    /// An ellipse about its middle.
    ///
    /// Parameters
    /// ----------
    /// a_m, b_m : float
    ///     Semi-axes along x and y, metres.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The ellipse, expanded until what is left out is below 1e-13 of its size.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     If an axis is not positive and finite.
    #[staticmethod]
    fn ellipse(a_m: f64, b_m: f64) -> PyResult<Self> {
        palpate::shape::ellipse(a_m, b_m).or_raise().map(Self)
    }

    /// A regular polygon with rounded corners, about its middle.
    ///
    /// Parameters
    /// ----------
    /// corners : int
    ///     Number of corners, 2 to 64.
    /// corner_radius : float, default 0.35
    ///     Smallest radius of curvature as a fraction of the mean radius, above 0, up to 1 (a circle).
    /// smoothness_rad : float, default 0.2
    ///     How wide a side spreads over the normal angles, 0.02 to pi radians.
    /// mean_radius_m : float, default 0.03
    ///     Mean radius, metres.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The rounded polygon, convex by construction.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     If a number is out of range.
    #[staticmethod]
    #[pyo3(signature = (corners, corner_radius=0.35, smoothness_rad=0.2, *, mean_radius_m=0.03))]
    fn rounded_polygon(corners: Whole, corner_radius: f64, smoothness_rad: f64, mean_radius_m: f64) -> PyResult<Self> {
        let unit = palpate::shape::rounded_polygon(corners.small(), corner_radius, smoothness_rad).or_raise()?;
        Self(unit).scaled(mean_radius_m)
    }

    /// The shape closest to the convex hull of a polygon or of boundary points.
    ///
    /// Corners are rounded as much as the number of harmonics asks for, so that the result is convex; `from_outline` chooses that number, and
    /// says what is lost.
    ///
    /// Parameters
    /// ----------
    /// points_m : array_like of float, shape (n, 2)
    ///     Corners or boundary points, metres, in any order.
    /// order : int, default 32
    ///     Number of harmonics, up to 512.
    /// center_of_mass_m : tuple of float, optional
    ///     Centre of mass in the frame of the points, metres. Default: the centroid of the hull's area.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The shape about its centre of mass.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     With fewer than three points, points on a line, or coordinates that are not finite.
    #[staticmethod]
    #[pyo3(signature = (points_m, order=Whole(32), center_of_mass_m=None), text_signature = "(points_m, order=32, center_of_mass_m=None)")]
    fn from_polygon(points_m: Table, order: Whole, center_of_mass_m: Option<(f64, f64)>) -> PyResult<Self> {
        let point = |x_m, y_m| BoundaryPoint { x_m, y_m };
        let points: Vec<BoundaryPoint> =
            arrays::rows("points_m", &points_m)?.into_iter().map(|[x, y]| point(x, y)).collect();
        let center = center_of_mass_m.map(|(x, y)| point(x, y));
        SupportFunction::from_boundary_points(&points, harmonics(order)?, center).or_raise().map(Self)
    }

    /// The shape closest, in least squares, to samples of a support function. It need not be convex.
    ///
    /// Parameters
    /// ----------
    /// theta_rad : array_like of float, shape (n,)
    ///     Normal angles, radians.
    /// r_m : array_like of float, shape (n,)
    ///     Support function there, metres.
    /// order : int
    ///     Number of harmonics, up to 512; it takes 2 order + 1 samples.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The fit.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     With too few samples, values that are not finite, or angles that leave too wide a gap.
    /// InputError
    ///     If the columns differ in length.
    #[staticmethod]
    fn from_samples(theta_rad: Column, r_m: Column, order: Whole) -> PyResult<Self> {
        let (theta, r) = (arrays::values(&theta_rad), arrays::values(&r_m));
        arrays::same_length(&[("theta_rad", theta.len()), ("r_m", r.len())])?;
        let samples: Vec<(f64, f64)> = theta.into_iter().zip(r).collect();
        SupportFunction::from_samples(&samples, harmonics(order)?).or_raise().map(Self)
    }

    /// float: mean radius a_0, metres.
    #[getter]
    fn mean_radius_m(&self) -> f64 {
        self.0.mean_radius_m()
    }

    /// numpy.ndarray: the pairs (a_k, b_k), shape (K, 2), metres.
    #[getter]
    fn harmonics_m(&self, py: Python<'_>) -> Py<PyArray2<f64>> {
        arrays::table(py, self.0.harmonics_m())
    }

    /// float: perimeter, metres.
    #[getter]
    fn perimeter_m(&self) -> f64 {
        self.0.perimeter_m()
    }

    /// float: enclosed area, square metres.
    #[getter]
    fn area_m2(&self) -> f64 {
        self.0.area_m2()
    }

    /// tuple of float: centroid of the area in the object frame, metres; (0, 0) for an object of even mass.
    #[getter]
    fn centroid_m(&self) -> (f64, f64) {
        let centroid = self.0.centroid();
        (centroid.x_m, centroid.y_m)
    }

    /// float: smallest radius of curvature, metres; negative where the outline is not convex.
    #[getter]
    fn min_curvature_radius_m(&self) -> f64 {
        self.0.min_curvature_radius_m()
    }

    /// bool: whether the radius of curvature is nowhere negative.
    #[getter]
    fn is_convex(&self) -> bool {
        self.0.is_convex()
    }

    /// Support function r: distance from the centre of mass to the tangent.
    ///
    /// Parameters
    /// ----------
    /// theta_rad : float or array_like of float
    ///     Normal angle in the object frame, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray
    ///     r in metres, in the shape of the input.
    fn r<'py>(&self, py: Python<'py>, theta_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &theta_rad, |theta| self.0.at(theta).r)
    }

    /// Signed distance d = -r' along the tangent from its foot to the contact point.
    ///
    /// Parameters
    /// ----------
    /// theta_rad : float or array_like of float
    ///     Normal angle in the object frame, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray
    ///     d in metres, in the shape of the input.
    fn d<'py>(&self, py: Python<'py>, theta_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &theta_rad, |theta| self.0.at(theta).d)
    }

    /// Radius of curvature v = r + r''.
    ///
    /// Parameters
    /// ----------
    /// theta_rad : float or array_like of float
    ///     Normal angle in the object frame, radians.
    ///
    /// Returns
    /// -------
    /// float or numpy.ndarray
    ///     v in metres, in the shape of the input.
    fn v<'py>(&self, py: Python<'py>, theta_rad: Numbers<'py>) -> PyResult<Bound<'py, PyAny>> {
        arrays::mapped(py, &theta_rad, |theta| self.0.at(theta).v)
    }

    /// Boundary points in the object frame.
    ///
    /// Parameters
    /// ----------
    /// theta_rad : array_like of float, shape (n,), optional
    ///     Normal angles, radians. Default: 720 of them, evenly spread over a turn.
    ///
    /// Returns
    /// -------
    /// numpy.ndarray
    ///     x and y of each point, shape (n, 2), metres.
    #[pyo3(signature = (theta_rad=None))]
    fn boundary(&self, py: Python<'_>, theta_rad: Option<Column>) -> Py<PyArray2<f64>> {
        let theta = theta_rad.map_or_else(
            || (0..720).map(|step| TAU * f64::from(step) / 720.0).collect(),
            |column| arrays::values(&column),
        );
        let points: Vec<[f64; 2]> = theta
            .into_iter()
            .map(|theta| {
                let point = self.0.boundary_point(theta);
                [point.x_m, point.y_m]
            })
            .collect();
        arrays::table(py, &points)
    }

    /// Generalised contact support functions (eq. 4 to 7 of Moll and Erdmann 2001).
    ///
    /// Parameters
    /// ----------
    /// theta1_rad : float
    ///     Normal angle at the first contact, radians.
    /// phi2_rad : float
    ///     Opening of the palms, radians.
    ///
    /// Returns
    /// -------
    /// tuple of float
    ///     r1, d1, r2 and d2: the vector between the contacts along the normal and the tangent at each, metres.
    fn generalized_support_m(&self, theta1_rad: f64, phi2_rad: f64) -> (f64, f64, f64, f64) {
        four(GeneralizedContactSupport::of_shape(&self.0, theta1_rad, phi2_rad))
    }

    /// The same object turned in its frame.
    ///
    /// Parameters
    /// ----------
    /// angle_rad : float
    ///     Angle, counter-clockwise, radians.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     With r(theta - angle_rad) in place of r(theta).
    fn rotated(&self, angle_rad: f64) -> PyResult<Self> {
        finite("angle_rad", &[angle_rad])?;
        Ok(Self(self.0.rotated(angle_rad)))
    }

    /// The same outline with its centre of mass elsewhere: the object moved against its frame.
    ///
    /// Parameters
    /// ----------
    /// x_m, y_m : float
    ///     By how much the outline moves, metres.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     With x_m cos(theta) + y_m sin(theta) added.
    fn translated(&self, x_m: f64, y_m: f64) -> PyResult<Self> {
        finite("x_m and y_m", &[x_m, y_m])?;
        Ok(Self(self.0.translated(x_m, y_m)))
    }

    /// The same form in another size.
    ///
    /// Parameters
    /// ----------
    /// mean_radius_m : float
    ///     Mean radius wanted, metres.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     The shape in that size.
    ///
    /// Raises
    /// ------
    /// ShapeError
    ///     If the mean radius is not positive and finite.
    fn scaled(&self, mean_radius_m: f64) -> PyResult<Self> {
        if !(mean_radius_m > 0.0 && mean_radius_m.is_finite()) {
            return Err(ShapeError::OutOfRange { what: "the mean radius" }).or_raise();
        }
        let factor = mean_radius_m / self.0.mean_radius_m();
        // The mean radius is to the last digit the one asked for.
        Ok(Self(SupportFunction::new(mean_radius_m, self.0.scaled(factor).harmonics_m().to_vec())))
    }

    /// The shape with its harmonics damped just enough to make it convex.
    ///
    /// Returns
    /// -------
    /// SupportFunction
    ///     A convex shape; the same if it was convex before.
    fn damped_to_convex(&self) -> Self {
        Self(self.0.damped_to_convex())
    }

    /// Draw the outline with matplotlib, in millimetres.
    ///
    /// Parameters
    /// ----------
    /// ax : matplotlib.axes.Axes, optional
    ///     Where to draw; by default in a new figure.
    /// **style
    ///     Passed on to `Axes.plot` for the outline.
    ///
    /// Returns
    /// -------
    /// matplotlib.axes.Axes
    ///     The axes drawn in.
    #[pyo3(signature = (ax=None, **style))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        ax: Option<Bound<'py, PyAny>>,
        style: Option<&Bound<'py, pyo3::types::PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("palpate._plot")?.getattr("plot_shape")?.call((slf, ax), style)
    }

    fn __repr__(&self) -> String {
        let centroid = self.0.centroid();
        format!(
            "<SupportFunction: mean radius {:.2} mm, {} harmonics, centre of mass {:.2} mm from the centroid>",
            1e3 * self.0.mean_radius_m(),
            self.0.harmonics_m().len(),
            1e3 * centroid.x_m.hypot(centroid.y_m)
        )
    }

    fn _repr_svg_(&self) -> String {
        svg::outline(&self.0)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> Pickled<'py> {
        let arguments = (self.0.mean_radius_m(), self.harmonics_m(py));
        pickled::by_class::<Self>(py, arguments)
    }
}

/// A number of harmonics that a fit can be made with.
fn harmonics(order: Whole) -> PyResult<usize> {
    let order = order.count();
    if order <= MOST_HARMONICS {
        return Ok(order);
    }
    Err(errors::ShapeError::new_err(format!("the number of harmonics must be at most {MOST_HARMONICS}, not {order}")))
}

/// Numbers that must be finite.
pub fn finite(names: &str, numbers: &[f64]) -> PyResult<()> {
    if numbers.iter().all(|number| number.is_finite()) {
        return Ok(());
    }
    Err(errors::input(format!("{names} must be finite")))
}

/// A column of normal angles and one of support values.
pub fn support_columns(py: Python<'_>, support: &[(f64, f64)]) -> (Py<PyArray1<f64>>, Py<PyArray1<f64>>) {
    let theta = support.iter().map(|(theta, _)| *theta).collect();
    let r = support.iter().map(|(_, r)| *r).collect();
    (arrays::column(py, theta), arrays::column(py, r))
}
