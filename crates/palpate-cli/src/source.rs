//! Shapes, motions and touchpads as they are named on the command line: by a name that palpate knows, or by a file.

use std::f64::consts::TAU;
use std::fmt;
use std::path::{Path, PathBuf};

use palpate::shape::{NamedShape, OutlineFit, SupportFunction};
use palpate_io::Outline;

use crate::terminal::{Failure, Terminal};

/// Corners cut or sides that bulge by less than this are not told, metres: no log shows them.
const WORTH_TELLING_M: f64 = 1e-6;

/// An object.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapeSource {
    /// One with a name.
    Named(NamedShape),
    /// An outline, a support function or a drawing.
    File(PathBuf),
}

/// A motion of the palms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MotionSource {
    /// Planned for the object.
    Turn,
    /// That of the paper; independent of the object.
    Zigzag,
    /// A random smooth motion; independent of the object.
    Random,
    /// The palms of a log.
    File(PathBuf),
}

/// What the touch sensors are like.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PadSource {
    /// Unlimited length, no rounding.
    Ideal,
    /// The pad of the paper.
    Interlink,
    /// A touchpad file.
    File(PathBuf),
}

/// A shape that was made, and what there is to say about it.
pub struct Made {
    /// The shape, and how far it is from its outline.
    pub fit: OutlineFit,
    /// Whether its origin is the centroid of the object, dents included.
    pub about_centroid: bool,
    /// A sentence each.
    pub notes: Vec<String>,
}

/// Takes the name of a shape, or of a file with one.
pub fn shape(text: &str) -> Result<ShapeSource, String> {
    match text.parse::<NamedShape>() {
        Ok(named) => Ok(ShapeSource::Named(named)),
        Err(_) if names_file(text) => Ok(ShapeSource::File(text.into())),
        Err(error) => Err(format!("{error}, or a file .csv or .svg")),
    }
}

/// Takes the name of a motion, or of a file with one.
pub fn motion(text: &str) -> Result<MotionSource, String> {
    match text {
        "turn" => Ok(MotionSource::Turn),
        "zigzag" => Ok(MotionSource::Zigzag),
        "random" => Ok(MotionSource::Random),
        file if names_file(file) => Ok(MotionSource::File(file.into())),
        _ => Err("turn, zigzag, random or a file .csv is needed".to_owned()),
    }
}

/// Takes the name of a touchpad, or of a file with one.
pub fn pad(text: &str) -> Result<PadSource, String> {
    match text {
        "ideal" => Ok(PadSource::Ideal),
        "interlink" => Ok(PadSource::Interlink),
        file if names_file(file) => Ok(PadSource::File(file.into())),
        _ => Err("ideal, interlink or a file .toml is needed".to_owned()),
    }
}

/// Endings of files that are read.
const ENDINGS: [&str; 5] = ["csv", "gz", "svg", "toml", "txt"];

/// Whether a text is the name of a file: it ends like one, or there is one.
fn names_file(text: &str) -> bool {
    let path = Path::new(text);
    let ends_so = |end: &std::ffi::OsStr| ENDINGS.iter().any(|ending| end.eq_ignore_ascii_case(ending));
    path.extension().is_some_and(ends_so) || path.is_file()
}

impl ShapeSource {
    /// The shape, in this mean radius where one is given.
    pub fn fitted(&self, radius_m: Option<f64>) -> Result<Made, Failure> {
        match self {
            Self::Named(name) => {
                let fit = name.fitted(radius_m)?;
                let notes = told(&fit).map(|told| format!("{name}: {told}")).into_iter().collect();
                Ok(Made { fit, about_centroid: false, notes })
            }
            Self::File(path) => {
                if radius_m.is_some() {
                    let message = "an outline has its own size; leave --radius-mm out";
                    return Err(Failure::Input(format!("{}: {message}", path.display())));
                }
                let file = palpate_io::read_outline(path)?;
                let fit = file.fit().map_err(|error| Failure::Input(format!("{}: {error}", path.display())))?;
                let all = file.notes.iter().cloned().chain(told(&fit)).chain(dent_told(&fit));
                let notes = all.map(|note| format!("{}: {note}", path.display())).collect();
                Ok(Made { fit, about_centroid: matches!(file.outline, Outline::Points(_)), notes })
            }
        }
    }
}

/// Where the centre of mass is, millimetres in the frame of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Center {
    /// From the centroid of the outline.
    FromCentroid([f64; 2]),
    /// From where the shape has it.
    Moved([f64; 2]),
}

impl ShapeSource {
    /// The object about its centre of mass, after notes on how it was made.
    pub fn about_center(
        &self,
        radius_mm: Option<f64>,
        center: Center,
        terminal: &Terminal,
    ) -> Result<SupportFunction, Failure> {
        let made = self.fitted(radius_mm.map(|radius| 1e-3 * radius))?;
        made.notes.iter().for_each(|note| terminal.note(note));
        let shape = made.fit.shape;
        let ([x_mm, y_mm], moved, option) = match center {
            Center::FromCentroid(com_mm) => {
                let centroid =
                    if made.about_centroid { [0.0; 2] } else { [shape.centroid().x_m, shape.centroid().y_m] };
                (com_mm, shape.translated(-centroid[0], -centroid[1]), "--com-mm")
            }
            Center::Moved(offset_mm) => (offset_mm, shape, "--com-offset-mm"),
        };
        let shape = moved.translated(-1e-3 * x_mm, -1e-3 * y_mm);
        if holds_its_origin(&shape) {
            Ok(shape)
        } else if [x_mm, y_mm] == [0.0; 2] {
            let message = "the centre of mass lies outside of the object; give another one by --com-mm";
            Err(Failure::Input(format!("{self}: {message}")))
        } else {
            Err(Failure::Input(format!("{option} {x_mm},{y_mm} puts the centre of mass outside the object")))
        }
    }
}

/// Whether the origin, the centre of mass, lies inside the shape.
fn holds_its_origin(shape: &SupportFunction) -> bool {
    (0..720).all(|step| shape.at(TAU * f64::from(step) / 720.0).r > 0.0)
}

impl fmt::Display for ShapeSource {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => name.fmt(formatter),
            Self::File(path) => path.display().fmt(formatter),
        }
    }
}

/// How far a shape is from its outline, where that can be felt.
fn told(fit: &OutlineFit) -> Option<String> {
    (fit.residual_m() > WORTH_TELLING_M).then(|| {
        format!(
            "the shape has {} harmonics; corners of the outline are cut by up to {:.3} mm, and its sides bulge by up to {:.3} mm",
            fit.shape.harmonics_m().len(),
            1e3 * fit.cut_m,
            1e3 * fit.bulge_m
        )
    })
}

/// What became of dents.
fn dent_told(fit: &OutlineFit) -> Option<String> {
    fit.is_dented().then(|| {
        format!(
            "the outline has a dent {:.2} mm deep, which palms do not feel: its convex hull takes its place",
            1e3 * fit.dent_m
        )
    })
}
