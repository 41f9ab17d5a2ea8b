//! The serial line protocol: one line per sample, with a check.
//!
//! `T,phi1,phi2,s1,s2[,f1,f2]*CC` and a line feed: time in microseconds, angles in microradians, positions in micrometres, forces in
//! millinewtons, and the CRC-8 of all before the `*`.

pub(crate) mod clock;
pub(crate) mod decoder;
pub(crate) mod packet;
