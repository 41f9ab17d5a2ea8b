//! Outlines of objects, from files: points of a CSV table, a support function, or a drawing in SVG.

mod svg;
mod table;

use std::path::Path;

use palpate::shape::{BoundaryPoint, OutlineFit, ShapeError, SupportFunction};

use crate::csv::bytes::read_bytes;
use crate::read_error::{ReadError, ReadProblem};

/// Most points of an outline: far more than a fit can tell apart.
pub(crate) const MAX_POINTS: usize = 100_000;

/// The outline of an object as a file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct OutlineFile {
    /// What is known of it.
    pub outline: Outline,
    /// What there is to say about the file, a sentence each: which path of a drawing was taken, and in what unit.
    pub notes: Vec<String>,
}

/// Points of an outline, or its support function.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// Points in order round the object, in a frame of their own.
    Points(Vec<BoundaryPoint>),
    /// Samples (θ in radians, r in metres) of the support function about the centre of mass.
    Support(Vec<(f64, f64)>),
}

impl OutlineFile {
    /// The shape closest to the outline, and how far it is off. Its origin is the centroid of an outline of points, and the centre of mass that
    /// a support function is about.
    ///
    /// # Errors
    /// The outline has no area; see [`SupportFunction::from_outline`] and [`SupportFunction::from_support`].
    pub fn fit(&self) -> Result<OutlineFit, ShapeError> {
        match &self.outline {
            Outline::Points(points) => SupportFunction::from_outline(points),
            Outline::Support(samples) => SupportFunction::from_support(samples),
        }
    }
}

/// Reads the outline of an object from a file: a drawing in SVG, or a CSV table with the columns x and y, points in order round the object, or with
/// theta and r, the support function about the centre of mass, as in the `shape.csv` of a result or a truth. Units are those of
/// [`read_log`](crate::read_log); in a drawing, user units are millimetres unless the document gives its size in other ones.
///
/// # Errors
/// The file cannot be read, has no outline, or one that is no size an object between palms can have.
pub fn read_outline(path: &Path) -> Result<OutlineFile, ReadError> {
    parse_outline(&path.to_string_lossy(), &read_bytes(path)?)
}

/// The same from memory; `name` stands for the file in messages.
///
/// # Errors
/// As [`read_outline`].
pub fn parse_outline(name: &str, bytes: &[u8]) -> Result<OutlineFile, ReadError> {
    let is_markup =
        bytes.trim_ascii_start().strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start().starts_with(b"<");
    let file = if is_markup { svg::parse(name, bytes)? } else { table::parse(name, bytes)? };
    if let Outline::Points(points) = &file.outline
        && points.len() > MAX_POINTS
    {
        return Err(ReadError::in_file(name, ReadProblem::TooManyPoints { points: points.len(), limit: MAX_POINTS }));
    }
    Ok(file)
}

/// Width or height of a set of points, whichever is larger, metres.
fn size_m(points: &[BoundaryPoint]) -> f64 {
    let extent = |of: fn(&BoundaryPoint) -> f64| {
        let (least, most) = points
            .iter()
            .map(of)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| (least.min(x), most.max(x)));
        most - least
    };
    extent(|point| point.x_m).max(extent(|point| point.y_m))
}
