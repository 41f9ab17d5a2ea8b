//! Outlines from files: points, support functions, drawings.

use palpate::shape::BoundaryPoint;
use palpate_io::{Outline, OutlineFile, parse_outline};
use proptest::prelude::*;

const SOAP: &str = "x_mm,y_mm\n0,0\n60,0\n60,40\n0,40\n";

fn read(text: &str) -> OutlineFile {
    parse_outline("soap", text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(text: &str) -> String {
    parse_outline("soap", text.as_bytes()).map_or_else(|error| error.to_string(), |_| "accepted".to_owned())
}

fn points(file: &OutlineFile) -> &[BoundaryPoint] {
    match &file.outline {
        Outline::Points(points) => points,
        Outline::Support(_) => panic!("a support function"),
    }
}

/// Width, height (millimetres) and number of the points of a drawing with this in it.
fn drawn(attributes: &str, content: &str) -> (f64, f64, usize) {
    let file = read(&format!("<svg xmlns=\"http://www.w3.org/2000/svg\" {attributes}>{content}</svg>"));
    let points = points(&file);
    let extent = |of: fn(&BoundaryPoint) -> f64| {
        let all: Vec<f64> = points.iter().map(of).collect();
        all.iter().copied().fold(f64::NEG_INFINITY, f64::max) - all.iter().copied().fold(f64::INFINITY, f64::min)
    };
    let rounded = |length_m: f64| (1e6 * length_m).round() / 1e3;
    (rounded(extent(|point| point.x_m)), rounded(extent(|point| point.y_m)), points.len())
}

#[test]
fn points_are_read_in_any_unit() {
    let expected = read(SOAP);
    assert_eq!(points(&expected)[2], BoundaryPoint { x_m: 0.06, y_m: 0.04 });
    assert_eq!(read("# soap\nsep=;\nY (cm);X [µm]\n0;0\n0;60000,0\n4,0;60000\n4;0\n"), expected);
    let fit = expected.fit().expect("a shape");
    assert!((fit.shape.perimeter_m() - 0.2).abs() < 1e-6);
}

#[test]
fn a_support_function_is_about_its_centre_of_mass() {
    let rows: String = (0..36).map(|i| format!("{},{}\n", 10 * i, 30.0 + (0.1745 * f64::from(i)).cos())).collect();
    let file = read(&format!("theta_deg,r_mm\n{rows}"));
    let shape = file.fit().expect("a shape").shape;
    // A disc of 30 mm, its centre of mass 1 mm off: that is kept.
    assert!((shape.centroid().x_m - 1e-3).abs() < 1e-6);
    // A shape.csv of a result has points too.
    let rows: String = (0..36).map(|i| format!("{},30,7,{i}\n", 10 * i)).collect();
    assert!(matches!(read(&format!("theta_deg,r_mm,x_mm,y_mm\n{rows}")).outline, Outline::Support(_)));
}

#[test]
fn tables_that_are_no_outline_are_refused() {
    assert_eq!(
        refusal("x_mm,y_mm\n0,0\n60,0\n"),
        "soap: there are 2 points, and an outline needs at least 3, in order round the object"
    );
    assert_eq!(
        refusal(&SOAP.replace("y_mm", "h_mm")),
        "soap, line 1: there is no column for y; it must be named y_m, y_cm, y_mm or y_um (the header has: x_mm, h_mm)"
    );
    assert_eq!(
        refusal(&SOAP.replace("mm", "m")),
        "soap, line 1, column x_m: the outline is 60 m across, and must be from 0.001 m to 2 m; correct its unit, or name the column x_cm, x_mm or x_um if that is its unit"
    );
    assert_eq!(
        refusal(&SOAP.replace("60", "0.06").replace("40", "0.04")),
        "soap, line 1, column x_mm: the outline is 0.00006 m across, and must be from 0.001 m to 2 m; correct its unit, or name the column x_m or x_cm if that is its unit"
    );
    // On each side of the limits.
    for (scale, unit, accepted) in
        [("2000", "mm", true), ("2001", "mm", false), ("1", "mm", true), ("0.999", "mm", false)]
    {
        let message = refusal(&format!("x_{unit},y_{unit}\n0,0\n{scale},0\n0,{scale}\n"));
        assert_eq!(message == "accepted", accepted, "{message}");
    }
    assert!(refusal("x_mm,y_mm\n0,0\n60,wet\n60,40\n").contains("line 3, column y_mm: \"wet\" is not a number"));
    let many: String = (0..100_001).map(|i| format!("{},{}\n", i % 60, i % 40)).collect();
    assert_eq!(
        refusal(&format!("x_mm,y_mm\n{many}")),
        "soap: the outline has 100001 points, more than 100000; leave some out"
    );
}

#[test]
fn a_drawing_is_measured_in_millimetres_unless_it_says_otherwise() {
    let path = "<path d=\"M 10 10 h 60 v 40 h -60 z\"/>";
    assert_eq!(drawn("", path), (60.0, 40.0, 4));
    assert_eq!(drawn("viewBox=\"0 0 100 100\"", path), (60.0, 40.0, 4));
    assert_eq!(drawn("width=\"100mm\" viewBox=\"0 0 200 200\"", path), (30.0, 20.0, 4));
    assert_eq!(drawn("width=\"2in\" viewBox=\"0 0 100 100\"", path), (30.48, 20.32, 4));
    assert_eq!(drawn("width=\"100mm\" height=\"100mm\"", path), (15.875, 10.583, 4));
    assert_eq!(drawn("width=\"800px\" viewBox=\"0 0 100 100\"", path), (60.0, 40.0, 4));
}

#[test]
fn the_largest_outline_is_taken_and_named() {
    let text = "<svg xmlns=\"http://www.w3.org/2000/svg\">\n<defs><circle r=\"400\"/></defs>\n<circle cx=\"3\" r=\"5\"/>\n\
        <g transform=\"translate(5 5) scale(2)\"><path id=\"soap\" d=\"M0,0 l30,0 0,20 -30,0 z m5,5 h5 v5 h-5 z\"/></g></svg>";
    let file = read(text);
    assert_eq!(
        file.notes,
        [
            "the outline is the path \"soap\" in line 4, the largest of 3; user units are taken for millimetres: 60.0 mm across"
        ]
    );
    // Y points up.
    let lowest = points(&file).iter().map(|point| point.y_m).fold(f64::INFINITY, f64::min);
    assert!((lowest + 0.045).abs() < 1e-12);
}

#[test]
fn curves_and_basic_shapes_are_outlines() {
    let (width, height, count) = drawn("", "<circle cx=\"9\" cy=\"9\" r=\"20\"/>");
    assert!((width - 40.0).abs() < 0.002 && (height - 40.0).abs() < 0.002 && count > 50);
    let (width, height, _) = drawn("", "<ellipse rx=\"30\" ry=\"20\"/>");
    assert!((width - 60.0).abs() < 0.002 && (height - 40.0).abs() < 0.002);
    let (width, height, count) = drawn("", "<rect x=\"1\" y=\"2\" width=\"60\" height=\"40\" rx=\"8\"/>");
    assert!((width - 60.0).abs() < 0.002 && (height - 40.0).abs() < 0.002 && count > 20);
    assert_eq!(drawn("", "<polygon points=\"0,0 60,0 60,40 0,40\"/>"), (60.0, 40.0, 4));
    let (width, _, _) = drawn("", "<path d=\"M0,0 A30,20 0 0 1 60,0 A30,20 0 0 1 0,0\"/>");
    assert!((width - 60.0).abs() < 0.002);
}

#[test]
fn drawings_that_cannot_be_read_are_refused() {
    let export = "export the outline as one path in plain SVG";
    assert_eq!(
        refusal("<html></html>"),
        format!("soap: not an SVG drawing that can be read (the root is <html>); {export}")
    );
    assert!(
        refusal("<svg>\n<path <").starts_with("soap, line 2: not an SVG drawing that can be read ("),
        "{}",
        refusal("<svg>\n<path <")
    );
    let none = "soap: the drawing has no path, polygon, rect, circle or ellipse with an area; convert text and copies to paths";
    assert_eq!(refusal("<svg><text>soap</text><path d=\"M0,0 L10,10\"/></svg>"), none);
    assert_eq!(
        refusal("<svg><circle r=\"1e400\"/><path d=\"M0,0 L1e400,1 3,3z\"/></svg>"),
        format!("soap, line 1: not an SVG drawing that can be read (r=\"1e400\" is not in user units); {export}")
    );
    assert_eq!(
        refusal("<svg>\n<path d=\"M0,0 L10,10 wet\"/></svg>"),
        format!(
            "soap, line 2: not an SVG drawing that can be read (the path data of the path cannot be read); {export}"
        )
    );
    assert_eq!(
        refusal("<svg><rect width=\"6000\" height=\"40\"/></svg>"),
        "soap: the outline is 6 m across, and must be from 0.001 m to 2 m; correct its unit"
    );
    // What expands without end is not expanded.
    let laughs = "<!DOCTYPE svg [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;\">]><svg>&b;</svg>";
    assert!(refusal(laughs).starts_with("soap, line 1: not an SVG drawing"), "{}", refusal(laughs));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_drawings_never_panic(
        path in "[MLHVCSQTAZmlhvcsqtaz0-9 .,eE-]{0,60}",
        transform in "(translate|scale|matrix|rotate|skewX)\\([-0-9e., ]{0,20}\\)",
        view in "[-0-9e. ]{0,20}",
        width in "[0-9]{0,3}(mm|in|px|%|)",
    ) {
        let text = format!("<svg width=\"{width}\" viewBox=\"{view}\"><g transform=\"{transform}\"><path d=\"{path}\"/></g></svg>");
        match parse_outline("soap.svg", text.as_bytes()) {
            Ok(file) => drop(file.fit()),
            Err(error) => prop_assert!(!error.to_string().chars().any(char::is_control)),
        }
    }
}
