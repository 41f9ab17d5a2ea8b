//! What a sensor's rig is known by on the command line: a file, its own word, or that it is exact.

use std::path::Path;

use palpate::Sample;
use palpate::pivot::{PivotRig, PivotSample};
use palpate_io::{RigFile, StrokesComments};
use palpate_live::{Address, RigSample};

use crate::terminal::Failure;

/// A rig whose samples come live.
pub trait LiveRig: RigSample {
    /// The rig in a file.
    fn read(path: &Path) -> Result<Self::Rig, Failure>;

    /// One whose readings are taken as they are.
    fn exact() -> Self::Rig;

    /// What is known where one rig was stated and the source says another: the first counts.
    fn known(stated: Option<Self::Rig>, said: Option<Self::Rig>) -> Option<Self::Rig>;

    /// What a recording notes of it.
    fn comments(rig: &Self::Rig) -> Vec<(String, String)>;
}

impl LiveRig for Sample {
    fn read(path: &Path) -> Result<RigFile, Failure> {
        Ok(palpate_io::read_rig(path)?)
    }

    fn exact() -> RigFile {
        RigFile::exact()
    }

    fn known(stated: Option<RigFile>, said: Option<RigFile>) -> Option<RigFile> {
        stated.or(said)
    }

    fn comments(rig: &RigFile) -> Vec<(String, String)> {
        vec![("rig".to_owned(), palpate_io::rig_comment(rig))]
    }
}

impl LiveRig for PivotSample {
    fn read(path: &Path) -> Result<StrokesComments, Failure> {
        Ok(StrokesComments { rig: Some(palpate_io::read_pivot_rig(path)?), swing_period_s: None })
    }

    fn exact() -> StrokesComments {
        StrokesComments { rig: Some(PivotRig::default()), swing_period_s: None }
    }

    fn known(stated: Option<StrokesComments>, said: Option<StrokesComments>) -> Option<StrokesComments> {
        let rig = stated.and_then(|stated| stated.rig).or(said.and_then(|said| said.rig));
        // The period of swinging is none of the rig.
        let swing_period_s = said.and_then(|said| said.swing_period_s);
        Some(StrokesComments { rig, swing_period_s })
    }

    fn comments(rig: &StrokesComments) -> Vec<(String, String)> {
        let period = rig.swing_period_s.map(|period_s| ("swing_period_s".to_owned(), period_s.to_string()));
        let rig = rig.rig.as_ref().map(|rig| ("rig".to_owned(), palpate_io::pivot_rig_comment(rig)));
        period.into_iter().chain(rig).collect()
    }
}

/// What stands in the head of a recording.
pub fn metadata<S: LiveRig>(source: &Address, rig: Option<&S::Rig>) -> Vec<(String, String)> {
    let mut metadata = vec![
        ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ("source".to_owned(), source.to_string().replace(['\n', '\r', '\0'], " ")),
    ];
    metadata.extend(rig.into_iter().flat_map(S::comments));
    metadata
}
