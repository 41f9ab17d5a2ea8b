//! What the page of strokes is made from.

use palpate::Truth;
use palpate::pivot::{PivotLog, PivotReconstruction, PivotRig, PivotTruthError};

/// What the page is made from.
#[derive(Clone, Copy, Debug)]
pub struct StrokesInput<'a> {
    /// Heading of the page, such as the name of the log.
    pub title: &'a str,
    /// The log that was reconstructed.
    pub log: &'a PivotLog,
    /// What was stated of the rig.
    pub rig: &'a PivotRig,
    /// What came out.
    pub reconstruction: &'a PivotReconstruction,
    /// The truth, where it is known.
    pub truth: Option<StrokesTruthOverlay<'a>>,
    /// Wall-clock time the reconstruction took, seconds.
    pub seconds: f64,
    /// The command line that made the result, for the footer.
    pub command: Option<&'a str>,
    /// Version of the program, for the footer.
    pub version: &'a str,
}

/// What is true, and how far the result is from it.
#[derive(Clone, Copy, Debug)]
pub struct StrokesTruthOverlay<'a> {
    /// True shape about the pivot and motion.
    pub truth: &'a Truth,
    /// Errors of the result.
    pub errors: PivotTruthError,
}
