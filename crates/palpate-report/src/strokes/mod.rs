//! The report page of a pivoting grasp: an arm, a pad and its strokes, after figure 9 of Moll & Erdmann (2001). As that of palms it is one
//! file that needs no other; its figures are drawn beforehand, and the script only moves the object.

mod chart;
mod figures;
mod input;
mod motion;
mod words;

pub use input::{StrokesInput, StrokesTruthOverlay};

use crate::html;

/// What runs in the page.
const SCRIPT: &str = concat!(
    include_str!("../../assets/theme.js"),
    include_str!("../../assets/gif.js"),
    include_str!("../../assets/export.js"),
    include_str!("../../assets/strokes.js")
);

const STYLE: &str = concat!(include_str!("../../assets/style.css"), include_str!("../../assets/strokes.css"));

/// The whole page as one HTML document.
pub fn strokes_page(input: &StrokesInput) -> String {
    let samples = motion::Shown::of(input);
    html::fill(include_str!("../../assets/strokes.html"), |name| match name {
        "title" => html::escape(input.title),
        "style" => STYLE.to_owned(),
        "script" => SCRIPT.to_owned(),
        "verdict" => words::verdict(input.reconstruction),
        "headline" => words::headline(input.reconstruction),
        "figures" => words::key_figures(input),
        "shape" => figures::shape(input),
        "stage" => motion::stage(input),
        "height" => figures::height(&samples),
        "contact" => figures::contact(&samples),
        "psi" => figures::psi(&samples),
        "support" => figures::support(input),
        "residuals" => figures::residuals(input, &samples),
        "rig" => words::rig(input),
        "errors" => words::truth_errors(input),
        "command" => crate::figures::command(input.command),
        "version" => html::escape(input.version),
        "data" => motion::json(input, &samples),
        _ => String::new(),
    })
}
