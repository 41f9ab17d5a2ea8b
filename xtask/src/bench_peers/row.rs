//! One line of the comparison.

use serde::Serialize;

use super::turns::Medians;

/// The peer of what palpate does alone.
pub const NOBODY: &str = "none";

/// palpate and one peer on one input.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Kind of work.
    pub job: String,
    /// Samples of the log, where there is one.
    pub n: Option<usize>,
    /// Harmonics, where they matter.
    pub k: Option<usize>,
    /// The other program.
    pub peer: String,
    /// Median time palpate takes, seconds.
    pub palpate_s: Option<f64>,
    /// Median time the peer takes, seconds.
    pub peer_s: Option<f64>,
    /// `peer_s / palpate_s`; none where the results do not agree.
    pub ratio: Option<f64>,
    /// How far the results agree, or why there is nothing to compare.
    pub agreement: String,
}

/// How far two results agree.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// Whether the peer solved the same problem as well: only then do times compare.
    pub holds: bool,
    /// The differences, in words.
    pub text: String,
}

impl Row {
    /// Both had a result.
    pub fn compared(
        job: &str,
        (n, k): (Option<usize>, Option<usize>),
        peer: &str,
        medians: Medians,
        agreement: Agreement,
    ) -> Self {
        Self {
            job: job.to_owned(),
            n,
            k,
            peer: peer.to_owned(),
            palpate_s: Some(medians.palpate_s),
            peer_s: Some(medians.peer_s),
            ratio: agreement.holds.then_some(medians.peer_s / medians.palpate_s),
            agreement: agreement.text,
        }
    }

    /// There is nothing to compare, for this reason.
    pub fn remark(job: &str, peer: &str, reason: impl Into<String>) -> Self {
        Self {
            job: job.to_owned(),
            n: None,
            k: None,
            peer: peer.to_owned(),
            palpate_s: None,
            peer_s: None,
            ratio: None,
            agreement: reason.into(),
        }
    }
}
