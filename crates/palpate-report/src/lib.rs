//! The report page: one HTML file that shows what was felt, what was made of it, and how far to trust it.
//!
//! ```
//! use palpate::{Log, Reconstruction, shape::SupportFunction};
//! # use palpate::reconstruct::{Doubt, Verdict};
//! use palpate_report::{ReportInput, page};
//!
//! let log = Log::default();
//! # let reconstruction = Reconstruction {
//! #     shape: SupportFunction::new(0.03, vec![]), outline: vec![], motion: vec![],
//! #     findings: None, verdict: Verdict::new(vec![Doubt::LittleFelt { coverage: 0.0 }]), chi2_per_dof: f64::NAN, jumps: vec![],
//! #     coverage: 0.0, alternatives: 1, others: vec![], sensor_sd_m: f64::NAN, balance_sd_m: f64::NAN,
//! #     symmetry: Default::default(), calibration: None, friction: None, inertia: None };
//! let html = page(&ReportInput {
//!     title: "An empty palm",
//!     log: &log,
//!     reconstruction: &reconstruction,
//!     truth: None,
//!     seconds: 0.1,
//!     command: None,
//!     version: env!("CARGO_PKG_VERSION"),
//! });
//! assert!(html.starts_with("<!doctype html>"));
//! ```
//!
//! The page needs no network and no other file: styles, script and data are inside, and its content security policy
//! forbids everything else. Lengths in it are millimetres and angles degrees, because people read it; the result files
//! hold SI units. A log of more than [`MAX_SAMPLES_SHOWN`] samples is thinned for the plots (ends of pieces and the
//! worst residuals stay); the figures and the histograms still come from all samples. Where several arrangements fit
//! equally well, the page has a choice of them and shows one at a time.
//!
//! [`animation()`] makes an animated GIF of the motion (feature `png`).
//!
//! [`paper`] reproduces the figures of Moll & Erdmann (2001).
//!
//! Nothing in the report fails: a value that is not finite leaves a gap in its curve, and a result without samples gives a page
//! that says so.
#![forbid(unsafe_code)]

#[cfg(feature = "png")]
mod animation;
mod data;
mod drawing;
mod figures;
mod html;
mod input;
mod overlay;
pub mod paper;
mod rig;
mod still;
mod strokes;

#[cfg(feature = "png")]
pub use animation::{AnimationError, animation};
pub use data::MAX_SAMPLES_SHOWN;
pub use input::{ReportInput, TruthOverlay};
pub use strokes::{StrokesInput, StrokesTruthOverlay, strokes_page};

/// What runs in the page; the last of them starts it.
const SCRIPT: &str = concat!(
    include_str!("../assets/theme.js"),
    include_str!("../assets/gif.js"),
    include_str!("../assets/export.js"),
    include_str!("../assets/report.js")
);

/// The whole page as one HTML document.
pub fn page(input: &ReportInput) -> String {
    let json = data::json(input);
    html::fill(include_str!("../assets/template.html"), |name| match name {
        "title" => html::escape(input.title),
        "style" => include_str!("../assets/style.css").to_owned(),
        "script" => SCRIPT.to_owned(),
        "verdict" => figures::verdict(input.reconstruction),
        "headline" => figures::headline(input),
        "still" => still::still(input.reconstruction),
        "figures" => figures::key_figures(input),
        "chooser" => figures::chooser(input.reconstruction),
        "jumps" => figures::jumps(input),
        "rig" => rig::rig(input),
        "errors" => figures::truth_errors(input.truth.as_ref()),
        "thinned" => figures::thinned(input),
        "command" => figures::command(input.command),
        "version" => html::escape(input.version),
        "data" => json.clone(),
        _ => String::new(),
    })
}
