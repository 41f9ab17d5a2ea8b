//! What sources, streams and recordings need of a sample: the seam between what both rigs share and what each has of its own.

mod palms;
mod strokes;

use std::fmt;
use std::path::Path;

use palpate_io::ReadError;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::SourceError;
use crate::join::Joined;
use crate::line_protocol::LinePacket;
use crate::source::Source;
use crate::source::address::Address;

/// The two rigs of the paper.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RigKind {
    /// Two palms.
    #[default]
    Palms,
    /// A pivoting grasp: strokes over one pad.
    Pivot,
}

/// A sample of a rig, and how it is written and read: [`Sample`](palpate::Sample) of two palms, [`PivotSample`](palpate::pivot::PivotSample) of strokes.
pub trait RigSample: Copy + fmt::Debug + PartialEq + Send + 'static {
    /// What a source may say of its rig.
    type Rig: Copy + fmt::Debug + PartialEq + Send + 'static;
    /// In which ways a rig may write its samples; the default is that of a log.
    type Conventions: Copy + fmt::Debug + Default + PartialEq + Send + 'static;
    /// Reads the rows of a CSV log.
    #[doc(hidden)]
    type Rows: fmt::Debug + Clone + Send + 'static;
    /// A line of the serial protocol.
    #[doc(hidden)]
    type Packet: LinePacket<Sample = Self>;
    /// A message of a recording in MCAP.
    #[doc(hidden)]
    type Message: Serialize + DeserializeOwned + for<'a> From<&'a Self> + Into<Self>;

    /// Name of the JSON schema of such a message.
    #[doc(hidden)]
    const SCHEMA: &'static str;

    /// Time, seconds.
    fn time_s(&self) -> f64;

    /// The same at another time.
    fn at(self, time_s: f64) -> Self;

    /// Whether no rig of these conventions has such a sample.
    fn is_implausible(&self, conventions: &Self::Conventions) -> bool;

    /// The conventions of a rig.
    fn conventions(rig: &Self::Rig) -> Self::Conventions;

    /// Takes in a line above the header of a CSV log; `is_stated`: the rig is known, and what the line says of it does not count.
    #[doc(hidden)]
    fn take_comment(name: &str, line: &str, is_stated: bool, rig: &mut Option<Self::Rig>) -> Result<(), SourceError>;

    /// A reader of the rows below a header.
    #[doc(hidden)]
    fn rows(name: &str, header: &str, line: usize, conventions: Self::Conventions) -> Result<Self::Rows, ReadError>;

    /// The sample in a row; `None` for a comment or a blank line.
    #[doc(hidden)]
    fn row(rows: &Self::Rows, text: &str, line: usize) -> Result<Option<Self>, ReadError>;

    /// What a CSV log begins with.
    #[doc(hidden)]
    fn csv_header(metadata: &[(String, String)]) -> String;

    /// Appends the row of the sample.
    #[doc(hidden)]
    fn push_csv_row(&self, text: &mut String);

    /// The JSON schema of a message.
    #[doc(hidden)]
    fn schema() -> String;

    /// The sample of readings that came separately.
    #[doc(hidden)]
    fn of_joined(joined: &Joined) -> Self;

    /// Between two readings of where the rig is, at this share of the time.
    #[doc(hidden)]
    fn between(before: f64, after: f64, share: f64) -> f64;

    /// Opens a source that only one of the rigs has: an input device.
    #[doc(hidden)]
    fn open_devices(address: &Address) -> Result<Box<dyn Source<Self>>, SourceError>;

    /// What a simulated rig does by this plan: its samples, its speed, and what is known of it.
    #[doc(hidden)]
    fn simulated(path: &Path, plan: &str) -> Result<(Vec<Self>, f64, Self::Rig), SourceError>;
}

/// An object of JSON schema: numbers, and what may be null.
fn json_schema(title: &str, numbers: &[&str], or_null: &[&str]) -> String {
    let number = |name: &&str| format!(r#""{name}":{{"type":"number"}}"#);
    let maybe = |name: &&str| format!(r#""{name}":{{"type":["number","null"]}}"#);
    let properties: Vec<String> = numbers.iter().map(number).chain(or_null.iter().map(maybe)).collect();
    format!(r#"{{"title":"{title}","type":"object","properties":{{{}}}}}"#, properties.join(","))
}
