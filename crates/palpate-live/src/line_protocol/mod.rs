//! The serial line protocol: one line per sample, with a check.
//!
//! `T,phi1,phi2,s1,s2[,f1,f2]*CC` of two palms, `T,x,y,s*CC` of a pivoting grasp, and a line feed: time in microseconds, angles in microradians,
//! lengths in micrometres, forces in millinewtons, and the CRC-8 of all before the `*`.

pub(crate) mod clock;
pub(crate) mod decoder;
pub(crate) mod fields;
pub(crate) mod palms_packet;
pub(crate) mod strokes_packet;

use std::fmt;

use fields::PacketError;

/// What a line says, of either rig.
pub trait LinePacket: Copy + fmt::Debug + PartialEq + Send + 'static {
    /// What becomes of it.
    type Sample;

    /// Good lines in a row that confirm each other.
    const CONFIRMED: usize;

    /// Reads a line without its line feed.
    ///
    /// # Errors
    /// The check fails, or the fields are not as the protocol has them.
    fn parse(line: &[u8]) -> Result<Self, PacketError>;

    /// Time in microseconds; 0 follows 2³² − 1.
    fn time_us(&self) -> u32;

    /// The sample at a time that the caller has unwrapped.
    fn sample(&self, time_s: f64) -> Self::Sample;

    /// Whether a rig gets here from `before` within this time.
    fn can_follow(&self, before: &Self, step_s: f64) -> bool;
}
