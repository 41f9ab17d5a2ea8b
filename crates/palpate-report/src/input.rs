//! What the report page is made from.

use palpate::compare::TruthError;
use palpate::{Log, Reconstruction, Truth};

/// What the page is made from.
#[derive(Clone, Copy, Debug)]
pub struct ReportInput<'a> {
    /// Heading of the page, such as the name of the log.
    pub title: &'a str,
    /// The log that was reconstructed.
    pub log: &'a Log,
    /// What came out.
    pub reconstruction: &'a Reconstruction,
    /// The truth, where it is known.
    pub truth: Option<TruthOverlay<'a>>,
    /// Wall-clock time the reconstruction took, seconds.
    pub seconds: f64,
    /// The command line that made the result, for the footer.
    pub command: Option<&'a str>,
    /// Version of the program, for the footer.
    pub version: &'a str,
}

/// What is true, and how far the result is from it.
#[derive(Clone, Copy, Debug)]
pub struct TruthOverlay<'a> {
    /// True shape and motion.
    pub truth: &'a Truth,
    /// Errors of the result.
    pub errors: TruthError,
}

impl<'a> ReportInput<'a> {
    /// The result and whatever fits equally well.
    pub(crate) fn arrangements(&self) -> impl Iterator<Item = &'a Reconstruction> + use<'a> {
        std::iter::once(self.reconstruction).chain(&self.reconstruction.others)
    }
}
