//! Outlines from drawings in SVG: the closed path, polygon or basic shape with the largest area.

use std::str::FromStr;

use kurbo::{Affine, BezPath, Circle, Ellipse, PathEl, Point, Rect, RoundedRect, Shape};
use palpate::shape::BoundaryPoint;
use roxmltree::{Document, Node};
use svgtypes::{Length, LengthUnit, PointsParser, SimplePathSegment, SimplifyingPathParser, Transform, ViewBox};

use crate::csv::number::six_digits;
use crate::csv::text;
use crate::log::plausible::{MAX_REACH_M, MIN_REACH_M};
use crate::outline::{MAX_POINTS, Outline, OutlineFile, size_m};
use crate::read_error::{ReadError, ReadProblem};

/// How far the points of a curve may lie from it, as a share of the size of its control points: less than any pad can tell.
const FLATNESS: f64 = 1e-5;
/// What holds drawings that are not shown by themselves.
const NOT_SHOWN: [&str; 7] = ["defs", "symbol", "clipPath", "mask", "marker", "pattern", "metadata"];

/// A closed outline of a drawing.
struct Candidate {
    /// What messages call it.
    name: String,
    points: Vec<Point>,
    area: f64,
}

/// The outline in a drawing.
pub(super) fn parse(name: &str, bytes: &[u8]) -> Result<OutlineFile, ReadError> {
    let refused = |problem| ReadError::in_file(name, problem);
    let text = std::str::from_utf8(bytes).map_err(|_| refused(ReadProblem::NotUtf8))?;
    let document = Document::parse(text).map_err(|error| {
        let line = error.pos().row as usize;
        ReadError::in_line(name, line, ReadProblem::Svg { message: text::quoted(&error.to_string()) })
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(refused(ReadProblem::Svg {
            message: format!("the root is <{}>", text::quoted(root.tag_name().name())),
        }));
    }
    let (m_per_unit, unit) = scale(root);
    let mut best: Option<Candidate> = None;
    let mut count = 0;
    for node in root.descendants().filter(|node| is_shown(*node)) {
        let line = document.text_pos_at(node.range().start).row as usize;
        let Some(path) =
            path_of(node).map_err(|message| ReadError::in_line(name, line, ReadProblem::Svg { message }))?
        else {
            continue;
        };
        let path = to_document(node) * path;
        for points in subpaths(&path).ok_or_else(|| {
            ReadError::in_line(name, line, ReadProblem::TooManyPoints { points: MAX_POINTS, limit: MAX_POINTS })
        })? {
            let area = area(&points);
            if points.len() < 3 || !(area > 0.0 && area.is_finite()) {
                continue;
            }
            count += 1;
            if best.as_ref().is_none_or(|best| area > best.area) {
                best = Some(Candidate { name: called(node, line), points, area });
            }
        }
    }
    let Some(Candidate { name: taken, points, .. }) = best else { return Err(refused(ReadProblem::NoOutline)) };
    // The Y axis of a drawing points down.
    let points: Vec<BoundaryPoint> =
        points.iter().map(|point| BoundaryPoint { x_m: m_per_unit * point.x, y_m: -m_per_unit * point.y }).collect();
    let across_m = size_m(&points);
    if !(MIN_REACH_M..=MAX_REACH_M).contains(&across_m) {
        let problem = ReadProblem::OutlineSize {
            across_m: six_digits(across_m),
            least_m: MIN_REACH_M,
            most_m: MAX_REACH_M,
            others: String::new(),
        };
        return Err(refused(problem));
    }
    let of = if count == 1 { String::new() } else { format!(", the largest of {count}") };
    let notes = vec![format!("the outline is {taken}{of}; {unit}: {:.1} mm across", 1e3 * across_m)];
    Ok(OutlineFile { outline: Outline::Points(points), notes })
}

/// Metres per user unit, and how the document says so.
fn scale(root: Node) -> (f64, String) {
    let stated = root.attribute("width").and_then(|width| Length::from_str(width).ok());
    let unit_m = |unit| {
        Some(match unit {
            LengthUnit::Mm => 1e-3,
            LengthUnit::Cm => 1e-2,
            LengthUnit::In => 0.0254,
            LengthUnit::Pt => 0.0254 / 72.0,
            LengthUnit::Pc => 0.0254 / 6.0,
            _ => return None,
        })
    };
    let stated_m = stated.and_then(|width| Some(width.number * unit_m(width.unit)?)).filter(|width| *width > 0.0);
    let Some(width_m) = stated_m else {
        return (1e-3, "user units are taken for millimetres".to_owned());
    };
    let view = root.attribute("viewBox").and_then(|view| ViewBox::from_str(view).ok());
    // Without a view box, a user unit is a pixel of 1/96 inch.
    let m_per_unit = view.map_or(0.0254 / 96.0, |view| width_m / view.w);
    (m_per_unit, format!("a user unit is {:.4} mm by the width of the document", 1e3 * m_per_unit))
}

/// Whether a node is drawn by itself.
fn is_shown(node: Node) -> bool {
    node.is_element() && !node.ancestors().any(|ancestor| NOT_SHOWN.contains(&ancestor.tag_name().name()))
}

/// What a note calls an outline.
fn called(node: Node, line: usize) -> String {
    let kind = node.tag_name().name();
    match node.attribute("id") {
        Some(id) => format!("the {kind} \"{}\" in line {line}", text::quoted(id)),
        None => format!("the {kind} in line {line}"),
    }
}

/// What a node draws, in its own frame; `None` where it has no outline.
fn path_of(node: Node) -> Result<Option<BezPath>, String> {
    let number = |name: &str| match node.attribute(name) {
        None => Ok(0.0),
        Some(value) => match Length::from_str(value) {
            Ok(Length { number, unit: LengthUnit::None | LengthUnit::Px }) if number.is_finite() => Ok(number),
            _ => Err(format!("{name}=\"{}\" is not in user units", text::quoted(value))),
        },
    };
    let wrong = |what: &str| format!("the {what} of the {} cannot be read", node.tag_name().name());
    Ok(Some(match node.tag_name().name() {
        "path" => {
            let Some(data) = node.attribute("d") else { return Ok(None) };
            let mut path = BezPath::new();
            for segment in SimplifyingPathParser::from(data) {
                match segment.map_err(|_| wrong("path data"))? {
                    SimplePathSegment::MoveTo { x, y } => path.move_to((x, y)),
                    SimplePathSegment::LineTo { x, y } => path.line_to((x, y)),
                    SimplePathSegment::CurveTo { x1, y1, x2, y2, x, y } => path.curve_to((x1, y1), (x2, y2), (x, y)),
                    SimplePathSegment::Quadratic { x1, y1, x, y } => path.quad_to((x1, y1), (x, y)),
                    SimplePathSegment::ClosePath => path.close_path(),
                }
            }
            path
        }
        "polygon" | "polyline" => {
            let Some(data) = node.attribute("points") else { return Ok(None) };
            let mut path = BezPath::new();
            for (x, y) in PointsParser::from(data) {
                if path.elements().is_empty() { path.move_to((x, y)) } else { path.line_to((x, y)) }
            }
            path
        }
        "rect" => {
            let rect = Rect::from_origin_size((number("x")?, number("y")?), (number("width")?, number("height")?));
            let radius = number("rx")?.max(number("ry")?);
            RoundedRect::from_rect(rect, radius)
                .to_path(FLATNESS * rect.width().max(rect.height()).max(f64::MIN_POSITIVE))
        }
        "circle" => {
            let radius = number("r")?;
            Circle::new((number("cx")?, number("cy")?), radius).to_path(FLATNESS * radius.max(f64::MIN_POSITIVE))
        }
        "ellipse" => {
            let radii = (number("rx")?, number("ry")?);
            Ellipse::new((number("cx")?, number("cy")?), radii, 0.0)
                .to_path(FLATNESS * radii.0.max(radii.1).max(f64::MIN_POSITIVE))
        }
        _ => return Ok(None),
    }))
}

/// From the frame of a node to that of the document.
fn to_document(node: Node) -> Affine {
    let own = |node: Node| {
        let transform = node.attribute("transform").and_then(|text| Transform::from_str(text).ok());
        transform.map_or(Affine::IDENTITY, |Transform { a, b, c, d, e, f }| Affine::new([a, b, c, d, e, f]))
    };
    node.ancestors().map(own).fold(Affine::IDENTITY, |inner, outer| outer * inner)
}

/// The points of each of its closed curves, or of those that are closed by a straight line; `None` where there are too many.
fn subpaths(path: &BezPath) -> Option<Vec<Vec<Point>>> {
    let control = path.elements().iter().flat_map(|element| match *element {
        PathEl::MoveTo(p) | PathEl::LineTo(p) => [Some(p), None, None],
        PathEl::QuadTo(p, q) => [Some(p), Some(q), None],
        PathEl::CurveTo(p, q, r) => [Some(p), Some(q), Some(r)],
        PathEl::ClosePath => [None; 3],
    });
    let control: Vec<Point> = control.flatten().collect();
    if !control.iter().all(|point| point.is_finite()) || control.len() > MAX_POINTS {
        return if control.len() > MAX_POINTS { None } else { Some(Vec::new()) };
    }
    let bounds = control.iter().fold(None, |bounds: Option<Rect>, point| {
        Some(bounds.map_or(Rect::from_points(*point, *point), |bounds| bounds.union_pt(*point)))
    });
    let Some(bounds) = bounds.filter(|bounds| bounds.width().max(bounds.height()) > 0.0) else {
        return Some(Vec::new());
    };
    let mut all: Vec<Vec<Point>> = Vec::new();
    let mut count = 0;
    kurbo::flatten(path, FLATNESS * bounds.width().max(bounds.height()), |element| {
        count += 1;
        match element {
            PathEl::MoveTo(point) => all.push(vec![point]),
            PathEl::LineTo(point) if count <= MAX_POINTS => {
                all.last_mut().into_iter().for_each(|last| last.push(point));
            }
            _ => {}
        }
    });
    (count <= MAX_POINTS).then_some(all)
}

/// Twice the area within a polygon, in square user units, whichever way it is run.
fn area(points: &[Point]) -> f64 {
    let Some(origin) = points.first() else { return 0.0 };
    let cross = |pair: &[Point]| (pair[0] - *origin).cross(pair[1] - *origin);
    points.windows(2).map(cross).sum::<f64>().abs()
}
