//! Where samples come from: one small trait, and an adapter for each kind of source.

pub(crate) mod address;
#[cfg(target_os = "linux")]
pub(crate) mod evdev;
pub(crate) mod follow;
pub(crate) mod mcap;
pub(crate) mod serial;
pub(crate) mod simulated;
pub(crate) mod text;

use palpate::Sample;

use crate::error::SourceError;
use crate::losses::Losses;
use crate::rigs::RigSample;

/// A source of samples, of two palms or of the other rig. It is read by one thread, in a loop.
pub trait Source<S: RigSample = Sample>: Send {
    /// The next thing that comes. Returns [`Arrival::Nothing`] now and then where nothing does, if the source can be waited for in parts.
    ///
    /// # Errors
    /// The source is at its end and something is wrong with it. A source that may come back is no error.
    fn next(&mut self) -> Result<Arrival<S>, SourceError>;

    /// What was lost since the source was opened.
    fn losses(&self) -> Losses;

    /// What was wrong with the first line or message that was left out, in a sentence.
    fn first_fault(&self) -> Option<String> {
        None
    }

    /// What the source knows of its rig so far, if anything: a simulated one when it is opened, a log when its first sample is there.
    fn rig(&self) -> Option<S::Rig> {
        None
    }

    /// What happens to samples that come faster than they are taken.
    fn overflow(&self) -> Overflow;
}

/// What a source gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival<S = Sample> {
    /// A sample, as the rig has it: before the conventions of its rig file are applied.
    Sample(S),
    /// Nothing for now.
    Nothing,
    /// Nothing any more.
    End,
}

/// What a source does when samples are not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overflow {
    /// It waits: a file, a pipe.
    Waits,
    /// It cannot wait, so that the oldest samples are dropped: a sensor.
    DropsOldest,
}
